#!/usr/bin/env python3
"""tap.py PORT LINK LOG: stands between the daemon and the modules, forwards in both directions, logs all bytes.

PORT is the simulator's pseudo-terminal; LINK is where the daemon finds ours. A port that is gone is opened
again when it is back. LOG has a record of wire.RECORD and the bytes for each piece that was forwarded. Lines on
the standard input:
    inject DIRECTION HEX        puts bytes on the wire, where no frame is under way
    truncate DIRECTION COUNT    of the next COUNT frames the second half is lost, their ends too
    merge DIRECTION COUNT       the next COUNT frames lose their ends
DIRECTION is 0 to the modules, 1 to the daemon.
"""

import errno
import gc
import os
import select
import sys
import termios
import time
import tty

import wire

FLUSH_NS = 100_000_000  # the log is read meanwhile


class Wire:
    """One direction: passes bytes on, with the ordered errors."""

    def __init__(self):
        self.inject = []
        self.spoil = None  # "truncate" or "merge"
        self.left = 0      # frames
        self.position = 0  # in the frame under way

    def through(self, data):
        if self.spoil is None and not self.inject:
            end = data.rfind(b"\n")
            self.position = self.position + len(data) if end < 0 else len(data) - end - 1
            return data
        out = bytearray()
        for byte in data:
            keep = True
            if self.spoil == "truncate":
                keep = self.position < wire.LENGTH // 2
            elif self.spoil == "merge":
                keep = byte != 0x0A
            if keep:
                out.append(byte)
            self.position += 1
            if byte == 0x0A:
                self.position = 0
                out += b"".join(self.inject)
                self.inject.clear()
                self.left = max(0, self.left - 1)
                if self.left == 0:
                    self.spoil = None
        return bytes(out)


def raw(fd):
    tty.setraw(fd, termios.TCSANOW)
    return fd


class Tap:
    def __init__(self, port, link, log):
        self.port = port
        self.log = open(log, "wb", buffering=1 << 16)
        self.wires = [Wire(), Wire()]
        self.modules = None
        self.ours, self.theirs = os.openpty()  # theirs stays open, so that ours outlives a daemon
        raw(self.theirs)
        os.set_blocking(self.ours, False)
        os.symlink(os.ttyname(self.theirs), link)

    def open_port(self):
        try:
            self.modules = raw(os.open(self.port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK))
        except (OSError, termios.error):
            self.modules = None

    def close_port(self):
        os.close(self.modules)
        self.modules = None

    def forward(self, direction):
        source, sink = [(self.ours, self.modules), (self.modules, self.ours)][direction]
        try:
            data = os.read(source, 4096)
        except OSError as error:
            if error.errno == errno.EAGAIN:
                return
            data = b""
        now = time.monotonic_ns()
        if not data:
            self.close_port()
            return
        data = self.wires[direction].through(data)
        self.log.write(wire.RECORD.pack(now, direction, len(data)) + data)
        if sink is not None and data:
            try:
                os.write(sink, data)
            except OSError:  # full or gone: lost, as on a wire
                pass

    def obey(self, line):
        verb, direction, argument = line.split()
        target = self.wires[int(direction)]
        if verb == "inject":
            target.inject.append(bytes.fromhex(argument))
        else:
            target.spoil, target.left = verb, int(argument)

    def run(self):
        commands, flushed_ns = b"", 0
        print("ready", flush=True)
        while True:
            if self.modules is None:
                self.open_port()
            files = [sys.stdin.fileno(), self.ours] + ([] if self.modules is None else [self.modules])
            ready = select.select(files, [], [], 0.05)[0]
            if self.modules in ready:
                self.forward(wire.TO_DAEMON)
            if self.ours in ready:
                self.forward(wire.TO_MODULES)
            if sys.stdin.fileno() in ready:
                piece = os.read(sys.stdin.fileno(), 65536)
                if not piece:
                    return
                *lines, commands = (commands + piece).split(b"\n")
                for line in lines:
                    self.obey(line.decode())
            if time.monotonic_ns() - flushed_ns > FLUSH_NS:
                self.log.flush()
                flushed_ns = time.monotonic_ns()


def main():
    gc.disable()  # no pauses
    tap = Tap(*sys.argv[1:4])
    try:
        tap.run()
    finally:
        tap.log.close()


if __name__ == "__main__":
    main()
