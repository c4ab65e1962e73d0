#include "daemon/record/recording.h"

#include <fcntl.h>
#include <unistd.h>

#include <boost/crc.hpp>
#include <cerrno>
#include <cstring>
#include <utility>

#include "daemon/record/files.h"
#include "daemon/record/recording_format.h"

namespace lss::record {

using namespace format;

std::uint32_t crc32c(std::span<const std::uint8_t> bytes) {
  boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true> crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

RecordingWriter::~RecordingWriter() { abandon(); }

int RecordingWriter::begin(const std::filesystem::path& path, const nlohmann::ordered_json& header,
                           std::uint64_t allocate) {
  abandon();
  size_ = index_ = 0;
  pending_frames_ = 0;
  items_.clear();
  so_far_ = {};
  fd_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (fd_ < 0) return errno;
  mark_being_written(fd_);
  // Not supported by some file systems; then blocks are allocated while writing.
  int error = 0;
  if (allocate > 0 && ::fallocate(fd_, 0, 0, static_cast<off_t>(allocate)) != 0) error = errno;
  if (error == EOPNOTSUPP || error == ENOSYS) error = 0;
  if (error == 0) {
    std::vector<std::uint8_t> prologue(kMagic.begin(), kMagic.end());
    append(prologue, kRecordingFormat);
    append(prologue, crc32c(prologue));
    error = write_all(fd_, text(prologue));
    if (error == 0) size_ = prologue.size();
  }
  if (error == 0) {
    const std::string json =
        header.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    error = write_chunk(kBegin, {reinterpret_cast<const std::uint8_t*>(json.data()), json.size()});
  }
  if (error == 0) return 0;
  abandon();
  ::unlink(path.c_str());
  return error;
}

void RecordingWriter::add(Item kind, std::span<const std::uint8_t> bytes) {
  append(items_, std::uint32_t{static_cast<std::uint8_t>(kind)});
  append(items_, static_cast<std::uint32_t>(bytes.size()));
  items_.insert(items_.end(), bytes.begin(), bytes.end());
}

void RecordingWriter::add_frame(std::span<const std::uint8_t> record, std::int64_t time_ns) {
  add(Item::frame, record);
  ++pending_frames_;
  if (so_far_.frames++ == 0) so_far_.first_ns = time_ns;
  so_far_.last_ns = time_ns;
}

void RecordingWriter::add_lost(std::uint64_t frames) {
  std::array<std::uint8_t, sizeof frames> bytes;
  std::memcpy(bytes.data(), &frames, sizeof frames);
  add(Item::lost, bytes);
  pending_frames_ += frames;
  so_far_.lost += frames;
}

int RecordingWriter::flush() {
  if (items_.empty()) return 0;
  if (const int error = write_chunk(kItems, items_); error != 0) return error;
  items_.clear();
  pending_frames_ = 0;
  return 0;
}

int RecordingWriter::sync() { return ::fdatasync(fd_) == 0 ? 0 : errno; }

int RecordingWriter::end() {
  int error = flush();
  std::vector<std::uint8_t> payload;
  append(payload, so_far_.frames);
  append(payload, so_far_.lost);
  append(payload, so_far_.first_ns);
  append(payload, so_far_.last_ns);
  if (error == 0) error = write_chunk(kEnd, payload);
  if (error == 0 && ::ftruncate(fd_, static_cast<off_t>(size_)) != 0) error = errno;
  if (error == 0) error = sync();
  abandon();
  return error;
}

void RecordingWriter::abandon() {
  if (fd_ < 0) return;
  // Removes allocated room and a partial chunk: the file ends with its last whole one.
  [[maybe_unused]] const int cut = ::ftruncate(fd_, static_cast<off_t>(size_));
  ::close(std::exchange(fd_, -1));
}

bool RecordingWriter::removed() const { return is_removed(fd_); }

int RecordingWriter::write_chunk(std::uint8_t kind, std::span<const std::uint8_t> payload) {
  chunk_.assign(kChunkMagic.begin(), kChunkMagic.end());
  append(chunk_, std::uint32_t{kind});
  append(chunk_, index_);
  append(chunk_, static_cast<std::uint32_t>(payload.size()));
  append(chunk_, crc32c(chunk_));
  chunk_.insert(chunk_.end(), payload.begin(), payload.end());
  append(chunk_, crc32c(chunk_));
  chunk_.insert(chunk_.end(), kTrailMagic.begin(), kTrailMagic.end());
  if (const int error = write_all(fd_, text(chunk_)); error != 0) return error;
  size_ += chunk_.size();
  ++index_;
  return 0;
}

}  // namespace lss::record
