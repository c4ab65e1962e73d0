"""The whole chain of D.I.A.N.A. Ardito: as rig.py, with a CAN bus over UDP in the place of a pseudo-terminal."""

from rig import OnCan


class Rover(OnCan):
    NAME, MODULES = "ardito", "nodes"

    def vehicle_words(self):
        return ["--plant", self.PLANT, *super().vehicle_words()]
