"""Lunar Zebro over a serial port, with the daemon in its unit and the simulator in the box."""

import json
import re
import unittest

from box import Box, setUpModule  # noqa: F401  pylint: disable=unused-import


class Zebro(Box):
    def test_walks_with_every_frame_in_time(self):
        # The terminal belongs to the user of the daemon, as a serial port belongs to one of its groups.
        self.must("systemd-run -q --unit=lss-sim --collect -p User=lss -p RuntimeDirectory=zebro "
                  "lss-sim zebro --dir /run/zebro --plant kinematic --pace --truth /run/zebro/truth.jsonl")
        self.wait("[ -e /run/zebro/legs ]", "the port is there")
        self.must("sed -i 's|^path = \"sim:legs\"|path = \"/run/zebro/legs\"|' /etc/lss/zebro.toml")
        self.must("systemctl start lssd@zebro")
        self.wait_status("all(m['online'] for m in s['modules'])", "all modules answer")
        self.must("lss-cli timing --reset > /dev/null")
        text = self.must("lss-cli walk forward --speed high --for 15s", 120)
        said = float(re.search(r"walk forward high ([\d.]+) m", text)[1])
        status = self.status()
        truth = json.loads(self.must("tail -n 2 /run/zebro/truth.jsonl | head -n 1"))
        timing = self.must("lss-cli timing")
        late = re.search(r"(\d+) of (\d+) commands late", timing)
        print(f"{said:.3f} m, really {truth['position_m'][0]:.3f} m; {late[0]}")
        print(timing.split("\n\n")[0])
        self.assertGreater(truth["position_m"][0], 0.1)
        self.assertEqual((status["state"], status["fault_count"]), ("Idle", 0))
        self.assertEqual((late[1], status["frame"]["overruns"]), ("0", 0))
        self.must("systemctl stop lssd@zebro")
        self.assertEqual(self.show("lssd@zebro", "Result"), "success")


if __name__ == "__main__":
    unittest.main()
