"""Closed-form estimates of many similar drives at once: the torque limit of each item of a rating, mass and length.

Teeth and output pins share the load as springs with clearance; one of them, the critical one, protrudes. Items and
limits are those of `life.items.rate`, which needs some 10^4 times the time of an estimate.
"""

import math
from dataclasses import dataclass
from functools import cache
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.units import ARCMINUTE, HOUR
from cycloid_mj.design import Design, stock
from cycloid_mj.design.materials import MATERIALS, SHAKEDOWN_PRESSURE, YIELD_PRESSURE
from cycloid_mj.geometry.ideal_loads import contact_modulus
from cycloid_mj.life import rolling
from cycloid_mj.life.heat import heat_limits
from cycloid_mj.life.plastic_set import SET_POWER, SET_SHARE
from cycloid_mj.life.surfaces import AGMA_2001, pitting_limit
from cycloid_mj.lubrication.bearings import seal_torque
from cycloid_mj.parts.export.casing import LIGHT_METAL
from cycloid_mj.parts.export.casing_rules import RULES
from cycloid_mj.parts.output import RIM
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.film import ASSUMED, RollerBearings, cam_mean_diameter, idle_torque_of
from cycloid_mj.statics.load_sharing import protruding_forces, share_torque

ANGLES = 24
"""Angles of half a turn at which pins carry (heuristic)."""

LINE_STIFFNESS = 0.26
"""Stiffness of a line contact over E* times its length: Palmgren's, of steel at 50 N/mm."""

LUBRICANT_FACTOR = 0.86
"""Product of the factors of ISO 6336-2 for lubricant, speed and roughness, on the allowed pressure (heuristic: median
of ratings of 100 drives)."""

CRITICAL = 3.0
"""Errors of the critical tooth (position and radius of its pin), output pin and disc, in standard deviations
(heuristic).

At the 95 % percentile, the largest of 30 normal errors is 3.1 standard deviations."""

ENDURANCE_SHARE = 0.35
"""Pulsating endurance limit over tensile strength, with size, surface and notch of a usual part (Shigley, 6-7)."""

LENGTH, MASS = np.array([0.9, 1.56, 0.34, 0.015]), np.array([0.38, 1.6, 2.5, 0.66, 0.5])
"""Coefficients of the regressions of length and mass, of 384 drives of 11:1 to 100:1 and 50 to 300 mm.

They scatter by 5 % in length and 14 % in mass; ratings correct them.
"""

FIRST_TORQUE = 1e3
"""Torque at which estimates begin, over the cube of the diameter [N/m2] (heuristic); the largest torques are 2.5 to
40 times it."""

ROUNDS = 5
"""Evaluations at the torque of the one before, as shares of the load depend on it (heuristic)."""


Sizes = np.recarray[Any, Any]
"""Sizes of n candidates [m], shape (n,), or of one; load ratings in [N]. Its fields are those of `SIZES`."""

SIZES = (
    *("outer", "circle", "pin", "eccentricity", "face"),
    *("bore", "cam_dynamic", "cam_static"),
    *("shaft", "bearing", "shaft_dynamic", "shaft_static"),
    *("count", "circle_out", "stud", "core", "needle_dynamic", "disc"),
)
"""Outer radius of the ring, pin circle, pins, eccentricity, face width of a disc; bore of the disc with the ratings of
its bearing; shaft, width and ratings of its bearings; number, circle, radius, core and needles (0: plain) of the output
pins, and thickness of the output disc."""

SIZES_DTYPE = np.dtype([(name, float) for name in SIZES])

Estimate = dict[str, Array]
"""Torque limits of n candidates by item [N m], and their `FIGURES`; shape (n,) each."""

FIGURES = ("mass", "length", "backlash")
"""Figures of an estimate that are no torque limits [kg, m, arcmin]."""


def estimate(sizes: Sizes, design: Design, diameter: float, deviation: float) -> Estimate:
    """Estimate torque limits [N m], mass, length and backlash of n candidate drives, without solving statics.

    The result has a torque limit for each item, a part with a kind of failure, under the item's key in a rating, such
    as ``cam_bearing``, and the other quantities under the keys `FIGURES`. As the loads depend on the torque, a
    fixed-point iteration determines both. The limit ``other`` stands for all items that have no estimate: it is the
    smallest of the estimated limits, or 0 if the profile of the disc is undercut. The backlash is that of the nominal
    clearances, without errors.

    Parameters
    ----------
    sizes
        Dimensions of the candidates.
    design
        Design with the teeth, discs, materials, clearances, friction and operating conditions of all candidates.
    diameter
        Outer diameter of the drives with their covers [m].
    deviation
        Standard deviation of the manufacturing errors, the same for all dimensions [m].
    """
    # attributes of a record array take longer than the arithmetic
    sizes = cast(Sizes, SimpleNamespace(**{name: np.array(sizes[name]) for name in SIZES}))
    torque = np.full(sizes.circle.shape, FIRST_TORQUE * diameter**3)
    for _ in range(ROUNDS):
        loads = _Loads.compute(sizes, design, deviation, torque)
        limits = {
            **_surface_torque_limits(sizes, design, loads),
            **_bearing_torque_limits(sizes, design, loads, diameter),
        }
        limits |= _pin_torque_limits(sizes, design, loads)
        limits["temperature"] = _thermal_torque_limit(sizes, design, loads, diameter)
        torque = np.clip(np.min(list(limits.values()), axis=0), 1e-6, 1e7)
    limits["other"] = np.where(loads.sound, torque, 0.0)
    half_backlash = loads.play / loads.arm + (design.clearance.cam + design.clearance.output) / sizes.circle_out
    figures = {"mass": _estimate_mass(sizes, design, diameter), "length": _length(sizes, design, diameter)}
    return {**limits, **figures, "backlash": 2.0 * half_backlash / ARCMINUTE}


def capacity(guess: Estimate, but: tuple[str, ...] = ()) -> Array:
    """Return the smallest torque limit of each candidate [N m], shape (n,), without those of some items."""
    return np.asarray(np.min([limit for key, limit in guess.items() if key not in (*FIGURES, *but)], axis=0))


def add_capacity(figures: Estimate) -> Estimate:
    """Return quantities of candidates with the key ``capacity``, their smallest torque limit (at least 1e-9 N m)."""
    limits = {key: values for key, values in figures.items() if key != "capacity"}
    return {**limits, "capacity": np.maximum(capacity(limits), 1e-9)}


@dataclass(frozen=True, eq=False)
class _Loads:
    """Loads of the critical disc of n candidates within their tolerances, at an output torque [N m], shape (n,) each.

    Attributes
    ----------
    torque
        Output torque [N m].
    disc_share
        Share of the torque that the disc carries, as its errors let it lead the others.
    tooth, tooth_pressure, pin
        Largest force on a tooth [N], largest pressure on one [Pa], and largest force on an output pin [N].
    pin_sum, cam
        Force on all output pins, and on the cam [N].
    tooth_loss
        Power of the sliding of all teeth over their coefficient of friction [W].
    sound
        Whether the disc is not undercut.
    play, arm
        Clearance of a tooth [m], and largest lever arm of its normal about the axis of the output [m].
    """

    torque: Array
    disc_share: Array
    tooth: Array
    tooth_pressure: Array
    pin: Array
    pin_sum: Array
    cam: Array
    tooth_loss: Array
    sound: Mask
    play: float
    arm: Array

    @classmethod
    def compute(cls, sizes: Sizes, design: Design, deviation: float, torque: Array) -> "_Loads":
        """Compute the loads on the critical disc of n candidate drives at their output torques [N m], shape (n,).

        The critical disc carries the largest share of the torque, because its errors let it lead the other discs. Its
        teeth share this part like springs in parallel, and so do its output pins. `sizes` are the dimensions of the
        candidates, `design` has what they have in common, and `deviation` is the standard deviation of their dimensions
        [m]. The result has the forces on teeth, output pins and cam, and pressure and sliding of the teeth.
        """
        tooth_count, disc_count = design.ring.teeth, design.gear.discs
        angle = (np.arange(ANGLES) + 0.5) * math.pi / ANGLES
        circle_radius, pin_radius, eccentricity = sizes.circle[:, None], sizes.pin[:, None], sizes.eccentricity[:, None]
        k1 = eccentricity * tooth_count / circle_radius
        relative_distance = np.sqrt(1.0 + k1**2 - 2.0 * k1 * np.cos(angle))
        arm = eccentricity * design.lobes * np.sin(angle) / relative_distance
        pin_arm = sizes.circle_out[:, None] * np.sin(angle)
        series_factor = 0.5 if design.ring.has_sockets else 1.0
        tooth_clearance = design.clearance.pin_gear + design.pin_play
        line_stiffness = LINE_STIFFNESS * _modulus(design, "output") * sizes.face
        bending_stiffness = 192.0 * design.material_of("output").youngs_modulus * math.pi / 4.0 * sizes.core**4
        bending_stiffness = bending_stiffness / _stack(sizes, design) ** 3
        contacts_per_angle = np.full(sizes.count.shape, 0.5 * tooth_count / ANGLES), 0.5 * sizes.count / ANGLES
        modulus = _modulus(design, "pin_gear")
        tooth_springs = (
            arm,
            contacts_per_angle[0],
            series_factor * LINE_STIFFNESS * modulus * sizes.face,
            tooth_clearance,
        )
        pin_springs = (
            pin_arm,
            contacts_per_angle[1],
            1.0 / (1.0 / line_stiffness + 1.0 / np.maximum(bending_stiffness, 1.0)),
            design.clearance.output,
        )
        torsional_stiffness = [
            share_torque(*springs, torque / disc_count)[1] for springs in (tooth_springs, pin_springs)
        ]
        lead_torque = (
            CRITICAL * deviation / arm.max(axis=1) / (1.0 / torsional_stiffness[0] + 1.0 / torsional_stiffness[1])
        )
        disc_share = np.minimum(1.0 / disc_count + (1.0 - 1.0 / disc_count) * lead_torque / torque, 1.0)
        # a thicker pin in a socket closes both its gaps
        tooth_deviation = math.sqrt(5.0 if design.ring.has_sockets else 2.0) * deviation
        tooth_force, pin_force = (
            share_torque(*springs, disc_share * torque)[0] for springs in (tooth_springs, pin_springs)
        )
        peak_force = protruding_forces(*tooth_springs, disc_share * torque, CRITICAL * tooth_deviation)
        peak_pin_force = protruding_forces(*pin_springs, disc_share * torque, CRITICAL * deviation)
        path_radius = (
            circle_radius * relative_distance**3 / (1.0 + tooth_count * k1**2 - (tooth_count + 1) * k1 * np.cos(angle))
        )
        curvature = np.maximum(1.0 / pin_radius + 1.0 / (path_radius - pin_radius), 1e-3)
        tangential_force = contacts_per_angle[0] * (tooth_force * np.sin(angle) / relative_distance).sum(axis=1)
        radial_force = contacts_per_angle[0] * (tooth_force * (np.cos(angle) - k1) / relative_distance).sum(axis=1)
        pin_sum = contacts_per_angle[1] * pin_force.sum(axis=1)
        speed = design.drive.speed / design.lobes
        return cls(
            torque,
            disc_share,
            peak_force.max(axis=1),
            np.sqrt((peak_force * curvature).max(axis=1) * modulus / (math.pi * sizes.face)),
            peak_pin_force.max(axis=1),
            pin_sum,
            np.hypot(tangential_force, np.abs(radial_force) + pin_sum),
            contacts_per_angle[0]
            * (tooth_force * np.abs(circle_radius * relative_distance - pin_radius)).sum(axis=1)
            * speed
            / disc_share,
            np.min(np.where(path_radius > 0.0, path_radius - pin_radius - tooth_clearance, np.inf), axis=1) > 0.0,
            tooth_clearance,
            arm.max(axis=1),
        )


def _modulus(design: Design, kind: str) -> float:
    first, second = design.partners(kind)
    return contact_modulus(first.youngs_modulus, first.poisson, second.youngs_modulus, second.poisson)


def _surface_torque_limits(sizes: Sizes, design: Design, loads: _Loads) -> dict[str, Array]:
    """Compute the output torques [N m] of n candidates allowed by the pressures on teeth and output pins.

    The result has an array (n,) by key of the item, such as ``output_pitting``. Limits are pitting of steel (also
    lubricated) or permanent set of a plastic, and yield at twice the output torque. `sizes` are the dimensions of the
    candidates, and `loads` their loads at `loads.torque`.
    """
    hole_radius = sizes.stud + sizes.eccentricity
    curvature = 1.0 / np.maximum(sizes.stud, 1e-6) - 1.0 / np.maximum(hole_radius, 1e-6)
    pin_pressure = np.sqrt(loads.pin * curvature * _modulus(design, "output") / (math.pi * sizes.face))
    half_width = 2.0 * np.stack([loads.tooth / loads.tooth_pressure, loads.pin / pin_pressure]) / (math.pi * sizes.face)
    travel_radius = np.stack(
        [(sizes.circle - sizes.pin) / design.lobes, hole_radius]
    )  # of the contact per radian of the crank
    loaded_shares = dict(zip(("pin_gear", "output"), half_width / (math.pi * travel_radius), strict=True))
    limits = {}
    for kind, pressure in (("pin_gear", loads.tooth_pressure), ("output", pin_pressure)):
        partners = design.partners(kind)
        strength = min(part.surface_strength for part in partners)
        if any(part.is_plastic for part in partners):
            loaded_hours = design.service.life * np.minimum(loaded_shares[kind], 1.0)
            allowed_pressure, key = SET_SHARE * SHAKEDOWN_PRESSURE * strength / loaded_hours**SET_POWER, f"{kind}_set"
        else:
            pressure_factor, power = AGMA_2001.factor, AGMA_2001.power
            cycles = design.drive.speed / (2.0 * math.pi) * HOUR * design.service.life
            allowed_pressure = pressure_factor * min(pitting_limit(part)[0] for part in partners) / cycles**power
            key = f"{kind}_pitting"
        limits[key] = loads.torque * (allowed_pressure / np.maximum(pressure, 1.0)) ** 2
        if design.friction.law == "film" and key.endswith("pitting"):
            limits[f"{key}_lubricated"] = LUBRICANT_FACTOR**2 * limits[key]
        if kind == "pin_gear":
            pressure_factor = SHAKEDOWN_PRESSURE if key.endswith("set") else YIELD_PRESSURE
            limits["peak_yield"] = loads.torque * 0.5 * (pressure_factor * strength / np.maximum(pressure, 1.0)) ** 2
    return limits


def _bearing_torque_limits(sizes: Sizes, design: Design, loads: _Loads, diameter: float) -> dict[str, Array]:
    """Compute the output torques [N m] of n candidates allowed by the bearings of cams, shaft, output and rollers.

    The result has an array (n,) by key of the item. Keys such as ``cam_bearing`` have the torque at which the bearing
    just reaches the required life, keys such as ``cam_bearing_static`` half the torque at which the load is its static
    rating. `sizes` are the dimensions of n candidate drives, and `loads` their loads at `loads.torque`. `diameter` is
    the outer diameter of the drives with covers [m]; the thinnest wall, and so the output bearing, depends on it.
    """
    disc_count, stack_width = design.gear.discs, _stack(sizes, design)
    megaturns = HOUR * design.service.life * design.drive.speed / (2.0 * math.pi) / 1e6
    near_arm = stack_width / 2.0 + 1.5 * sizes.disc + sizes.bearing
    far_arm = stack_width / 2.0 + sizes.disc + sizes.bearing / 2.0
    near_load, far_load = loads.cam * far_arm / (near_arm + far_arm), loads.cam * near_arm / (near_arm + far_arm)
    if disc_count > 1:
        near_load = far_load = loads.cam * (stack_width - sizes.face) / (near_arm + far_arm)
    max_outer_radius = sizes.circle + sizes.pin
    hub_bearings = _hub_bearings()
    min_wall = max(RULES.min_wall, RULES.wall_share * diameter / 2.0)
    min_bore = sizes.circle_out + (1.0 + RIM) * sizes.stud - min_wall
    hub_index = np.minimum(
        np.searchsorted(hub_bearings["outside"], 2.0 * max_outer_radius, side="right") - 1,
        np.searchsorted(hub_bearings["bore"], 2.0 * min_bore, side="right") - 1,
    )
    dynamic_rating, width, static_rating, bore, outer_diameter = (
        hub_bearings[key][np.maximum(hub_index, 0)] for key in ("dynamic", "width", "static", "bore", "outside")
    )
    is_plastic = design.material_of("gear").is_plastic
    spacing = (
        1.5 * width if is_plastic else width + 0.5 * (bore + outer_diameter) * math.tan(stock.ANGULAR_CONTACT.angle)
    )
    lever = stack_width / 2.0 + sizes.disc + width / 2.0
    if disc_count == 1:
        inner_load, outer_load = loads.pin_sum * (lever + spacing) / spacing, loads.pin_sum * lever / spacing
    else:
        inner_load = outer_load = loads.pin_sum * (stack_width - sizes.face) / spacing
    hub_load = np.hypot(inner_load, near_load)
    roller_exponent, ball_exponent = 1.0 / rolling.EXPONENT, 1.0 / rolling.BALL_EXPONENT
    spin_ratios = np.maximum(sizes.eccentricity / np.maximum(sizes.stud, 1e-6), 1e-6)
    limits = {
        "cam_bearing": sizes.cam_dynamic / megaturns**roller_exponent / loads.cam,
        "cam_bearing_static": sizes.cam_static / (2.0 * loads.cam),
        "shaft_bearing_near": sizes.shaft_dynamic / megaturns**roller_exponent / near_load,
        "shaft_bearing_near_static": sizes.shaft_static / (2.0 * near_load),
        "output_bearing_inner": dynamic_rating / (megaturns / design.lobes) ** ball_exponent / hub_load,
        "output_bearing_inner_static": static_rating / (2.0 * hub_load),
        "output_bearing_outer": dynamic_rating
        / (megaturns / design.lobes) ** ball_exponent
        / np.maximum(outer_load, 1e-6),
        "shaft_bearing_far": sizes.shaft_dynamic / megaturns**roller_exponent / np.maximum(far_load, 1e-6),
        "output_rollers": np.where(
            sizes.needle_dynamic > 0.0,
            sizes.needle_dynamic / (megaturns * spin_ratios) ** roller_exponent / (0.5 * loads.pin),
            1e9,
        ),
    }
    return {key: loads.torque * limit for key, limit in limits.items()}


@cache
def _hub_bearings() -> dict[str, Array]:
    """Return the sizes [m] and load ratings [N] of the thin ball bearings in stock by key, the smallest first."""
    keys = "dynamic", "width", "static", "bore", "outside"
    return {key: np.array([getattr(bearing, key) for bearing in stock.thin_ball_bearings()]) for key in keys}


def _stack(sizes: Sizes, design: Design) -> Array:
    disc_count = design.gear.discs
    return disc_count * sizes.face + (disc_count - 1) * design.gear.disc_gap


def _pin_torque_limits(sizes: Sizes, design: Design, loads: _Loads) -> dict[str, Array]:
    """Compute the output torques [N m] of n candidates allowed by output pins and by the walls between holes.

    The result has an array (n,) by key of the item, such as ``output_pin_fatigue``. The pins are beams clamped at both
    ends: limits are fatigue, and yield at twice the output torque. `sizes` are the dimensions of the candidates, and
    `loads` their loads at `loads.torque`.
    """
    material, disc_count = design.material_of("output"), design.gear.discs
    span = disc_count * sizes.face
    bending_stress = 4.0 * loads.pin * disc_count * span / 8.0 / (math.pi * np.maximum(sizes.core, 1e-6) ** 3)
    shear_stress = loads.pin * disc_count / (2.0 * math.pi * np.maximum(sizes.core, 1e-6) ** 2)
    limits = {
        "output_pin_fatigue": ENDURANCE_SHARE * material.tensile_strength / bending_stress,
        "peak_pin_bending": material.yield_strength / (2.0 * bending_stress),
        "peak_pin_shear": material.yield_strength / math.sqrt(3.0) / (2.0 * shear_stress),
    }
    hole_radius, disc_material = sizes.stud + sizes.eccentricity, design.material_of("gear")
    root_radius = sizes.circle - sizes.eccentricity - sizes.pin
    wall_thicknesses = {
        "hole_to_hole": 2.0 * (sizes.circle_out * np.sin(np.pi / sizes.count) - hole_radius),
        "hole_to_root": root_radius - sizes.circle_out - hole_radius,
        "bore_to_hole": sizes.circle_out - hole_radius - sizes.bore,
    }
    for name, thickness in wall_thicknesses.items():
        positive_thickness = np.maximum(thickness, 1e-6)
        stress = (
            0.75
            * loads.pin
            / (sizes.face * positive_thickness)
            * np.maximum(2.0 * hole_radius / positive_thickness, math.sqrt(3.0))
        )
        limits[f"{name}_fatigue"] = ENDURANCE_SHARE * disc_material.tensile_strength / stress
    return {key: loads.torque * limit for key, limit in limits.items()}


def _thermal_torque_limit(sizes: Sizes, design: Design, loads: _Loads, diameter: float) -> Array:
    """Estimate the output torque [N m] of n candidates at which the housing reaches its allowed temperature, (n,).

    The losses of teeth, output pins and cams are proportional to the torque; those of the seal of the crank and of the
    lubricant in the cams are constant. Convection removes them from the cylinder of the housing.

    `sizes` are the dimensions of the candidates, `design` has what they have in common, and `loads` are their loads at
    some torque.
    """
    reducer = Reducer(design)
    friction, speed = design.friction, design.drive.speed
    plain_friction = (
        (friction.boundary if design.has_film else friction.output) * sizes.core / np.maximum(sizes.stud, 1e-6)
    )
    pin_friction = np.where(sizes.needle_dynamic > 0.0, friction.output_rolling, plain_friction)
    cam_friction = ASSUMED.roller_load_factor if design.has_film else friction.cam_rolling
    friction_moment = pin_friction * loads.pin_sum * sizes.eccentricity + cam_friction * loads.cam * sizes.bore
    loss = design.mesh_friction * loads.tooth_loss + friction_moment / loads.disc_share * speed
    if design.has_film:
        cam_diameter = cam_mean_diameter(reducer) / design.gear.bore_radius * sizes.bore
        cam_idle_torque = (
            idle_torque_of(reducer, RollerBearings("cam", design.gear.discs, 1.0, speed)) * cam_diameter**3
        )
        loss = loss + speed * (cam_idle_torque + seal_torque(2.0 * sizes.shaft))
    radius, service = diameter / 2.0, design.service
    area = 2.0 * math.pi * radius * (radius + _length(sizes, design, diameter))
    max_rise = min(limit.temperature for limit in heat_limits(reducer)) - service.ambient_temperature
    return np.asarray(
        loads.torque * max_rise * service.film_coefficient * area / np.maximum(service.duty_share * loss, 1e-12)
    )


def _length(sizes: Sizes, design: Design, diameter: float) -> Array:
    """Estimate the length of n candidates [m], shape (n,), by a regression on discs, shaft bearing and diameter."""
    terms = _stack(sizes, design), sizes.bearing, diameter, 1.0
    return np.asarray(LENGTH @ np.stack(np.broadcast_arrays(*terms)))


def _estimate_mass(sizes: Sizes, design: Design, diameter: float) -> Array:
    """Estimate the mass of n candidates [kg], shape (n,), as a weighted sum of the masses of five simplified parts.

    These are ring, discs, cams, covers and output discs; their weights `MASS` follow from a regression. `sizes` are the
    dimensions of the candidates, `design` has their materials, and `diameter` [m] is their outer diameter.
    """
    radius, inner_radius, stack_width = diameter / 2.0, sizes.circle - sizes.pin, _stack(sizes, design)
    ring_density, disc_density, shaft_density, output_density = (
        design.material_of(part).density for part in ("housing", "gear", "shaft", "output")
    )
    light_density = MATERIALS[LIGHT_METAL].density
    cover_term = (
        (light_density if ring_density > 2.0 * light_density else ring_density)
        * radius**2
        * (_length(sizes, design, diameter) - stack_width)
    )
    ring_and_disc_terms = (
        ring_density * (sizes.outer**2 - inner_radius**2) * stack_width,
        disc_density * (inner_radius**2 - sizes.bore**2) * stack_width,
    )
    terms = (
        *ring_and_disc_terms,
        shaft_density * sizes.bore**2 * stack_width,
        cover_term,
        2.0 * output_density * sizes.circle_out**2 * sizes.disc,
    )
    return np.asarray(math.pi * (MASS @ np.stack(terms)))
