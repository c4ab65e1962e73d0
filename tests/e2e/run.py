#!/usr/bin/env python3
"""run.py MODULE.CLASS.TEST: one scenario, with an eye on the machine.

Bytes of a pseudo-terminal are handed over by ordinary kernel threads, so that a busy machine delays them whatever
the priority of both ends is: measured at load 11 on two CPUs, 0.04 ms in the median, 22 ms at p99, 759 ms at most.
Replies that late are lost for the bus master, and rightly so. A pseudo-terminal of our own, for measuring only,
tells such a machine from a fault of the product: a scenario begins when hand-overs were quick for a while, and
one that failed while they took longer than a bus cycle is tried again, up to three times in all, and it says so.
For TALARIS that is half as long: its thrusters are held open or shut for as long as the machine stands still.
"""

import os
import subprocess
import sys
import threading
import time
import tty
import unittest

TRIES = 3
SKIPPED = 77  # SKIP_RETURN_CODE in CMakeLists.txt
BUS_CYCLE_S = 0.020
PERIOD_S = 0.005
QUIET_S = 3
PATIENCE_S = 120  # then it begins on a busy machine


def measure():
    """Says once a second how long the longest hand-over took, until nobody listens."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(95))
    except PermissionError:
        pass
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    while True:
        longest_s = 0.0
        end_s = time.monotonic() + 1
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
            self.more.wait_for(lambda: len(self.seconds) >= QUIET_S and max(self.seconds[-QUIET_S:]) < BUS_CYCLE_S,
                               PATIENCE_S)
            self.seconds.clear()

    def longest_s(self):
        """Since wait_for_quiet(), with the second that is under way."""
        with self.more:
            count = len(self.seconds)
            self.more.wait_for(lambda: len(self.seconds) > count, 10)
            return max(self.seconds, default=0.0)


def passes(name):
    """Ends at once, as skipped, when what the scenario needs is not there."""
    suite = unittest.defaultTestLoader.loadTestsFromName(name)
    if suite.countTestCases() == 0:
        return False
    result = unittest.TextTestRunner(verbosity=2).run(suite)
    if result.skipped:
        sys.exit(SKIPPED)
    return result.wasSuccessful()


def main():
    if sys.argv[1] == "--measure":
        measure()
    meter = Meter()
    try:
        for count in range(1, TRIES + 1):
            meter.wait_for_quiet()
            passed = passes(sys.argv[1])
            longest_s = meter.longest_s()
            print(f"try {count}: {'passed' if passed else 'failed'}; "
                  f"pseudo-terminals took up to {longest_s * 1e3:.1f} ms", flush=True)
            if passed or longest_s < (BUS_CYCLE_S / 2 if ".Talaris." in sys.argv[1] else BUS_CYCLE_S):
                return 0 if passed else 1
        return 1
    finally:
        meter.process.kill()
        meter.process.wait()


if __name__ == "__main__":
    sys.exit(main())
