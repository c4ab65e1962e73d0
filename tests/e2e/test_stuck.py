"""One thing stands still, all else goes on: a thread of the daemon, a subscriber, the log, the disk."""

import glob
import json
import os
import resource
import signal
import time
import unittest

import threads
from programs import die_with_parent, wait_until
from rig import FATAL_ERROR, FAULT, IDLE, Scenario

PERIOD_NS = 20_000_000


class Stuck(Scenario):
    def frames_go_on(self, count=25):
        first = self.status()["frame"]["index"]
        return self.wait_status(lambda s: s["frame"]["index"] >= first + count, 20, "frames go on")

    def test_a_late_frame_repeats_its_command_and_keeps_the_phase(self):
        daemon = self.start_all()
        before = self.status()["frame"]["overruns"]
        for _ in range(5):  # a frame may just have ended
            with threads.stopped(daemon.process.pid, "frame"):
                time.sleep(0.030)
        status = self.wait_status(lambda s: s["frame"]["overruns"] > before, 10, "late commands are counted")
        self.assertEqual(status["state"], IDLE)
        self.assertIn("frame_late", [e["name"] for e in self.events()])
        missed = json.loads(self.cli_ok("--json", "timing").out)["missed"]
        self.assertGreater(missed["repeated"], 0)
        self.frames_go_on(64)
        self.cli_ok("estop")
        boundaries = [f["timing"]["boundary_ns"] for f in self.kept_frames()]
        began_ns = next(e["time_ns"] for e in self.events() if e["name"] == "port_opened")
        self.assertEqual({(b - began_ns) % PERIOD_NS for b in boundaries}, {0}, "the grid that the daemon began on")
        self.assertEqual(len(boundaries), 64)

    def kept_frames(self):
        path = wait_until(lambda: glob.glob(os.path.join(self.run_folder, "*emergency_stop.crash.jsonl")), 10,
                          "the frames before the fault are kept")[0]
        shown = json.loads(self.cli_ok("--json", "log", "show", path).out)
        return shown["frames"]

    def test_a_stuck_frame_thread_stops_the_modules_and_is_reported(self):
        daemon = self.start_all()
        client = self.begin_walk()
        with threads.stopped(daemon.process.pid, "frame"):
            wait_until(lambda: "thread frame stands still" in daemon.err(), 10, "it is reported")
            wait_until(lambda: glob.glob(os.path.join(self.run_folder, "*.crash.jsonl")), 10,
                       "the frames before it are kept")
        status = self.wait_state(FATAL_ERROR)
        self.assertTrue(self.fault_ids(status) & {FAULT["frame_overrun"], FAULT["orders_stale"]}, status["faults"])
        self.assertEqual(client.wait(30), 6)
        wait_until(lambda: "thread frame runs again" in daemon.err(), 5, "that it runs again is reported")
        self.assertNotIn("thread bus/legs stands still", daemon.err())

    def test_a_stuck_bus_thread_is_a_fatal_error_and_not_reported_as_a_stuck_frame_thread(self):
        daemon = self.start_all()
        client = self.begin_walk()
        with threads.stopped(daemon.process.pid, "bus/legs"):
            status = self.wait_state(FATAL_ERROR, 10)
            self.assertIn(FAULT["bus_stuck"], self.fault_ids(status))
            wait_until(lambda: "thread bus/legs stands still" in daemon.err(), 5, "it is reported")
        self.assertEqual(client.wait(30), 6)
        self.assertNotIn("thread frame stands still", daemon.err())
        self.cli_ok("solve")
        self.assertEqual(self.fault_ids(self.wait_state(IDLE)) - {FAULT["bus_noise"]}, set())

    def test_a_stuck_publisher_delays_no_frame(self):
        daemon = self.start_all()
        self.cli_ok("timing", "--reset")
        before = self.status()["counters"]["telemetry_dropped"]
        with threads.stopped(daemon.process.pid, "publish"):
            wait_until(lambda: "thread publish stands still" in daemon.err(), 10, "it is reported")
        status = self.frames_go_on()
        dropped = status["counters"]["telemetry_dropped"] - before
        self.assertGreater(dropped, 40, "telemetry of each frame of a second, but the newest")
        self.assertRegex(self.cli_ok("status").out, r"[1-9]\d* samples dropped")
        self.assertGreater(json.loads(self.cli_ok("--json", "timing").out)["frames"], 50)
        self.assert_no_frame_waited()
        self.assertEqual(status["realtime"]["mallocs_since_start"], 0)
        self.assertNotIn("thread frame stands still", daemon.err())

    # [Prod-2]
    def test_a_full_disk_a_stuck_log_and_subscribers_that_stop_reading_delay_no_frame(self):
        self.start_sim()
        config = self.write_config()

        def tiny_disk():
            die_with_parent()
            resource.setrlimit(resource.RLIMIT_FSIZE, (65536, 65536))
        # Nobody reads the daemon's output: its pipe is full after 64 KiB.
        unread, stderr = os.pipe()
        self.addCleanup(os.close, unread)
        os.set_blocking(stderr, False)
        try:
            while os.write(stderr, b"x" * 4096):
                pass
        except BlockingIOError:
            pass
        os.set_blocking(stderr, True)
        daemon = self.start_daemon(config, before=tiny_disk, stderr=stderr)
        os.close(stderr)
        self.wait_modules()
        subscribers = [self.begin_cli("--jsonl", "watch", name=f"watch{i}") for i in range(2)]
        subscribers.append(self.begin_cli("--jsonl", "events", "--follow", name="follow"))
        for subscriber in subscribers:
            wait_until(lambda s=subscriber: s.out() or s.name == "follow", 20, "it hears the daemon")
            subscriber.signal(signal.SIGSTOP)
        self.cli_ok("timing", "--reset")
        for _ in range(3):
            self.cli_ok("estop")
            self.cli_ok("solve")
        self.cli_ok("walk", "forward", "--for", "10s", limit_s=120)
        self.assertEqual(glob.glob(os.path.join(self.run_folder, "*.crash.jsonl*")), [])
        events = [e["name"] for e in self.events()]
        self.assertIn("log_failed", events)
        status = self.frames_go_on()
        self.assertEqual(status["state"], IDLE)
        self.assertEqual(status["realtime"]["mallocs_since_start"], 0)
        self.assertEqual(status["realtime"]["page_faults_since_start"], 0)
        self.assert_no_frame_waited()
        self.assertTrue(daemon.running())
        for subscriber in subscribers:
            subscriber.kill()
        daemon.signal(signal.SIGTERM)
        self.assertEqual(daemon.wait(10), 0, "it ends although nobody takes its lines")

    def test_a_stuck_log_thread_is_reported_and_delays_nothing(self):
        daemon = self.start_all()
        self.cli_ok("timing", "--reset")
        with threads.stopped(daemon.process.pid, "log"):
            wait_until(lambda: "thread log stands still" in daemon.err(), 10, "it is reported")
            self.cli_ok("estop")
            self.cli_ok("solve")
            self.frames_go_on()
        self.assert_no_frame_waited()
        self.assertEqual(len(self.kept_frames()), 64, "kept when it runs again")

    def test_a_clock_that_is_set_moves_no_frame(self):
        daemon = self.start_with_clock()
        before = self.frames_go_on()
        self.set_clock(3600)
        self.wait_status(lambda s: s["utc_ns"] - before["utc_ns"] > 3500 * 10**9, 10, "UTC stamps follow")
        status = self.frames_go_on()
        self.assertIn("clock_stepped", [e["name"] for e in self.events()])
        frames = status["frame"]["index"] - before["frame"]["index"]
        self.assertAlmostEqual(frames, (status["time_ns"] - before["time_ns"]) / PERIOD_NS, delta=6)
        self.assertEqual(status["state"], IDLE)
        # Back by more than the elapsed time: any wait for a wall-clock time would take hours.
        self.set_clock(-3600)
        self.wait_status(lambda s: s["utc_ns"] < before["utc_ns"], 10, "UTC stamps follow back")
        self.frames_go_on(100)
        steps = [e["count"] for e in self.events() if e["name"] == "clock_stepped"]
        self.assertEqual(steps, [2], "within a minute: one event that counts both")
        self.assertTrue(daemon.running())


if __name__ == "__main__":
    unittest.main()
