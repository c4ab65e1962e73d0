"""The whole chain of TALARIS: as rig.py, with two sensors on pseudo-terminals and a CAN bus over UDP."""

from rig import OnCan


class Hopper(OnCan):
    """Calibrated for 5 s only."""

    NAME = "talaris"

    def write_config(self, name=None, **changes):
        return super().write_config(name, **{"calibration_s": "5.0", **changes})

    def wait_phase(self, phase, limit_s=60, client=None):
        return self.wait_status(lambda s: s["telemetry"] and s["telemetry"]["phase"] == phase, limit_s, f"phase {phase}", client)

    def true_height(self):
        first, last = self.truth.samples[0][1], self.truth.samples[-1][1]
        return last["position_m"][0] - first["position_m"][0]

    def all_shut(self):
        return self.truth.samples[-1][1]["valves"] == 0
