// Device descriptions, EDS and DCF: any text is read, what is wrong is said in few sentences, and a
// description without errors is usable.

#include "drivers/canopen/description.h"

#include <cmath>

#include "drivers/ardito/profile.h"
#include "tests/fuzz/fuzz.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lss;
  using fuzz::must;
  const std::string text = fuzz::text_of({data, size});
  const canopen::ReadDescription read = canopen::read_description(text);
  const canopen::Description& description = read.description;
  must(read.errors.size() <= canopen::kMostSentences + 1, "few sentences");
  must(description.objects.size() <= canopen::kMostObjects, "not too many objects");
  must(description.signals.size() <= canopen::kMostSignals, "not too many signals");
  must(std::ranges::is_sorted(
           description.objects, std::less_equal<>{},
           [](const canopen::DescribedObject& object) { return object.index << 8 | object.sub; }),
       "objects are in order, each once");
  for (const canopen::DescribedSignal& signal : description.signals)
    must(std::isfinite(signal.unit), "the unit of a signal is a number");
  if (!read.errors.empty()) return 0;
  for (std::size_t kind = 0; kind < ardito::kKinds; ++kind) {
    std::vector<std::string> errors;
    const ardito::Profile profile =
        ardito::make_profile(static_cast<ardito::Kind>(kind), description, errors);
    if (!errors.empty()) continue;
    for (const ardito::Field& field : profile.field)
      must(field.bytes <= 4 && std::isfinite(field.unit) && field.unit != 0, "a field is usable");
  }
  return 0;
}
