"""Requirements of a new drive."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, Self

from cycloid_mj.base.arguments import require_choice
from cycloid_mj.base.array import significant
from cycloid_mj.base.errors import DesignError, UsageError
from cycloid_mj.base.units import RPM
from cycloid_mj.design import PRESETS, override
from cycloid_mj.design.fits import clearances
from cycloid_mj.design.layouts import Layout
from cycloid_mj.design.materials import MATERIALS
from cycloid_mj.design.processes import PROCESSES, Process
from cycloid_mj.life.duty import PEAK_FACTOR, Duty, DutyPoint, constant_duty, read_duty
from cycloid_mj.life.heat import COOLING
from cycloid_mj.parts.export.motors import MotorName

LEAST_RATIO, MOST_RATIO = 3, 150
MAX_DISCS = 4
"""Range of ratios, and largest number of discs, that a requirement may state."""


@dataclass(frozen=True)
class Quantity:
    """A required value: its name, its flag, its unit with the value in SI, and its range in this unit."""

    name: str
    flag: str
    unit: str
    scale: float
    low: float
    high: float


QUANTITIES = {
    "diameter": Quantity("diameter", "--diameter-mm", "mm", 1e-3, 5.0, 3000.0),
    "torque": Quantity("torque", "--torque-nm", "N m", 1.0, 1e-4, 1e6),
    "life": Quantity("life", "--life-h", "h", 1.0, 1.0, 1e6),
    "speed": Quantity("speed", "--speed-rpm", "rpm", RPM, 0.1, 50e3),
    "length": Quantity("length", "--length-mm", "mm", 1e-3, 5.0, 3000.0),
    "backlash": Quantity("backlash", "--backlash-arcmin", "arcmin", 1.0, 0.01, 6000.0),
    "duty_share": Quantity("share of the time", "--duty", "of 1", 1.0, 0.001, 1.0),
    "film": Quantity("heat transfer coefficient", "--cooling", "W/(m2 K)", 1.0, 1.0, 1000.0),
    "ambient": Quantity("ambient temperature", "--ambient-c", "°C", 1.0, -50.0, 90.0),
    "clearance": Quantity("clearance", "--clearance-um", "um", 1e-6, 0.1, 1000.0),
}
"""Required values by their attribute of a requirement, which has no single-stage drives beyond their ranges."""

UNSET = {"length": math.inf, "backlash": math.inf, "clearance": 0.0}
"""Values of a requirement that does not limit them."""

PIN_SIZE = 0.06
"""Typical diameter of a ring pin relative to that of a drive, at which a fit is represented by one clearance
(heuristic)."""

LARGEST_PAIR = 0.6
"""Largest diameter of a pair, that of the cam, relative to that of a drive, at which a fit must be tabulated
(heuristic)."""

FLAGS_BY_KEY = {
    "ring.teeth": "--ratio",
    "gear.discs": "--discs",
    "drive.torque_nm": "--torque-nm",
    "drive.speed_rpm": "--speed-rpm or --output-rpm",
    "service.life_h": "--life-h",
    "service.duty_share": "--duty",
    "service.film_coefficient_w_m2_k": "--cooling",
    "service.ambient_temperature_c": "--ambient-c",
}
"""Keys of the design file that a requirement determines -> their flags."""

FINER = 10.0**-0.1
"""Step of the clearances that a backlash may require (R10, ISO 3)."""


def make_requirement(
    *,
    ratio: int,
    diameter_mm: float,
    torque_nm: float,
    life_h: float | None = None,
    speed_rpm: float | None = None,
    output_rpm: float | None = None,
    process: Process = "steel",
    discs: int = 1,
    length_mm: float | None = None,
    backlash_arcmin: float | None = None,
    material: str = "",
    clearance_um: float | None = None,
    fit: str = "",
    custom: bool = False,
    duty: str | float | None = None,
    cooling: str | float = "still",
    ambient_c: float = 20.0,
    motor: MotorName = "auto",
    changes: tuple[str, ...] = (),
    kind: "type[Requirement] | None" = None,
) -> "Requirement":
    """Return a requirement for a drive from values in the units of the command line.

    Diameter and length are the largest outer dimensions. `speed_rpm` is that of the crank. Life, speed and duty default
    to those of `process`, the manufacturing process. ``clearance_um`` is the clearance of each pair of parts;
    alternatively, `fit` is an ISO 286 fit such as "H7/g6". `custom` allows sizes that are not in stock. `duty` is the
    share of the time under load, or the path of a CSV file with a duty cycle. `cooling` is one of `COOLING`, or a heat
    transfer coefficient [W/(m2 K)]. `changes` are settings of the design, ``table.key=value``. `kind` is the class of
    the result, by default `Requirement`. Raises UsageError if two values exclude each other, one is out of range, or
    the design does not accept a change.
    """
    if speed_rpm is not None and output_rpm is not None:
        raise UsageError(
            "both the crank speed and the output speed are set, but each determines the other: remove one of them"
        )
    require_choice("process", process, PROCESSES)
    limits = PROCESSES[process]
    speed = output_rpm * ratio if output_rpm is not None else limits.speed_rpm if speed_rpm is None else speed_rpm
    share, points = _parse_duty(duty, limits.duty_share)
    requirement = (kind or Requirement)(
        ratio=ratio,
        diameter=1e-3 * diameter_mm,
        torque=torque_nm,
        life=limits.life_h if life_h is None else life_h,
        speed=max((speed for _, speed, _ in points), default=speed * RPM),
        process=process,
        discs=discs,
        length=math.inf if length_mm is None else 1e-3 * length_mm,
        backlash=math.inf if backlash_arcmin is None else backlash_arcmin,
        material=_library_material(material),
        clearance=0.0 if clearance_um is None else 1e-6 * clearance_um,
        fit=fit,
        custom=custom,
        duty=points,
        duty_share=share,
        film=_film_coefficient(cooling),
        ambient=ambient_c,
        motor=motor,
        changes=changes,
    )
    _check_changes(requirement)
    return requirement


def _check_changes(requirement: "Requirement") -> None:
    """Raise UsageError if a change names an unknown key, a value that no design accepts, or a key with its own flag.

    Without this check, the search would discard all candidates and report that none of them fits, or overwrite the
    value.
    """
    for key in (change.partition("=")[0].strip() for change in requirement.changes):
        if key in FLAGS_BY_KEY:
            raise UsageError(
                f"--set {key} contradicts the requirement, which determines this value: use {FLAGS_BY_KEY[key]}"
            )
    counts = {"ring": {"teeth": requirement.ratio + 1}, "gear": {"discs": requirement.discs or 1}}
    design = PRESETS["rv80e"] if requirement.LAYOUT == "rv" else PRESETS["pin"].but(**counts)
    try:
        override(design, requirement.changes)
    except DesignError as error:
        raise UsageError(error.message, error.details) from error


def _parse_duty(duty: str | float | None, usual_share: float) -> tuple[float, tuple[tuple[float, float, float], ...]]:
    """Return the share of the time under load [1], and the points of a duty cycle.

    Parameters
    ----------
    duty
        The share, the path of a CSV file with a duty cycle, or None for the usual share.
    usual_share
        The usual share [1].

    Returns
    -------
    tuple
        The share, which is 1 for a file; and for each point of the file the torque relative to the largest torque, the
        crank speed [rad/s] and the share of the time. Without a file, there are no points.
    """
    if duty is None:
        return usual_share, ()
    try:
        return float(duty), ()
    except ValueError:
        points = read_duty(Path(str(duty))).points
    largest = max(point.torque for point in points if point.speed)
    return 1.0, tuple((point.torque / largest, point.speed, point.share) for point in points)


def _film_coefficient(cooling: str | float) -> float:
    """Return the heat transfer coefficient [W/(m2 K)] for `cooling`: a key of `COOLING`, or the coefficient itself."""
    if cooling in COOLING:
        return COOLING[str(cooling)]
    try:
        return float(cooling)
    except ValueError:
        raise UsageError(
            f"unknown cooling {cooling!r}: choose {', '.join(COOLING)}, or a heat transfer coefficient in W/(m2 K)"
        ) from None


def _library_material(material: str) -> str:
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
    duty, duty_share
        Points of a duty cycle, (torque over the largest, speed [rad/s], share), or the share of the time under load.
    film, ambient
        Heat transfer coefficient of the housing [W/(m2 K)], and temperature around it [°C].
    motor
        Motor whose shaft and screws the crank and the covers must fit; auto: any.
    changes
        Settings of the design, ``table.key=value``, that hold for every candidate.
    tightened
        Whether the clearance was reduced for the backlash.
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
    duty: tuple[tuple[float, float, float], ...] = ()
    duty_share: float = 1.0
    film: float = 12.0
    ambient: float = 20.0
    motor: MotorName = "auto"
    changes: tuple[str, ...] = ()

    LAYOUT: ClassVar[Layout] = "central"
    RATIOS: ClassVar[tuple[int, int]] = (LEAST_RATIO, MOST_RATIO)
    STAGES: ClassVar[str] = "a single stage"

    def __post_init__(self) -> None:
        """Raise UsageError if a value of the requirement is out of range, or a count is not a whole number.

        Raises
        ------
        UsageError
            A value is out of range, or not a whole number.
        """
        for name, number in (("ratio", self.ratio), ("number of discs", self.discs)):
            if number != round(number):
                raise UsageError(
                    f"the {name} is {number}, but must be a whole number: choose {math.floor(number)} or "
                    f"{math.ceil(number)}"
                )
        min_ratio, max_ratio = self.RATIOS
        if not min_ratio <= self.ratio <= max_ratio:
            raise UsageError(
                f"the ratio is {self.ratio}, which is out of range: choose a ratio from {min_ratio} to {max_ratio} "
                f"for {self.STAGES}{self._two_stages()}"
            )
        if not 0 <= self.discs <= MAX_DISCS:
            raise UsageError(
                f"the number of discs is {self.discs}, which is out of range: choose a number from 1 to {MAX_DISCS}"
            )
        for key, quantity in QUANTITIES.items():
            value = getattr(self, key) / quantity.scale
            if not quantity.low <= value <= quantity.high and getattr(self, key) != UNSET.get(key):
                raise UsageError(
                    f"the {quantity.name} is {value:.10g} {quantity.unit}, which is out of range: choose a value from "
                    f"{quantity.low:g} to {quantity.high:g} {quantity.unit}"
                )
        if self.material and self.material not in MATERIALS:
            raise UsageError(f"unknown material {self.material!r}: choose one of {', '.join(MATERIALS)}")
        if self.fit:
            self._check_fit()

    def _two_stages(self) -> str:
        """Return advice on reaching a large ratio by two stages in series.

        It is empty if one stage is enough, or if two stages are not.
        """
        if not MOST_RATIO < self.ratio <= MOST_RATIO**2:
            return ""
        stages = range(LEAST_RATIO, math.isqrt(self.ratio) + 1)
        low = max((item for item in stages if self.ratio % item == 0), default=0)
        if not low or self.ratio // low > MOST_RATIO:
            low = math.isqrt(self.ratio)
        high = round(self.ratio / low)
        return (
            f". Two stages multiply, {high} x {low} = {high * low}: run `cycloid-mj design new` for the output stage "
            f"(--ratio {low}) with {self.torque:g} N m, and for the input stage (--ratio {high}) with the torque "
            f"divided by {low}, {self.torque / low:.4g} N m, and {low} times the output speed"
        )

    def _check_fit(self) -> None:
        """Raise UsageError if the fit is unknown or an interference fit, or if a clearance is set in addition to it."""
        if self.clearance:
            raise UsageError(
                f"fit = {self.fit} and clearance_um = {1e6 * self.clearance:g} are both set, but each of them "
                "determines the clearances between the parts: remove one of the two"
            )
        try:
            min_clearance, _ = clearances(self.fit, LARGEST_PAIR * self.diameter)
        except ValueError as error:
            raise UsageError(
                f"the fit {self.fit!r} is not valid: {error}. Choose a clearance fit, such as H7/g6"
            ) from None
        if min_clearance < 0.0:
            raise UsageError(
                f"the fit {self.fit} is an interference fit, but the parts must move: choose a clearance fit, such as "
                "H7/g6"
            )

    def but(self, **changes: Any) -> Self:
        """Return the requirement with other values."""
        return replace(self, **changes)

    def duty_at(self, torque: float) -> Duty:
        """Return the duty cycle whose largest torque is a torque [N m]."""
        if not self.duty:
            return constant_duty(torque, self.speed)
        points = tuple(DutyPoint(relative * torque, speed, share) for relative, speed, share in self.duty)
        return Duty(points, PEAK_FACTOR * torque, peak_given=False)

    @property
    def numbers_of_discs(self) -> tuple[int, ...]:
        """The numbers of discs that may be used."""
        return (self.discs,) if self.discs else (1, 2)

    @property
    def kind(self) -> Self:
        """Return the requirement without limits and conditions that do not influence the sizes of candidates.

        Such requirements share a cached set of candidates. Limits become infinite; conditions become those that are
        usual for the process.
        """
        process = PROCESSES[self.process]
        return self.but(
            torque=1.0,
            length=math.inf,
            backlash=self.backlash if self.backlash == math.inf else 1.0,
            life=process.life_h,
            speed=process.speed_rpm * RPM,
            duty_share=process.duty_share,
            duty=(),
            film=COOLING["still"],
            ambient=20.0,
            tightened=False,
        )

    @property
    def made_of(self) -> str:
        """Material of disc and housing."""
        return self.material or PROCESSES[self.process].material

    @property
    def usual_clearance(self) -> float:
        """Required clearance, or that of the process, or that of the fit at the size of a ring pin [m]."""
        return self.clearance_at(PIN_SIZE * self.diameter)

    @property
    def finer(self) -> list[Self]:
        """The requirement with the finer clearances to try after its own, the largest first.

        Without a limit of the backlash, this is only the finest clearance of the process; if a clearance or a fit is
        required, there are none.
        """
        if (self.clearance or self.fit) and not self.tightened:
            return []
        finest = PROCESSES[self.process].finest
        usual = [finest] if finest < self.usual_clearance else []
        allowed = usual if self.backlash == math.inf else self.tighter_clearances
        return [self.but(clearance=clearance, tightened=True) for clearance in allowed]

    @property
    def tighter_clearances(self) -> Iterator[float]:
        """Return the clearances below the usual one that the process allows [m], the largest first.

        Such clearances are finer than the usual accuracy of the process. They need parts that are measured and matched,
        such as pins sorted into groups by ISO 3096.
        """
        min_clearance = PROCESSES[self.process].matched
        count = math.floor(math.log(min_clearance / self.usual_clearance) / math.log(FINER) + 1e-9)
        return (significant(self.usual_clearance * FINER**step) for step in range(1, count + 1))

    def clearance_at(self, size: float) -> float:
        """Compute the clearance of a pair [m], normal to its surfaces, at its diameter [m]; for a fit its mean."""
        if self.fit:
            return round(0.25 * sum(clearances(self.fit, size)), 9)
        return self.clearance or PROCESSES[self.process].clearance

    def cam_clearance_at(self, size: float) -> float:
        """Compute the clearance of a cam in its bearing [m]; `size` is the outside diameter of the bearing [m].

        Cam and bearing are ground in every process, so a clearance is at most the usual one of ground parts.
        """
        clearance = self.clearance_at(size)
        return clearance if self.fit else min(clearance, PROCESSES["steel"].clearance)
