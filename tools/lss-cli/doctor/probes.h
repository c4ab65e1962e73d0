#pragma once

// The system calls of lss-cli doctor. They change nothing: a thread requests SCHED_FIFO and ends, a
// serial port is opened and closed with its settings. Main thread; every call is short.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

namespace lss::cli::doctor {

// Requests SCHED_FIFO in a separate thread. Returns 0 when granted, otherwise the errno.
int ask_fifo(int priority);

// How long one clock_gettime takes, undisturbed.
double clock_read_ns();
// The kernel's clock is disciplined by NTP, PTP or similar.
bool clock_synchronised();
// UTC minus monotonic time: constant except for steps of the clock.
std::int64_t utc_offset_ns();

struct SerialAnswer {
  int error = 0;  // errno of opening it
  bool terminal = false, pseudo = false;
  std::optional<bool> low_latency = std::nullopt;  // empty: the driver has no such switch
};
// Opens no device that is known not to be a terminal: some devices act when they are opened.
SerialAnswer ask_serial(const std::filesystem::path& path);

// 0, or the errno of making a raw CAN socket.
int ask_can_socket();

struct CanLink {
  std::string kind;  // "can", "vcan"; empty when the driver does not say
  std::optional<std::uint32_t> state = std::nullopt;  // enum can_state of linux/can/netlink.h
  std::uint32_t bitrate = 0;                          // bit/s; 0: not set
  std::uint32_t restart_ms = 0;                       // after bus-off; 0: never by itself
};
// By netlink; empty when there is no such interface.
std::optional<CanLink> ask_can_link(const std::string& interface);
// The attributes behind the ifinfomsg of an RTM_NEWLINK message.
CanLink parse_can_link(std::span<const std::byte> attributes);

struct Space {
  std::uint64_t free_bytes = 0, total_bytes = 0;  // of the file system
  bool writable = true;                           // by this user
};
// Empty when there is no such folder.
std::optional<Space> space(const std::filesystem::path& folder);

}  // namespace lss::cli::doctor
