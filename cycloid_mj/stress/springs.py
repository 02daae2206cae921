"""Springs of a structure by finite elements of its parts, for the statics of printed drives.

The compliance by finite elements includes that of the contacts, which statics computes by Hertz. The springs have the
remainder, which is subtracted from that of the discs, on which all contacts are.
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
from cycloid_mj.statics.windup import solve_windups
from cycloid_mj.stress.figures import wind_up_by_part
from cycloid_mj.stress.mounts import Mounts, with_modulus

SPRING_OF_PART = {
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
"""Kind of part -> spring that includes its compliance."""


@dataclass(frozen=True)
class PartSprings:
    """Compliance of the parts of a reducer, and the design with these springs.

    Attributes
    ----------
    design
        Design with `structure` springs, and all of `TWISTING` set.
    compliance
        Rotation of the output per torque [rad/(N m)] by part, including its contacts.
    contacts
        Rotation per torque by the contacts of statics, which the springs exclude [rad/(N m)].
    limits
        Compliance by part for each limit of the modulus that mounts state; empty without limits.
    """

    design: Design
    compliance: Mapping[str, float]
    contacts: float
    limits: tuple[Mapping[str, float], ...] = ()

    @property
    def stiffness(self) -> float:
        """Torsional stiffness at the output by all parts and their contacts [N m/rad]."""
        return 1.0 / sum(self.compliance.values())

    @property
    def interval(self) -> tuple[float, float] | None:
        """Smallest and largest stiffness within the limits of the modulus [N m/rad]; None without limits."""
        stiffness_limits = [1.0 / sum(compliances.values()) for compliances in self.limits]
        return (min(stiffness_limits), max(stiffness_limits)) if stiffness_limits else None

    @property
    def text(self) -> str:
        """The stiffness with its interval, in words."""
        between = " ({:.4g} to {:.4g} by the modulus)".format(*self.interval) if self.interval else ""
        return f"{self.stiffness:.4g} N m/rad{between}"

    def table(self) -> Table:
        """Return a table with the compliance [mrad/(N m)] of each part and the key of its spring in the design file."""
        rows = [
            (part, 1e3 * compliance, f"springs.{SPRING_OF_PART[_kind(part)]}_nm_per_rad")
            for part, compliance in self.compliance.items()
        ]
        rows.append(("of that, the contacts", 1e3 * self.contacts, "left to statics"))
        return Table(
            f"{self.design.name}: {self.text} by its parts",
            ("part", "turn of the output per torque [mrad/(N m)]", "spring"),
            tuple(rows),
        )

    def as_json(self) -> dict[str, Any]:
        """Convert torsional compliances and spring stiffnesses of the parts to JSON values; keys end in their units.

        ``parts_rad_per_nm`` has the compliance of each part, ``contacts_rad_per_nm`` the share of the contacts in it.
        ``springs_nm_per_rad`` has the springs of the design (``springs.*``) by their keys.
        """
        springs = self.design.springs
        return {
            "design": self.design.name,
            "stiffness_nm_per_rad": self.stiffness,
            "stiffness_interval_nm_per_rad": list(self.interval) if self.interval else None,
            "parts_rad_per_nm": dict(self.compliance),
            "contacts_rad_per_nm": self.contacts,
            "springs_nm_per_rad": {part: getattr(springs, part) for part in TWISTING},
        }


def part_springs(reducer: Reducer, mounts: Mounts | None = None) -> PartSprings:
    """Compute the torsional compliance of each part by finite elements, and a design whose springs replace the parts.

    The result has the compliances [rad/(N m)] and this design: its table ``springs`` has the stiffness of carrier,
    shaft and housing. A spring has the sum of the compliances of its parts (`SPRING_OF_PART`); carrier and shaft also
    have the torsion that `statics.structure` computes. The compliance of the contacts is subtracted from that of the
    carrier, since statics includes it. `mounts` are the seats of output pins and crank from a drawing; each limit of
    their modulus needs another simulation.

    Raises
    ------
    CycloidError
        The run failed, a part does not mesh, a package of the extra ``fem`` is missing, or the mounts do not fit the
        design.
    """
    part_compliances = wind_up_by_part(reducer, mounts)
    moduli = mounts.material.modulus if mounts and mounts.material else ()
    compliance_limits = tuple(wind_up_by_part(with_modulus(reducer, modulus), mounts) for modulus in moduli)
    reducer_without_springs = reducer.but(structure="springs", springs=dict.fromkeys(TWISTING, 0.0))
    compliances = [
        sum(part_compliance.series(reducer_without_springs).values())
        for part_compliance in solve_windups(
            reducer_without_springs, turn_evenly(reducer_without_springs), reducer_without_springs.design.rated_torque
        )
    ]
    contact_compliance = float(np.mean(compliances)) - wind_up(reducer_without_springs)
    torsion, stiffness = twisting_compliance(reducer_without_springs), twisting_stiffness(reducer_without_springs)
    compliance = {"carrier": torsion["carrier"], "shaft": torsion["shaft"], "housing": 0.0}
    for part, part_compliance in part_compliances.items():
        compliance[SPRING_OF_PART[_kind(part)]] += part_compliance
    compliance["carrier"] = max(compliance["carrier"] - contact_compliance, torsion["carrier"])
    springs = {part: stiffness[part] * torsion[part] / compliance[part] for part in TWISTING}
    design = reducer_without_springs.design.but(
        name=f"{reducer_without_springs.design.name}-springs"[:64], springs=springs
    )
    return PartSprings(design, part_compliances, contact_compliance, compliance_limits)


def _kind(part: str) -> str:
    return part if part in SPRING_OF_PART else names.family(part)
