"""lss-cli param: parameters change while the daemon runs, are saved, survive its death and the damage of a copy, and a
recording with all of it is executed again to the bit."""

import glob
import json
import os
import resource
import unittest

from hopper_rig import Hopper
from programs import run, wait_until
from rig import DAEMON, EXIT, FAULT, IDLE, OPERATIONAL, Scenario
from rover_rig import Rover

# idl/codes.h
CHANGED, SAVED, NOT_SAVED, TAKEN, DAMAGED, REFUSED = 51, 52, 53, 54, 55, 56


class Parameters:
    """Beside a Scenario."""

    def param(self, name):
        document = json.loads(self.cli_ok("--json", "param", "get", name).out)
        return document["parameters"][0]

    def copies(self):
        return sorted(glob.glob(os.path.join(self.run_folder, "*-parameters-*.bin")))

    def event_texts(self, number, count=1):
        """Of that many at least: a thread of its own writes them into the log."""
        texts = lambda: [e["text"] for e in self.events() if e["id"] == number]
        wait_until(lambda: len(texts()) >= count, 10, f"{count} times event {number} in the log")
        return texts()

    def flip(self, path, at=100):
        with open(path, "r+b") as file:
            file.seek(at)
            byte = file.read(1)[0]
            file.seek(at)
            file.write(bytes([byte ^ 0x04]))

    def kill(self, daemon):
        daemon.process.kill()
        daemon.process.wait()

    def replay_all(self):
        paths = sorted(glob.glob(os.path.join(self.run_folder, "*.lssrec")))
        result = run([DAEMON, "--replay", *paths], self.environment(), 300)
        self.assertEqual(result.code, 0, result)
        self.assertEqual(result.out.count("equal: "), len(paths), result.out)

    def restarted_with(self, name, value):
        """A daemon whose parameter was set and saved before it was killed and started again."""
        daemon = self.start_all()
        self.assert_kept(name, value)
        self.kill(daemon)
        daemon = self.start_daemon()
        self.wait_modules()
        self.assertEqual(self.param(name)["value"], value)
        return daemon

    def assert_kept(self, name, value):
        """Over a death of the daemon, with the simulator going on."""
        self.cli_ok("param", "set", name, str(value))
        self.assertEqual(self.param(name)["value"], value)
        self.assertIsNone(self.param(name)["saved"])
        self.cli_ok("param", "save")
        self.assertEqual(self.param(name)["saved"], value)
        self.assertEqual(len(self.copies()), 2)


class Zebro(Parameters, Scenario):
    IN_LOCKSTEP = True

    def test_a_value_is_set_saved_and_survives_a_kill_and_the_damage_of_a_copy(self):
        daemon = self.start_all()
        self.assertEqual(self.param("limits.current_A")["value"], 1.2)
        self.assertEqual(self.status()["saved_parameters"], "none")
        self.cli_ok("param", "set", "gait.flight_s", "3.25")
        self.assertIn("gait.flight_s: 3 to 3.25 s", " ".join(self.event_texts(CHANGED)))

        # A rejection names the allowed range.
        wrong = self.cli("param", "set", "limits.current_A", "12")
        self.assertEqual(wrong.code, EXIT["rejected"], wrong)
        self.assertIn("limits.current_A: 12 A is out of range, allowed 0.05 to 1.5 A", wrong.err)
        wrong = self.cli("param", "set", "gait.flight_s", "1")
        self.assertEqual(wrong.code, EXIT["rejected"], wrong)
        self.assertIn("does not go with those of other parameters", wrong.err)
        wrong = self.cli("param", "set", "limits.curent_A", "1")
        self.assertEqual(wrong.code, EXIT["unknown_name"], wrong)
        self.assertIn("did you mean limits.current_A?", wrong.err)

        # While it walks: only safe parameters, and only by the holder of authority.
        # The verb itself: no sequence that stops the vehicle, too.
        client = self.begin_cli("--source", "pilot", "walk", "forward", "--speed", "high", name="walk")
        self.wait_walking(client)
        self.assertEqual(self.cli("param", "set", "limits.current_A", "1.3").code, EXIT["not_authorised"])
        moving = self.cli("--source", "pilot", "param", "set", "gait.flight_s", "3.5")
        self.assertEqual(moving.code, EXIT["rejected"], moving)
        self.assertIn("not allowed in this state (Operational)", moving.err)
        self.cli_ok("--source", "pilot", "param", "set", "limits.current_A", "1.4")
        self.assertEqual(self.status()["mode"], "Walking")
        self.cli_ok("--source", "pilot", "stop")
        client.wait(60)
        self.wait_state(IDLE)

        # Saved, killed, started again: there, and in force from the first frame.
        self.assert_kept("solve.rounds", 7)
        self.assertEqual(json.loads(self.cli_ok("--json", "param", "diff").out)["save"], 1)
        self.kill(daemon)
        daemon = self.start_daemon()
        for name, value in (("gait.flight_s", 3.25), ("limits.current_A", 1.4), ("solve.rounds", 7)):
            self.assertEqual(self.param(name)["value"], value)
        self.assertEqual(self.param("motion.stand_up_s")["value"], 3)
        self.assertEqual(self.status()["saved_parameters"], "good")
        self.assertEqual(self.event_texts(TAKEN), ["3 saved parameters taken, number 1"])

        # A copy is damaged: reported, and the other one is used.
        self.kill(daemon)
        self.flip(self.copies()[1])
        daemon = self.start_daemon()
        self.assertEqual(self.param("limits.current_A")["value"], 1.4)
        self.assertEqual(self.status()["saved_parameters"], "one_copy")
        told, = self.event_texts(DAMAGED)
        self.assertIn(os.path.basename(self.copies()[1]) + " is damaged", told)
        self.assertIn("one copy of the saved parameters is not good", self.cli_ok("status").out)

        # Both: reported, and the configuration's values are used.
        self.kill(daemon)
        self.flip(self.copies()[0], 20)
        daemon = self.start_daemon()
        self.assertEqual(self.param("limits.current_A")["value"], 1.2)
        self.assertEqual(self.status()["saved_parameters"], "lost")
        self.assertEqual(len(self.event_texts(DAMAGED, 2)), 2)
        self.assertIn("the configuration applies", self.event_texts(REFUSED)[0])

        # A save restores both.
        self.assert_kept("limits.current_A", 1.1)
        self.wait_status(lambda s: s["saved_parameters"] == "good", 5, "status says that it is good again")
        daemon.stop()
        self.replay_all()

    def test_a_disk_that_cannot_be_written_fails_the_save_with_what_to_do(self):
        daemon = self.start_all()
        self.assert_kept("limits.current_A", 1.4)
        self.cli_ok("param", "set", "limits.current_A", "1.5")
        resource.prlimit(daemon.process.pid, resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))
        skipped = json.loads(self.cli_ok("--json", "timing").out)["missed"]["skipped"]
        full = self.cli("param", "save")
        self.assertEqual(full.code, EXIT["failed"], full)
        self.assertIn("free or repair the disk", full.err)
        self.assertEqual(len(self.event_texts(NOT_SAVED)), 1)
        self.assertEqual(self.param("limits.current_A")["saved"], 1.4)
        resource.prlimit(daemon.process.pid, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
        self.cli_ok("param", "save")
        self.assertEqual(self.param("limits.current_A")["saved"], 1.5)
        self.assertEqual(json.loads(self.cli_ok("--json", "timing").out)["missed"]["skipped"], skipped,
                         "no frame waits for a disk")


class Ardito(Parameters, Rover):
    IN_LOCKSTEP = True

    def test_a_beacon_that_was_set_and_saved_runs_so_long_after_a_restart(self):
        daemon = self.restarted_with("safety.beacon_s", 1.5)
        client = self.begin_cli("drive", "0.3", "--for", "2s", name="drive")
        warned = self.wait_status(lambda s: s["mode"] == "Warning", 20, "the beacon runs", client)
        stopped = self.wait_status(lambda s: s["mode"] not in ("Warning", ""), 20, "the motors go on", client)
        self.assertLess((stopped["time_ns"] - warned["time_ns"]) * 1e-9, 4, "with the configuration's it is 5 s")
        self.assertEqual(client.wait(120), 0)
        self.wait_state(IDLE)
        daemon.stop()
        self.replay_all()


class Sinking(Parameters, Rover):
    IN_LOCKSTEP, PLANT = True, "dart"

    def drive_with_a_low_wheel(self):
        """In soil, where wheels slip: one looks 67 mm lower, and its motor pushes harder."""
        client = self.begin_endless("drive", "0.3", name="drive")
        self.wait_mode("Running", 60, client)
        self.later(3)
        self.fault("encoder-jump:0x20:3:-1800")
        self.fault("encoder-jump:0x04:4:1000")
        return client

    def later(self, seconds):
        begin_s = self.truth.samples[-1][1]["t_s"]
        wait_until(lambda: self.truth.samples[-1][1]["t_s"] > begin_s + seconds, 60, f"{seconds} s of simulated time")

    def test_the_sink_limit_decides_what_counts_as_dug_in(self):
        self.start_sim("--ground", "regolith")
        self.start_daemon(self.write_config(beacon_s="1.5"))
        self.wait_modules()
        for wrong, code, why in (("0.02", "rejected", "0.02 m is out of range, allowed 0.03 to 0.5 m"),
                                 ("0.6", "rejected", "0.6 m is out of range, allowed 0.03 to 0.5 m"),
                                 ("deep", "usage", "deep")):
            refused = self.cli("param", "set", "mobility.sink_limit_m", wrong)
            self.assertEqual(refused.code, EXIT[code], refused)
            self.assertIn(why, refused.err)
        self.assertEqual(self.param("mobility.sink_limit_m")["value"], 0.06)

        client = self.drive_with_a_low_wheel()
        self.assertEqual(client.wait(60), EXIT["failed"])
        self.assertIn(FAULT["wheel_embedded"], self.fault_ids(self.status()))
        self.fault("clear")
        self.wait_state(IDLE)

        self.cli_ok("param", "set", "mobility.sink_limit_m", "0.1")
        client = self.drive_with_a_low_wheel()
        self.later(5)
        status = self.status()
        self.assertEqual(status["mode"], "Running")
        self.assertNotIn(FAULT["wheel_embedded"], self.fault_ids(status))
        sunk_m = self.telemetry()["sunk_m"]
        self.assertEqual(max(range(6), key=lambda i: sunk_m[i]), 3)
        self.assertGreater(sunk_m[3], 0.05)
        client.kill()
        self.wait_state(IDLE)


class Talaris(Parameters, Hopper):
    IN_LOCKSTEP = True

    def test_a_reserve_that_was_set_and_saved_refuses_a_plan_after_a_restart(self):
        daemon = self.restarted_with("gas.reserve_s", 43)
        self.cli_ok("--detach", "start")
        heart = self.begin_cli("--source", "lss-cli", "heartbeat", name="heart")
        self.wait_state(OPERATIONAL)  # what is detached is only accepted
        self.cli_ok("--detach", "gnc", "standby")
        refused = self.cli("--detach", "plan", "hop", "--height", "2", "--distance", "5")
        self.assertEqual(refused.code, EXIT["rejected"], refused)
        self.assertIn("gas does not suffice", refused.err)
        self.assertEqual(self.cli("--detach", "param", "set", "limits.tilt_deg", "25").code, EXIT["rejected"])
        self.cli_ok("--detach", "stop")
        self.wait_state(IDLE)
        heart.stop()
        daemon.stop()
        self.replay_all()


if __name__ == "__main__":
    unittest.main()
