#include "tests/ardito/chain/results_document.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/support/stamp.h"

namespace lss::ardito {
namespace {

constexpr const char* kBeginning = R"(# D.I.A.N.A. Ardito in the closed loop: measurements

Made by `ardito_results_test`: the daemon's cycle and bus master, a CAN bus of 500 kbit/s with every bit of its frames,
the twelve simulated nodes with their noise, and the rover in physics, in virtual time (`tests/ardito/chain/`);
parameters of `config/ardito.toml`, except for the lamp before the start, which is cut to 1.5 s. Figures of the thesis
are those of its section 19 (mobility controller and FMEDA of D.I.A.N.A. Ardito), measured there in another simulator
with other dynamics: they only show whether the same is reached. Friction is 0.3 as there.
)";

std::string read() {
  std::ifstream file(LSS_RESULTS_DOCUMENT);
  std::stringstream text;
  text << file.rdbuf();
  return text.str().empty() ? kBeginning : text.str();
}

}  // namespace

bool writing_results() { return std::getenv("LSS_WRITE_RESULTS") != nullptr; }

void write_section(const std::string& title, const std::string& text) {
  std::string document = read();
  const std::string head = "\n## " + title + "\n";
  const std::size_t begin = document.find(head);
  if (begin != std::string::npos) {
    const std::size_t end = document.find("\n## ", begin + head.size());
    document.replace(begin, end == std::string::npos ? end : end - begin, head + text);
  } else {
    document += head + text;
  }
  const std::string next = std::string(LSS_RESULTS_DOCUMENT) + ".next";
  std::ofstream(next) << document;
  std::filesystem::rename(next, LSS_RESULTS_DOCUMENT);
}

std::string measured_by(const std::string& test) {
  return "Measured " + testing_support::stamp(LSS_RESULTS_DOCUMENT) +
         " by\n`LSS_WRITE_RESULTS=1 ardito_results_test --gtest_filter=" + test + "`.\n";
}

}  // namespace lss::ardito
