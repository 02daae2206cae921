"""A reducer in the plane as arrays, the input of the compiled planar solver.

The unknowns are x, y and rotation of each disc, the rotations of output and crank, and x, y and rotation of each moving
pin, in this order, in the frame of the foundation. A pin that tilts has x and y in the planes of both discs: x, y and
rotation, then x and y in the plane of the second disc. All other bodies are at rest or rotate with the output. In an RV
reducer, x, y and rotation of the sun follow the discs, and the rotations of all cranks follow that of the output.
"""

from collections.abc import Mapping
from dataclasses import astuple
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cycloid_mj.base import names
from cycloid_mj.base.array import Array, Integers
from cycloid_mj.dynamics.contact.contact_search import RingPin
from cycloid_mj.dynamics.contact.teeth import Teeth
from cycloid_mj.dynamics.film_table import CAM, OUTPUT, SEAT, TEETH, film_table
from cycloid_mj.dynamics.law import ContactParameters
from cycloid_mj.dynamics.mjcf import Held
from cycloid_mj.dynamics.mjcf.bodies import collider_attributes, crank_inertia, teeth_of_disc
from cycloid_mj.dynamics.mjcf.laws import laws_of_discs
from cycloid_mj.dynamics.mjcf.model import servo_gains
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts import moving_masses, pin_mass_matrix
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bodies import Role, Surfaces
from cycloid_mj.reducer.impact import ImpactLaw
from cycloid_mj.reducer.roller_needles import RollerNeedles
from cycloid_mj.reducer.rv_bodies import needle_share
from cycloid_mj.statics.film import drag_torques

LAW = np.dtype(
    [(name, np.float64) for name in ("stiffness", "damping", "friction", "creep")]
    + [(name, np.float64) for name in ("impact", "exponent", "impact_damping", "impact_depth")]
)
"""A contact law: of line contacts [N/m], [N s/m], [1], [N s/m], and of the law IMPACT (`impact.ImpactLaw`), else 0."""

SEAL_CREEP = 2e6
"""Torque of a drag per speed and inertia below its limit [1/s], as in MuJoCo's joint friction (heuristic)."""


class System(NamedTuple):
    """A reducer in the plane with D discs, N ring pins or lobes and n output pins.

    Attributes
    ----------
    bodies
        Number of bodies with the unknowns x, y and rotation before the output: discs, and the sun.
    shafts
        Index of the unknowns of output and input: the crank, or the sun, shape (2,).
    cranks
        Number of cranks of an RV reducer, whose rotations are the last unknowns but those of pins; else 0.
    bearing_contacts
        Largest number of contacts of crank bearings, or of cams with separate rollers.
    needles, cage_ratio
        Number of separate rollers of a cam, or 0; turns of their cage per turn of the cam, both relative to the disc.
    roller_needles
        Separate needles of the rollers of output pins.
    floating
        Whether there is a sun that moves along x and y.
    support
        Stiffness of springs that hold the unknowns of bodies at 0 [N/m], shape (3 bodies,); of a fixed sun, else (0,).
    teeth
        Teeth of every disc, except for their offset.
    offset, tooth_rotation
        Distance of each disc's flanks from the trochoid [m], and clockwise rotation of its teeth [rad], shape (D,).
    ring
        Values of `contact_search.RingPin` for each pin or lobe, shape (N, 6).
    ring_centres, outward
        Positions on the ring [m] of pins, lobes or seats, and their outward directions, shapes (N, 2).
    seat_centres
        Positions on the ring of the joint frames of moving pins [m], shape (N, 2).
    lobes, free, sleeved
        Whether the ring has lobes, moving pins, sleeves.
    ring_shaft, stud_shaft
        Index of the unknown that rotates the ring, and the output pins or crank axes; -1 if they are at rest.
    inner, outer
        Radii of the inner and outer surface of the seats of moving pins [m], shape (N,).
    arc
        Cosine and sine of half the arc on which sockets hold their pins; (-1, 0) for closed circles.
    holes, studs, cams
        Positions in their bodies of holes, output pins and cams [m], shapes (D, n, 2), (n, 2), (D, 2).
    hole, stud, bore, cam
        Radii of holes, output pins, bores and cams [m].
    laws
        Contact law of each disc and kind, records of `LAW`, shape (D, 4).
    inertia
        Mass or inertia of bodies, output, and crank or cranks [kg], [kg m2], by unknown.
    pin_mass, pin_inertia
        Mass matrix of a moving pin for its motion in the planes of its contacts [kg], shape (planes, planes), and its
        inertia about its axis [kg m2]; shape (0, 0) and 0 without moving pins.
    gravity
        Acceleration [m/s2], shape (2,).
    unbalance
        Mass times centroid of output and input in their frames [kg m], shape (2, 2).
    drag
        Limit [N m] of the drag on output and input, and its torque per speed below the limit [N m s], shape (2, 2).
    film
        Friction coefficients of the law ``film``, see `film_table`; `film_table.NO_TABLE` with the law ``coulomb``.
    servo
        Servo gains [N m/rad], [N m s/rad] of output and input, shape (2, 2); if the first is 0, commands are torques.
    """

    bodies: int
    shafts: Integers
    cranks: int
    bearing_contacts: int
    needles: int
    cage_ratio: float
    roller_needles: RollerNeedles
    floating: bool
    support: Array
    teeth: Teeth
    offset: Array
    tooth_rotation: Array
    ring: Array
    ring_centres: Array
    outward: Array
    seat_centres: Array
    lobes: bool
    free: bool
    sleeved: bool
    ring_shaft: int
    stud_shaft: int
    inner: Array
    outer: Array
    arc: Array
    holes: Array
    studs: Array
    cams: Array
    hole: float
    stud: float
    bore: float
    cam: float
    laws: npt.NDArray[np.void]
    inertia: Array
    pin_mass: Array
    pin_inertia: float
    gravity: Array
    unbalance: Array
    drag: Array
    film: Array
    servo: Array


def make_system(reducer: Reducer, held: Held = "crank") -> System:
    """Return bodies, contacts, laws and servos of a reducer as arrays for the planar solver.

    A servo drives the shaft `held`, a torque acts on the other shaft.

    Raises
    ------
    DesignError
        A part of the design is not feasible.
    """
    mechanism, masses, discs = reducer.mechanism, moving_masses(reducer), range(reducer.design.gear.discs)
    cam_matings = [mechanism.mating("cam", disc) for disc in discs]
    output_matings = [mechanism.mating("output", disc) for disc in discs]
    shafts = {"output": masses[mechanism.turning], "crank": masses[names.SHAFT]}
    shaft_inertia = {
        "output": float(shafts["output"].inertia[2, 2]),
        "crank": crank_inertia(reducer, masses),
    }
    drag, servo = drags_and_servos(reducer, held, shaft_inertia, shaft_inertia)
    return System(
        bodies=len(discs),
        shafts=np.array([3 * len(discs), 3 * len(discs) + 1]),
        cranks=0,
        bearing_contacts=len(discs) * reducer.separate_needles,
        needles=reducer.separate_needles,
        cage_ratio=reducer.cage_ratio,
        roller_needles=reducer.roller_needles,
        floating=False,
        support=np.zeros(0),
        holes=np.array([mating.on.position for mating in output_matings]),
        studs=output_matings[0].by.position,
        cams=np.array([cam.by.position[0] for cam in cam_matings]),
        hole=float(output_matings[0].on.radius[0]),
        stud=float(output_matings[0].by.radius[0]),
        bore=float(cam_matings[0].on.radius[0]),
        cam=float(cam_matings[0].by.radius[0]),
        inertia=np.array([*_disc_inertias(reducer), *shaft_inertia.values()]),
        unbalance=np.array([shaft.mass * shaft.centroid[:2] for shaft in shafts.values()]),
        film=film_table(reducer),
        **teeth_and_ring(reducer, 3 * len(discs)),
        drag=drag,
        servo=servo,
    )


def teeth_and_ring(reducer: Reducer, output_unknown: int) -> dict[str, Any]:
    """Return the arguments of a planar `System` that describe discs, ring and gravity, by field (``ring_centres``).

    `output_unknown` is the index of the output's rotation among the unknowns.
    """
    design, mechanism = reducer.design, reducer.mechanism
    discs = range(design.gear.discs)
    tooth_matings = [mechanism.mating(design.tooth_pair, disc) for disc in discs]
    teeth_of_discs = [teeth_of_disc(reducer, disc) for disc in discs]
    ring_surfaces = tooth_matings[0].by
    seats, inner_radii, outer_radii, arc = _seat_geometry(reducer, ring_surfaces)
    unknown_of_body = {mechanism.turning: output_unknown}
    pin_mass = moving_masses(reducer)[names.PIN] if design.ring.has_pin_bodies else None
    return {
        "teeth": teeth_of_discs[0],
        "offset": np.array([teeth.flank.offset for teeth in teeth_of_discs]),
        "tooth_rotation": np.array([mating.on.angle[0] for mating in tooth_matings]),
        "ring": _ring_values(reducer, ring_surfaces),
        "ring_centres": seats.position,
        "outward": unit(seats.angle),
        "seat_centres": np.array([body.position for body in mechanism.pins]).reshape(-1, 2),
        "lobes": ring_surfaces.role == Role.LOBE,
        "free": design.ring.has_pin_bodies,
        "sleeved": design.ring.has_pin_bodies and design.ring.has_sleeves,
        "ring_shaft": unknown_of_body.get(names.HOUSING, -1),
        "stud_shaft": unknown_of_body.get(names.OUTPUT, -1),
        "inner": inner_radii,
        "outer": outer_radii,
        "arc": arc,
        "laws": _contact_laws(reducer),
        "pin_mass": pin_mass_matrix(reducer) if pin_mass else np.zeros((0, 0)),
        "pin_inertia": float(pin_mass.inertia[2, 2]) if pin_mass else 0.0,
        "gravity": np.array([design.environment.gravity_x, design.environment.gravity_y]),
    }


def drags_and_servos(
    reducer: Reducer, held: Held, shaft_inertia: Mapping[str, float], servo_inertia: Mapping[str, float]
) -> tuple[Array, Array]:
    """Return drag and servo gains of the shafts of a reducer for the planar solver, each of shape (2, 2).

    The drag has a limit [N m] and a torque per speed below it [N m s], the servo the gains [N m/rad] and [N m s/rad].
    The first row is the output, the second the crank. The shaft `held` has the servo. `shaft_inertia` are the inertias
    [kg m2] of the shafts ``output`` and ``crank``; `servo_inertia` are those that a servo on each shaft moves.
    """
    crank_drag, output_drag = drag_torques(reducer)
    losses = {"output": output_drag, "crank": crank_drag}
    drag = np.array([[losses[name], SEAL_CREEP * shaft_inertia[name]] for name in losses])
    return drag, np.array([servo_gains(servo_inertia[name]) if name == held else (0.0, 0.0) for name in losses])


def _disc_inertias(reducer: Reducer) -> list[float]:
    """Return mass [kg], mass and moment of inertia [kg m2] of each disc, in one list of length 3 D."""
    masses = moving_masses(reducer)
    disc_masses = [masses[disc.part] for disc in reducer.mechanism.discs]
    return [inertia for disc in disc_masses for inertia in (disc.mass, disc.mass, float(disc.inertia[2, 2]))]


def _seat_geometry(reducer: Reducer, ring_surfaces: Surfaces) -> tuple[Surfaces, Array, Array, Array]:
    """Return the ring's surfaces that are in contact, and the radii and opening angle of the seats of its moving pins.

    `ring_surfaces` are the surfaces that mate with the teeth: pins or lobes.

    Returns
    -------
    tuple
        Surfaces: the seats of moving pins, or without moving pins `ring_surfaces`. `System.inner` and `System.outer`:
        radii of the inner and outer circle of each of N seats [m], shape (N,), empty without moving pins. `System.arc`:
        cosine and sine of half the arc on which a socket surrounds its pin, (-1, 0) for a closed circle.
    """
    design = reducer.design
    if not design.ring.has_pin_bodies:
        return ring_surfaces, np.zeros(0), np.zeros(0), np.array([-1.0, 0.0])
    seats = reducer.mechanism.mating(design.seat_pair)
    inner_circles, outer_circles = (seats.on, seats.by) if design.ring.has_sockets else (seats.by, seats.on)
    sine = np.sin(outer_circles.half_angle) if outer_circles.half_angle < np.pi else 0.0
    return seats.by, inner_circles.radius, outer_circles.radius, np.array([np.cos(outer_circles.half_angle), sine])


def _ring_values(reducer: Reducer, ring_surfaces: Surfaces) -> Array:
    """Return the data of N ring pins or lobes for the contact search, one row each, shape (N, 6).

    The columns are the fields of `contact_search.RingPin`: radius [m], outward direction, and play, compliance ratio
    and opening of the seat of a massless pin. Lobes have only the radius; other values are 0.
    """
    ring_values = np.zeros((len(ring_surfaces.names), len(RingPin._fields)))
    ring_values[:, 0] = ring_surfaces.radius
    for pin in range(len(ring_surfaces.names) if ring_surfaces.role == Role.PIN else 0):
        pin_values = collider_attributes(reducer, ring_surfaces, pin)["userdata"]
        ring_values[pin, 1 : 1 + len(pin_values)] = pin_values
    return ring_values


def _contact_laws(reducer: Reducer) -> npt.NDArray[np.void]:
    """Return the contact laws as records of `LAW`, shape (D, 4): D discs, and columns TEETH, SEAT, CAM and OUTPUT.

    The record of a kind that the drive lacks is zero.
    """
    design = reducer.design
    kinds = {TEETH: design.tooth_pair, SEAT: design.seat_pair, CAM: "cam", OUTPUT: "output"}
    laws_array = np.zeros((design.gear.discs, len(kinds)), dtype=LAW)
    for disc, laws in enumerate(laws_of_discs(reducer)):
        for column, kind in kinds.items():
            if kind not in laws:
                continue
            law = law_record(laws[kind], reducer.contacts[kind].impact)
            laws_array[disc, column] = law_of_needle(law, reducer.separate_needles if kind == "cam" else 0)[0]
    return laws_array


def law_of_needle(law: npt.NDArray[np.void], needles: int) -> npt.NDArray[np.void]:
    """Return the law of each of Z separate needles from that of their bearing, a record of `LAW` of any shape.

    Friction coefficient, exponent and depth stay; all other fields are multiplied by `needle_share`. `needles` is Z; 0
    returns the law of the bearing.
    """
    needle_law = law.copy()
    for field in ("stiffness", "damping", "creep", "impact", "impact_damping") if needles else ():
        needle_law[field] *= needle_share(needles)
    return needle_law


def law_record(law: ContactParameters, impact: ImpactLaw | None = None) -> npt.NDArray[np.void]:
    """Return a contact law as a record of `LAW`, shape (1,); `impact` is its law IMPACT, if any."""
    impact_parameters = astuple(impact) if impact else (0.0,) * 4
    field_values = law.stiffness, law.damping, law.friction, law.creep, *impact_parameters
    return np.array([field_values], dtype=LAW)
