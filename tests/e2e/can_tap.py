#!/usr/bin/env python3
"""can_tap.py PORT SIMULATOR LOG: stands between the daemon, which sends to the UDP port PORT of the loopback, and the
simulator's CAN bus at the port SIMULATOR; forwards datagrams both ways and logs them with the time of their arrival, as
tap.py does with bytes."""

import gc
import select
import socket
import sys
import time

import wire

FLUSH_NS = 100_000_000  # the log is read meanwhile


def main():
    gc.disable()  # no pauses
    port, simulator = (int(word) for word in sys.argv[1:3])
    ours, theirs = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
    ours.bind(("127.0.0.1", port))
    theirs.connect(("127.0.0.1", simulator))
    daemon = None
    flushed_ns = 0
    print("ready", flush=True)
    with open(sys.argv[3], "wb", buffering=1 << 16) as log:
        while True:
            files = select.select([ours, theirs], [], [], 0.05)[0]
            for file in files:
                now_ns = time.monotonic_ns()
                try:
                    data, sender = file.recvfrom(2048)
                except ConnectionRefusedError:  # the simulator is gone: lost, as on a wire
                    continue
                if file is ours:
                    daemon = sender
                log.write(wire.RECORD.pack(now_ns, wire.TO_MODULES if file is ours else wire.TO_DAEMON, len(data)) + data)
                try:
                    if file is ours:
                        theirs.send(data)
                    elif daemon is not None:
                        ours.sendto(data, daemon)
                except ConnectionRefusedError:
                    pass
            now_ns = time.monotonic_ns()
            if now_ns - flushed_ns > FLUSH_NS:
                log.flush()
                flushed_ns = now_ns


if __name__ == "__main__":
    main()
