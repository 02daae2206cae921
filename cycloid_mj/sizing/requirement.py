"""Requirements of a new drive."""

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
"""Range of each required size, lengths as diameters: there are no single-stage drives beyond."""

PIN_SIZE = 0.06
"""Typical diameter of a ring pin relative to that of a drive, at which a fit is represented by one clearance."""

LARGEST_PAIR = 0.6
"""Largest diameter of a pair, that of the cam, relative to that of a drive, at which a fit must be tabulated."""

MOST_RATIOS = 7
"""Number of ratios tried in a range, evenly spaced."""


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
    """Return the only material of the library with a word in its name, such as 16MnCr5; else the text itself."""
    matching = [name for name in MATERIALS if material.lower() in name.lower().split()]
    return matching[0] if len(matching) == 1 and material not in MATERIALS else material


@dataclass(frozen=True)
class Requirement:
    """Requirement of a drive, in SI except for the life.

    Attributes
    ----------
    ratio
        Crank turns per output turn.
    diameter
        Outer diameter [m].
    torque
        Output torque over the life [N m]; twice this is required as a peak.
    life
        Life at that torque [h].
    speed
        Crank speed [rad/s].
    process
        Manufacturing process.
    discs
        Number of discs; 0: one, or two where one is not enough.
    length
        Largest overall length [m]; inf: any.
    backlash
        Largest backlash [arcmin]; inf: any.
    material
        Material of disc and housing, by its name in the library; empty: the default of the process.
    clearance
        Clearance of each pair of parts [m]; 0: the default of the process, or less where the backlash requires it.
    fit
        Fit of each pair of parts instead, such as H7/g6, at its size (ISO 286-1); empty: none.
    custom
        Whether sizes are free instead of those of pins and bearings in stock.
    tightened
        Whether the clearance was reduced for the backlash, and may be reduced further.
    covered
        Whether the covers must not be larger than the ring, with their screws in its wall.
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
        """Check the ranges of all values.

        Raises
        ------
        UsageError
            A value is out of range, or not a whole number.
        """
        for what, number in (("ratio", self.ratio), ("number of discs", self.discs)):
            if number != round(number):
                raise UsageError(
                    f"the {what} is {number}; it must be whole, such as {math.floor(number)} or {math.ceil(number)}"
                )
        if not LEAST_RATIO <= self.ratio <= MOST_RATIO:
            raise UsageError(f"the ratio is {self.ratio}; a single stage allows {LEAST_RATIO} to {MOST_RATIO}")
        if not 0 <= self.discs <= MOST_DISCS:
            raise UsageError(f"the number of discs is {self.discs}; allowed: 1 to {MOST_DISCS}")
        for what, value, unit, minimum, most in self._sizes():
            if not minimum <= value <= most:
                raise UsageError(f"the {what} is {value:.10g} {unit}; allowed: {minimum:g} to {most:g} {unit}")
        if self.material and self.material not in MATERIALS:
            raise UsageError(f"unknown material {self.material!r}; available: {', '.join(MATERIALS)}")
        if self.fit:
            self._check_fit()

    def _check_fit(self) -> None:
        """Raise UsageError unless the fit is a known one with clearance, and no clearance is set as well."""
        if self.clearance:
            raise UsageError(
                f"both a fit, {self.fit}, and a clearance, {1e6 * self.clearance:g} um, are set: remove one of them"
            )
        try:
            tightest, _ = clearances(self.fit, LARGEST_PAIR * self.diameter)
        except ValueError as error:
            raise UsageError(f"the fit is {self.fit!r}: {error}") from None
        if tightest < 0.0:
            raise UsageError(f"the fit {self.fit} jams, as its parts must move: use a clearance fit such as H7/g6")

    def _sizes(self) -> Iterator[tuple[str, float, str, float, float]]:
        """Yield name, value, unit and range of each size."""
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
        """Material of disc and housing."""
        return self.material or PROCESSES[self.process].material

    @property
    def usual_clearance(self) -> float:
        """Required clearance, or that of the process, or that of the fit at the size of a ring pin [m]."""
        return self.clearance_at(PIN_SIZE * self.diameter)

    def clearance_at(self, size: float) -> float:
        """Compute the clearance of a pair [m], normal to its surfaces, at its diameter [m]: of a fit the mean."""
        if self.fit:
            return round(0.25 * sum(clearances(self.fit, size)), 9)
        return self.clearance or PROCESSES[self.process].clearance
