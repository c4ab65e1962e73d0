"""Programs that a test starts: their logs, waits that end, and no process left behind."""

import collections
import ctypes
import json
import os
import signal
import subprocess
import threading
import time

Result = collections.namedtuple("Result", "code out err")
LIBC = ctypes.CDLL(None, use_errno=True)
PR_SET_PDEATHSIG = 1
HARDWARE_PRIORITY = 60
patience = 1  # times each limit: simulated time may be slower than the wall clock, and a limit then only ends what hangs


def wait_until(condition, limit_s, what, poll_s=0.05, most_s=None):
    """The result of the condition, once it is true; AssertionError after the time limit. Asks less and less often, but
    each `most_s` at least, where asking costs something."""
    end = time.monotonic() + patience * limit_s
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > end:
            raise AssertionError(f"not within {limit_s} s: {what}")
        time.sleep(poll_s)
        poll_s = min(1.25 * poll_s, most_s or poll_s)


def die_with_parent():
    LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def as_simulation():
    """Tests in real time come first."""
    die_with_parent()
    os.nice(5)


def as_hardware():
    """Hardware does not wait for a busy machine; below the daemon, so that it never delays the tested program."""
    die_with_parent()
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(HARDWARE_PRIORITY))
    except PermissionError:
        pass


class Program:
    """A process in the background. Its output goes to files of its name in the folder."""

    def __init__(self, name, words, folder, environment, before=die_with_parent, stderr=None):
        self.name = name
        self.out_path = os.path.join(folder, name + ".out")
        self.err_path = os.path.join(folder, name + ".err")
        with open(self.out_path, "ab") as out, open(self.err_path, "ab") as err:
            self.process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=out, stderr=stderr or err,
                                            env=environment, preexec_fn=before)
        self.end_signal = signal.SIGTERM

    def running(self):
        return self.process.poll() is None

    def out(self):
        return read_text(self.out_path)

    def err(self):
        return read_text(self.err_path)

    def json_lines(self):
        """Output of --jsonl so far; the last line may be incomplete."""
        return [json.loads(line) for line in self.out().split("\n")[:-1]]

    def say(self, line):
        self.process.stdin.write(line.encode() + b"\n")
        self.process.stdin.flush()

    def halt(self):
        """SIGSTOP; returns when all its threads stand still: until then one may still take what it waited for."""
        self.signal(signal.SIGSTOP)
        os.waitid(os.P_PID, self.process.pid, os.WSTOPPED)

    def signal(self, number):
        self.process.send_signal(number)

    def wait(self, limit_s):
        """Its exit code."""
        try:
            return self.process.wait(patience * limit_s)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"{self.name} did not end within {limit_s} s") from None

    def kill(self):
        """-9, and waits for its end."""
        if self.running():
            self.process.kill()
        self.process.wait()

    def stop(self, limit_s=20):
        if self.running():
            self.signal(self.end_signal)
            try:
                self.process.wait(limit_s)
            except subprocess.TimeoutExpired:
                self.kill()
        if not self.process.stdin.closed:
            try:
                self.process.stdin.close()
            except BrokenPipeError:
                pass


def read_text(path):
    with open(path, encoding="utf-8", errors="replace") as file:
        return file.read()


def run(words, environment, limit_s):
    """Runs to the end; a run that does not end is killed and an AssertionError."""
    process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, env=environment, preexec_fn=die_with_parent,
                               text=True, errors="replace")
    try:
        out, err = process.communicate(timeout=patience * limit_s)
    except subprocess.TimeoutExpired:
        process.kill()
        out, err = process.communicate()
        raise AssertionError(f"{' '.join(words)} did not end within {limit_s} s\n{out}{err}") from None
    return Result(process.returncode, out, err)


class Truth:
    """The simulator's true state, followed while it is written: (CLOCK_MONOTONIC ns, or simulated ns in lockstep, state)."""

    BEGIN_S = 1000  # drivers/lockstep/lockstep.h

    def __init__(self, path, lockstep=False):
        self.path, self.lockstep = path, lockstep
        self.samples = []
        self.ending = threading.Event()
        self.thread = threading.Thread(target=self.follow, daemon=True)
        self.thread.start()

    def follow(self):
        file, rest = None, ""
        while not self.ending.wait(0.02):
            if file is None:
                if not os.path.exists(self.path):
                    continue
                file = open(self.path, encoding="utf-8")
            *lines, rest = (rest + file.read()).split("\n")
            now_ns = time.monotonic_ns()
            states = [json.loads(line) for line in lines if line]
            self.samples += [(int((self.BEGIN_S + s["t_s"]) * 1e9) if self.lockstep else now_ns, s) for s in states]
        if file is not None:
            file.close()

    def stop(self):
        self.ending.set()
        self.thread.join()
