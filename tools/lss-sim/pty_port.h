#pragma once

// A serial port that others can open: a pseudo-terminal with a link to it in a folder, DIR/NAME ->
// /dev/pts/N. Its other end stays alive whoever opens and closes it. Used by one thread at a time.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "tools/lss-sim/file.h"

namespace lss::sim {

class PtyPort {
 public:
  explicit PtyPort(std::filesystem::path link) : link_(std::move(link)) {}
  ~PtyPort() { close(); }
  PtyPort(const PtyPort&) = delete;
  PtyPort& operator=(const PtyPort&) = delete;

  // Makes a new pseudo-terminal and puts the link in place atomically. The error says what failed.
  tl::expected<void, std::string> open();
  // The terminal goes away (whoever has it open sees it hung up), and the link with it.
  void close();
  bool is_open() const { return static_cast<bool>(master_); }

  // What was written to the terminal; empty when nothing waits. Valid until the next call.
  std::span<const std::uint8_t> read();
  // What nobody reads is lost, as on a wire. Returns how many are not.
  std::size_t write(std::span<const std::uint8_t> bytes);

  int fd() const { return master_.get(); }
  const std::filesystem::path& link() const { return link_; }
  const std::string& terminal() const { return terminal_; }

 private:
  std::filesystem::path link_;
  std::string terminal_;
  File master_;
  File slave_;  // kept open: otherwise the master reports a hang-up while nobody else has it open
  std::uint8_t buffer_[512];
};

}  // namespace lss::sim
