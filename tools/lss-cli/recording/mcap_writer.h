#pragma once

// Writes one MCAP file: chunks with checksums and indexes, and at the end a summary. The file stays
// readable when the program is killed at any time: chunks are complete, or removed by the next
// append(). One thread. Errors are thrown as a Failure that names the file; after an error the file
// ends with its last complete chunk.

#include <map>
#include <string>

#include "drivers/file.h"
#include "tools/lss-cli/recording/mcap_scan.h"

namespace lss::cli::recording {

class McapWriter {
 public:
  // A new file; throws when it exists. `profile`: "ros2" when it has messages of ROS 2.
  static McapWriter create(const std::string& path, const std::string& library,
                           const std::string& profile = "");
  // Continues a file of ours, complete or torn, with all its complete chunks; a new file when there
  // is none. Throws for foreign files, for a file that another process writes, and for one that is
  // damaged before its end.
  static McapWriter append(const std::string& path, const std::string& library,
                           const std::string& profile = "");

  // The channel of that topic and schema, which may exist already.
  std::uint16_t channel(const std::string& topic, const Schema& schema, const std::string& encoding,
                        const Texts& metadata);
  void metadata(const std::string& name, const Texts& values);
  // Into the chunk that is open.
  void write(const RawMessage& message);
  // Ends the open chunk: from here on it survives the process.
  void end_chunk();
  // Syncs the written data to the disk.
  void sync();
  // Ends the chunk and the file.
  void close();

  // Size of the file if it were closed now.
  std::uint64_t size() const;
  std::size_t open_chunk_size() const { return records_.size(); }
  // Of the chunks that are in the file, those of earlier runs included.
  const ChannelSpan& span(std::uint16_t channel) { return scan_.spans[channel]; }
  const Span& all() const { return scan_.all; }
  // Of the file so far, that of earlier runs included.
  const std::vector<MetadataAt>& all_metadata() const { return scan_.metadata; }
  std::uint64_t cut() const { return cut_; }  // bytes that append() had to remove

 private:
  McapWriter(std::string path, File file) : path_(std::move(path)), file_(std::move(file)) {}

  void begin(const std::string& library, const std::string& profile);
  void resume();  // the header stays unchanged
  void put(const Writer& data);
  void put_record(std::uint8_t opcode, const Writer& content);
  Writer message_indexes(Chunk& chunk, std::uint64_t at);
  Writer summary(std::uint64_t start) const;
  [[noreturn]] void fail(const char* what, int error);

  std::string path_;
  File file_;  // destroyed without close(): it has its complete chunks
  std::uint64_t at_ = 0, cut_ = 0;
  Crc crc_;
  Scan scan_;  // of all that is in the file, without the data
  std::uint64_t summary_size_ = 0;

  Writer records_;  // of the chunk that is open
  Span chunk_;
  std::map<std::uint16_t, Writer> index_;
};

}  // namespace lss::cli::recording
