"""docs/install.md, followed literally by an ordinary person, up to its last line; then nothing is left."""

import os
import re
import unittest

from box import SOURCE, Box, setUpModule  # noqa: F401  pylint: disable=unused-import
from vm import shlex

# Of the whole disk: everything but what lives by itself.
SNAPSHOT = ("find / -xdev \\( -path /var/log -o -path /var/lib/apt -o -path /var/cache -o -path /tmp -o -path /run "
            "-o -path /var/lib/systemd -o -path /var/tmp -o -path /mnt -o -path /home \\) -prune -o -print | sort; "
            "ls /dev/shm; cut -d: -f1 /etc/passwd /etc/group | sort; ls -d /run/lss /tmp/systemd-private*lssd* 2> /dev/null; true")


def blocks():
    with open(os.path.join(SOURCE, "docs/install.md"), encoding="utf-8") as file:
        return re.findall(r"^```sh\n(.*?)^```", file.read(), re.M | re.S)


class Install(Box):
    INSTALL = False

    def test_the_document_leads_from_a_bare_computer_to_a_moving_vehicle_and_back(self):
        self.must("cp /mnt/host/*.deb /home/operator && chown operator: /home/operator/*.deb")
        before = self.must(SNAPSHOT)
        said = {}
        for block in blocks():
            command = f"cd; set -e\n{block}"
            status, text = self.run_there(f"runuser -u operator -- env HOME=/home/operator bash -c {shlex.quote(command)}", 240)
            print(f"--- {block.strip()}\n{text}", flush=True)
            self.assertEqual(status, 0, f"{block}\n{text}")
            said[block] = text
            if "enable --now lssd@" in block:
                self.wait_status("all(m['online'] for m in s['modules'])", "the modules answer", 60)
            if "lss-cli walk" in block:
                walked = float(re.search(r"walk forward high ([\d.]+) m", text)[1])
                self.assertGreater(walked, 0.05)
        self.assertTrue(any("lss-cli walk" in block for block in said))

        self.must("systemctl stop lss-sim 2> /dev/null; systemctl reset-failed; rm /etc/systemd/network/80-can0.network")
        self.assertEqual(self.run_there("pgrep -l 'lssd|iox-roudi'")[1], "")
        after = self.must(SNAPSHOT)
        left = sorted(set(after.splitlines()) - set(before.splitlines()))
        left = [line for line in left if not re.search(r"\.wants/systemd-network|/systemd/system/(dbus-org|sockets|"
                                                       r"sysinit|network-online)|^/etc/.*-$|/var/lib/dpkg/", line)]
        self.assertEqual(left, [], "what is left after purge")


if __name__ == "__main__":
    unittest.main()
