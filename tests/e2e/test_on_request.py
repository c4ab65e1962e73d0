"""telemetry.mode = "on_request": telemetry is sent on request, and only then."""

import re
import unittest

from programs import run
from rig import BOOT_S, PEER, Scenario, loopback

QUESTIONS = 3


class OnRequest(Scenario):
    IN_LOCKSTEP = True

    # [O-Int-1]
    def test_a_sample_leaves_for_each_question_and_none_unasked(self):
        self.start_all(mode='"on_request"')
        words = [PEER, "telemetry", str(self.domain), "1000"]
        unasked = run([*words, "5"], self.environment(CYCLONEDDS_URI=loopback(False)), 20)
        self.assertIn("loaned 0\n", unasked.out)

        listener = self.begin("listener", [*words, "10"], CYCLONEDDS_URI=loopback(False))
        self.wait_for_text(listener, "reader", BOOT_S)
        for _ in range(QUESTIONS):
            self.cli_ok("data")
        listener.wait(20)
        heard = int(re.search(r"loaned (\d+)", listener.out())[1])
        print(f"{heard} samples for {QUESTIONS} questions")
        self.assertIn(heard, range(1, QUESTIONS + 1), "the first may be over before both ends know each other")


if __name__ == "__main__":
    unittest.main()
