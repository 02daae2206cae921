"""Contacts of the cranks of an RV reducer: their bearings in the discs, and their planets on the sun.

A bearing is needles and taper in series, as in ``statics.rv``: a spring between the eccentric and its bore, with the
sum of both clearances. A preloaded bearing has a second contact on the far side, which opens under a larger load. With
``contact.needles = "each"``, a bearing has a contact for each needle, and its friction is that of their resultant. The
friction of needles and taper acts at the eccentric. A planet has two flanks on the sun, see
``reducer.rv_bodies.PlanetMesh``.

Unknowns are the discs, the sun, the output, the cranks in the frame of the foundation, and the moving pins.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.dynamics.contact.crank_train import flank_normal, planet_flanks, unpack_mesh
from cycloid_mj.dynamics.contact.gap import Pose, outwards
from cycloid_mj.dynamics.film_table import CAM, OUTPUT
from cycloid_mj.dynamics.planar.contacts import (
    NONE,
    Contact,
    Contacts,
    MatingSurfaces,
    disc_pose,
    linearise_law,
    njit,
    resultant_share,
    scale_friction,
    set_film_friction,
    shaft_pose,
)
from cycloid_mj.dynamics.planar.system import System

_BEARING, _MESH = np.int64(CAM), np.int64(OUTPUT)

MIN_DISTANCE = 1e-15
"""Displacement of an eccentric from its bore [m], below rounding, from which on its direction is defined."""


class CrankTrain(NamedTuple):
    """The n cranks of an RV reducer with D discs.

    Attributes
    ----------
    axes
        Positions of the crank axes in the carrier [m], shape (n, 2).
    eccentrics
        Positions of the eccentrics on their cranks at the crank angle 0 [m], shape (D, n, 2).
    bores
        Positions of the crank bores in the discs [m], shape (D, n, 2).
    runouts
        Offsets of the planets' teeth from the crank axes at the crank angle 0 [m], shape (n, 2).
    laws
        Contact laws of a bearing, and of a planet's flank, records of ``system.LAW``, shape (2,).
    eccentric_radius, clearance
        Radius of the eccentrics, and radial clearance of the bearings; negative: preload [m].
    meshes
        Values of `MeshNumbers` for each planet, shape (n, 10).
    needles, cage_ratio
        Number of separate needles of an eccentric, or 0, whose law is then that of a needle; and turns of their cage
        per turn of the eccentric, both relative to the disc.
    """

    axes: Array
    eccentrics: Array
    bores: Array
    runouts: Array
    laws: npt.NDArray[np.void]
    eccentric_radius: float
    clearance: float
    meshes: Array
    needles: int
    cage_ratio: float


@njit
def find_crank_contacts(
    system: System, train: CrankTrain, contacts: Contacts, count: int, q: Array, v: Array, half_step: float
) -> int:
    """Write the contacts of all cranks of an RV reducer after `count` others; return the new number of contacts.

    `train` are the cranks of the reducer `system`. `q` and `v` are the coordinates of all bodies and their speeds,
    shape (unknowns,) [m, rad, m/s, rad/s], and `half_step` is half of the time step [s]. The array `contacts` is filled
    from the index `count`. Pairs are numbered after those of teeth and seats: first the bearing of each disc and crank,
    then the mesh of each planet.
    """
    disc_count, crank_count = train.eccentrics.shape[0], train.eccentrics.shape[1]
    carrier_unknown, first_crank = system.stud_shaft, len(system.inertia) - crank_count
    carrier_pose, pair = shaft_pose(q, carrier_unknown), len(system.ring_centres) * (disc_count + system.free)
    for disc in range(disc_count):
        pose_of_disc = disc_pose(q, 3 * disc, 0.0)
        for crank_index in range(crank_count):
            mating, crank_unknown = (
                MatingSurfaces(pair, train.laws[0], 3 * disc, -1, carrier_unknown, NONE),
                first_crank + crank_index,
            )
            pair += 1
            axis_x, axis_y = outwards(carrier_pose, train.axes[crank_index, 0], train.axes[crank_index, 1])
            eccentric_x, eccentric_y = outwards(
                shaft_pose(q, crank_unknown),
                train.eccentrics[disc, crank_index, 0],
                train.eccentrics[disc, crank_index, 1],
            )
            bore_x, bore_y = outwards(
                pose_of_disc, train.bores[disc, crank_index, 0], train.bores[disc, crank_index, 1]
            )
            dx, dy = axis_x + eccentric_x - pose_of_disc.x - bore_x, axis_y + eccentric_y - pose_of_disc.y - bore_y
            if train.needles:
                arms = BearingArms(axis_x, axis_y, eccentric_x, eccentric_y, bore_x, bore_y, train.eccentric_radius)
                cage_angle = q[3 * disc + 2] + train.cage_ratio * (q[crank_unknown] - q[3 * disc + 2])
                count = _find_needle_contacts(
                    system, train, contacts, count, mating, crank_unknown, arms, (dx, dy), cage_angle, v, half_step
                )
                continue
            distance = math.sqrt(dx * dx + dy * dy)
            # at rest in the middle any direction will do: the bearing is equally stiff in all
            nx, ny = (dx / distance, dy / distance) if distance > MIN_DISTANCE else (1.0, 0.0)
            for side in (1.0, -1.0):
                if side < 0.0 and train.clearance >= 0.0:
                    continue
                contact = contacts[count]
                _start_contact(contact, mating, crank_unknown, side * nx, side * ny, train.clearance - side * distance)
                _set_bearing_arms(
                    contact,
                    BearingArms(axis_x, axis_y, eccentric_x, eccentric_y, bore_x, bore_y, train.eccentric_radius),
                )
                contact.geometric_stiffness = half_step * side / max(distance, MIN_DISTANCE)
                linearise_law(contact, mating.law, 1.0, 0.0, v, half_step)
                set_film_friction(system, contact, _BEARING, 1.0, v)
                count += 1
    for crank_index in range(crank_count):
        mating = MatingSurfaces(pair + crank_index, train.laws[1], 3 * disc_count, -1, carrier_unknown, NONE)
        count = _find_planet_contacts(
            system, train, contacts, count, mating, first_crank + crank_index, crank_index, q, v, half_step
        )
    return count


class BearingArms(NamedTuple):
    """Vectors of a crank bearing [m] in the frame of the foundation.

    (ax, ay) leads from the reducer's axis to that of the crank, (ex, ey) from there to the eccentric, and (bx, by) from
    the disc's centre to the bore. Friction acts at the `radius` [m] of the eccentric.
    """

    ax: float
    ay: float
    ex: float
    ey: float
    bx: float
    by: float
    radius: float


@njit
def _find_needle_contacts(
    system: System,
    train: CrankTrain,
    contacts: Contacts,
    count: int,
    mating: MatingSurfaces,
    crank_unknown: int,
    arms: BearingArms,
    displacement: tuple[float, float],
    cage_angle: float,
    v: Array,
    half_step: float,
) -> int:
    """Write a contact for each needle of a crank bearing after `count` others; return the new number of contacts.

    `train` are the cranks of the reducer `system`, `mating` is the pair of eccentric and bore, and `crank_unknown` the
    index of the crank's rotation among the unknowns. `arms` are the lever arms of the bearing, `displacement` (x, y)
    [m] is that of the eccentric in its bore, and `cage_angle` [rad] the angle of the cage, at 0 of which a needle is on
    +y. `v` are the speeds of all coordinates, shape (unknowns,), and `half_step` is half of the time step [s].
    """
    dx, dy = displacement
    spacing = 2.0 * math.pi / train.needles
    friction_share = resultant_share(dx, dy, train.clearance, cage_angle, train.needles)
    for needle in range(train.needles):
        nx, ny = -math.sin(cage_angle + needle * spacing), math.cos(cage_angle + needle * spacing)
        contact = contacts[count]
        _start_contact(contact, mating, crank_unknown, nx, ny, train.clearance - dx * nx - dy * ny)
        _set_bearing_arms(contact, arms)
        linearise_law(contact, mating.law, 1.0, 0.0, v, half_step)
        set_film_friction(system, contact, _BEARING, 1.0, v)
        scale_friction(contact, friction_share, v)
        count += 1
    return count


@njit
def _start_contact(
    contact: Contact, mating: MatingSurfaces, crank_unknown: int, nx: float, ny: float, gap: float
) -> None:
    """Set pair, unknowns, normal and gap of a contact that pushes the body `disc` along the normal."""
    contact.pair = mating.pair
    contact.disc, contact.pin, contact.shaft, contact.crank = mating.disc, -1, mating.shaft, crank_unknown
    contact.nx, contact.ny, contact.gap, contact.side = nx, ny, gap, -1.0
    contact.disc_centre, contact.shaft_centre, contact.crank_centre = 0.0, 0.0, 0.0
    contact.geometric_stiffness = 0.0


@njit
def _set_bearing_arms(contact: Contact, arms: BearingArms) -> None:
    """Set the lever arms [m] of a contact of a crank bearing, along normal and tangent, about disc, carrier and crank.

    `arms` are the vectors between the axes of the reducer, the crank, the eccentric and the disc (`BearingArms`). The
    normal of the contact must be set.
    """
    nx, ny = contact.nx, contact.ny
    axis_x, axis_y, eccentric_x, eccentric_y, bore_x, bore_y, radius = arms
    contact.disc_normal, contact.disc_centre = bore_x * ny - bore_y * nx, bore_x * nx + bore_y * ny
    contact.disc_tangent = contact.disc_centre + radius
    contact.shaft_normal, contact.shaft_centre = axis_y * nx - axis_x * ny, -axis_x * nx - axis_y * ny
    contact.shaft_tangent = contact.shaft_centre
    contact.crank_normal, contact.crank_centre = (
        eccentric_y * nx - eccentric_x * ny,
        -eccentric_x * nx - eccentric_y * ny,
    )
    contact.crank_tangent = contact.crank_centre - radius


@njit
def _find_planet_contacts(
    system: System,
    train: CrankTrain,
    contacts: Contacts,
    count: int,
    mating: MatingSurfaces,
    crank_unknown: int,
    planet_index: int,
    q: Array,
    v: Array,
    half_step: float,
) -> int:
    """Write the contacts of both flanks of a planet on the sun after `count` others; return the new number of contacts.

    `train` are the cranks of the reducer `system`, `contacts` is the output array. `crank_unknown` is the index of the
    planet's rotation in q, `planet_index` that of the planet, `mating` its pair with the sun. `q` and `v` are the
    coordinates of all bodies and their speeds, shape (unknowns,) [m, rad, m/s, rad/s], `half_step` is half of the time
    step [s]. The normals are directions of the force on the sun, opposite to those of ``PlanetMesh``.
    """
    sun_unknown, mesh = mating.disc, unpack_mesh(train.meshes[planet_index])
    crank_pose = shaft_pose(q, crank_unknown)
    axis_x, axis_y = outwards(shaft_pose(q, mating.shaft), train.axes[planet_index, 0], train.axes[planet_index, 1])
    runout_x, runout_y = outwards(crank_pose, train.runouts[planet_index, 0], train.runouts[planet_index, 1])
    planet_pose = Pose(axis_x + runout_x, axis_y + runout_y, crank_pose.cosine, crank_pose.sine)
    flanks = planet_flanks(mesh, disc_pose(q, sun_unknown, 0.0), planet_pose)
    phase = mesh.planet_teeth * (q[crank_unknown] - math.atan2(flanks.y, flanks.x)) + mesh.phase
    error_slope = mesh.error * mesh.planet_teeth * math.cos(phase)
    for side in (1.0, -1.0):
        outward_x, outward_y = flank_normal(flanks, side)
        nx, ny = -outward_x, -outward_y
        contact = contacts[count]
        _start_contact(contact, mating, crank_unknown, nx, ny, flanks.gap if side > 0.0 else flanks.opposite)
        contact.disc_normal, contact.disc_tangent = -side * mesh.sun_base, mesh.arm
        contact.shaft_normal, contact.shaft_tangent = nx * axis_y - ny * axis_x - side * error_slope, 0.0
        contact.crank_normal = -side * (mesh.planet_base - error_slope) + nx * runout_y - ny * runout_x
        contact.crank_tangent = -mesh.arm
        linearise_law(contact, mating.law, 1.0, 0.0, v, half_step)
        set_film_friction(system, contact, _MESH, 1.0, v)
        count += 1
    return count
