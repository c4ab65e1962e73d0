// Configurations (TOML): each is taken or refused, with a file and a line. The vehicle's table is
// read with every kind of value that a vehicle has.

#include "daemon/config/config.h"

#include "tests/fuzz/fuzz.h"

namespace {

using namespace lss;
using fuzz::must;

void read_vehicle(config::Section& s) {
  const double number = s.number("number", 1, 0.5, 2);
  must(number >= 0.5 && number <= 2, "a number is in its range");
  const auto whole = s.integer("whole", 3, 1, 9);
  must(whole >= 1 && whole <= 9, "a whole number is in its range");
  (void)s.flag("flag", true);
  (void)s.text("text", "a");
  must(s.choice("choice", 1, {"one", "two"}) < 2, "a choice is one of them");
  must(s.integers("integers", {1, 2}, 2, 0, 5).size() == 2, "a list has its length");
  for (const double one : s.numbers("numbers", {1, 2, 3}, 3, 0, 5))
    must(one >= 0 && one <= 5, "each number is in its range");
  (void)s.texts("texts", {"a"});
  config::Section below = s.section("below");
  (void)below.required_text("name");
  for (config::Section& one : s.sections("list")) (void)one.number("number", 1, 0, 2);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  bool has_read = false;
  const auto config = config::parse(fuzz::text_of({data, size}), "input", {"zebro", "talaris"},
                                    [&](const std::string&, config::Section& section) {
                                      has_read = true;
                                      read_vehicle(section);
                                    });
  if (!config) {
    must(config.error().starts_with("input"), "a refusal says where and why");
    return 0;
  }
  must(has_read, "the vehicle has read its table");
  must(config->vehicle == "zebro" || config->vehicle == "talaris", "the vehicle is one of them");
  must(config->period_ns > 0 && config->offset_ns >= 0 && config->offset_ns < config->period_ns,
       "a frame has its length, and orders go out in it");
  must(config->obc_timeout_ns > 0, "a lost operator stops the vehicle");
  return 0;
}
