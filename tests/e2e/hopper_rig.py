"""The whole chain of TALARIS: as rig.py, with two sensors on pseudo-terminals and a CAN bus over UDP."""

import os

from programs import as_hardware, as_simulation, read_text, Truth, wait_until
from rig import BOOT_S, SIMULATOR, SOURCE, Scenario, edited


class Hopper(Scenario):
    """config: changes of config/talaris.toml; without shared memory, calibrated for 5 s only."""

    def setUp(self):
        super().setUp()
        self.port = f"udp://127.0.0.1:{20000 + self.domain}"

    def start_sim(self, *words, seed=1):
        truth = os.path.join(self.folder, f"truth-{len(self.programs)}.jsonl")
        sim = self.begin("lss-sim", [SIMULATOR, "talaris", "--dir", self.sim_folder, "--pace",
                                     "--can", self.port, "--seed", str(seed), "--truth", truth, *self.simulator_words, *words],
                         as_simulation if self.lockstep else as_hardware)
        wait_until(lambda: "ready" in sim.out() + sim.err(), BOOT_S, "the simulator is ready")
        if self.truth is not None:
            self.truth.stop()
        self.truth = Truth(truth, self.lockstep)
        return sim

    def write_config(self, name="talaris.toml", **changes):
        text = read_text(os.path.join(SOURCE, "config", "talaris.toml")).replace(
            'path = "udp://127.0.0.1:20000"', f'path = "{self.port}"')
        changes = {"shared_memory": "false", "calibration_s": "5.0", **changes}
        path = os.path.join(self.folder, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(edited(text, changes))
        return path

    def wait_modules(self):
        """Waits until all modules have answered, which `start` needs."""
        return self.wait_status(
            lambda s: s["telemetry"] and all(m["online"] is not False for m in s["telemetry"]["modules"]), BOOT_S,
            "all modules are heard")

    def wait_mode(self, mode, limit_s=60, client=None):
        return self.wait_status(lambda s: s["mode"] == mode, limit_s, f"mode {mode}", client)

    def wait_phase(self, phase, limit_s=60, client=None):
        return self.wait_status(lambda s: s["telemetry"] and s["telemetry"]["phase"] == phase, limit_s, f"phase {phase}", client)

    def true_height(self):
        first, last = self.truth.samples[0][1], self.truth.samples[-1][1]
        return last["position_m"][0] - first["position_m"][0]

    def all_shut(self):
        return self.truth.samples[-1][1]["valves"] == 0
