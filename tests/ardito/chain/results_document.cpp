#include "tests/ardito/chain/results_document.h"

#include <cstdlib>

#include "tests/support/section.h"
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

}  // namespace

bool writing_results() { return std::getenv("LSS_WRITE_RESULTS") != nullptr; }

void write_section(const std::string& title, const std::string& text) {
  testing_support::write_section(LSS_RESULTS_DOCUMENT, title, text, kBeginning);
}

std::string measured_by(const std::string& test) {
  return "Measured " + testing_support::stamp(LSS_RESULTS_DOCUMENT) +
         " by\n`LSS_WRITE_RESULTS=1 ardito_results_test --gtest_filter=" + test + "`.\n";
}

}  // namespace lss::ardito
