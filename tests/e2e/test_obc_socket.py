"""lss-cli serve: an OBC that polls a socket walks Lunar Zebro. Obc, the example of docs/cli.md, uses the standard
library only."""

import json
import os
import select
import socket
import time
import unittest
import zlib

from programs import wait_until
from rig import BOOT_S, FATAL_ERROR, FAULT, IDLE, Scenario

LEASE_S = 2  # of lss-cli


class Obc:
    def __init__(self, path):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.connect(path)
        self.stream = self.socket.makefile("rb")
        self.sequence = 0

    def ask(self, words):
        """The reply to this request; no other line may come before it."""
        self.sequence += 1
        text = f"{self.sequence} {words}".encode()
        self.socket.sendall(b"%08x %s\n" % (zlib.crc32(text), text))
        crc, rest = self.stream.readline().rstrip(b"\n").split(b" ", 1)
        assert int(crc, 16) == zlib.crc32(rest), rest
        sequence, reply = rest.split(b" ", 1)
        assert int(sequence) == self.sequence, rest
        return json.loads(reply)

    def hears_nothing(self, seconds):
        return not select.select([self.socket], [], [], seconds)[0]

    def close(self):
        self.stream.close()
        self.socket.close()


class ObcSocket(Scenario):
    IN_LOCKSTEP = True

    def start_served(self):
        self.start_all()
        path = os.path.join(self.folder, "obc")
        self.served = self.begin_cli("serve", "--socket", path, name="serve")
        wait_until(lambda: os.path.exists(path), BOOT_S, "the socket is there")
        obc = Obc(path)
        self.addCleanup(obc.close)
        return obc

    def perform(self, obc, words):
        """A command, polled until it is completed."""
        self.assertIn(obc.ask(words).get("phase"), ("accepted", "executing", "completed"))
        command = obc.sequence
        wait_until(lambda: obc.ask(f"result {command}")["phase"] == "completed", 60, words)

    def walk(self, obc):
        self.perform(obc, "start")
        self.perform(obc, "stand")
        self.assertIn(obc.ask("walk forward --speed high").get("phase"), ("accepted", "executing"))
        wait_until(lambda: obc.ask("heartbeat")["mode"] == "Walking", 60, "it walks")

    # [O-Int-1] [Oper-5]
    def test_an_obc_that_polls_walks_hears_nothing_unasked_and_stops_at_once(self):
        obc = self.start_served()
        self.assertTrue(obc.hears_nothing(2.5), "status and telemetry go on meanwhile, elsewhere")
        self.assertEqual(obc.ask("walk forward")["phase"], "rejected", "no step is taken for it")
        self.walk(obc)
        first_m = obc.ask("data")["telemetry"]["distance_m"]
        until_s = time.monotonic() + 3 * LEASE_S
        while time.monotonic() < until_s:
            self.assertEqual(obc.ask("heartbeat")["mode"], "Walking")
            self.assertTrue(obc.hears_nothing(0.5))
        self.assertGreater(obc.ask("data")["telemetry"]["distance_m"], first_m)
        stopped = obc.ask("estop")
        self.assertTrue(stopped["stopped"], stopped)
        status = obc.ask("status")
        self.assertEqual(status["state"], FATAL_ERROR)
        self.assertIn(FAULT["emergency_stop"], self.fault_ids(status))
        self.assertTrue(obc.hears_nothing(1.5))

    # [O-Int-2]
    def test_a_vehicle_whose_obc_polls_no_more_stops_within_its_lease(self):
        obc = self.start_served()
        self.walk(obc)
        last_ns = obc.ask("heartbeat")["time_ns"]
        self.assert_resting(self.wait_state(IDLE, 60))
        expired = [e for e in self.events() if e["name"] == "lease_expired"]
        self.assertEqual(len(expired), 1)
        after_s = (expired[0]["time_ns"] - last_ns) / 1e9
        print(f"lease expired {after_s:.2f} s after the status that the last poll returned")
        self.assertLess(after_s, LEASE_S + 1.5, "the status is at most 1 s old")
        self.assertTrue(self.served.running(), "it serves on")
        self.assertEqual(obc.ask("status")["state"], IDLE)


if __name__ == "__main__":
    unittest.main()
