#pragma once

// Finds all complete records of an MCAP file from its beginning, so that a torn file, or one being
// written, can be read like one with a summary. Verifies the checksums of chunks. The file must
// stay unchanged, or only grow, during the lifetime of this object.

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tools/lss-cli/recording/mcap_format.h"

namespace lss::cli::recording {

// A whole file, mapped.
class MappedFile {
 public:
  // Throws a Failure that names the file.
  explicit MappedFile(const std::string& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  Bytes data() const { return data_; }

 private:
  Bytes data_;
};

struct RawMessage {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  std::int64_t log_ns = 0, publish_ns = 0;
  Bytes data;
};
// Each message of a chunk, with its place among the chunk's records.
void each_message(Bytes records,
                  const std::function<void(const RawMessage&, std::uint64_t at)>& take);

struct Chunk {
  std::uint64_t offset = 0, length = 0;  // of the record, its head included
  std::int64_t first_ns = 0, last_ns = 0;
  std::uint64_t size = 0;                        // of its records
  std::map<std::uint16_t, std::uint64_t> index;  // channel to the offset of its MessageIndex
  std::uint64_t index_length = 0;
  Bytes records;
};

struct MetadataAt {
  std::uint64_t offset = 0, length = 0;
  std::string name;
  Texts values;
};

struct ChannelSpan : Span {
  std::int64_t published_ns = 0;  // the last
  std::uint32_t sequence = 0;     // the last
};

struct Scan {
  std::string library;
  std::map<std::uint16_t, Schema> schemas;
  std::map<std::uint16_t, Channel> channels;
  std::map<std::uint16_t, ChannelSpan> spans;
  std::vector<Chunk> chunks;
  std::vector<MetadataAt> metadata;
  Span all;
  std::size_t descriptions = 0;  // bytes of schemas, channels and metadata
  std::uint64_t end = 0;         // of the last whole record of the data section
  bool whole = false;            // it has DataEnd, summary and footer
  bool damaged = false;          // not torn: more follows what cannot be read
  std::string complaint;         // why the remaining part is left out; empty when complete

  void count(const RawMessage& message);
  // Of all chunks, in the order of the file.
  void each(const std::function<void(const RawMessage&)>& take) const;
};

// Throws a Failure when it is no MCAP file, or needs an unsupported feature.
Scan scan(const std::string& path, Bytes file);

}  // namespace lss::cli::recording
