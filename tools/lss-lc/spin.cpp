#include "tools/lss-lc/spin.h"

#include <fmt/format.h>

namespace lss::lc {

std::string promela(const Verified& vehicle) {
  const Model model = vehicle.model(*vehicle.table, vehicle.modules);
  std::string text =
      "/* Made by: lss-lc promela. Every event may happen in every state; the step is the one "
      "that\n"
      "   ships, in C++. */\n"
      "c_decl {\n"
      "  extern unsigned char lss_lc_state[8];\n"
      "  void lss_lc_step(int happening);\n"
      "  int lss_lc_good(void);\n"
      "}\n"
      "c_track \"lss_lc_state\" \"8\"\n\n"
      "active proctype world() {\n"
      "  do\n";
  for (std::size_t i = 0; i < model.happenings.size(); ++i) {
    text += fmt::format("  :: c_code [lss_lc_good()] {{ lss_lc_step({}); }} /* {} */\n", i,
                        lc::text(vehicle, model.happenings[i]));
  }
  return text + "  od\n}\n";
}

}  // namespace lss::lc
