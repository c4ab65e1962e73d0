#pragma once

// A serial port that others can open: a pseudo-terminal with a link to it in a folder, DIR/NAME ->
// /dev/pts/N. Its other end stays open when other programs open and close it. Used by one thread at
// a time.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "drivers/file.h"

namespace lss::sim {

class PtyPort {
 public:
  explicit PtyPort(std::filesystem::path link) : link_(std::move(link)) {}
  ~PtyPort() { close(); }
  PtyPort(const PtyPort&) = delete;
  PtyPort& operator=(const PtyPort&) = delete;

  // Makes a new pseudo-terminal and puts the link in place atomically. The error names the failure.
  tl::expected<void, std::string> open();
  // Removes the terminal (a program that has it open sees a hang-up) and the link.
  void close();
  bool is_open() const { return static_cast<bool>(master_); }

  // Bytes written to the terminal; empty when none wait. Valid until the next call.
  std::span<const std::uint8_t> read();
  // Unread bytes are lost, as on a wire. Returns the number of bytes written.
  std::size_t write(std::span<const std::uint8_t> bytes);

  int fd() const { return master_.get(); }
  const std::filesystem::path& link() const { return link_; }
  const std::string& terminal() const { return terminal_; }

 private:
  std::filesystem::path link_;
  std::string terminal_;
  File master_;
  File slave_;  // kept open: otherwise the master end reports a hang-up while no other program has
                // it open
  std::uint8_t buffer_[512];
};

}  // namespace lss::sim
