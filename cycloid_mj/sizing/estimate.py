"""Closed-form estimates of many candidates at once: the torque limit of each item, mass and length.

Teeth and output pins share the load as springs with the clearance of their pair, turned by the load only; the items
are those of ``life`` with the same limits. Their errors are corrected by rated candidates, see `search`.
"""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.units import ARCMINUTE, HOUR
from cycloid_mj.design import Design, stock
from cycloid_mj.design.materials import SHAKEDOWN_PRESSURE, YIELD_PRESSURE
from cycloid_mj.geometry.ideal_loads import contact_modulus
from cycloid_mj.life import rolling
from cycloid_mj.life.heat import heat_limits
from cycloid_mj.life.plastic_set import SET_POWER, SET_SHARE
from cycloid_mj.life.surfaces import AGMA_2001, pitting_limit
from cycloid_mj.parts.export.casing_rules import RULES
from cycloid_mj.parts.output import RIM
from cycloid_mj.reducer import Reducer
from cycloid_mj.sizing.candidates import TOLERANCE_SHARE, Sizes
from cycloid_mj.sizing.requirement import Requirement

ANGLES = 24
"""Angles of half a turn at which pins carry."""

LINE_STIFFNESS = 0.26
"""Stiffness of a line contact over E* times its length: Palmgren's, of steel at 50 N/mm."""

LOSSES = 2.0
"""All losses, with those of bearings and seals, over those of teeth, output pins and cams (median of 30 drives)."""

LUBRICANT_FACTOR = 0.7
"""Usual product of the factors of ISO 6336-2 for lubricant, speed and roughness, on the allowed pressure."""

TOOTH_ERROR = 3.0 * math.sqrt(3.0) * TOLERANCE_SHARE
"""Error of a critical tooth over the clearance: three standard deviations of position, radius and seat of its pin."""

ENDURANCE_SHARE = 0.35
"""Pulsating endurance limit over tensile strength, with size, surface and notch of a usual part (Shigley, 6-7)."""

LENGTH, MASS = np.array([1.1, 0.9, 2.5, 0.36]), np.array([1.3, 2.0, 5.2, 0.58])
"""Coefficients of the regressions of length and mass, of 210 drives of 10:1 to 100:1 and 40 to 300 mm.

They scatter by 8 % in length and 24 % in mass, with steel covers instead of the usual aluminium; ratings correct them.
"""

ROUNDS = 3
"""Evaluations at the torque of the one before, as shares of the load depend on it."""


Estimate = dict[str, Array]
"""Torque limits of n candidates by item [N m], and their `FIGURES`; shape (n,) each."""

FIGURES = ("mass", "length", "backlash")
"""Figures of an estimate that are no torque limits [kg, m, arcmin]."""


def estimate(requirement: Requirement, sizes: Sizes, design: Design) -> Estimate:
    """Estimate the torque limit of each item [N m], and mass, length and backlash (see `FIGURES`), of n candidates.

    Materials and friction are those of a `design` of one of the candidates. As the loads depend on the torque, a
    fixed-point iteration determines both. The limit ``other`` stands for all items that have no estimate: it is the
    smallest of the estimated limits, or 0 if the profile of the disc is undercut.
    """
    torque = np.full(sizes.circle.shape, 1e3 * requirement.diameter**3)
    for _ in range(ROUNDS):
        loads = _Loads.of(requirement, sizes, design, torque)
        limits = {**_surfaces(requirement, sizes, design, loads), **_bearings(requirement, sizes, loads)}
        limits |= _pins(sizes, design, loads, requirement.discs or 1)
        limits["temperature"] = _thermal_torque_limit(requirement, sizes, design, loads)
        torque = np.clip(np.min(list(limits.values()), axis=0), 1e-6, 1e7)
    limits["other"] = np.where(loads.sound, torque, 0.0)
    play = loads.play / loads.arm + (design.clearance.cam + design.clearance.output) / sizes.circle_out
    figures = {"mass": _mass(requirement, sizes, design), "length": _length(requirement, sizes)}
    return {**limits, **figures, "backlash": 2.0 * play / ARCMINUTE}


def capacity(guess: Estimate, but: tuple[str, ...] = ()) -> Array:
    """Return the smallest torque limit of each candidate [N m], shape (n,), without those of some items."""
    return np.asarray(np.min([limit for key, limit in guess.items() if key not in (*FIGURES, *but)], axis=0))


@dataclass(frozen=True, eq=False)
class _Loads:
    """Loads of candidates at a torque [N m], shape (n,): largest forces [N], pressures [Pa], losses [W].

    `play` is the clearance of a tooth [m], and `arm` the largest lever of its normal about the output's axis [m].
    """

    torque: Array
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
    def of(cls, requirement: Requirement, sizes: Sizes, design: Design, torque: Array) -> "_Loads":
        """Share the torque of each disc between teeth and output pins."""
        teeth, discs = requirement.ratio + 1, requirement.discs or 1
        angle = (np.arange(ANGLES) + 0.5) * math.pi / ANGLES
        circle, pin, ecc = sizes.circle[:, None], sizes.pin[:, None], sizes.eccentricity[:, None]
        k1 = ecc * teeth / circle
        reach = np.sqrt(1.0 + k1**2 - 2.0 * k1 * np.cos(angle))
        arm = ecc * requirement.ratio * np.sin(angle) / reach
        modulus = _modulus(design, "pin_gear")
        series = 0.5 if design.ring.has_sockets else 1.0
        play = design.clearance.pin_gear + design.pin_play
        stiffness = series * LINE_STIFFNESS * modulus * sizes.face
        force = _share(arm, 0.5 * teeth / ANGLES, stiffness, play, torque / discs)
        bend = circle * reach**3 / (1.0 + teeth * k1**2 - (teeth + 1) * k1 * np.cos(angle))
        curvature = np.maximum(1.0 / pin + 1.0 / (bend - pin), 1e-3)
        weight = 0.5 * teeth / ANGLES
        peak = _with_error(force, arm, weight, stiffness * TOOTH_ERROR * requirement.usual_clearance, torque / discs)
        tangential = weight * (force * np.sin(angle) / reach).sum(axis=1)
        radial = weight * (force * (np.cos(angle) - k1) / reach).sum(axis=1)
        count = sizes.count[:, None]
        line = LINE_STIFFNESS * _modulus(design, "output") * sizes.face
        bending = 192.0 * design.material_of("output").youngs_modulus * math.pi / 4.0 * sizes.core**4
        bending = bending / _stack(requirement, sizes) ** 3
        arm_out, compliance = sizes.circle_out[:, None] * np.sin(angle), 1.0 / line + 1.0 / np.maximum(bending, 1.0)
        pressed = _share(arm_out, 0.5 * count / ANGLES, 1.0 / compliance, design.clearance.output, torque / discs)
        pin_sum = (0.5 * count / ANGLES * pressed).sum(axis=1)
        speed = requirement.speed / requirement.ratio
        loss = weight * (force * np.abs(circle * reach - pin)).sum(axis=1) * speed * discs
        return cls(
            torque,
            peak.max(axis=1),
            np.sqrt((peak * curvature).max(axis=1) * modulus / (math.pi * sizes.face)),
            np.maximum(pressed.max(axis=1), 4.0 * torque / discs / (sizes.count * sizes.circle_out)),
            pin_sum,
            np.hypot(tangential, np.abs(radial) + pin_sum),
            loss,
            np.min(np.where(bend > 0.0, bend - pin - play, np.inf), axis=1) > 0.0,
            play,
            arm.max(axis=1),
        )


def _share(arm: Array, weight: float | Array, stiffness: Array, play: float, torque: Array) -> Array:
    """Compute the forces (n, m) [N] of m springs with clearance that balance a torque by a common rotation.

    Parameters
    ----------
    arm
        Lever arm of each spring [m], shape (n, m).
    weight
        Number of springs that each of them stands for [1].
    stiffness
        Stiffness of a spring of each candidate [N/m], shape (n,).
    play
        Clearance of all springs [m].
    torque
        Torque [N m], shape (n,).
    """
    active = np.ones_like(arm, bool)
    for _ in range(8):
        squares = (weight * active * arm**2).sum(axis=1)
        turn = (torque / stiffness + play * (weight * active * arm).sum(axis=1)) / np.maximum(squares, 1e-30)
        active = turn[:, None] * arm > play
    return stiffness[:, None] * np.maximum(turn[:, None] * arm - play, 0.0)


def _with_error(force: Array, arm: Array, weight: float, deflection_force: Array, torque: Array) -> Array:
    """Return the force [N] that each tooth (n, m) would have if it protruded by an error.

    `deflection_force` [N] presses a single tooth back by the error, shape (n,). The other loaded teeth share it, and
    no tooth carries more than the whole torque of the disc. `force` [N] are the forces without errors.
    """
    loaded = np.where(force > 0.0, arm, 0.0)
    largest = loaded.max(axis=1, keepdims=True)
    teeth = weight * (loaded**2).sum(axis=1, keepdims=True) / np.maximum(largest, 1e-12) ** 2
    extra = deflection_force[:, None] * np.maximum(1.0 - 1.0 / np.maximum(teeth, 1.0), 0.0)
    alone = torque[:, None] / np.maximum(largest, 1e-12)
    return np.where(force > 0.0, np.maximum(force, np.minimum(force + extra, alone)), 0.0)


def _modulus(design: Design, kind: str) -> float:
    first, second = design.partners(kind)
    return contact_modulus(first.youngs_modulus, first.poisson, second.youngs_modulus, second.poisson)


def _surfaces(requirement: Requirement, sizes: Sizes, design: Design, loads: _Loads) -> dict[str, Array]:
    """Compute the output torques [N m] that tooth and output pin pressures allow, by item, shape (n,) each.

    The limit is pitting of steel or permanent set of a plastic, and yield at twice the torque.
    """
    hole = sizes.stud + sizes.eccentricity
    curvature = 1.0 / np.maximum(sizes.stud, 1e-6) - 1.0 / np.maximum(hole, 1e-6)
    output = np.sqrt(loads.pin * curvature * _modulus(design, "output") / (math.pi * sizes.face))
    half_width = 2.0 * np.stack([loads.tooth / loads.tooth_pressure, loads.pin / output]) / (math.pi * sizes.face)
    travel = np.stack([(sizes.circle - sizes.pin) / requirement.ratio, hole])  # of the contact per radian of the crank
    loaded_shares = dict(zip(("pin_gear", "output"), half_width / (math.pi * travel), strict=True))
    limits = {}
    for kind, pressure in (("pin_gear", loads.tooth_pressure), ("output", output)):
        partners = design.partners(kind)
        strength = min(part.surface_strength for part in partners)
        if any(part.is_plastic for part in partners):
            loaded_hours = requirement.life * np.minimum(loaded_shares[kind], 1.0)
            allowed, key = SET_SHARE * SHAKEDOWN_PRESSURE * strength / loaded_hours**SET_POWER, f"{kind}_set"
        else:
            factor, power = AGMA_2001.factor, AGMA_2001.power
            cycles = requirement.speed / (2.0 * math.pi) * HOUR * requirement.life
            allowed = factor * min(pitting_limit(part)[0] for part in partners) / cycles**power
            key = f"{kind}_pitting"
        limits[key] = loads.torque * (allowed / np.maximum(pressure, 1.0)) ** 2
        if design.friction.law == "film" and key.endswith("pitting"):
            limits[f"{key}_lubricated"] = LUBRICANT_FACTOR**2 * limits[key]
        if kind == "pin_gear":
            factor = SHAKEDOWN_PRESSURE if key.endswith("set") else YIELD_PRESSURE
            limits["peak_yield"] = loads.torque * 0.5 * (factor * strength / np.maximum(pressure, 1.0)) ** 2
    return limits


def _bearings(requirement: Requirement, sizes: Sizes, loads: _Loads) -> dict[str, Array]:
    """Compute the output torques [N m] that bearings of cams, shaft, output and rollers allow, by item, (n,) each.

    The limits are their lives, and their static ratings at twice the torque.
    """
    discs, stack = requirement.discs or 1, _stack(requirement, sizes)
    hours = HOUR * requirement.life * requirement.speed / (2.0 * math.pi) / 1e6
    near, far = stack / 2.0 + 1.5 * sizes.disc + sizes.bearing, stack / 2.0 + sizes.disc + sizes.bearing / 2.0
    shaft, far_end = loads.cam * far / (near + far), loads.cam * near / (near + far)
    if discs > 1:
        shaft = far_end = loads.cam * (stack - sizes.face) / (near + far)
    room = sizes.circle + sizes.pin
    hubs = stock.thin_ball_bearings()
    wall = max(RULES.min_wall, RULES.wall_share * requirement.diameter / 2.0)
    rim = sizes.circle_out + (1.0 + RIM) * sizes.stud - wall
    index = np.minimum(
        np.searchsorted([bearing.outside for bearing in hubs], 2.0 * room, side="right") - 1,
        np.searchsorted([bearing.bore for bearing in hubs], 2.0 * rim, side="right") - 1,
    )
    dynamic, width, static = (
        np.array([getattr(bearing, key) for bearing in hubs])[np.maximum(index, 0)]
        for key in ("dynamic", "width", "static")
    )
    spacing = 1.5 * width
    lever = stack / 2.0 + sizes.disc + width / 2.0
    if discs == 1:
        inner, outer = loads.pin_sum * (lever + spacing) / spacing, loads.pin_sum * lever / spacing
    else:
        inner = outer = loads.pin_sum * (stack - sizes.face) / spacing
    hub = np.hypot(inner, shaft)
    roller, ball = 1.0 / rolling.EXPONENT, 1.0 / rolling.BALL_EXPONENT
    spins = np.maximum(sizes.eccentricity / np.maximum(sizes.stud, 1e-6), 1e-6)
    limits = {
        "cam_bearing": sizes.cam_dynamic / hours**roller / loads.cam,
        "cam_bearing_static": sizes.cam_static / (2.0 * loads.cam),
        "shaft_bearing_near": sizes.shaft_dynamic / hours**roller / shaft,
        "shaft_bearing_near_static": sizes.shaft_static / (2.0 * shaft),
        "output_bearing_inner": dynamic / (hours / requirement.ratio) ** ball / hub,
        "output_bearing_inner_static": static / (2.0 * hub),
        "output_bearing_outer": dynamic / (hours / requirement.ratio) ** ball / np.maximum(outer, 1e-6),
        "shaft_bearing_far": sizes.shaft_dynamic / hours**roller / np.maximum(far_end, 1e-6),
        "output_rollers": np.where(
            sizes.needle_dynamic > 0.0, sizes.needle_dynamic / (hours * spins) ** roller / (0.5 * loads.pin), 1e9
        ),
    }
    return {key: loads.torque * limit for key, limit in limits.items()}


def _stack(requirement: Requirement, sizes: Sizes) -> Array:
    discs = requirement.discs or 1
    return discs * sizes.face + (discs - 1) * 0.02 * requirement.diameter


def _pins(sizes: Sizes, design: Design, loads: _Loads, discs: int) -> dict[str, Array]:
    """Compute the output torques [N m] that output pins and the walls between holes allow, by item, shape (n,) each.

    The pins are beams clamped at both ends: limits are fatigue, and yield at twice the torque. `discs` is the number of
    discs.
    """
    material = design.material_of("output")
    span = discs * sizes.face
    bending = 4.0 * loads.pin * discs * span / 8.0 / (math.pi * np.maximum(sizes.core, 1e-6) ** 3)
    shear = loads.pin * discs / (2.0 * math.pi * np.maximum(sizes.core, 1e-6) ** 2)
    limits = {
        "output_pin_fatigue": ENDURANCE_SHARE * material.tensile_strength / bending,
        "peak_pin_bending": material.yield_strength / (2.0 * bending),
        "peak_pin_shear": material.yield_strength / math.sqrt(3.0) / (2.0 * shear),
    }
    hole, disc = sizes.stud + sizes.eccentricity, design.material_of("gear")
    root = sizes.circle - sizes.eccentricity - sizes.pin
    walls = {
        "hole_to_hole": 2.0 * (sizes.circle_out * np.sin(np.pi / sizes.count) - hole),
        "hole_to_root": root - sizes.circle_out - hole,
        "bore_to_hole": sizes.circle_out - hole - sizes.bore,
    }
    for name, thickness in walls.items():
        wall = np.maximum(thickness, 1e-6)
        stress = 0.75 * loads.pin / (sizes.face * wall) * np.maximum(2.0 * hole / wall, math.sqrt(3.0))
        limits[f"{name}_fatigue"] = ENDURANCE_SHARE * disc.tensile_strength / stress
    return {key: loads.torque * limit for key, limit in limits.items()}


def _thermal_torque_limit(requirement: Requirement, sizes: Sizes, design: Design, loads: _Loads) -> Array:
    """Estimate the output torque [N m] at which the housing of each candidate reaches its allowed temperature, (n,).

    The losses of teeth, output pins and cams are proportional to the torque; natural convection removes them from the
    cylinder of the housing.
    """
    discs = requirement.discs or 1
    sliding = design.friction.boundary if design.has_film else design.friction.output
    plain = sliding * sizes.core / np.maximum(sizes.stud, 1e-6)
    rolls = np.where(sizes.needle_dynamic > 0.0, design.friction.output_rolling, plain)
    lost = design.mesh_friction * loads.tooth_loss
    lost = lost + rolls * loads.pin_sum * sizes.eccentricity * requirement.speed * discs
    lost = lost + design.friction.cam_rolling * loads.cam * sizes.bore * requirement.speed * discs
    radius, service = requirement.diameter / 2.0, design.service
    area = 2.0 * math.pi * radius * (radius + _length(requirement, sizes))
    allowed = min(limit.temperature for limit in heat_limits(Reducer(design))) - service.ambient_temperature
    return np.asarray(
        loads.torque * allowed * service.film_coefficient * area / np.maximum(LOSSES * service.duty_share * lost, 1e-12)
    )


def _length(requirement: Requirement, sizes: Sizes) -> Array:
    """Estimate the length by its regression on discs, output disc, shaft bearing and outer radius."""
    parts = np.stack([_stack(requirement, sizes), sizes.disc, sizes.bearing, 0.0 * sizes.disc + requirement.diameter])
    return np.asarray(LENGTH @ parts)


def _mass(requirement: Requirement, sizes: Sizes, design: Design) -> Array:
    """Estimate the mass by its regression on the volumes of ring, disc, cam, and covers."""
    radius, inner, stack = requirement.diameter / 2.0, sizes.circle - sizes.pin, _stack(requirement, sizes)
    rings = (sizes.outer**2 - inner**2) * stack, (inner**2 - sizes.bore**2) * stack, sizes.bore**2 * stack
    covers = radius**2 * (_length(requirement, sizes) - stack)
    return np.asarray(design.material_of("housing").density * math.pi * (MASS @ np.stack([*rings, covers])))
