"""The whole chain of D.I.A.N.A. Ardito: as rig.py, with a CAN bus over UDP in the place of a pseudo-terminal."""

import os

from programs import as_hardware, as_simulation, read_text, Truth, wait_until
from rig import BOOT_S, SIMULATOR, SOURCE, Scenario, edited


class Rover(Scenario):
    """config: changes of config/ardito.toml; without shared memory."""

    def setUp(self):
        super().setUp()
        self.port = f"udp://127.0.0.1:{20000 + self.domain}"

    def start_sim(self, *words, seed=1):
        truth = os.path.join(self.folder, f"truth-{len(self.programs)}.jsonl")
        sim = self.begin("lss-sim", [SIMULATOR, "ardito", "--dir", self.sim_folder, "--pace", "--plant", self.PLANT,
                                     "--can", self.port, "--seed", str(seed), "--truth", truth, *self.simulator_words, *words],
                         as_simulation if self.lockstep else as_hardware)
        wait_until(lambda: "ready" in sim.out() + sim.err(), BOOT_S, "the simulator is ready")
        if self.truth is not None:
            self.truth.stop()
        self.truth = Truth(truth, self.lockstep)
        return sim

    def write_config(self, name="ardito.toml", **changes):
        text = read_text(os.path.join(SOURCE, "config", "ardito.toml"))
        changes = {"shared_memory": "false", "path": f'"{self.port}"', **changes}
        path = os.path.join(self.folder, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(edited(text, changes))
        return path

    def wait_modules(self):
        """Waits until all nodes run, which `start` needs."""
        return self.wait_status(lambda s: s["telemetry"] and all(n["online"] for n in s["telemetry"]["nodes"]),
                                BOOT_S, "all nodes run")

    def wait_mode(self, mode, limit_s=60, client=None):
        return self.wait_status(lambda s: s["mode"] == mode, limit_s, f"mode {mode}", client)
