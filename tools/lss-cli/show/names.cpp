#include "tools/lss-cli/show/names.h"

#include <algorithm>

#include "idl/edit_distance.h"

namespace lss::cli {

std::string nearest(std::string_view wrong, const std::vector<std::string>& names) {
  const std::string* best = nullptr;
  std::size_t best_distance = 0;
  for (const std::string& name : names) {
    const bool beginning = wrong.size() >= 2 && name.starts_with(wrong);
    const std::size_t distance = beginning ? 1 : edit_distance(wrong, name);
    if (best == nullptr || distance < best_distance) {
      best = &name;
      best_distance = distance;
    }
  }
  // A distance of more than half of its letters is another word.
  if (best == nullptr || 2 * best_distance > std::max(wrong.size(), best->size())) return "";
  return *best;
}

std::string did_you_mean(std::string_view wrong, const std::vector<std::string>& names) {
  const std::string name = nearest(wrong, names);
  return name.empty() ? "" : "did you mean " + name + "?";
}

}  // namespace lss::cli
