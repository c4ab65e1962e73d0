"""The log that runs, with everything of every frame, while its thread or its disk does not keep up."""

import glob
import json
import os
import resource
import signal
import unittest

import threads
from programs import die_with_parent, run, wait_until
from rig import DAEMON, IDLE, Scenario

FULL = 500_000


class Log(Scenario):
    def paths(self):
        return sorted(glob.glob(os.path.join(self.run_folder, "*.log.jsonl")))

    def read_log(self):
        """[(first line, [frame, ...])] of each file, the oldest first; by lss-cli, and each line whole."""
        listed = json.loads(self.cli_ok("--json", "log", "list", self.run_folder).out)["files"]
        logs = [file for file in listed if file["kind"] == "log"]
        self.assertEqual([file["path"] for file in logs], self.paths())
        files = []
        for file in logs:
            self.assertEqual(file["what"], "everything")
            shown = [json.loads(line) for line in self.cli_ok("--jsonl", "log", "show", file["path"]).out.splitlines()]
            files.append((shown[0]["header"], shown[1:]))
        return files

    def assert_every_frame_is_there_or_counted(self, frames):
        """The daemon counts a frame that it skipped itself; lost lines are frames here."""
        for before, after in zip(frames, frames[1:]):
            skipped = after["timing"]["frames_skipped"] - before["timing"]["frames_skipped"]
            missing = after["frame"] - before["frame"] - 1 - skipped
            lost = after.get("lost_frames", 0) + after.get("lost_lines", 0)
            self.assertEqual(missing, lost, f"before frame {after['frame']}")

    def assert_nothing_delayed_a_frame(self):
        self.assert_no_frame_waited()
        status = self.status()
        self.assertEqual(status["realtime"]["mallocs_since_start"], 0)
        self.assertEqual(status["realtime"]["page_faults_since_start"], 0)
        return status

    def test_a_stuck_log_thread_loses_frames_that_are_counted_and_delays_none(self):
        daemon = self.start_all(use='"everything"')
        self.cli_ok("timing", "--reset")
        client = self.begin_walk()
        with threads.stopped(daemon.process.pid, "log"):
            status = self.wait_status(lambda s: s["counters"]["telemetry_dropped"] > 50, 60, "frames are dropped")
            self.assertEqual(status["mode"], "Walking")
        wait_until(lambda: "thread log runs again" in daemon.err(), 10, "it runs again")
        wait_until(lambda: "log_lost" in [e["name"] for e in self.events()], 10, "it is reported")
        client.signal(signal.SIGINT)
        client.wait(60)
        status = self.assert_nothing_delayed_a_frame()
        self.assertEqual(status["state"], IDLE)
        dropped = status["counters"]["telemetry_dropped"]
        daemon.stop()
        (first, frames), = self.read_log()
        self.assertEqual(first["lost_frames_since_start"], 0)
        print(len(frames), "frames logged,", dropped, "dropped")
        self.assert_every_frame_is_there_or_counted(frames)
        lost = sum(f.get("lost_frames", 0) for f in frames)
        self.assertTrue(50 < lost <= dropped, "the counter has what else the publisher dropped, too")
        # The flight recorder has the same gap; frames right after it cannot be compared, all others are equal.
        replayed = run([DAEMON, "--replay", *glob.glob(os.path.join(self.run_folder, "*.lssrec"))],
                       self.environment(), 300)
        self.assertEqual(replayed.code, 5, replayed)
        self.assertIn(f"{lost} frames are not in it", replayed.out)
        self.assertIn("every bit of every output", replayed.out)
        self.assertGreater(frames[-1]["telemetry"]["distance_m"], 0.01, "and the walk is in it")
        names = [e["name"] for f in frames for e in f.get("outbox", {}).get("events", [])]
        self.assertIn("mode_changed", names)

    def test_a_full_disk_costs_the_log_lines_that_are_counted_and_no_frame(self):
        self.start_sim()

        def tiny_disk():
            die_with_parent()
            resource.setrlimit(resource.RLIMIT_FSIZE, (FULL, resource.RLIM_INFINITY))
        daemon = self.start_daemon(self.write_config(use='"everything"'), before=tiny_disk)
        self.wait_modules()
        self.cli_ok("timing", "--reset")
        client = self.begin_walk()
        wait_until(lambda: "the log cannot be written" in daemon.err(), 30, "it is reported")
        self.wait_status(lambda s: not s["recording"], 5, "status says that nothing is recorded")
        # There is room again.
        resource.prlimit(daemon.process.pid, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
        wait_until(lambda: "the log goes on" in daemon.err(), 30, "it goes on")
        self.wait_status(lambda s: s["recording"], 15, "status says so, when the recorder has tried again, too")
        client.signal(signal.SIGINT)
        client.wait(60)
        self.assertEqual(self.assert_nothing_delayed_a_frame()["state"], IDLE)
        self.assertEqual([e["name"] for e in self.events()].count("log_failed"), 1)
        daemon.stop()
        files = self.read_log()
        self.assertGreater(len(files), 1)
        self.assertLessEqual(os.path.getsize(self.paths()[0]), FULL)
        frames = [frame for _, of_file in files for frame in of_file]
        lost = sum(f.get("lost_lines", 0) for f in frames)
        print(len(frames), "frames logged,", lost, "lines lost")
        self.assertGreater(lost, 50)
        self.assert_every_frame_is_there_or_counted(frames)


if __name__ == "__main__":
    unittest.main()
