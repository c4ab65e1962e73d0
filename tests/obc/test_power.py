"""Power cuts in the middle of writing: data on the disk is complete when the computer is up again. The disk
(disk.py) loses all unflushed data. Moments come from a seed: LSS_OBC_SEED, 1; cuts: LSS_OBC_CUTS, 5."""

import glob
import json
import os
import random
import re
import subprocess
import sys
import unittest

import vm
from box import SOURCE, Box, setUpModule  # noqa: F401  pylint: disable=unused-import
from disk import Disk

sys.path.append(os.path.join(SOURCE, "tests/e2e"))
import recording  # noqa: E402  pylint: disable=wrong-import-position,wrong-import-order

UNIT = "lssd@ardito"
PARAMETER = "solve.budget_s"  # any number will do
CUTS = int(os.environ.get("LSS_OBC_CUTS", "5"))
SEED = int(os.environ.get("LSS_OBC_SEED", "1"))
PERIOD_NS, LEAD_NS, MOST_LOST_NS = 100_000_000, 10_000_000, 100_000_000  # config/ardito.toml


class Power(Box):
    @classmethod
    def boot(cls):
        if cls.disk is None:
            folder = f"{cls.share}-disk"
            os.mkdir(folder)
            cls.addClassCleanup(subprocess.run, ["rm", "-r", folder], check=True)
            cls.drive = Disk(os.path.join(vm.IMAGE, "root.ext4"), folder, SEED)
            cls.addClassCleanup(cls.drive.close)
            cls.disk = cls.drive.name
        super().boot()

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.random = random.Random(SEED)
        cls.use_can()
        # All of every frame into the log, and small files: a new one is begun every few seconds.
        cls.must("sed -i 's|^use = \"standard\"|use = \"everything\"|; s|^file_mb = [0-9]*|file_mb = 1|' "
                 "/etc/lss/ardito.toml && sync")

    # --- writing

    def begin_writing(self):
        """The daemon runs; a listener on the bus records the frames on another disk, that of this machine. Logs are the
        kernel's to write, after half a minute: here after a second, so that there is something to tear."""
        self.must("echo 100 > /proc/sys/vm/dirty_expire_centisecs; echo 50 > /proc/sys/vm/dirty_writeback_centisecs")
        self.must(f"systemctl start {UNIT}", 120)
        self.must("systemd-run -q --unit=watch -p StandardOutput=append:/mnt/host/sync.log "
                  "stdbuf -oL candump -L can0,080:7FF")
        self.wait_status("s['recording'] and s['frame']['index'] > 20", "frames are recorded", 60)
        # One save after the other; those that were acknowledged are noted by this machine.
        value, count = int(self.parameter()["value"]), len(self.acknowledged())
        self.must(f"systemd-run -q --unit=save sh -c 'v={value}; while :; do v=$((v + 1)); lss-cli param set {PARAMETER} $v && "
                  "lss-cli param save && echo $v >> /mnt/host/saved; done'")
        self.until(lambda: len(self.acknowledged()) > count, "parameters are saved", 60)

    def parameter(self):
        return json.loads(self.must(f"lss-cli --json param get {PARAMETER}"))["parameters"][0]

    def acknowledged(self):
        """Values of the parameter whose save was acknowledged."""
        path = os.path.join(self.share, "saved")
        if not os.path.exists(path):
            return []
        with open(path, encoding="ascii") as file:
            return [int(line) for line in file.read().split("\n")[:-1]]

    def cut(self):
        """In the middle of a write; UTC of the last SYNC received before."""
        self.drive.stop_in_write(self.random.randrange(1, 400), vm.HANG_S)
        self.machine.cut_power()
        lost, kept = self.drive.lose_power()
        with open(os.path.join(self.share, "sync.log"), encoding="ascii") as file:
            stamps = re.findall(r"^\((\d+)\.(\d{6})\) can0 080#\s*$", file.read(), re.M)
        return lost, kept, int(stamps[-1][0]) * 1_000_000_000 + int(stamps[-1][1]) * 1000

    # --- conditions

    def recordings_are_whole(self, cut_ns):
        """All of them are replayed to the bit; how much of the newest is missing before the cut."""
        names = self.must("ls /var/lib/lss/*.lssrec").split()
        status, text = self.run_there(f"lssd --replay {' '.join(names)}", 600)
        self.assertEqual(status, 0, text)
        # The newest may have been full and ended, or have no frame yet, when the power was cut: what is missing counts.
        self.must("rm -f /mnt/host/*.lssrec; cp " + " ".join(names[-2:]) + " /mnt/host/")
        for name in reversed(names[-2:]):
            header, items, _ = recording.read(os.path.join(self.share, os.path.basename(name)))
            frames = [item for kind, item in items if kind == recording.FRAME]
            if frames:
                break
        last = recording.Schema(header["schema"]).read(frames[-1])[0]
        last_ns = last["in"]["time_ns"] + header["utc_ns"] - header["time_ns"]
        return cut_ns + LEAD_NS - last_ns, "torn" in text

    def logs_are_whole(self):
        """Every line but the last of a file is JSON."""
        self.must("rm -rf /mnt/host/logs; mkdir /mnt/host/logs; cp /var/lib/lss/*.jsonl /mnt/host/logs/")
        lines = 0
        for path in glob.glob(os.path.join(self.share, "logs", "*.jsonl")):
            with open(path, "rb") as file:
                whole = file.read().split(b"\n")[:-1]
            for line in whole:
                try:
                    json.loads(line)
                except ValueError as error:
                    raise AssertionError(f"{path}: {error}: {line[:200]!r}") from None
            lines += len(whole)
        return lines

    def parameters_are_whole(self, events):
        """The acknowledged save is active again, or the one after it, which was in progress; and no copy is damaged."""
        last = self.acknowledged()[-1]
        parameter = self.parameter()
        self.assertIn(parameter["saved"], (last, last + 1))
        self.assertEqual(parameter["value"], parameter["saved"])
        self.assertIn("parameters_taken", events)
        self.assertEqual({"parameters_damaged", "parameters_refused"} & set(events), set())
        self.assertEqual(self.status()["saved_parameters"], "good")
        return int(parameter["saved"]) - last

    def comes_up_ready(self):
        """The names of its events."""
        self.must(f"systemctl start {UNIT}", 120)
        self.assertEqual(self.active(UNIT), "active")
        status = self.wait_status("s['telemetry']", "it answers", 60)
        self.assertEqual(status["state"], "Idle")
        self.wait_status("s['recording']", "everything is recorded", 20)
        return [e["name"] for e in json.loads(self.must("lss-cli --json events"))["events"]]

    def test_power_is_cut_at_any_moment_and_nothing_is_corrupt(self):
        torn_files, lines, ahead, missing_ns = 0, 0, 0, []
        for number in range(1, CUTS + 1):
            self.begin_writing()
            lost, kept, cut_ns = self.cut()
            self.boot()
            self.must("dmesg | grep -q 'EXT4-fs (vda): recovery complete'")
            self.assertEqual(self.must("dmesg | grep -E 'EXT4-fs (error|warning)' | cat"), "")
            missing, torn = self.recordings_are_whole(cut_ns)
            missing_ns.append(missing)
            before, lines = lines, self.logs_are_whole()
            self.assertGreaterEqual(lines, before)
            events = self.comes_up_ready()
            self.assertEqual("recording_cut" in events, torn, "what was torn is reported, and nothing else")
            ahead += self.parameters_are_whole(events)
            torn_files += torn
            print(f"cut {number}: {lost} writes not flushed, {kept} of them on the disk; recorded up to {missing / 1e6:.0f} ms "
                  f"before the frame of the last SYNC{', torn' if torn else ''}; {lines} lines of logs", flush=True)
        self.assertGreater(lines, 0)
        # SYNC was received, so the power was on until then: the frames before the last 100 ms are recorded.
        self.assertLessEqual(max(missing_ns), MOST_LOST_NS + PERIOD_NS, missing_ns)
        print(f"{CUTS} cuts, {torn_files} of them tore a recording, {ahead} came between a save and its acknowledgement; "
              f"{len(self.acknowledged())} saves, {self.drive.flushes} flushes")
        # The file system has no scar that it hides.
        self.must(f"systemctl stop {UNIT} && sync")
        try:
            self.run_there("systemctl poweroff")
        except vm.Gone:
            pass  # before it could answer
        self.machine.process.wait(vm.HANG_S)
        self.drive.gone.wait()
        self.drive.flush()
        path = f"{os.environ['PATH']}:/sbin:/usr/sbin"
        checked = subprocess.run(["e2fsck", "-fn", self.drive.safe_path], stdout=subprocess.PIPE,
                                 stderr=subprocess.STDOUT, text=True, env={**os.environ, "PATH": path}, check=False)
        self.assertEqual(checked.returncode, 0, checked.stdout)


if __name__ == "__main__":
    unittest.main()
