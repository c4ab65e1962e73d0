#pragma once

// The way into a running simulator: a lock on its folder, so that there is one, and a local socket
// in it that takes one fault as text and answers "ok" or what is wrong. Main thread only.

#include <filesystem>
#include <functional>
#include <string>
#include <tl/expected.hpp>

#include "tools/lss-sim/file.h"

namespace lss::sim {

class Control {
 public:
  // Takes the folder, making it when needed. The error says who has it.
  static tl::expected<Control, std::string> open(const std::filesystem::path& folder);
  Control(Control&&) = default;
  ~Control();

  int fd() const { return socket_.get(); }  // readable: call serve
  // Answers one request; `handle` returns the empty string or what is wrong with it.
  void serve(const std::function<std::string(const std::string& text)>& handle);

 private:
  Control(std::filesystem::path folder, File lock, File socket)
      : folder_(std::move(folder)), lock_(std::move(lock)), socket_(std::move(socket)) {}

  std::filesystem::path folder_;
  File lock_, socket_;
};

enum class Answer { ok, refused, nobody };

// From another process: sends the text to the simulator of the folder. `message` says what went
// wrong.
Answer send_to_simulator(const std::filesystem::path& folder, const std::string& text,
                         std::string& message);

}  // namespace lss::sim
