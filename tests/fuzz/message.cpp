// Messages of the pilot's page to its gateway: JSON, and the scripts that it may carry.

#include "tools/lss-ground/message.h"

#include <cmath>

#include "tests/fuzz/fuzz.h"
#include "tools/lss-cli/show/failure.h"
#include "tools/lss-cli/talaris/script.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lss;
  using fuzz::must;
  const auto message = ground::parse_message(fuzz::text_of({data, size}));
  if (!message) {
    must(!message.error().empty(), "a refusal says why");
    return 0;
  }
  if (const auto* order = std::get_if<ground::Order>(&*message)) {
    for (const auto& [name, value] : order->parameters)
      must(std::isfinite(value), "a parameter is a number");
  }
  if (const auto* script = std::get_if<ground::Script>(&*message)) {
    try {
      const auto steps = cli::talaris::parse_script(script->text, "script");
      must(!steps.empty(), "a script has a step");
      double at_s = 0;
      for (const auto& step : steps) {
        must(step.at_s >= at_s && std::isfinite(step.value) && std::isfinite(step.which),
             "steps are in order, and numbers");
        at_s = step.at_s;
      }
      must(std::isfinite(cli::talaris::duration_s(steps)), "a script comes to an end");
    } catch (const cli::Failure& failure) {
      must(*failure.what() != '\0', "a refusal says why");
    }
  }
  return 0;
}
