"""An emergency stop: the torque that is held once, without yield, dents, sheared or bent pins, or a jumped tooth."""

import math
from collections.abc import Iterator, Mapping

from cycloid_mj.base.errors import RunError
from cycloid_mj.checks.cam_rollers import cam_pressure_limit, has_bare_rollers
from cycloid_mj.design.materials import HARDNESS_PRESSURE, SHAKEDOWN_PRESSURE, YIELD_PRESSURE
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.loading import Loading
from cycloid_mj.life.strength import pin_moment
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import torque_at_pressure

KINDS = {
    "peak_yield": (
        "first yield, of plastics a lasting set",
        YIELD_PRESSURE,
        "surface_strength",
        "p0 = 1.79 Y, below a line (Johnson 1985, 4.4); of plastics 4 k = 2.31 Y",
    )
}
KINDS["peak_dents"] = (
    "lasting dents",
    HARDNESS_PRESSURE,
    "surface_tensile_strength",
    "p0 = 2.84 S, Brinell's (ISO 18265)",
)
"""Pressures that are held once: what happens beyond, over which strength, and its source."""


def peaks(reducer: Reducer, peak: float, worst: Loading) -> Iterator[RatedItem]:
    """Rate a peak torque [N m] by what each part holds once; forces go with the torque of the worst loading."""
    design = reducer.design
    torque = abs(worst.point.torque)
    for key, (what, factor, kind_of_strength, source) in KINDS.items():
        borne = {}
        for kind in worst.pressures:
            most = SHAKEDOWN_PRESSURE if reducer.contacts[kind].weaker_is_plastic else factor
            if kind != "cam" or design.gear.bearing == "plain":
                borne[kind] = most * min(getattr(part, kind_of_strength) for part in design.partners(kind))
            elif has_bare_rollers(reducer):  # a bought bearing has its static factor
                borne[kind] = cam_pressure_limit(reducer, most, kind_of_strength)
        if borne:
            held, note = _held(worst, borne)
            yield _torque_item(key, what, peak, held, source, note)
    output, material = design.output, design.material_of("output")
    radius, force = output.root_radius, float(worst.output.sum(axis=1).max()) * peak / torque
    planes = 1 if output.support == "cantilever" else 2
    shear, strength = force / (planes * math.pi * radius**2), material.yield_strength / math.sqrt(3.0)
    yield RatedItem(
        "peak_pin_shear",
        "emergency stop, shear of an output pin",
        1e-6 * shear,
        1e-6 * strength,
        "MPa",
        strength / shear if shear else math.inf,
        None,
        "F/(n pi r^2) against Y/sqrt(3)",
        f"{planes} x {1e3 * radius:.3g} mm radius; forces in proportion to the torque",
    )
    bent = 4.0 * float(pin_moment(reducer, worst.output).max()) * peak / torque / (math.pi * radius**3)
    yield RatedItem(
        "peak_pin_bending",
        "emergency stop, bending of an output pin",
        1e-6 * bent,
        1e-6 * material.yield_strength,
        "MPa",
        material.yield_strength / bent if bent else math.inf,
        None,
        "4 M/(pi r^3) against Y",
        "nominal stress: a notch yields, and holds once; forces in proportion to the torque",
    )
    jump = torque / (design.lobes * worst.wind_up) if worst.wind_up else math.inf
    yield _torque_item(
        "peak_jump",
        "jump of a tooth",
        peak,
        jump,
        "T = k/z: the top of a sine of one lobe's pitch, z lobes, that starts with the gear's stiffness k",
        "assumed: the ring does not widen; k of all contacts and the cam at the largest load",
    )


def _held(worst: Loading, borne: Mapping[str, float]) -> tuple[float, str]:
    """Find the torque [N m] at which a kind of contact first has the pressure that it bears [Pa], and tell how."""
    kind = min(borne, key=lambda one: borne[one] / worst.pressures[one])
    torque = math.copysign(worst.point.torque, worst.reducer.design.drive.speed)
    guess = torque * (borne[kind] / worst.pressures[kind]) ** 2
    try:
        held, kind = torque_at_pressure(worst.reducer, worst.springs, borne, guess)
    except RunError:
        return abs(guess), f"in {kind}; no balance was found there: the pressure goes with the root of the torque"
    return abs(held), f"in {kind}, by its own balance"


def _torque_item(key: str, what: str, peak: float, torque: float, source: str, note: str) -> RatedItem:
    return RatedItem(key, f"emergency stop, {what}", peak, torque, "N m", torque / peak, None, source, note)
