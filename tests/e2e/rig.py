"""The whole chain on one machine: lss-sim, lssd and lss-cli as they are installed, in a folder and a DDS domain
of their own. A test is a method of Scenario; all its programs are stopped, and their logs shown when it failed."""

import fcntl
import json
import os
import re
import shutil
import signal
import sys
import tempfile
import time
import unittest

import programs
import wire
from programs import as_hardware, as_simulation, die_with_parent, Program, read_text, run, Truth, wait_until

DAEMON = os.environ["LSS_E2E_DAEMON"]
TOOLS = os.environ["LSS_E2E_TOOLS"]
SIMULATOR = os.environ["LSS_E2E_SIMULATOR"]
PEER = os.environ["LSS_E2E_PEER"]
CLOCK = os.environ["LSS_E2E_CLOCK_LIBRARY"]
SOURCE = os.environ["LSS_E2E_SOURCE"]
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.append(os.path.join(os.path.dirname(HERE), "support"))
from own_domain import own_domain  # noqa: E402

# idl/codes.h, idl/commands.h and idl/zebro/commands.h number these; numbers are never reused.
IDLE, OPERATIONAL, FATAL_ERROR = "Idle", "Operational", "FatalError"
MODE_CHANGED = 4
WALKING = 4
REJECTED = 1
FAULT = {"emergency_stop": 1, "obc_silent": 2, "module_silent": 4, "port_lost": 11, "port_absent": 12,
         "shared_memory_lost": 15, "bus_noise": 16,
         "frame_overrun": 3, "bus_stuck": 17, "orders_stale": 20,
         "memory_lost": 90, "camera_lost": 59, "corner_altimeter_lost": 75,
         "emergency_button": 32, "altitude_lost": 46, "node_wrong": 35, "node_refuses": 36,
         "wheel_embedded": 74}
EXIT = {"usage": 2, "unreachable": 3, "unknown_name": 4, "rejected": 5, "failed": 6, "timed_out": 7,
        "not_authorised": 8}

BOOT_S = 20  # of the daemon, on a busy machine


def loopback(shared_memory):
    """CYCLONEDDS_URI of a program that is not ours."""
    return ('<CycloneDDS><Domain id="any"><General><Interfaces><NetworkInterface name="lo" multicast="true"/>'
            f'</Interfaces></General><SharedMemory><Enable>{str(shared_memory).lower()}</Enable></SharedMemory>'
            "</Domain></CycloneDDS>")


def edited(text, changes):
    """The configuration with other values; each key must be there, once."""
    for key, value in changes.items():
        text, count = re.subn(rf"(?m)^{key} *=[^#\n]*", f"{key} = {value} ", text)
        if count != 1:
            raise AssertionError(f"{count} keys {key} in the configuration")
    return text


def try_lock(file):
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return True
    except OSError:
        return False


def roudi_lives():
    """RouDi has a lock on this file as long as it runs."""
    with open("/tmp/iox-unique-roudi.lock", "a", encoding="ascii") as file:
        return not try_lock(file)


def real_time(why, any_machine=False):
    """For a test of a class in simulated time that cannot be. any_machine: it has no line, and may run on a machine that
    stands still."""
    def mark(test):
        test.real_time, test.any_machine = why, any_machine
        return test
    return mark


class Scenario(unittest.TestCase):
    """config: changes of config/NAME.toml; without shared memory unless a test is about it."""

    NAME = "zebro"  # of the vehicle
    MODULES = "modules"  # what must answer, in the telemetry
    IN_LOCKSTEP = False  # simulated time
    SPEED = 1  # of it against the wall clock; "max" where all that moves is commanded by `run`, which takes part
    PLANT = "kinematic"  # "dart" where forces matter
    MEASURES = False  # how long something takes by the wall clock, also in simulated time
    TOOLS = TOOLS  # folder of lss-cli and lss-ground

    @property
    def lockstep(self):
        return self.IN_LOCKSTEP and not hasattr(getattr(self, self._testMethodName), "real_time")

    @property
    def any_machine(self):
        """Whether it is independent of a machine that stands still."""
        test = getattr(self, self._testMethodName)
        return not self.MEASURES and (self.lockstep or getattr(test, "any_machine", False))

    @property
    def clock_words(self):
        """For lssd."""
        return ["--lockstep"] if self.lockstep else []

    @property
    def simulator_words(self):
        return ["--lockstep", "--speed", str(self.SPEED), "--client-speed", "max"] if self.lockstep else []

    def setUp(self):
        programs.patience = 5 if self.lockstep else 1
        self.folder = tempfile.mkdtemp(prefix="lss-e2e-")
        self.sim_folder = self.run_folder = os.path.join(self.folder, "run")
        os.mkdir(self.run_folder)
        self.domain, self.domain_lock = own_domain()
        self.programs = []
        self.truth = None
        self.addCleanup(self.clean_up)

    def clean_up(self):
        for program in reversed(self.programs):
            program.stop()
        if self.truth is not None:
            self.truth.stop()
        result = self._outcome.result
        failed = any(getattr(test, "test_case", test) is self for test, _ in result.failures + result.errors)
        if failed:
            self.show_logs()
        self.domain_lock.close()
        if failed and os.environ.get("LSS_E2E_KEEP"):
            print(f"kept: {self.folder}", file=sys.stderr)
        else:
            shutil.rmtree(self.folder)

    def show_logs(self):
        for program in self.programs:
            for path in (program.out_path, program.err_path):
                lines = read_text(path).splitlines()[-25:]
                if lines:
                    print(f"--- end of {os.path.basename(path)}", *lines, sep="\n", file=sys.stderr)

    # --- programs

    def environment(self, **more):
        kept = {k: v for k, v in os.environ.items() if k not in ("CYCLONEDDS_URI", "LSS_DOMAIN", "LSS_SOURCE")}
        return {**kept, "NO_COLOR": "1", "LSS_DOMAIN": str(self.domain), **more}

    def begin(self, name, words, before=die_with_parent, stderr=None, **environment):
        again = sum(p.name.split("#")[0] == name for p in self.programs)
        program = Program(f"{name}#{again + 1}" if again else name, words, self.folder,
                          self.environment(**environment), before, stderr)
        self.programs.append(program)
        return program

    def wait_for_text(self, program, text, limit_s, path=None):
        def said():
            if text in read_text(path or program.out_path):
                return True
            if not program.running():
                raise AssertionError(f"{program.name} ended with {program.process.returncode} before: {text}")
            return False
        wait_until(said, limit_s, f"{program.name}: {text}")

    def vehicle_words(self):
        """For lss-sim."""
        return ["--plant", self.PLANT]

    def start_sim(self, *words, seed=1):
        truth = os.path.join(self.folder, f"truth-{len(self.programs)}.jsonl")
        sim = self.begin("lss-sim", [SIMULATOR, self.NAME, "--dir", self.sim_folder, "--pace",
                                     *self.vehicle_words(), "--seed", str(seed), "--truth", truth,
                                     *self.simulator_words, *words],
                         as_simulation if self.lockstep else as_hardware)
        self.wait_for_text(sim, "ready", BOOT_S)
        if self.truth is not None:
            self.truth.stop()
        self.truth = Truth(truth, self.lockstep)
        return sim

    def config_text(self):
        return read_text(os.path.join(SOURCE, "config", f"{self.NAME}.toml"))

    def write_config(self, name=None, shared_memory=False, **changes):
        if not shared_memory:
            changes["shared_memory"] = "false"
        path = os.path.join(self.folder, name or f"{self.NAME}.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(edited(self.config_text(), changes))
        return path

    def start_daemon(self, config=None, wait=True, **how):
        config = config or self.write_config()
        daemon = self.begin("lssd", [DAEMON, "--config", config, "--run-dir", self.run_folder,
                                     "--domain", str(self.domain), *self.clock_words],
                            **{**({"before": as_simulation} if self.lockstep else {}), **how})
        if wait:
            self.wait_status(lambda s: s["state"] == IDLE, BOOT_S, "the daemon answers", daemon)
        return daemon

    def wait_modules(self):
        """Waits until all modules have answered, which `start` needs."""
        return self.wait_status(
            lambda s: s["telemetry"] and all(m["online"] is not False for m in s["telemetry"][self.MODULES]), BOOT_S,
            "all modules are heard")

    def start_all(self, **config):
        """Simulator and daemon, all modules have answered."""
        self.start_sim()
        daemon = self.start_daemon(self.write_config(**config))
        self.wait_modules()
        return daemon

    def start_with_clock(self):
        """As start_all(), with a wall clock that set_clock() sets."""
        self.clock = os.path.join(self.folder, "clock")
        self.set_clock(0)
        self.start_sim()
        daemon = self.start_daemon(LD_PRELOAD=CLOCK, LSS_E2E_CLOCK=self.clock)
        self.wait_modules()
        return daemon

    def set_clock(self, step_s):
        with open(self.clock, "r+b" if os.path.exists(self.clock) else "wb") as file:
            file.write(step_s.to_bytes(8, sys.byteorder, signed=True))

    def start_tap(self):
        """The simulator must run; daemons that start afterwards find it."""
        self.assertFalse(self.lockstep, "what is tapped is no port of the simulator: real_time()")
        self.run_folder = os.path.join(self.folder, "tapped")
        os.mkdir(self.run_folder)
        self.wire_log = os.path.join(self.folder, "wire.log")
        tap = self.begin("tap", [sys.executable, os.path.join(HERE, "tap.py"), os.path.join(self.sim_folder, "legs"),
                                 os.path.join(self.run_folder, "legs"), self.wire_log], as_hardware)
        self.wait_for_text(tap, "ready", BOOT_S)
        return tap

    def start_tapped(self, **config):
        self.start_sim()
        self.tap = self.start_tap()
        daemon = self.start_daemon(self.write_config(**config))
        self.wait_modules()
        return daemon

    def orders(self, since_ns):
        """Orders on the wire since then, when the tap has put them into its log."""
        now_ns = time.monotonic_ns()
        wait_until(lambda: any(f.time_ns > now_ns for f in wire.frames(self.wire_log, now_ns)), 10,
                   "the bus goes on")
        return wire.orders(self.wire_log, since_ns)

    def take_roudi(self):
        """There can be one RouDi on a machine: a test that needs one, or none, has this lock meanwhile."""
        lock = open("/tmp/lss-test-roudi.lock", "a", encoding="ascii")
        self.addCleanup(lock.close)
        wait_until(lambda: try_lock(lock), 300, "RouDi is ours")
        wait_until(lambda: not roudi_lives(), 30, "no RouDi but ours runs")

    def start_roudi(self):
        roudi = self.begin("iox-roudi", ["iox-roudi", "-c", os.path.join(SOURCE, "config", "roudi.toml")])
        roudi.end_signal = signal.SIGKILL  # asked to end it would end its clients, also those of others
        wait_until(roudi_lives, BOOT_S, "RouDi runs")
        self.wait_for_text(roudi, "ready for clients", BOOT_S)
        return roudi

    def start_roudi_and_sim(self):
        self.take_roudi()
        roudi = self.start_roudi()
        self.start_sim()
        return roudi

    def subscribe(self, count, shared_memory):
        """Output of a subscriber built from the IDL alone, for this number of samples, twice; it must receive them."""
        words = [PEER, "telemetry", str(self.domain), str(count), "15"]
        for _ in range(2):
            result = run(words, self.environment(CYCLONEDDS_URI=loopback(shared_memory)), 30)
            if result.code != -signal.SIGSEGV:
                break
            # Cyclone DDS 0.10.2 can crash a reader that joins a running stream of shared memory.
            print("a subscriber crashed while it joined and is started again")
        self.assertEqual(result.code, 0, result)
        return result.out

    # --- lss-cli

    def taking_part(self, *verb):
        return ("run", "--lockstep", "--dir", self.run_folder, "-e", " ".join(verb))

    def cli(self, *words, limit_s=60):
        """`run` takes part in simulated time, as do long verbs here; other verbs only query, or start something."""
        if self.lockstep:
            if words[0] in ("solve", "hop") or "--for" in words and words[0] not in ("run", "record"):
                words = self.taking_part(*words)
            elif words[0] == "run":
                words = ("run", "--lockstep", "--dir", self.run_folder, *words[1:])
        return run([os.path.join(self.TOOLS, "lss-cli"), *words], self.environment(), limit_s)

    def cli_ok(self, *words, limit_s=60):
        result = self.cli(*words, limit_s=limit_s)
        self.assertEqual(result.code, 0, f"lss-cli {' '.join(words)}: {result.err}{result.out}")
        return result

    def begin_cli(self, *words, name="lss-cli"):
        return self.begin(name, [os.path.join(self.TOOLS, "lss-cli"), *words])

    def begin_endless(self, *verb, options=(), name):
        """An attached motion without an end: fast until it is under way, then at the pace of the wall clock. `options`
        are of lss-cli."""
        words = self.taking_part(*verb, "; wait 3600s --at-speed") if self.lockstep else verb
        return self.begin_cli("--jsonl", *options, *words, name=name)

    def status(self):
        """As in `lss-cli --json status`; None without an answer, for which a slow simulation has time."""
        result = self.cli("--json", "--timeout", "20s", "status", limit_s=30)
        return json.loads(result.out) if result.code == 0 else None

    def wait_status(self, condition, limit_s, what, program=None):
        last = without = None

        def holds():
            nonlocal last, without
            if program is not None and not program.running():
                raise AssertionError(f"{program.name} ended with {program.process.returncode}\n{program.err()}")
            last = self.status()
            try:
                return last if last and condition(last) else None
            except TypeError as error:
                if last.get("telemetry") is not None:
                    raise
                without = error  # telemetry is late, on a busy machine
                return None
        try:
            return wait_until(holds, limit_s, what, poll_s=0.05, most_s=0.3)
        except AssertionError as error:
            raise AssertionError(f"{error}; last status: {json.dumps(last)}") from without

    def telemetry(self):
        """The newest, which may be late on a busy machine."""
        return self.wait_status(lambda s: s["telemetry"], BOOT_S, "telemetry arrives")["telemetry"]

    def wait_mode(self, mode, limit_s=60, client=None):
        return self.wait_status(lambda s: s["mode"] == mode, limit_s, f"mode {mode}", client)

    def wait_walking(self, client=None):
        return self.wait_mode("Walking", client=client)

    def wait_state(self, state, limit_s=30):
        return self.wait_status(lambda s: s["state"] == state, limit_s, f"state {state}")

    def begin_walk(self, *words, name="walk"):
        """An attached walk without an end, under way."""
        client = self.begin_endless("walk", "forward", "--speed", "high", options=words, name=name)
        self.wait_walking(client)
        return client

    def events(self):
        return json.loads(self.cli_ok("--json", "events").out)["events"]

    def assert_no_frame_waited(self):
        """Since `lss-cli timing --reset`. A frame that waits for something that stands still for a second misses 50; a busy
        machine that lets nothing stand still for longer than a frame was seen to make up to 5 late."""
        missed = json.loads(self.cli_ok("--json", "timing").out)["missed"]
        print("missed", missed)
        self.assertLess(missed["skipped"] + missed["overruns"], 10, missed)

    def walks(self):
        """[(begin_ns, end_ns)] of every time in mode Walking."""
        spans, begin_ns = [], None
        for event in self.events():
            if event["id"] != MODE_CHANGED:
                continue
            old, new = (int(n) for n in event["arguments"][:2])
            if new == WALKING:
                begin_ns = event["time_ns"]
            elif old == WALKING:
                spans.append((begin_ns, event["time_ns"]))
        return spans

    def fault(self, words):
        """In the simulator that runs: KIND[:ARG...], clear[:KIND]."""
        told = run([SIMULATOR, "fault", "--dir", self.sim_folder, words], self.environment(), 10)
        self.assertEqual(told.code, 0, told)

    # --- judgements

    def fault_ids(self, status):
        return {fault["id"] for fault in status["faults"]}

    def assert_resting(self, status):
        """Idle, no authority, no motor on as soon as the modules can report it."""
        self.assertEqual(status["state"], IDLE)
        self.assertIsNone(status["authority"])
        self.wait_status(lambda s: all(not m["motion_control"] and m["current_A"] < 0.02 for m in s["telemetry"]["modules"]), 1,
                         "all motors are off")

    def commander(self):
        """A client made from the IDL alone, see peer.c."""
        peer = self.begin("commander", [PEER, "commander", str(self.domain), "zebro-1"],
                          CYCLONEDDS_URI=loopback(False))
        self.wait_for_text(peer, "ready", BOOT_S)
        return peer

    def answers(self, peer, source, sequence, count=1, limit_s=10):
        """The first `count` acknowledgements of that command: [(phase, reason, time_ns)]."""
        def heard():
            lines = [line.split() for line in peer.out().split("\n")[:-1]]
            found = [tuple(int(n) for n in (w[4], w[5], w[6])) for w in lines
                     if w[0] == "ack" and w[1] == source and int(w[2]) == sequence]
            return found if len(found) >= count else None
        return wait_until(heard, limit_s, f"{source} {sequence} is acknowledged", poll_s=0.01)


class OnCan(Scenario):
    """A vehicle with a CAN bus over UDP."""

    def setUp(self):
        super().setUp()
        self.port = f"udp://127.0.0.1:{20000 + self.domain}"

    def vehicle_words(self):
        return ["--can", self.port]

    def config_text(self):
        return super().config_text().replace('"udp://127.0.0.1:20000"', f'"{self.port}"')

    def start_can_tap(self, name, port, to):
        log = os.path.join(self.folder, f"{name}.log")
        tap = self.begin(name, [sys.executable, os.path.join(HERE, "can_tap.py"), str(port), str(to), log])
        self.wait_for_text(tap, "ready", BOOT_S)
        return log

    def start_can_tapped(self, **config):
        """As start_tapped()."""
        self.start_sim()
        simulator, port = 20000 + self.domain, 20200 + self.domain
        self.wire_log = self.start_can_tap("tap", port, simulator)
        self.port = f"udp://127.0.0.1:{port}"
        daemon = self.start_daemon(self.write_config(**config))
        self.wait_modules()
        return daemon
