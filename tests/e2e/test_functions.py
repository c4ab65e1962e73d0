"""All functions of Lunar Zebro one after the other, in the gravity of the Earth and of the Moon."""

import math
import unittest

import motion
from rig import EXIT, IDLE, Scenario

WALK_S = 12
STANDING_M, LYING_M = 0.045, 0.030  # height of the body on hard ground: at least, at most
SUNK_M = 0.015  # standing in soil (docs/soil.md)


class Functions(Scenario):
    IN_LOCKSTEP, SPEED, PLANT = True, "max", "dart"

    def all_functions(self, gravity, *ground):
        self.start_sim("--gravity", gravity, *ground)
        self.start_daemon(self.write_config())
        self.wait_modules()

        self.cli_ok("run", "-e", "panel deploy")
        refused = self.cli("start")
        self.assertEqual(refused.code, EXIT["rejected"], refused)
        self.assertIn("panel", refused.err + refused.out)
        self.assertEqual(self.status()["state"], IDLE)
        self.cli_ok("run", "-e", "panel retract")

        walks = [f"walk {how} --for {WALK_S}s" for how in (
            "forward low", "forward medium", "forward high", "backward high", "forward high --heading=-90",
            "forward high --heading 90")]
        self.cli_ok("run", "-e", "; ".join(["start", "stand", *walks, "lay-down", "stow", "stop"]), limit_s=300)
        self.assert_resting(self.status())

        spans = [(motion.at(self.truth, begin), motion.at(self.truth, end)) for begin, end in self.walks()]
        self.assertEqual(len(spans), len(walks))
        for ends in spans:
            self.assertGreater(min(state["position_m"][2] for state in ends), STANDING_M - (SUNK_M if ground else 0))
        self.assertLess(self.truth.samples[-1][1]["position_m"][2], LYING_M)
        moved = [motion.moved(*ends) for ends in spans]
        for words, (forward_m, left_m, turned_rad) in zip(walks, moved):
            print(f"{gravity} {' '.join(ground)}: {words}: {forward_m * 1e3:.1f} mm forward, {left_m * 1e3:.1f} mm left, "
                  f"{math.degrees(turned_rad):.1f} deg")
        low, medium, high, back = (forward_m for forward_m, _, _ in moved[:4])
        self.assertGreater(low, 0.001 * WALK_S, "at least 1 mm/s")
        self.assertGreater(medium, 1.5 * low)
        self.assertGreater(high, 1.5 * medium)
        self.assertLess(back, (-0.5 if ground else -0.7) * high)
        left_rad, right_rad = moved[4][2], moved[5][2]
        self.assertGreater(left_rad, 0.2)
        self.assertLess(right_rad, -0.2)

    # [Func-1] [Func-2] [Func-3] [Func-4] [Func-5] [Ver-2] [Oper-8]
    def test_on_the_earth_it_does_all_that_it_shall(self):
        self.all_functions("earth")

    # [Ver-3]
    def test_on_the_moon_it_does_all_that_it_shall(self):
        self.all_functions("moon")

    # [Ver-3]
    def test_on_the_moons_regolith_it_does_all_that_it_shall(self):
        self.all_functions("moon", "--ground", "regolith")


if __name__ == "__main__":
    unittest.main()
