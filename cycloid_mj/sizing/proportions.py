"""A complete drive from proportions of its size, as in commercial and published drives (assumed)."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Self

from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.checks import WALLS, Check, jumps, shape_checks, sound_checks
from cycloid_mj.checks.body import bearings
from cycloid_mj.design import PRESETS, stock
from cycloid_mj.life.figures import drive_length, length
from cycloid_mj.parts.export.casing import covers_fit
from cycloid_mj.parts.export.drive import has_casing
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP
from cycloid_mj.sizing import bought
from cycloid_mj.sizing.process import PROCESSES
from cycloid_mj.sizing.requirement import Requirement

MAX_PIN_SHARE = 0.2
"""Largest radius of a pin relative to the pin circle, for rings of few pins."""

MIN_WIDTH, MAX_WIDTH = 0.12, 1.2
"""Smallest and largest face width of all discs relative to the pin circle; a wider disc tilts."""

MIN_PIN_SHARE = 0.5
"""Smallest radius of an output pin relative to its hole; thinner pins bend too much."""

GRID: dict[str, tuple[float, ...]] = {
    "short_width": (0.3, 0.36, 0.42, 0.48, 0.54, 0.6, 0.66, 0.72, 0.78, 0.84),
    "pin": (0.4, 0.5, 0.62, 0.72, 0.8),
    "wall": (0.06, 0.09, 0.12, 0.16, 0.2, 0.25),
    "bore": (0.3, 0.36, 0.42, 0.48, 0.54, 0.6),
    "hole": (0.5, 0.56, 0.62, 0.7, 0.78),
    "shaft": (0.4, 0.5, 0.6, 0.7, 0.8),
    "output_pins": (4, 6, 8, 10, 12),
    "width": (MIN_WIDTH, 0.16, 0.22, 0.3, 0.4, 0.55, 0.75, 1.0, MAX_WIDTH),
}
"""Grid of values of each proportion (assumed)."""

GAP_SHARE = 0.04
"""Gap between discs relative to the outer radius, for the spacer, with little tilting moment."""

DISC_SHARE = 0.15
"""Thickness of an output disc relative to the outer radius."""

POWER_RESERVE = 1.1
"""Power of the motor relative to that of torque and speed."""

FIT_TOLERANCES = ("mesh", "seat", "cam", "output")
"""Tolerances that follow from a fit."""

STEPS = tuple(digit * 10.0**power for power in range(-3, -7, -1) for digit in (5.0, 2.5, 1.0))
"""Rounding steps of dimensions [m], from 5 mm to 1 um."""


@dataclass(frozen=True)
class Proportions:
    """Proportions of a drive.

    Attributes
    ----------
    short_width
        K1 = c N / E.
    pin
        Pin radius relative to the space between its neighbours.
    wall
        Minimum wall of the housing outside the pins relative to its radius; cover screws can require more.
    bore
        Bore relative to the root of the disc.
    hole
        Hole relative to its space: the web of the disc, or that between its neighbours.
    shaft
        Shaft relative to the bore.
    output_pins
        Number of output pins.
    width
        Face width of all discs relative to the radius of the pin circle.
    """

    short_width: float = 0.78
    pin: float = 0.62
    wall: float = 0.06
    bore: float = 0.42
    hole: float = 0.7
    shaft: float = 0.7
    output_pins: int = 8
    width: float = 0.75

    def but(self, **changes: Any) -> Self:
        """Return other proportions."""
        return replace(self, **changes)

    def neighbour(self, name: str, sense: int) -> Self | None:
        """Return the proportions with the next value of `GRID` up (1) or down (-1) in one of them; None at its end."""
        place = GRID[name].index(getattr(self, name)) + sense
        return self.but(**{name: GRID[name][place]}) if 0 <= place < len(GRID[name]) else None


def build_drive(requirement: Requirement, proportions: Proportions, torque: float) -> Reducer | None:
    """Build a drive of some proportions for a torque [N m]; return None if it does not meet the requirement."""
    drawn = _draw(requirement, proportions, torque)
    if drawn is None:
        return None
    return next(
        (
            reducer
            for one in _with_wall(requirement, proportions, drawn, torque)
            if (reducer := _sound(requirement, one))
        ),
        None,
    )


def _with_wall(requirement: Requirement, proportions: Proportions, drawn: Reducer, torque: float) -> Iterator[Reducer]:
    """Yield a drive with the thinnest wall in which its cover screws fit, then the drive as drawn."""
    within = covers_fit(drawn)
    walls = (wall for wall in GRID["wall"] if wall > proportions.wall and not within)
    thicker = (_draw(requirement, proportions.but(wall=wall), torque) for wall in walls)
    if fitting := next((one for one in thicker if one and covers_fit(one)), None):
        yield fitting
    if within or not requirement.covered:
        yield drawn


def _sound(requirement: Requirement, drawn: Reducer) -> Reducer | None:
    """Balance a drive; return None if it is too long, its covers do not fit, or it cannot be built.

    The most frequent failures are checked first.
    """
    reducer = _balance_shaft(Reducer(drawn.design))
    if _fails(shape_checks(reducer)) or jumps(reducer):
        return None
    if (requirement.length < math.inf and _too_long(requirement, reducer)) or not has_casing(reducer):
        return None
    return None if _fails(sound_checks(reducer)) else reducer


def _fails(checks: Iterator[Check]) -> bool:
    return any(not item.passed and (item.severity == "error" or item.name in WALLS) for item in checks)


def _too_long(requirement: Requirement, reducer: Reducer) -> bool:
    """Return whether a drive exceeds the required length or cannot be drawn; the mechanism is checked first."""
    most = MILLIMETRES * requirement.length
    try:
        return length(reducer) > most or drive_length(reducer) > most
    except DesignError:
        return True


@dataclass(frozen=True)
class _Sizes:
    """Sizes of a drive that follow from stock, or are free [m].

    `bearing` is the width of the shaft bearings; it and `core` are 0 if they follow from the design. `face` is the
    width of each disc, `disc` the thickness of the output discs.
    """

    pin: float
    circle: float
    face: float
    bore: float
    shaft: float
    bearing: float
    stud: float
    core: float
    disc: float


def _choose_sizes(requirement: Requirement, proportions: Proportions) -> _Sizes | None:
    """Choose sizes of parts in stock; return None if none fits."""
    teeth, outer, discs = requirement.ratio + 1, requirement.diameter / 2.0, requirement.discs or 1
    room = math.sin(math.pi / teeth) - 0.005
    circle = rounded((1.0 - proportions.wall) * outer / (1.0 + proportions.pin * room))
    pin = rounded(min(proportions.pin * room, MAX_PIN_SHARE) * circle)
    if not requirement.custom:
        bought_pin = bought.ring_pin(pin, room * circle)
        if not bought_pin:
            return None
        pin, circle = bought_pin, rounded((1.0 - proportions.wall) * outer - bought_pin)
    eccentricity, gap = rounded(proportions.short_width * circle / teeth), rounded(GAP_SHARE * outer)
    face, gaps = rounded(proportions.width * circle / discs), (discs - 1) * gap
    if not requirement.custom:
        face = round((stock.reach_of_pins(2.0 * pin, discs * face + gaps) - gaps) / discs, 9)
    root = circle - eccentricity - pin - requirement.clearance_at(2.0 * pin)
    bore, cam, width = rounded(proportions.bore * root), math.inf, 0.0
    if not requirement.custom:
        bearing = bought.cam_bearing(bore, face)
        if not bearing:
            return None
        bore, cam = bearing.bore_radius, bearing.cam_radius
    shaft = rounded(min(proportions.shaft * bore, 0.85 * (min(bore, cam) - eccentricity)))
    if not requirement.custom:
        found_shaft = bought.shaft_bearing(shaft, bar=discs > 1)
        if not found_shaft:
            return None
        shaft, width = round(0.5 * found_shaft.bore, 9), found_shaft.width
    middle, band = 0.5 * (bore + root), root - bore - 0.02 * circle
    hole = proportions.hole * min(0.5 * band, middle * math.sin(math.pi / proportions.output_pins) - 0.005 * circle)
    stud, core, disc = rounded(hole - eccentricity), 0.0, rounded(DISC_SHARE * outer)
    if not min(root, stud) > MIN_PIN_SHARE * hole > 0.0:
        return None
    if not requirement.custom:
        between = discs * face + gaps + 2.0 * AXIAL_GAP
        found_core = bought.core(stud, between, disc)
        if not found_core:
            return None
        core = found_core
        disc = bought.disc_thickness(core, between, disc)
    return _Sizes(pin, circle, face, bore, shaft, width, stud, core, disc)


def _draw(requirement: Requirement, proportions: Proportions, torque: float) -> Reducer | None:
    """Return the design of some proportions; None if no parts in stock fit, or a value is out of bounds."""
    limits, teeth, outer = PROCESSES[requirement.process], requirement.ratio + 1, requirement.diameter / 2.0
    discs, sizes = requirement.discs or 1, _choose_sizes(requirement, proportions)
    if sizes is None:
        return None
    circle, pin, bore, stud = sizes.circle, sizes.pin, sizes.bore, sizes.stud
    eccentricity, at_pin = rounded(proportions.short_width * circle / teeth), requirement.clearance_at(2.0 * pin)
    middle = 0.5 * (bore + circle - eccentricity - pin - at_pin)
    clamping = {} if requirement.custom else bought.clamping(outer - circle - pin)
    rollers = {} if requirement.custom else {"roller_bearing": "plain"}
    try:
        return Reducer(
            PRESETS["pin"].but(
                name="new",
                structure="springs",
                ring={"teeth": teeth, "pin_circle_radius": circle, "pin_radius": pin, **limits.changes.get("ring", {})},
                gear={
                    "discs": discs,
                    "disc_gap": rounded(GAP_SHARE * outer),
                    "eccentricity": eccentricity,
                    "face_width": sizes.face,
                    "bore_radius": bore,
                },
                output={
                    **rollers,
                    "pins": proportions.output_pins,
                    "pin_radius": stud,
                    "core_radius": sizes.core,
                    "pin_circle_radius": rounded(middle),
                    "hole_radius": _round_to_file(stud + eccentricity),
                    "disc_thickness": sizes.disc,
                    "support": "both_ends",
                },
                shaft={
                    "radius": sizes.shaft,
                    "bearing_width": sizes.bearing,
                    "counterweight_radius": rounded(0.75 * (circle - pin)),
                    "length": rounded(0.3 * outer),
                    "mounting": "straddle",
                },
                housing={"outer_radius": outer, **clamping},
                clearance=dict.fromkeys(("pin_gear", "pin_socket", "pin_sleeve", "tooth"), at_pin)
                | {"cam": requirement.clearance_at(2.0 * bore), "output": requirement.clearance_at(2.0 * stud)},
                tolerance=dict.fromkeys(FIT_TOLERANCES, requirement.fit),
                drive={
                    "torque": torque / requirement.ratio,
                    "speed": requirement.speed,
                    "power": POWER_RESERVE * requirement.speed * torque / requirement.ratio,
                },
                service={"life": requirement.life},
                material={"name": requirement.made_of},
                **{table: dict(values) for table, values in limits.changes.items() if table != "ring"},
            )
        )
    except DesignError:
        return None


def _balance_shaft(reducer: Reducer) -> Reducer:
    """Return the drive with the shaft length that its bearing and the counterweight need."""
    shaft = reducer.design.shaft
    if reducer.design.gear.discs > 1:
        return reducer.but(shaft={"length": rounded_up(max(2.0 * shaft.radius, 1.1 * shaft.bearing_width))})
    needed = bearings(reducer).limit.bound
    return reducer.but(shaft={"length": rounded_up(needed + (0.5 if shaft.bearing_width else 1.5) * shaft.radius)})


def rounded(length: float) -> float:
    """Round a length [m] down to the largest rounding step that changes it by at most 2 %."""
    step = next((step for step in STEPS if step <= 0.02 * abs(length)), STEPS[-1])
    return _round_to_file(math.floor(length / step + 1e-9) * step)


def rounded_up(length: float) -> float:
    """Round a length [m] up, to the same steps."""
    step = next((step for step in STEPS if step <= 0.02 * abs(length)), STEPS[-1])
    return _round_to_file(math.ceil(length / step - 1e-9) * step)


def _round_to_file(length: float) -> float:
    """Return a length [m] rounded to the digits of the design file."""
    return round(MILLIMETRES * length, 6) / MILLIMETRES
