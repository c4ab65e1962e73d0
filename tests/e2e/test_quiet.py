"""Forbidden actions of the real-time threads, over a long walk."""

import os
import unittest

from rig import IDLE, Scenario

WALK_S = 120 if os.environ.get("LSS_EVERYTHING") else 20


class Quiet(Scenario):
    # [Prod-1]
    def test_walking_without_a_malloc_or_a_page_fault_on_real_time_threads(self):
        self.start_all()
        self.cli_ok("walk", "forward", "--speed", "high", "--for", f"{WALK_S}s", limit_s=WALK_S + 100)
        status = self.status()
        realtime = status["realtime"]
        print("overruns", status["frame"]["overruns"], "of", status["frame"]["index"], "frames;", realtime)
        self.assertEqual(status["state"], IDLE)
        self.assertGreater(status["frame"]["index"], (WALK_S + 5) * 1e9 / status["frame"]["period_ns"])
        self.assertTrue(realtime["memory_locked"])
        fifo = [t for t in realtime["threads"] if t["policy"] == "SCHED_FIFO"]
        self.assertGreaterEqual(len(fifo), 3, "bus, actuate, frame")
        self.assertEqual(realtime["mallocs_since_start"], 0)
        self.assertEqual(realtime["page_faults_since_start"], 0)


if __name__ == "__main__":
    unittest.main()
