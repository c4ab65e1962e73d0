#pragma once

// Everything that is whole in an MCAP file, found from its begin on, so that a file that was torn,
// or is written just now, reads as well as one that has its summary. Checksums of chunks are
// compared. The file must stay as it is, or only grow, while this lives.

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tools/lss-cli/recording/mcap_format.h"

namespace lss::cli::recording {

// The whole of a file, mapped.
class MappedFile {
 public:
  // Throws a Failure that names the file.
  explicit MappedFile(const std::string& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  Octets data() const { return data_; }

 private:
  Octets data_;
};

struct RawMessage {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  std::int64_t log_ns = 0, publish_ns = 0;
  Octets data;
};
RawMessage read_message(Octets record);

struct Chunk {
  std::uint64_t offset = 0, length = 0;  // of the record, its head included
  std::int64_t first_ns = 0, last_ns = 0;
  std::uint64_t size = 0;                        // of its records
  std::map<std::uint16_t, std::uint64_t> index;  // channel to the offset of its MessageIndex
  std::uint64_t index_length = 0;
  Octets records;
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
  bool whole = false;            // it has its end: DataEnd, summary, footer
  std::string complaint;         // why the rest is left out; empty when whole

  // Of all chunks, in the order of the file.
  void each(const std::function<void(const RawMessage&)>& take) const;
};

// Throws a Failure when it is no MCAP file, or one that needs what we do not have.
Scan scan(const std::string& path, Octets file);

}  // namespace lss::cli::recording
