"""Emergency stops: the torque without yield, dents, sheared or bent pins, or a skipped tooth."""

import math
from collections.abc import Iterator, Mapping

from cycloid_mj.base.errors import RunError
from cycloid_mj.checks.cam_rollers import cam_pressure_limit, has_bare_rollers
from cycloid_mj.design.materials import HARDNESS_PRESSURE, SHAKEDOWN_PRESSURE, YIELD_PRESSURE
from cycloid_mj.life.item import RatedItem, torque_item
from cycloid_mj.life.loading import Loading
from cycloid_mj.life.strength import pin_moment
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import torque_at_pressure

KINDS = {
    "peak_yield": (
        "first yield, or permanent set of plastics",
        YIELD_PRESSURE,
        "surface_strength",
        "p0 = 1.79 Y, below a line (Johnson 1985, 4.4); plastics 4 k = 2.31 Y",
    ),
    "peak_dents": ("dents", HARDNESS_PRESSURE, "surface_tensile_strength", "p0 = 2.84 S, Brinell (ISO 18265)"),
}
"""Pressure limits of an emergency stop: consequence, factor, strength that it multiplies, and source."""

FAR_BEYOND = 2.0
"""Ratio of a torque by the square root law to the smallest other limit, from which no equilibrium is sought
(heuristic)."""


def rate_emergency_stop(reducer: Reducer, peak_torque: float, worst: Loading) -> Iterator[RatedItem]:
    """Yield the safety factors of all parts at the peak torque [N m] of an emergency stop.

    The items are shear and bending of an output pin, skipping of a tooth, and yield and dents at contacts. Forces on
    output pins are scaled in proportion to the torque from `worst`, the solved forces at the largest torque of the
    duty. Torque limits by contact pressure follow from the static equilibrium at the limit.
    """
    design = reducer.design
    torque = abs(worst.point.torque)
    output, material = design.output, design.material_of("output")
    radius, force = output.root_radius, float(worst.output.sum(axis=1).max()) * peak_torque / torque
    shear_planes = 1 if output.support == "cantilever" else 2
    shear_stress = force / (shear_planes * math.pi * radius**2)
    shear_strength = material.yield_strength / math.sqrt(3.0)
    pin_shear = RatedItem(
        "peak_pin_shear",
        "emergency stop: shear of an output pin",
        1e-6 * shear_stress,
        1e-6 * shear_strength,
        "MPa",
        shear_strength / shear_stress if shear_stress else math.inf,
        None,
        "F/(n pi r^2) against Y/sqrt(3)",
        f"shear planes: {shear_planes}, radius {1e3 * radius:.3g} mm; forces in proportion to the torque",
    )
    bending_stress = 4.0 * float(pin_moment(reducer, worst.output).max()) * peak_torque / torque / (math.pi * radius**3)
    pin_bending = RatedItem(
        "peak_pin_bending",
        "emergency stop: bending of an output pin",
        1e-6 * bending_stress,
        1e-6 * material.yield_strength,
        "MPa",
        material.yield_strength / bending_stress if bending_stress else math.inf,
        None,
        "4 M/(pi r^3) against Y",
        "nominal stress, because a notch yields locally without failure; forces in proportion to the torque",
    )
    tooth_skipping = torque_item(
        "peak_jump",
        "emergency stop: skipped tooth",
        peak_torque,
        torque / (design.lobes * worst.wind_up) if worst.wind_up else math.inf,
        "T = k/z: maximum of a sine with the pitch of one of z lobes and the initial stiffness k of the disc",
        "assumed: a rigid ring; k of all contacts and the cam at the largest load",
    )
    items, solved = [pin_shear, pin_bending, tooth_skipping], dict[frozenset[tuple[str, float]], tuple[float, str]]()
    for key, (consequence, pressure_factor, strength_name, source) in KINDS.items():
        limits = {}
        for kind in worst.pressures:
            limit_factor = SHAKEDOWN_PRESSURE if reducer.contacts[kind].weaker_is_plastic else pressure_factor
            if kind != "cam" or design.gear.bearing == "plain":
                limits[kind] = limit_factor * min(getattr(part, strength_name) for part in design.partners(kind))
            elif has_bare_rollers(reducer):  # a bought bearing has its static factor
                limits[kind] = cam_pressure_limit(reducer, limit_factor, strength_name)
        if limits:
            other_limit = peak_torque * min(item.margin(0.0) for item in items)
            torque_limit, note = _torque_at_limits(worst, limits, other_limit, solved)
            items.append(torque_item(key, f"emergency stop: {consequence}", peak_torque, torque_limit, source, note))
    yield from items


def _torque_at_limits(
    worst: Loading,
    limits: Mapping[str, float],
    other_limit: float,
    solved: dict[frozenset[tuple[str, float]], tuple[float, str]],
) -> tuple[float, str]:
    """Compute the output torque [N m] at which a kind of contact first reaches its pressure limit.

    The law p ~ sqrt(T) is a lower bound of that torque, since more contacts share a larger torque. If the bound is more
    than `FAR_BEYOND` times `other_limit`, the bound itself is returned, since there may be no equilibrium.

    Parameters
    ----------
    worst
        Solved forces at the largest torque of the duty.
    limits
        Pressure limit of each kind of contact [Pa], such as {"pin_gear": 2e9}; not empty.
    other_limit
        Smallest torque of the other limits [N m].
    solved
        Results of earlier calls, by the set of the items of `limits`, to which this result is added: yield and dents of
        most plastics have the same limits.

    Returns
    -------
    tuple
        The torque [N m], and a text with the kind of contact and how the torque was computed.
    """
    kind = min(limits, key=lambda pair_kind: limits[pair_kind] / worst.pressures[pair_kind])
    torque = math.copysign(worst.point.torque, worst.reducer.design.drive.speed)
    estimated_torque = torque * (limits[kind] / worst.pressures[kind]) ** 2
    root_note = "the pressure is assumed to grow with the square root of the torque"
    if abs(estimated_torque) > max(FAR_BEYOND * other_limit, abs(torque)):
        return abs(estimated_torque), f"in {kind}, lower bound: {root_note}; another limit of the stop is far below"
    limit_set = frozenset(limits.items())
    try:
        if limit_set not in solved:
            solved[limit_set] = torque_at_pressure(worst.reducer, worst.springs, limits, estimated_torque)
    except RunError:
        return abs(estimated_torque), f"in {kind}; no equilibrium was found there: {root_note}"
    limit_torque, kind = solved[limit_set]
    return abs(limit_torque), f"in {kind}, by the equilibrium at that torque"
