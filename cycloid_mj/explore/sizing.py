"""From ratio, diameter and torque to a whole design: proportions that work, then the widths that the loads ask for.

Proportions are shares of the pin circle, as drives on the market and in papers have them (assumed, each with its reason
beside it in the file). What the strength asks for follows from statics at the rated torque, with the real clearances.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

from cycloid_mj.base.errors import DesignError, UsageError
from cycloid_mj.checks import WALLS, Check, check, soundness
from cycloid_mj.design import PRESETS, Design
from cycloid_mj.design.units import RPM
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bodies import are_one_part

Process = Literal["steel", "printed"]

LEAST_RATIO, MOST_RATIO = 3, 119

WALL = 0.12
"""Of the housing outside the pins, as a share of its radius."""

PIN_SHARE = 0.62
"""Of the room that a pin has between its neighbours: walls between sockets, and lobes, are left as much again."""

THICKEST = 0.2
"""Most radius of a pin, as a share of the pin circle's: of few pins, which would leave no gear between them."""

SHORT_WIDTHS = (0.72, 0.66, 0.6, 0.54, 0.48, 0.42, 0.36, 0.3)
"""K1 = c N / E, the largest first that every check of the teeth allows: more turns the forces round, less aside."""

BORE_SHARE, SHAFT_SHARE = 0.42, 0.5
"""Of the bore in the gear's root, and of the shaft in the bore."""

HOLE_SHARE = 0.62
"""Of the room for a hole, between the walls of the gear's web or between its neighbours."""

NARROWEST, WIDEST = 0.2, 1.2
"""Least and most face width of all discs, as shares of the pin circle: a wider gear tilts more than it carries."""

GAP_SHARE = 0.04
"""Of a gap between discs in the outer radius: room for the spacer, and little for tilting couples."""

MOST_DISCS = 4

MARGIN = 1.1
"""On the pressures that a check allows."""

SPEED = RPM.to_si(1500.0)
"""Of the crank [rad/s]: a motor with four poles at 50 Hz."""

STEPS = tuple(digit * 10.0**power for power in range(-3, -7, -1) for digit in (5.0, 2.5, 1.0))
"""Of dimensions [m], from 5 mm to 1 um."""

WIDENINGS = 12


@dataclass(frozen=True)
class ProcessLimits:
    """What a process is good for.

    Attributes
    ----------
    clearance
        Of each pair [m].
    changes
        Changes of the preset ``pin``, by table.
    reasons
        Of these, by the key of the design file's model.
    """

    clearance: float
    changes: Mapping[str, Mapping[str, object]]
    reasons: Mapping[str, str]


PROCESSES: dict[Process, ProcessLimits] = {
    "steel": ProcessLimits(
        clearance=5e-6,
        changes={"material": {"name": "tempered steel"}, "pin_material": {"name": "bearing steel"}},
        reasons={
            "material.name": "turned, ground and wire-cut from the bar",
            "pin_material.name": "pins are bought: needle rollers",
            "clearance.pin_gear": "ground parts leave a few micrometres",
        },
    ),
    "printed": ProcessLimits(
        clearance=1e-4,
        changes={
            "material": {"name": "PLA"},
            "pin_material": {"name": "bearing steel"},
            "output_material": {"name": "bearing steel"},
            "shaft_material": {"name": "tempered steel"},
            "ring": {"pins": "fixed"},
            "friction": {"pin_gear": 0.12},
        },
        reasons={
            "material.name": "printed; use the numbers of your own filament",
            "pin_material.name": "steel dowels, pressed in",
            "output_material.name": "steel dowels with rollers; the disc is taken with them",
            "clearance.pin_gear": "what a printer needs for parts that move",
            "friction.pin_gear": "greased plastic on steel",
        },
    ),
}


@dataclass(frozen=True)
class Sized:
    """A design with its reasons, by ``table.value``, and what its checks say."""

    design: Design
    reasons: Mapping[str, str]
    checks: tuple[Check, ...]


def sized(name: str, ratio: int, diameter: float, torque: float, process: Process = "steel", discs: int = 1) -> Sized:
    """Size a design for a ratio, an outer diameter [m] and a rated torque on the output [N m], with some discs.

    Raises
    ------
    UsageError
        The ratio or the number of discs is out of range or no whole number, or the torque too large for the diameter.
    DesignError
        No proportions pass the checks.
    """
    for what, number in (("ratio", ratio), ("number of discs", discs)):
        if number != round(number):
            raise UsageError(f"the {what} is {number}; give {math.floor(number)} or {math.ceil(number)}")
    if not LEAST_RATIO <= ratio <= MOST_RATIO:
        raise UsageError(f"the ratio is {ratio}; one stage of pins has from {LEAST_RATIO} to {MOST_RATIO}")
    if not 1 <= discs <= MOST_DISCS:
        raise UsageError(f"{discs} discs are asked for; a crank has from 1 to {MOST_DISCS}")
    for what, value, unit in (("diameter", 1e3 * diameter, "mm"), ("torque", torque, "N m")):
        if not 0.0 < value < math.inf:
            raise UsageError(f"the {what} is {value:g} {unit}; it must be more than 0")
    for short_width in SHORT_WIDTHS:
        shape = _shaped(name, ratio, diameter, torque, process, discs, short_width)
        if shape is not None and _sound(Reducer(shape)):
            return _carrying(Reducer(shape), process, short_width)
    raise DesignError(
        f"no gear with a ratio of {ratio} fits into {1e3 * diameter:g} mm with the clearances of the process "
        f"{process!r}: take a larger diameter, or a smaller ratio"
    )


def _shaped(
    name: str, ratio: int, diameter: float, torque: float, process: Process, discs: int, short_width: float
) -> Design | None:
    """Return the proportions at one K1; nothing where the design's own bounds refuse them."""
    limits, teeth, outer = PROCESSES[process], ratio + 1, diameter / 2.0
    room = PIN_SHARE * (math.sin(math.pi / teeth) - 0.005)
    circle = _rounded((1.0 - WALL) * outer / (1.0 + room))
    pin = _rounded(min(room, THICKEST) * circle)
    eccentricity = _rounded(short_width * circle / teeth)
    root = circle - eccentricity - pin - limits.clearance
    bore = _rounded(BORE_SHARE * root)
    middle, band = 0.5 * (bore + root), root - bore - 0.02 * circle
    counts = (8, 6) if root > 8.0 * eccentricity else (6, 8)
    count = next((few for few in (*counts, 4, 10, 12) if are_one_part(discs, few, ratio)), counts[0])
    hole = HOLE_SHARE * min(0.5 * band, middle * math.sin(math.pi / count) - 0.005 * circle)
    stud = _rounded(hole - eccentricity)
    if not min(root, stud) > 0.35 * hole > 0.0:
        return None
    try:
        changed = PRESETS["pin"].but(
            name=name,
            structure="springs",
            gear={
                "discs": discs,
                "disc_gap": _rounded(GAP_SHARE * outer),
                "eccentricity": eccentricity,
                "face_width": _rounded(NARROWEST * circle / discs),
                "bore_radius": bore,
            },
            output={
                "pins": count,
                "pin_radius": stud,
                "pin_circle_radius": _rounded(middle),
                "hole_radius": stud + eccentricity,
                "disc_thickness": _rounded(0.15 * outer),
                "support": "cantilever" if discs == 1 else "both_ends",
            },
            shaft={
                "radius": _rounded(min(SHAFT_SHARE * bore, 0.9 * (bore - eccentricity))),
                "counterweight_radius": _rounded(0.7 * circle),
                "length": _rounded(0.6 * outer),
                "mounting": "overhang" if discs == 1 else "straddle",
            },
            housing={"outer_radius": outer},
            clearance=dict.fromkeys(
                ("pin_gear", "pin_socket", "pin_sleeve", "tooth", "cam", "output"), limits.clearance
            ),
            drive={"torque": torque / ratio, "speed": SPEED, "power": MARGIN * SPEED * torque / ratio},
        )
        ring = {"teeth": teeth, "pin_circle_radius": circle, "pin_radius": pin}
        changed = changed.but(ring=ring)
        return changed.but(**{table: dict(values) for table, values in limits.changes.items()})
    except DesignError:
        return None


def _sound(reducer: Reducer) -> bool:
    """Tell whether the teeth and the body hold, with walls as thick as is assumed; the shaft is made longer later."""
    failed = (item for item in soundness(reducer) if not item.passed and item.name not in ("balance", "bearings"))
    return not any(item.severity == "error" or item.name in WALLS for item in failed)


def _carrying(reducer: Reducer, process: Process, short_width: float) -> Sized:
    """Make the gear as wide as the pressures ask for, and the shaft as long as its counterweight needs."""
    pressed = ("tooth_yield", "output_yield", "cam_yield", "bore_to_hole", "hole_to_root", "housing_ligament")
    for _ in range(WIDENINGS):
        reducer = Reducer(_balanced(reducer))
        by_name = {item.name: item for item in check(reducer.design)}
        worst = max((_overload(by_name[name]) for name in pressed if name in by_name), default=math.inf)
        if worst <= 1.0:
            return Sized(reducer.design, dict(_reasons(reducer, process, short_width)), tuple(by_name.values()))
        width = reducer.design.gear.face_width * min(max(worst, 1.02) ** 1.5, 2.0)
        if reducer.design.gear.discs * width > WIDEST * reducer.design.ring.pin_circle_radius:
            break
        reducer = reducer.but(gear={"face_width": _rounded(1.02 * width)})
    design = reducer.design
    raise UsageError(
        f"{design.rated_torque:g} N m are too much for a diameter of {2e3 * design.housing.outer_radius:g} mm made as "
        f"{process!r}: a face width of {1e3 * design.gear.face_width:g} mm still yields; take a larger diameter"
    )


def _overload(item: Check) -> float:
    if item.value is None or not item.bound:
        return 1.0 if item.passed else math.inf
    return MARGIN * item.value / item.bound


def _balanced(reducer: Reducer) -> Design:
    """Lengthen the shaft until counterweight and bearings have room."""
    for _ in range(WIDENINGS):
        failed = [item for item in soundness(reducer) if item.name in ("balance", "bearings") and not item.passed]
        if not failed:
            return reducer.design
        reducer = reducer.but(shaft={"length": _rounded(1.25 * reducer.design.shaft.length)})
    raise DesignError(f"no shaft of a reasonable length balances the gear of {reducer.design.name!r}: {failed[0]}")


def _reasons(reducer: Reducer, process: Process, short_width: float) -> Iterator[tuple[str, str]]:
    design = reducer.design
    yield "ring.teeth", f"the ratio {design.lobes} plus one"
    yield "ring.pin_circle_radius", f"leaves a wall of {WALL:.0%} of the outer radius"
    yield "ring.pin_radius", f"{PIN_SHARE:.0%} of the room between neighbours"
    yield "gear.eccentricity", f"K1 = c N / E = {short_width:g}: the largest tried that the teeth bear"
    discs = design.gear.discs
    least = discs * design.gear.face_width <= NARROWEST * design.ring.pin_circle_radius
    enough = f"{NARROWEST:.0%} of the pin circle for all discs, more than the pressures ask for"
    yield "structure", "as drives are built: output pins bend, carrier, shaft and housing twist"
    if discs > 1:
        one_part = are_one_part(discs, design.output.pins, design.lobes)
        yield "gear.discs", "as asked for; they balance each other"
        yield "gear.disc_gap", f"{GAP_SHARE:.0%} of the outer radius"
        yield "output.pins", "with them all discs are one and the same part" if one_part else "discs differ as parts"
        yield "output.support", "held at one end, the pins would leave most of the load to the disc next to their root"
        yield "shaft.mounting", "a bearing on either side of the discs"
    yield "gear.face_width", enough if least else f"keeps pressures and walls {MARGIN - 1.0:.0%} within their limits"
    yield "gear.bore_radius", f"{BORE_SHARE:.0%} of the gear's root"
    yield "output.pin_circle_radius", "the middle of the web between bore and root"
    yield "output.pin_radius", f"its hole takes {HOLE_SHARE:.0%} of the web, or of the room between neighbours"
    yield "output.hole_radius", "output pin + eccentricity"
    beside = "for the counterweight that balances the gear, and for two bearings" if discs == 1 else "for a bearing"
    yield "shaft.length", f"room {beside}"
    yield "housing.outer_radius", "as asked for"
    yield "drive.torque", "the torque asked for, over the ratio"
    yield "drive.speed", "a motor with four poles at 50 Hz"
    yield from PROCESSES[process].reasons.items()


def _rounded(length: float) -> float:
    """Round a length [m] down to the largest of the usual steps that changes it by 2 % at most."""
    step = next((step for step in STEPS if step <= 0.02 * abs(length)), STEPS[-1])
    return round(math.floor(length / step + 1e-9) * step, 9)
