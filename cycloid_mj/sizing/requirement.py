"""What is asked of a new drive."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Self

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.units import MICROMETRES, MILLIMETRES, RPM
from cycloid_mj.design.fits import clearances
from cycloid_mj.design.materials import MATERIALS
from cycloid_mj.sizing.process import PROCESSES, Process

LEAST_RATIO, MOST_RATIO = 3, 150
MOST_DISCS = 4

DIAMETERS_MM, TORQUES_NM = (5.0, 3000.0), (1e-4, 1e6)
LIVES_H, SPEEDS_RPM = (1.0, 1e6), (0.1, 50e3)
BACKLASHES_ARCMIN, CLEARANCES_UM = (0.01, 6000.0), (0.1, 1000.0)
"""Least and most of each size that is asked for, lengths as diameters: beyond, no drive of one stage is made."""

PIN_SIZE = 0.06
"""Diameter of a ring pin over that of a drive, about: where one clearance stands for those of a fit."""

LARGEST_PAIR = 0.6
"""Diameter of the largest pair, that of the cam, over that of a drive, at most: a fit is to be known there."""

MOST_RATIOS = 7
"""Of a range of ratios: so many are tried, evenly spaced."""


def required(
    *,
    ratio: int,
    diameter_mm: float,
    torque_nm: float,
    life_h: float = 6000.0,
    speed_rpm: float = 1500.0,
    process: Process = "steel",
    discs: int = 1,
    length_mm: float | None = None,
    backlash_arcmin: float | None = None,
    material: str = "",
    clearance_um: float | None = None,
    fit: str = "",
    custom: bool = False,
) -> "Requirement":
    """Return a requirement in the units of the command line; see `Requirement`."""
    return Requirement(
        ratio=ratio,
        diameter=1e-3 * diameter_mm,
        torque=torque_nm,
        life=life_h,
        speed=speed_rpm * RPM,
        process=process,
        discs=discs,
        length=math.inf if length_mm is None else 1e-3 * length_mm,
        backlash=math.inf if backlash_arcmin is None else backlash_arcmin,
        material=_named(material),
        clearance=0.0 if clearance_um is None else 1e-6 * clearance_um,
        fit=fit,
        custom=custom,
    )


def _named(material: str) -> str:
    """Return the only material of the library that has a word in its name, as 16MnCr5; what is none stays as it is."""
    matching = [name for name in MATERIALS if material.lower() in name.lower().split()]
    return matching[0] if len(matching) == 1 and material not in MATERIALS else material


@dataclass(frozen=True)
class Requirement:
    """What a drive is to do, in SI but for the life.

    Attributes
    ----------
    ratio
        Turns of the crank for one of the output.
    diameter
        Outside [m].
    torque
        On the output [N m], for all of the life; twice as much is to be held once.
    life
        Hours at that torque.
    speed
        Of the crank [rad/s].
    process
        How it is made.
    discs
        On the crank; 0: one, or two where one is too few.
    length
        Most that it is to be long over all [m]; inf: any.
    backlash
        Most that it is to have [arcmin]; inf: any.
    material
        Of gear and housing, by its name in the library; empty: the usual one of the process.
    clearance
        Of each pair of parts [m]; 0: the usual one of the process, or less where the backlash asks for it.
    fit
        Of each pair of parts instead, such as H7/g6, at its own size (ISO 286-1); empty: none.
    custom
        Whether sizes are free, and not those of pins and bearings in stock.
    tightened
        Whether the clearance was lowered for the backlash's sake, and may be lowered more.
    covered
        Whether the covers are to be no larger than the ring: their screws have room in its wall.
    """

    ratio: int
    diameter: float
    torque: float
    life: float = 6000.0
    speed: float = 1500.0 * RPM
    process: Process = "steel"
    discs: int = 1
    length: float = math.inf
    backlash: float = math.inf
    material: str = ""
    clearance: float = 0.0
    fit: str = ""
    custom: bool = False
    tightened: bool = False
    covered: bool = False

    def __post_init__(self) -> None:
        """Refuse what no drive can be.

        Raises
        ------
        UsageError
            A value is out of its range, or no whole number.
        """
        for what, number in (("ratio", self.ratio), ("number of discs", self.discs)):
            if number != round(number):
                raise UsageError(f"the {what} is {number}; give {math.floor(number)} or {math.ceil(number)}")
        if not LEAST_RATIO <= self.ratio <= MOST_RATIO:
            raise UsageError(f"the ratio is {self.ratio}; one stage of pins has from {LEAST_RATIO} to {MOST_RATIO}")
        if not 0 <= self.discs <= MOST_DISCS:
            raise UsageError(f"{self.discs} discs are asked for; a crank has from 1 to {MOST_DISCS}")
        for what, value, unit, least, most in self._sizes():
            if not least <= value <= most:
                raise UsageError(f"the {what} is {value:.10g} {unit}; it is to be from {least:g} to {most:g} {unit}")
        if self.material and self.material not in MATERIALS:
            raise UsageError(f"there is no material {self.material!r}; it is one of {', '.join(MATERIALS)}")
        if self.fit:
            self._check_fit()

    def _check_fit(self) -> None:
        if self.clearance:
            raise UsageError(
                f"a fit, {self.fit}, and a clearance of {1e6 * self.clearance:g} um: leave one of them out"
            )
        try:
            tightest, _ = clearances(self.fit, LARGEST_PAIR * self.diameter)
        except ValueError as error:
            raise UsageError(f"the fit is {self.fit!r}: {error}") from None
        if tightest < 0.0:
            raise UsageError(f"the fit {self.fit} jams: its parts move in each other; take one such as H7/g6")

    def _sizes(self) -> Iterator[tuple[str, float, str, float, float]]:
        """Yield what has a unit: its name, value and unit, and the least and the most that it may be."""
        yield "diameter", MILLIMETRES * self.diameter, "mm", *DIAMETERS_MM
        yield "torque", self.torque, "N m", *TORQUES_NM
        yield "life", self.life, "h", *LIVES_H
        yield "speed", self.speed / RPM, "rpm", *SPEEDS_RPM
        if self.length != math.inf:
            yield "length", MILLIMETRES * self.length, "mm", *DIAMETERS_MM
        if self.backlash != math.inf:
            yield "backlash", self.backlash, "arcmin", *BACKLASHES_ARCMIN
        if self.clearance:
            yield "clearance", MICROMETRES * self.clearance, "um", *CLEARANCES_UM

    def but(self, **changes: Any) -> Self:
        """Return the requirement with other values."""
        return replace(self, **changes)

    @property
    def made_of(self) -> str:
        """Material of gear and housing."""
        return self.material or PROCESSES[self.process].material

    @property
    def usual_clearance(self) -> float:
        """Clearance that is asked for, or that of the process, or that of the fit at the size of a ring pin [m]."""
        return self.clearance_at(PIN_SIZE * self.diameter)

    def clearance_at(self, size: float) -> float:
        """Compute the clearance of a pair [m], normal to its surfaces, at its diameter [m]: of a fit the mean."""
        if self.fit:
            return round(0.25 * sum(clearances(self.fit, size)), 9)
        return self.clearance or PROCESSES[self.process].clearance
