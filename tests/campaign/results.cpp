#include "tests/campaign/results.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace lss::campaign {
namespace {

using Json = nlohmann::ordered_json;

// The members of a summary that a file has, each with its name.
template <class Visitor, class Of>
void visit(Visitor&& v, Of& s) {
  v("runs", s.runs), v("broken", s.broken), v("frames", s.frames), v("faults", s.faults);
  v("commands", s.commands), v("rejected", s.rejected), v("stops", s.stops);
  v("simulated_s", s.simulated_s), v("cpu_s", s.cpu_s);
  v("slowest_rest_s", s.slowest_rest_s), v("slowest_cut_rest_s", s.slowest_cut_rest_s);
  v("slowest_idle_s", s.slowest_idle_s), v("outcomes", s.outcomes), v("complaints", s.complaints);
}

const Subject& subject_of(const std::string& vehicle) {
  const auto all = subjects();
  const auto found = std::ranges::find(all, vehicle, &Subject::vehicle);
  if (found == all.end())
    throw std::runtime_error(fmt::format("has {}, which is not in this program", vehicle));
  return *found;
}

}  // namespace

Shard parse_shard(const std::string& text) {
  Shard shard;
  const char* const end = text.data() + text.size();
  const auto number = std::from_chars(text.data(), end, shard.number);
  const bool slash = number.ec == std::errc() && number.ptr != end && *number.ptr == '/';
  const auto of = slash ? std::from_chars(number.ptr + 1, end, shard.of) : number;
  if (!slash || of.ec != std::errc() || of.ptr != end || shard.number < 1 ||
      shard.number > shard.of)
    throw std::runtime_error(fmt::format("\"{}\" is no shard: I/N, with I from 1 to N", text));
  return shard;
}

std::string to_text(const Results& results) {
  Json json = {
      {"lss", "campaign"},        {"commit", results.commit},      {"first", results.first},
      {"runs", results.runs},     {"shard", results.shard.number}, {"of", results.shard.of},
      {"vehicles", Json::array()}};
  for (const Summary& summary : results.summaries) {
    Json one = {{"vehicle", summary.subject.vehicle}};
    visit([&](const char* name, const auto& value) { one[name] = value; }, summary);
    json["vehicles"].push_back(std::move(one));
  }
  return json.dump(1) + '\n';
}

Results from_text(const std::string& text, const std::string& name) {
  try {
    const Json json = Json::parse(text);
    if (json.at("lss") != "campaign") throw std::runtime_error("is no result of lss-campaign");
    Results results{.commit = json.at("commit"),
                    .first = json.at("first"),
                    .runs = json.at("runs"),
                    .shard = {json.at("shard"), json.at("of")},
                    .summaries = {}};
    for (const Json& one : json.at("vehicles")) {
      Summary& summary = results.summaries.emplace_back(subject_of(one.at("vehicle")));
      visit([&](const char* member, auto& value) { one.at(member).get_to(value); }, summary);
    }
    return results;
  } catch (const Json::exception&) {
    throw std::runtime_error(name + " is no result of lss-campaign --out");
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(name + " " + error.what());
  }
}

void write(const Results& results, const std::filesystem::path& path) {
  std::ofstream file(path, std::ios::trunc);
  file << to_text(results);
  if (!file.flush()) throw std::runtime_error(path.string() + " cannot be written");
}

Results read(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path.string() + " cannot be read");
  return from_text({std::istreambuf_iterator<char>(file), {}}, path.string());
}

Results merge(const std::vector<Results>& shards) {
  if (shards.empty()) throw std::runtime_error("nothing to merge");
  Results all = shards.front();
  all.summaries.clear();
  std::vector<bool> there(all.shard.of);
  for (const Results& shard : shards) {
    if (shard.first != all.first || shard.runs != all.runs || shard.shard.of != all.shard.of)
      throw std::runtime_error(fmt::format(
          "they are of different campaigns: scenarios {} to {} in {} shards, and {} to {} "
          "in {}",
          all.first, all.first + all.runs - 1, all.shard.of, shard.first,
          shard.first + shard.runs - 1, shard.shard.of));
    if (shard.commit != all.commit)
      throw std::runtime_error(
          fmt::format("they are of different commits: {} and {}", all.commit, shard.commit));
    if (shard.shard.number < 1 || shard.shard.number > all.shard.of)
      throw std::runtime_error(
          fmt::format("there is no shard {} of {}", shard.shard.number, all.shard.of));
    if (there[shard.shard.number - 1])
      throw std::runtime_error(
          fmt::format("shard {}/{} comes twice", shard.shard.number, all.shard.of));
    there[shard.shard.number - 1] = true;
    if (!std::ranges::equal(
            shard.summaries, shards.front().summaries, {},
            [](const Summary& s) { return std::string(s.subject.vehicle); },
            [](const Summary& s) { return std::string(s.subject.vehicle); }))
      throw std::runtime_error("they are of different vehicles");
    if (all.summaries.empty()) {
      for (const Summary& summary : shard.summaries) all.summaries.emplace_back(summary.subject);
    }
    for (std::size_t i = 0; i < all.summaries.size(); ++i) all.summaries[i].add(shard.summaries[i]);
  }
  for (unsigned i = 0; i < all.shard.of; ++i) {
    if (!there[i])
      throw std::runtime_error(fmt::format("shard {}/{} is missing", i + 1, all.shard.of));
  }
  all.shard = {};
  return all;
}

}  // namespace lss::campaign
