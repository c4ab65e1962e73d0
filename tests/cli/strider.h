#pragma once

// A vehicle that lss-cli was built without: Lunar Zebro under another name and with another walk.

#include <nlohmann/json.hpp>

#include "tests/cli/fake_daemon.h"
#include "tests/cli/zebro_dictionary.h"

namespace lss::cli::test {

inline Birth strider() {
  nlohmann::json all = nlohmann::json::parse(zebro_dictionary());
  all["vehicle"] = "strider";
  all.erase("presentation");
  for (nlohmann::json& command : all["commands"]) {
    if (command["name"] != "walk") continue;
    command["name"] = "stride";
    command["parameters"][1] = {{"name", "length"}, {"unit", "m"},    {"min", 0.1},
                                {"max", 0.5},       {"default", 0.2}, {"whole", false},
                                {"help", "of each"}};
  }
  return {.vehicle_id = "strider-1", .vehicle = "strider", .dictionary = all.dump()};
}

}  // namespace lss::cli::test
