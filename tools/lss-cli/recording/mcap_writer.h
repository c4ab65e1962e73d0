#pragma once

// One MCAP file being written: chunks with checksums and indexes, and at the end a summary. What is
// written stays readable whenever the program dies: chunks are whole, or cut off by the next
// append(). One thread. Trouble is thrown as a Failure that names the file; after one the file ends
// with its last whole chunk.

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tools/lss-cli/recording/mcap_scan.h"

namespace lss::cli::recording {

class McapWriter {
 public:
  // A new file; refuses one that is there.
  static McapWriter create(const std::string& path, const std::string& library);
  // Goes on with one of ours, whole or torn, keeping every whole chunk; a new one when there is
  // none. Refuses files of others, and one that another process writes.
  static McapWriter append(const std::string& path, const std::string& library);

  McapWriter(McapWriter&& other) noexcept;
  McapWriter& operator=(McapWriter&&) = delete;
  ~McapWriter();  // without close(): leaves the file as it is

  // The channel of that topic and schema, which may be there from before.
  std::uint16_t channel(const std::string& topic, const Schema& schema, const std::string& encoding,
                        const Texts& metadata);
  void metadata(const std::string& name, const Texts& values);
  // Into the chunk that is open.
  void write(const RawMessage& message);
  // Ends the chunk that is open: from here on it survives us.
  void end_chunk();
  // Puts on the disk what was written.
  void sync();
  // Ends the chunk and the file.
  void close();

  // Of the file when it would be closed now.
  std::uint64_t size() const;
  std::size_t open_chunk_size() const { return records_.size(); }
  // Of the chunks that are in the file, those of earlier runs included.
  const ChannelSpan& span(std::uint16_t channel) { return scan_.spans[channel]; }
  const Span& all() const { return scan_.all; }
  std::uint64_t cut() const { return cut_; }  // octets that append() could not keep

 private:
  McapWriter(std::string path, int fd) : path_(std::move(path)), fd_(fd) {}

  void begin(const std::string& library);
  void resume();  // the header stays as it is
  void put(const Writer& data);
  void put_record(Opcode opcode, const Writer& content);
  Writer message_indexes(Chunk& chunk, std::uint64_t at);
  void count(Octets records);
  Writer summary(std::uint64_t start) const;
  [[noreturn]] void fail(const char* what, int error);

  std::string path_;
  int fd_ = -1;
  std::uint64_t at_ = 0, cut_ = 0;
  Crc crc_;
  Scan scan_;  // of all that is in the file, without the data
  std::uint64_t summary_size_ = 0;

  Writer records_;  // of the chunk that is open
  Span chunk_;
  std::map<std::uint16_t, Writer> index_;
};

}  // namespace lss::cli::recording
