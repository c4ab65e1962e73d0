#pragma once

// The same system for SPIN (spinroot.com), as a second opinion on the explorer: a Promela model
// that lets every event happen in every state, whose state is the packed one and whose only step is
// the step() that ships, called from C. The counts of states and transitions must be the same.

#include <string>

#include "tools/lss-lc/vehicle.h"

namespace lss::lc {

std::string promela(const Verified& vehicle);

}  // namespace lss::lc

// Called by the verifier that SPIN makes from the model: spin_step.cpp, compiled for each vehicle.
extern "C" {
extern unsigned char lss_lc_state[8];
void lss_lc_step(int happening);
int lss_lc_good(void);
}
