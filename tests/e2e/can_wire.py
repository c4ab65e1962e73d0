"""Frames of a CAN bus over UDP, from the interface documents alone: decodes the log of can_tap.py."""

import collections
import struct

import wire

Frame = collections.namedtuple("Frame", "time_ns to_daemon id data")


def decode(datagram):
    """[(identifier, data)] of a datagram of cannelloni."""
    version, operation, _, count = struct.unpack_from(">BBBH", datagram)
    if (version, operation) != (2, 0):
        return []
    found, offset = [], 5
    for _ in range(count):
        identifier, length = struct.unpack_from(">IB", datagram, offset)
        offset += 5
        found.append((identifier, datagram[offset:offset + length]))
        offset += length
    return found


def frames(log, since_ns=0):
    with open(log, "rb") as file:
        content = file.read()
    found, offset = [], 0
    while offset + wire.RECORD.size <= len(content):
        time_ns, direction, length = wire.RECORD.unpack_from(content, offset)
        offset += wire.RECORD.size
        datagram = content[offset:offset + length]
        offset += length
        if time_ns >= since_ns and len(datagram) == length:
            found += [Frame(time_ns, direction == wire.TO_DAEMON, *frame) for frame in decode(datagram)]
    return found


def quick_stops(frame):
    """A wheel drive of Ardito has its quick stop."""
    return not frame.to_daemon and 0x201 <= frame.id <= 0x206 and frame.data[:2] == b"\x02\x00"


def fans_off(frame):
    """All fans of TALARIS have no throttle."""
    return not frame.to_daemon and frame.id == 0x221 and frame.data == struct.pack("<4H", *[1000] * 4)


def all_shut(frame):
    """All valves of TALARIS are shut."""
    return not frame.to_daemon and frame.id == 0x220 and frame.data[:1] == b"\0"
