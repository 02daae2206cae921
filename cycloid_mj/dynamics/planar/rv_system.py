"""An RV reducer in the plane as arrays, the input of the compiled planar solver."""

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.dynamics.contact.crank_train import mesh_numbers
from cycloid_mj.dynamics.film_table import film_table
from cycloid_mj.dynamics.mjcf import Held
from cycloid_mj.dynamics.mjcf.laws import laws_of_discs, stiffest
from cycloid_mj.dynamics.planar.crank_train import CrankTrain
from cycloid_mj.dynamics.planar.system import System, drags_and_servos, law_of_needle, law_record, teeth_and_ring
from cycloid_mj.parts import moving_masses, output_inertia
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.roller_needles import NO_NEEDLES

FIXED_SUN_STIFFNESS = 1e10
"""Stiffness of the bearings of a sun that is not floating [N/m]: its displacement under a kilonewton is 0.1 um."""


def make_rv_system(reducer: RvReducer, held: Held = "crank") -> System:
    """Return bodies, contacts, laws and servos of an RV reducer as arrays for the planar solver, without its cranks.

    The cranks are returned by `make_crank_train`. `held` is the shaft with a servo: "crank" for the sun, or "output".

    Raises
    ------
    DesignError
        A part of the design is not feasible.
    """
    masses, disc_count, crank_count = moving_masses(reducer), len(reducer.mechanism.discs), reducer.cranks.count
    sun, crank, inertia_of_output = masses[names.SUN], masses[names.CRANK], total_output_inertia(reducer)
    planar_masses = [masses[disc.part] for disc in reducer.mechanism.discs] + [sun]
    sun_inertia = float(sun.inertia[2, 2]) + reducer.design.drive.rotor_inertia
    inertia_by_unknown = [
        inertia for body in planar_masses for inertia in (body.mass, body.mass, float(body.inertia[2, 2]))
    ]
    output_unknown, sun_unknown = 3 * (disc_count + 1), 3 * disc_count + 2
    is_floating = reducer.planet.sun_support == "floating"
    fixed_support_stiffness = [*np.zeros(3 * disc_count), FIXED_SUN_STIFFNESS, FIXED_SUN_STIFFNESS, 0.0]
    shaft_inertia = {"output": inertia_of_output, "crank": sun_inertia}
    servo_inertia = {"output": inertia_of_output, "crank": input_inertia(reducer)}
    drag, servo = drags_and_servos(reducer, held, shaft_inertia, servo_inertia)
    return System(
        bodies=disc_count + 1,
        shafts=np.array([output_unknown, sun_unknown]),
        cranks=crank_count,
        bearing_contacts=disc_count * crank_count * max(2, reducer.separate_needles),
        needles=0,
        cage_ratio=0.0,
        roller_needles=NO_NEEDLES,
        floating=is_floating,
        support=np.array([] if is_floating else fixed_support_stiffness),
        holes=np.zeros((0, 0, 2)),
        studs=np.zeros((0, 2)),
        cams=np.zeros((0, 2)),
        hole=0.0,
        stud=0.0,
        bore=0.0,
        cam=0.0,
        inertia=np.array(
            [*inertia_by_unknown[:-1], sun_inertia, inertia_of_output, *[float(crank.inertia[2, 2])] * crank_count]
        ),
        unbalance=np.zeros((2, 2)),
        film=film_table(reducer),
        **teeth_and_ring(reducer, output_unknown),
        drag=drag,
        servo=servo,
    )


def make_crank_train(reducer: RvReducer) -> CrankTrain:
    """Return the cranks of an RV reducer as arrays: positions, contact laws, bearing clearance and planet meshes."""
    mechanism, mesh = reducer.mechanism, reducer.planet_mesh
    bearings = [mechanism.mating(names.CRANK_BEARING, disc) for disc in range(len(mechanism.discs))]
    laws = stiffest(laws_of_discs(reducer))
    bearing_law = law_of_needle(law_record(laws[names.CRANK_BEARING]), reducer.separate_needles)
    return CrankTrain(
        axes=np.array([mechanism.body(name).position for name in bearings[0].by.bodies]),
        eccentrics=np.array([bearing.by.position for bearing in bearings]),
        bores=np.array([bearing.on.position for bearing in bearings]),
        runouts=mechanism.mating(names.PLANET_MESH).by.position,
        laws=np.concatenate([bearing_law, law_record(laws[names.PLANET_MESH])]),
        eccentric_radius=reducer.cranks.eccentric_radius,
        clearance=reducer.bearing_clearance,
        meshes=np.array([mesh_numbers(mesh, planet) for planet in range(reducer.cranks.count)]),
        needles=reducer.separate_needles,
        cage_ratio=reducer.cage_ratio,
    )


def input_inertia(reducer: RvReducer) -> float:
    """Compute the inertia of all moving parts, reduced to the sun at their ideal speeds [kg m2]."""
    masses, member = moving_masses(reducer), reducer.member
    crank_ratio, carrier_ratio = float(member.crank_angle(1.0)), float(member.gear_angle(1.0))
    disc_masses = [masses[disc.part] for disc in reducer.mechanism.discs]
    return (
        float(masses[names.SUN].inertia[2, 2])
        + reducer.design.drive.rotor_inertia
        + reducer.cranks.count * float(masses[names.CRANK].inertia[2, 2]) * crank_ratio**2
        + sum(disc.mass * (reducer.design.gear.eccentricity * crank_ratio) ** 2 for disc in disc_masses)
        + sum(float(disc.inertia[2, 2]) * carrier_ratio**2 for disc in disc_masses)
        + total_output_inertia(reducer) * float(member.output_angle(1.0)) ** 2
    )


def total_output_inertia(reducer: RvReducer) -> float:
    """Compute the inertia of the output about its axis with the cranks that a carrier takes along [kg m2]."""
    mechanism, masses = reducer.mechanism, moving_masses(reducer)
    carried_cranks = [body for body in mechanism.carried if body.part == names.CRANK]
    return output_inertia(reducer) + sum(
        masses[body.part].mass * float(body.position @ body.position) for body in carried_cranks
    )
