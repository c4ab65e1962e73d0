#include "tests/zebro/chain/fault_document.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>

#include "tests/zebro/chain/fault_cases.h"

namespace lss::zebro {
namespace {

constexpr const char* kBeginning =
    R"(# Faults of Lunar Zebro: reactions and times

For operators and reviewers: every fault of `lss-sim faults zebro` during a walk in simulation (kinematic robot). Made by
`LSS_WRITE_FAULTS=1 zebro_faults_test`.

- **stops**: every module is sent an emergency stop within 20.8 ms of the release of that frame's orders; legs stand still
  within 0.3 s unless the line hides them. FatalError until `solve`; when all faults are cleared this leads to Idle with all
  legs.
- **walks on**: 10 s more; then a stop command ends it safely.

## Alone

At ten moments of a walk each. *Within*: from the fault to FatalError or the warning, by `config/zebro.toml`.

| | fault | Lunar Zebro | reports | within, ms | because | measured, ms | `solve` while it lasts |
|---|---|---|---|---|---|---|---|
)";

constexpr const char* kPairs = R"(
- A bus that is cut, too noisy or gone, or a dead or restarting module, hides other faults of modules.
- After `solve` a leg that slipped or drifted is out of service until `restore`.
- Faults 19 to 24 are tested alone only.

## Two at a time, on different legs

Rows: first fault; columns: second, 0 to 2 s later. `1`, `2`: it stops and names that one first (`1/2`: either); `-`: it walks
on; empty: the second replaces the first.

)";

constexpr const char* kOneLeg = R"(
## Two at a time, on one leg

)";

constexpr const char* kEnd = R"(
Over-current: 0.2 Nm drags below every limit, 0.75 Nm exceeds the software's limit only, 1 Nm (default) stalls the motor.
)";

std::map<FaultTable, std::map<std::size_t, std::string>> kept;

std::string numbers(std::size_t columns) {
  std::string first = "| first \\ second |", second = "|---|";
  for (std::size_t i = 1; i <= columns; ++i) {
    first += " " + std::to_string(i) + " |";
    second += "---|";
  }
  return first + "\n" + second + "\n";
}

std::size_t one_leg_columns() {
  return static_cast<std::size_t>(std::ranges::count_if(paired_cases(), &FaultCase::of_module));
}

std::string read() {
  std::ifstream file(LSS_FAULTS_DOCUMENT);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

// Without measurements: from-to, and which of two stopped it.
std::string lasting(const std::string& row) {
  static const std::regex measured("\\| [0-9]+ to [0-9]+ \\|"), which("\\| [12](/2)? (?=\\|)");
  return std::regex_replace(std::regex_replace(row, measured, "| # |"), which, "| stops ");
}

}  // namespace

bool writing_faults() { return std::getenv("LSS_WRITE_FAULTS") != nullptr; }

std::string check_row(FaultTable table, std::size_t number, const std::string& row) {
  if (writing_faults()) {
    kept[table][number] = row;
    return {};
  }
  static const std::string document = read();
  std::istringstream lines(document);
  const std::string wanted = lasting(row);
  for (std::string line; std::getline(lines, line);) {
    if (lasting(line) == wanted) return {};
  }
  return "docs/faults-zebro.md has no row\n" + row +
         "\nWhen this is what Lunar Zebro shall do: LSS_WRITE_FAULTS=1 zebro_faults_test";
}

std::string check_frame(std::size_t alone, std::size_t pairs, std::size_t one_leg) {
  if (writing_faults()) return {};
  const std::string document = read();
  for (const std::string& part : {std::string(kBeginning), kPairs + numbers(pairs),
                                  kOneLeg + numbers(one_leg), std::string(kEnd)}) {
    if (document.find(part) == std::string::npos) return "docs/faults-zebro.md lacks\n" + part;
  }
  const std::size_t heads = 6;  // and lines under them
  std::size_t rows = 0;
  std::istringstream lines(document);
  for (std::string line; std::getline(lines, line);) rows += line.starts_with("|") ? 1u : 0u;
  return rows == heads + alone + pairs + one_leg ? "" : "docs/faults-zebro.md has other rows";
}

void write_faults() {
  std::ofstream file(LSS_FAULTS_DOCUMENT);
  const auto table = [&](FaultTable which) {
    for (const auto& [number, row] : kept[which]) file << row << "\n";
  };
  file << kBeginning;
  table(FaultTable::alone);
  file << kPairs << numbers(paired_cases().size());
  table(FaultTable::pairs);
  file << kOneLeg << numbers(one_leg_columns());
  table(FaultTable::one_leg);
  file << kEnd;
}

}  // namespace lss::zebro
