#pragma once

// The order in which error solving tries its strategies. The configuration has a list of strategies
// for each class of faults. Pure function.

#include <algorithm>
#include <array>
#include <cstddef>

namespace lss {

// Begins with the first strategies of all classes that are present, then come the second ones, and
// so on. A strategy that several lists contain appears once, at its latest place, because it serves
// all classes and the most expensive strategy comes last. The value-initialised Kind means no
// strategy and ends a list. `otherwise` is the result when all lists are empty.
template <class Kind, std::size_t Choices, std::size_t Classes>
std::array<Kind, Choices> plan(const std::array<std::array<Kind, Choices>, Classes>& order,
                               const std::array<bool, Classes>& present, Kind otherwise) noexcept {
  std::array<Kind, Choices> backwards{};
  std::size_t count = 0;
  for (std::size_t choice = Choices; choice-- > 0;) {
    for (std::size_t c = Classes; c-- > 0;) {
      const Kind kind = order[c][choice];
      const auto end = backwards.begin() + static_cast<std::ptrdiff_t>(count);
      if (present[c] && kind != Kind{} && count < Choices &&
          std::find(backwards.begin(), end, kind) == end)
        backwards[count++] = kind;
    }
  }
  if (count == 0) backwards[count++] = otherwise;
  std::array<Kind, Choices> forwards{};
  std::reverse_copy(backwards.begin(), backwards.begin() + static_cast<std::ptrdiff_t>(count),
                    forwards.begin());
  return forwards;
}

}  // namespace lss
