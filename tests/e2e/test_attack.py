"""What a program on the domain can do that has no more than the IDL: floods, invented names, replays, twins. Every stop is
obeyed meanwhile, and nobody is locked out afterwards."""

import os
import time
import unittest

import can_wire
from attack import AT_REST_S, ATTACK, PILOT, Attacked, OnTheBus, OnTheLine, rss_kb
from hopper_rig import Hopper
from programs import run, wait_until
from rig import EXIT, IDLE, Scenario
from rover_rig import Rover

NAME_CONFLICT_FAULT, NAME_CONFLICT = 55, 77  # idl/codes.h
NO_REASON, STALE_SEQUENCE = 0, 7
DATA, STOP, DRY_RUN = 6, 2, 1
REJECTED, STATE_IDLE = 1, 0  # lss.idl
CLEARS_S = 10


class Zebro(OnTheLine, Scenario):
    VEHICLE, MODE = "zebro-1", "Walking"

    def begin_motion(self, count):
        return self.begin_walk("--source", PILOT, name=f"walk-{count}")

    def test_walking_under_all_floods_it_obeys_every_stop_and_locks_nobody_out(self):
        self.under_all_floods(self.start_tapped())


class Ardito(OnTheBus, Rover):
    VEHICLE, MODE = "ardito-1", "Running"
    STOP_FRAME = staticmethod(can_wire.quick_stops)
    ECHOED = "0200000001" "00000201" "06" "020000000000"

    def begin_motion(self, count):
        client = self.begin_cli("--jsonl", "--source", PILOT, "drive", "0.3", name=f"drive-{count}")
        self.wait_mode("Running", 60, client)
        return client

    def test_driving_under_all_floods_it_obeys_every_stop_and_locks_nobody_out(self):
        self.under_all_floods(self.start_can_tapped(beacon_s="1.5"))


class Talaris(OnTheBus, Hopper):
    VEHICLE, MODE = "talaris-1", "Manual"
    STOP_FRAME = staticmethod(can_wire.fans_off)
    ECHOED = "0200000001" "00000221" "08" "E803E803E803E803"

    def begin_motion(self, count):
        """Fans at a tenth of their throttle, on the ground."""
        arm = "edf arm; " if count == 0 else ""
        begun_ns = time.monotonic_ns()
        client = self.begin_cli("--jsonl", "--source", PILOT, "run", "-e", arm + "edf throttle 0.1; wait 600s",
                                name=f"fans-{count}")

        def turn():
            sent = [f for f in can_wire.frames(self.wire_log, begun_ns) if not f.to_daemon and f.id == 0x221]
            return sent and sent[-1].data == bytes.fromhex("4c04") * 4  # 1100 us
        wait_until(turn, 60, "the fans turn")
        return client

    def test_with_turning_fans_under_all_floods_it_obeys_every_stop_and_locks_nobody_out(self):
        self.under_all_floods(self.start_can_tapped())


class Names(Attacked, Scenario):
    VEHICLE, MODE = "zebro-1", "Walking"

    def ask(self, peer, source, sequence, kind, flags=DRY_RUN):
        """Phase and reason of the first answer to this, whether the number was used before or not."""
        def answers():
            return [line.split()[4:6] for line in peer.out().split("\n")[:-1]
                    if line.startswith(f"ack {source} {sequence} ")]
        before = len(answers())
        peer.say(f"command {source} {sequence} {kind} {flags} 0")
        return tuple(int(word) for word in wait_until(lambda: answers()[before:], 10, "an answer", poll_s=0.01)[0])

    def test_the_largest_sequence_number_in_the_pilots_name_locks_nobody_out(self):
        self.start_all()
        walk = self.begin_walk("--source", PILOT)
        counts = self.end_attacker(self.attacker("max-sequence", "--rate", "20", seconds=1.0), 30)
        self.assertGreater(counts["sent"], 0)
        peer = self.commander()  # a new process begins at 1
        self.assertEqual(self.ask(peer, PILOT, 1, STOP)[1], NO_REASON)
        self.assertEqual(self.ask(peer, PILOT, 1, STOP)[1], STALE_SEQUENCE, "grows for each writer")
        self.cli_ok("--source", PILOT, "stop", limit_s=90)
        walk.wait(30)
        self.assert_resting(self.wait_state(IDLE))

    def test_a_clock_that_is_set_back_locks_nobody_out(self):
        self.start_with_clock()
        walk = self.begin_walk("--source", PILOT)
        self.set_clock(-86400)
        environment = self.environment(LD_PRELOAD=os.environ["LSS_E2E_CLOCK_LIBRARY"], LSS_E2E_CLOCK=self.clock)
        told = run([os.path.join(os.environ["LSS_E2E_TOOLS"], "lss-cli"), "--source", PILOT, "stop"], environment, 90)
        self.assertEqual(told.code, 0, told)
        walk.wait(30)
        self.wait_state(IDLE)

    def test_invented_names_lock_nobody_out_and_cost_no_memory(self):
        daemon = self.start_all()
        names = self.attacker("many-names")
        inventor = self.attacker("invent-sources", "--rate", "5000")
        time.sleep(4)  # warm-up
        before_kb = rss_kb(daemon.process)
        time.sleep(6)  # tests the time
        grown_kb = rss_kb(daemon.process) - before_kb
        peer = self.commander()
        self.assertEqual(self.ask(peer, "new-commander", 1, DATA)[1], NO_REASON)
        self.cli_ok("--source", PILOT, "run", "-e", "start; stop", limit_s=60)
        self.end_attacker(names)
        print(self.end_attacker(inventor), f"VmRSS grew by {grown_kb} kB")
        self.assertLess(grown_kb, 1024)

    # --- two daemons of one name

    def conflicts(self, watcher, pid, since_ns):
        """Whether its newest status since then has the fault; None: no status."""
        mine = [s for s in self.heard(watcher, since_ns) if s["pid"] == pid]
        return NAME_CONFLICT_FAULT in mine[-1]["faults"] if mine else None

    def wait_conflict(self, watcher, pid, wanted, limit_s):
        since_ns = time.monotonic_ns()
        wait_until(lambda: self.conflicts(watcher, pid, since_ns) is wanted, limit_s,
                   f"{pid} {'has' if wanted else 'has no'} name conflict: {self.heard(watcher)[-4:]}")
        return time.monotonic_ns() - since_ns

    def start_second(self):
        """Another daemon with another vehicle, of the same name."""
        first = self.sim_folder
        self.sim_folder = self.run_folder = os.path.join(self.folder, "second")
        os.mkdir(self.sim_folder)
        self.start_sim(seed=2)
        daemon = self.start_daemon(wait=False)
        self.sim_folder = self.run_folder = first
        return daemon

    def test_two_daemons_of_one_name_both_say_so_and_refuse_to_start_until_one_is_gone(self):
        first = self.start_all()
        watcher = self.watch()
        self.wait_conflict(watcher, first.process.pid, False, AT_REST_S + 5)
        walk = self.begin_walk("--source", PILOT)
        second = self.start_second()
        for daemon in (first, second):
            self.wait_conflict(watcher, daemon.process.pid, True, 10)
        # A moving vehicle stops safely.
        wait_until(lambda: self.next_status(watcher, first)["state"] == STATE_IDLE, 60, "the walk ends")
        self.assertNotEqual(walk.wait(30), 0, "its client says that the walk ended")

        peer = self.commander()
        peer.say("command new-pilot 1 1 0 2000 0 0 0 0")
        answers = self.answers(peer, "new-pilot", 1, count=2)
        self.assertEqual([answer[:2] for answer in answers], [(REJECTED, NAME_CONFLICT)] * 2)
        self.assertEqual(self.cli("start", limit_s=30).code, EXIT["rejected"])

        second.stop()
        cleared_s = self.wait_conflict(watcher, first.process.pid, False, CLEARS_S + 5) / 1e9
        print(f"cleared {cleared_s:.1f} s after the other was gone")
        self.assertGreater(cleared_s, CLEARS_S - 2)
        self.cli_ok("--source", PILOT, "run", "-e", "start; stop", limit_s=90)

    def test_a_heartbeat_of_a_twin_is_a_name_conflict_until_it_ends(self):
        daemon = self.start_all()
        watcher = self.watch()
        self.begin_walk("--source", PILOT)
        twin = self.attacker("twin", "--rate", "5")
        self.wait_conflict(watcher, daemon.process.pid, True, 5)
        wait_until(lambda: self.next_status(watcher)["state"] == STATE_IDLE, 60, "the walk ends")
        result = self.cli("start", limit_s=30)
        self.assertEqual(result.code, EXIT["rejected"], result)
        told = run([ATTACK, "stop", str(self.domain), self.VEHICLE], self.environment(), 30)
        self.assertEqual(told.code, 0, "an emergency stop is obeyed")
        self.end_attacker(twin)
        self.wait_conflict(watcher, daemon.process.pid, False, CLEARS_S + 5)
        self.cli_ok("--source", PILOT, "solve", limit_s=90)
        self.cli_ok("--source", PILOT, "run", "-e", "start; stop", limit_s=90)


if __name__ == "__main__":
    unittest.main()
