#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "daemon/record/files.h"
#include "daemon/record/limits.h"
#include "daemon/record/recording.h"
#include "daemon/record/recording_format.h"

namespace lss::record {
namespace {

using namespace format;

constexpr std::size_t kWindow = 64 * 1024;  // files are looked through piece by piece
// Passes through a file. One that was made to be slow to read is not read further.
constexpr std::uint64_t kMostSearches = 4;

// The whole window at once: a file may be one long hole.
bool is_zero(const std::vector<std::uint8_t>& window) {
  return window.front() == 0 &&
         std::memcmp(window.data(), window.data() + 1, window.size() - 1) == 0;
}

// A field of the wrong type. A missing field is checked where it is needed.
std::optional<std::string> wrong_field(const nlohmann::ordered_json& header) {
  using Type = nlohmann::ordered_json::value_t;
  struct Fields {
    Type type;
    const char* spoken;
    std::vector<const char*> names;
  };
  static const Fields kFields[] = {
      {Type::string,
       "a text",
       {"lss", "vehicle", "vehicle_id", "version", "config", "state_layout", "schema"}},
      {Type::number_integer, "a time", {"utc_ns", "time_ns", "run_utc_ns", "period_ns"}},
      {Type::boolean, "true or false", {"start"}},
      {Type::object, "an object", {"build", "parameters"}}};
  for (const Fields& fields : kFields) {
    for (const char* name : fields.names) {
      const auto found = header.find(name);
      if (found == header.end()) continue;
      const bool right =
          fields.type == Type::number_integer
              ? found->is_number_integer() && most::is_time(found->get<std::int64_t>())
              : found->type() == fields.type;
      if (!right) return fmt::format("{} is not {}", name, fields.spoken);
    }
  }
  if (const auto build = header.find("build"); build != header.end()) {
    for (const auto& [name, value] : build->items())
      if (!value.is_string()) return fmt::format("build.{} is not a text", name.substr(0, 20));
  }
  return std::nullopt;
}

}  // namespace

tl::expected<RecordingReader, std::string> RecordingReader::open(
    const std::filesystem::path& path) {
  File file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));  // of a pipe, too
  struct stat info {};
  if (!file || ::fstat(file.get(), &info) != 0) {
    return tl::unexpected(
        fmt::format("{} cannot be read: {}", path.string(), std::strerror(errno)));
  }
  RecordingReader reader(std::move(file), static_cast<std::uint64_t>(info.st_size));
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
  if (reader.size_ > most::kFileBytes)
    return tl::unexpected(fmt::format("{} has {} bytes, at most {} are read", path.string(),
                                      reader.size_, most::kFileBytes));
  reader.offset_ = kPrologue;
  if (const auto header = reader.read_header(); !header)
    return tl::unexpected(fmt::format("{} {}", path.string(), header.error()));
  return reader;
}

tl::expected<void, std::string> RecordingReader::read_header() {
  const bool first = next_chunk();
  if (first && chunk_.size() > most::kHeaderBytes)
    return tl::unexpected(fmt::format("has a header of {} bytes, at most {} are read",
                                      chunk_.size(), most::kHeaderBytes));
  if (first && kind_ == kBegin) header_ = parse_json(text(chunk_));
  if (!first || !header_.is_object())
    return tl::unexpected(fmt::format("has no whole header: {}", first ? "it is no JSON object"
                                                                 : trouble_.empty()
                                                                     ? "nothing was written"
                                                                     : trouble_));
  chunk_.clear();
  if (const auto wrong = wrong_field(header_))
    return tl::unexpected(fmt::format("has a header in which {}; it was not made by lssd", *wrong));
  return {};
}

bool RecordingReader::next(Item& kind, std::span<const std::uint8_t>& bytes) {
  if (next_item(kind, bytes)) return true;
  if (!damage_.empty()) {
    end_ = End::damaged;
    trouble_ = fmt::format("{}; chunks that are missing: {}", damage_, missing_);
  }
  return false;
}

bool RecordingReader::next_item(Item& kind, std::span<const std::uint8_t>& bytes) {
  static constexpr std::array<std::uint8_t, sizeof(std::uint64_t)> kUnknown{};
  while (at_ == chunk_.size()) {
    if (end_ != End::none) return false;
    if (!next_chunk()) {
      if (!skip_damage()) return false;
      kind = Item::lost;
      bytes = kUnknown;
      return true;
    }
    if (kind_ == kEnd) {
      end_ = End::whole;
      chunk_.clear();
      at_ = 0;
      if (offset_ != size_) classify();  // nothing but unused room may follow
      if (end_ == End::open) end_ = End::whole;
      return false;
    }
  }
  // Only a recorder could have written items that do not fit together.
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

// Reads the next chunk into chunk_; false: no more, and end_ says why.
bool RecordingReader::next_chunk() {
  at_ = 0;
  if (read_chunk()) return true;
  if (!damage_.empty()) {  // of any kind
    end_ = End::damaged;
    return false;
  }
  classify();
  if (end_ != End::torn && end_ != End::damaged) return false;
  // Its recorder may have continued meanwhile: then the chunk is complete now, or will be. Or it
  // has ended: then the file is final, and longer than it was.
  const bool written = being_written();
  if (!written) size_ = file_size();
  const End first = std::exchange(end_, End::none);
  torn_bytes_ = 0;
  trouble_.clear();
  if (read_chunk()) return true;
  if (written && first == End::torn) {
    end_ = End::open;
  } else {
    classify();
  }
  return false;
}

// Reads the chunk at offset_ when it is complete.
bool RecordingReader::read_chunk() {
  std::array<std::uint8_t, kHead> bytes;
  Head head;
  chunk_.clear();
  if (offset_ > size_ || !read_at(offset_, bytes) || !read_head(bytes, head)) return false;
  if (head.index != index_ || head.size > most::kChunkBytes ||
      size_ - offset_ < kHead + std::uint64_t{head.size} + kTrail)
    return false;
  chunk_.resize(kHead + head.size + kTrail);
  const bool got = read_at(offset_, chunk_);
  const Body body = got ? check_body(chunk_, head) : Body{};
  if (!body.crc || !body.trail) {
    chunk_.clear();
    return false;
  }
  offset_ += chunk_.size();
  ++index_;
  kind_ = head.kind;
  chunk_.erase(chunk_.begin(), chunk_.begin() + kHead);
  chunk_.resize(head.size);
  return true;
}

// After damage: the next chunk to read is the next complete one. False: there is none.
bool RecordingReader::skip_damage() {
  std::uint64_t at = 0;
  std::uint32_t index = 0;
  if (end_ != End::damaged || !find_chunk(at, index)) return false;
  if (damage_.empty()) damage_ = trouble_;
  missing_ += index - index_;
  offset_ = at;
  index_ = index;
  end_ = End::none;
  trouble_.clear();
  return true;
}

// The first complete chunk from offset_ on that can follow, and its index.
bool RecordingReader::find_chunk(std::uint64_t& at, std::uint32_t& index) {
  const std::uint64_t end = std::min(size_, file_size());
  const std::uint64_t limit = kMostSearches * (size_ + most::kChunkBytes);
  std::vector<std::uint8_t> window, chunk;
  Head head;
  for (std::uint64_t from = offset_; from + kHead <= end; from += window.size() - kHead + 1) {
    window.resize(std::min<std::uint64_t>(kWindow, end - from));
    searched_ += window.size();
    if (searched_ > limit || !read_at(from, window)) return false;
    if (is_zero(window)) continue;
    const std::span<const std::uint8_t> all(window);
    for (std::size_t i = 0; i + kHead <= all.size(); ++i) {
      if (!read_head(all.subspan(i), head)) continue;
      at = from + i;
      const std::uint64_t size = kHead + std::uint64_t{head.size} + kTrail;
      if (head.kind == kBegin || head.index < index_ || head.size > most::kChunkBytes ||
          end - at < size)
        continue;
      chunk.resize(size);
      if (!read_at(at, chunk)) return false;
      index = head.index;
      if (const Body body = check_body(chunk, head); body.crc && body.trail) return true;
      searched_ += size;
      if (searched_ > limit) return false;
    }
  }
  return false;
}

bool RecordingReader::being_written() const { return is_being_written(file_.get()); }

// Why no complete chunk begins at offset_. Torn: incomplete, and nothing follows; everything else
// was complete and was changed.
void RecordingReader::classify() {
  const std::uint64_t used = end_of_use() - offset_;
  if (used == 0) {
    end_ = End::open;
    return;
  }
  const bool torn = end_ != End::whole && looks_torn(used);
  end_ = torn ? End::torn : End::damaged;
  torn_bytes_ = torn ? used : 0;
  trouble_ =
      torn ? fmt::format("cut off at byte {}: the {} bytes after it are no whole chunk", offset_,
                         used)
           : fmt::format("damaged in the chunk that begins at byte {}: it is not as it was written",
                         offset_);
  std::array<std::uint8_t, kHead> bytes;
  if (Head head; read_at(offset_, bytes) && read_head(bytes, head) && head.size > most::kChunkBytes)
    trouble_ += fmt::format(", of {} bytes; at most {} are read", head.size, most::kChunkBytes);
}

// size_ when it cannot be found out.
std::uint64_t RecordingReader::file_size() const {
  struct stat info {};
  return ::fstat(file_.get(), &info) == 0 ? static_cast<std::uint64_t>(info.st_size) : size_;
}

// Position after the last byte that is not zero; offset_ when there is none.
std::uint64_t RecordingReader::end_of_use() const {
  std::uint64_t end = std::min(size_, file_size());
  std::vector<std::uint8_t> window;
  while (end > offset_) {
    window.resize(std::min<std::uint64_t>(kWindow, end - offset_));
    const std::size_t before = window.size();
    if (!read_at(end - before, window)) return offset_;
    if (is_zero(window)) {
      end -= window.size();
      continue;
    }
    while (window.back() == 0) window.pop_back();
    return end - before + window.size();
  }
  return offset_;
}

bool RecordingReader::looks_torn(std::uint64_t used) const {
  std::array<std::uint8_t, kHead> bytes;
  Head head;
  if (used >= kHead && read_at(offset_, bytes) && read_head(bytes, head)) {
    if (head.size > most::kChunkBytes) return false;
    std::vector<std::uint8_t> chunk(kHead + head.size + kTrail);
    const bool to_its_end = used >= chunk.size() && read_at(offset_, chunk);
    const Body body = to_its_end ? check_body(chunk, head) : Body{};
    if (body.crc || body.trail) return false;  // a part, or the number of the chunk
  }
  std::array<std::uint8_t, kTrailMagic.size()> trail;
  if (used >= trail.size() && read_at(offset_ + used - trail.size(), trail) &&
      starts_with(trail, kTrailMagic))
    return false;                                 // the end of a chunk is there
  return !has_head(offset_ + 1, offset_ + used);  // another chunk follows
}

bool RecordingReader::has_head(std::uint64_t from, std::uint64_t to) const {
  std::vector<std::uint8_t> window;
  Head head;
  for (; from + kHead < to; from += window.size() - kHead + 1) {
    window.resize(std::min<std::uint64_t>(kWindow, to - from));
    if (!read_at(from, window)) return false;
    const std::span<const std::uint8_t> all(window);
    for (std::size_t at = 0; at + kHead <= all.size(); ++at) {
      if (read_head(all.subspan(at), head)) return true;
    }
  }
  return false;
}

bool RecordingReader::read_at(std::uint64_t offset, std::span<std::uint8_t> to) const {
  while (!to.empty()) {
    const ssize_t got = ::pread(file_.get(), to.data(), to.size(), static_cast<off_t>(offset));
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
  if (reader->being_written()) return 0;  // by another daemon of this name and folder
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
