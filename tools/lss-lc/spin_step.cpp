// The functions that SPIN's verifier calls, for the vehicle LSS_SPIN_VEHICLE of this build.

#include <cstring>

#include "tools/lss-lc/spin.h"

namespace {

using namespace lss;

const lc::Model& model() {
  static const lc::Model model = [] {
    const lc::Verified& vehicle = *lc::verified_vehicle(LSS_SPIN_VEHICLE);
    return vehicle.model(*vehicle.table, vehicle.modules);
  }();
  return model;
}

lc::ControllerState state() {
  lc::Key key;
  std::memcpy(&key, lss_lc_state, sizeof key);
  return lc::unpack(key);
}
void set(const lc::ControllerState& state) {
  const lc::Key key = lc::pack(lc::stand_in(model(), state));
  std::memcpy(lss_lc_state, &key, sizeof key);
}

bool packs = true;  // every state so far

// Before main(): the initial state of the search.
[[maybe_unused]] const bool begun = [] {
  set(model().begin);
  return true;
}();

}  // namespace

extern "C" {

unsigned char lss_lc_state[8];

void lss_lc_step(int happening) {
  const lc::Happening h = model().happenings[static_cast<std::size_t>(happening)];
  const lc::ControllerState next = lc::step(*model().table, state(), h.event, h.subject).next;
  packs = packs && lc::unpack(lc::pack(next)) == next;
  set(next);
}

// The properties of states; SPIN stops with an error at a violation.
int lss_lc_good() {
  if (!packs) return 0;
  return model().states.all(*model().table, state()) ? 1 : 0;
}

}  // extern "C"
