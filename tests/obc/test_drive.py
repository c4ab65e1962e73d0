"""Ardito drives over can0, its nodes and its body simulated in the box."""

import json
import re
import unittest

from box import Box, setUpModule  # noqa: F401  pylint: disable=unused-import

UNIT = "lssd@ardito"


class Drive(Box):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.use_can()
        cls.start_sim("ardito", "--dir", "/tmp/ardito", "--can", "can0", "--pace", "--truth", "/tmp/truth.jsonl")
        cls.must(f"systemctl start {UNIT}", 90)

    def setUp(self):
        self.ready()

    # --- helpers

    def ready(self):
        self.wait(f"systemctl is-active -q {UNIT}", "the daemon runs", 60)
        self.wait_status("all(n['online'] for n in s['nodes'])", "all nodes run", 60)
        if self.status()["state"] == "FatalError":
            self.must("lss-cli solve", 90)
        self.wait_status("s['state'] == 'Idle'", "Idle", 30)

    def truth(self):
        return json.loads(self.must("tail -n 2 /tmp/truth.jsonl | head -n 1"))

    def speed(self):
        return max(abs(v) for v in self.truth()["velocity_m_s"])

    def begin_drive(self):
        self.must("systemctl reset-failed drive 2> /dev/null; systemd-run -q --unit=drive --collect lss-cli drive 0.3")
        self.wait_status("s['mode'] == 'Running'", "it drives", 60)
        self.until(lambda: self.speed() > 0.05, "the wheels turn")

    def rests(self):
        """By the simulator, which is the wheels: whatever the daemon thinks."""
        self.until(lambda: self.speed() < 0.02, "the rover stands")

    # --- tests

    def test_1_it_drives_over_can0_with_a_regular_sync(self):
        before = self.truth()
        self.must("candump -n 3000 -T 20000 -t a can0 > /tmp/can.log & canbusload -t can0@500000 > /tmp/load.log & "
                  "load=$!; lss-cli drive 0.3 --for 8s; result=$?; kill $load; exit $result", 120)
        after = self.truth()
        moved = after["position_m"][0] - before["position_m"][0]
        frames = re.findall(r"\(([\d.]+)\)\s+can0\s+([0-9A-F]{3})\s", self.must("cat /tmp/can.log"))
        sync = [float(t) for t, identifier in frames if identifier == "080"]
        period = (sync[-1] - sync[0]) / (len(sync) - 1)
        gaps = [b - a for a, b in zip(sync, sync[1:])]
        kinds = {identifier for _, identifier in frames}
        load = max(int(p) for p in re.findall(r"(\d+)%", self.must("cat /tmp/load.log")))
        print(f"{moved:.2f} m; SYNC {len(sync)} times, {period * 1e3:.2f} ms, gaps {min(gaps) * 1e3:.1f} to "
              f"{max(gaps) * 1e3:.1f} ms; {len(kinds)} identifiers; bus load at most {load} %")
        self.assertGreater(moved, 0.2)
        self.assertGreater(len(sync), 30)
        self.assertAlmostEqual(period, 0.100, delta=0.002)
        for node in (1, 2, 3, 4, 5, 6, 17, 18, 21, 22, 32, 33):
            self.assertIn(f"{0x700 + node:03X}", kinds, "heartbeats of each node")
        self.assertLess(load, 60)

    def test_2_a_daemon_that_hangs_is_killed_by_its_watchdog_and_started_again(self):
        self.begin_drive()
        pid, restarts = self.pid(UNIT), int(self.show(UNIT, "NRestarts"))
        self.must(f"kill -STOP {pid}")
        self.rests()
        took = self.wait(f"[ $(systemctl show -P NRestarts {UNIT}) -gt {restarts} ]", "it is started again", 60)
        print(f"started again {took:.1f} s after it stood")
        self.must(f"journalctl -b -u {UNIT} -o cat --no-pager | grep -i 'watchdog timeout'")
        self.wait(f"systemctl is-active -q {UNIT}", "it runs again", 60)
        self.assertNotEqual(self.pid(UNIT), pid)
        self.assertNotEqual(self.wait_status("True", "it answers")["state"], "Operational")

    def test_3_killed_it_comes_up_safe(self):
        self.begin_drive()
        pid = self.pid(UNIT)
        self.must(f"kill -KILL {pid}")
        self.rests()
        self.wait(f"systemctl is-active -q {UNIT} && [ $(systemctl show -P MainPID {UNIT}) != {pid} ]", "it runs again", 60)
        self.assertNotEqual(self.wait_status("True", "it answers")["state"], "Operational")
        self.rests()

    def test_4_an_interface_that_goes_down_stops_the_rover_and_comes_back(self):
        self.begin_drive()
        pid = self.pid(UNIT)
        self.must("ip link set can0 down")
        self.rests()
        status = self.wait_status("s['state'] == 'FatalError'", "a fatal error", 30)
        print("can0 down:", ", ".join(sorted({f["name"] for f in status["faults"]})))
        self.must("ip link set can0 up")
        self.wait_status("all(n['online'] for n in s['nodes'])", "all nodes run again", 60)
        self.must("lss-cli solve", 90)
        self.assertEqual(self.pid(UNIT), pid, "it is the same process")
        self.must("lss-cli drive 0.3 --for 2s", 60)

    def test_5_stopping_the_unit_stops_the_vehicle_first(self):
        self.begin_drive()
        self.must(f"systemctl stop {UNIT}", 60)
        self.rests()
        self.assertEqual((self.active(UNIT), self.show(UNIT, "Result")), ("inactive", "success"))
        self.must(f"systemctl start {UNIT}", 90)


if __name__ == "__main__":
    unittest.main()
