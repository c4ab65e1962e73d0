"""Every way to stop, seen on the wire: emergency stop, signals to the daemon, the end of a heartbeat."""

import signal
import statistics
import time
import unittest

import wire
from rig import EXIT, FATAL_ERROR, IDLE, OPERATIONAL, FAULT, Scenario
from programs import wait_until
from wire import stopped_ns

FRAME_AND_BUS_CYCLE_S = 0.040
ESTOP_KIND = 3


def moving(orders):
    return [f for f in orders if f.code in (wire.START_MOTION, *wire.ROTATES)]


class Stop(Scenario):
    # [Oper-5]
    def test_an_emergency_stop_from_anyone_is_on_the_wire_within_a_frame_and_a_bus_cycle(self):
        self.start_tapped()
        stranger = self.commander()
        delays_s = []
        for sequence in range(1, 6):
            client = self.begin_walk(name=f"walk-{sequence}")
            sent_ns = time.monotonic_ns()
            stranger.say(f"command stranger {sequence} {ESTOP_KIND} 0 0")
            arrival_ns = self.answers(stranger, "stranger", sequence)[0][2]
            self.assertGreaterEqual(arrival_ns, sent_ns)
            self.assertEqual(client.wait(20), EXIT["failed"])
            status = self.wait_state(FATAL_ERROR)
            self.assertIn(FAULT["emergency_stop"], self.fault_ids(status))

            orders = self.orders(arrival_ns)
            told_ns = stopped_ns(orders, [wire.EMERGENCY])
            self.assertIsNotNone(told_ns, "every module has its emergency stop")
            delays_s.append((told_ns - arrival_ns) / 1e9)
            begun_ns = next(f.time_ns for f in orders if f.code == wire.EMERGENCY)
            self.assertEqual(moving([f for f in orders if f.time_ns >= begun_ns]), [])
            self.cli_ok("solve")
            self.wait_state(IDLE)
        print("emergency stops on the wire after", [f"{s * 1e3:.1f}" for s in delays_s],
              f"ms; median {statistics.median(delays_s) * 1e3:.1f}, max {max(delays_s) * 1e3:.1f}")
        self.assertLessEqual(max(delays_s), FRAME_AND_BUS_CYCLE_S)

    def test_a_daemon_that_was_halted_stops_the_modules_and_reports_a_fatal_error(self):
        daemon = self.start_tapped()
        self.begin_walk()
        daemon.signal(signal.SIGSTOP)
        time.sleep(1.5)  # tests the standstill
        resumed_ns = time.monotonic_ns()
        daemon.signal(signal.SIGCONT)
        status = self.wait_state(FATAL_ERROR)
        print("faults:", [f["name"] for f in status["faults"]])
        orders = self.orders(resumed_ns)
        told_ns = stopped_ns(orders, [wire.EMERGENCY])
        self.assertIsNotNone(told_ns, "every module has its emergency stop")
        print(f"reported after {(told_ns - resumed_ns) / 1e6:.1f} ms")
        self.assertEqual(moving([f for f in orders if f.time_ns > told_ns]), [])
        self.assertTrue(daemon.running())
        self.cli_ok("solve")
        self.wait_state(IDLE)

    def test_after_a_short_halt_the_vehicle_stands_on_or_says_why_not(self):
        """0.25 s: longer than orders stay fresh for the bus (0.1 s), shorter than a silence of modules (0.5 s)."""
        daemon = self.start_tapped()
        self.begin_cli("stand", "--hold", name="stand")
        self.wait_status(lambda s: s["mode"] == "Standing", 60, "the vehicle stands")
        daemon.signal(signal.SIGSTOP)
        time.sleep(0.25)  # tests the standstill
        resumed_ns = time.monotonic_ns()
        daemon.signal(signal.SIGCONT)
        status = self.wait_status(lambda s: s["time_ns"] > resumed_ns + 2_000_000_000, 10, "two seconds later")
        told_ns = stopped_ns(self.orders(resumed_ns), [wire.EMERGENCY])
        print("emergency stop on the wire:", told_ns and f"after {(told_ns - resumed_ns) / 1e6:.1f} ms;",
              status["state"], status["mode"], [f["name"] for f in status["faults"]])
        if status["state"] != FATAL_ERROR:
            self.assertEqual(status["mode"], "Standing")
            off = [m["name"] for m in status["telemetry"]["modules"][:6] if not m["motion_control"]]
            self.assertEqual(off, [], "said to stand, with motors that are off")

    # [Oper-7]
    def test_a_terminated_daemon_stops_every_module_before_it_leaves(self):
        daemon = self.start_tapped()
        self.begin_walk()
        asked_ns = time.monotonic_ns()
        daemon.signal(signal.SIGTERM)
        self.assertEqual(daemon.wait(3), 0)
        left_ns = time.monotonic_ns()
        print(f"left after {(left_ns - asked_ns) / 1e6:.0f} ms")
        wait_until(lambda: stopped_ns(wire.orders(self.wire_log, asked_ns), [wire.EMERGENCY, wire.STOP_MOTION]), 2,
                   "every module was stopped")
        last = {f.address: f for f in wire.orders(self.wire_log, asked_ns)}
        self.assertEqual(moving(last.values()), [], "the last order of each module stops")

    # [O-Int-2]
    def test_a_detached_walk_goes_on_with_its_heartbeat_and_stops_with_anothers(self):
        self.start_tapped()
        heartbeat = self.begin_cli("heartbeat", name="heartbeat")
        viewer = self.begin_cli("--source", "viewer", "heartbeat", name="viewer")
        self.cli_ok("--detach", "walk", "forward", "--speed", "high")
        self.wait_walking()
        began_ns = time.monotonic_ns()
        self.wait_status(lambda s: time.monotonic_ns() - began_ns > 8e9, 20, "four leases pass")
        status = self.status()
        self.assertEqual((status["state"], status["mode"]), (OPERATIONAL, "Walking"))

        heartbeat.signal(signal.SIGINT)
        heartbeat.wait(10)
        ended_ns = time.monotonic_ns()
        self.assert_resting(self.wait_state(IDLE, 60))
        self.assertIn("lease_expired", [e["name"] for e in self.events() if e["time_ns"] > ended_ns])
        orders = self.orders(ended_ns)
        self.assertEqual([f for f in orders if f.code == wire.EMERGENCY], [], "a safe stop is no emergency")
        viewer.stop()

    # [Func-2] [Oper-7]
    def test_ctrl_c_ends_an_attached_walk_with_a_safe_stop(self):
        self.start_tapped()
        client = self.begin_walk()
        asked_ns = time.monotonic_ns()
        client.signal(signal.SIGINT)
        self.assertEqual(client.wait(60), 0)
        self.assert_resting(self.wait_state(IDLE))
        orders = self.orders(asked_ns)
        self.assertEqual([f for f in orders if f.code == wire.EMERGENCY], [], "a safe stop is no emergency")
        self.assertIsNotNone(stopped_ns(orders, [wire.STOP_MOTION]), "motors go off")


if __name__ == "__main__":
    unittest.main()
