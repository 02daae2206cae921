"""Summary of a design that can be built."""

import math
from dataclasses import dataclass

from cycloid_mj.base.errors import RunError
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.checks.rated_load import rated_load
from cycloid_mj.design import describe_plastic_limits
from cycloid_mj.figures import figure
from cycloid_mj.figures.geometry import mass
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bodies import are_discs_identical

CREEP_SPEED = 1e-6
"""Crank speed for statics of a design whose crank does not turn [rad/s]: only its sign matters."""


@dataclass(frozen=True)
class Summary:
    """Main figures of a design, by statics and closed forms.

    Attributes
    ----------
    ratio
        Turns of the crank per turn of the output.
    discs, one_part
        Number of discs, and whether all are the same part.
    outer_diameter
        Outer diameter of the housing [m].
    mass
        Mass of all parts [kg].
    rated_torque
        Nominal torque, that of the motor times the ratio [N m].
    loaded_teeth
        Mean number of loaded contact lines of a disc with the ring at the nominal torque.
    pressure_angle
        Pressure angle of their forces, averaged by force [rad].
    backlash
        Backlash of the output, mean over a turn of the crank [rad].
    capacity
        Torque on the output at which the first contact yields [N m]; NaN without an equilibrium there.
    weakest
        Kind of the contact with the highest pressure over its strength.
    material_limits
        Limits of the materials of the library, a sentence each: heat, and for plastics sustained load.
    """

    ratio: float
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


def summarize(reducer: Reducer) -> Summary:
    """Return the `Summary` of a design that can be built: ratio, size, mass, loads and backlash at the nominal torque.

    Raises
    ------
    RunError
        There is no static equilibrium at the nominal torque.
    """
    design = reducer.design
    loads = rated_load(reducer)
    turning_reducer = reducer if design.drive.speed else reducer.but(drive={"speed": CREEP_SPEED})
    weakest_kind = max(design.pair_kinds, key=lambda kind: loads.peak_pressure(kind) / reducer.contacts[kind].strength)
    return Summary(
        ratio=design.reduction,
        discs=design.gear.discs,
        one_part=are_discs_identical(design.gear.discs, design.output.pins, design.lobes),
        outer_diameter=2.0 * design.housing.outer_radius,
        mass=mass(reducer),
        rated_torque=design.rated_torque,
        loaded_teeth=loads.loaded_teeth,
        pressure_angle=loads.pressure_angle,
        backlash=ARCMINUTE * figure("backlash_arcmin").value(turning_reducer),
        capacity=_capacity(turning_reducer),
        weakest=weakest_kind,
        material_limits=describe_plastic_limits(design),
    )


def _capacity(reducer: Reducer) -> float:
    """Compute the torque at first yield [N m]; NaN without an equilibrium there."""
    try:
        return figure("capacity_nm").value(reducer)
    except RunError:
        return math.nan
