#pragma once

// The log thread: passes every frame to the running logs (run_log.h) and to the flight recorder
// (recorder.h), keeps the last frames and writes them to a file when a fault was raised (lss-cli
// log show). The frame thread's side is wait-free and drops when the ring is full: a slow or full
// disk never delays a frame; dropped frames are counted and reported. Ordinary thread.
//
// A file of a fault consists of JSON lines: a header, then one frame per line, the oldest first. It
// gets its name when it is complete. Files are numbered; the newest are kept, and the first since
// the start, so that a recurring fault does not delete the file of its cause. Soon after a fault
// another does not write the same frames again: its file comes when later frames have filled the
// ring once, or when no frame comes any more.

#include <atomic>
#include <boost/lockfree/policies.hpp>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/record/files.h"
#include "daemon/record/recorder.h"
#include "daemon/record/run_log.h"
#include "daemon/runtime/ring.h"
#include "idl/codes.h"

namespace lss::record {

struct FrameLogSettings {
  std::filesystem::path folder;  // of kept files; empty: no frames before a fault
  std::size_t files = 32;        // kept
  std::string vehicle_id;
  nlohmann::ordered_json header;             // more for the first line
  std::vector<config::LogPreset> presets{};  // the running logs; none: only faults are logged
  std::optional<RecorderSettings> recorder{};
};

class FrameLog {
 public:
  static constexpr std::size_t kFrames = 64;
  FrameLog(FrameLogSettings settings, ToJson to_json);
  ~FrameLog() { stop(); }
  FrameLog(const FrameLog&) = delete;
  FrameLog& operator=(const FrameLog&) = delete;

  // Warns when nothing can be written to the folder.
  void start();
  void stop();  // writes pending data

  // Frame thread.
  void put(const FrameMark& mark, std::span<const std::uint8_t> record) noexcept;
  // The recorder needs the state of the vehicle after the last frame put.
  bool wants_state() const noexcept { return wants_state_.load(std::memory_order_relaxed); }
  void put_state(std::span<const std::uint8_t> state) noexcept;

  // Main thread: the frame thread stands still and can raise no fault.
  void keep() noexcept { keep_ = true; }

  // Any thread.
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }
  std::uint64_t turns() const noexcept { return turns_.load(std::memory_order_relaxed); }
  // Whether frames are recorded or a log runs, as configured, without errors.
  bool recording() const noexcept { return recording_.load(std::memory_order_relaxed); }
  // Publish thread: events to report.
  bool pop(EventId& event) noexcept { return told_.pop(event); }

 private:
  struct Header {
    Item item = Item::frame;
    std::size_t size = 0;
    std::uint64_t dropped = 0;  // before it
    FrameMark mark;
  };

  bool push(const Header& header, std::span<const std::uint8_t> bytes) noexcept;
  void run();
  void drain();
  void take(const Header& header, TimeNs now);
  bool writes() const;
  void write();
  std::string write_file(const std::filesystem::path& path) const;
  void prepare_folder();
  void keep_newest() const;
  void tell_dropped(TimeNs now);

  FrameLogSettings settings_;
  NumberedFiles files_;
  ToJson to_json_;
  // Half a megabyte: four seconds of zebro's usual 2.3 kB every 20 ms, seldom less than one.
  boost::lockfree::spsc_queue<std::uint8_t, boost::lockfree::capacity<(1u << 19)>> queue_;
  std::atomic<std::uint64_t> dropped_{0}, turns_{0};
  std::atomic<bool> wants_state_{false};
  Ring<EventId, 16> told_;

  std::deque<std::vector<std::uint8_t>> last_;  // log thread
  std::size_t since_ = kFrames;                 // frames since the last file
  FaultId pending_ = FaultId::none;
  bool failed_ = false;
  std::vector<std::unique_ptr<RunLog>> run_logs_;
  std::unique_ptr<Recorder> recorder_;
  std::vector<std::uint8_t> state_;
  std::atomic<bool> recording_{false};
  std::uint64_t told_dropped_ = 0;
  TimeNs tell_dropped_ns_ = 0;   // not before
  unsigned number_ = 0;          // of the newest file
  std::filesystem::path first_;  // since the start
  std::atomic<bool> keep_{false}, stop_{false};
  std::thread thread_;
};

}  // namespace lss::record
