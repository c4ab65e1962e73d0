#include "tools/lss-ground/places.h"

#include <algorithm>

namespace lss::ground {

bool Places::stays(const std::string& id, const Place& place, Clock::time_point now) const {
  if (driven_ && driven_(id)) return true;
  return place.answered != Clock::time_point{} && now - place.heard < kRemember;
}

std::size_t Places::held_by(const dds::Guid& origin) const {
  return static_cast<std::size_t>(
      std::ranges::count_if(places_, [&](const auto& p) { return p.second.origin == origin; }));
}

// The name that must leave for a participant that has this many places, including the requested
// one.
std::string Places::victim(std::size_t asking, Clock::time_point now) const {
  const std::pair<const std::string, Place>*crowd = nullptr, *silent = nullptr;
  std::size_t most = asking;
  for (const auto& entry : places_) {
    const Place& place = entry.second;
    if (stays(entry.first, place, now)) continue;
    const std::size_t held = held_by(place.origin);
    if (held > most || (held == most && crowd != nullptr && place.since > crowd->second.since)) {
      crowd = &entry;
      most = held;
    }
    const bool longest = silent == nullptr || place.heard < silent->second.heard;
    if (now - place.heard >= kSilent && longest) silent = &entry;
  }
  if (crowd != nullptr) return crowd->first;
  return silent != nullptr && asking == 1 ? silent->first : "";
}

Places::Admission Places::admit(const std::string& id, const dds::Guid& origin,
                                Clock::time_point now) {
  Admission admission{.in = true, .left = {}};
  if (places_.size() >= kMost) {
    admission.left = victim(held_by(origin) + 1, now);
    if (admission.left.empty()) {
      turned_away_ = now;
      return {};
    }
    places_.erase(admission.left);
  }
  places_[id] = {.origin = origin, .since = now, .heard = now, .answered = {}};
  return admission;
}

void Places::heard(const std::string& id, Clock::time_point now) {
  if (const auto place = places_.find(id); place != places_.end()) place->second.heard = now;
}

void Places::answered(const std::string& id, Clock::time_point now) {
  if (const auto place = places_.find(id); place != places_.end()) place->second.answered = now;
}

std::vector<std::string> Places::forget(Clock::time_point now) {
  std::vector<std::string> left;
  std::erase_if(places_, [&](const auto& entry) {
    const auto& [id, place] = entry;
    if (now - place.heard < kForget || stays(id, place, now)) return false;
    left.push_back(id);
    return true;
  });
  return left;
}

}  // namespace lss::ground
