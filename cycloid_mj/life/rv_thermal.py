"""Losses and heat conductances of an RV reducer for its thermal network."""

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.design.model import Material
from cycloid_mj.life.duty import DutyPoint
from cycloid_mj.life.rv import TAPERS, flange_forces
from cycloid_mj.life.thermal_network import (
    Conductance,
    Network,
    line_contact_conductance,
    outside_links,
    roller_conductance,
)
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics.rv import RvLoads
from cycloid_mj.statics.rv_sheet import friction_powers, solve_running_equilibrium

RV_THERMAL_ASSUMPTIONS = (
    "each of the two parts in contact receives half of their loss; motor and driven machine receive no heat",
    "a third of the rollers of each crank bearing is loaded; between flanges and housing there is grease, without the "
    "main bearings; conductivities by the kind of material",
    "discs that expand more than the ring are preloaded: the springs of the pins, the housing as a thin ring and the "
    "discs as full plates yield in series; cranks are preloaded in their bores",
)


def describe_rv_friction(reducer: RvReducer) -> str:
    """Return a sentence that states at which temperatures the friction of an RV reducer is computed."""
    friction = reducer.design.friction
    friction_text = (
        f"film of {friction.lubricant} at the temperature of the parts in contact"
        if reducer.design.has_film
        else "the coefficients of the design at any temperature"
    )
    return f"friction: {friction_text}; sun and planets have the temperature of the cranks"


def solve_rv_losses(
    reducer: RvReducer,
    points: Sequence[DutyPoint],
    temperatures: Mapping[str, float],
    crank_angles: int,
) -> tuple[tuple[dict[str, float], ...], Network]:
    """Return the losses [W] by source at each point of a duty, and the thermal network under its largest torque.

    Sources are those of `friction_powers`, such as "teeth". `temperatures` [°C] of the parts determine losses and
    conductances; `crank_angles` is the number of crank angles. The network is that of the steady state: its heat
    capacities are 1 J/K.

    Raises
    ------
    RunError
        No static equilibrium exists.
    """
    losses = tuple(
        dict(
            friction_powers(
                reducer.turning_at(point.speed).at_temperatures(temperatures), abs(point.torque), crank_angles
            )
        )
        for point in points
    )
    max_torque = max(abs(point.torque) for point in points)
    warm_reducer = reducer.at_temperatures(temperatures)
    loads = solve_running_equilibrium(warm_reducer, max_torque, crank_angles)
    links = (
        *_contact_links(warm_reducer, loads),
        *_grease_links(reducer),
        *outside_links(reducer, temperatures["housing"]),
    )
    return losses, Network(links)


def _contact_links(reducer: RvReducer, loads: RvLoads) -> Iterator[Conductance]:
    """Yield the heat conductances [W/K] of cycloid teeth and crank bearings, means over the crank angles of `loads`."""
    design, cranks = reducer.design, reducer.cranks
    pair, steel, disc_material = design.tooth_pair, design.material_of("shaft"), design.material_of("gear")
    tooth_conductances = line_contact_conductance(
        loads.pins, design.line_length(pair), design.ring.pin_radius, design.partners(pair)
    )
    source = f"line contacts of {pair}, pi k L/ln(4 R/b), mean of a turn"
    yield Conductance("disc", "ring", float(tooth_conductances.sum(axis=1).mean()), source)
    needle_conductance = _row_conductance(
        loads.bearings,
        cranks.needles,
        cranks.needle_radius,
        design.gear.face_width,
        (steel, disc_material),
    )
    yield Conductance("crank", "disc", needle_conductance, "needles of the cranks, a third of them loaded")
    cup_diameter = 2.0 * cranks.taper_radius
    taper_conductance = _row_conductance(
        flange_forces(reducer, loads.cranks),
        TAPERS.rollers,
        0.5 * TAPERS.diameter * cup_diameter,
        TAPERS.length * cup_diameter,
        (steel, steel),
    )
    source = f"tapered bearings of the cranks, {TAPERS.rollers} rollers assumed, a third of them loaded"
    yield Conductance("crank", "output", taper_conductance, source)


def _row_conductance(
    forces: Array, rollers: int, radius: float, length: float, partners: tuple[Material, Material]
) -> float:
    """Sum the heat conductances of equal roller bearings [W/K], each under its mean force over m crank angles.

    `forces` [N] have the shape (m, ...), where the further axes number the bearings. A bearing has `rollers` rollers
    with a `radius` and `length` [m]; `partners` are the materials of rollers and rings.
    """
    mean_forces = np.mean(forces.reshape(len(forces), -1), axis=0)
    return sum(roller_conductance(rollers, radius, length, float(force), partners) for force in mean_forces)


def _grease_links(reducer: RvReducer) -> Iterator[Conductance]:
    """Yield the heat conductances [W/K] through grease, of discs to flanges and of flanges to the housing."""
    design, cranks = reducer.design, reducer.cranks
    hole_radii_squared = cranks.count * (reducer.bore_radius**2 + reducer.window_radius**2)
    face_area = math.pi * (
        min(design.ring_root_radius, reducer.flange_radius) ** 2 - cranks.middle_hole_radius**2 - hole_radii_squared
    )
    rim_area = 2.0 * math.pi * reducer.flange_radius * cranks.flange_thickness
    coefficient = design.thermal.grease_conductivity / design.thermal.face_gap
    yield Conductance("disc", "output", 2.0 * coefficient * face_area, "grease between discs and flanges, k A/gap")
    yield Conductance("output", "housing", 2.0 * coefficient * rim_area, "grease between flanges and housing, k A/gap")
