"""The springs of a structure by finite elements of its parts: what statics has behind the contacts of a printed drive.

Finite elements have the give of the contacts in that of the parts, and statics has it by Hertz: of the discs, on which
all contacts are, the springs hold what is left.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.result import Table
from cycloid_mj.design import Design
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.springs import turn_evenly
from cycloid_mj.statics.structure import TWISTING, twisting_compliance, twisting_stiffness, wind_up
from cycloid_mj.statics.windup import windups
from cycloid_mj.stress.figures import wind_up_by_part
from cycloid_mj.stress.mounts import Mounts, printed_of

HOLDS = {
    "gear": "carrier",
    "output": "carrier",
    "shaft": "shaft",
    "ring": "housing",
    "pin": "housing",
    "bearing_seats": "housing",
    "studs": "carrier",
    "far_plate": "carrier",
    "crank": "shaft",
}
"""Kind of part -> the spring that holds its give."""


@dataclass(frozen=True)
class PartSprings:
    """What the parts of a reducer give, and the design whose springs say so.

    Attributes
    ----------
    design
        With `structure` springs, and all of `TWISTING` given.
    given
        Part -> turn of the output per torque [rad/(N m)], with the give of its contacts in it.
    contacts
        Turn per torque by the contacts of statics, which the springs leave out [rad/(N m)].
    limits
        Part -> turn per torque, once for each limit of the modulus that mounts state; empty where they state none.
    """

    design: Design
    given: Mapping[str, float]
    contacts: float
    limits: tuple[Mapping[str, float], ...] = ()

    @property
    def stiffness(self) -> float:
        """Torsional stiffness at the output by all parts and their contacts [N m/rad]."""
        return 1.0 / sum(self.given.values())

    @property
    def interval(self) -> tuple[float, float] | None:
        """Least and largest stiffness within the limits of the modulus [N m/rad]; None where none are stated."""
        ends = [1.0 / sum(one.values()) for one in self.limits]
        return (min(ends), max(ends)) if ends else None

    @property
    def text(self) -> str:
        """The stiffness with its interval, in words."""
        between = " ({:.4g} to {:.4g} by the modulus)".format(*self.interval) if self.interval else ""
        return f"{self.stiffness:.4g} N m/rad{between}"

    def table(self) -> Table:
        """Tabulate what each part gives, and the spring that holds it."""
        rows = [(part, 1e3 * one, f"springs.{HOLDS[_kind(part)]}_nm_per_rad") for part, one in self.given.items()]
        rows.append(("of that, the contacts", 1e3 * self.contacts, "left to statics"))
        return Table(
            f"{self.design.name}: {self.text} by its parts",
            ("part", "turn of the output per torque [mrad/(N m)]", "held by"),
            tuple(rows),
        )

    def as_json(self) -> dict[str, Any]:
        """Convert all of it to JSON values."""
        springs = self.design.springs
        return {
            "design": self.design.name,
            "stiffness_nm_per_rad": self.stiffness,
            "stiffness_interval_nm_per_rad": list(self.interval) if self.interval else None,
            "parts_rad_per_nm": dict(self.given),
            "contacts_rad_per_nm": self.contacts,
            "springs_nm_per_rad": {part: getattr(springs, part) for part in TWISTING},
        }


def part_springs(reducer: Reducer, mounts: Mounts | None = None) -> PartSprings:
    """Compute the springs of a reducer by finite elements of its parts; errors as `stress.figures.wind_up_by_part`.

    Carrier and shaft twist beside, as their shapes say. Mounts are what a drawing tells of the seats of output pins and
    crank; the limits of their modulus take a run and a set of finite elements each.
    """
    parts = wind_up_by_part(reducer, mounts)
    moduli = mounts.material.modulus if mounts and mounts.material else ()
    limits = tuple(wind_up_by_part(printed_of(reducer, modulus), mounts) for modulus in moduli)
    still = reducer.but(structure="springs", springs=dict.fromkeys(TWISTING, 0.0))
    series = [sum(one.series(still).values()) for one in windups(still, turn_evenly(still), still.design.rated_torque)]
    contacts = float(np.mean(series)) - wind_up(still)
    twist, stiffness = twisting_compliance(still), twisting_stiffness(still)
    gives = {"carrier": twist["carrier"], "shaft": twist["shaft"], "housing": 0.0}
    for part, one in parts.items():
        gives[HOLDS[_kind(part)]] += one
    gives["carrier"] = max(gives["carrier"] - contacts, twist["carrier"])
    springs = {part: stiffness[part] * twist[part] / gives[part] for part in TWISTING}
    design = still.design.but(name=f"{still.design.name}-springs"[:64], springs=springs)
    return PartSprings(design, parts, contacts, limits)


def _kind(part: str) -> str:
    return part if part in HOLDS else names.family(part)
