"""Walking: the true motion of the simulated robot against the gait table."""

import math
import unittest

import motion
from rig import Scenario


class Walk(Scenario):
    IN_LOCKSTEP, SPEED, PLANT = True, "max", "dart"

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
        self.assertAlmostEqual(forward_m / taken_s, motion.SPEED_M_S["high"], delta=0.25 * motion.SPEED_M_S["high"])
        self.assertLess(abs(left_m), 0.2 * forward_m)

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
            self.assertLess(abs(left_m), 0.2 * forward_m, speed)
        for speed, value in measured.items():
            nominal = motion.SPEED_M_S[speed]
            self.assertAlmostEqual(value, nominal, delta=0.25 * nominal, msg=speed)
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
        self.assertAlmostEqual(forward_m / taken_s, -motion.SPEED_M_S["high"], delta=0.25 * motion.SPEED_M_S["high"])
        self.assertLess(abs(left_m), 0.2 * abs(forward_m))

        # Both sides at full stride against each other, 130 mm apart; legs skid when the robot turns.
        nominal_rad_s = 2 * motion.SPEED_M_S["high"] / 0.130
        for name, span, sign in (("clockwise", clockwise, -1), ("counter-clockwise", counter, 1)):
            first, last, taken_s = motion.whole_cycles(self.truth, span, "high", 1)
            forward_m, left_m, turned_rad = motion.moved(first, last)
            print(f"{name}: {math.degrees(turned_rad / taken_s):.2f} deg/s, {forward_m * 1e3:.1f} mm forward, "
                  f"{left_m * 1e3:.1f} mm left")
            self.assertGreater(sign * turned_rad / taken_s, 0.3 * nominal_rad_s, name)
            self.assertLess(sign * turned_rad / taken_s, 1.25 * nominal_rad_s, name)
            self.assertLess(math.hypot(forward_m, left_m), 0.02, f"{name}: on the spot")


if __name__ == "__main__":
    unittest.main()
