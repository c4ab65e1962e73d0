// A commanded reset of modules; more in tests/safety/resets.h.

#include <gtest/gtest.h>

#include "world.h"

namespace lss::zebro {
namespace {

// [Env-3] [Oper-4]
TEST(ZebroReset, ReachesOneModuleOrAllAndNoOther) {
  for (const bool stopped : {false, true}) {
    for (int wanted = 0; wanted <= kModules; ++wanted) {
      SCOPED_TRACE(wanted);
      World w;
      w.run(0.2);
      if (stopped) w.send(lss::CommandKind::emergency_stop);
      w.step();
      w.send(lss::CommandKind::reset, {static_cast<double>(wanted)});
      w.step();
      for (int i = 1; i <= kModules; ++i) {
        const bool reset =
            w.out_.command.module[static_cast<std::size_t>(i - 1)].kind == ModuleOrder::Kind::reset;
        EXPECT_EQ(reset, wanted == 0 || wanted == i) << "module " << i;
      }
    }
  }
}

}  // namespace
}  // namespace lss::zebro
