#include "daemon/record/recording.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <boost/crc.hpp>
#include <cerrno>
#include <cstring>
#include <utility>

#include "daemon/record/files.h"

namespace lss::record {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers in files are little-endian");

constexpr auto& kMagic = kRecordingMagic;
constexpr std::size_t kPrologue = 16;  // magic, format, crc
constexpr std::array<std::uint8_t, 4> kChunkMagic{'L', 'S', 'S', 'c'};
constexpr std::array<std::uint8_t, 4> kTrailMagic{'c', 'S', 'S', 'L'};
constexpr std::size_t kHead = 20;     // magic, kind, three zeros, index, size, crc
constexpr std::size_t kTrail = 8;     // crc of head and payload, magic
constexpr std::size_t kItemHead = 8;  // kind, three zeros, size
constexpr std::size_t kEndPayload = 32;

enum ChunkKind : std::uint8_t { kBegin = 1, kItems = 2, kEnd = 3 };

template <class T>
void append(std::vector<std::uint8_t>& to, const T& x) {
  const std::size_t at = to.size();
  to.resize(at + sizeof x);
  std::memcpy(&to[at], &x, sizeof x);
}

template <class T>
T load(std::span<const std::uint8_t> from, std::size_t at) {
  T x;
  std::memcpy(&x, &from[at], sizeof x);
  return x;
}

bool starts_with(std::span<const std::uint8_t> bytes, std::span<const std::uint8_t> magic) {
  return bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin());
}

struct Head {
  std::uint8_t kind = 0;
  std::uint32_t index = 0, size = 0;
};

// False: there is none.
bool read_head(std::span<const std::uint8_t> bytes, Head& head) {
  if (bytes.size() < kHead || !starts_with(bytes, kChunkMagic)) return false;
  head = {.kind = bytes[4],
          .index = load<std::uint32_t>(bytes, 8),
          .size = load<std::uint32_t>(bytes, 12)};
  return load<std::uint32_t>(bytes, 16) == crc32c(bytes.first(16));
}

// Of a chunk that begins here and has room.
struct Body {
  bool crc = false, trail = false;
};
Body check_body(std::span<const std::uint8_t> bytes, const Head& head) {
  const std::size_t end = kHead + head.size;
  return {.crc = load<std::uint32_t>(bytes, end) == crc32c(bytes.first(end)),
          .trail = starts_with(bytes.subspan(end + 4), kTrailMagic)};
}

std::string_view text(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

std::uint32_t crc32c(std::span<const std::uint8_t> bytes) {
  boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true> crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

// ---- writing

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
  // Some file systems cannot; then the room is found while it is written.
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
  // What was allocated and half a chunk: the file ends with its last whole one.
  [[maybe_unused]] const int cut = ::ftruncate(fd_, static_cast<off_t>(size_));
  ::close(std::exchange(fd_, -1));
}

bool RecordingWriter::removed() const {
  struct stat info {};
  return ::fstat(fd_, &info) == 0 && info.st_nlink == 0;
}

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

// ---- reading

tl::expected<RecordingReader, std::string> RecordingReader::open(
    const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat info {};
  if (fd < 0 || ::fstat(fd, &info) != 0) {
    const int error = errno;
    if (fd >= 0) ::close(fd);
    return tl::unexpected(
        fmt::format("{} cannot be read: {}", path.string(), std::strerror(error)));
  }
  RecordingReader reader(fd, static_cast<std::uint64_t>(info.st_size));
  std::array<std::uint8_t, kPrologue> prologue;
  if (!S_ISREG(info.st_mode) || !reader.read_at(0, prologue) || !starts_with(prologue, kMagic))
    return tl::unexpected(path.string() + " is no recording: it does not begin as one");
  if (load<std::uint32_t>(prologue, 12) != crc32c(std::span(prologue).first(12)))
    return tl::unexpected(path.string() +
                          " is damaged at byte 8: the format's number is not as it was written");
  if (const auto format = load<std::uint32_t>(prologue, 8); format != kRecordingFormat)
    return tl::unexpected(
        fmt::format("{} has format {}, this program reads format {}: use the lssd that wrote it",
                    path.string(), format, kRecordingFormat));
  reader.offset_ = kPrologue;
  const bool first = reader.next_chunk();
  if (first && reader.kind_ == kBegin)
    reader.header_ = nlohmann::ordered_json::parse(text(reader.chunk_), nullptr, false);
  if (!first || !reader.header_.is_object())
    return tl::unexpected(
        fmt::format("{} has no whole header: {}", path.string(),
                    reader.trouble_.empty() ? "nothing was written" : reader.trouble_));
  reader.chunk_.clear();
  return reader;
}

RecordingReader::RecordingReader(RecordingReader&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      size_(other.size_),
      offset_(other.offset_),
      index_(other.index_),
      header_(std::move(other.header_)),
      kind_(other.kind_),
      chunk_(std::move(other.chunk_)),
      at_(other.at_),
      end_(other.end_),
      torn_bytes_(other.torn_bytes_),
      trouble_(std::move(other.trouble_)) {}

RecordingReader::~RecordingReader() {
  if (fd_ >= 0) ::close(fd_);
}

bool RecordingReader::next(Item& kind, std::span<const std::uint8_t>& bytes) {
  while (at_ == chunk_.size()) {
    if (end_ != End::none || !next_chunk()) return false;
    if (kind_ == kEnd) {
      end_ = End::whole;
      chunk_.clear();
      at_ = 0;
      if (offset_ != size_) classify();  // nothing but unused room may follow
      if (end_ == End::open) end_ = End::whole;
      return false;
    }
  }
  // Items that do not fit together would have been written so.
  const std::span<const std::uint8_t> rest = std::span(chunk_).subspan(at_);
  const std::uint32_t size = rest.size() >= kItemHead ? load<std::uint32_t>(rest, 4) : 0;
  if (rest.size() < kItemHead + size || kind_ != kItems) {
    end_ = End::damaged;
    trouble_ =
        fmt::format("damaged before byte {}: a chunk holds what no recorder writes", offset_);
    return false;
  }
  kind = static_cast<Item>(rest[0]);
  bytes = rest.subspan(kItemHead, size);
  at_ += kItemHead + size;
  return true;
}

// The next one into chunk_; false: there is no more, and end_ says why.
bool RecordingReader::next_chunk() {
  std::array<std::uint8_t, kHead> bytes;
  Head head;
  if (read_at(offset_, bytes) && read_head(bytes, head) && head.index == index_ &&
      size_ - offset_ >= kHead + std::uint64_t{head.size} + kTrail) {
    chunk_.resize(kHead + head.size + kTrail);
    if (read_at(offset_, chunk_)) {
      const Body body = check_body(chunk_, head);
      if (body.crc && body.trail) {
        offset_ += chunk_.size();
        ++index_;
        kind_ = head.kind;
        chunk_.erase(chunk_.begin(), chunk_.begin() + kHead);
        chunk_.resize(head.size);
        at_ = 0;
        return true;
      }
    }
  }
  chunk_.clear();
  at_ = 0;
  classify();
  return false;
}

// No whole chunk begins at offset_: why not? Torn is what was not written to its end, and nothing
// follows; everything else was written, and changed.
void RecordingReader::classify() {
  std::vector<std::uint8_t> rest(size_ - offset_);
  if (!read_at(offset_, rest)) rest.clear();
  std::size_t used = rest.size();
  while (used > 0 && rest[used - 1] == 0) --used;
  const std::span<const std::uint8_t> all(rest);
  if (used == 0) {
    end_ = End::open;
    return;
  }
  bool torn = end_ != End::whole;
  Head head;
  if (torn && read_head(all, head)) {
    const bool to_its_end = used >= kHead + std::uint64_t{head.size} + kTrail;
    const Body body = to_its_end ? check_body(all, head) : Body{};
    if (body.crc || body.trail) torn = false;  // a part, or the number of the chunk
  }
  if (torn && used >= kTrailMagic.size() &&
      starts_with(all.subspan(used - kTrailMagic.size()), kTrailMagic))
    torn = false;  // the end of a chunk is there
  for (std::size_t at = 1; torn && at + kHead < used; ++at) {
    if (read_head(all.subspan(at), head)) torn = false;  // another chunk follows
  }
  end_ = torn ? End::torn : End::damaged;
  torn_bytes_ = torn ? used : 0;
  trouble_ =
      torn ? fmt::format("cut off at byte {}: the {} bytes after it are no whole chunk", offset_,
                         used)
           : fmt::format("damaged in the chunk that begins at byte {}: it is not as it was written",
                         offset_);
}

bool RecordingReader::read_at(std::uint64_t offset, std::span<std::uint8_t> to) const {
  while (!to.empty()) {
    const ssize_t got = ::pread(fd_, to.data(), to.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    offset += static_cast<std::uint64_t>(got);
    to = to.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

bool RecordingReader::last_words(RecordingEnd& end) const {
  std::array<std::uint8_t, kHead + kEndPayload + kTrail> bytes;
  Head head;
  if (size_ < bytes.size() || !read_at(size_ - bytes.size(), bytes)) return false;
  if (!read_head(bytes, head) || head.kind != kEnd || head.size != kEndPayload) return false;
  if (!check_body(bytes, head).crc) return false;
  end = {.frames = load<std::uint64_t>(bytes, kHead),
         .lost = load<std::uint64_t>(bytes, kHead + 8),
         .first_ns = load<std::int64_t>(bytes, kHead + 16),
         .last_ns = load<std::int64_t>(bytes, kHead + 24)};
  return true;
}

tl::expected<std::uint64_t, std::string> cut_recording(const std::filesystem::path& path) {
  auto reader = RecordingReader::open(path);
  if (!reader) return tl::unexpected(reader.error());
  Item kind;
  std::span<const std::uint8_t> bytes;
  while (reader->next(kind, bytes)) {
  }
  if (reader->end() == RecordingReader::End::damaged)
    return tl::unexpected(path.string() + " is " + reader->trouble());
  if (reader->offset() == reader->size()) return 0;
  if (::truncate(path.c_str(), static_cast<off_t>(reader->offset())) != 0)
    return tl::unexpected(fmt::format("{} cannot be cut: {}", path.string(), std::strerror(errno)));
  return reader->torn_bytes();
}

}  // namespace lss::record
