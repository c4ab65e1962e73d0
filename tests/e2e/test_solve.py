"""Error solving end to end: modules are restored where possible, otherwise isolated."""

import unittest

import motion
from rig import FATAL_ERROR, FAULT, IDLE, Scenario

LM, RM = 3, 4
# idl/zebro/codes.h, idl/codes.h. A leg whose count stands still just before its sensor passes it elsewhere than it counted.
LIES, SLEEPS = {501, 503}, {502, 503, 18}
WALK_S = 40


class Solve(Scenario):
    IN_LOCKSTEP = True

    def isolated(self):
        return [m["name"] for m in self.telemetry()["modules"] if m["isolated"]]

    def tried(self):
        return [e["text"] for e in self.events() if e["name"] == "strategy_begun"]

    # [Conf-3] [Oper-6]
    def test_a_dead_leg_is_isolated_and_the_other_five_walk(self):
        self.start_all(budget_s="3.0")
        self.begin_walk()
        self.fault(f"module-dead:{LM}")
        status = self.wait_state(FATAL_ERROR)
        self.assertIn(FAULT["module_silent"], self.fault_ids(status))
        self.cli_ok("solve", limit_s=90)
        status = self.wait_state(IDLE)
        self.assertEqual([m["name"] for m in status["telemetry"]["modules"] if m["isolated"]], ["LM"])
        self.assertEqual(status["faults"], [])
        self.assertTrue(any("isolate" in text for text in self.tried()), self.tried())

        self.cli_ok("walk", "forward", "high", "--for", f"{WALK_S}s", limit_s=180)
        begin, end = (motion.at(self.truth, t) for t in self.walks()[-1])
        forward_m, left_m, turned_rad = motion.moved(begin, end)
        print(f"five legs: {forward_m * 1e3:.1f} mm in {WALK_S} s, {left_m * 1e3:.1f} mm left, {turned_rad:.3f} rad")
        self.assertGreater(forward_m, 0.001 * WALK_S, "at least 1 mm/s")

        # It answers again, and is put into service again.
        self.fault("clear")
        self.cli_ok("restore")
        self.wait_status(lambda s: all(m["online"] and not m["isolated"] for m in s["telemetry"]["modules"]), 20, "all in service")
        self.cli_ok("run", "-e", "start; stand; stop", limit_s=120)

    # [Conf-3] [Env-2]
    def test_legs_that_lie_or_sleep_are_isolated_and_stay_so_over_a_restart(self):
        daemon = self.start_all(budget_s="3.0")
        for fault, leg, said in (("encoder-random", LM, LIES), ("encoder-frozen", RM, SLEEPS)):
            self.begin_walk(name=f"walk-{fault}")
            self.fault(f"{fault}:{leg}")
            status = self.wait_state(FATAL_ERROR)
            self.assertTrue(any(f["id"] in said and f["subject"] == leg for f in status["faults"]), status["faults"])
            self.cli_ok("solve", limit_s=90)
            self.wait_state(IDLE)
        self.assertEqual(self.isolated(), ["LM", "RM"])
        self.cli_ok("walk", "forward", "high", "--for", "20s", limit_s=180)

        daemon.process.kill()
        daemon.process.wait()
        self.start_daemon()
        self.assertEqual(self.isolated(), ["LM", "RM"])
        self.cli_ok("run", "-e", "start; stand; stop", limit_s=120)
        self.fault("clear")
        self.cli_ok("restore-leg", str(LM))
        self.assertEqual(self.isolated(), ["RM"])

    # [Prod-4]
    def test_a_tripped_leg_is_moved_free(self):
        self.start_all()
        self.begin_walk()
        self.fault("over-current:2")
        self.wait_state(FATAL_ERROR)
        self.fault("clear")
        self.cli_ok("solve", limit_s=90)
        self.assertTrue(any("move_free" in text for text in self.tried()), self.tried())
        self.cli_ok("run", "-e", "start; stand; stop", limit_s=120)


if __name__ == "__main__":
    unittest.main()
