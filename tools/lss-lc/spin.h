#pragma once

// The same system for SPIN (spinroot.com), as an independent check of the explorer: a Promela model
// that allows every event in every state. Its state is the packed one, its only step the step()
// that ships, called from C. The counts of states and transitions must be the same.

#include <string>

#include "tools/lss-lc/vehicle.h"

namespace lss::lc {

std::string promela(const Verified& vehicle);

}  // namespace lss::lc

// Called by the verifier that SPIN generates from the model: spin_step.cpp, compiled for each
// vehicle.
extern "C" {
extern unsigned char lss_lc_state[8];
void lss_lc_step(int happening);
int lss_lc_good(void);
}
