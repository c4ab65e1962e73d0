#pragma once

// The same system for SPIN (spinroot.com), as a second opinion on the explorer: a Promela model
// that lets every event happen in every state, whose state is the packed one and whose only step is
// the step() that ships, called from C. The counts of states and transitions must be the same.

#include <string>

#include "tools/lss-lc/explorer.h"

namespace lss::lc {

std::string promela(const Model& model, std::string (*name)(const Table&, Happening));

}  // namespace lss::lc

// Called by the verifier that SPIN makes from the model; the vehicle's is in spin_NAME.cpp.
extern "C" {
extern unsigned char lss_lc_state[8];
void lss_lc_step(int happening);
int lss_lc_good(void);
}
