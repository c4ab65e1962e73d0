"""Flight recordings on both sides of the box: a walk, a drive and a hop in it, in simulated time, replay equal on this
machine; those of this machine's programs (label "record") replay equal in it. In arm64's box: on another processor."""

import glob
import os
import shutil
import subprocess
import unittest

import vm
from box import Box, setUpModule  # noqa: F401  pylint: disable=unused-import

LSSD = os.environ["LSS_OBC_LSSD"]  # this machine's
RECORDINGS = os.environ["LSS_OBC_RECORDINGS"]
FOREIGN = 4  # exit code of lssd --replay: another layout, format or vehicle


class Recordings(Box):
    """Without rigid bodies of legs and wheels: those are too slow here."""

    def move(self, vehicle, motion, seconds, words="", **changes):
        """The programs as they are installed, for so many simulated seconds. Their recording, on this machine."""
        folder, config = f"/run/{vehicle}", f"/run/{vehicle}.toml"
        self.must(f"cp /etc/lss/{vehicle}.toml {config}")
        for key, value in {"shared_memory": "false", **changes}.items():
            self.must(f"sed -i -E 's/^{key} *=[^#]*/{key} = {value} /' {config} && [ $(grep -c '^{key} = {value}' {config}) = 1 ]")
        self.must(f"systemd-run -q --unit=sim lss-sim {vehicle} --dir {folder} --pace --lockstep --speed max --seed 7 "
                  f"--client-at 3 --for {seconds} {words}")
        self.wait(f"[ -e {folder}/lockstep ]", "the simulator is ready", 60)
        self.must(f"systemd-run -q --unit=daemon lssd --lockstep --config {config} --run-dir {folder}")
        print(self.must(f"time lss-cli run --lockstep --dir {folder} -e '{motion}'", 900), flush=True)
        self.wait("! systemctl is-active -q sim", "the simulator ends", 300)
        self.must("systemctl stop daemon; ! systemctl is-failed -q sim daemon", 60)
        name = self.must(f"ls {folder}/*.lssrec")
        copy = os.path.join(self.share, f"{vehicle}.lssrec")
        self.must(f"cp {name} /mnt/host/{vehicle}.lssrec")
        print(self.must(f"lssd --replay {name}", 300))
        return copy

    def replays_here(self, path):
        result = subprocess.run([LSSD, "--replay", path], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                check=False, timeout=vm.HANG_S)
        print(result.stdout, flush=True)
        self.assertEqual(result.returncode, 0, result.stdout)

    def test_1_a_walk_of_zebro(self):
        self.replays_here(self.move("zebro", "start; stand; walk forward --speed high --for 5s; stop", 25, "--plant kinematic"))

    def test_2_a_drive_of_ardito(self):
        self.replays_here(self.move("ardito", "start; drive 0.3 --heading 5 --for 5s; park 0.4 --for 2s; stop", 25,
                                    "--plant kinematic"))

    def test_3_a_hop_of_talaris(self):
        self.replays_here(self.move("talaris", "hop --arm --height 2 --distance 5", 40, calibration_s="5.0"))

    def test_4_recordings_of_this_machine_replay_there(self):
        equal = 0
        for path in sorted(glob.glob(os.path.join(RECORDINGS, "*.lssrec"))):
            shutil.copy(path, self.share)
            status, text = self.run_there(f"lssd --replay /mnt/host/{os.path.basename(path)}", 300)
            print(os.path.basename(path), text, flush=True)
            self.assertIn(status, (0, FOREIGN), text)
            equal += status == 0
        if not equal:
            self.skipTest(f"no recordings of this layout in {RECORDINGS}: ctest -L record makes them")


if __name__ == "__main__":
    unittest.main()
