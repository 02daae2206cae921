"""A whole drive from shares of its size, as drives on the market and in papers have them (assumed)."""

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

THICKEST = 0.2
"""Most radius of a pin, as a share of the pin circle's: of few pins, which would leave no gear between them."""

NARROWEST, WIDEST = 0.12, 1.2
"""Least and most face width of all discs, as shares of the pin circle: a wider gear tilts more than it carries."""

SLIMMEST = 0.5
"""Least radius of an output pin in its hole: a pin as thick as the eccentricity; slimmer ones bend away."""

LEVELS: dict[str, tuple[float, ...]] = {
    "short_width": (0.3, 0.36, 0.42, 0.48, 0.54, 0.6, 0.66, 0.72, 0.78, 0.84),
    "pin": (0.4, 0.5, 0.62, 0.72, 0.8),
    "wall": (0.06, 0.09, 0.12, 0.16, 0.2, 0.25),
    "bore": (0.3, 0.36, 0.42, 0.48, 0.54, 0.6),
    "hole": (0.5, 0.56, 0.62, 0.7, 0.78),
    "shaft": (0.4, 0.5, 0.6, 0.7, 0.8),
    "output_pins": (4, 6, 8, 10, 12),
    "width": (NARROWEST, 0.16, 0.22, 0.3, 0.4, 0.55, 0.75, 1.0, WIDEST),
}
"""Values of each share that are tried (assumed)."""

GAP_SHARE = 0.04
"""Of a gap between discs in the outer radius: room for the spacer, and little for tilting couples."""

DISC_SHARE = 0.15
"""Of the thickness of an output disc in the outer radius."""

OVERRATED = 1.1
"""Power of the motor over that which torque and speed ask for."""

FITTED = ("mesh", "seat", "cam", "output")
"""Tolerances that a fit gives."""

STEPS = tuple(digit * 10.0**power for power in range(-3, -7, -1) for digit in (5.0, 2.5, 1.0))
"""Of dimensions [m], from 5 mm to 1 um."""


@dataclass(frozen=True)
class Proportions:
    """Shares of a drive, each of what is named.

    Attributes
    ----------
    short_width
        K1 = c N / E.
    pin
        Pin in its room between its neighbours.
    wall
        Housing outside the pins in its radius, at least; more where the screws of the covers need it.
    bore
        Bore in the gear's root.
    hole
        Hole in the room for it: the gear's web, or that between its neighbours.
    shaft
        Shaft in the bore.
    output_pins
        Their number.
    width
        Face width of all discs in the pin circle's radius.
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


def shaped(asked: Requirement, of: Proportions, torque: float) -> Reducer | None:
    """Make a drive of these proportions for a torque [N m]; nothing where it cannot be built as it is asked for."""
    drawn = _drawn(asked, of, torque)
    if drawn is None:
        return None
    return next((reducer for one in _walled(asked, of, drawn, torque) if (reducer := _sound(asked, one))), None)


def _walled(asked: Requirement, of: Proportions, drawn: Reducer, torque: float) -> Iterator[Reducer]:
    """Yield a drive with the thinnest wall in which the screws of its covers have room, then as it was drawn."""
    within = covers_fit(drawn)
    walls = (wall for wall in LEVELS["wall"] if wall > of.wall and not within)
    thicker = (_drawn(asked, of.but(wall=wall), torque) for wall in walls)
    if fitting := next((one for one in thicker if one and covers_fit(one)), None):
        yield fitting
    if within or not asked.covered:
        yield drawn


def _sound(asked: Requirement, drawn: Reducer) -> Reducer | None:
    """Balance a drive; nothing where it is longer than asked for, has no room for its covers, or cannot be built.

    What most drives that are tried fail by comes first, as all checks together cost the most.
    """
    reducer = _balanced(Reducer(drawn.design))
    if _fails(shape_checks(reducer)) or jumps(reducer):
        return None
    if (asked.length < math.inf and _too_long(asked, reducer)) or not has_casing(reducer):
        return None
    return None if _fails(sound_checks(reducer)) else reducer


def _fails(checks: Iterator[Check]) -> bool:
    return any(not item.passed and (item.severity == "error" or item.name in WALLS) for item in checks)


def _too_long(asked: Requirement, reducer: Reducer) -> bool:
    """Tell whether a drive is longer than asked for, or cannot be drawn: its mechanism first, which costs the least."""
    most = MILLIMETRES * asked.length
    try:
        return length(reducer) > most or drive_length(reducer) > most
    except DesignError:
        return True


@dataclass(frozen=True)
class _Sizes:
    """Sizes of a drive that stock decides, or that are free [m].

    `bearing` is the width of the shaft's bearings; it and `core` are 0 where they follow a rule. `face` is the width of
    each gear, `disc` the thickness of the output's discs.
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


def _sized(asked: Requirement, of: Proportions) -> _Sizes | None:
    """Size what may be bought; nothing where stock, or the room that there is, has none of that size."""
    teeth, outer, discs = asked.ratio + 1, asked.diameter / 2.0, asked.discs or 1
    room = math.sin(math.pi / teeth) - 0.005
    circle = rounded((1.0 - of.wall) * outer / (1.0 + of.pin * room))
    pin = rounded(min(of.pin * room, THICKEST) * circle)
    if not asked.custom:
        bought_pin = bought.ring_pin(pin, room * circle)
        if not bought_pin:
            return None
        pin, circle = bought_pin, rounded((1.0 - of.wall) * outer - bought_pin)
    eccentricity, gap = rounded(of.short_width * circle / teeth), rounded(GAP_SHARE * outer)
    face, gaps = rounded(of.width * circle / discs), (discs - 1) * gap
    if not asked.custom:
        face = round((stock.reach_of_pins(2.0 * pin, discs * face + gaps) - gaps) / discs, 9)
    root = circle - eccentricity - pin - asked.clearance_at(2.0 * pin)
    bore, cam, width = rounded(of.bore * root), math.inf, 0.0
    if not asked.custom:
        bearing = bought.cam_bearing(bore, face)
        if not bearing:
            return None
        bore, cam = bearing.bore_radius, bearing.cam_radius
    shaft = rounded(min(of.shaft * bore, 0.85 * (min(bore, cam) - eccentricity)))
    if not asked.custom:
        found_shaft = bought.shaft_bearing(shaft, bar=discs > 1)
        if not found_shaft:
            return None
        shaft, width = round(0.5 * found_shaft.bore, 9), found_shaft.width
    middle, band = 0.5 * (bore + root), root - bore - 0.02 * circle
    hole = of.hole * min(0.5 * band, middle * math.sin(math.pi / of.output_pins) - 0.005 * circle)
    stud, core, disc = rounded(hole - eccentricity), 0.0, rounded(DISC_SHARE * outer)
    if not min(root, stud) > SLIMMEST * hole > 0.0:
        return None
    if not asked.custom:
        between = discs * face + gaps + 2.0 * AXIAL_GAP
        found_core = bought.core(stud, between, disc)
        if not found_core:
            return None
        core = found_core
        disc = bought.disc_thickness(core, between, disc)
    return _Sizes(pin, circle, face, bore, shaft, width, stud, core, disc)


def _drawn(asked: Requirement, of: Proportions, torque: float) -> Reducer | None:
    """Draw the proportions; nothing where stock has no parts for them, or the design's own bounds refuse them."""
    limits, teeth, outer = PROCESSES[asked.process], asked.ratio + 1, asked.diameter / 2.0
    discs, sizes = asked.discs or 1, _sized(asked, of)
    if sizes is None:
        return None
    circle, pin, bore, stud = sizes.circle, sizes.pin, sizes.bore, sizes.stud
    eccentricity, at_pin = rounded(of.short_width * circle / teeth), asked.clearance_at(2.0 * pin)
    middle = 0.5 * (bore + circle - eccentricity - pin - at_pin)
    clamping = {} if asked.custom else bought.clamping(outer - circle - pin)
    rollers = {} if asked.custom else {"roller_bearing": "plain"}
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
                    "pins": of.output_pins,
                    "pin_radius": stud,
                    "core_radius": sizes.core,
                    "pin_circle_radius": rounded(middle),
                    "hole_radius": _as_told(stud + eccentricity),
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
                | {"cam": asked.clearance_at(2.0 * bore), "output": asked.clearance_at(2.0 * stud)},
                tolerance=dict.fromkeys(FITTED, asked.fit),
                drive={
                    "torque": torque / asked.ratio,
                    "speed": asked.speed,
                    "power": OVERRATED * asked.speed * torque / asked.ratio,
                },
                service={"life": asked.life},
                material={"name": asked.made_of},
                **{table: dict(values) for table, values in limits.changes.items() if table != "ring"},
            )
        )
    except DesignError:
        return None


def _balanced(reducer: Reducer) -> Reducer:
    """Make the shaft as long as its bearing and the counterweight that balances the gear need."""
    shaft = reducer.design.shaft
    if reducer.design.gear.discs > 1:
        return reducer.but(shaft={"length": rounded_up(max(2.0 * shaft.radius, 1.1 * shaft.bearing_width))})
    needed = bearings(reducer).limit.bound
    return reducer.but(shaft={"length": rounded_up(needed + (0.5 if shaft.bearing_width else 1.5) * shaft.radius)})


def rounded(length: float) -> float:
    """Round a length [m] down to the largest of the usual steps that changes it by 2 % at most."""
    step = next((step for step in STEPS if step <= 0.02 * abs(length)), STEPS[-1])
    return _as_told(math.floor(length / step + 1e-9) * step)


def rounded_up(length: float) -> float:
    """Round a length [m] up, to the same steps."""
    step = next((step for step in STEPS if step <= 0.02 * abs(length)), STEPS[-1])
    return _as_told(math.ceil(length / step - 1e-9) * step)


def _as_told(length: float) -> float:
    """Return the length [m] that the design file tells by the fewest digits."""
    return round(MILLIMETRES * length, 6) / MILLIMETRES
