"""A module that is reset by command is away for a while, which is no emergency; one that stays away is."""

import glob
import os
import unittest

from hopper_rig import Hopper
from programs import wait_until
from rig import EXIT, FATAL_ERROR, FAULT, IDLE, Scenario
from rover_rig import Rover

RESET_BEGUN, RESET_ENDED = 57, 58  # of idl/codes.h


class Resets:
    """Tests of every vehicle. MODULE: name of the module to reset; MOVE: a command that shows that it works afterwards."""

    def crashes(self):
        return glob.glob(os.path.join(self.run_folder, "*.crash.jsonl"))

    def begin_reset(self):
        client = self.begin_cli("reset", self.MODULE, name="reset")
        wait_until(lambda: any(e["id"] == RESET_BEGUN for e in self.events()), 10, "the reset began")
        return client

    def assert_start_is_refused(self):
        result = self.cli("start")
        self.assertEqual(result.code, EXIT["rejected"], result)
        self.assertIn("does not answer", result.err)

    # [Oper-4]
    def test_reset_of_one_module_and_of_all_in_idle_is_no_emergency(self):
        self.start_all()
        for what in (self.MODULE, "all"):
            self.cli_ok("reset", what)
            status = self.status()
            self.assertEqual((status["state"], status["faults"]), (IDLE, []), f"after reset {what}")
        took = [e["text"] for e in self.events() if e["id"] == RESET_ENDED]
        print(*took, sep="\n")
        self.assertEqual(self.crashes(), [])
        self.cli_ok(*self.MOVE, limit_s=120)
        self.assertEqual(self.crashes(), [])

    def check_never_back(self, client):
        """`client` resets a module that will not come back."""
        self.assert_start_is_refused()
        self.assertEqual(self.status()["state"], IDLE)
        self.assertEqual(client.wait(30), EXIT["failed"])
        self.assertIn("does not answer", client.err())
        status = self.wait_state(FATAL_ERROR)
        silent = [f["subject"] for f in status["faults"] if f["id"] == FAULT["module_silent"]]
        self.assertEqual(silent, [self.NUMBER])
        wait_until(lambda: any("module_silent" in path for path in self.crashes()), 10, "the frames before it are kept")
        self.fault("clear")
        self.cli_ok("solve", limit_s=90)
        self.wait_state(IDLE)


class OnTheBus(Resets):
    """The nodes of a CAN bus. One that refuses its configuration runs on until it is reset."""

    def start_refusing(self, **config):
        self.start_all(**config)
        self.fault(f"sdo-abort:{self.NODE}")
        client = self.begin_reset()
        self.wait_status(lambda s: FAULT["node_refuses"] in self.fault_ids(s), 10, "it is not configured")
        return client

    def test_a_module_that_is_slow_to_come_back_is_waited_for(self):
        client = self.start_refusing(reset_s="30.0")
        self.assert_start_is_refused()
        self.fault("clear")
        self.assertEqual(client.wait(40), 0, client.err())
        status = self.status()
        self.assertEqual((status["state"], status["faults"]), (IDLE, []))
        self.assertFalse(any("module_silent" in path for path in self.crashes()))
        self.cli_ok(*self.MOVE, limit_s=120)

    def test_a_module_that_does_not_come_back_is_a_fault_at_its_deadline(self):
        self.check_never_back(self.start_refusing())


class Ardito(OnTheBus, Rover):
    IN_LOCKSTEP = True
    MODULE, NUMBER, NODE = "RF", 2, "0x02"
    MOVE = ("drive", "0.3", "--for", "2s")


class Talaris(OnTheBus, Hopper):
    IN_LOCKSTEP = True
    MODULE, NUMBER, NODE = "fans", 4, "0x21"
    MOVE = ("run", "-e", "start; stop")


class Zebro(Resets, Scenario):
    IN_LOCKSTEP = True
    MODULE, NUMBER = "LM", 3
    MOVE = ("run", "-e", "start; stand; stop")

    def test_a_module_that_does_not_come_back_is_a_fault_at_its_deadline(self):
        self.start_all(module_silent_ms="3000")  # it is reset before it is missed
        self.fault(f"module-dead:{self.NUMBER}")
        self.check_never_back(self.begin_reset())


if __name__ == "__main__":
    unittest.main()
