"""Forces of ring and bearings on the housing, their moments, and the unbalance of discs, shaft or cranks.

In an RV reducer, the carrier transmits the forces of discs and planets on the cranks to its bearings. The sun has
bearings only if it does not float.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.record import Run
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts import (
    MassProperties,
    Solid,
    body_solids,
    crank_segments,
    gear_solid,
    mass_chord_error,
    mass_properties,
    moving_masses,
)
from cycloid_mj.reducer import Reducer, RvReducer, once
from cycloid_mj.statics.bearings import Planes, Reactions, compute_spatial_reactions


@dataclass(frozen=True)
class Unbalance:
    """Unbalance of the parts that rotate with the crank."""

    bare: float
    """Static unbalance of gears and cams, or of the discs of an RV reducer, without a counterweight: the sum of m c
    [kg m]."""
    balanced: float
    """The same with the counterweight, if there is one [kg m]."""
    couple: float
    """Couple unbalance with the counterweight about the middle plane of all discs, the sum of m y z [kg m2]; of several
    discs the magnitude of the vector with the sums of m x z and m y z."""


@dataclass(frozen=True, eq=False)
class Reaction:
    """Forces on the housing [N], shape (n, 2) each: of the ring's teeth, and of the bearings of input and output."""

    ring: Array
    crank: Array
    output: Array

    @property
    def total(self) -> Array:
        """Their sum [N], shape (n, 2)."""
        return self.ring + self.crank + self.output


def body_masses(reducer: Reducer) -> dict[str, MassProperties]:
    """Collect the mass properties of a gear, the crank, and the loaded body under the name of the output."""
    shaft, turning_mass = body_solids(reducer)[names.SHAFT], moving_masses(reducer)[reducer.mechanism.turning]
    return {names.GEAR: _gear(reducer.shape), names.SHAFT: mass_properties(shaft), names.OUTPUT: turning_mass}


@once
def _gear(reducer: Reducer) -> MassProperties:
    return mass_properties(gear_solid(reducer))


def weight_force(reducer: Reducer) -> Array:
    """Compute the weight of all bodies that move [N], shape (2,)."""
    masses, environment = moving_masses(reducer), reducer.design.environment
    mass = sum(masses[body.part].mass for body in reducer.mechanism.bodies if body.joints)
    return mass * np.array([environment.gravity_x, environment.gravity_y])


def unbalance(reducer: Reducer) -> Unbalance:
    """Compute static unbalance [kg m] and couple unbalance [kg m2] of discs and crank, from the masses of the solids.

    With one disc, `Unbalance.bare` is without the counterweight and `Unbalance.balanced` with it; all values are
    components along the eccentric, with a sign. With several discs, and for RV reducers, there is no counterweight:
    `bare` and `balanced` are equal, and all values are magnitudes. The couple of RV reducers includes the eccentrics of
    the cranks, but the static unbalance does not, as in simulations; it is zero with several discs.
    """
    design = reducer.design
    if isinstance(reducer, RvReducer):
        return _rv_unbalance(reducer)
    shaft_solid, gear_mass = body_solids(reducer)[names.SHAFT], _gear(reducer.shape)
    eccentricity = design.gear.eccentricity
    shaft_mass, discs = mass_properties(shaft_solid), design.gear.discs
    centroid, z = shaft_mass.centroid[:2], shaft_mass.centroid[2]
    directions = unit(-np.array(reducer.phases))
    static_unbalance = gear_mass.mass * eccentricity * directions.sum(axis=0) + shaft_mass.mass * centroid
    couple = gear_mass.mass * eccentricity * np.array(design.gear.disc_planes) @ directions + (
        shaft_mass.mass * centroid * z - shaft_mass.inertia[:2, 2]
    )
    if discs > 1:
        magnitude = float(np.hypot(*static_unbalance))
        return Unbalance(magnitude, magnitude, float(np.hypot(*couple)))
    cam_mass = mass_properties(
        Solid(names.CAM, (crank_segments(reducer)[names.CAM].prism(mass_chord_error(reducer)),), shaft_solid.density)
    )
    return Unbalance(
        gear_mass.mass * eccentricity + cam_mass.mass * cam_mass.centroid[1],
        float(static_unbalance[1]),
        float(couple[1]),
    )


def _rv_unbalance(reducer: RvReducer) -> Unbalance:
    """Compute static unbalance of discs [kg m] and couple unbalance of discs and cranks [kg m2] of an RV reducer."""
    gear, masses = reducer.design.gear, moving_masses(reducer)
    directions, crank_mass = unit(-np.array(reducer.phases)), masses[names.CRANK]
    disc_unbalance = masses[reducer.mechanism.discs[0].part].mass * gear.eccentricity
    couple = disc_unbalance * np.array(gear.disc_planes) @ directions
    couple += reducer.cranks.count * (
        crank_mass.mass * crank_mass.centroid[:2] * crank_mass.centroid[2] - crank_mass.inertia[:2, 2]
    )
    static_unbalance = float(np.hypot(*(disc_unbalance * directions.sum(axis=0))))
    return Unbalance(static_unbalance, static_unbalance, float(np.hypot(*couple)))


def carrier_tilting(run: Run, reducer: Reducer) -> Array:
    """Compute the tilting moment of the discs on the carrier of an RV reducer [N m] in n samples, (n, 2): x, y.

    The forces of the cranks act in the plane of each disc; the moment is about the middle of all discs.
    """
    gear = reducer.design.gear
    force = -run.forces(names.CRANK_BEARING).reshape(len(run), gear.discs, -1, 2).sum(axis=2)
    return Planes(force, np.array(gear.disc_planes)).moment


def bearing_reactions(run: Run, reducer: Reducer) -> Reactions:
    """Compute the forces of the discs on shaft, output and ring, and the reactions of the bearings [N], over a run.

    The forces act in the plane of each disc. They are the reversed contact forces on the discs in each sample.
    """
    design = reducer.design
    cam_forces, tooth_forces, output_forces = (run.forces(kind) for kind in ("cam", design.tooth_pair, "output"))
    forces_by_disc = (
        -force.reshape(len(run), design.gear.discs, -1, 2).sum(axis=2)
        for force in (cam_forces, output_forces, tooth_forces)
    )
    return compute_spatial_reactions(reducer, *forces_by_disc)


def reaction(run: Run, reducer: Reducer) -> Reaction:
    """Compute the forces of ring, crank bearing and output bearing on the housing over a run, from its contact forces.

    The force of the ring is the sum of its logged contact forces. The force of crank or output on its bearing is the
    sum of its contact forces, plus its weight, minus its mass times acceleration. The centroid of the shaft moves on a
    circle at the measured crank speed. The centroid of the output is on the axis, and so is the common centroid of all
    cranks of an RV reducer.
    """
    gravity = np.array([reducer.design.environment.gravity_x, reducer.design.environment.gravity_y])
    mechanism = reducer.mechanism
    if isinstance(reducer, RvReducer):
        return _rv_reaction(run, reducer, gravity)
    masses = body_masses(reducer)
    return Reaction(
        ring=-_sum_forces(run, mechanism.against(names.HOUSING)),
        crank=-_sum_forces(run, mechanism.against(names.SHAFT))
        + masses[names.SHAFT].mass * (gravity - shaft_acceleration(run, masses[names.SHAFT])),
        output=-_sum_forces(run, mechanism.against(names.OUTPUT)) + masses[names.OUTPUT].mass * gravity,
    )


def _rv_reaction(run: Run, reducer: RvReducer, gravity: Array) -> Reaction:
    """Compute the forces on the housing of an RV reducer, as `reaction` does, under `gravity` (2,) [m/s2].

    `Reaction.output` is the force of the carrier on its bearings: the contact forces on the cranks and planets, plus
    the weights of cranks and loaded body. `Reaction.crank` is the force of the sun on its bearings, which is 0 if the
    sun floats.
    """
    mechanism, masses = reducer.mechanism, moving_masses(reducer)
    cranks = [body for body in mechanism.bodies if body.carrier == names.OUTPUT]
    pairs_on_cranks = [pair for body in cranks for pair in mechanism.against(body.name)]
    carrier_mass = sum(masses[body.part].mass for body in cranks) + masses[mechanism.turning].mass
    # the force of a planet on the sun is logged; the bearings of a floating sun carry nothing
    sun_force = run.forces(names.PLANET_MESH).sum(axis=1) + masses[names.SUN].mass * gravity
    return Reaction(
        ring=-_sum_forces(run, mechanism.against(names.HOUSING)),
        crank=sun_force * (reducer.planet.sun_support == "fixed"),
        output=-_sum_forces(run, pairs_on_cranks) + carrier_mass * gravity,
    )


def inertia_force(run: Run, reducer: Reducer, disc_accelerations: Sequence[Array]) -> Array:
    """Compute the force of discs and driven shaft on the housing due to their accelerations alone [N], shape (m, 2).

    `disc_accelerations` are the accelerations of the centre of each disc [m/s2], shape (m, 2) each. They are means from
    one sample to the next, so m is one less than the number of samples.
    """
    masses, mechanism = moving_masses(reducer), reducer.mechanism
    discs = zip(mechanism.discs, disc_accelerations, strict=True)
    force = -sum(
        (masses[disc.part].mass * acceleration for disc, acceleration in discs), start=np.zeros((len(run) - 1, 2))
    )
    if not isinstance(reducer, RvReducer):
        shaft = body_masses(reducer)[names.SHAFT]
        return np.asarray(force - shaft.mass * shaft_acceleration(run, shaft)[1:])
    if reducer.planet.sun_support == "fixed":
        return force
    sun_speed = run.block(names.planar_speeds(names.SUN)[:2])
    return np.asarray(force - masses[names.SUN].mass * np.diff(sun_speed, axis=0) / np.diff(run.time)[:, np.newaxis])


def shaft_acceleration(run: Run, shaft: MassProperties) -> Array:
    """Compute the centripetal acceleration of the shaft's centroid [m/s2], shape (n, 2)."""
    return -((run["crank_speed"] ** 2)[:, np.newaxis]) * _eccentric_direction(run) * shaft.centroid[1]


def without_counterweight(run: Run, reducer: Reducer, force: Array) -> Array:
    """Compute a force on the housing [N], in n samples (n, 2), as it would be without the counterweight.

    The crank's bearing is rigid, so that only the unbalance that the counterweight compensates is added.
    """
    unbalances = unbalance(reducer)
    centrifugal_force = (unbalances.bare - unbalances.balanced) * run["crank_speed"] ** 2
    return force + centrifugal_force[:, np.newaxis] * _eccentric_direction(run)


def _eccentric_direction(run: Run) -> Array:
    """Compute unit vectors along the eccentric, shape (n, 2)."""
    return np.stack([-np.sin(run["crank_angle"]), np.cos(run["crank_angle"])], axis=1)


def _sum_forces(run: Run, base_names: list[str]) -> Array:
    """Add the logged forces of some pairs [N], shape (n, 2)."""
    axes = [
        run.block([names.column(base_name, component) for base_name in base_names]).sum(axis=1)
        for component in (names.FORCE_X, names.FORCE_Y)
    ]
    return np.stack(axes, axis=1)
