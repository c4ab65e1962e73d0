#include "tests/ardito/chain/results_document.h"

#include <cstdlib>

#include "tests/support/section.h"
#include "tests/support/stamp.h"

namespace lss::ardito {
namespace {

constexpr const char* kBeginning = R"(# D.I.A.N.A. Ardito in the closed loop: measurements

How soon the rover finds failures and stops. Made by `ardito_results_test` in virtual time: the daemon's cycle and bus master,
CAN, twelve simulated nodes with noise, the rover in physics; `config/ardito.toml`, friction 0.3. The thesis' figures (section
19) are of another simulator with the same friction.
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
