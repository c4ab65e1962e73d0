#pragma once

// Targets of a running log: files that rotate, or datagrams to a socket. Log thread. No line is
// retried: a line that cannot be written is lost, and the caller counts it.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "daemon/config/config.h"
#include "daemon/record/files.h"
#include "drivers/file.h"
#include "drivers/time.h"

namespace lss::record {

class LogSink {
 public:
  virtual ~LogSink() = default;
  // A line, with its end. Empty, or the reason why it is lost.
  virtual std::string put(std::string_view line, TimeNs now) = 0;
  virtual std::string where() const = 0;  // for people
};

// The first line of a file: writer and contents.
using FirstLine = std::function<std::string()>;

// Each start, and each file that is full, begins a new file, ID-NUMBER-TIME-PRESET.log.jsonl.
// Before that the oldest of this vehicle are deleted, so that all together stay within total_bytes;
// other files, and one that another daemon writes, are never touched. Every line is with the kernel
// when put() returns: a killed daemon loses none. When the disk is full, the file ends with its
// last whole line, and opening a new one is retried.
class LogFiles final : public LogSink {
 public:
  static constexpr const char* kSuffix = ".log.jsonl";
  static constexpr TimeNs kRetry = 5 * kSecond;

  LogFiles(const config::LogPreset& preset, std::filesystem::path folder,
           const std::string& vehicle_id, FirstLine first_line);
  ~LogFiles() override { close(); }
  LogFiles(const LogFiles&) = delete;
  LogFiles& operator=(const LogFiles&) = delete;

  std::string put(std::string_view line, TimeNs now) override;
  std::string where() const override { return folder_.string(); }

 private:
  int begin();
  int add(std::string_view text);
  void close();

  std::string preset_;
  std::uint64_t file_bytes_, total_bytes_;
  std::filesystem::path folder_;
  NumberedFiles files_;
  FirstLine first_line_;
  std::filesystem::path path_;  // of the open file
  int fd_ = -1;
  std::uint64_t size_ = 0, lines_ = 0;
  std::string error_;
  TimeNs retry_ns_ = 0;
};

// One datagram per line, to a UNIX socket or to UDP on the loopback interface. The receiver may be
// absent, come and go, and be slow. The first line is sent when a connection begins and every ten
// seconds.
class LogSocket final : public LogSink {
 public:
  static constexpr TimeNs kRetry = kSecond;
  static constexpr TimeNs kFirstLineEvery = 10 * kSecond;

  LogSocket(std::string address, FirstLine first_line)
      : address_(std::move(address)), first_line_(std::move(first_line)) {}

  std::string put(std::string_view line, TimeNs now) override;
  std::string where() const override { return address_; }

 private:
  int connect();
  int send(std::string_view text) const;

  std::string address_;
  FirstLine first_line_;
  File socket_;
  std::string error_;
  TimeNs retry_ns_ = 0, first_line_ns_ = 0;
};

std::unique_ptr<LogSink> make_sink(const config::LogPreset& preset,
                                   const std::filesystem::path& folder,
                                   const std::string& vehicle_id, FirstLine first_line);

}  // namespace lss::record
