"""Checks of a sound design under its nominal torque: pressures, sharing, walls. All are warnings: it runs all the same.

Forces are those of `loaded`, with the real clearances, errors and friction, and the stiffness of contacts and cam.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypedDict

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.checks.cam_rollers import has_bare_rollers, roller_contacts
from cycloid_mj.checks.limit import Check, Limit, joint_change, single_changes, value_and_limit
from cycloid_mj.checks.rated_load import Rated, rated
from cycloid_mj.design import PARTNERS, Design
from cycloid_mj.design.materials import HARDNESS_PRESSURE, SHAKEDOWN_PRESSURE, YIELD_PRESSURE
from cycloid_mj.design.units import DEGREE, MEGAPASCAL, NEWTON_METRE, NONE, Unit
from cycloid_mj.reducer import Reducer

CONCENTRATION = 3.0
"""Assumed: most that the largest tooth force may be, over that of ideal sharing."""

PRESSURE_ANGLE = math.radians(70.0)
"""Assumed: largest mean pressure angle; beyond, the teeth push the gear aside three times as hard as round."""

SAFETY = 2.0
"""Assumed: what the notches of a wall leave of its strength; `cycloid-mj stress` finds it by finite elements."""

MARGIN = 1e-3
"""Relative; how far a remedy that rests on the statics stays inside its limit: they are as exact as that."""

NEAR = 0.01
"""Relative; how near to its limit a remedy comes that is found by halving."""

GUESSES = 6

TENSION, SHEAR = 1.0, 1.0 / math.sqrt(3.0)
"""Share of the yield strength that a wall bears (von Mises)."""

PARTS = {"tooth": "the teeth", "output": "the output pins in their holes", "cam": "the cam's bearing"}


class _Numbers(TypedDict):
    value: float
    bound: float
    unit: str


def strength_checks(reducer: Reducer) -> Iterator[Check]:
    """Check what a sound design carries at its nominal torque."""
    try:
        state = rated(reducer)
    except CycloidError as error:
        yield _unknown(error)
        return
    for part in PARTS:
        if part != "cam" or reducer.design.gear.bearing == "plain" or has_bare_rollers(reducer):
            yield from _pressures(state, part)
    yield _concentration(state)
    yield _pressure_angle(state)
    for wall in walls(reducer):
        yield _wall(state, wall)


def _unknown(error: CycloidError) -> Check:
    return Check(
        name="rated_load",
        passed=False,
        got="without a static balance",
        limit="one that the contacts can hold",
        why=str(error),
        remedy="",
        severity="warning",
        key="the design at its nominal torque",
    )


def _pressures(state: Rated, part: str) -> Iterator[Check]:
    """Check the Hertz pressure of one part's contacts against first yield, shakedown and hardness."""
    design = state.reducer.design
    reducer = Reducer(design)
    kind = design.tooth_pair if part == "tooth" else part
    pressure = state.peak_pressure(kind)
    yields = _weaker(reducer, kind, "yield_strength", "surface_strength")
    breaks = _weaker(reducer, kind, "tensile_strength", "surface_tensile_strength")
    for name, (key, strength, ratio), factor, where, what in (
        ("yield", yields, YIELD_PRESSURE, "x yield strength", "the material first yields below the surface"),
        ("shakedown", yields, SHAKEDOWN_PRESSURE, "x yield strength, 4 k", "the material yields anew at each passing"),
        (
            "hardness",
            breaks,
            HARDNESS_PRESSURE,
            "x tensile strength",
            "the contact leaves dents, as a hardness test does",
        ),
    ):
        allowed = factor * strength
        passed = pressure <= allowed
        remedies: list[Limit] = []
        beyond = f"beyond, {what}"
        if not passed:
            torque = state.torque_at(kind, allowed)
            beyond = f"{what} from {_newton_metres(torque)} on" if math.isfinite(torque) else what
            remedies = [
                _face_width(reducer, lambda other: other.peak_pressure(kind), allowed, 2.0),
                Limit(key, "at least", ratio * pressure / factor),
                Limit("drive.torque", "at most", (1.0 - MARGIN) * torque / design.reduction),
            ]
        got, limit = value_and_limit(pressure, "at most", allowed, MEGAPASCAL)
        yield Check(
            name=f"{part}_{name}",
            passed=passed,
            got=got,
            limit=f"{limit} ({factor:.3g} {where})",
            why=beyond,
            remedy=_alternatives(reducer, remedies),
            severity="warning",
            key=f"the Hertz pressure of {PARTS[part]} at {_newton_metres(abs(state.torque))}",
            changes=single_changes(reducer, remedies),
            **_numbers(pressure, allowed, MEGAPASCAL),
        )


def _weaker(reducer: Reducer, kind: str, strength: str, of_surface: str) -> tuple[str, float, float]:
    """Return key, value [Pa] and ratio of a strength of the weaker of the two surfaces that meet in a kind of pair.

    The value is that of the material over the ratio, which is 1 except for bare rollers, see `roller_contacts`.
    """
    design = reducer.design
    bare = kind == "cam" and has_bare_rollers(reducer)
    sides = roller_contacts(reducer) if bare else ((part, 1.0) for part in PARTNERS[kind])
    strengths = []
    for part, ratio in sides:
        material = design.material_of(part)
        key = "surface_yield" if material.surface_yield else strength
        strengths.append((f"{design.material_table(part)}.{key}", float(getattr(material, of_surface)) / ratio, ratio))
    return min(strengths, key=lambda item: item[1])


def _face_width(reducer: Reducer, value: Callable[[Rated], float], allowed: float, power: float) -> Limit:
    """Return the face width at which a value of a rated design, about width ** -1/power, falls to what is allowed."""
    width, figure = reducer.design.gear.face_width, value(rated(reducer))
    for _ in range(GUESSES):
        width *= (1.0 + MARGIN) * (figure / allowed) ** power
        try:
            figure = value(rated(reducer.but(gear={"face_width": width})))
        except CycloidError:
            return Limit("gear.face_width", "at least", math.inf)
        if (1.0 - 4.0 * MARGIN) * allowed < figure <= allowed:
            break
    return Limit("gear.face_width", "at least", width)


def _concentration(state: Rated) -> Check:
    design, ratio = state.reducer.design, state.concentration
    reducer = Reducer(design)
    names = _clearances(reducer)
    passed = ratio <= CONCENTRATION
    got, limit = value_and_limit(ratio, "at most", CONCENTRATION, NONE)

    def tighter(share: float) -> Design:
        return design.but(clearance={name: share * getattr(design.clearance, name) for name in names})

    share = 1.0 if passed else _threshold(lambda share: rated(Reducer(tighter(share))).concentration <= CONCENTRATION)
    limits = [Limit(f"clearance.{name}", "at most", share * getattr(design.clearance, name)) for name in names]
    return Check(
        name="load_concentration",
        passed=passed,
        got=got,
        limit=f"{limit} (assumed)",
        why="with clearances and a cam that gives, few teeth carry what ideal sharing spreads over half of them",
        remedy=""
        if passed
        else " and ".join(filter(None, (limit.remedy(reducer) for limit in limits)))
        if share
        else "no smaller clearance is enough: a wider face or more rollers make the cam stiffer"
        " (gear.face_width_mm, contact.cam_rollers)",
        severity="warning",
        key="the largest tooth force over that of ideal sharing",
        changes=() if passed or not share else joint_change(reducer, limits),
        **_numbers(ratio, CONCENTRATION, NONE),
    )


def _clearances(reducer: Reducer) -> tuple[str, ...]:
    design = reducer.design
    moving = {"pin_socket": design.ring.has_sockets, "pin_sleeve": design.ring.has_sleeves}
    return (design.tooth_pair, *(name for name, moves in moving.items() if moves), "cam", "output")


def _pressure_angle(state: Rated) -> Check:
    design, angle = state.reducer.design, state.pressure_angle
    passed = angle <= PRESSURE_ANGLE
    got, limit = value_and_limit(angle, "at most", PRESSURE_ANGLE, DEGREE)
    least, most = design.gear.eccentricity, design.ring.pin_circle_radius / design.ring.teeth

    def steeper(share: float) -> Design:
        eccentricity = most + share * (least - most)
        return design.but(
            gear={"eccentricity": eccentricity}, output={"hole_radius": design.output.pin_radius + eccentricity}
        )

    def holds(share: float) -> bool:
        return rated(Reducer(steeper(share))).pressure_angle <= PRESSURE_ANGLE

    share = 1.0 if passed else _threshold(holds)
    better = steeper(share) if share else design
    limits = [
        Limit("gear.eccentricity", "at least", better.gear.eccentricity),
        Limit("output.hole_radius", "at least", better.output.hole_radius),
    ]
    return Check(
        name="pressure_angle",
        passed=passed,
        got=f"{got} (weighted by force)",
        limit=f"{limit} (assumed)",
        why="the steeper the tooth forces, the more they load cam and housing instead of turning the gear",
        remedy=""
        if passed
        else " and ".join(filter(None, (limit.remedy(Reducer(design)) for limit in limits)))
        if share
        else "no larger eccentricity is enough: lower the clearances",
        severity="warning",
        key="the mean pressure angle at the nominal torque",
        changes=() if passed or not share else joint_change(Reducer(design), limits),
        **_numbers(angle, PRESSURE_ANGLE, DEGREE),
    )


def _threshold(holds: Callable[[float], bool]) -> float:
    """Find the largest share from 0 to 1, to a hundredth of it, where something holds that fails at 1; 0 for none."""

    def kept(share: float) -> bool:
        try:
            return holds(share)
        except CycloidError:
            return False

    low, high = 0.0, 1.0
    while high - low > NEAR * high and high > NEAR:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if kept(middle) else (low, middle)
    return low


@dataclass(frozen=True)
class Wall:
    """A wall of a `part` that a pin of one `kind` presses on: `thickness` [m], `share` of its yield strength."""

    name: str
    where: str
    part: str
    kind: str
    thickness: float
    share: float

    def stress(self, force: float, width: float) -> float:
        """Compute the stress [Pa] under a force [N] on so wide a line [m]: two planes of shear or tension bear it."""
        return force / (2.0 * self.thickness * width)


def walls(reducer: Reducer) -> tuple[Wall, ...]:
    """List the walls of gear and housing that pins press on."""
    design = reducer.design
    output, ring, gear = design.output, design.ring, design.gear
    hole = output.hole_radius + design.clearance.output
    root = ring.pin_circle_radius + design.modification.pin_circle - gear.eccentricity - reducer.profile_offset
    outside = ring.pin_circle_radius + ring.pin_radius + design.socket_play
    if ring.kind == "nonpin":
        outside = ring.pin_circle_radius - ring.pin_radius + 2.0 * gear.eccentricity
    between = 2.0 * (output.pin_circle_radius * math.sin(math.pi / output.pins) - hole)
    inside, beyond = output.pin_circle_radius - hole, root - output.pin_circle_radius - hole
    ligament, tooth = design.housing.outer_radius - outside, design.tooth_pair
    return (
        Wall("hole_to_hole", "between neighbouring output holes", "gear", "output", between, TENSION),
        Wall("hole_to_root", "between the output holes and the root of the lobes", "gear", "output", beyond, SHEAR),
        Wall(
            "bore_to_hole",
            "between the bore and the output holes",
            "gear",
            "output",
            inside - gear.bore_radius - design.clearance.cam,
            SHEAR,
        ),
        Wall("housing_ligament", "of the housing outside the ring's teeth", "housing", tooth, ligament, SHEAR),
    )


def _wall(state: Rated, wall: Wall) -> Check:
    """Check that no pin tears out of its wall."""
    design = state.reducer.design

    def acting(state: Rated) -> float:
        return wall.stress(state.peak_force(wall.kind), state.reducer.design.line_length(wall.kind))

    stress = acting(state)
    material = design.material_of(wall.part)
    strength = wall.share * material.yield_strength / SAFETY
    passed = stress <= strength
    kind = "tension" if wall.share == TENSION else "shear"
    got, limit = value_and_limit(stress, "at most", strength, MEGAPASCAL)
    enough = Limit(
        f"{design.material_table(wall.part)}.yield_strength", "at least", material.yield_strength * stress / strength
    )
    remedies = [] if passed else [_face_width(Reducer(design), acting, strength, 1.0), enough]
    return Check(
        name=wall.name,
        passed=passed,
        got=f"{got} of {kind}",
        limit=f"{limit} (the yield strength in {kind} over {SAFETY:g}, assumed)",
        why=f"the largest force there, {state.peak_force(wall.kind):.4g} N, must not tear the"
        f" {1e3 * wall.thickness:.4g} mm of wall",
        remedy=_alternatives(Reducer(design), remedies),
        severity="warning",
        key=f"the wall {wall.where}",
        changes=single_changes(Reducer(design), remedies),
        **_numbers(stress, strength, MEGAPASCAL),
    )


def _alternatives(reducer: Reducer, limits: list[Limit]) -> str:
    return ", or ".join(filter(None, (limit.remedy(reducer) for limit in limits)))


def _numbers(value: float, bound: float, unit: Unit) -> _Numbers:
    """Return a value and its bound [SI] in a unit of the file."""
    return {"value": unit.from_si(value), "bound": unit.from_si(bound), "unit": unit.suffix}


def _newton_metres(torque: float) -> str:
    return f"{NEWTON_METRE.from_si(torque):.4g} N m"
