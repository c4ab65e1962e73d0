#!/usr/bin/env python3
"""run.py MODULE.CLASS.TEST: one scenario, once.

Most scenarios are in simulated time, independent of the machine (docs/simulator.md). Those in real time, or that measure
by the wall clock, need a machine that does not stand still: bytes of a pseudo-terminal are handed over by ordinary kernel threads, and replies that
come later than a bus cycle are correctly lost for the bus master. A separate pseudo-terminal, for measurement only,
distinguishes such a machine from a fault of the product: such a scenario begins when hand-overs were quick for some time;
when it failed while they took longer than its limit, it counts as skipped, with the reason.
For TALARIS that is half as long: its thrusters stay open or shut for as long as the machine stands still.
With LSS_ANY_MACHINE set, as tools/test without words sets it, these scenarios are skipped.
"""

import os
import signal
import subprocess
import sys
import threading
import time
import tty
import unittest

SKIPPED = 77  # SKIP_RETURN_CODE in CMakeLists.txt
BUS_CYCLE_S = 0.020
PERIOD_S = 0.005
WINDOW_S = 0.25
QUIET = 4  # windows
PATIENCE_S = 60  # then it begins on a busy machine
FIRST = -5  # niceness of what depends on the machine, where permitted


def measure():
    """Prints the longest hand-over time of each window, until the reader ends."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(95))
    except PermissionError:
        pass
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    while True:
        longest_s = 0.0
        end_s = time.monotonic() + WINDOW_S
        while time.monotonic() < end_s:
            begin_s = time.monotonic()
            os.write(ours, b"x")
            os.read(theirs, 1)
            longest_s = max(longest_s, time.monotonic() - begin_s)
            time.sleep(PERIOD_S)
        print(longest_s, flush=True)


class Meter:
    def __init__(self):
        self.process = subprocess.Popen([sys.executable, __file__, "--measure"], stdout=subprocess.PIPE)
        self.seconds = []
        self.more = threading.Condition()
        threading.Thread(target=self.listen, daemon=True).start()

    def listen(self):
        for line in self.process.stdout:
            with self.more:
                self.seconds.append(float(line))
                self.more.notify()

    def wait_for_quiet(self):
        with self.more:
            self.more.wait_for(lambda: len(self.seconds) >= QUIET and max(self.seconds[-QUIET:]) < BUS_CYCLE_S,
                               PATIENCE_S)
            self.seconds.clear()

    def longest_s(self):
        """Since wait_for_quiet(), with the window that is under way."""
        with self.more:
            count = len(self.seconds)
            self.more.wait_for(lambda: len(self.seconds) > count, 10)
            return max(self.seconds, default=0.0)

    def end(self):
        self.process.kill()
        self.process.wait()


def passes(suite):
    """Ends at once, as skipped, when a prerequisite is missing."""
    result = unittest.TextTestRunner(verbosity=2).run(suite)
    if result.skipped:
        print(f"skipped: {result.skipped[0][1]}")
        sys.exit(SKIPPED)
    return result.wasSuccessful()


def in_real_time(name, suite):
    meter = Meter()
    try:
        meter.wait_for_quiet()
        passed = passes(suite)
        longest_s = meter.longest_s()
    finally:
        meter.end()
    bound_s = BUS_CYCLE_S / 2 if ".Talaris." in name else BUS_CYCLE_S
    print(f"pseudo-terminals took up to {longest_s * 1e3:.1f} ms; this scenario in real time can bear {bound_s * 1e3:.0f} ms")
    if passed or longest_s < bound_s:
        return 0 if passed else 1
    print("skipped: it failed while the machine stood still for longer")
    return SKIPPED


def cut_off(*_):
    raise AssertionError("not at its end in the time that it has: it waited here")


def main():
    if sys.argv[1] == "--measure":
        measure()
    # Before CTest kills it: a scenario that hangs shows where, and what its programs printed.
    signal.signal(signal.SIGALRM, cut_off)
    signal.alarm(int(os.environ.get("LSS_E2E_LIMIT_S", "0")))
    suite = unittest.defaultTestLoader.loadTestsFromName(sys.argv[1])
    (test,) = suite
    if test.any_machine:
        return 0 if passes(suite) else 1
    if os.environ.get("LSS_ANY_MACHINE"):
        print("skipped: in real time, on a quiet machine: tools/test release")
        return SKIPPED
    try:
        os.nice(FIRST)
    except PermissionError:
        pass
    return in_real_time(sys.argv[1], suite)


if __name__ == "__main__":
    sys.exit(main())
