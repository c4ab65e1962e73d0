"""Recorded for as long as LSS_RECORD_MINUTES says, in motion: nothing lost, real time undisturbed, replayed to the
bit; size, CPU and speed of the replay are printed. Not part of every run: tests/README.md."""

import os
import re
import signal
import time
import unittest

import recording
from hopper_rig import Hopper
from rig import IDLE, Scenario
from rover_rig import Rover
from test_record import Recorded

MINUTES = float(os.environ.get("LSS_RECORD_MINUTES", "0"))
TICKS_PER_S = os.sysconf("SC_CLK_TCK")


def cpu_s(pid):
    """{name of the thread: seconds of CPU}, the whole process as ''."""
    seconds = {}
    for path in [f"/proc/{pid}", *(f"/proc/{pid}/task/{task}" for task in os.listdir(f"/proc/{pid}/task"))]:
        with open(f"{path}/stat", encoding="utf-8") as file:
            text = file.read()
        name = "" if path.count("/") == 2 else text[text.index("(") + 1:text.rindex(")")]
        user, system = text[text.rindex(")") + 2:].split()[11:13]
        seconds[name] = seconds.get(name, 0) + (int(user) + int(system)) / TICKS_PER_S
    return seconds


@unittest.skipUnless(MINUTES > 0, "LSS_RECORD_MINUTES says how long")
class Long(Recorded):
    """Beside a Scenario with motion(), a generator: the motion begins, and when it is asked again it ends."""

    def test_a_long_run_loses_nothing_and_is_replayed(self):
        daemon = self.start_all()
        self.cli_ok("timing", "--reset")
        motion = self.motion()
        next(motion)
        begun_s, before = time.monotonic(), cpu_s(daemon.process.pid)
        while time.monotonic() < begun_s + 60 * MINUTES:
            time.sleep(min(10, max(0, begun_s + 60 * MINUTES - time.monotonic())))
        took_s, after = time.monotonic() - begun_s, cpu_s(daemon.process.pid)
        self.assert_nothing_lost()
        next(motion, None)
        self.wait_state(IDLE, 120)
        status = self.status()
        daemon.stop()
        for name in sorted(after):
            print(f"{name or 'lssd'}: {100 * (after[name] - before.get(name, 0)) / took_s:.2f} % of a CPU")
        paths = self.recordings()
        numbers = [number for path in paths for number in self.numbers_of(path)]
        self.assertEqual(numbers, list(range(numbers[0], numbers[0] + len(numbers))), "every frame, once")
        self.assertGreaterEqual(numbers[-1], status["frame"]["index"] - 1)
        size = sum(os.path.getsize(path) for path in paths)
        began_s = time.monotonic()
        said = self.replay(*paths)
        replayed_s = time.monotonic() - began_s
        print(said)
        print(f"{len(numbers)} frames in {len(paths)} files, {size / 1e6:.1f} MB; {took_s / 60:.1f} min recorded, "
              f"replayed equal in {replayed_s:.2f} s, {took_s / replayed_s:.0f} times real time")
        self.assertFalse(re.search("not ended", said))

    def numbers_of(self, path):
        """Of all frames; decoding all of each would take as long as the recording."""
        header, items, _ = recording.read(path)
        frames = [item for kind, item in items if kind == recording.FRAME]
        at, size = recording.Schema(header["schema"]).read(frames[0])[1]["in.frame"]
        return [int.from_bytes(frame[at:at + size], "little") for frame in frames]


class Zebro(Long, Scenario):
    def motion(self):
        client = self.begin_walk()
        yield
        client.signal(signal.SIGINT)
        self.assertEqual(client.wait(60), 0)


class Ardito(Long, Rover):
    def motion(self):
        client = self.begin_cli("drive", "0.2", "--heading", "3", name="drive")
        self.wait_status(lambda s: s["mode"] == "Running", 60, "it drives", client)
        yield
        client.signal(signal.SIGINT)
        self.assertEqual(client.wait(60), 0)


class Talaris(Long, Hopper):
    """One hop, since it has gas for one; then at standstill, still at the full rate."""

    def motion(self):
        self.cli_ok("hop", "--arm", "--height", "2", "--distance", "8", limit_s=180)
        yield


if __name__ == "__main__":
    unittest.main()
