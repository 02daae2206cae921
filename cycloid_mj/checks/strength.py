"""Checks of a design at its nominal torque: contact pressures, load sharing, walls. All are warnings.

Forces are those of `rated_load`, with clearances, errors, friction, and the stiffness of contacts and cam.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.checks.cam_rollers import has_bare_rollers, roller_contacts
from cycloid_mj.checks.check import Check
from cycloid_mj.checks.limit import (
    Limit,
    joint_remedy,
    numbers,
    single_remedies,
    value_and_limit,
)
from cycloid_mj.checks.rated_load import RatedLoad, rated_load
from cycloid_mj.design import PARTNERS
from cycloid_mj.design.materials import HARDNESS_PRESSURE, SHAKEDOWN_PRESSURE, YIELD_PRESSURE
from cycloid_mj.design.units import DEGREE, MEGAPASCAL, NEWTON_METRE, NONE
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class StrengthSettings:
    """Assumed limits at the nominal torque, and settings of the remedies by statics."""

    max_concentration: float = 3.0
    """Assumed largest tooth force over that of ideal load sharing."""
    max_pressure_angle: float = math.radians(70.0)
    """Assumed largest mean pressure angle: the radial force is then three times the tangential force."""
    wall_safety: float = 2.0
    """Assumed factor for the notches of a wall; `cycloid-mj stress` computes them by finite elements."""
    statics_rtol: float = 1e-3
    """Relative distance of a remedy computed by statics from its limit: the accuracy of the statics."""
    bisection_rtol: float = 0.01
    """Relative accuracy of a remedy by bisection."""
    max_iterations: int = 6
    """Iterations for a face width: pressures and stresses are nearly a power of it."""


STRENGTH = StrengthSettings()


TENSION, SHEAR = 1.0, 1.0 / math.sqrt(3.0)
"""Strength of a wall over the yield strength in tension (von Mises)."""

PARTS = {"tooth": "the teeth", "output": "the output pins in their holes", "cam": "the cam's bearing"}


def strength_checks(reducer: Reducer) -> Iterator[Check]:
    """Yield the checks of contact pressures, load sharing and wall strength of a feasible design at its nominal torque.

    If there is no static equilibrium, a single failed check is yielded, which states the reason. A cam with a bought
    bearing has no pressure checks.
    """
    try:
        loads = rated_load(reducer)
    except CycloidError as error:
        yield _failed_equilibrium_check(error)
        return
    for part in PARTS:
        if part != "cam" or reducer.design.gear.bearing == "plain" or has_bare_rollers(reducer):
            yield from _pressure_checks(loads, part)
    yield _check_load_sharing(loads)
    yield _check_pressure_angle(loads)
    for wall in list_walls(reducer):
        yield _check_wall(loads, wall)


def _failed_equilibrium_check(error: CycloidError) -> Check:
    """Return a failed check, a warning: no static equilibrium at the nominal torque, with the text of `error`."""
    return Check(
        name="rated_load",
        passed=False,
        got="without a static equilibrium",
        limit="one that the contacts can carry",
        why=str(error),
        remedy="",
        severity="warning",
        key="the design at its nominal torque",
    )


def _pressure_checks(loads: RatedLoad, part: str) -> Iterator[Check]:
    """Yield the checks of a part's largest Hertz pressure against three limits: first yield, shakedown and hardness.

    `loads` are those at the nominal torque, `part` is a key of `PARTS`. The remedies of a failed check are a wider
    face, a stronger material, or less torque.
    """
    reducer, design = loads.reducer, loads.reducer.design
    kind = design.tooth_pair if part == "tooth" else part
    pressure = loads.peak_pressure(kind)
    weaker_yield = _weaker_strength(reducer, kind, "yield_strength", "surface_strength")
    weaker_tensile = _weaker_strength(reducer, kind, "tensile_strength", "surface_tensile_strength")
    for name, (key, strength, ratio), factor, factor_text, consequence in (
        ("yield", weaker_yield, YIELD_PRESSURE, "x yield strength", "the material first yields below the surface"),
        (
            "shakedown",
            weaker_yield,
            SHAKEDOWN_PRESSURE,
            "x yield strength, 4 k",
            "the material yields in every load cycle",
        ),
        (
            "hardness",
            weaker_tensile,
            HARDNESS_PRESSURE,
            "x tensile strength",
            "the contact leaves dents, as in a hardness test",
        ),
    ):
        allowed_pressure = factor * strength
        is_passed = pressure <= allowed_pressure
        remedies: list[Limit] = []
        consequence_text = f"above this pressure {consequence}"
        if not is_passed:
            torque = loads.torque_at(kind, allowed_pressure)
            consequence_text = f"above {_newton_metres(torque)} {consequence}" if math.isfinite(torque) else consequence
            remedies = [
                _face_width_limit(reducer, lambda trial: trial.peak_pressure(kind), allowed_pressure, 2.0),
                Limit(key, "at least", ratio * pressure / factor),
                Limit("drive.torque", "at most", (1.0 - STRENGTH.statics_rtol) * torque / design.reduction),
            ]
        value_text, limit_text = value_and_limit(pressure, "at most", allowed_pressure, MEGAPASCAL)
        yield Check(
            name=f"{part}_{name}",
            passed=is_passed,
            got=value_text,
            limit=f"{limit_text} ({factor:.3g} {factor_text})",
            why=consequence_text,
            severity="warning",
            key=f"the Hertz pressure of {PARTS[part]} at {_newton_metres(abs(loads.torque))}",
            **single_remedies(reducer, remedies),
            **numbers(pressure, allowed_pressure, MEGAPASCAL),
        )


def _weaker_strength(
    reducer: Reducer, kind: str, body_attribute: str, surface_attribute: str
) -> tuple[str, float, float]:
    """Return the strength of the weaker of the two surfaces of a mating pair, and the key that sets it.

    Parameters
    ----------
    kind
        Kind of pair, a key of `PARTNERS`.
    body_attribute, surface_attribute
        Attributes of `Material`: a strength of the body, such as "yield_strength", and the same of the surface.

    Returns
    -------
    key : str
        Key of the design file that sets the strength: that of `body_attribute`, or "surface_yield" for a hardened
        surface.
    strength : float
        Strength of the surface over the pressure ratio [Pa], with which the pressure of the model is compared.
    ratio : float
        Pressure ratio [1]: true pressure on this part over that of the model; 1 except for bare rollers
        (`roller_contacts`).
    """
    design = reducer.design
    has_bare_rollers_on_disc = kind == "cam" and has_bare_rollers(reducer)
    ratio_by_part = roller_contacts(reducer) if has_bare_rollers_on_disc else ((part, 1.0) for part in PARTNERS[kind])
    strengths = []
    for part, ratio in ratio_by_part:
        material = design.material_of(part)
        key = "surface_yield" if material.surface_yield else body_attribute
        strengths.append(
            (f"{design.material_table(part)}.{key}", float(getattr(material, surface_attribute)) / ratio, ratio)
        )
    return min(strengths, key=lambda candidate: candidate[1])


def _face_width_limit(
    reducer: Reducer, compute_load: Callable[[RatedLoad], float], allowed_load: float, power: float
) -> Limit:
    """Return the limit on the face width [m] at which a load, such as a pressure, decreases to an allowed value.

    `compute_load` computes it from the equilibrium at the nominal torque. Each iteration assumes that it varies as
    width ** (-1/`power`) and solves for the equilibrium again. Without an equilibrium the limit is infinite, so that it
    is no remedy.
    """
    width, load = reducer.design.gear.face_width, compute_load(rated_load(reducer))
    for _ in range(STRENGTH.max_iterations):
        width *= (1.0 + STRENGTH.statics_rtol) * (load / allowed_load) ** power
        try:
            load = compute_load(rated_load(reducer.but(gear={"face_width": width})))
        except CycloidError:
            return Limit("gear.face_width", "at least", math.inf)
        if (1.0 - 4.0 * STRENGTH.statics_rtol) * allowed_load < load <= allowed_load:
            break
    return Limit("gear.face_width", "at least", width)


def _check_load_sharing(loads: RatedLoad) -> Check:
    """Return the check of the largest tooth force over that of ideal load sharing [1], at the nominal torque.

    The remedy reduces all clearances by a common factor, which bisection determines. If no factor is small enough, the
    remedy is a stiffer cam, in words.
    """
    reducer, design, ratio = loads.reducer, loads.reducer.design, loads.concentration
    clearance_keys = _load_sharing_clearances(reducer)
    is_passed = ratio <= STRENGTH.max_concentration
    value_text, limit_text = value_and_limit(ratio, "at most", STRENGTH.max_concentration, NONE)

    def with_smaller_clearances(share: float) -> Reducer:
        """Return the reducer with a `share` of its clearances."""
        return reducer.but(
            clearance={
                clearance_key: share * getattr(design.clearance, clearance_key) for clearance_key in clearance_keys
            }
        )

    share = (
        1.0
        if is_passed
        else _find_threshold(
            lambda share: rated_load(with_smaller_clearances(share)).concentration <= STRENGTH.max_concentration
        )
    )
    limits = [
        Limit(f"clearance.{clearance_key}", "at most", share * getattr(design.clearance, clearance_key))
        for clearance_key in clearance_keys
    ]
    remedy = joint_remedy(reducer, [] if is_passed else limits)
    if not share:
        remedy_text = "a wider face or more rollers make the cam stiffer (gear.face_width_mm, contact.cam_rollers)"
        remedy = {"remedy": f"smaller clearances are not enough: {remedy_text}", "changes": ()}
    return Check(
        name="load_concentration",
        passed=is_passed,
        got=value_text,
        limit=f"{limit_text} (assumed)",
        why="with clearances and a compliant cam, few teeth carry what ideal sharing distributes over half of them",
        severity="warning",
        key="the largest tooth force over that of ideal load sharing",
        **remedy,
        **numbers(ratio, STRENGTH.max_concentration, NONE),
    )


def _load_sharing_clearances(reducer: Reducer) -> tuple[str, ...]:
    """Return the kinds of pairs whose clearances change the load sharing."""
    design = reducer.design
    moves_by_kind = {"pin_socket": design.ring.has_sockets, "pin_sleeve": design.ring.has_sleeves}
    return (design.tooth_pair, *(kind for kind, moves in moves_by_kind.items() if moves), "cam", "output")


def _check_pressure_angle(loads: RatedLoad) -> Check:
    """Return the check of the mean pressure angle of the tooth forces, weighted by force, at the nominal torque.

    `loads` are those in static equilibrium. The remedy is a larger eccentricity, with output holes that are larger by
    the same amount. Bisection determines it between its present value and the largest possible value, at which the path
    of the pins has loops. If no eccentricity is large enough, the remedy is smaller clearances, in words.
    """
    reducer, design, angle = loads.reducer, loads.reducer.design, loads.pressure_angle
    is_passed = angle <= STRENGTH.max_pressure_angle
    value_text, limit_text = value_and_limit(angle, "at most", STRENGTH.max_pressure_angle, DEGREE)
    current_eccentricity, max_eccentricity = design.gear.eccentricity, design.ring.pin_circle_radius / design.ring.teeth

    def with_larger_eccentricity(share: float) -> Reducer:
        """Return the reducer with an eccentricity from the largest (`share` 0) to the present value (1)."""
        eccentricity = max_eccentricity + share * (current_eccentricity - max_eccentricity)
        return reducer.but(
            gear={"eccentricity": eccentricity}, output={"hole_radius": design.output.pin_radius + eccentricity}
        )

    def is_met(share: float) -> bool:
        return rated_load(with_larger_eccentricity(share)).pressure_angle <= STRENGTH.max_pressure_angle

    share = 1.0 if is_passed else _find_threshold(is_met)
    improved_design = with_larger_eccentricity(share).design if share else design
    limits = [
        Limit("gear.eccentricity", "at least", improved_design.gear.eccentricity),
        Limit("output.hole_radius", "at least", improved_design.output.hole_radius),
    ]
    remedy = joint_remedy(reducer, [] if is_passed else limits)
    if not share:
        remedy = {"remedy": "a larger eccentricity is not enough: lower the clearances", "changes": ()}
    return Check(
        name="pressure_angle",
        passed=is_passed,
        got=f"{value_text} (weighted by force)",
        limit=f"{limit_text} (assumed)",
        why="with a larger angle the tooth forces load cam and housing instead of turning the disc",
        severity="warning",
        key="the mean pressure angle at the nominal torque",
        **remedy,
        **numbers(angle, STRENGTH.max_pressure_angle, DEGREE),
    )


def _find_threshold(is_met: Callable[[float], bool]) -> float:
    """Find the largest argument in [0, 1] at which `is_met` returns true, by bisection; 0 if there is none.

    `is_met` is false at 1, and is assumed to be true at all arguments below the result. The relative accuracy, and the
    smallest result other than 0, is `STRENGTH.bisection_rtol`. A `CycloidError` counts as false.
    """

    def is_met_safely(share: float) -> bool:
        """Return whether the condition is met; false if it raises `CycloidError`."""
        try:
            return is_met(share)
        except CycloidError:
            return False

    passing, failing = 0.0, 1.0
    while failing - passing > STRENGTH.bisection_rtol * failing and failing > STRENGTH.bisection_rtol:
        midpoint = 0.5 * (passing + failing)
        passing, failing = (midpoint, failing) if is_met_safely(midpoint) else (passing, midpoint)
    return passing


@dataclass(frozen=True)
class Wall:
    """A wall of a `part` that pins of one `kind` press on.

    Attributes
    ----------
    name
        Name of its check.
    where
        Location in words.
    part
        Part whose material counts, such as ``gear``.
    kind
        Kind of contact whose force acts on the wall, such as ``output``.
    thickness
        Thickness [m].
    strength_ratio
        Strength of the wall over the yield strength of its material [1]: `TENSION` or `SHEAR`.
    """

    name: str
    where: str
    part: str
    kind: str
    thickness: float
    strength_ratio: float

    def stress(self, force: float, width: float) -> float:
        """Compute the stress [Pa] under a force [N] on a line of a width [m], which two sections carry."""
        return force / (2.0 * self.thickness * width)


def list_walls(reducer: Reducer) -> tuple[Wall, ...]:
    """Return the walls of disc and housing that pins press on, each with thickness [m] and `Wall.strength_ratio`."""
    design = reducer.design
    output, ring, gear = design.output, design.ring, design.gear
    hole_radius = output.hole_radius + design.clearance.output
    root_radius = ring.pin_circle_radius + design.modification.pin_circle - gear.eccentricity - reducer.profile_offset
    ring_root_radius = ring.pin_circle_radius + ring.pin_radius + design.socket_play
    if ring.kind == "nonpin":
        ring_root_radius = ring.pin_circle_radius - ring.pin_radius + 2.0 * gear.eccentricity
    hole_distance = 2.0 * (output.pin_circle_radius * math.sin(math.pi / output.pins) - hole_radius)
    hole_to_axis, hole_to_root = (
        output.pin_circle_radius - hole_radius,
        root_radius - output.pin_circle_radius - hole_radius,
    )
    housing_wall, tooth_pair = design.housing.outer_radius - ring_root_radius, design.tooth_pair
    return (
        Wall("hole_to_hole", "between neighbouring output holes", "gear", "output", hole_distance, TENSION),
        Wall(
            "hole_to_root", "between the output holes and the root of the lobes", "gear", "output", hole_to_root, SHEAR
        ),
        Wall(
            "bore_to_hole",
            "between the bore and the output holes",
            "gear",
            "output",
            hole_to_axis - gear.bore_radius - design.clearance.cam,
            SHEAR,
        ),
        Wall("housing_ligament", "of the housing outside the ring's teeth", "housing", tooth_pair, housing_wall, SHEAR),
    )


def _check_wall(loads: RatedLoad, wall: Wall) -> Check:
    """Return the check that no pin breaks through its wall by tension or shear, at the nominal torque.

    `loads` are those in static equilibrium. The remedies are a wider disc, or a material with a higher yield strength.
    """
    reducer, design = loads.reducer, loads.reducer.design

    def wall_stress(loads: RatedLoad) -> float:
        """Return the stress in the wall [Pa] under the largest force of its contacts."""
        return wall.stress(loads.peak_force(wall.kind), loads.reducer.design.line_length(wall.kind))

    stress = wall_stress(loads)
    material = design.material_of(wall.part)
    allowed_stress = wall.strength_ratio * material.yield_strength / STRENGTH.wall_safety
    is_passed = stress <= allowed_stress
    stress_kind = "tension" if wall.strength_ratio == TENSION else "shear"
    value_text, limit_text = value_and_limit(stress, "at most", allowed_stress, MEGAPASCAL)
    yield_strength_limit = Limit(
        f"{design.material_table(wall.part)}.yield_strength",
        "at least",
        material.yield_strength * stress / allowed_stress,
    )
    remedies = [] if is_passed else [_face_width_limit(reducer, wall_stress, allowed_stress, 1.0), yield_strength_limit]
    return Check(
        name=wall.name,
        passed=is_passed,
        got=f"{value_text} of {stress_kind}",
        limit=f"{limit_text} (the yield strength in {stress_kind} over {STRENGTH.wall_safety:g}, assumed)",
        why=f"the largest force there, {loads.peak_force(wall.kind):.4g} N, must not tear the wall of"
        f" {1e3 * wall.thickness:.4g} mm",
        severity="warning",
        key=f"the wall {wall.where}",
        **single_remedies(reducer, remedies),
        **numbers(stress, allowed_stress, MEGAPASCAL),
    )


def _newton_metres(torque: float) -> str:
    """Format a torque [N m]."""
    return f"{NEWTON_METRE.from_si(torque):.4g} N m"
