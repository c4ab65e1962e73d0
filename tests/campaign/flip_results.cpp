#include "tests/campaign/flip_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <utility>

namespace lss::campaign {
namespace {

using Json = nlohmann::ordered_json;

// The members of the counts that a file has, each with its name.
template <class Visitor, class Of>
void visit(Visitor&& v, Of& c) {
  v("bytes", c.bytes), v("parts", c.parts), v("state", c.state), v("program", c.program);
  v("instructions", c.instructions), v("places", c.places), v("hung", c.hung);
  v("scenarios", c.scenarios), v("simulated_s", c.simulated_s);
  v("slowest_detection_s", c.slowest_detection_s);
}

void add(FlipTally& sum, const FlipTally& more) {
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += more[i];
}

void add(FlipCounts& sum, const FlipCounts& more) {
  for (const auto& [name, tally] : more.parts) add(sum.parts[name], tally);
  for (const auto& [name, tally] : more.places) add(sum.places[name], tally);
  for (const auto& [name, hung] : more.hung) sum.hung[name] += hung;
  add(sum.state, more.state);
  add(sum.program, more.program);
  sum.bytes = more.bytes;
  sum.instructions = more.instructions;
  sum.scenarios += more.scenarios;
  sum.simulated_s += more.simulated_s;
  sum.slowest_detection_s = std::max(sum.slowest_detection_s, more.slowest_detection_s);
}

std::string content(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path.string() + " cannot be read");
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

std::string to_text(const FlipResults& results) {
  Json json = {{"lss", "flips"},         {"commit", results.commit},
               {"part", results.part},   {"protected", results.protect},
               {"seeds", results.seeds}, {"vehicles", Json::object()}};
  for (const auto& [vehicle, counts] : results.vehicles) {
    Json& one = json["vehicles"][vehicle];
    visit([&](const char* name, const auto& value) { one[name] = value; }, counts);
  }
  return json.dump(1) + '\n';
}

FlipResults flips_from_text(const std::string& text, const std::string& name) {
  try {
    const Json json = Json::parse(text);
    FlipResults results{.commit = json.at("commit"),
                        .part = json.at("part"),
                        .protect = json.at("protected"),
                        .seeds = json.at("seeds"),
                        .vehicles = {}};
    for (const auto& [vehicle, one] : json.at("vehicles").items()) {
      FlipCounts& counts = results.vehicles[vehicle];
      visit([&, &one = one](const char* member, auto& value) { one.at(member).get_to(value); },
            counts);
    }
    return results;
  } catch (const Json::exception&) {
    throw std::runtime_error(name + " is no result of lss-campaign --flips --out");
  }
}

void write(const FlipResults& results, const std::filesystem::path& path) {
  std::ofstream file(path, std::ios::trunc);
  file << to_text(results);
  if (!file.flush()) throw std::runtime_error(path.string() + " cannot be written");
}

FlipResults read_flips(const std::filesystem::path& path) {
  return flips_from_text(content(path), path.string());
}

bool is_flips(const std::filesystem::path& path) {
  const Json json = Json::parse(content(path), nullptr, false);
  return json.is_object() && json.value("lss", "") == "flips";
}

FlipResults merge(const std::vector<FlipResults>& all) {
  if (all.empty()) throw std::runtime_error("nothing to merge");
  const FlipResults& first = all.front();
  FlipResults sum{.commit = first.commit,
                  .part = first.part,
                  .protect = first.protect,
                  .seeds = {},
                  .vehicles = {}};
  std::set<std::pair<std::string, unsigned>> there;
  std::set<unsigned> seeds;
  for (const FlipResults& one : all) {
    if (one.commit != sum.commit)
      throw std::runtime_error(
          fmt::format("they are of different commits: {} and {}", sum.commit, one.commit));
    if (one.part != sum.part || one.protect != sum.protect)
      throw std::runtime_error("they are of different parts, or not all of protected memory");
    for (const auto& [vehicle, counts] : one.vehicles) {
      for (const unsigned seed : one.seeds) {
        if (!there.emplace(vehicle, seed).second)
          throw std::runtime_error(fmt::format("seed {} of {} comes twice", seed, vehicle));
        seeds.insert(seed);
      }
      add(sum.vehicles[vehicle], counts);
    }
  }
  sum.seeds.assign(seeds.begin(), seeds.end());
  return sum;
}

std::string document(const FlipResults& results) {
  std::string text;
  for (const auto& [vehicle, counts] : results.vehicles) text += flip_table(vehicle, counts) + '\n';
  return text;
}

}  // namespace lss::campaign
