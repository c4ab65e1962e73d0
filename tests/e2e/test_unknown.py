"""lss-cli and lss-ground without any vehicle on their roster: commands and telemetry come from the dictionary of the
daemon. Beside them, the lss-cli that was built with all vehicles."""

import json
import os
import signal
import unittest

import motion
from programs import run, wait_until
from rig import BOOT_S, EXIT, IDLE, TOOLS, Scenario
from rover_rig import Rover
from test_ground import Beating, Gateway


def shape(value):
    """Which members it has, without the names that lss-cli adds."""
    if isinstance(value, dict):
        return {key: shape(part) for key, part in value.items() if key != "name"}
    return [shape(part) for part in value] if isinstance(value, list) else None


class Unknown:
    IN_LOCKSTEP = True
    TOOLS = os.environ.get("LSS_E2E_BARE")

    def json_of(self, *words):
        return json.loads(self.cli_ok("--json", *words).out)

    def full(self, *words):
        return run([os.path.join(TOOLS, "lss-cli"), *words], self.environment(), 60)

    def same_as_full(self, *words):
        """Of the answer in JSON."""
        self.assertEqual(self.json_of(*words), json.loads(self.full("--json", *words).out), words)

    @staticmethod
    def with_telemetry(which):
        """The status; telemetry may come later."""
        seen = []

        def comes():
            seen.append(json.loads(which("--json", "status").out))
            return seen[-1]["telemetry"]
        wait_until(comes, BOOT_S, "telemetry arrives")
        return seen[-1]

    def says_the_same(self):
        """Before anything moves."""
        bare, full = (self.with_telemetry(which) for which in (self.cli_ok, self.full))
        self.assertEqual(shape(bare), shape(full))
        self.assertEqual(bare["vehicle"], full["vehicle"])
        for name in ("state", "distance_m", "port_open"):
            self.assertEqual(bare["telemetry"][name], full["telemetry"][name])
        self.same_as_full("param", "get")
        self.same_as_full("events", "--last", "1")
        self.assertIn("distance", self.cli_ok("data").out)
        self.assertEqual(self.cli_ok("health").out, self.full("health").out)
        listed, known = (json.loads(which("--json", "command", "list").out)
                         for which in (self.cli_ok, self.full))
        self.assertEqual(listed, known)
        for command in known["commands"]:
            described = self.cli_ok("command", "describe", command["name"]).out
            whole = self.full("command", "describe", command["name"]).out
            self.assertEqual(described, whole)

    def refused(self, code, text, *words):
        """With the same words as by the full lss-cli."""
        bare, full = self.cli(*words), self.full(*words)
        self.assertEqual(bare.code, EXIT[code], bare)
        self.assertIn(text, bare.err)
        self.assertEqual(bare.err, full.err)

    def telemetry_of(self, path):
        """Names of the columns of its telemetry in a recording."""
        client = self.begin_cli("record", "--out", path, name="record")

        def recorded():
            listed = self.cli("--json", "log", "list", path)
            topics = json.loads(listed.out).get("topics", []) if listed.code == 0 else []
            return sum(t["messages"] for t in topics if "telemetry" in t["topic"]) > 5
        wait_until(lambda: client.running() and recorded(), 20, "telemetry is recorded")
        client.signal(signal.SIGINT)
        client.wait(30)
        rows = os.path.join(self.folder, "rows.csv")
        self.cli_ok("log", "export", path, "--topic", "telemetry", "--out", rows)
        with open(rows, encoding="utf-8") as file:
            names = file.readline().strip().split(",")
            self.assertGreater(len(file.readlines()), 5)
        return names


@unittest.skipIf(Unknown.TOOLS is None, "the tools are of another build")
class Ardito(Unknown, Rover):
    def test_an_unknown_rover_is_driven(self):
        self.start_all()
        self.says_the_same()
        self.refused("usage", "out of range", "drive", "2")
        self.refused("usage", "do not know what", "halt", "now")
        self.refused("unknown_name", "did you mean drive?", "drvie", "0.3")
        self.assertIn("--heading", self.cli_ok("drive", "--help").out)
        self.assertIn("would be accepted", self.cli_ok("--dry-run", "drive", "0.3").out)

        begin = self.truth.samples[-1][1]
        self.cli_ok("drive", "0.3", "--heading", "2deg", "--for", "6s")
        ahead, _, turned = motion.moved(begin, self.truth.samples[-1][1])
        self.assertGreater(ahead, 1.0)
        self.assertLess(turned, -0.1)
        self.assertEqual(self.status()["state"], IDLE)

        client = self.begin_endless("drive", "0.3", name="drive")
        self.wait_mode("Running", 60, client)
        begin = self.truth.samples[-1][1]
        wait_until(lambda: abs(motion.moved(begin, self.truth.samples[-1][1])[0]) > 0.1, 10, "the rover moves")
        client.signal(signal.SIGINT)
        client.wait(30)
        self.wait_state(IDLE)
        self.cli_ok("estop")
        self.cli_ok("solve")
        self.cli_ok("reset", "LF")
        self.cli_ok("param", "set", self.json_of("param", "get")["parameters"][0]["name"], "1")

        names = self.telemetry_of(os.path.join(self.folder, "drive.mcap"))
        self.assertIn("wheels[5].current_A", names)

    def test_a_page_drives_an_unknown_rover(self):
        self.start_all()
        gateway = Gateway(self)
        client = gateway.client(session="a session that only it knows")
        vehicle = client.wait_for(lambda m: m["type"] == "vehicle")
        self.assertEqual((vehicle["id"], vehicle["vehicle"]), ("ardito-1", "ardito"))
        known = json.loads(self.full("--json", "command", "list").out)["commands"]
        self.assertEqual(vehicle["commands"], [c for c in known if c["name"] != "estop"])
        self.assertEqual(vehicle["presentation"]["without_client"], "slows down, stands still and switches its motors off")
        telemetry = client.wait_for(lambda m: m["type"] == "telemetry")["telemetry"]
        full = json.loads(self.full("--json", "status").out)["telemetry"]
        self.assertEqual(shape(telemetry), shape(full))

        page = Beating(client)
        begin = self.truth.samples[-1][1]
        client.send(type="command", id=1, vehicle="ardito-1", command="drive", parameters={"speed": 2}, whole=True)
        self.assertEqual(page.ends(1, 20)["reason"]["name"], "out_of_range")
        client.send(type="command", id=2, vehicle="ardito-1", command="drive", parameters={"speed": 0.3}, whole=True)
        wait_until(lambda: ("drive", "executing") in page.phases(2), 40, "it drives")
        self.assertIn(("start", "completed"), page.phases(1) + page.phases(2))
        wait_until(lambda: motion.moved(begin, self.truth.samples[-1][1])[0] > 0.1, 30, "the rover moves")
        client.send(type="command", id=3, vehicle="ardito-1", command="stop")
        self.assertEqual(page.ends(3, 30)["phase"], "completed")
        self.wait_state(IDLE)
        page.stop()


@unittest.skipIf(Unknown.TOOLS is None, "the tools are of another build")
class Zebro(Unknown, Scenario):
    SPEED = "max"

    def test_an_unknown_walker_walks(self):
        self.start_all()
        self.says_the_same()
        self.refused("usage", "did you mean high?", "walk", "--speed", "hihg")
        self.refused("unknown_name", "did you mean walk?", "wlak")
        self.cli_ok("run", "-e", "start; stand; walk high --for 10s; stop")
        (span,) = self.walks()
        ahead, _, _ = motion.moved(motion.at(self.truth, span[0]), motion.at(self.truth, span[1]))
        self.assertGreater(ahead, 0.05)
        self.assert_resting(self.status())
        wrong = self.cli("run", "-e", "start; stnad")
        self.assertEqual(wrong.code, EXIT["unknown_name"], wrong)
        self.assertIn("did you mean stand?", wrong.err)


if __name__ == "__main__":
    unittest.main()
