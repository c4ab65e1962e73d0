"""The power goes while everything is logged."""

import json
import unittest

from box import Box, setUpModule  # noqa: F401  pylint: disable=unused-import


class Power(Box):
    DISK = True

    def test_files_survive_a_power_cut_and_the_daemon_comes_up_by_itself(self):
        self.use_can()
        self.must("sed -i 's|^use = \"standard\"|use = \"everything\"|' /etc/lss/ardito.toml")
        self.start_sim("ardito", "--dir", "/tmp/ardito", "--can", "can0")
        self.must("systemctl enable --now lssd@ardito", 90)
        self.wait("[ $(cat /var/lib/lss/*.log.jsonl | wc -c) -gt 1000000 ]", "it logs", 90)
        self.must("sync")  # what the disk was told to keep
        kept = int(self.must("cat /var/lib/lss/*.log.jsonl | wc -l"))
        self.wait(f"[ $(cat /var/lib/lss/*.log.jsonl | wc -l) -gt {kept + 20} ]", "it logs on", 60)
        self.machine.cut_power()

        type(self).boot()
        self.must("dmesg | grep 'recovery complete'")
        self.wait("systemctl is-active -q lssd@ardito", "it runs after the boot", 90)
        self.wait_status("True", "it answers", 60)
        self.assertEqual(self.must("systemctl --failed --no-legend"), "")
        old = self.must("ls -t /var/lib/lss/*.log.jsonl | tail -n 1")
        self.must(f"cp {old} /mnt/host/log.jsonl")
        with open(f"{self.share}/log.jsonl", "rb") as file:
            *whole, last = file.read().split(b"\n")
        for line in whole:
            json.loads(line)
        print(f"{len(whole)} lines whole of {kept} that were synced; {len(last)} bytes of one cut off")
        self.assertGreaterEqual(len(whole), kept)
        self.must(f"lss-cli log show {old} | tail -n 1")
        # The configuration that was edited is what it was.
        self.must("grep -q '^path = \"can0\"' /etc/lss/ardito.toml && dpkg --verify lssd | grep -v '/etc/lss/' ; true")


if __name__ == "__main__":
    unittest.main()
