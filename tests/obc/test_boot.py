"""The installed package on a booted OBC: up to READY, with only the rights that it needs, and stopped."""

import os
import re
import shutil
import signal
import threading
import time
import unittest

from box import Box, setUpModule  # noqa: F401  pylint: disable=unused-import


STILL_S, LIMIT_S = 6, 1  # of the host, of the box


class Boot(Box):
    def test_1_a_real_time_kernel_with_nothing_enabled_by_surprise(self):
        self.assertIn("PREEMPT_RT", self.must("uname -v"))
        self.assertEqual(self.must("id -gn lss; id -gn iox"), "lss\nlss")
        self.assertEqual(self.must("systemctl list-units --no-legend 'lssd@*' iox-roudi.service"), "")
        for unit in ("lssd@ardito", "iox-roudi"):
            self.assertEqual(self.run_there(f"systemctl is-enabled {unit}")[1], "disabled")

    def test_2_socket_can_works_as_the_tests_of_the_port_say(self):
        if "LSS_OBC_TEST_CAN" not in os.environ:
            self.skipTest("test_can is not built for this box")
        shutil.copy(os.environ["LSS_OBC_TEST_CAN"], self.share)
        self.must("ip link add can9 type vcan && ip link set can9 up")
        text = self.must("LSS_TEST_CAN=can9 /mnt/host/test_can --gtest_filter='SocketCanTest.*'", 120)
        counts = re.search(r"\[  PASSED  \] (\d+) tests", text)
        self.assertTrue(counts and int(counts[1]) >= 12 and "SKIPPED" not in text, text)
        print(f"SocketCanTest: {counts[1]} passed")

    def test_3_it_comes_up_to_ready_over_can(self):
        self.use_can()
        took = self.must("s=$EPOCHREALTIME; systemctl start lssd@ardito; r=$?; echo $s $EPOCHREALTIME; exit $r", 120).split()
        print(f"systemctl start, which returns at READY: {float(took[1]) - float(took[0]):.1f} s")
        self.assertEqual(self.active("lssd@ardito"), "active")
        self.assertEqual(self.active("iox-roudi"), "active")
        status = self.wait_status("s['telemetry']", "it answers", 60)
        self.assertEqual((status["state"], status["shared_memory"]), ("Idle", "active"), status["shared_memory_text"])
        self.must("timeout 20 candump -n 5 can0,080:7FF | grep -c ' 080 ' | grep -qx 5")  # it is on the bus

    def test_4_real_time_and_locked_memory_without_a_capability(self):
        realtime = self.status()["realtime"]
        self.assertTrue(realtime["granted"] and realtime["memory_locked"], realtime)
        pid = self.pid("lssd@ardito")
        threads = self.must(f"for t in /proc/{pid}/task/*; do echo $(cat $t/comm) $(chrt -p ${{t##*/}}); done")
        self.assertEqual(threads.count("SCHED_FIFO"), 3, threads)
        kernel = dict(re.findall(r"(\w+):\s+(\S+)", self.must(f"cat /proc/{pid}/status")))
        self.assertGreater(int(kernel["VmLck"]), 0)
        for name in ("CapEff", "CapPrm", "CapBnd", "CapAmb"):
            self.assertEqual(int(kernel[name], 16), 0, name)
        self.assertEqual((kernel["NoNewPrivs"], kernel["Seccomp"]), ("1", "2"))
        self.assertEqual(self.must(f"stat -c %U:%G /proc/{pid}"), "lss:lss")

    def test_5_the_exposure_of_its_units_is_at_most_2(self):
        for unit in ("lssd@ardito.service", "iox-roudi.service"):
            text = self.must(f"systemd-analyze security --no-pager {unit}")
            line = re.search(r"Overall exposure level for \S+: ([\d.]+).*", text)
            print(line[0])
            self.assertLessEqual(float(line[1]), 2.0, text)

    def test_6_stopped_it_is_gone_and_nothing_failed(self):
        self.must("systemctl stop lssd@ardito", 60)
        self.assertEqual(self.active("lssd@ardito"), "inactive")
        self.assertEqual(self.show("lssd@ardito", "Result"), "success")
        self.must("systemctl stop iox-roudi")
        self.assertEqual(self.must("systemctl --failed --no-legend"), "")

    def test_7_no_time_passes_while_the_host_stands_still(self):
        """Else a busy host would let limits pass: systemd's of 90 s for a mount or a unit, and those of these tests."""
        begun, go_on = (os.path.join(self.share, name) for name in ("begun", "go_on"))

        def stand_still():
            while not os.path.exists(begun):
                time.sleep(0.01)
            self.machine.process.send_signal(signal.SIGSTOP)
            time.sleep(STILL_S)
            self.machine.process.send_signal(signal.SIGCONT)
            with open(go_on, "wb"):
                pass

        threading.Thread(target=stand_still, daemon=True).start()
        stood = []

        def stood_before():
            if stood:
                return True
            # The loop keeps the CPU busy: time would leap ahead.
            stood.append(self.must("while :; do :; done & begin=$EPOCHREALTIME; touch /mnt/host/begun; until [ -e /mnt/host/go_on ]; "
                                   "do :; done; end=$EPOCHREALTIME; kill $!; echo $begin $end", LIMIT_S).split())
            return False

        self.until(stood_before, "it is asked again", LIMIT_S)
        self.assertLess(float(stood[0][1]) - float(stood[0][0]), LIMIT_S)


if __name__ == "__main__":
    unittest.main(failfast=True)
