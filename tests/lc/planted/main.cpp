// lss-lc composition with a defect in the code of watch, solver or supervisor (CMakeLists.txt):
// finds it, or not. Arguments: failures, the first failure's name, the property.

#include <fmt/format.h>

#include <cstdlib>

#include "tools/lss-lc/zebro/composed.h"

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const lss::lc::Composition c = lss::zebro::compose(
      {.failures = static_cast<unsigned>(std::atoi(argv[1])), .every = false, .only = argv[2]});
  if (!c.violation) {
    fmt::print("not found in {} states\n", c.states);
    return 1;
  }
  fmt::print("{}\n", c.violation->property);
  for (const std::string& line : c.violation->trace) fmt::print("{}\n", line);
  return c.violation->property == argv[3] ? 0 : 1;
}
