"""Faults on an OBC around the daemon of Ardito on can0. No node answers there: its own process, its
interface, RouDi, the disk and the clock are what it is about; test_drive.py has the vehicle."""

import unittest

from box import Box, setUpModule  # noqa: F401  pylint: disable=unused-import

UNIT = "lssd@ardito"


class Faults(Box):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.use_can()
        cls.must(f"systemctl start {UNIT}", 120)

    def setUp(self):
        self.wait(f"systemctl is-active -q {UNIT}", "the daemon runs", 60)
        self.wait_status("s['telemetry']", "it answers", 60)

    def on_the_bus(self):
        """SYNC is sent: five in time, regardless of the state of the process."""
        return self.run_there("timeout 20 candump -n 5 can0,080:7FF | grep -c ' 080 ' | grep -qx 5")[0] == 0

    def comes_up_safe(self, pid):
        self.wait(f"systemctl is-active -q {UNIT} && [ $(systemctl show -P MainPID {UNIT}) != {pid} ]", "it runs again", 90)
        status = self.wait_status("s['telemetry']", "it answers", 60)
        self.assertIn(status["state"], ("Idle", "FatalError"))
        self.assertTrue(all(wheel["target_rad_s"] == 0 for wheel in status["telemetry"]["wheels"]))
        self.assertTrue(self.on_the_bus())

    def test_1_a_daemon_that_hangs_is_killed_by_its_watchdog_and_started_again(self):
        pid, restarts = self.pid(UNIT), int(self.show(UNIT, "NRestarts"))
        self.must(f"kill -STOP {pid}")
        took = self.wait(f"[ $(systemctl show -P NRestarts {UNIT}) -gt {restarts} ]", "it is started again", 60)
        print(f"started again {took:.1f} s after it was halted")
        self.must(f"journalctl -b -u {UNIT} -o cat --no-pager | grep -i 'watchdog timeout'")
        self.comes_up_safe(pid)

    def test_2_killed_it_comes_up_safe(self):
        pid = self.pid(UNIT)
        self.must(f"kill -KILL {pid}")
        self.comes_up_safe(pid)

    def test_3_a_roudi_that_dies_costs_no_restart_and_is_taken_up_again(self):
        pid, roudi = self.pid(UNIT), self.pid("iox-roudi")
        self.must(f"systemctl restart {UNIT}", 120)
        pid = self.pid(UNIT)
        self.wait_status("s['shared_memory'] == 'active'", "shared memory", 60)
        self.must(f"kill -KILL {roudi}")
        self.wait(f"systemctl is-active -q iox-roudi && [ $(systemctl show -P MainPID iox-roudi) != {roudi} ]",
                  "RouDi runs again", 60)
        self.wait_status("s['shared_memory'] == 'lost' and s['telemetry']", "it says so, and telemetry goes by the network", 60)
        self.assertEqual(self.pid(UNIT), pid)
        self.must(f"systemctl restart {UNIT}", 120)
        self.wait_status("s['shared_memory'] == 'active'", "shared memory again", 60)

    def test_4_the_daemon_waits_until_roudi_can_be_used(self):
        self.must(f"systemctl stop {UNIT} iox-roudi", 90)
        self.must("mkdir -p /run/systemd/system/iox-roudi.service.d && printf '[Service]\\nExecStart=\\n"
                  "ExecStart=/bin/sh -c \"sleep 4; exec /usr/bin/iox-roudi -c /etc/lss/roudi.toml\"\\n' "
                  "> /run/systemd/system/iox-roudi.service.d/late.conf && systemctl daemon-reload")
        try:
            self.must(f"systemctl start {UNIT}", 120)
            began = int(self.show("iox-roudi", "ExecMainStartTimestampMonotonic"))
            daemon = int(self.show(UNIT, "ExecMainStartTimestampMonotonic"))
            self.assertGreater(daemon - began, 4_000_000)
            self.assertEqual(self.wait_status("True", "it answers")["shared_memory"], "active")
        finally:
            self.must("rm /run/systemd/system/iox-roudi.service.d/late.conf && systemctl daemon-reload")

    def test_5_an_interface_that_goes_down_is_reported_and_taken_again(self):
        pid = self.pid(UNIT)
        self.must("ip link set can0 down")
        status = self.wait_status("any(f['name'] in ('port_lost', 'port_absent', 'bus_off') for f in s['faults'])",
                                  "it says so", 60)
        print("can0 down:", ", ".join(sorted({f["name"] for f in status["faults"]})))
        self.must("ip link set can0 up")
        self.wait_status("s['telemetry'] and s['telemetry']['port_open']", "the port is open again", 60)
        self.assertTrue(self.on_the_bus())
        self.assertEqual(self.pid(UNIT), pid, "it is the same process")

    def test_6_a_full_disk_stops_no_frame(self):
        pid = self.pid(UNIT)
        self.must("fallocate -l $(df --output=avail -B 1 / | tail -n 1) /var/fill; dd if=/dev/zero of=/var/fill2 bs=4k; "
                  "[ $(df --output=avail / | tail -n 1) -lt 100 ]", 120)
        try:
            index = self.status()["frame"]["index"]
            self.wait_status(f"s['frame']['index'] > {index} + 30", "frames go on", 60)
            self.assertEqual(self.pid(UNIT), pid)
            self.assertTrue(self.on_the_bus())
        finally:
            self.must("rm -f /var/fill /var/fill2")


if __name__ == "__main__":
    unittest.main()
