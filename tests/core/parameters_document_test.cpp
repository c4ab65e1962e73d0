// docs/parameters.md shows the tables that the daemon reads.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "daemon/replay/records.h"

namespace lss {
namespace {

std::string text_of(const char* path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string table_of(std::span<const TunableInfo> infos) {
  std::string table = "| parameter | range | |\n|---|---|---|\n";
  for (const TunableInfo& t : infos) {
    const std::string unit = t.unit;
    table += fmt::format("| `{}` | {:g} to {:g}{}{}{} | {} |\n", t.name, t.min, t.max,
                         (unit.empty() ? "" : " ") + unit, t.whole ? ", whole" : "",
                         t.change == Change::always ? "" : ", at rest", t.help);
  }
  return table;
}

TEST(ParametersDocument, HasTheTableOfEachVehicleOfThisBuild) {
  const std::string document = text_of(LSS_DOCUMENT);
  ASSERT_FALSE(document.empty());
  for (const char* vehicle : {"zebro", "ardito", "talaris"}) {
    const auto records = vehicle_records(vehicle);
    if (!records) continue;
    const std::string table = fmt::format("<!-- {} -->\n{}", vehicle, table_of(records->tunables));
    EXPECT_NE(document.find(table), std::string::npos) << "docs/parameters.md should have:\n"
                                                       << table;
  }
}

TEST(ParametersDocument, TheConfigurationsHaveEachOfThem) {
  for (const char* vehicle : {"zebro", "ardito", "talaris"}) {
    const auto records = vehicle_records(vehicle);
    if (!records) continue;
    const std::string config = text_of(fmt::format("{}/{}.toml", LSS_CONFIGS, vehicle).c_str());
    for (const TunableInfo& t : records->tunables) {
      const std::string name = t.name;
      const std::string key = "\n" + name.substr(name.rfind('.') + 1) + " = ";
      EXPECT_NE(config.find(key), std::string::npos) << vehicle << ": " << name;
    }
  }
}

}  // namespace
}  // namespace lss
