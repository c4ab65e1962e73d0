"""D.I.A.N.A. Ardito on can0 in the box, with `candump` as the witness. The vehicle is `lss-sim ardito`, without rigid bodies: those
are too slow here."""

import json
import os
import sys

import canlog
from box import SOURCE, Box

sys.path.append(os.path.join(SOURCE, "tests/e2e"))
import recording  # noqa: E402  pylint: disable=wrong-import-position,wrong-import-order

UNIT = "lssd@ardito"
SIM = "/run/ardito"


class Rover(Box):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.use_can()
        cls.start_sim("ardito", "--dir", SIM, "--can", "can0", "--plant", "kinematic", "--truth", "/run/truth.jsonl")
        cls.must(f"systemctl start {UNIT}", 120)

    def tearDown(self):
        super().tearDown()
        self.run_there("systemctl stop watch drive; systemctl reset-failed; true")

    def watch_bus(self, name):
        self.watched = f"{name}.log"
        self.must(f"systemd-run -q --unit=watch --collect -p StandardOutput=file:/run/{self.watched} "
                  "candump -L -d -r 4194304 can0,0:0,#FFFFFFFF")
        self.wait(f"[ -s /run/{self.watched} ]", "candump watches", 20)

    def seen(self):
        """All that candump saw, whose log was written to its end."""
        self.must(f"systemctl stop watch && mv /run/{self.watched} /mnt/host/", 60)
        return canlog.read(os.path.join(self.share, self.watched))

    def all_nodes_run(self):
        self.wait_status("s['telemetry'] and all(n['online'] for n in s['telemetry']['nodes'])", "all nodes run", 60)

    def drive(self, speed_m_s):
        self.must(f"systemd-run -q --unit=drive --collect lss-cli --jsonl drive {speed_m_s}")
        self.wait_status("s['mode'] == 'Running'", "it drives", 60)

    def end_drive(self):
        """Interrupts the driving client; it has ended when this returns."""
        self.run_there("systemctl kill -s INT drive; systemctl stop drive; systemctl reset-failed drive; true")

    def truth(self):
        return json.loads(self.must("tail -n 2 /run/truth.jsonl").splitlines()[0])

    def stands(self):
        self.until(lambda: max(map(abs, self.truth()["velocity_m_s"])) < 0.001, "the rover stands", 20)

    def frames_of(self, name):
        """Of one flight recording there, and how far UTC is ahead of their clock."""
        self.must(f"cp {name} /mnt/host/copy.lssrec")
        header, items, _ = recording.read(os.path.join(self.share, "copy.lssrec"))
        schema = recording.Schema(header["schema"])
        frames = [item for kind, item in items if kind == recording.FRAME]
        return (schema.read(frame)[0] for frame in frames), len(frames), header["utc_ns"] - header["time_ns"]
