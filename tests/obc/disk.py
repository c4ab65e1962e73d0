"""A disk that loses power like a real one. Killing QEMU is no power cut: data of the guest is in the host's memory
already, and survives. This disk (an NBD server) keeps writes in its own cache until a flush; a power cut leaves of each
unflushed write all, nothing, or its first sectors, by the seed. A sector, which is written as a whole or not at all, has
4 kB, as in flash: with smaller ones a commit of ext4's journal can be torn, and then ext4 needs e2fsck before the next
mount, which the box does not have.
"""

import os
import random
import socket
import struct
import threading

SECTOR = 4096
# https://github.com/NetworkBlockDevice/nbd/blob/master/doc/proto.md
HELLO = struct.pack(">QQH", 0x4E42444D41474943, 0x49484156454F5054, 3)  # fixed newstyle, no zeroes
OPTION, OPTION_REPLY = 0x49484156454F5054, 0x3E889045565A9
OPT_EXPORT_NAME, OPT_ABORT, OPT_INFO, OPT_GO = 1, 2, 6, 7
REP_ACK, REP_INFO, REP_ERR_UNSUP = 1, 3, 0x80000001
REQUEST, REPLY = 0x25609513, 0x67446698
READ, WRITE, DISCONNECT, FLUSH = 0, 1, 2, 3
FLAGS = 1 | 4 | 8  # has flags, flush, force unit access
FUA = 1


class Disk:
    """image: a copy of it is written to. Each connection is a computer that has it; one at a time."""

    def __init__(self, image, folder, seed):
        self.random = random.Random(seed)
        self.size = os.path.getsize(image)
        self.path = os.path.join(folder, "disk")  # data for reads
        self.safe_path = os.path.join(folder, "safe")  # data that survives a power cut
        for path in (self.path, self.safe_path):
            copy(image, path)
        self.file = os.open(self.path, os.O_RDWR)
        self.safe = os.open(self.safe_path, os.O_RDWR)
        self.cached = []  # (offset, bytes), in their order
        self.flushes = 0
        self.writes_left = None
        self.stopped = threading.Event()
        self.address = os.path.join(folder, "nbd")
        self.name = f"nbd:unix:{self.address}"
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(self.address)
        self.listener.listen(1)
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def serve(self):
        while True:
            try:
                line, _ = self.listener.accept()
            except OSError:
                return
            with line:
                try:
                    self.agree(line)
                    while self.answer(line):
                        pass
                except (ConnectionError, EOFError):
                    pass  # its power was cut
            self.gone.set()

    @staticmethod
    def receive(line, size):
        data = bytearray()
        while len(data) < size:
            got = line.recv(size - len(data))
            if not got:
                raise EOFError
            data += got
        return bytes(data)

    def agree(self, line):
        self.gone = threading.Event()
        line.sendall(HELLO)
        self.receive(line, 4)
        while True:
            magic, option, size = struct.unpack(">QII", self.receive(line, 16))
            assert magic == OPTION
            self.receive(line, size)
            if option == OPT_EXPORT_NAME:
                line.sendall(struct.pack(">QH", self.size, FLAGS))
                return
            if option in (OPT_GO, OPT_INFO):
                info = struct.pack(">HQH", 0, self.size, FLAGS)
                line.sendall(struct.pack(">QIII", OPTION_REPLY, option, REP_INFO, len(info)) + info)
            known = option in (OPT_GO, OPT_INFO, OPT_ABORT)
            line.sendall(struct.pack(">QIII", OPTION_REPLY, option, REP_ACK if known else REP_ERR_UNSUP, 0))
            if option == OPT_GO:
                return
            if option == OPT_ABORT:
                raise EOFError

    def answer(self, line):
        magic, flags, kind, handle, offset, size = struct.unpack(">IHHQQI", self.receive(line, 28))
        assert magic == REQUEST
        data = b""
        if kind == READ:
            data = os.pread(self.file, size, offset)
        elif kind == WRITE:
            written = self.receive(line, size)
            os.pwrite(self.file, written, offset)
            self.cached.append((offset, written))
            if self.writes_left == 1:
                self.stopped.set()
                while line.recv(65536):  # it accepts nothing any more, until its computer is gone
                    pass
                return False
            if self.writes_left:
                self.writes_left -= 1
            if flags & FUA:
                self.flush()
        elif kind == FLUSH:
            self.flush()
        elif kind == DISCONNECT:
            return False
        else:
            raise AssertionError(f"no such request: {kind}")
        line.sendall(struct.pack(">IIQ", REPLY, 0, handle) + data)
        return True

    def flush(self):
        for offset, data in self.cached:
            os.pwrite(self.safe, data, offset)
        self.cached = []
        self.flushes += 1

    def stop_in_write(self, count, limit_s):
        """The disk is dead from the so manieth write on, which it has in its cache; returns when it is."""
        self.stopped.clear()
        self.writes_left = count
        if not self.stopped.wait(limit_s):
            raise AssertionError(f"no {count} writes in {limit_s} s")

    def lose_power(self):
        """After its computer is gone. Unflushed writes: their number, and how many of them are complete."""
        self.gone.wait()
        self.writes_left = None
        kept = 0
        for offset, data in self.cached:
            sectors = max(1, len(data) // SECTOR)
            left = self.random.choice((0, self.random.randrange(sectors), sectors))
            kept += left == sectors
            os.pwrite(self.safe, data if left == sectors else data[:left * SECTOR], offset)
        for offset, data in self.cached:
            os.pwrite(self.file, os.pread(self.safe, len(data), offset), offset)
        lost, self.cached = len(self.cached), []
        return lost, kept

    def close(self):
        self.listener.shutdown(socket.SHUT_RDWR)
        self.listener.close()
        self.thread.join(10)
        os.close(self.file)
        os.close(self.safe)


def copy(image, path):
    """Sparse, as the image is."""
    with open(image, "rb") as source, open(path, "wb") as target:
        size = os.path.getsize(image)
        target.truncate(size)
        at = 0
        while True:
            try:
                begin = os.lseek(source.fileno(), at, os.SEEK_DATA)
            except OSError:  # nothing but a hole follows
                return
            end = os.lseek(source.fileno(), begin, os.SEEK_HOLE)
            os.copy_file_range(source.fileno(), target.fileno(), end - begin, begin, begin)
            at = end
