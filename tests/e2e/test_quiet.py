"""Forbidden actions of the real-time threads, over a long walk."""

import unittest

from rig import IDLE, Scenario


class Quiet(Scenario):
    # [Prod-1]
    def test_two_minutes_of_walking_without_a_malloc_or_a_page_fault_on_real_time_threads(self):
        self.start_all()
        self.cli_ok("walk", "forward", "--speed", "high", "--for", "2min", limit_s=220)
        status = self.status()
        realtime = status["realtime"]
        print("overruns", status["frame"]["overruns"], "of", status["frame"]["index"], "frames;", realtime)
        self.assertEqual(status["state"], IDLE)
        self.assertGreater(status["frame"]["index"], 130 * 1e9 / status["frame"]["period_ns"])
        self.assertTrue(realtime["memory_locked"])
        fifo = [t for t in realtime["threads"] if t["policy"] == "SCHED_FIFO"]
        self.assertGreaterEqual(len(fifo), 3, "bus, actuate, frame")
        self.assertEqual(realtime["mallocs_since_start"], 0)
        self.assertEqual(realtime["page_faults_since_start"], 0)


if __name__ == "__main__":
    unittest.main()
