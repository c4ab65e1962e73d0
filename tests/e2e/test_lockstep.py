"""Simulated time: the same scenario gives the same bits, under any load of the machine. Each run is the programs as
they are installed, with their threads, files and DDS."""

import hashlib
import json
import os
import random
import signal
import struct
import subprocess
import sys
import threading
import time
import unittest

import recording
from programs import as_simulation, die_with_parent, read_text, run, wait_until
from rig import BOOT_S, DAEMON, SIMULATOR, SOURCE, TOOLS, Scenario, edited

RUN_LIMIT_S = 150
RELEASED = os.environ.get("LSS_E2E_RELEASED")
HOGS = 4
HOG_S = 2  # FIFO 99; longer than any machine stands still by itself
WATCHDOG_S = 8  # docs/icd-zebro.md 7
STOPPED_BY_WATCHDOG = 1 << 5  # docs/icd-zebro.md, flags


def spread(angles):
    """The widest range that one of the legs went through, rad, of a list of angles of all legs."""
    return max(max(leg) - min(leg) for leg in zip(*angles))


def one_cpu_and_nice():
    die_with_parent()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    os.nice(19)


def next_double(text):
    """The number after this one: one bit of it differs."""
    (bits,) = struct.unpack("<q", struct.pack("<d", float(text)))
    return repr(struct.unpack("<d", struct.pack("<q", bits + 1))[0])


def sha256(path):
    with open(path, "rb") as data:
        return hashlib.sha256(data.read()).hexdigest()


def without_build(path):
    """What is in a recording or a log but for the description of the program that wrote it."""
    if path.endswith(".lssrec"):
        header, items, ended = recording.read(path)
        return hashlib.sha256(repr(({**header, "build": None}, items, ended)).encode()).hexdigest()
    lines = read_text(path).splitlines()
    if path.endswith(".log.jsonl"):
        lines[0] = json.dumps({**json.loads(lines[0]), "build": None})
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()


class Stopper:
    """Stops one of the processes at a time for a while, at random moments, until end()."""

    def __init__(self, processes, seed):
        self.processes, self.random, self.ending, self.stops = processes, random.Random(seed), threading.Event(), 0
        self.thread = threading.Thread(target=self.work, daemon=True)
        self.thread.start()

    def work(self):
        while not self.ending.wait(self.random.uniform(0.05, 0.6)):
            process = self.random.choice(self.processes())
            if process.poll() is not None:
                continue
            process.send_signal(signal.SIGSTOP)
            time.sleep(self.random.uniform(0.3, 1.5))
            process.send_signal(signal.SIGCONT)
            self.stops += 1

    def end(self):
        self.ending.set()
        self.thread.join()


class Lockstep:
    """VEHICLE, WORDS of lss-sim, MOTION and SECONDS of simulated time, the same SHORT,
    CLIENT_AT, and KEY of the configuration, a number."""

    IN_LOCKSTEP = True
    CLIENT_AT = 3
    WORDS = ()
    CHANGES = {}  # of the configuration

    def config(self, **changes):
        text = read_text(os.path.join(SOURCE, "config", f"{self.VEHICLE}.toml")).replace(
            "udp://127.0.0.1:20000", f"udp://127.0.0.1:{20000 + self.domain}")
        path = os.path.join(self.folder, "config.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(edited(text, {"shared_memory": "false", **self.CHANGES, **changes}))
        return path

    def fly(self, name, before=as_simulation, disturb=None, short=False, program=DAEMON, content=sha256, **changes):
        """One run, in a folder of the same name each time. {file: hash} of its files."""
        motion, seconds = (self.SHORT, self.SHORT_S) if short else (self.MOTION, self.SECONDS)
        words = [SIMULATOR, self.VEHICLE, "--dir", self.run_folder, "--pace", "--lockstep", "--speed",
                 "max", "--seed", "7", "--truth", os.path.join(self.run_folder, "truth.jsonl"), "--for", str(seconds),
                 "--client-at", str(self.CLIENT_AT), *self.WORDS]
        if self.VEHICLE != "zebro":
            words += ["--can", f"udp://127.0.0.1:{20000 + self.domain}"]
        begun_s = time.monotonic()
        sim = self.begin(f"sim-{name}", words, before)
        wait_until(lambda: "ready" in sim.out() + sim.err() or not sim.running(), BOOT_S, "the simulator is ready")
        daemon = self.begin(f"lssd-{name}", [program, "--config", self.config(**changes), "--run-dir", self.run_folder,
                                             "--lockstep", "--domain", str(self.domain)], before)
        client = self.begin(f"cli-{name}", [os.path.join(TOOLS, "lss-cli"), "run", "--lockstep", "--dir", self.run_folder,
                                            "-e", motion], before)
        disturbance = disturb([sim, daemon, client]) if disturb else None
        self.assertEqual(client.wait(RUN_LIMIT_S), 0, client.err() + client.out())
        self.assertEqual(sim.wait(RUN_LIMIT_S), 0, sim.err())
        if disturbance is not None:
            disturbance.end()
            print(f"{name}: {disturbance.stops} stops")
        daemon.stop()
        left = {}
        for file in sorted(os.listdir(self.run_folder)):
            if not file.endswith((".jsonl", ".lssrec")):
                continue
            path = os.path.join(self.run_folder, file)
            left[file] = content(path)
            os.unlink(path)
        print(f"{name}: {time.monotonic() - begun_s:.1f} s; " + read_text(sim.err_path).strip().split("\n")[-1])
        self.assertEqual(len(left), 3, left)  # the true path, the flight recording, the log with its events
        return left

    def hogs(self, programs):
        """Four programs at FIFO 99 for seconds."""
        hog = [sys.executable, "-c", f"import time\nend = time.monotonic() + {HOG_S}\nwhile time.monotonic() < end: pass"]

        class Hogs:
            stops = HOGS
            processes = [subprocess.Popen(["chrt", "-f", "99", *hog], preexec_fn=die_with_parent) for _ in range(HOGS)]

            def end(self):
                for process in self.processes:
                    process.wait(60)
        return Hogs()

    def test_the_same_bits_when_processes_stand_still(self):
        first = self.fly("first")
        stopped = self.fly("stopped", disturb=lambda all_: Stopper(lambda: [p.process for p in all_], seed=1))
        self.assertEqual(stopped, first, "processes that stood still")
        value = next(line for line in read_text(self.config()).split("\n") if line.startswith(self.KEY + " "))
        value = value.split("=")[1].split("#")[0].strip()
        self.assertNotEqual(self.fly("one-bit", **{self.KEY: next_double(value)}), first, "one bit of a parameter")

    def test_the_same_bits_as_released(self):
        """Of a build with sanitizers."""
        if not os.path.exists(RELEASED or ""):
            self.skipTest("skipped: the release build is not there")
        first = self.fly("released", short=True, program=RELEASED, content=without_build)
        self.assertEqual(self.fly("this", short=True, content=without_build), first)

    def test_the_same_bits_on_a_slow_machine(self):
        first = self.fly("first", short=True)
        self.assertEqual(self.fly("slow", before=one_cpu_and_nice, short=True), first, "one CPU, nice 19")

    @unittest.skipUnless(os.geteuid() == 0, "needs SCHED_FIFO 99")
    def test_the_same_bits_beside_programs_at_fifo_99(self):
        first = self.fly("first", short=True)
        self.assertEqual(self.fly("hogs", disturb=self.hogs, short=True), first, "four programs at FIFO 99")


class Zebro(Lockstep, Scenario):
    VEHICLE, SECONDS = "zebro", 19
    MOTION = "start; stand; walk forward --speed high --for 2s; stop"
    SHORT, SHORT_S = "start; wait 1s; stop", 6
    KEY = "leg_diameter_mm"


class Ardito(Lockstep, Scenario):
    VEHICLE, SECONDS = "ardito", 22
    MOTION = "start; drive 0.3 --heading 5 --for 2s; park 0.4 --for 2s; stop"
    SHORT, SHORT_S = "start; stop", 15
    WORDS = ("--plant", "kinematic")
    KEY = "wheel_radius_mm"


class Talaris(Lockstep, Scenario):
    VEHICLE, SECONDS = "talaris", 40
    CHANGES = {"calibration_s": "5.0"}
    SHORT, SHORT_S = "edf arm; edf throttle 0.1; wait 1s; stop", 9
    MOTION = "hop --arm --height 2 --distance 5"
    KEY = "lift_y_m"


class Together(Scenario):
    """At the pace of the wall clock, with clients that do not take part."""

    IN_LOCKSTEP = True

    def simulated_s(self):
        return self.truth.samples[-1][1]["t_s"] if self.truth.samples else 0

    def test_who_hangs_is_named_and_who_was_killed_is_left_out(self):
        daemon = self.start_all()
        sim = self.programs[0]
        self.begin_walk()
        daemon.signal(signal.SIGSTOP)
        wait_until(lambda: "time stands still: waiting for lssd thread" in sim.err(), 10, "who hangs is named")
        stood_s = self.simulated_s()
        time.sleep(1)  # of the wall clock: simulated time must not move
        self.assertLess(self.simulated_s() - stood_s, 0.2)
        daemon.signal(signal.SIGCONT)
        wait_until(lambda: "time goes on" in sim.err(), 10, "time goes on")
        self.assertEqual(self.wait_walking()["faults"], [])

        legs = self.truth.samples[-1][1]["leg_angle_rad"]
        wait_until(lambda: spread([legs, self.truth.samples[-1][1]["leg_angle_rad"]]) > 0.5, 30, "the legs move")
        daemon.kill()
        silent_s = self.simulated_s() + WATCHDOG_S + 2
        wait_until(lambda: self.simulated_s() > silent_s + 1, 60, "time goes on without the daemon")
        angles = [state["leg_angle_rad"] for _, state in self.truth.samples if state["t_s"] > silent_s]
        self.assertLess(spread(angles), 0.001, "the legs stand still")
        self.start_daemon()
        for module in self.wait_modules()["telemetry"]["modules"][:6]:
            self.assertTrue(module["flags"] & STOPPED_BY_WATCHDOG, module)

    def test_a_daemon_begins_and_ends_while_time_stands_still(self):
        client_at_s = 3
        self.start_sim("--client-at", str(client_at_s))
        daemon = self.start_daemon(wait=False)
        wait_until(lambda: self.simulated_s() > client_at_s - 0.3, 60, "time waits for a client that does not come")
        time.sleep(1)  # of the wall clock: what is left until then
        daemon.signal(signal.SIGTERM)
        self.assertEqual(daemon.wait(12), 0)
        names = [name for name in os.listdir(self.run_folder) if name.endswith(".lssrec")]
        ended = [recording.read(os.path.join(self.run_folder, name))[2] for name in names]
        self.assertEqual(ended, [True], "the recording is whole")
        again = self.start_daemon(wait=False)
        self.wait_for_text(again, " ready: ", 20, again.err_path)
        again.signal(signal.SIGTERM)
        self.assertEqual(again.wait(12), 0)

    def test_ctrl_c_ends_a_wait_while_time_hardly_moves(self):
        self.SPEED = 0.1
        self.start_sim()
        self.start_daemon(wait=False)
        client = self.begin_cli("run", "--lockstep", "--dir", self.run_folder, "-e", "status; wait 1h --at-speed")
        self.wait_for_text(client, "OBC link", 60)
        begun_s = time.monotonic()
        client.signal(signal.SIGINT)
        self.assertEqual(client.wait(60), 6, client.err())
        self.assertLess(time.monotonic() - begun_s, 15, "3 s of simulated time take 30 s")

    def test_as_many_clients_take_part_as_have_places(self):
        self.start_all()
        clients = [self.begin_cli(*self.taking_part("wait 3600s --at-speed"), name=f"client-{i}") for i in range(5)]
        wait_until(lambda: not all(client.running() for client in clients), 60, "one of them is refused")
        (refused,) = [client for client in clients if not client.running()]
        self.assertEqual(refused.wait(1), 3)
        self.assertIn("4 programs take part as clients", refused.err())

    def refused(self, *words):
        told = run([DAEMON, "--run-dir", self.run_folder, "--domain", str(self.domain), "--lockstep", *words],
                   self.environment(), BOOT_S)
        self.assertEqual(told.code, 78, told)
        return told.err

    def test_what_cannot_follow_simulated_time_is_refused_with_what_to_do(self):
        self.assertIn("start lss-sim VEHICLE --lockstep first", self.refused("--config", self.write_config()))
        told = self.cli("run", "-e", "start")
        self.assertEqual(told.code, 3, told)
        self.assertIn("start lss-sim VEHICLE --lockstep", told.err)
        self.start_sim()
        device = self.write_config(path='"/dev/ttyS1"')
        self.assertIn("is no port of the simulator", self.refused("--config", device))
        told = run([SIMULATOR, "zebro", "--dir", self.folder, "--speed", "max"], self.environment(), 10)
        self.assertEqual(told.code, 2, told)


if __name__ == "__main__":
    unittest.main()
