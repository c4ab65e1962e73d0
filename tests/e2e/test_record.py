"""The flight recorder and lssd --replay: a recording is executed again bit by bit, by this build and by
those of other presets; altered, damaged and cut files are distinguished."""

import csv
import glob
import io
import json
import math
import os
import re
import resource
import shutil
import signal
import time
import unittest

import recording
from hopper_rig import Hopper
from programs import die_with_parent, read_text, run, wait_until
from rig import DAEMON, IDLE, SOURCE, Scenario, real_time
from rover_rig import Rover

RECORDING_FAILED = 49  # idl/codes.h
KEPT = os.environ.get("LSS_E2E_RECORDINGS")
ALTERED = os.environ.get("LSS_E2E_ALTERED")  # another number in one place of each vehicle: tests/altered
EQUAL, UNREADABLE, DIFFERENT, DAMAGED, FOREIGN, INCOMPLETE = range(6)


class Recorded:
    """Beside a Scenario."""

    def recordings(self):
        return sorted(glob.glob(os.path.join(self.run_folder, "*.lssrec")))

    def replay(self, *paths, program=(DAEMON, "--replay"), expect=EQUAL):
        result = run([*program, *paths], self.environment(), 300)
        self.assertEqual(result.code, expect, result)
        return result.out

    def replay_everywhere(self):
        """By this build, and by those of the other presets that are there; not by one that was altered."""
        paths = self.recordings()
        print(self.replay(*paths), sum(os.path.getsize(path) for path in paths), "bytes")
        if KEPT:  # for builds of other presets that are made later
            os.makedirs(KEPT, exist_ok=True)
            for number, path in enumerate(paths):
                shutil.copy(path, os.path.join(KEPT, f"{self.NAME}-{number}.lssrec"))
        said = self.replay(*paths, program=[ALTERED], expect=DIFFERENT)
        self.assertRegex(said, r"field +(command|telemetry|state)\.")
        print(said)
        for preset in ("release", "debug", "asan", "tsan"):
            other = os.path.join(SOURCE, "build", preset, "bin", "lssd")
            if os.path.exists(other) and not os.path.samefile(other, DAEMON) and self.same_records(other, paths):
                print(preset, self.replay(*paths, program=[other, "--replay"]))

    def same_records(self, other, paths):
        """A build that was made before records or configuration changed has nothing to say, nor one that is being
        linked."""
        try:
            result = run([other, "--replay", *paths], self.environment(), 300)
        except OSError:
            return False
        older = ("laid out otherwise", "of another layout", "does not take the configuration")
        return "--config is required" not in result.err and not any(text in result.out for text in older)

    def begin_again(self):
        """Moves the files recorded so far; the next file begins in the middle of a run."""
        path, = self.recordings()
        begun = os.path.join(self.folder, "begun.lssrec")
        shutil.copy(path, begun)
        os.remove(path)
        wait_until(self.recordings, 10, "another file begins")
        self.replay(begun)

    def replayed_from_the_middle(self, daemon, client):
        """The client moves, and ends by itself. The frames of the first file that is left."""
        self.begin_again()
        self.assertEqual(client.wait(120), 0)
        self.wait_state(IDLE)
        daemon.stop()
        self.replay_everywhere()
        return self.frames_of(self.recordings()[0])[0]

    def frames_of(self, path):
        header, items, ended = recording.read(path)
        schema = recording.Schema(header["schema"])
        return [schema.read(item)[0] for kind, item in items if kind == recording.FRAME], ended

    def assert_lss_cli_reads_the_same(self, path):
        frames, ended = self.frames_of(path)
        listed = json.loads(self.cli_ok("--json", "log", "list", path).out)
        self.assertEqual((listed["frames"], listed["whole"]), (len(frames), ended))
        self.assertEqual(listed["last_frame"], frames[-1]["in"]["frame"])
        columns = "modules[*].position_rad,distance_m,timing.margin_ns"
        rows = list(csv.DictReader(io.StringIO(self.cli_ok("log", "export", path, "--columns", columns).out)))
        self.assertEqual(len(rows), len(frames))
        for row, frame in zip(rows, frames):
            self.assertEqual(int(row["frame"]), frame["in"]["frame"])
            self.assertEqual(int(row["timing.margin_ns"]), frame["timing"]["margin_ns"])
            for name in row:
                if not name.startswith("telemetry."):
                    continue
                value = frame["telemetry"]
                for part in re.findall(r"[^.\[\]]+", name)[1:]:
                    value = value[int(part) if part.isdigit() else part]
                self.assertTrue(float(row[name]) == value if row[name] else math.isnan(value), name)
        self.assertEqual(len(row), 4 + len(frames[0]["telemetry"]["modules"]) + 2)
        last = frames[-1]["in"]["frame"]
        shown = json.loads(self.cli_ok("--json", "log", "show", path, "--frame", str(last)).out)
        self.assertEqual(shown["state"]["controller"]["state"], IDLE)
        self.assertEqual(shown["timing"]["woken_ns"], frames[-1]["timing"]["woken_ns"])

    def assert_its_trace_has_the_same_times(self, path):
        """What Perfetto opens, beside the records themselves."""
        frames, _ = self.frames_of(path)
        trace = self.cli_ok("timing", "trace", path).out
        self.assertEqual(trace, self.cli_ok("timing", "trace", path).out)
        events = json.loads(trace)["traceEvents"]
        slices = [e for e in events if e["ph"] == "X" and e["name"] == "frame"]
        self.assertEqual([e["args"]["frame"] for e in slices], [f["in"]["frame"] for f in frames])
        for event, frame in zip(slices, frames):
            times = frame["timing"]
            self.assertEqual(round(event["ts"] * 1000), times["boundary_ns"])
            self.assertEqual(round(event["dur"] * 1000), times["ready_ns"] - times["boundary_ns"])
        self.assertEqual(sum(e["name"] == "sample" for e in events), sum(len(f["in"]["samples"]) for f in frames))
        released = {e["args"]["frame"]: round((e["ts"] + e["dur"]) * 1000) for e in events if e["name"] == "release"}
        for frame in frames[1:]:
            self.assertEqual(released[frame["in"]["frame"] - 1], frame["timing"]["released_ns"])

    def assert_nothing_lost(self):
        status = self.status()
        self.assertEqual(status["counters"]["telemetry_dropped"], 0)
        self.assertTrue(status["recording"])
        self.assertEqual(status["realtime"]["mallocs_since_start"], 0)
        self.assertEqual(status["realtime"]["page_faults_since_start"], 0)


class Zebro(Recorded, Scenario):
    IN_LOCKSTEP = True

    def write_config(self, name="zebro.toml", file_mb=None, **changes):
        path = super().write_config(name, **changes)
        if file_mb:  # of the recorder: the log has one, too
            text = re.sub(r"(?ms)(^\[recorder\].*?^file_mb = )\d+", rf"\g<1>{file_mb}", read_text(path))
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
        return path

    def test_a_walk_is_replayed_to_the_bit_and_what_was_altered_is_reported(self):
        daemon = self.start_all(file_mb=1)
        client = self.begin_walk()
        wait_until(lambda: len(self.recordings()) >= 2, 60, "the second file begins")
        self.wait_status(lambda s: s["telemetry"]["distance_m"] > 0.005, 60, "it walked 5 mm", client)
        client.signal(signal.SIGINT)
        client.wait(60)
        self.wait_state(IDLE)
        if recording.read(self.recordings()[0])[0]["build"]["type"] == "RelWithDebInfo":  # else it has no time
            self.assert_nothing_lost()
        daemon.stop()
        self.replay_everywhere()
        first, second = self.recordings()[:2]
        self.altered(first)
        self.replay(second)  # alone: it begins in the middle of the run
        self.assert_lss_cli_reads_the_same(self.recordings()[-1])
        self.assert_its_trace_has_the_same_times(self.recordings()[-1])
        frames = [f for path in self.recordings() for f in self.frames_of(path)[0]]
        numbers = [f["in"]["frame"] for f in frames]
        self.assertEqual(len(set(numbers)), len(numbers))
        self.assertEqual(numbers, sorted(numbers))
        self.assertGreater(max(f["telemetry"]["distance_m"] for f in frames), 0.001, "the walk is in it")

    def altered(self, path):
        header, items, _ = recording.read(path)
        other = os.path.join(self.folder, "altered.lssrec")

        def write(change_header=None, change_items=None):
            recording.write(other, {**header, **(change_header or {})}, change_items or items)

        # Unchanged, but for the end that is not there.
        write()
        self.assertIn("not ended", self.replay(other))

        # One bit of one output, with the right checksums.
        schema = recording.Schema(header["schema"])
        numbers = [i for i, (kind, _) in enumerate(items) if kind == recording.FRAME]
        chosen = numbers[len(numbers) // 2]
        values, places = schema.read(items[chosen][1])
        begin, size = places["telemetry.modules[3].set_point_rad"]
        record = bytearray(items[chosen][1])
        record[begin] ^= 1
        write(change_items=items[:chosen] + [(recording.FRAME, bytes(record))] + items[chosen + 1:])
        said = self.replay(other, expect=DIFFERENT)
        self.assertIn(f"in frame {values['in']['frame']},", said)
        self.assertIn("telemetry.modules[3].set_point_rad", said)
        self.assertEqual(size, 8)
        print(said)

        # The program does something else than it did: as if a constant in it had been changed.
        config, count = re.subn(r"(?m)^temperature_warning_degC = [0-9.]+", "temperature_warning_degC = 20.0",
                                header["config"])
        self.assertEqual(count, 1)
        write({"config": config})
        said = self.replay(other, expect=DIFFERENT)
        self.assertRegex(said, r"field +(command|telemetry|state|outbox)\.")
        print(said)

        # Another layout, another vehicle, another configuration.
        write({"schema": header["schema"].replace("distance_m:f8", "distance_m:f4")})
        self.assertIn("laid out otherwise", self.replay(other, expect=FOREIGN))
        write({"vehicle": "walrus"})
        self.assertIn("not built into", self.replay(other, expect=FOREIGN))
        write({"config": "vehicle = 'zebro'\nnonsense = 1\n"})
        self.assertIn("nonsense", self.replay(other, expect=FOREIGN))

        # Without its beginning nothing is known of the vehicle.
        write({"start": False}, items[10:])
        self.assertIn("cannot be compared", self.replay(other, expect=INCOMPLETE))

        # Damage, a torn end, and no recording at all.
        with open(path, "rb") as file:
            data = bytearray(file.read())
        with open(other, "wb") as file:
            file.write(data[:-1000])
        self.assertIn("torn: cut off at byte", self.replay(other))
        data[len(data) // 2] ^= 0x10
        with open(other, "wb") as file:
            file.write(data)
        self.assertRegex(self.replay(other, expect=DAMAGED), "damaged in the chunk that begins at byte .*; "
                         "chunks that are missing: 1; what is whole is replayed")
        self.replay(os.path.join(self.folder, "none.lssrec"), expect=UNREADABLE)

    @real_time("the last 100 ms before the kill")
    def test_a_killed_daemon_leaves_all_but_the_last_100_ms(self):
        daemon = self.start_all()
        self.cli_ok("timing", "--reset")
        client = self.begin_walk()
        frame = self.status()["frame"]["index"]
        self.wait_status(lambda s: s["frame"]["index"] > frame + 100, 60, "it walks for two seconds")
        killed_ns = time.monotonic_ns()
        daemon.process.kill()
        daemon.process.wait()
        client.kill()
        path, = self.recordings()
        frames, ended = self.frames_of(path)
        self.assertFalse(ended)
        missing_ms = (killed_ns - frames[-1]["in"]["time_ns"]) * 1e-6
        print("the last frame that is readable began", missing_ms, "ms before the kill")
        self.assertLess(missing_ms, 100)
        self.assertIn("not ended", self.replay(path))
        again = self.start_daemon()
        wait_until(lambda: len(self.recordings()) == 2, 10, "another file")
        wait_until(lambda: os.path.getsize(path) < 10_000_000, 10, "the room that was not used is given back")
        again.stop()
        self.replay(*self.recordings())

    @real_time("a full disk delays nothing")
    def test_a_full_disk_is_reported_delays_nothing_and_recording_goes_on(self):
        self.start_sim()

        def small_disk():
            die_with_parent()
            resource.setrlimit(resource.RLIMIT_FSIZE, (15_000_000, resource.RLIM_INFINITY))
        daemon = self.start_daemon(before=small_disk)
        self.wait_modules()
        self.cli_ok("timing", "--reset")
        wait_until(lambda: "frames cannot be recorded" in daemon.err(), 30, "it is reported")
        self.wait_status(lambda s: not s["recording"], 5, "status says that nothing is recorded")
        self.assertIn("is recorded", self.cli_ok("status").out)
        self.assertEqual([e["id"] for e in self.events()].count(RECORDING_FAILED), 1)
        resource.prlimit(daemon.process.pid, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
        self.wait_status(lambda s: s["recording"], 30, "it goes on")
        self.assert_no_frame_waited()
        frame = self.status()["frame"]["index"]
        self.wait_status(lambda s: s["frame"]["index"] > frame + 20, 30, "some frames more")
        daemon.stop()
        path, = self.recordings()
        header, items, _ = recording.read(path)
        self.assertFalse(header["start"])
        self.assertGreater(header["lost_before"], 0)
        self.assertEqual(items[0][0], recording.STATE)
        self.replay(path)


class Ardito(Recorded, Rover):
    IN_LOCKSTEP = True

    def test_a_drive_is_replayed_to_the_bit_also_from_the_middle(self):
        daemon = self.start_all(beacon_s="1.5")
        client = self.begin_cli("drive", "0.3", "--for", "20s", name="drive")  # of the wall clock: simulated time may be slow
        self.wait_status(lambda s: s["mode"] == "Running", 60, "it drives", client)
        frames = self.replayed_from_the_middle(daemon, client)
        self.assertGreater(frames[-1]["telemetry"]["distance_m"], 0.3)


class Talaris(Recorded, Hopper):
    IN_LOCKSTEP = True

    def test_a_hop_is_replayed_to_the_bit_also_from_the_middle(self):
        daemon = self.start_all()
        client = self.begin_cli("hop", "--arm", "--height", "1", "--distance", "3", name="hop")
        self.wait_phase("traverse", 90, client)
        frames = self.replayed_from_the_middle(daemon, client)
        self.assertGreater(max(f["telemetry"]["position_m"][0] for f in frames), 0.5)


if __name__ == "__main__":
    unittest.main()
