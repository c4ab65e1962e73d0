#pragma once

// The control interface of a running simulator: a lock on its folder, so that there is only one,
// and a local socket in it that accepts one fault as text and answers "ok" or an error. Main thread
// only.

#include <filesystem>
#include <functional>
#include <string>
#include <tl/expected.hpp>

#include "drivers/file.h"

namespace lss::sim {

class Control {
 public:
  // Locks the folder, and creates it when needed. The error names its owner.
  static tl::expected<Control, std::string> open(const std::filesystem::path& folder);
  Control(Control&&) = default;
  ~Control();

  int fd() const { return socket_.get(); }  // readable: call serve
  // Answers one request; `handle` returns an empty string or the error.
  void serve(const std::function<std::string(const std::string& text)>& handle);

 private:
  Control(std::filesystem::path folder, File lock, File socket)
      : folder_(std::move(folder)), lock_(std::move(lock)), socket_(std::move(socket)) {}

  std::filesystem::path folder_;
  File lock_, socket_;
};

enum class Answer { ok, refused, nobody };

// From another process: sends the text to the simulator of the folder. `message` is the error.
Answer send_to_simulator(const std::filesystem::path& folder, const std::string& text,
                         std::string& message);

}  // namespace lss::sim
