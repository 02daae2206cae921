"""An RV reducer in the plane as arrays, the input of the compiled planar solver."""

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.dynamics.contact.crank_train import mesh_numbers
from cycloid_mj.dynamics.film_table import NO_TABLE
from cycloid_mj.dynamics.mjcf import Held
from cycloid_mj.dynamics.mjcf.bodies import teeth_of_disc
from cycloid_mj.dynamics.mjcf.laws import laws_of_discs, stiffest
from cycloid_mj.dynamics.mjcf.model import servo_gains
from cycloid_mj.dynamics.planar.crank_train import CrankTrain
from cycloid_mj.dynamics.planar.system import SEAL_CREEP, System, contact_laws, law_record, ring_values, seat_geometry
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts import moving_masses, output_inertia
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.bodies import Role
from cycloid_mj.reducer.rv_bodies import CRANK_BEARING, PLANET_MESH
from cycloid_mj.statics.film import drag_torques

FIXED_SUN_STIFFNESS = 1e10
"""Stiffness of the bearings of a sun that is not floating [N/m]: its displacement under a kilonewton is 0.1 um."""


def make_rv_system(reducer: RvReducer, held: Held = "crank") -> System:
    """Return the arrays of an RV reducer except for its cranks; a servo drives the sun or the output, as `held` says.

    Raises
    ------
    DesignError
        A part of the design is not feasible.
    """
    design, mechanism, masses = reducer.design, reducer.mechanism, moving_masses(reducer)
    discs, cranks = len(mechanism.discs), reducer.cranks.count
    teeth = [teeth_of_disc(reducer, disc) for disc in range(discs)]
    mesh = [mechanism.mating(design.tooth_pair, disc) for disc in range(discs)]
    ring = mesh[0].by
    seats, inner, outer, arc = seat_geometry(reducer, ring)
    sun, crank, output = masses[names.SUN], masses[names.CRANK], total_output_inertia(reducer)
    planar = [masses[disc.part] for disc in mechanism.discs] + [sun]
    sun_inertia = float(sun.inertia[2, 2]) + design.drive.rotor_inertia
    turned = [value for body in planar for value in (body.mass, body.mass, float(body.inertia[2, 2]))]
    inertia = np.array([*turned[:-1], sun_inertia, output, *[float(crank.inertia[2, 2])] * cranks])
    shafts = np.array([3 * (discs + 1), 3 * discs + 2])
    loaded = {mechanism.turning: int(shafts[0])}
    pin = masses[names.PIN] if design.ring.has_pin_bodies else None
    drags = dict(zip(("crank", "output"), drag_torques(reducer), strict=True))
    is_floating = reducer.planet.sun_support == "floating"
    fixed_support = [*np.zeros(3 * discs), FIXED_SUN_STIFFNESS, FIXED_SUN_STIFFNESS, 0.0]
    shaft_inertia = {"output": output, "crank": sun_inertia}
    servo_inertia = {"output": output, "crank": input_inertia(reducer)}
    return System(
        bodies=discs + 1,
        shafts=shafts,
        cranks=cranks,
        floating=is_floating,
        support=np.array([] if is_floating else fixed_support),
        teeth=teeth[0],
        offset=np.array([tooth.flank.offset for tooth in teeth]),
        turned=np.array([mating.on.angle[0] for mating in mesh]),
        ring=ring_values(reducer, ring),
        place=seats.place,
        home=unit(seats.angle),
        seated=np.array([body.place for body in mechanism.pins]).reshape(-1, 2),
        lobes=ring.role == Role.LOBE,
        free=design.ring.has_pin_bodies,
        sleeved=design.ring.has_pin_bodies and design.ring.has_sleeves,
        ring_shaft=loaded.get(names.HOUSING, -1),
        stud_shaft=loaded.get(names.OUTPUT, -1),
        inner=inner,
        outer=outer,
        arc=arc,
        holes=np.zeros((0, 0, 2)),
        studs=np.zeros((0, 2)),
        cams=np.zeros((0, 2)),
        hole=0.0,
        stud=0.0,
        bore=0.0,
        cam=0.0,
        laws=contact_laws(reducer),
        inertia=inertia,
        pin=np.array([pin.mass, pin.inertia[2, 2]]) if pin else np.zeros(2),
        gravity=np.array([design.environment.gravity_x, design.environment.gravity_y]),
        unbalance=np.zeros((2, 2)),
        drag=np.array([[drags[name], SEAL_CREEP * shaft_inertia[name]] for name in shaft_inertia]),
        film=NO_TABLE,
        servo=np.array([servo_gains(servo_inertia[name]) if name == held else (0.0, 0.0) for name in shaft_inertia]),
    )


def make_crank_train(reducer: RvReducer) -> CrankTrain:
    """Return the cranks of an RV reducer as arrays."""
    mechanism, mesh = reducer.mechanism, reducer.planet_mesh
    bearings = [mechanism.mating(CRANK_BEARING, disc) for disc in range(len(mechanism.discs))]
    laws = stiffest(laws_of_discs(reducer))
    return CrankTrain(
        axes=np.array([mechanism.body(name).place for name in bearings[0].by.bodies]),
        eccentrics=np.array([bearing.by.place for bearing in bearings]),
        bores=np.array([bearing.on.place for bearing in bearings]),
        runouts=mechanism.mating(PLANET_MESH).by.place,
        laws=np.concatenate([law_record(laws[kind]) for kind in (CRANK_BEARING, PLANET_MESH)]),
        eccentric_radius=reducer.cranks.eccentric_radius,
        clearance=reducer.bearing_clearance,
        meshes=np.array([mesh_numbers(mesh, planet) for planet in range(reducer.cranks.count)]),
    )


def input_inertia(reducer: RvReducer) -> float:
    """Compute the inertia of all moving parts, seen from the sun [kg m2], from their ideal speeds."""
    masses, member = moving_masses(reducer), reducer.member
    orbit = float(member.against_ring(1.0) + member.ring_angle(1.0))
    crank, carrier = float(member.against_carrier(1.0) + member.gear_angle(1.0)), float(member.gear_angle(1.0))
    discs = [masses[disc.part] for disc in reducer.mechanism.discs]
    return (
        float(masses[names.SUN].inertia[2, 2])
        + reducer.design.drive.rotor_inertia
        + reducer.cranks.count * float(masses[names.CRANK].inertia[2, 2]) * crank**2
        + sum(disc.mass * (reducer.design.gear.eccentricity * orbit) ** 2 for disc in discs)
        + sum(float(disc.inertia[2, 2]) * carrier**2 for disc in discs)
        + total_output_inertia(reducer) * float(member.output_angle(1.0)) ** 2
    )


def total_output_inertia(reducer: RvReducer) -> float:
    """Compute the inertia of the output about its axis with the cranks that a carrier takes along [kg m2]."""
    mechanism, masses = reducer.mechanism, moving_masses(reducer)
    carried = [body for body in mechanism.carried if body.part == names.CRANK]
    return output_inertia(reducer) + sum(masses[body.part].mass * float(body.place @ body.place) for body in carried)
