#pragma once

// One end of a line between two processes in simulated time: pseudo-terminals and datagrams carry
// the data, the page counts it. The sender counts after it wrote; the receiver reads until it has
// the counted amount, with any latency of the kernel. Off: only a branch.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "drivers/lockstep/lockstep.h"

namespace lss::lockstep {

struct Line;

class Wire {
 public:
  enum class Side : int { daemon = 0, simulator = 1 };

  explicit Wire(Side side) noexcept : own_(static_cast<std::size_t>(side)), other_(1 - own_) {}
  ~Wire() { close(); }
  // Data in transit is lost. A name of a port, or an address; by the thread that reads, or before
  // it runs.
  void open(std::string_view name) noexcept;
  void close() noexcept;

  // Any thread.
  void sent(std::size_t count) noexcept {
    if (is_open()) count_sent(count);
  }
  void took(std::size_t count) noexcept {
    if (is_open()) count_taken(count);
  }
  // Counted data is not read yet, or the other end is closed, which reading shows.
  bool coming() noexcept;
  // Waits in wall time until more counted data can be read; false: there is no more.
  bool awaits(int fd) noexcept { return is_open() && await_more(fd); }
  bool is_heard() const noexcept;           // the other end is open
  std::uint32_t openings() const noexcept;  // of the other end
  bool is_open() const noexcept { return line() != nullptr; }

 private:
  Line* line() const noexcept { return line_.load(std::memory_order_acquire); }
  void count_sent(std::size_t count) noexcept;
  void count_taken(std::size_t count) noexcept;
  bool await_more(int fd) noexcept;

  const std::size_t own_, other_;
  std::atomic<Line*> line_{nullptr};  // of the page, which stays
};

// The name of a line: the last part of a path, an address without what is after '?'.
std::string_view line_name(std::string_view path) noexcept;
// The simulator has this line.
bool has_line(std::string_view name) noexcept;

}  // namespace lss::lockstep
