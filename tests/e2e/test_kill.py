"""kill -9 of everything around the daemon while it walks: it keeps running, reacts as specified, continues afterwards."""

import os
import signal
import socket
import time
import unittest

import motion
import wire
from programs import wait_until
from rig import EXIT, FATAL_ERROR, FAULT, IDLE, OPERATIONAL, Scenario, real_time


class Kill(Scenario):
    IN_LOCKSTEP = True

    def walk_again(self):
        walked = len(self.walks())
        self.cli_ok("walk", "forward", "--speed", "high", "--for", "9s", limit_s=120)
        span = self.walks()[walked]
        forward_m = motion.moved(motion.at(self.truth, span[0]), motion.at(self.truth, span[1]))[0]
        self.assertGreater(forward_m, 0.04)
        self.assert_resting(self.status())

    # [O-Int-2]
    def test_a_killed_client_leaves_a_vehicle_that_stops_safely_and_obeys_the_next(self):
        daemon = self.start_all()
        client = self.begin_walk("--source", "first")
        self.assertEqual(self.status()["authority"], "first")
        client.kill()
        status = self.wait_state(IDLE, 60)
        self.assert_resting(status)
        self.assertEqual(self.fault_ids(status) - {FAULT["bus_noise"]}, set())
        self.assertIn("lease_expired", [e["name"] for e in self.events()])
        self.walk_again()
        self.assertTrue(daemon.running())

    def test_a_stop_in_the_name_of_a_killed_client_is_completed(self):
        self.start_all()
        client = self.begin_walk("--source", "first")
        client.kill()
        self.cli_ok("--source", "first", "stop")
        self.assert_resting(self.status())

    # [P-Int-2] [Oper-6]
    def test_a_killed_simulator_is_a_fatal_error_and_can_come_back(self):
        self.start_sim()
        daemon = self.start_daemon()
        self.wait_modules()
        client = self.begin_walk()
        sim = next(p for p in self.programs if p.name == "lss-sim")
        sim.kill()
        status = self.wait_state(FATAL_ERROR)
        self.assertTrue(self.fault_ids(status) & {FAULT["port_lost"], FAULT["module_silent"]}, status["faults"])
        self.assertEqual(client.wait(20), EXIT["failed"])
        self.assertTrue(daemon.running())

        self.start_sim(seed=2)
        status = self.wait_status(lambda s: s["telemetry"] and s["telemetry"]["port_open"] and all(m["online"] for m in s["telemetry"]["modules"]),
                                  20, "the port is opened by itself")
        self.assertEqual(status["state"], FATAL_ERROR, "only by command")
        self.cli_ok("solve")
        self.assertEqual(self.fault_ids(self.wait_state(IDLE)) - {FAULT["bus_noise"]}, set())
        self.walk_again()
        self.assertTrue(daemon.running())

    @real_time("what is on the wire")
    # [Oper-3] [P-Int-2] [Prod-2]
    def test_a_killed_daemon_that_is_started_again_stops_every_module_and_walks_again(self):
        daemon = self.start_tapped()
        client = self.begin_walk()
        daemon.kill()
        client.kill()
        again_ns = time.monotonic_ns()
        daemon = self.start_daemon()
        orders = self.orders(again_ns)
        told_ns = wire.stopped_ns(orders, [wire.EMERGENCY])
        self.assertIsNotNone(told_ns, "every module has its emergency stop")
        print(f"every module was stopped {(told_ns - again_ns) / 1e6:.0f} ms after the start of the daemon")
        self.assertEqual([f for f in orders if f.code in (wire.START_MOTION, *wire.ROTATES)], [])
        self.assert_resting(self.wait_modules())
        self.walk_again()
        self.assertTrue(daemon.running())

    def test_a_program_that_changed_in_memory_stops_the_vehicle_until_it_is_started_again(self):
        self.start_sim()
        daemon = self.start_daemon()
        self.wait_modules()
        self.begin_walk()
        with open(f"/proc/{daemon.process.pid}/maps", encoding="ascii") as file:
            header = next(int(line.split("-")[0], 16) for line in file if line.rstrip().endswith("/lssd"))
        unused = header + 9  # a byte of the ELF header that nobody reads
        with open(f"/proc/{daemon.process.pid}/mem", "r+b", buffering=0) as memory:
            memory.seek(unused)
            memory.write(b"\x20")
        self.assertIn(FAULT["memory_lost"], self.fault_ids(self.wait_state(FATAL_ERROR)))
        wait_until(lambda: "the program changed in memory" in daemon.out() + daemon.err(), 20, "it says where")
        self.assertNotEqual(self.cli("solve").code, 0)
        self.assertEqual(self.status()["state"], FATAL_ERROR)
        daemon.stop()
        self.start_daemon()
        self.wait_modules()
        self.walk_again()

    @real_time("shared memory")
    # [Prod-2]
    def test_a_killed_roudi_changes_nothing_but_the_way_of_telemetry(self):
        roudi = self.start_roudi_and_sim()
        daemon = self.start_daemon(self.write_config(shared_memory=True))
        self.assertEqual(self.wait_modules()["shared_memory"], "active")
        client = self.begin_walk()
        roudi.kill()
        status = self.wait_status(lambda s: s["shared_memory"] == "lost", 10, "the loss is reported")
        self.assertIn(1000 + FAULT["shared_memory_lost"], [e["id"] for e in self.events()])
        self.assertEqual((status["state"], status["mode"]), (OPERATIONAL, "Walking"))
        self.subscribe(100, shared_memory=False)

        self.start_roudi()
        self.subscribe(100, shared_memory=False)
        status = self.status()
        self.assertEqual((status["state"], status["mode"]), (OPERATIONAL, "Walking"))
        client.signal(signal.SIGINT)
        self.assertEqual(client.wait(60), 0)
        self.assert_resting(self.wait_state(IDLE))
        self.assertTrue(daemon.running())

    @real_time("shared memory")
    def test_a_roudi_that_hangs_changes_nothing_and_keeps_no_daemon_from_its_end(self):
        roudi = self.start_roudi_and_sim()
        config = self.write_config(shared_memory=True)
        daemon = self.start_daemon(config)
        self.assertEqual(self.wait_modules()["shared_memory"], "active")
        roudi.halt()
        client = self.begin_walk()
        client.signal(signal.SIGINT)
        self.assertEqual(client.wait(60), 0)
        self.assert_resting(self.wait_state(IDLE))
        self.assertEqual(self.status()["shared_memory"], "active", "its memory is ours")
        ended_s = time.monotonic()
        daemon.signal(signal.SIGTERM)
        self.assertEqual(daemon.wait(30), 0)
        print(f"ended after {time.monotonic() - ended_s:.1f} s")
        self.start_daemon(config)
        self.assertEqual(self.wait_modules()["shared_memory"], "absent")
        self.walk_again()

    def test_a_service_manager_that_hangs_keeps_no_daemon_from_stopping_safely_and_ending(self):
        self.start_sim()
        path = os.path.join(self.folder, "notify")
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager, \
                socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_NONBLOCK) as probe:
            manager.bind(path)  # and never reads
            daemon = self.start_daemon(NOTIFY_SOCKET=path)
            self.wait_modules()
            self.begin_walk()

            def full():
                try:
                    probe.sendto(b"STATUS=probe", path)
                except BlockingIOError:
                    return True
                return False
            wait_until(full, 10, "nothing more can be sent to it")
            daemon.signal(signal.SIGTERM)
            self.assertEqual(daemon.wait(30), 0)

    @real_time("shared memory")
    def test_without_roudi_telemetry_goes_by_the_network_and_status_says_so(self):
        self.take_roudi()
        self.start_sim()
        self.start_daemon(self.write_config(shared_memory=True))
        status = self.wait_modules()
        self.assertEqual(status["shared_memory"], "absent")
        self.assertNotEqual(status["shared_memory_text"], "")
        self.subscribe(100, shared_memory=False)

    @real_time("shared memory")
    def test_a_subscriber_from_the_idl_alone_gets_loaned_samples_by_shared_memory(self):
        self.start_roudi_and_sim()
        self.start_daemon(self.write_config(shared_memory=True))
        self.assertEqual(self.wait_modules()["shared_memory"], "active")
        said = self.subscribe(200, shared_memory=True)
        self.assertIn("reader shm=1 loan=1", said)
        self.assertIn("loaned 20", said)  # the last take may bring a few more than 200
        self.assertIn("chunks 20", said)


if __name__ == "__main__":
    unittest.main()
