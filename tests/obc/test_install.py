"""docs/install.md, followed literally by an ordinary person, up to its last line; then nothing is left."""

import glob
import os
import re
import subprocess
import unittest

from box import SOURCE, Box, setUpModule  # noqa: F401  pylint: disable=unused-import
from vm import shlex

# The whole disk, except for files that change by themselves.
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
                self.wait_status("s['telemetry'] and all(m['online'] for m in s['telemetry']['modules'])", "the modules answer", 60)
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


class Removal(Box):
    """Upgrade and removal of a vehicle that runs, with a configuration that was edited."""

    EDITED = "grep -q '^path = \"can0\"' /etc/lss/ardito.toml"

    @classmethod
    def newer(cls):
        """The package as a next version with other defaults would be, in the shared folder."""
        tree = os.path.join(cls.share, "tree")
        deb = glob.glob(os.path.join(cls.share, "lssd_*.deb"))[0]
        for words in (["dpkg-deb", "-R", deb, tree],
                      ["sed", "-i", "s/^Version: .*/Version: 99.0/", os.path.join(tree, "DEBIAN/control")],
                      ["sed", "-i", "s/^offset_ms = .*/offset_ms = 11/", os.path.join(tree, "etc/lss/ardito.toml"),
                       os.path.join(tree, "etc/lss/zebro.toml")],
                      ["dpkg-deb", "--root-owner-group", "-Zgzip", "-b", tree, os.path.join(cls.share, "newer.deb")]):
            subprocess.run(words, stdout=subprocess.DEVNULL, check=True)

    def test_1_an_upgrade_leaves_a_running_vehicle_alone_and_keeps_what_was_edited(self):
        self.use_can()
        self.must("systemctl enable --now lssd@ardito", 120)
        pid = self.pid("lssd@ardito")
        self.newer()
        # An empty answer at dpkg's question is its default: the file stays as it is.
        self.must("echo | dpkg -i /mnt/host/newer.deb", 120)
        self.assertEqual(self.must("dpkg-query -W -f '${Version} ${Status}' lssd"), "99.0 install ok installed")
        self.assertEqual((self.pid("lssd@ardito"), self.active("lssd@ardito")), (pid, "active"))
        self.must(f"{self.EDITED} && ! grep -q '^offset_ms = 11' /etc/lss/ardito.toml")
        self.must("grep -q '^offset_ms = 11' /etc/lss/ardito.toml.dpkg-dist", 10)
        self.must("grep -q '^offset_ms = 11' /etc/lss/zebro.toml")  # that one was not edited
        self.must("systemctl restart lssd@ardito", 120)
        self.assertEqual(self.wait_status("True", "the new version answers")["vehicle"], "ardito")

    def test_2_removal_stops_the_vehicle_and_keeps_its_configuration_and_logs(self):
        self.must("dpkg -r lssd", 120)
        self.assertEqual(self.run_there("pgrep -l 'lssd|iox-roudi'")[1], "")
        self.must(f"{self.EDITED} && ls /var/lib/lss/*.jsonl && getent passwd lss")
        self.assertEqual(self.must("find /etc/systemd/system -name '*lssd*'; systemctl --failed --no-legend"), "")

    def test_3_installed_again_it_runs_with_what_was_kept(self):
        self.must("dpkg -i /mnt/host/newer.deb < /dev/null && systemctl start lssd@ardito", 120)
        self.must(f"{self.EDITED} && timeout 20 candump -n 1 can0,080:7FF")


if __name__ == "__main__":
    unittest.main()
