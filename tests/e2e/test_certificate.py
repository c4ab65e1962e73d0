"""Timing certificates: lss-cli timing certify makes one of recorded frames, lssd compares its frames with it."""

import json
import os
import unittest

from hopper_rig import Hopper
from programs import read_text
from rig import DAEMON

REFUSED, READY_LATE = 91, 92  # idl/codes.inc
PACKET_US = 1875  # docs/icd-talaris.md: in simulated time the only part of a frame that takes any


class Talaris(Hopper):
    IN_LOCKSTEP = True

    def certify(self, config, latency_us, *more):
        path, = [os.path.join(self.run_folder, name) for name in os.listdir(self.run_folder)
                 if name.endswith("000001-20260101T000000Z-talaris.lssrec")]
        return self.cli("--json", "timing", "certify", "--config", config, "--latency-us", str(latency_us), "--frames", "4",
                        "--lssd", DAEMON, path, *more)

    def events_of(self, *ids):
        return [e for e in self.events() if e["id"] in ids]

    def run_with(self, config, frames=8):
        """The events about its certificate, of a daemon that made some frames."""
        daemon = self.start_daemon(config)
        first = self.status()["frame"]["index"]
        self.wait_status(lambda s: s["frame"]["index"] > first + frames, 60, "some frames")
        events = self.events_of(REFUSED, READY_LATE)
        daemon.stop()
        return events, daemon.err()

    def change(self, **values):
        with open(self.certificate, encoding="utf-8") as file:
            certificate = json.load(file)
        certificate.update(values)
        with open(self.certificate, "w", encoding="utf-8") as file:
            json.dump(certificate, file)

    def test_a_frame_later_than_certified_is_an_event_and_a_wrong_certificate_is_refused(self):
        self.certificate = os.path.join(self.folder, "certificate.json")
        config = self.write_config(certificate=f'"{self.certificate}"')
        self.start_sim()

        events, said = self.run_with(config)  # there is none yet
        self.assertEqual([e["id"] for e in events], [REFUSED])
        self.assertIn("there is no such file", said)
        self.assertIn("lss-cli timing certify", said)

        made = self.certify(config, 100)
        self.assertEqual(made.code, 0, made)
        document = json.loads(made.out)
        self.assertGreater(document["cycle"]["instructions"], 1000)
        self.assertAlmostEqual(document["ready"]["us"], PACKET_US + 2 * 100 + document["cycle"]["us"], delta=0.3)
        self.assertEqual(document["release"]["us"], 200)
        self.assertEqual(document["ready"]["seen_us"], PACKET_US)
        self.assertAlmostEqual(document["ready"]["slack_us"], 5000 - document["ready"]["us"], delta=0.2)
        saved = json.loads(read_text(self.certificate))
        self.assertEqual(saved["ready"], document["ready"])

        events, said = self.run_with(config)
        self.assertEqual(events, [], said)

        # A planted frame: later than what is certified, by the packet that it waits for.
        self.change(ready={"us": 1800})
        events, said = self.run_with(config)
        self.assertEqual({e["id"] for e in events}, {READY_LATE})
        self.assertRegex(said, r"frame 2: its command was ready 187[45][.0-9]* us after the boundary, certified are 1800\n")
        self.assertGreater(events[-1]["count"], 1)

        self.change(ready=document["ready"], kernel="Linux 1.0")
        events, said = self.run_with(config)
        self.assertEqual([e["id"] for e in events], [REFUSED])
        self.assertIn('the kernel was "Linux 1.0" and is "Linux', said)
        self.assertNotIn("the machine was", said)

        # Another configuration than the certificate's.
        self.change(kernel=document["kernel"])
        other = self.write_config("other.toml", certificate=f'"{self.certificate}"', calibration_s="6.0")
        events, said = self.run_with(other)
        self.assertEqual([e["id"] for e in events], [REFUSED])
        self.assertIn("the configuration was", said)

        # No certificate is made that a recorded frame exceeds: as if the packet came sooner than it does.
        fast = os.path.join(self.folder, "fast.toml")
        with open(fast, "w", encoding="utf-8") as file:
            file.write(read_text(config).replace("baud = 115200", "baud = 230400"))
        out = os.path.join(self.folder, "none.json")
        made = self.certify(fast, 1, "--out", out)
        self.assertEqual(made.code, 6, made)
        self.assertIn("a recorded frame was later", made.err)
        self.assertFalse(os.path.exists(out))


if __name__ == "__main__":
    unittest.main()
