#include "tools/lss-cli/recording/mcap_scan.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "tools/lss-cli/show/failure.h"

namespace lss::cli::recording {
namespace {

struct Record {
  std::uint8_t opcode = 0;
  Bytes content;
};

Record next(Reader& reader) {
  Record record;
  record.opcode = reader.number<std::uint8_t>();
  record.content = reader.block();
  return record;
}

[[noreturn]] void refuse(const std::string& what) {
  throw Failure(ExitCode::usage, what, "was it made by lss-cli record?");
}

// Of schemas, channels and metadata, which stay in memory.
void add_description(Bytes content, Scan& scan) {
  scan.descriptions += content.size();
  if (scan.descriptions > most::kDescriptions)
    refuse(fmt::format("its schemas, channels and metadata have more than {} bytes",
                       most::kDescriptions));
}

void check_name(const std::string& name, const char* of_what) {
  if (name.size() > most::kName)
    refuse(fmt::format("the name of its {} has {} characters, at most {} are read", of_what,
                       name.size(), most::kName));
}

void take_schema(Bytes content, Scan& scan) {
  add_description(content, scan);
  Reader in(content);
  const auto id = in.number<std::uint16_t>();
  Schema& schema = scan.schemas[id];
  schema.name = in.text();
  schema.encoding = in.text();
  schema.text = in.text();
  check_name(schema.name, "schema");
  check_name(schema.encoding, "encoding");
}

void take_channel(Bytes content, Scan& scan) {
  add_description(content, scan);
  Reader in(content);
  const auto id = in.number<std::uint16_t>();
  Channel& channel = scan.channels[id];
  channel.schema = in.number<std::uint16_t>();
  channel.topic = in.text();
  channel.encoding = in.text();
  channel.metadata = in.texts();
  if (scan.channels.size() > most::kChannels)
    refuse(fmt::format("it has more than {} channels", most::kChannels));
  check_name(channel.topic, "topic");
  check_name(channel.encoding, "encoding");
}

RawMessage read_message(Bytes record) {
  Reader in(record);
  return {.channel = in.number<std::uint16_t>(),
          .sequence = in.number<std::uint32_t>(),
          .log_ns = in.number<std::int64_t>(),
          .publish_ns = in.number<std::int64_t>(),
          .data = in.rest()};
}

// Throws Torn when it is not as expected.
Chunk read_chunk(Bytes content) {
  Reader in(content);
  Chunk chunk;
  chunk.first_ns = in.number<std::int64_t>();
  chunk.last_ns = in.number<std::int64_t>();
  chunk.size = in.number<std::uint64_t>();
  const auto crc = in.number<std::uint32_t>();
  const std::string compression = in.text();
  if (!compression.empty()) {
    throw Failure(ExitCode::usage,
                  "its chunks are compressed by " + compression.substr(0, most::kName),
                  "decompress it first: mcap compress --compression none FILE -o OTHER");
  }
  chunk.records = in.block();
  if (chunk.records.size() != chunk.size || (crc != 0 && crc_of(chunk.records) != crc))
    throw Torn();
  return chunk;
}

void take_chunk(const Chunk& chunk, Scan& scan) {
  Reader records(chunk.records);
  while (!records.empty()) {
    const Record record = next(records);
    if (record.opcode == kSchema) take_schema(record.content, scan);
    if (record.opcode == kChannel) take_channel(record.content, scan);
    if (record.opcode == kMessage) scan.count(read_message(record.content));
  }
  if (scan.chunks.size() == most::kChunks)
    refuse(fmt::format("it has more than {} chunks", most::kChunks));
  scan.chunks.push_back(chunk);
}

void take_metadata(Bytes content, std::uint64_t offset, std::uint64_t length, Scan& scan) {
  add_description(content, scan);
  Reader in(content);
  MetadataAt& metadata = scan.metadata.emplace_back();
  metadata.offset = offset;
  metadata.length = length;
  metadata.name = in.text();
  metadata.values = in.texts();
}

// False at the end of the data section.
bool take(const Record& record, std::uint64_t offset, std::uint64_t length, Scan& scan) {
  switch (record.opcode) {
    case kHeader: {
      add_description(record.content, scan);
      Reader in(record.content);
      in.text();  // profile
      scan.library = in.text();
      break;
    }
    case kSchema: take_schema(record.content, scan); break;
    case kChannel: take_channel(record.content, scan); break;
    case kMessage:  // without a chunk: treated as a chunk of its own
      throw Failure(ExitCode::usage, "it has messages outside of chunks",
                    "put them into chunks first: mcap filter FILE -o OTHER");
    case kChunk: {
      Chunk chunk = read_chunk(record.content);
      chunk.offset = offset;
      chunk.length = length;
      take_chunk(chunk, scan);
      break;
    }
    case kMessageIndex:
      if (!scan.chunks.empty()) {
        Chunk& chunk = scan.chunks.back();
        chunk.index[Reader(record.content).number<std::uint16_t>()] = offset;
        chunk.index_length += length;
      }
      break;
    case kMetadataRecord: take_metadata(record.content, offset, length, scan); break;
    case kDataEnd: return false;
    default: break;  // unknown records are skipped, as the format requires
  }
  return true;
}

bool ends_whole(Bytes file, std::uint64_t data_end) {
  if (file.size() < data_end + kFooterSize + kMagic.size()) return false;
  const Bytes magic = file.last(kMagic.size());
  const Bytes footer = file.last(kMagic.size() + kFooterSize).first(kFooterSize);
  return std::memcmp(magic.data(), kMagic.data(), kMagic.size()) == 0 &&
         footer.front() == std::byte{kFooter};
}

}  // namespace

MappedFile::MappedFile(const std::string& path) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // a pipe is rejected
  struct stat info {};
  const bool there = fd >= 0 && fstat(fd, &info) == 0;
  int error = there ? 0 : errno;
  if (there && !S_ISREG(info.st_mode)) error = EISDIR;
  if (error == 0 && info.st_size > 0) {
    const auto size = static_cast<std::size_t>(info.st_size);
    void* at = mmap(nullptr, size, PROT_READ, MAP_SHARED, fd, 0);
    if (at == MAP_FAILED) {
      error = errno;
    } else {
      data_ = {static_cast<const std::byte*>(at), size};
    }
  }
  if (fd >= 0) close(fd);
  if (error != 0) {
    throw Failure(ExitCode::usage, fmt::format("{}: {}", path, std::strerror(error)),
                  "name a file that lss-cli record made");
  }
}

MappedFile::~MappedFile() {
  // Mapped read-only, but munmap takes a pointer to non-const.
  if (!data_.empty()) munmap(const_cast<std::byte*>(data_.data()), data_.size());
}

void each_message(Bytes records,
                  const std::function<void(const RawMessage&, std::uint64_t at)>& take) {
  Reader reader(records);
  while (!reader.empty()) {
    const std::uint64_t at = reader.at();
    const Record record = next(reader);
    if (record.opcode == kMessage) take(read_message(record.content), at);
  }
}

void Scan::count(const RawMessage& message) {
  ChannelSpan& span = spans[message.channel];
  span.add(message.log_ns);
  span.published_ns = std::max(span.published_ns, message.publish_ns);
  span.sequence = message.sequence;
  all.add(message.log_ns);
}

void Scan::each(const std::function<void(const RawMessage&)>& take) const {
  for (const Chunk& chunk : chunks)
    each_message(chunk.records, [&](const RawMessage& message, std::uint64_t) { take(message); });
}

Scan scan(const std::string& path, Bytes file) {
  Scan result;
  if (file.size() < kMagic.size() || std::memcmp(file.data(), kMagic.data(), kMagic.size()) != 0) {
    throw Failure(ExitCode::usage, path + " is no MCAP file",
                  "name a file that lss-cli record wrote");
  }
  Reader reader(file);
  reader.take(kMagic.size());
  result.end = reader.at();
  std::size_t behind = 0;  // bytes that follow the record
  try {
    while (true) {
      const std::uint64_t offset = reader.at();
      behind = 0;
      if (reader.empty()) {
        result.complaint = "it has no end: its recorder was killed, or writes just now";
        return result;
      }
      const Record record = next(reader);
      behind = file.size() - reader.at();
      if (!take(record, offset, reader.at() - offset, result)) break;
      result.end = reader.at();
    }
    result.whole = ends_whole(file, reader.at());
    if (!result.whole) result.complaint = "its summary is torn";
  } catch (const Torn&) {
    result.complaint = fmt::format("it is torn or damaged at byte {}", result.end);
    result.damaged = behind > 0 || ends_whole(file, result.end);
  } catch (const Failure& e) {
    throw Failure(e.code(), fmt::format("{}: {}", path, e.what()), e.advice());
  }
  return result;
}

}  // namespace lss::cli::recording
