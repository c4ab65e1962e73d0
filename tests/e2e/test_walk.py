"""Walking: the true motion of the simulated robot against the gait table."""

import math
import unittest

import motion
from rig import Scenario

ASIDE = 0.03  # of the way ahead; 0.014 at most of 30 seeds (tests/zebro/chain/gait_speed_test.cpp)


class Walk(Scenario):
    IN_LOCKSTEP, SPEED, PLANT = True, "max", "dart"

    def assert_near(self, value, nominal, share, what):
        self.assertAlmostEqual(value, nominal, delta=share * abs(nominal), msg=what)

    # [Func-1]
    def test_walks_forward_at_the_speed_of_the_gait_table_and_rests_again(self):
        self.start_sim()
        self.start_daemon(self.write_config(shared_memory=True))
        self.wait_modules()
        self.cli_ok("run", "-e", "walk forward --speed high --for 20s", limit_s=150)

        (span,) = self.walks()
        self.assertAlmostEqual((span[1] - span[0]) / 1e9, 20, delta=1.5)
        first, last, taken_s = motion.whole_cycles(self.truth, span, "high", 2)
        forward_m, left_m, turned_rad = motion.moved(first, last)
        print(f"two cycles: {forward_m * 1e3:.1f} mm forward, {left_m * 1e3:.1f} mm left, "
              f"{math.degrees(turned_rad):.2f} deg, {forward_m / taken_s * 1e3:.2f} mm/s")
        self.assert_near(forward_m / taken_s, motion.SPEED_M_S["high"], motion.SHARE, "high")
        self.assertLess(abs(left_m), ASIDE * forward_m)

        whole_m, aside_m, _ = motion.moved(motion.at(self.truth, span[0]), motion.at(self.truth, span[1]))
        self.assertGreater(whole_m, 0.15)
        self.assertLess(abs(aside_m), 0.2 * whole_m)
        self.assert_resting(self.status())

    # [Func-4]
    def test_low_medium_and_high_follow_the_gait_table(self):
        self.start_all()
        parts = [("low", 26), ("medium", 16), ("high", 13)]  # a cycle, long after the beginning
        steps = [f"walk forward --speed {speed} --for {seconds}s" for speed, seconds in parts]
        self.cli_ok("run", "-e", "; ".join(["start", "stand", *steps, "stop"]), limit_s=240)

        spans = self.walks()
        self.assertEqual(len(spans), 3)
        measured = {}
        for (speed, _), span in zip(parts, spans):
            first, last, taken_s = motion.whole_cycles(self.truth, span, speed, 1)
            forward_m, left_m, _ = motion.moved(first, last)
            measured[speed] = forward_m / taken_s
            print(f"{speed}: {measured[speed] * 1e3:.2f} mm/s, {left_m * 1e3:.1f} mm left")
            self.assertLess(abs(left_m), ASIDE * forward_m, speed)
        for speed, value in measured.items():
            self.assert_near(value, motion.SPEED_M_S[speed], motion.SHARE, speed)
        self.assertLess(measured["low"], measured["medium"])
        self.assertLess(measured["medium"], measured["high"])

    # [Func-3]
    def test_backward_and_turns_go_their_way(self):
        self.start_all()
        self.cli_ok("run", "-e", "start; stand; walk backward --speed high --for 14s; "
                    "walk --heading 90 --speed high --for 14s; walk --heading=-90 --speed high --for 14s; stop",
                    limit_s=240)
        backward, clockwise, counter = self.walks()

        first, last, taken_s = motion.whole_cycles(self.truth, backward, "high", 1)
        forward_m, left_m, _ = motion.moved(first, last)
        print(f"backward: {forward_m / taken_s * 1e3:.2f} mm/s, {left_m * 1e3:.1f} mm left")
        self.assert_near(forward_m / taken_s, -motion.SPEED_M_S["high"], motion.SHARE, "backward")
        self.assertLess(abs(left_m), ASIDE * abs(forward_m))

        # Both sides at full stride against each other; legs skid when the robot turns.
        for name, span in (("clockwise", clockwise), ("counter-clockwise", counter)):
            first, last, taken_s = motion.whole_cycles(self.truth, span, "high", 1)
            forward_m, left_m, turned_rad = motion.moved(first, last)
            print(f"{name}: {math.degrees(turned_rad / taken_s):.2f} deg/s, {forward_m * 1e3:.1f} mm forward, "
                  f"{left_m * 1e3:.1f} mm left")
            self.assert_near(math.degrees(turned_rad / taken_s), motion.TURN_DEG_S[name], motion.TURN_SHARE, name)
            self.assertLess(math.hypot(forward_m, left_m), 0.01, f"{name}: on the spot")  # 0.0035 of 30 seeds


if __name__ == "__main__":
    unittest.main()
