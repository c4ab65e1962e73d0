"""Hostile programs (tests/attack) around a scenario: their actions, the frames on the bus, the cost."""

import json
import os
import statistics
import time

import wire
from programs import die_with_parent, run, wait_until
from rig import BOOT_S, FATAL_ERROR, IDLE

ATTACK = os.environ["LSS_E2E_ATTACK"]
ATTACK_S = float(os.environ.get("LSS_ATTACK_S", "4"))  # of each vehicle
PILOT = "pilot"
ROUNDS = 3  # each with a stop
# Messages a second, 20,000 in all.
RATES = {"flood-heartbeats": 9000, "flood-commands": 5000, "invent-sources": 3918, "flood-estop-dry-run": 1000,
         "replay": 1000, "max-sequence": 50, "many-names": 32}
SENT_AT_LEAST = 5000  # a second, on a machine that is too slow for more; ten times what once filled the queue
MEDIAN_S = 0.1        # from sending a stop to its first bytes on the bus: a frame; row xiii measures it closely
MOST_S = 0.5          # of a machine that does other things, too
GROWTH_KB = 2048      # of the daemon's memory over the attack


def aside():
    """Its messages are the attack, not the time of the CPU that it takes from the kernel's pseudo-terminals."""
    die_with_parent()
    os.nice(10)


def rss_kb(process):
    with open(f"/proc/{process.pid}/status", encoding="ascii") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmRSS:"))


class Attacked:
    """With a Scenario of a vehicle that moves: VEHICLE, MODE while it moves, begin_motion(), stopped_ns(since_ns)."""

    def attacker(self, mode, *words, seconds=600.0, source=PILOT):
        program = self.begin(mode, [ATTACK, mode, str(self.domain), self.VEHICLE, "--source", source, "--seconds",
                                    str(seconds), *words], aside)
        self.wait_for_text(program, "ready", BOOT_S, program.err_path)
        return program

    def end_attacker(self, program, wait_s=0.0):
        """Its counts; it may end by itself for so long."""
        if wait_s:
            program.wait(wait_s)
        program.stop()
        counts = json.loads(program.out().splitlines()[-1])
        self.assertEqual(program.process.returncode, 0, counts)
        return counts

    def begin_attack(self):
        return ([self.attacker(mode, "--rate", str(rate)) for mode, rate in RATES.items()]
                + [self.attacker("deaf-reader")])

    def end_attack(self, attackers):
        """Messages sent, and a second while all ran."""
        counts = [self.end_attacker(program) for program in attackers]
        return (sum(count.get("sent", 0) for count in counts), sum(count.get("per_second", 0) for count in counts))

    def stop_from_anyone(self, limit_s=10):
        """(from sending to the bus, to `accepted`, to `completed` in s, tries) of a plain client's emergency stop."""
        told = run([ATTACK, "stop", str(self.domain), self.VEHICLE, "--source", "bystander", "--seconds", str(limit_s)],
                   self.environment(), limit_s + 30)
        counts = json.loads(told.out)
        self.assertEqual(told.code, 0, counts)
        sent_ns = counts["sent_ns"]
        # The newest of a frame is the only one that is completed, so `accepted` may have been another's.
        self.assertIsNotNone(counts["accepted_ns"], counts)
        stop_ns = wait_until(lambda: self.stopped_ns(sent_ns), 10, "the stop is on the bus")
        return tuple((ns - sent_ns) / 1e9 for ns in (stop_ns, counts["accepted_ns"], counts["completed_ns"])) + (
            counts["tries"],)

    def watch(self):
        program = self.attacker("watch")
        wait_until(lambda: self.heard(program), BOOT_S, "a status is heard")
        return program

    def heard(self, watcher, since_ns=0):
        """Statuses since then, of all daemons of this name."""
        return [s for s in watcher.json_lines() if s.get("time_ns", -1) >= since_ns]

    def next_status(self, watcher, daemon=None):
        """Of that daemon, or of any."""
        now_ns = time.monotonic_ns()
        return wait_until(lambda: [s for s in self.heard(watcher, now_ns)
                                   if daemon is None or s["pid"] == daemon.process.pid], 10, "a status comes")[0]

    def moves_for(self, watcher, seconds):
        """Overruns meanwhile; it never leaves its mode."""
        before, begin_ns = self.next_status(watcher), time.monotonic_ns()
        time.sleep(seconds)  # tests the time
        after = self.next_status(watcher)
        modes = {s["mode"] for s in self.heard(watcher, begin_ns)}
        self.assertEqual(modes, {self.MODE}, "it goes on moving")
        return after["overruns"] - before["overruns"], after["frames"] - before["frames"]

    def under_all_floods(self, daemon):
        watcher = self.watch()
        idle, attacked = [0, 0], [0, 0]
        stops, grown_kb = [], []
        for count in range(ROUNDS):
            client = self.begin_motion(count)
            idle = [a + b for a, b in zip(idle, self.moves_for(watcher, ATTACK_S / ROUNDS))]
            before_kb = rss_kb(daemon.process)
            attackers = self.begin_attack()
            attacked = [a + b for a, b in zip(attacked, self.moves_for(watcher, ATTACK_S / ROUNDS))]
            grown_kb.append(rss_kb(daemon.process) - before_kb)
            stops.append(self.stop_from_anyone())
            sent, rate = self.end_attack(attackers)
            print(f"round {count + 1}: {sent:.0f} messages, {rate:.0f}/s; stop on the bus after "
                  f"{stops[-1][0] * 1e3:.1f} ms, accepted {stops[-1][1] * 1e3:.1f}, completed {stops[-1][2] * 1e3:.1f}, "
                  f"{stops[-1][3]} tries; VmRSS {before_kb} kB and {grown_kb[-1]:+d}")
            self.assertGreater(rate, SENT_AT_LEAST, "the machine is too slow for an attack")
            self.wait_state(FATAL_ERROR)
            client.wait(20)
            # Nobody is locked out: the pilot goes on under the same name.
            self.cli_ok("--source", PILOT, "solve", limit_s=90)
            self.wait_state(IDLE)
        print(f"late frames: {attacked[0]} of {attacked[1]} under attack, {idle[0]} of {idle[1]} before")
        client = self.begin_motion(ROUNDS)
        self.cli_ok("--source", PILOT, "stop", limit_s=90)
        self.wait_state(IDLE)
        client.kill()
        on_bus = [stop[0] for stop in stops]
        self.assertLessEqual(statistics.median(on_bus), MEDIAN_S)
        self.assertLessEqual(max(on_bus), MOST_S)
        # The first round warms up; frames from before a stop are not caused by the attack.
        self.assertLess(sum(grown_kb[1:]), GROWTH_KB, f"VmRSS grew in each round by {grown_kb} kB")
        self.assertLessEqual(attacked[0], idle[0] + max(1, 0.01 * attacked[1]), "frames are late because of it")


def first_emergency_ns(log, since_ns):
    """On the line of Lunar Zebro."""
    return next((f.time_ns for f in wire.orders(log, since_ns) if f.code == wire.EMERGENCY), None)
