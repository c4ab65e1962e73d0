"""D.I.A.N.A. Ardito drives, with and without failures: judged by the simulator's true path."""

import os
import signal
import socket
import unittest

import motion
from programs import run, wait_until
from rig import BOOT_S, DAEMON, EXIT, FATAL_ERROR, FAULT, IDLE, real_time
from rover_rig import Rover

LM, RR = 3, 6


class Ardito(Rover):
    IN_LOCKSTEP = True

    def rests(self, limit_s=5):
        """Until it stands: no further than 2 mm in half a second."""
        def still():
            now = self.truth.samples[-1][1]
            before = next((s for _, s in self.truth.samples if s["t_s"] > now["t_s"] - 0.6), now)
            return now["t_s"] - before["t_s"] > 0.4 and abs(motion.moved(before, now)[0]) < 0.002
        return wait_until(still, limit_s, "the rover stands")

    def begin_drive(self, *words):
        """The client of a rover that has got under way: Running alone begins at standstill."""
        client = self.begin_endless("drive", *words, name="drive")
        self.wait_mode("Running", 60, client)
        begin = self.truth.samples[-1][1]
        wait_until(lambda: abs(motion.moved(begin, self.truth.samples[-1][1])[0]) > 0.1, 10, "the rover moves")
        return client

    def driven(self, *words, limit_s=120):
        """Result of an attached command: forward and left metres, and the turn."""
        begin = self.truth.samples[-1][1]
        self.cli_ok(*words, limit_s=limit_s)
        self.rests()
        return motion.moved(begin, self.truth.samples[-1][1])

    def test_drives_ahead_back_along_an_arc_and_turns_on_the_spot(self):
        self.start_all()
        ahead, left, turned = self.driven("drive", "0.3", "--for", "10s")
        print(f"ahead: {ahead:.3f} m, {left:.3f} m left, {turned:.3f} rad")
        self.assertAlmostEqual(ahead, 3.0, delta=0.3)
        self.assertLess(abs(left), 0.1)

        back, _, _ = self.driven("drive", "-0.2", "--for", "5s")
        print(f"back: {back:.3f} m")
        self.assertAlmostEqual(back, -1.0, delta=0.15)

        ahead, left, turned = self.driven("drive", "0.3", "--heading", "5deg", "--for", "8s")
        print(f"arc to the right: {ahead:.3f} m ahead, {left:.3f} m left, {turned:.3f} rad")
        self.assertLess(turned, -0.5)
        self.assertLess(left, 0)

        ahead, left, turned = self.driven("park", "0.4", "--for", "10s")  # it steers first
        print(f"on the spot: {ahead:.3f} m, {left:.3f} m, {turned:.3f} rad")
        self.assertLess(turned, -0.2)
        self.assertLess(abs(ahead) + abs(left), 0.25)

    def test_a_sensor_that_fails_is_substituted_and_a_motor_is_done_without(self):
        self.start_all()
        self.begin_drive("0.3")
        self.fault(f"E-TM:{LM}")
        self.wait_status(lambda s: s["telemetry"]["wheels"][LM - 1]["state"] == 1, 3, "the encoder is found")
        self.fault(f"TM:{RR}:1")
        status = self.wait_status(lambda s: s["telemetry"]["wheels"][RR - 1]["state"] == 3, 3, "the motor is found")
        self.assertFalse(status["telemetry"]["wheels"][RR - 1]["clutch"])
        self.assertEqual(status["mode"], "Running")
        before = self.truth.samples[-1][1]
        wait_until(lambda: self.truth.samples[-1][1]["t_s"] > before["t_s"] + 5, 20, "five more seconds")
        self.assertGreater(motion.moved(before, self.truth.samples[-1][1])[0], 1.2)

    def test_a_silent_wheel_drive_stops_the_rover_and_solve_goes_on_with_five(self):
        self.start_all(budget_s="3.0")
        self.begin_drive("0.3")
        self.fault("node-silent:0x05")
        status = self.wait_state(FATAL_ERROR)
        self.assertIn(FAULT["module_silent"], self.fault_ids(status))
        self.rests()
        self.cli_ok("solve", limit_s=90)
        status = self.wait_state(IDLE)
        self.assertEqual([n["name"] for n in status["telemetry"]["nodes"] if n["isolated"]], ["LR"])
        ahead, _, _ = self.driven("drive", "0.3", "--for", "6s")
        print(f"five wheels: {ahead:.3f} m")
        self.assertGreater(ahead, 1.2)

    def test_ctrl_c_a_killed_client_and_an_emergency_stop_all_end_it(self):
        self.start_all()
        client = self.begin_drive("0.3")
        client.signal(signal.SIGINT)
        client.wait(30)
        self.wait_state(IDLE)
        self.rests()

        self.begin_drive("0.3").kill()
        self.wait_state(IDLE)
        self.rests()

        client = self.begin_drive("0.3")
        self.cli_ok("estop")
        self.wait_state(FATAL_ERROR)
        self.rests()
        self.assertEqual(client.wait(10), EXIT["failed"])
        self.cli_ok("solve", limit_s=60)
        self.wait_state(IDLE)

    def test_the_button_cuts_the_motors_until_it_is_released_and_solved(self):
        self.start_all()
        self.begin_drive("0.3")
        self.fault("e-stop-button")
        status = self.wait_state(FATAL_ERROR)
        self.assertIn(FAULT["emergency_button"], self.fault_ids(status))
        self.rests()
        result = self.cli("drive", "0.3", "--for", "1s")
        self.assertEqual(result.code, EXIT["rejected"], result)
        self.fault("clear")
        self.cli_ok("solve", limit_s=60)
        self.assertGreater(self.driven("drive", "0.3", "--for", "3s")[0], 0.5)

    @real_time("time stands still while the daemon is halted")
    def test_a_halted_and_a_killed_daemon_leave_nodes_that_stop_by_themselves(self):
        daemon = self.start_all(beacon_s="1.5")
        self.begin_drive("0.3")
        daemon.signal(signal.SIGSTOP)
        self.rests(3)
        daemon.signal(signal.SIGCONT)
        self.wait_state(FATAL_ERROR)
        self.cli_ok("solve", limit_s=90)
        self.begin_drive("0.3")
        daemon.kill()
        self.rests(3)
        self.start_daemon(os.path.join(self.folder, "ardito.toml"))
        self.wait_modules()
        self.assertGreater(self.driven("drive", "0.3", "--for", "3s")[0], 0.5)

    def test_a_killed_simulator_is_a_fatal_error_and_can_come_back(self):
        self.start_all()
        self.begin_drive("0.3")
        self.programs[0].kill()
        self.wait_state(FATAL_ERROR)
        self.start_sim()
        self.wait_modules()
        self.cli_ok("solve", limit_s=90)
        self.assertGreater(self.driven("drive", "0.3", "--for", "3s")[0], 0.5)

    @real_time("strangers do not count their datagrams")
    def test_strangers_on_the_port_and_broken_datagrams_are_dropped_and_counted(self):
        self.start_all(beacon_s="1.5")
        self.begin_drive("0.3")
        before = self.telemetry()["bus_frames_dropped"]
        with open(f"/proc/{self.programs[1].process.pid}/net/udp", encoding="ascii") as table:
            inodes = {line.split()[9]: int(line.split()[1].split(":")[1], 16) for line in table.readlines()[1:]}
        folder = f"/proc/{self.programs[1].process.pid}/fd"
        links = [os.readlink(os.path.join(folder, fd)) for fd in os.listdir(folder)]
        ports = [port for inode, port in inodes.items() if f"socket:[{inode}]" in links]
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            for port in ports:
                for size in (0, 1, 5, 40, 1400):
                    stranger.sendto(os.urandom(size), ("127.0.0.1", port))
                # A frame that would stop wheel 1, from the wrong address.
                stranger.sendto(bytes.fromhex("0200000001000000810830810000000000000000"), ("127.0.0.1", port))
        self.wait_status(lambda s: s["telemetry"]["bus_frames_dropped"] >= before + 6, 10, "they are counted")
        self.assertEqual(self.status()["mode"], "Running")
        self.fault("foreign-frames:200")
        self.wait_status(lambda s: s["telemetry"]["bus_frames_dropped"] >= before + 200, 20, "these, too")
        self.assertEqual(self.status()["mode"], "Running")

    def test_nodes_that_are_missing_wrong_or_refuse_are_reported_and_start_is_refused(self):
        self.start_sim("--fault", "0s:node-silent:0x21", "--fault", "0s:wrong-device-type:0x02",
                       "--fault", "0s:sdo-abort:0x11")
        self.start_daemon()
        status = self.wait_status(lambda s: {FAULT["node_wrong"], FAULT["node_refuses"]} <= self.fault_ids(s)
                                  and s["telemetry"]["nodes"], 30, "both are reported")
        links = {n["name"]: n["link"] for n in status["telemetry"]["nodes"]}
        self.assertEqual(links["RF"], "wrong")
        self.assertIn(links["steer-LF"], ("refuses", "booting", "configuring", "identifying"))
        self.assertIn(links["IMU"], ("missing", "booting"))
        result = self.cli("start")
        self.assertEqual(result.code, EXIT["rejected"], result)
        self.assertIn("is another one than configured or refuses its configuration", result.err)
        self.assertIn("2 (RF)", result.err)
        self.fault("clear")
        self.wait_modules()
        self.assertGreater(self.driven("drive", "0.3", "--for", "3s")[0], 0.5)

    @real_time("a CAN interface", any_machine=True)
    def test_a_period_that_its_controller_is_not_made_for_is_refused_and_not_tried_again(self):
        no_restart = 78  # RestartPreventExitStatus= of systemd/lssd@.service.in
        result = run([DAEMON, "--config", self.write_config(period_ms="50"), "--run-dir", self.run_folder,
                      "--domain", str(self.domain)], self.environment(), BOOT_S)
        self.assertEqual(result.code, no_restart, result)
        self.assertIn("[frame] period_ms is 50", result.err)

    def test_a_kernel_without_can_is_reported_with_what_to_do(self):
        if os.path.exists("/sys/class/net/can0"):
            self.skipTest("this machine has a can0")
        result = run([DAEMON, "--config", self.write_config(path='"can0"'), "--run-dir", self.run_folder,
                      "--domain", str(self.domain)], self.environment(), BOOT_S)
        self.assertNotEqual(result.code, 0)
        self.assertIn("can0", result.err)
        self.assertTrue("no CAN" in result.err or "plug it in" in result.err, result.err)


if __name__ == "__main__":
    unittest.main()
