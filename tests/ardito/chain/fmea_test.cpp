// Each failure mode of docs/fmea.md, executed; the document is made of the same rows.
// LSS_WRITE_RESULTS=1 ardito_fmea_test writes it.

#include "tests/ardito/chain/fmea.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <vector>

namespace lss::ardito {
namespace {

constexpr const char* kBeginning = R"(# Failure modes of D.I.A.N.A. Ardito

Failure modes of the Ardito thesis (part IV; numbers are its sections). `ardito_fmea_test` executes each that has a name on the
daemon's cycle with simulated nodes. [How](gnc-ardito.md), [times](ardito-results.md).

- The rover drives on unless the reaction says otherwise.
- Wheel out: motor off, clutch open; five wheels drive on.
- Mechanical: **no sensor detects it**; the thesis and `lssd` rely on the design.
)";

std::string document() {
  std::string text = kBeginning;
  for (const FailureSection& section : failure_sections()) {
    text +=
        fmt::format("\n## {}\n\n| | failure mode | detected by | reaction |\n|---|---|---|---|\n",
                    section.title);
    for (const FailureMode& m : section.modes) {
      const std::string name = *m.name != 0 ? fmt::format("`{}`", m.name) : "";
      const char* between = *m.name != 0 && *m.mode != 0 ? ": " : "";
      text += fmt::format("| {} | {}{}{} | {} | {} |\n", m.number, name, between, m.mode, m.seen_by,
                          m.done);
    }
    if (*section.text != 0) text += fmt::format("\n{}", section.text);
  }
  return text;
}

TEST(ArditoFmea, TheDocumentHasTheRowsThatTheTestsExecute) {
  if (std::getenv("LSS_WRITE_RESULTS") != nullptr) std::ofstream(LSS_DOCUMENT) << document();
  std::ifstream file(LSS_DOCUMENT);
  const std::string written{std::istreambuf_iterator<char>(file), {}};
  EXPECT_TRUE(written == document()) << "LSS_WRITE_RESULTS=1 ardito_fmea_test writes it again";
}

std::vector<const FailureMode*> executed() {
  std::vector<const FailureMode*> all;
  for (const FailureSection& section : failure_sections()) {
    for (const FailureMode& m : section.modes) {
      if (m.run) all.push_back(&m);
    }
  }
  return all;
}

TEST(ArditoFmea, EveryModeThatASensorSeesIsExecuted) {
  for (const FailureSection& section : failure_sections()) {
    for (const FailureMode& m : section.modes)
      EXPECT_EQ(*m.name != 0, m.run != nullptr) << m.number << m.mode;
  }
}

class ArditoFailureMode : public testing::TestWithParam<const FailureMode*> {};

TEST_P(ArditoFailureMode, IsTreatedAsTheDocumentSays) { EXPECT_EQ(GetParam()->run(), ""); }

INSTANTIATE_TEST_SUITE_P(Fmea, ArditoFailureMode, testing::ValuesIn(executed()),
                         [](const auto& row) { return std::string(row.param->name); });

}  // namespace
}  // namespace lss::ardito
