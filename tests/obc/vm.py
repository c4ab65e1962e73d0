"""An OBC in a box: QEMU without KVM, and a way to run commands in it.

Time in the box is counted in instructions, one nanosecond each, on one CPU, and leaps ahead when nothing is to do: a busy
host makes the box slow, never late. Deadlines are met or missed there as the code takes instructions, not as the host
has time. With a disk of its own, which has the host's time, it does not leap: while nothing is to do the host's time
passes. All limits are seconds in the box.
"""

import base64
import ctypes
import os
import re
import select
import shlex
import shutil
import signal
import socket
import subprocess
import tempfile
import time

IMAGE = os.environ["LSS_OBC_IMAGE"]
HANG_S = 4 * 3600  # of the host, without an answer: the last resort
KILLED = 137  # exit status
# Of each processor: the machine and its console.
MACHINES = {"amd64": (["qemu-system-x86_64", "-M", "q35", "-cpu", "max"], "ttyS0"),
            "arm64": (["qemu-system-aarch64", "-M", "virt", "-cpu", "cortex-a72"], "ttyAMA0")}


class Gone(Exception):
    """The machine ended while it was spoken to."""


def die_with_parent():
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


class Machine:
    """share: folder of this machine that is /mnt/host there. disk: the writable disk; none: discarded at the end."""

    SHIFT = 0  # an instruction takes 2^SHIFT ns

    def __init__(self, share, disk=None):
        self.folder = tempfile.mkdtemp(prefix="lss-obc-")
        self.listener = socket.socket(socket.AF_UNIX)
        path = os.path.join(self.folder, "agent")
        self.listener.bind(path)
        self.listener.listen(1)
        self.console = os.path.join(self.folder, "console")
        with open(os.path.join(IMAGE, "arch"), encoding="ascii") as file:
            machine, serial = MACHINES[file.read().strip()]
        words = [*machine, "-nodefaults", "-no-user-config", "-display", "none",
                 "-accel", "tcg,thread=single", "-icount", f"shift={self.SHIFT},sleep={'on' if disk else 'off'}",
                 "-rtc", "clock=vm", "-smp", "1", "-m", "768", "-no-reboot",
                 "-kernel", os.path.join(IMAGE, "vmlinuz"), "-initrd", os.path.join(IMAGE, "initrd.gz"),
                 "-append", f"root=/dev/vda rw console={serial} quiet panic=-1 mitigations=off nokaslr systemd.show_status=0",
                 "-serial", f"file:{self.console}",
                 "-drive", f"file={disk or os.path.join(IMAGE, 'root.ext4')},format=raw,if=none,id=disk,"
                           f"snapshot={'off' if disk else 'on'}",
                 "-device", "virtio-blk-pci,drive=disk", "-device", "virtio-rng-pci",
                 "-virtfs", f"local,path={share},mount_tag=host,security_model=none,multidevs=remap",
                 "-device", "virtio-serial", "-chardev", f"socket,id=agent,path={path}",
                 "-device", "virtserialport,chardev=agent,name=obc"]
        self.began_s = time.monotonic()
        with open(os.path.join(self.folder, "qemu"), "wb") as log:
            self.process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                                            preexec_fn=die_with_parent)
        self.line = None
        self.buffer = b""
        self.commands = 0

    def wait_for_boot(self):
        while not select.select([self.listener], [], [], 1)[0]:
            if self.process.poll() is not None:
                with open(os.path.join(self.folder, "qemu"), encoding="utf-8") as log:
                    raise Gone(log.read())
        self.line, _ = self.listener.accept()
        self.answer("ready")
        self.boot_s = time.monotonic() - self.began_s
        with open(f"/proc/{self.process.pid}/stat", encoding="ascii") as file:
            ticks = file.read().rsplit(")", 1)[1].split()[11:13]
        self.cpu_s = sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK")

    def read_line(self):
        while b"\n" not in self.buffer:
            ready, _, _ = select.select([self.line], [], [], HANG_S)
            if not ready:
                raise AssertionError(f"the machine hangs: no answer in {HANG_S} s\n{self.last_words()}")
            got = self.line.recv(65536)
            if not got:
                raise Gone(self.last_words())
            self.buffer += got
        line, self.buffer = self.buffer.split(b"\n", 1)
        return line.decode()

    def answer(self, name):
        while True:
            words = self.read_line().split()
            if words and words[0] == name:
                return int(words[1]), base64.b64decode(words[2]).decode(errors="replace").rstrip("\n")

    def run(self, command, limit_s=60):
        """Exit status and output of a shell command, as root."""
        self.commands += 1
        name = f"c{self.commands}"
        limited = f"timeout -s KILL {limit_s} bash -c {shlex.quote(command)}"
        self.line.sendall(f"{name} {base64.b64encode(limited.encode()).decode()}\n".encode())
        status, text = self.answer(name)
        if status == KILLED:
            raise AssertionError(f"not within {limit_s} s: {command}\n{text}\n{self.last_words()}")
        return status, text

    def must(self, command, limit_s=60):
        """The output of a command that has to succeed."""
        status, text = self.run(command, limit_s)
        if status != 0:
            raise AssertionError(f"{command}\nended with {status}:\n{text}")
        return text

    def last_words(self):
        with open(self.console, encoding="utf-8", errors="replace") as file:
            return "console: " + "\n".join(file.read().splitlines()[-20:])

    def cut_power(self):
        self.process.kill()
        self.process.wait()
        self.end()

    def end(self):
        self.process.kill()
        self.process.wait()
        for end in (self.line, self.listener):
            if end is not None:
                end.close()
        shutil.rmtree(self.folder, ignore_errors=True)
