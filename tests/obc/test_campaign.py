"""A short campaign of faults with everything as it is on an OBC: the installed daemon, CAN, faults of `lss-sim`, commands of `lss-cli`.
Scenarios come from a seed: LSS_OBC_SEED, 1; how many: LSS_OBC_SCENARIOS, 8. Hundreds, in virtual time: tests/campaign/."""

import json
import os
import random
import unittest

import canlog
from box import setUpModule  # noqa: F401  pylint: disable=unused-import
from rover import SIM, UNIT, Rover

SCENARIOS = int(os.environ.get("LSS_OBC_SCENARIOS", "8"))
SEED = int(os.environ.get("LSS_OBC_SEED", "1"))
LAST_S = 9  # then all faults are cleared
REST_S, STILL_M_S = 3, 0.02  # as tests/campaign/ardito.cpp
TRUTH_S = 0.2  # its known times
OPERATIONAL = 1  # State of idl/lss.idl
UNCLEAR = (1, 3, 7)  # exit codes (lss-cli --help): internal error, unreachable, outcome unknown
WHEELS = range(1, 7)
NODES = [1, 2, 3, 4, 5, 6, 0x11, 0x12, 0x15, 0x16, 0x20, 0x21]
KINDS = ([f"{kind}:{wheel}" for kind in ("H-TM", "E-TM", "E-TRG", "TM", "TRG", "TC") for wheel in WHEELS]
         + [f"{kind}:{wheel}" for kind in ("SM", "SRG", "E-SM", "E-SRG") for wheel in (1, 2, 5, 6)]
         + [f"{kind}:{node}" for kind in ("node-silent", "node-reboot", "emcy-storm", "babble", "wrong-pdo-length") for node in NODES]
         + [f"drive-fault:{node}" for node in NODES[:10]]
         + ["foreign-frames", "e-stop-button", "power-bad", "imu-stuck"] * 6)
COMMANDS = ["halt", "park 5", "drive 0.1", "drive -- -0.2", "stop", "estop", "solve", "start", "reset"]


class Campaign(Rover):
    def story(self, number):
        """(when, what): faults as for lss-sim, and commands."""
        drawn = random.Random(f"{SEED} {number}")
        deeds = []
        for _ in range(drawn.randint(1, 2)):
            fault, at_s = drawn.choice(KINDS), drawn.uniform(0, 6)
            deeds.append((at_s, f"lss-sim fault --dir {SIM} {fault}"))
            if drawn.random() < 0.5:
                deeds.append((drawn.uniform(at_s, LAST_S), f"lss-sim fault --dir {SIM} clear:{fault.split(':')[0]}"))
        deeds += [(drawn.uniform(0, LAST_S), f"lss-cli {drawn.choice(COMMANDS)}") for _ in range(drawn.randint(0, 3))]
        return sorted(deeds)

    def play(self, deeds):
        """Exit codes of the commands."""
        script, now_s = "", 0.0
        for at_s, what in deeds:
            script += f"sleep {at_s - now_s:.3f}; timeout -s INT 4 {what} > /dev/null 2>&1; echo $?; "
            now_s = at_s
        return [int(line) for line in self.must(f"{script} sleep {LAST_S - now_s:.3f}", 120).splitlines()]

    def repair(self):
        """Back to Idle, as a person would."""
        self.must(f"lss-sim fault --dir {SIM} clear")
        self.end_drive()
        self.all_nodes_run()
        for _ in range(8):
            state = self.wait_status("s['state'] in ('Idle', 'Operational', 'FatalError')", "it does not solve any more", 60)["state"]
            if state == "Idle":
                return
            self.run_there("lss-cli solve" if state == "FatalError" else "lss-cli stop", 60)
        self.fail(f"it does not come back to Idle: {json.dumps(self.status()['faults'])}")

    def states(self):
        """[(UTC at which orders of a frame leave, in us, whether it may move)] of this run of the daemon."""
        times = []
        for name in sorted(self.must("find /var/lib/lss -name '*.lssrec' -newer /run/scenario").split()):
            frames, _, ahead_ns = self.frames_of(name)
            times += [((f["in"]["time_ns"] + ahead_ns) // 1000 + canlog.OFFSET_US, f["state"]["controller"]["state"] == OPERATIONAL)
                      for f in frames]
        return times

    def motion(self):
        """[(UTC in us, speed)] of the rover."""
        now, line = self.must("echo $EPOCHREALTIME; tail -n 2 /run/truth.jsonl | head -n 1").splitlines()
        ahead_us = int(now.replace(".", "")) - int(json.loads(line)["t_s"] * 1e6)
        self.must(f"tail -n {(LAST_S + 300) * 10} /run/truth.jsonl > /mnt/host/truth.jsonl")
        with open(os.path.join(self.share, "truth.jsonl"), encoding="ascii") as file:
            lines = [json.loads(text) for text in file.read().split("\n")[1:-1]]
        return [(ahead_us + int(t["t_s"] * 1e6), max(map(abs, t["velocity_m_s"]))) for t in lines]

    def what_must_hold(self, frames):
        """Outside Operational no drive is ordered to turn, and soon the rover stands."""
        orders = [f for f in frames if f.id in canlog.DRIVES and f.enables]
        states, motion = self.states(), self.motion()
        stops, since_us, at, looked = 0, None, 0, 0
        for (begin_us, moves), (end_us, _) in zip(states, states[1:]):
            if moves:
                since_us = None
                continue
            if since_us is None:
                since_us, stops = begin_us, stops + 1
            while at < len(orders) and orders[at].time_us <= begin_us + canlog.RPDOS_US:
                at += 1
            wrong = at < len(orders) and orders[at].time_us < end_us
            self.assertFalse(wrong, "a drive is ordered to turn outside Operational")
            still_us = since_us + (REST_S + TRUTH_S) * 1e6
            if begin_us > still_us:
                speeds = [v for t, v in motion if begin_us <= t < end_us]
                looked += len(speeds)
                self.assertTrue(all(v < STILL_M_S for v in speeds), f"{(begin_us - since_us) / 1e6:.1f} s after it left Operational: {speeds}")
        self.assertGreater(looked, 0, "the rover was seen at rest")
        return len(states), stops

    def test_with_any_faults_nothing_moves_but_in_operational_and_it_comes_back(self):
        held = frames_in_all = stops_in_all = commands = 0
        for number in range(1, SCENARIOS + 1):
            deeds = self.story(number)
            with self.subTest(number=number, story=[f"{at_s:.1f} s {what}" for at_s, what in deeds]):
                self.run_there("systemctl stop watch; true")
                self.must(f"touch /run/scenario; sleep 0.1; systemctl restart {UNIT}", 120)
                self.all_nodes_run()
                self.repair()
                pid, begun = self.pid(UNIT), self.status()
                self.watch_bus(f"scenario-{number}")
                self.drive(random.Random(number).choice((0.1, 0.3, 0.5)))
                codes = self.play(deeds)
                commands += sum("lss-cli" in what for _, what in deeds)
                for code, (_, what) in zip(codes, deeds):
                    self.assertTrue("lss-sim" in what or code not in UNCLEAR, f"{what}: {code}")
                self.repair()
                self.drive(0.2)
                self.run_there("systemctl kill -s INT drive")
                self.wait_status("s['state'] == 'Idle'", "it drove again and stopped", 60)
                status = self.status()
                self.assertEqual(self.pid(UNIT), pid, "the daemon is the same process")
                self.assertEqual(status["frame"]["overruns"], begun["frame"]["overruns"], "no frame was late")
                self.end_drive()
                seen = self.seen()
                self.must(f"systemctl stop {UNIT}", 60)  # its recording is ended
                count, stops = self.what_must_hold(seen)
                self.must("lssd --replay $(find /var/lib/lss -name '*.lssrec' -newer /run/scenario)", 300)
                held, frames_in_all, stops_in_all = held + 1, frames_in_all + count, stops_in_all + stops
                print(f"{number}: {'; '.join(f'{at_s:.1f} s {what.split(SIM)[-1].strip()}' for at_s, what in deeds)}: "
                      f"{count} frames, {stops} times out of Operational, {len(seen)} frames on the bus", flush=True)
        print(f"all held in {held} of {SCENARIOS} scenarios: {commands} commands, {frames_in_all} frames, "
              f"{stops_in_all} times out of Operational")


if __name__ == "__main__":
    unittest.main()
