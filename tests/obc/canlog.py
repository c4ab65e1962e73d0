"""The candump log of Ardito's bus, decoded with docs/icd-ardito.md alone. Times are whole microseconds."""

import re
import statistics
import struct
from typing import NamedTuple

RATE_BIT_S = 500_000
PERIOD_US, LEAD_US, OFFSET_US = 100_000, 10_000, 10_000  # config/ardito.toml
TPDOS_US, RPDOS_US = 5_800, 3_400  # section 6: their maximum time on the wire

SYNC, MASTER = 0x080, 0x77F
WHEELS = [0x201 + i for i in range(6)]
STEERING = [0x211, 0x212, 0x215, 0x216]
DRIVES = WHEELS + STEERING
ORDERS = DRIVES + [0x220]
# Section 5, those that come for each SYNC.
TPDOS = ([0x181 + i for i in range(6)] + [0x281 + i for i in range(6)] + [0x191, 0x192, 0x195, 0x196]
         + [0x291, 0x292, 0x295, 0x296] + [0x1A0, 0x2A0, 0x1A1])
SPEEDS = [0x181 + i for i in range(6)]
QUICK_STOP = 0x0002


class Frame(NamedTuple):
    time_us: int
    id: int
    data: bytes

    @property
    def controlword(self):
        return struct.unpack_from("<H", self.data)[0]

    @property
    def enables(self):
        """Of an order to a drive: the power stage is on, and the motor follows."""
        return self.controlword & 0x0F == 0x0F

    @property
    def motor_rpm(self):
        """Of the first measurement of a wheel drive."""
        return struct.unpack_from("<i", self.data, 2)[0]

    @property
    def bits(self):
        """On the wire: with stuff bits and the three of the space between frames."""
        head = f"0{self.id:011b}000{len(self.data):04b}" + "".join(f"{byte:08b}" for byte in self.data)
        crc = 0
        for bit in head:
            crc = (crc << 1 ^ (0x4599 if (crc >> 14 & 1) != int(bit) else 0)) & 0x7FFF
        text, stuffed, last, run = f"{head}{crc:015b}", 0, "", 0
        for bit in text:
            run = run + 1 if bit == last else 1
            last = bit
            if run == 5:  # the stuff bit is the other one, and begins a run itself
                stuffed, last, run = stuffed + 1, "10"[int(bit)], 1
        return len(text) + stuffed + 13


def read(path):
    """Data frames of a log that `candump -L -d` wrote; it contains a note about lost frames."""
    frames = []
    with open(path, encoding="ascii") as file:
        for line in file:
            found = re.match(r"\((\d+)\.(\d{6})\) \S+ ([0-9A-F]{3})#([0-9A-F]*)\s*$", line)
            if found:
                frames.append(Frame(int(found[1]) * 1_000_000 + int(found[2]), int(found[3], 16), bytes.fromhex(found[4])))
            else:  # an error frame, an extended one, or one that asks
                assert re.match(r"\(\d+\.\d{6}\) \S+ ([0-9A-F]{8}#|[0-9A-F]{3}#R)", line), f"candump says: {line}"
    return frames


def rpm(speed_m_s):
    """Of a motor, at a speed of the rover: section 3."""
    return speed_m_s * 3183


def syncs(frames):
    return [frame.time_us for frame in frames if frame.id == SYNC]


def gaps(times_us):
    return [after - before for before, after in zip(times_us, times_us[1:])]


def text(values_us):
    return (f"mean {statistics.mean(values_us) / 1e3:.4f} ms, sigma {statistics.pstdev(values_us):.1f} us, "
            f"min {min(values_us) / 1e3:.3f} ms, max {max(values_us) / 1e3:.3f} ms")


def loads(frames):
    """How full the bus is, of each whole second."""
    first_us = frames[0].time_us
    bits = [0] * ((frames[-1].time_us - first_us) // 1_000_000)
    for frame in frames:
        second = (frame.time_us - first_us) // 1_000_000
        if second < len(bits):
            bits[second] += frame.bits
    return [count / RATE_BIT_S for count in bits]


def cycles(frames):
    """From each SYNC to the next: its frames."""
    begins = [i for i, frame in enumerate(frames) if frame.id == SYNC]
    return [frames[begin:end] for begin, end in zip(begins, begins[1:])]


def last_orders(frames):
    """The last order of each drive."""
    return {frame.id: frame for frame in frames if frame.id in DRIVES}
