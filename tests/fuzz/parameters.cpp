// Files of saved parameters: what is read is the same when it is written and read again, and only
// parameters of the vehicle in their ranges come into force.

#include <cmath>

#include "daemon/parameters/start.h"
#include "daemon/parameters/store.h"
#include "tests/fuzz/sealed.h"

namespace {

constexpr lss::TunableInfo kTunables[] = {
    {"gait.stance_share", "", 0.5, 0.9, lss::Change::always, false, ""},
    {"a", "", 1, 5, lss::Change::always, true, ""}};

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lss;
  using fuzz::must;
  fuzz::Input in({data, size});
  const bool sealed = in.below(8) != 0;
  const fuzz::Bytes input = in.rest();
  std::vector<std::uint8_t> bytes(input.begin(), input.end());
  if (sealed && bytes.size() >= 4) fuzz::put_crc(bytes, 0, bytes.size() - 4);
  const StoredCopy copy = decode(bytes, "zebro", "z-1");
  if (!copy.good()) {
    must(copy.stored.values.empty() || !copy.trouble.empty(), "a refusal says why");
    return 0;
  }
  const StoredCopy again = decode(encode(copy.stored, "zebro", "z-1"), "zebro", "z-1");
  must(again.good() && again.stored.number == copy.stored.number, "it can be written and read");
  must(std::ranges::equal(again.stored.values, copy.stored.values,
                          [](const config::SavedValue& a, const config::SavedValue& b) {
                            return a.name == b.name &&
                                   std::memcmp(&a.value, &b.value, sizeof a.value) == 0;
                          }),
       "... with the same values");
  for (const config::SavedValue& value : vet(kTunables, copy.stored.values).values) {
    const int index = find_tunable(kTunables, value.name);
    must(index >= 0, "a parameter in force is known");
    const TunableInfo& info = kTunables[static_cast<std::size_t>(index)];
    must(value.value >= info.min && value.value <= info.max, "... and in its range");
    must(!info.whole || value.value == std::floor(value.value), "... and whole where it must be");
  }
  return 0;
}
