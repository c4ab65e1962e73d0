#pragma once

// The log thread: keeps the last frames and writes them to a file when a fault was raised, so that
// what led to it can be read (lss-cli log show). The frame thread's side is wait-free and drops
// when the ring is full: a slow or full disk never delays a frame. Ordinary thread.
//
// A file holds JSON lines: what it is, then a frame a line, the oldest first. It appears under its
// name when it is whole, and only the newest files are kept. A fault soon after another does not
// write the same frames again: the file comes when the frames since have filled the ring once.

#include <array>
#include <atomic>
#include <boost/lockfree/policies.hpp>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "daemon/core/ring.h"
#include "idl/codes.h"

namespace lss::record {

struct FrameLogSettings {
  std::filesystem::path folder;  // empty: nothing is written
  std::size_t files = 32;        // kept
  std::string vehicle_id;
  nlohmann::ordered_json header;  // more for the first line
};

class FrameLog {
 public:
  static constexpr std::size_t kFrames = 64;
  // Makes JSON of a record, on the log thread.
  using ToJson = std::function<nlohmann::ordered_json(std::span<const std::uint8_t>)>;

  FrameLog(FrameLogSettings settings, ToJson to_json);
  ~FrameLog() { stop(); }
  FrameLog(const FrameLog&) = delete;
  FrameLog& operator=(const FrameLog&) = delete;

  // Warns when nothing can be written to the folder.
  void start();
  void stop();  // writes what is pending

  // Frame thread. `fault`: the first that was raised in this frame.
  void put(FaultId fault, std::span<const std::uint8_t> record) noexcept;

  // Any thread.
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }
  std::uint64_t turns() const noexcept { return turns_.load(std::memory_order_relaxed); }
  // Publish thread: what to tell.
  bool pop(EventId& event) noexcept { return told_.pop(event); }

 private:
  struct Header {
    std::uint32_t size = 0;
    FaultId fault = FaultId::none;
  };

  void run();
  void drain();
  void write();
  std::string write_file(const std::filesystem::path& path) const;
  void keep_newest() const;

  FrameLogSettings settings_;
  ToJson to_json_;
  // Half a megabyte: more than two seconds of frames of any vehicle.
  boost::lockfree::spsc_queue<std::uint8_t, boost::lockfree::capacity<(1u << 19)>> queue_;
  std::atomic<std::uint64_t> dropped_{0}, turns_{0};
  Ring<EventId, 16> told_;

  std::deque<std::vector<std::uint8_t>> last_;  // log thread
  std::size_t since_ = kFrames;                 // frames since the last file
  FaultId pending_ = FaultId::none;
  bool failed_ = false;
  unsigned written_ = 0;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace lss::record
