#pragma once

// Files of the flight recorder, ID-NUMBER-TIME-NAME.lssrec (docs/recording.md has the format to the
// octet): a header, then chunks with CRC-32C, in each some items. What is in a whole chunk is
// certain; what is not in one is not there. No DDS, no log, no thread of its own.

#include <array>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

namespace lss::record {

inline constexpr const char* kRecordingSuffix = ".lssrec";
inline constexpr std::uint32_t kRecordingFormat = 1;
// The first bytes of a file: no text, and a transfer that changes line ends is noticed.
inline constexpr std::array<std::uint8_t, 8> kRecordingMagic{0x89, 'L', 'S', 'S',
                                                             'R',  'E', 'C', '\n'};

enum class Item : std::uint8_t {
  frame = 1,  // a record, as fields() writes it (frame_record.h)
  state = 2,  // what the vehicle remembers after the frame before (state.h)
  lost = 3,   // so many frames are missing here: u64
};

std::uint32_t crc32c(std::span<const std::uint8_t> bytes);

// What the last chunk says of a file that was ended.
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
  // Everything that was added is with the kernel.
  int flush();
  int sync();  // ... and on the disk
  int end();   // flush, the last chunk, and what was allocated in vain is given back
  void abandon();
  bool removed() const;  // by somebody who wanted the room

  std::uint64_t size() const noexcept { return size_ + items_.size(); }
  std::size_t pending() const noexcept { return items_.size(); }             // bytes, until flush()
  std::uint64_t pending_frames() const noexcept { return pending_frames_; }  // lost without it
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

// Reads a file chunk by chunk, also one that is being written.
class RecordingReader {
 public:
  enum class End : std::uint8_t {
    none,     // there is more
    whole,    // it was ended
    open,     // it was not, and nothing is cut: it is being written, or the daemon was killed
    torn,     // the last chunk was not written to its end
    damaged,  // bytes were changed: not to be trusted
  };

  // An error says what is wrong with the file as a whole.
  static tl::expected<RecordingReader, std::string> open(const std::filesystem::path& path);
  RecordingReader(RecordingReader&& other) noexcept;
  RecordingReader& operator=(RecordingReader&&) = delete;
  ~RecordingReader();

  const nlohmann::ordered_json& header() const noexcept { return header_; }
  // False: no more; end() says why. The bytes are good until the next call.
  bool next(Item& kind, std::span<const std::uint8_t>& bytes);
  End end() const noexcept { return end_; }
  std::uint64_t offset() const noexcept { return offset_; }  // of the end of what is whole
  std::uint64_t size() const noexcept { return size_; }
  const std::string& trouble() const noexcept { return trouble_; }  // torn, damaged: what and where
  std::uint64_t torn_bytes() const noexcept { return torn_bytes_; }
  // What the last chunk of a file that was ended says, without reading the rest.
  bool last_words(RecordingEnd& end) const;

 private:
  RecordingReader(int fd, std::uint64_t size) : fd_(fd), size_(size) {}
  bool next_chunk();
  void classify();
  bool read_at(std::uint64_t offset, std::span<std::uint8_t> to) const;

  int fd_;
  std::uint64_t size_, offset_ = 0;
  std::uint32_t index_ = 0;
  nlohmann::ordered_json header_;
  std::uint8_t kind_ = 0;
  std::vector<std::uint8_t> chunk_;
  std::size_t at_ = 0;
  End end_ = End::none;
  std::uint64_t torn_bytes_ = 0;
  std::string trouble_;
};

// Cuts a file that was not ended behind its last whole chunk. How many bytes were torn: 0 when
// nothing but unused room was cut; an error when it cannot be read, is damaged or cannot be cut.
tl::expected<std::uint64_t, std::string> cut_recording(const std::filesystem::path& path);

}  // namespace lss::record
