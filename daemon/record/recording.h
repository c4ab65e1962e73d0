#pragma once

// Files of the flight recorder, ID-NUMBER-TIME-NAME.lssrec (byte format: docs/recording.md): a
// header, then chunks of items with CRC-32C. Only complete chunks are valid. Limits: limits.h. No
// DDS, no log, no thread of its own.

#include <array>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "drivers/file.h"

namespace lss::record {

inline constexpr const char* kRecordingSuffix = ".lssrec";
inline constexpr std::uint32_t kRecordingFormat = 1;
// The first bytes of a file: not text; shows a transfer that changed line ends.
inline constexpr std::array<std::uint8_t, 8> kRecordingMagic{0x89, 'L', 'S', 'S',
                                                             'R',  'E', 'C', '\n'};

enum class Item : std::uint8_t {
  frame = 1,  // a record, as Writer of fields.h writes it (frame_record.h)
  state = 2,  // state of the vehicle after the frame before (state.h)
  lost = 3,   // so many frames are missing here: u64; 0, from the reader: it is not known how many
};

std::uint32_t crc32c(std::span<const std::uint8_t> bytes);

// Contents of the last chunk of a file that was ended.
struct RecordingEnd {
  std::uint64_t frames = 0, lost = 0;
  std::int64_t first_ns = 0, last_ns = 0;  // of frames: T_k
};

// One file, written by one thread. Items are collected until flush(). Functions that return int
// give 0 or the error's number; after an error the file ends with its last whole chunk.
class RecordingWriter {
 public:
  RecordingWriter() = default;
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  // A new file; its blocks are allocated, so that a full disk shows now and a sync is short.
  int begin(const std::filesystem::path& path, const nlohmann::ordered_json& header,
            std::uint64_t allocate);
  bool is_open() const noexcept { return fd_ >= 0; }
  void add(Item kind, std::span<const std::uint8_t> bytes);
  void add_frame(std::span<const std::uint8_t> record, std::int64_t time_ns);
  void add_lost(std::uint64_t frames);
  // Everything added is with the kernel.
  int flush();
  int sync();  // ... and on the disk
  int end();   // flush, the last chunk, and unused allocated room is released
  void abandon();
  bool removed() const;  // by another program or a person

  std::uint64_t size() const noexcept { return size_ + items_.size(); }
  std::size_t pending() const noexcept { return items_.size(); }  // bytes, until flush()
  // Without it these are missing, and nothing says so: added ones, and lost ones.
  std::uint64_t pending_frames() const noexcept { return pending_frames_; }
  const RecordingEnd& so_far() const noexcept { return so_far_; }

 private:
  int write_chunk(std::uint8_t kind, std::span<const std::uint8_t> payload);

  int fd_ = -1;
  std::uint64_t size_ = 0;  // of whole chunks
  std::uint32_t index_ = 0;
  std::vector<std::uint8_t> items_, chunk_;
  std::uint64_t pending_frames_ = 0;
  RecordingEnd so_far_;
};

// Reads a file chunk by chunk, also one that is being written. Goes on behind damage with the next
// complete chunk, after an Item::lost; its end is then `damaged`.
class RecordingReader {
 public:
  enum class End : std::uint8_t {
    none,     // there is more
    whole,    // it was ended
    open,     // it was not, without a partial chunk: it is being written, or the daemon was killed
    torn,     // the last chunk is incomplete
    damaged,  // bytes were changed, or not all chunks are there
  };

  // An error concerns the file as a whole.
  static tl::expected<RecordingReader, std::string> open(const std::filesystem::path& path);
  RecordingReader(RecordingReader&&) noexcept = default;

  const nlohmann::ordered_json& header() const noexcept { return header_; }
  // False: no more; end() says why. The bytes are valid until the next call.
  bool next(Item& kind, std::span<const std::uint8_t>& bytes);
  End end() const noexcept { return end_; }
  std::uint64_t offset() const noexcept { return offset_; }  // end of the complete chunks
  std::uint64_t size() const noexcept { return size_; }
  const std::string& trouble() const noexcept { return trouble_; }  // torn, damaged: what and where
  std::uint64_t torn_bytes() const noexcept { return torn_bytes_; }
  // The contents of the last chunk of an ended file, without reading the others.
  bool last_words(RecordingEnd& end) const;
  bool being_written() const;  // by a process that runs

 private:
  RecordingReader(File file, std::uint64_t size) : file_(std::move(file)), size_(size) {}
  tl::expected<void, std::string> read_header();
  bool next_item(Item& kind, std::span<const std::uint8_t>& bytes);
  bool next_chunk();
  bool read_chunk();
  bool skip_damage();
  bool find_chunk(std::uint64_t& at, std::uint32_t& index);
  void classify();
  std::uint64_t file_size() const;
  std::uint64_t end_of_use() const;
  bool looks_torn(std::uint64_t used) const;
  bool has_head(std::uint64_t from, std::uint64_t to) const;
  bool read_at(std::uint64_t offset, std::span<std::uint8_t> to) const;

  File file_;
  std::uint64_t size_, offset_ = 0;
  std::uint32_t index_ = 0;
  nlohmann::ordered_json header_;
  std::uint8_t kind_ = 0;
  std::vector<std::uint8_t> chunk_;
  std::size_t at_ = 0;
  End end_ = End::none;
  std::uint64_t torn_bytes_ = 0;
  std::string trouble_;
  // Of damage that was skipped.
  std::uint64_t missing_ = 0, searched_ = 0;  // chunks; bytes that were looked at
  std::string damage_;                        // the first; empty: none
};

// Truncates a file that was not ended after its last complete chunk, unless a process still writes
// it. Returns the torn bytes, 0 for unused room only; an error when it cannot be read, is damaged
// or cannot be cut.
tl::expected<std::uint64_t, std::string> cut_recording(const std::filesystem::path& path);

}  // namespace lss::record
