#include "tools/lss-cli/recording/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>

#include "tools/lss-cli/recording/mcap_writer.h"
#include "tools/lss-cli/show/failure.h"
#include "tools/lss-cli/show/names.h"

namespace lss::cli::recording {
namespace {

class McapRecording : public Recording {
 public:
  explicit McapRecording(const std::string& path) : file_(path), scan_(scan(path, file_.data())) {
    topics_.reserve(scan_.channels.size());
    for (const auto& [id, channel] : scan_.channels) {
      Topic& topic = topics_.emplace_back();
      const Schema& schema = scan_.schemas[channel.schema];
      topic.name = channel.topic;
      topic.type_name = schema.name;
      topic.encoding = schema.encoding + ", " + channel.encoding;
      if (const auto span = scan_.spans.find(id); span != scan_.spans.end())
        topic.span = span->second;
      topic.layout = layout(path, schema, channel);
      by_id_[id] = &topic;
    }
    for (const MetadataAt& metadata : scan_.metadata) {
      if (metadata.name == kMetadata) about_.insert(metadata.values.begin(), metadata.values.end());
    }
    count_gaps();
  }

  const char* kind() const override { return "mcap"; }
  const std::vector<Topic>& topics() const override { return topics_; }
  const Span& span() const override { return scan_.all; }
  using Recording::about;
  const Texts& about() const override { return about_; }
  const std::string& complaint() const override { return scan_.complaint; }

  void each(const Filter& filter, const std::function<void(const Message&)>& take) const override {
    each_raw(filter, [&](const RawMessage& raw, const Topic& topic) {
      if (topic.layout != nullptr) topic.layout->check(raw.data);
      take({topic, raw.sequence, raw.log_ns, raw.publish_ns, raw.data});
    });
  }

  std::uint64_t copy(const Filter& filter, const std::string& path) const override {
    McapWriter writer = McapWriter::create(path, scan_.library);
    try {
      return copy_into(writer, filter);
    } catch (...) {  // or the next try finds it there
      std::error_code ignored;
      std::filesystem::remove(path, ignored);
      throw;
    }
  }

 private:
  std::uint64_t copy_into(McapWriter& writer, const Filter& filter) const {
    for (const MetadataAt& metadata : scan_.metadata)
      writer.metadata(metadata.name, metadata.values);
    std::map<std::uint16_t, std::uint16_t> ids;
    for (const Topic* topic : select(*this, filter)) {
      for (const auto& [id, known] : by_id_) {
        if (known != topic) continue;
        const Channel& channel = scan_.channels.at(id);
        ids[id] = writer.channel(channel.topic, scan_.schemas.at(channel.schema), channel.encoding,
                                 channel.metadata);
      }
    }
    constexpr std::size_t kChunk = 1024 * 1024;
    each_raw(filter, [&](RawMessage raw, const Topic&) {
      raw.channel = ids.at(raw.channel);
      writer.write(raw);
      if (writer.open_chunk_size() > kChunk) writer.end_chunk();
    });
    writer.close();
    return writer.all().messages;
  }

  void each_raw(const Filter& filter,
                const std::function<void(const RawMessage&, const Topic&)>& take) const {
    const std::vector<const Topic*> list = select(*this, filter);
    const std::set<const Topic*> wanted(list.begin(), list.end());
    scan_.each([&](const RawMessage& raw) {
      const auto topic = by_id_.find(raw.channel);
      if (topic == by_id_.end() || !wanted.contains(topic->second)) return;
      const double at_s = seconds(raw.log_ns);
      if (at_s >= filter.from_s && at_s <= filter.until_s) take(raw, *topic->second);
    });
  }

  const Layout* layout(const std::string& path, const Schema& schema, const Channel& channel) {
    if (schema.encoding != "omgidl" || channel.encoding != "cdr") return nullptr;
    try {
      auto& types = types_[schema.text];
      if (types == nullptr) types = std::make_unique<Types>(schema.text);
      const Type* type = types->find(schema.name);
      if (type == nullptr || type->kind != Kind::structure) return nullptr;
      auto& layout = layouts_[type];
      if (layout != nullptr) return layout.get();
      columns_ += type->columns;
      if (columns_ > most::kColumns) {
        throw Failure(ExitCode::usage,
                      fmt::format("its topics have more than {} columns", most::kColumns),
                      "was it made by lss-cli record?");
      }
      layout = std::make_unique<Layout>(*type);
      return layout.get();
    } catch (const Failure& e) {
      throw Failure(e.code(), fmt::format("{}: {}", path, e.what()), e.advice());
    }
  }

  // Heartbeats count separately for each source, events for each id and subject.
  void count_gaps() {
    std::map<std::string, std::uint64_t> last;
    scan_.each([&](const RawMessage& raw) {
      const auto found = by_id_.find(raw.channel);
      if (found == by_id_.end() || found->second->layout == nullptr) return;
      Topic& topic = *found->second;
      const Column* counter = counter_of(*topic.layout);
      if (counter == nullptr) return;
      topic.layout->check(raw.data);
      std::string key = topic.name;
      const std::string& type = topic.layout->type().name;
      if (const Column* source = type == "lss::Heartbeat" ? topic.layout->find("source") : nullptr)
        key += topic.layout->text(*source, raw.data);
      for (const char* name : {"id", "subject"}) {
        const Column* column = type == "lss::Event" ? topic.layout->find(name) : nullptr;
        if (column != nullptr) key += ' ' + topic.layout->json(*column, raw.data).dump();
      }
      const auto now = topic.layout->json(*counter, raw.data).get<std::uint64_t>();
      const auto [before, first] = last.try_emplace(key, now);
      if (!first && now > before->second) topic.gaps += now - before->second - 1;
      before->second = now;
    });
  }

  MappedFile file_;
  Scan scan_;
  std::vector<Topic> topics_;
  std::map<std::uint16_t, Topic*> by_id_;
  std::map<std::string, std::unique_ptr<Types>> types_;
  std::map<const Type*, std::unique_ptr<Layout>> layouts_;
  std::size_t columns_ = 0;  // of all layouts
  Texts about_;
};

}  // namespace

// After a mismatch the last `*` takes one more character: the time is at most pattern length times
// text length.
bool matches(std::string_view pattern, std::string_view text) {
  std::size_t p = 0, t = 0, star = std::string_view::npos, from = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      from = t;
    } else if (p < pattern.size() && pattern[p] == text[t]) {
      ++p;
      ++t;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      t = ++from;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

bool names(std::string_view wanted, std::string_view topic) {
  const std::string full = "lss/" + std::string(wanted);
  return matches(wanted, topic) || matches(full, topic) || topic.starts_with(full + "/");
}

std::vector<const Topic*> select(const Recording& recording, const Filter& filter) {
  std::vector<const Topic*> list;
  for (const Topic& topic : recording.topics()) {
    const auto is_meant = [&](const std::string& wanted) { return names(wanted, topic.name); };
    if (filter.topics.empty() || std::ranges::any_of(filter.topics, is_meant))
      list.push_back(&topic);
  }
  std::vector<std::string> known;
  for (const Topic& topic : recording.topics()) known.push_back(topic.name);
  for (const std::string& wanted : filter.topics) {
    const auto is_known = [&](const std::string& name) { return names(wanted, name); };
    if (std::ranges::any_of(known, is_known)) continue;
    const std::string guess = did_you_mean(wanted, known);
    throw Failure(ExitCode::unknown_name, fmt::format("there is no topic '{}' in it", wanted),
                  guess.empty() ? fmt::format("there are: {}", fmt::join(known, ", ")) : guess);
  }
  return list;
}

const Column* counter_of(const Layout& layout) {
  for (const char* name : {"frame", "number", "index", "counter"}) {
    const Column* column = layout.find(name);
    if (column != nullptr && column->type->kind == Kind::uint64) return column;
  }
  return nullptr;
}

bool begins_with(const std::string& path, Bytes magic) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;  // a pipe may deliver nothing
  std::ifstream file(path, std::ios::binary);
  std::string begin(magic.size(), '\0');
  file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return file.gcount() == static_cast<std::streamsize>(begin.size()) &&
         std::ranges::equal(bytes_of(begin), magic);
}

bool is_recording(const std::string& path) { return begins_with(path, bytes_of(kMagic)); }

std::unique_ptr<Recording> open(const std::string& path) {
  return std::make_unique<McapRecording>(path);
}

}  // namespace lss::cli::recording
