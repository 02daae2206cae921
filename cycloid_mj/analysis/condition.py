"""Under what a run's figures hold, in data and in words: its load and its crank speed."""

from dataclasses import dataclass

from cycloid_mj.design import Design
from cycloid_mj.design.units import RPM


@dataclass(frozen=True)
class Condition:
    """Load torque on the output and crank speed that a design asks for; the speed is signed."""

    load_nm: float
    speed_rpm: float

    def __str__(self) -> str:
        """Give the condition in words, such as "36.68 N m, 1640 rpm"."""
        return f"{load_words(self.load_nm)}, {self.speed_rpm:g} rpm"


def condition(design: Design) -> Condition:
    """Give the condition that a design is run under."""
    # the speed is that of the design file, without the rounding of the way to rad/s and back
    return Condition(design.load.torque, round(RPM.from_si(design.drive.speed), 9))


def load_words(load: float) -> str:
    """Name a load [N m]."""
    return f"{load:g} N m" if load else "no load"
