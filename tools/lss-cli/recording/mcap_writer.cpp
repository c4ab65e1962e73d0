#include "tools/lss-cli/recording/mcap_writer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "tools/lss-cli/show/failure.h"

namespace lss::cli::recording {
namespace {

constexpr const char* kNoCompression = "";

Writer schema_record(std::uint16_t id, const Schema& schema) {
  return Writer::of(id, schema.name, schema.encoding, schema.text);
}

Writer channel_record(std::uint16_t id, const Channel& channel) {
  return Writer::of(id, channel.schema, channel.topic, channel.encoding, channel.metadata);
}

Writer chunk_index_record(const Chunk& chunk) {
  Writer index;
  for (const auto& [channel, offset] : chunk.index) index.add(channel, offset);
  return Writer::of(chunk.first_ns, chunk.last_ns, chunk.offset, chunk.length, index.str(),
                    chunk.index_length, kNoCompression, chunk.size, chunk.size);
}

Writer statistics_record(const Scan& scan) {
  Writer counts;
  for (const auto& [channel, span] : scan.spans) counts.add(channel, span.messages);
  constexpr std::uint32_t kAttachments = 0;
  return Writer::of(scan.all.messages, static_cast<std::uint16_t>(scan.schemas.size()),
                    static_cast<std::uint32_t>(scan.channels.size()), kAttachments,
                    static_cast<std::uint32_t>(scan.metadata.size()),
                    static_cast<std::uint32_t>(scan.chunks.size()), scan.all.first_ns,
                    scan.all.last_ns, counts.str());
}

// For a chunk with none or only some.
std::map<std::uint16_t, Writer> index_of(const Chunk& chunk) {
  std::map<std::uint16_t, Writer> index;
  each_message(chunk.records, [&](const RawMessage& message, std::uint64_t at) {
    index[message.channel].add(message.log_ns, at);
  });
  return index;
}

File open_file(const std::string& path, int flags) {
  File file(open(path.c_str(), O_RDWR | O_CLOEXEC | flags, 0644));
  if (!file) {
    const int error = errno;
    throw Failure(ExitCode::usage, fmt::format("{}: {}", path, std::strerror(error)),
                  error == EEXIST ? "go on with it by --append, or name another file"
                                  : "name a file in a folder that you may write to: --out FILE");
  }
  if (flock(file.get(), LOCK_EX | LOCK_NB) != 0) {
    throw Failure(ExitCode::usage, path + " is being written by another process",
                  "let it end, or name another file: --out FILE");
  }
  return file;
}

}  // namespace

McapWriter McapWriter::create(const std::string& path, const std::string& library,
                              const std::string& profile) {
  McapWriter writer(path, open_file(path, O_CREAT | O_EXCL));
  writer.begin(library, profile);
  return writer;
}

McapWriter McapWriter::append(const std::string& path, const std::string& library,
                              const std::string& profile) {
  McapWriter writer(path, open_file(path, O_CREAT));
  std::array<char, kMagic.size()> begin{};
  const ssize_t got = pread(writer.file_.get(), begin.data(), begin.size(), 0);
  if (got > 0 && !kMagic.starts_with({begin.data(), static_cast<std::size_t>(got)}))
    throw Failure(ExitCode::usage, path + " is no MCAP file", "name another file: --out FILE");
  // A file shorter than a header is empty.
  if (lseek(writer.file_.get(), 0, SEEK_END) <= static_cast<off_t>(kMagic.size() + kRecordHead)) {
    if (ftruncate(writer.file_.get(), 0) != 0 || lseek(writer.file_.get(), 0, SEEK_SET) != 0)
      writer.fail("cannot be cut", errno);
    writer.begin(library, profile);
  } else {
    writer.resume();
  }
  return writer;
}

void McapWriter::begin(const std::string& library, const std::string& profile) {
  Writer head;
  head.raw(bytes_of(kMagic));
  put(head);
  put_record(kHeader, Writer::of(profile, library));
}

void McapWriter::resume() {
  const MappedFile file(path_);
  scan_ = scan(path_, file.data());
  if (!scan_.library.starts_with(kLibrary)) {
    throw Failure(ExitCode::usage,
                  fmt::format("{} was made by '{}', not by lss-cli", path_, scan_.library),
                  "only files of lss-cli record can be gone on with; name another one");
  }
  if (scan_.damaged) {
    throw Failure(ExitCode::failed,
                  fmt::format("{} is damaged at byte {} of {}: going on would remove what follows",
                              path_, scan_.end, file.data().size()),
                  "name another file: --out FILE; see what can be read with: lss-cli log list");
  }
  if (!scan_.whole) cut_ = file.data().size() - scan_.end;
  at_ = scan_.end;
  // Only the last chunk may lack its indexes; they are then added at the end of the file.
  std::map<std::uint16_t, Writer> index;
  if (!scan_.chunks.empty()) index = index_of(scan_.chunks.back());
  const bool without_index =
      !scan_.chunks.empty() && index.size() != scan_.chunks.back().index.size();
  if (without_index) at_ = scan_.chunks.back().offset + scan_.chunks.back().length;
  crc_.add(file.data().first(at_));
  if (ftruncate(file_.get(), static_cast<off_t>(at_)) != 0 ||
      lseek(file_.get(), static_cast<off_t>(at_), SEEK_SET) < 0) {
    fail("cannot be cut", errno);
  }
  if (without_index) {
    index_ = std::move(index);
    scan_.chunks.back().index.clear();
    const Writer out = message_indexes(scan_.chunks.back(), at_);
    index_.clear();
    put(out);
  }
  for (Chunk& chunk : scan_.chunks) {
    summary_size_ += kRecordHead + chunk_index_record(chunk).size();
    chunk.records = {};  // destroyed with the mapping
  }
}

void McapWriter::fail(const char* what, int error) {
  // No partial chunk: a reader must find complete chunks only.
  [[maybe_unused]] const int cut = ftruncate(file_.get(), static_cast<off_t>(at_));
  lseek(file_.get(), static_cast<off_t>(at_), SEEK_SET);
  throw Failure(ExitCode::failed, fmt::format("{} {}: {}", path_, what, std::strerror(error)),
                error == ENOSPC || error == EFBIG || error == EDQUOT
                    ? "make room; what was recorded until here is in the file"
                    : "what was recorded until here is in the file");
}

void McapWriter::put(const Writer& data) {
  Bytes left = data.data();
  while (!left.empty()) {
    const ssize_t written = ::write(file_.get(), left.data(), left.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail("cannot be written", written < 0 ? errno : ENOSPC);
    left = left.subspan(static_cast<std::size_t>(written));
  }
  crc_.add(data.data());
  at_ += data.size();
}

void McapWriter::put_record(std::uint8_t opcode, const Writer& content) {
  Writer out;
  out.record(opcode, content);
  put(out);
}

std::uint16_t McapWriter::channel(const std::string& topic, const Schema& schema,
                                  const std::string& encoding, const Texts& metadata) {
  std::uint16_t schema_id = 0;
  for (const auto& [id, known] : scan_.schemas) {
    if (known.name == schema.name && known.text == schema.text) schema_id = id;
  }
  for (const auto& [id, known] : scan_.channels) {
    if (schema_id != 0 && known.schema == schema_id && known.topic == topic) return id;
  }
  end_chunk();
  if (schema_id == 0) {
    schema_id = static_cast<std::uint16_t>(scan_.schemas.size() + 1);  // 0: no schema
    scan_.schemas[schema_id] = schema;
    put_record(kSchema, schema_record(schema_id, schema));
  }
  const auto id = static_cast<std::uint16_t>(scan_.channels.size() + 1);
  scan_.channels[id] = {schema_id, topic, encoding, metadata};
  put_record(kChannel, channel_record(id, scan_.channels[id]));
  return id;
}

void McapWriter::metadata(const std::string& name, const Texts& values) {
  end_chunk();
  const std::uint64_t offset = at_;
  put_record(kMetadataRecord, Writer::of(name, values));
  scan_.metadata.push_back({offset, at_ - offset, name, values});
}

void McapWriter::write(const RawMessage& message) {
  Writer content =
      Writer::of(message.channel, message.sequence, message.log_ns, message.publish_ns);
  content.raw(message.data);
  index_[message.channel].add(message.log_ns, static_cast<std::uint64_t>(records_.size()));
  records_.record(kMessage, content);
  chunk_.add(message.log_ns);
}

// Of the chunk, to stand at `at`.
Writer McapWriter::message_indexes(Chunk& chunk, std::uint64_t at) {
  Writer out;
  for (const auto& [channel, entries] : index_) {
    chunk.index[channel] = at + out.size();
    out.record(kMessageIndex, Writer::of(channel, entries.str()));
  }
  chunk.index_length = out.size();
  return out;
}

void McapWriter::end_chunk() {
  if (records_.size() == 0) return;
  Writer content =
      Writer::of(chunk_.first_ns, chunk_.last_ns, static_cast<std::uint64_t>(records_.size()),
                 crc_of(records_.data()), kNoCompression);
  content.block(records_.data());
  Writer out;
  out.record(kChunk, content);
  Chunk chunk{at_, out.size(), chunk_.first_ns, chunk_.last_ns, records_.size(), {}, 0, {}};
  out.raw(message_indexes(chunk, at_ + out.size()).data());
  const Writer records = std::exchange(records_, {});
  chunk_ = {};
  index_.clear();
  put(out);  // otherwise it is lost as a whole
  each_message(records.data(),
               [this](const RawMessage& message, std::uint64_t) { scan_.count(message); });
  summary_size_ += kRecordHead + chunk_index_record(chunk).size();
  scan_.chunks.push_back(std::move(chunk));
}

void McapWriter::sync() {
  if (fdatasync(file_.get()) != 0 && errno != EINVAL && errno != EROFS)
    fail("cannot be synced", errno);
}

std::uint64_t McapWriter::size() const {
  constexpr std::uint64_t kSchemasAndChannels = 64 * 1024;
  if (!file_) return at_;
  return at_ + records_.size() + summary_size_ + kSchemasAndChannels;
}

Writer McapWriter::summary(std::uint64_t start) const {
  Writer out, offsets;
  const auto group = [&](std::uint8_t opcode, const auto& put_group) {
    const std::uint64_t begin = out.size();
    put_group();
    if (out.size() == begin) return;
    offsets.record(kSummaryOffset, Writer::of(opcode, start + begin,
                                              static_cast<std::uint64_t>(out.size() - begin)));
  };
  group(kSchema, [&] {
    for (const auto& [id, schema] : scan_.schemas) out.record(kSchema, schema_record(id, schema));
  });
  group(kChannel, [&] {
    for (const auto& [id, channel] : scan_.channels)
      out.record(kChannel, channel_record(id, channel));
  });
  group(kStatistics, [&] { out.record(kStatistics, statistics_record(scan_)); });
  group(kChunkIndex, [&] {
    for (const Chunk& chunk : scan_.chunks) out.record(kChunkIndex, chunk_index_record(chunk));
  });
  group(kMetadataIndex, [&] {
    for (const MetadataAt& metadata : scan_.metadata)
      out.record(kMetadataIndex, Writer::of(metadata.offset, metadata.length, metadata.name));
  });
  const std::uint64_t offsets_start = start + out.size();
  out.raw(offsets.data());
  // The footer up to its checksum, which covers all of this.
  out.add(kFooter, static_cast<std::uint64_t>(kFooterSize - kRecordHead), start, offsets_start);
  out.number(crc_of(out.data()));
  out.raw(bytes_of(kMagic));
  return out;
}

void McapWriter::close() {
  if (!file_) return;
  end_chunk();
  const std::uint64_t end = at_;
  Writer out;
  out.record(kDataEnd, Writer::of(crc_.value()));
  out.raw(summary(at_ + out.size()).data());
  try {
    put(out);
    sync();
  } catch (const Failure& e) {
    at_ = end;
    throw Failure(e.code(), e.what(), "make room, then: lss-cli record --append ends it whole");
  }
  file_ = File();
}

}  // namespace lss::cli::recording
