#include "tests/zebro/chain/fault_document.h"

#include <cstdlib>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>

namespace lss::zebro {
namespace {

constexpr const char* kBeginning =
    R"(# Faults of Lunar Zebro: reactions and times

Every fault of `lss-sim faults zebro` during a simulated walk (kinematic robot), at ten moments each. Made by
`LSS_WRITE_FAULTS=1 zebro_faults_test`.

- **stops**: every module is sent an emergency stop within 20.8 ms of the release of that frame's orders; legs stand still
  within 0.3 s unless the line hides them. FatalError until `solve`, which leads to Idle with all legs when no fault is left.
- **walks on**: 10 s more; then a stop command ends it safely.
- *Within*: from the fault to FatalError or the warning, by `config/zebro.toml`.

| | fault | Lunar Zebro | reports | within, ms | because | measured, ms | `solve` while it lasts |
|---|---|---|---|---|---|---|---|
)";

constexpr const char* kEnd = R"(
- **Two of 1 to 18**, 0 to 2 s apart, on different legs or one: it stops if one of them alone stops, by the earlier of their
  times, and names either.
- A bus that is cut, too noisy or gone, or a dead or restarting module, hides other faults of modules.
- After `solve` a leg that slipped or drifted is out of service until `restore`.
- Over-current: 0.2 Nm is below every limit, 0.75 Nm exceeds the software's only, 1 Nm (default) stalls the motor.
)";

std::map<std::size_t, std::string> kept;

std::string read() {
  std::ifstream file(LSS_FAULTS_DOCUMENT);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

// Without measurements: from-to.
std::string lasting(const std::string& row) {
  static const std::regex measured("\\| [0-9]+ to [0-9]+ \\|");
  return std::regex_replace(row, measured, "| # |");
}

}  // namespace

bool writing_faults() { return std::getenv("LSS_WRITE_FAULTS") != nullptr; }

std::string check_row(std::size_t number, const std::string& row) {
  if (writing_faults()) {
    kept[number] = row;
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

std::string check_frame(std::size_t rows) {
  if (writing_faults()) return {};
  const std::string document = read();
  for (const char* part : {kBeginning, kEnd}) {
    if (document.find(part) == std::string::npos)
      return std::string("docs/faults-zebro.md lacks\n") + part;
  }
  const std::size_t heads = 2;  // and line under it
  std::size_t found = 0;
  std::istringstream lines(document);
  for (std::string line; std::getline(lines, line);) found += line.starts_with("|") ? 1u : 0u;
  return found == heads + rows ? "" : "docs/faults-zebro.md has other rows";
}

void write_faults() {
  std::ofstream file(LSS_FAULTS_DOCUMENT);
  file << kBeginning;
  for (const auto& [number, row] : kept) file << row << "\n";
  file << kEnd;
}

}  // namespace lss::zebro
