#include "daemon/record/log_sink.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <utility>

#include "daemon/runtime/clock.h"

namespace lss::record {

namespace fs = std::filesystem;

LogFiles::LogFiles(const config::LogPreset& preset, fs::path folder, const std::string& vehicle_id,
                   FirstLine first_line)
    : preset_(preset.name),
      file_bytes_(preset.file_bytes),
      total_bytes_(preset.total_bytes),
      folder_(std::move(folder)),
      files_(folder_, vehicle_id, kSuffix),
      first_line_(std::move(first_line)) {}

std::string LogFiles::put(std::string_view line, TimeNs now) {
  const bool full = lines_ > 0 && size_ + line.size() > file_bytes_;
  if (fd_ >= 0 && (full || is_removed(fd_))) close();
  if (fd_ < 0 && now < retry_ns_) return error_;
  int error = fd_ < 0 ? begin() : 0;
  if (error == 0) error = add(line);
  if (error == 0) {
    ++lines_;
    return {};
  }
  close();
  retry_ns_ = now + kRetry;
  return error_ = std::strerror(error);
}

int LogFiles::begin() {
  const unsigned number = files_.make_room(file_bytes_, total_bytes_);
  path_ = files_.path(number, utc_ns(), preset_);
  size_ = lines_ = 0;
  fd_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0644);
  if (fd_ < 0) return errno;
  mark_being_written(fd_);
  return add(first_line_());
}

// The whole line, or nothing.
int LogFiles::add(std::string_view text) {
  const int error = write_all(fd_, text);
  if (error == 0) {
    size_ += text.size();
  } else {
    [[maybe_unused]] const int cut = ::ftruncate(fd_, static_cast<off_t>(size_));
  }
  return error;
}

void LogFiles::close() {
  if (fd_ < 0) return;
  if (lines_ == 0) ::unlink(path_.c_str());
  ::close(std::exchange(fd_, -1));
}

std::string LogSocket::put(std::string_view line, TimeNs now) {
  if (!socket_ && now < retry_ns_) return error_;
  int error = !socket_ ? connect() : 0;
  if (error == 0 && now >= first_line_ns_) {
    error = send(first_line_());
    if (error == 0) first_line_ns_ = now + kFirstLineEvery;
  }
  if (error == 0) error = send(line);
  if (error == 0) return {};
  if (error == EAGAIN || error == ENOBUFS) return "who listens is too slow";
  if (error == EMSGSIZE) return "a line is longer than a datagram may be";
  socket_ = File();
  retry_ns_ = now + kRetry;
  return error_ = std::strerror(error);
}

int LogSocket::connect() {
  sockaddr_storage storage{};
  socklen_t size = 0;
  constexpr std::string_view kUdp = "udp://";
  if (address_.starts_with(kUdp)) {
    const std::size_t colon = address_.rfind(':');
    sockaddr_in to{};
    to.sin_family = AF_INET;
    std::uint16_t port = 0;
    std::from_chars(address_.data() + colon + 1, address_.data() + address_.size(), port);
    to.sin_port = htons(port);
    const std::string host = address_.substr(kUdp.size(), colon - kUdp.size());
    if (::inet_pton(AF_INET, host.c_str(), &to.sin_addr) != 1) return EADDRNOTAVAIL;
    std::memcpy(&storage, &to, size = sizeof to);
  } else {
    sockaddr_un to{};
    to.sun_family = AF_UNIX;
    if (address_.size() >= sizeof to.sun_path) return ENAMETOOLONG;
    std::memcpy(to.sun_path, address_.data(), address_.size());
    std::memcpy(&storage, &to, size = sizeof to);
  }
  socket_ = File(::socket(storage.ss_family, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!socket_) return errno;
  first_line_ns_ = 0;
  const auto* to = reinterpret_cast<const sockaddr*>(&storage);
  return ::connect(socket_.get(), to, size) == 0 ? 0 : errno;
}

int LogSocket::send(std::string_view text) const {
  constexpr int kFlags = MSG_DONTWAIT | MSG_NOSIGNAL;
  return ::send(socket_.get(), text.data(), text.size(), kFlags) < 0 ? errno : 0;
}

std::unique_ptr<LogSink> make_sink(const config::LogPreset& preset, const fs::path& folder,
                                   const std::string& vehicle_id, FirstLine first_line) {
  if (!preset.address.empty())
    return std::make_unique<LogSocket>(preset.address, std::move(first_line));
  return std::make_unique<LogFiles>(preset, folder, vehicle_id, std::move(first_line));
}

}  // namespace lss::record
