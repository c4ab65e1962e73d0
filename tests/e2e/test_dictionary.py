"""What the daemon says of its vehicle, beside the IDL and the other verbs of lss-cli."""

import json
import os
import re
import unittest

from hopper_rig import Hopper
from programs import read_text
from rig import SOURCE, Scenario
from rover_rig import Rover


def idl_fields(vehicle):
    """{struct: [member]} of the IDL of a vehicle; the key of a topic is no field of it."""
    text = re.sub(r"//[^\n]*", "", read_text(os.path.join(SOURCE, "idl", vehicle, f"{vehicle}.idl")))
    return {name: [re.search(r"(\w+)(?:\[\w+\])?$", line.strip()).group(1) for line in body.split(";")
                   if line.strip() and "@key" not in line]
            for name, body in re.findall(r"struct (\w+) *\{(.*?)\};", text, re.S)}


class Dictionary:
    IN_LOCKSTEP = True

    def json_of(self, *words):
        return json.loads(self.cli_ok("--json", *words).out)

    def check(self, vehicle, moving, parameter):
        self.start_all()
        said = self.json_of("dictionary")
        self.assertEqual(said["vehicle"], vehicle)
        self.assertEqual(said["schema_version"], 6, "of the dictionary, not of lss-cli's documents")
        self.assertEqual(said["states"], ["Idle", "Operational", "FatalError", "SolveErrors"])

        commands = {command["name"]: command for command in said["commands"]}
        known = self.json_of("command", "list")["commands"]
        self.assertEqual(sorted(commands), sorted(c["name"] for c in known))
        self.assertTrue(commands[moving]["leased"])
        self.assertEqual(commands["estop"]["access"], "anyone")
        self.assertIn(parameter, [p["name"] for p in commands[moving]["parameters"]])
        for command in said["commands"]:
            self.assertTrue(command["allowed"], command["name"])
            for p in command["parameters"]:
                self.assertLessEqual(p["min"], p["max"])

        fields = idl_fields(vehicle)
        telemetry = next(names for struct, names in fields.items() if struct.endswith("Telemetry"))
        self.assertEqual([f["name"] for f in said["telemetry"]["fields"]], telemetry)
        for field in said["telemetry"]["fields"]:
            if "fields" in field:
                self.assertIn([f["name"] for f in field["fields"]], fields.values())
                self.assertGreater(field["count"], 0)

        values = {p["name"]: p for p in self.json_of("param", "get")["parameters"]}
        self.assertEqual({p["name"]: (p["unit"], p["min"], p["max"]) for p in said["parameters"]},
                         {name: (p["unit"], p["min"], p["max"]) for name, p in values.items()})
        codes = self.json_of("codes")
        own = [c for c in codes["faults"] if c.pop("vehicle", vehicle) == vehicle]
        self.assertEqual([c for c in said["faults"] if c["text"] != "retired"], own)
        self.assertGreater(len(codes["reasons"]), 50)
        self.assertEqual([c["name"] for c in codes["states"]], said["states"])
        modes = [(c["number"], c["name"]) for c in codes["modes"] if c["vehicle"] == vehicle]
        self.assertEqual(modes, list(enumerate(said["modes"])))


class Zebro(Dictionary, Scenario):
    def test_says_what_lunar_zebro_is(self):
        self.check("zebro", "walk", "heading")
        refused = self.cli("codes", "fautls")
        self.assertEqual(refused.code, 4, refused)
        self.assertIn("faults, reasons, events", refused.err)


class Ardito(Dictionary, Rover):
    def test_says_what_ardito_is(self):
        self.check("ardito", "drive", "heading")


class Talaris(Dictionary, Hopper):
    def test_says_what_talaris_is(self):
        self.check("talaris", "valve", "time")


if __name__ == "__main__":
    unittest.main()
