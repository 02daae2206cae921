"""What a sound design is, in a few numbers."""

import math
from dataclasses import dataclass

from cycloid_mj.base.errors import RunError
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.checks.rated_load import rated
from cycloid_mj.design import material_limits
from cycloid_mj.figures import figure
from cycloid_mj.figures.geometry import mass
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bodies import are_one_part

SLOW = 1e-6
"""Speed for a crank that stands still in its design [rad/s]: statics need a sense of rotation alone."""


@dataclass(frozen=True)
class Summary:
    """What a design is, by statics and closed forms.

    Attributes
    ----------
    ratio
        Turns of the crank in one of the output.
    discs, one_part
        Their number, and whether they are all one and the same part.
    outer_diameter
        Of the housing [m].
    mass
        Of all parts [kg].
    rated_torque
        On the output, that of the drive times the ratio [N m].
    loaded_teeth
        Contact lines with the ring that carry at the nominal torque, on average.
    pressure_angle
        Mean angle of their forces to the way that they turn the gear, weighted by force [rad].
    backlash
        Play of the output from stop to stop, mean over a turn of the crank [rad].
    capacity
        Torque on the output at which the first contact yields [N m]; NaN where the statics do not reach so far.
    weakest
        Kind of that contact.
    material_limits
        What materials of the library do not bear, a sentence each: heat, and of plastics a load that stays.
    """

    ratio: int
    discs: int
    one_part: bool
    outer_diameter: float
    mass: float
    rated_torque: float
    loaded_teeth: float
    pressure_angle: float
    backlash: float
    capacity: float
    weakest: str
    material_limits: tuple[str, ...]


def summary(reducer: Reducer) -> Summary:
    """Sum up a design that has no errors; errors as `rated`."""
    design = reducer.design
    state = rated(reducer)
    turning = reducer if design.drive.speed else reducer.but(drive={"speed": SLOW})
    weakest = max(design.pair_kinds, key=lambda kind: state.peak_pressure(kind) / reducer.contacts[kind].strength)
    return Summary(
        ratio=design.reduction,
        discs=design.gear.discs,
        one_part=are_one_part(design.gear.discs, design.output.pins, design.lobes),
        outer_diameter=2.0 * design.housing.outer_radius,
        mass=mass(reducer),
        rated_torque=design.rated_torque,
        loaded_teeth=state.loaded_teeth,
        pressure_angle=state.pressure_angle,
        backlash=ARCMINUTE * figure("backlash_arcmin").value(turning),
        capacity=_capacity(turning),
        weakest=weakest,
        material_limits=material_limits(design),
    )


def _capacity(reducer: Reducer) -> float:
    """Compute the torque at first yield [N m]; NaN where statics do not reach it."""
    try:
        return figure("capacity_nm").value(reducer)
    except RunError:
        return math.nan
