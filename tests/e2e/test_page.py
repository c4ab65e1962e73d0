"""A person at the pilot's page, in headless Chromium: walks, drives and flies, and stops each."""

import json
import os
import sys

import hopper_rig
import rover_rig
from browser import CHROMIUM, NODE, PLAYWRIGHT, needs_browser
from programs import run
from rig import SOURCE, Scenario
from test_ground import Beating, Gateway

OTHERS = 9  # additional clients that receive all messages


@needs_browser
class Page:
    IN_LOCKSTEP = True

    def visit(self, vehicle, limit_s=150):
        self.start_all()
        gateway = Gateway(self, "--lease-ms", "10000")  # a browser on a busy machine is slow
        others = [Beating(gateway.client()) for _ in range(OTHERS)]
        shots = os.environ.get("LSS_E2E_SHOTS")
        words = [NODE, os.path.join(SOURCE, "tests/e2e/page.mjs"), vehicle, f"http://127.0.0.1:{gateway.port}/"]
        result = run(words + ([shots] if shots else []), self.environment(CHROMIUM=CHROMIUM, PLAYWRIGHT=PLAYWRIGHT,
                                                                          HOME=self.folder), limit_s)
        print(result.out, file=sys.stderr)
        self.assertEqual(result.code, 0, result.err)
        counters = others[0].counters()
        print(f"gateway: {counters}", file=sys.stderr)
        self.assertEqual([counters[c] for c in ("refused", "bad_messages", "too_fast")], [0, 0, 0])
        self.assertGreaterEqual(counters["stops"], 20)
        budget, = json.loads(self.cli_ok("--json", "param", "get", "solve.budget_s").out)["parameters"]
        self.assertEqual((budget["value"], budget["configured"], budget["saved"]), (10, 10, 12), "set, saved and reset on the page")


class Zebro(Page, Scenario):
    def test_a_person_walks_zebro_and_stops_it(self):
        self.visit("zebro")


class Ardito(Page, rover_rig.Rover):
    def test_a_person_drives_ardito_and_stops_it(self):
        self.visit("ardito")


class Talaris(Page, hopper_rig.Hopper):
    def test_a_person_flies_the_hop_and_stops_talaris(self):
        self.visit("talaris")
