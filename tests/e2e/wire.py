"""Frames of the RS-485 bus of Lunar Zebro, from the interface table alone: decodes the log of the tap."""

import collections
import struct

RECORD = struct.Struct("<qBH")  # CLOCK_MONOTONIC of arrival, direction, length of the bytes that follow
TO_MODULES, TO_DAEMON = 0, 1

START_MOTION, STOP_MOTION, FORWARD, BACKWARD, REQUEST, EMERGENCY, RESET = range(1, 8)
ROTATES = (FORWARD, BACKWARD)
STATUS_MOTION_ON, STATUS_MOVING = 1 << 0, 1 << 2
LENGTH = 24
MODULES = range(1, 8)

Frame = collections.namedtuple("Frame", "time_ns to_daemon address code data")


def encode(address, code, data=b""):
    body = bytes([address, code]) + data.ljust(8, b"\0")
    return b":" + (body + bytes([-sum(body) & 0xFF])).hex().upper().encode() + b"\n"


def decode(line):
    """(address, code, data), or None for an invalid frame."""
    if len(line) != LENGTH or line[:1] != b":" or line[-1:] != b"\n" or line != line.upper():
        return None
    try:
        body = bytes.fromhex(line[1:-1].decode("ascii"))
    except ValueError:
        return None
    return (body[0], body[1], body[2:10]) if sum(body) & 0xFF == 0 else None


def frames(log, since_ns=0):
    """Good frames of a tap's log, in the order of their ends, stamped with the arrival of the last byte."""
    with open(log, "rb") as file:
        content = file.read()
    pending = [b"", b""]
    found = []
    offset = 0
    while offset + RECORD.size <= len(content):
        time_ns, direction, length = RECORD.unpack_from(content, offset)
        offset += RECORD.size
        *lines, rest = (pending[direction] + content[offset:offset + length]).split(b"\n")
        offset += length
        pending[direction] = rest
        for line in lines:
            good = decode(line[line.rfind(b":"):] + b"\n")
            if good and time_ns >= since_ns:
                found.append(Frame(time_ns, direction == TO_DAEMON, *good))
    return found


def orders(log, since_ns=0):
    """Messages of the daemon other than requests."""
    return [f for f in frames(log, since_ns) if not f.to_daemon and f.code != REQUEST]


def stopped_ns(orders, codes):
    """Time of the last of the seven modules' orders with one of these codes; None when one got none."""
    first = {}
    for frame in orders:
        if frame.code in codes:
            for address in MODULES if frame.address == 0 else (frame.address,):
                first.setdefault(address, frame.time_ns)
    return max(first.values()) if set(first) >= set(MODULES) else None

