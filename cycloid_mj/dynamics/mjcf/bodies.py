"""The bodies of a mechanism in MuJoCo: joints, masses, visual meshes, and cylinders for the exact collider."""

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array, on_grid, significant
from cycloid_mj.dynamics.contact.crank_train import mesh_numbers
from cycloid_mj.dynamics.contact.gap import Flank, Trochoid
from cycloid_mj.dynamics.contact.teeth import Teeth, user_data
from cycloid_mj.geometry.modification import FlankEnds, flank_ends
from cycloid_mj.parts import MassProperties, attached_parts
from cycloid_mj.parts.parts import COLOURS, Colour, tint
from cycloid_mj.parts.rv import axial_layout
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.reducer.bodies import Body, Role, Surfaces
from cycloid_mj.statics.film import drag_torques

VISUAL_GROUP, CONTACT_GROUP = 2, 3
"""Groups of the geoms that are only drawn, and of those that touch each other."""

SEAL_TIME, SEAL_IMPEDANCE = 1e-4, [0.99, 0.99, 1.0, 0.5, 1.0]
"""Time [s] in which the drag of seals stops a shaft that it can hold, and how firmly: a shaft that turns feels all of
it above a creep of some mrad/s."""

_X, _Y, _Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)  # unit vectors


def add_bodies(spec: Any, reducer: Reducer, masses: Mapping[str, MassProperties], tilting_pins: bool = False) -> None:
    """Add the bodies of the mechanism, with joints and, if they move, inertia, to the editable MuJoCo model `spec`.

    `masses` are the mass properties by part, such as ``gear``; `tilting_pins` is whether moving pins tilt.
    """
    # MuJoCo factorises from the last degree of freedom backwards: each pin is coupled with the gear only, so with pins
    # last an elimination fills in nothing between pins; before the gear each would couple all of them.
    for body in reducer.mechanism.bodies:
        parent = spec.body(body.carrier) if body.carrier else spec.worldbody
        element = parent.add_body(name=body.name, pos=mujoco_position(body.position, body.plane))
        _add_joints(element, body, reducer, tilting_pins and body.part == names.PIN)
        if body.joints:
            set_inertia(element, masses[body.part])


def add_shapes(spec: Any, reducer: Reducer) -> None:
    """Add the meshes of all parts, for viewers, and the cylinders of the exact contacts to the bodies of a model.

    `spec` is the editable MuJoCo model (``MjSpec``).
    """
    planes = {body.name: body.plane for body in reducer.mechanism.bodies}
    for body in reducer.mechanism.bodies:
        for part, position in list_visible_parts(reducer, body):
            spec.body(body.name).add_geom(
                type=mujoco.mjtGeom.mjGEOM_MESH,
                meshname=part,
                group=VISUAL_GROUP,
                contype=0,
                conaffinity=0,
                mass=0.0,
                rgba=list(colour(part)),
                pos=mujoco_position(position[:2], float(position[2])),
            )
    for surfaces in reducer.mechanism.surfaces:
        centre_z, half_width = axial_extent(reducer, surfaces)
        for index, name in enumerate(surfaces.names):
            spec.body(surfaces.bodies[index]).add_geom(
                name=name,
                type=mujoco.mjtGeom.mjGEOM_CYLINDER,
                size=[surfaces.radius[index], half_width, 0.0],
                pos=mujoco_position(surfaces.position[index], centre_z - planes[surfaces.bodies[index]]),
                priority=int(surfaces.role),
                group=CONTACT_GROUP,
                contype=0,
                conaffinity=0,
                mass=0.0,
                rgba=[0.9, 0.4, 0.2, 0.3],
                **collider_attributes(reducer, surfaces, index),
            )


def crank_inertia(reducer: Reducer, masses: Mapping[str, MassProperties]) -> float:
    """Compute the inertia of the driven shaft, crank or sun, and the rotor about their axis [kg m2]."""
    shaft = masses[names.SUN if isinstance(reducer, RvReducer) else names.SHAFT]
    return float(
        shaft.inertia[2, 2] + shaft.mass * np.sum(shaft.centroid[:2] ** 2) + reducer.design.drive.rotor_inertia
    )


def list_visible_parts(reducer: Reducer, body: Body) -> list[tuple[str, Array]]:
    """List the visible parts of a body, and the position (x, y, z) of each in its frame, shape (3,) [m]."""
    return [(body.part, np.zeros(3)), *attached_parts(reducer, body.part).values()]


def colour(part: str) -> Colour:
    """Return the colour of a part by its name."""
    return tint(COLOURS[names.family(part)], part)


def axial_extent(reducer: Reducer, surfaces: Surfaces) -> tuple[float, float]:
    """Return the axial position and half width of a group of surfaces, which span their disc, or all discs.

    The teeth of sun and planets have the width of the planets.

    Returns
    -------
    tuple of float
        Position of the centre along z from the middle of all discs, and half width [m].
    """
    gear = reducer.design.gear
    if isinstance(reducer, RvReducer) and surfaces.role in (Role.SUN, Role.PLANET):
        z_start, z_end = axial_layout(reducer).planets
        return 0.5 * (z_start + z_end), 0.5 * (z_end - z_start)
    if surfaces.disc is None:
        return 0.0, 0.5 * gear.stack_width
    return gear.disc_planes[surfaces.disc], 0.5 * gear.face_width


def mujoco_position(position: Array, z: float = 0.0) -> list[float]:
    """Return a position in the plane [m], shape (2,), and its z [m] in MuJoCo's format."""
    return [*on_grid(position).tolist(), float(on_grid(np.array(z)))]


def clockwise_quaternion(angle: float) -> list[float]:
    """Compute the quaternion of a clockwise turn about z [rad]."""
    quaternion: list[float] = on_grid([np.cos(0.5 * angle), 0.0, 0.0, -np.sin(0.5 * angle)]).tolist()
    return quaternion


def set_inertia(body: Any, properties: MassProperties) -> None:
    """Set a body's mass, centroid and moments of inertia."""
    inertia = properties.inertia
    body.explicitinertial = True
    body.mass = properties.mass
    body.ipos = properties.centroid.tolist()
    body.fullinertia = [inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]


def _add_joints(element: Any, body: Body, reducer: Reducer, tilts: bool) -> None:
    """Add the joints of a body of the `reducer` to its `element`, an ``MjsBody`` of the editable MuJoCo model.

    They are slide joints along x and y if the body moves sideways, and a hinge about its axis. The hinge of the driven
    shaft has the rotor's inertia, those of both shafts have the drag of seals and lubricant. If the body `tilts`, there
    are hinges about x and y, too, before the hinge about its own axis.
    """
    hinge, slide = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE
    *slides, rotation = body.joints or [""]
    for name, axis, origin in zip(slides, (_X, _Y), body.origin, strict=False):
        element.add_joint(name=name, type=slide, axis=axis, ref=origin)
    for name, axis in zip(names.tilt_joints(body.name) if tilts else (), (_X, _Y), strict=False):
        element.add_joint(name=name, type=hinge, axis=axis)
    if rotation:
        element.add_joint(name=rotation, type=hinge, axis=_Z, **_shaft_attributes(reducer, rotation))


def _shaft_attributes(reducer: Reducer, joint: str) -> dict[str, Any]:
    """Return the attributes of a shaft's joint: friction of seals, and armature of the rotor."""
    design = reducer.design
    drag = dict(zip((reducer.INPUT_JOINT, names.OUTPUT_JOINT), drag_torques(reducer), strict=True)).get(joint, 0.0)
    seal_attributes = {"frictionloss": drag, "solref_friction": [SEAL_TIME, 1.0], "solimp_friction": SEAL_IMPEDANCE}
    rotor_attributes = {"armature": design.drive.rotor_inertia} if joint == reducer.INPUT_JOINT else {}
    return rotor_attributes | (seal_attributes if drag > 0.0 else {})


def collider_attributes(reducer: Reducer, surfaces: Surfaces, i: int) -> dict[str, Any]:
    """Return MuJoCo attributes ``quat`` and ``userdata`` of the geom of surface `i`, for the collision function.

    `surfaces` is the group of the surface. Teeth have the numbers of their geometry and stiffness law; seats of moving
    pins those of `_seat_user_data`; planets the numbers of their mesh. Ring pins have their outward direction, for the
    start of the contact search, or zeros if it varies in a run; massless pins add play, compliance ratio and opening of
    their seats. Other surfaces have no data. Attributes that a surface does not need are omitted.
    """
    design = reducer.design
    angle = float(surfaces.angle[i])
    if surfaces.role == Role.TEETH:
        teeth = teeth_of_disc(reducer, surfaces.disc or 0)
        return {"quat": clockwise_quaternion(angle), "userdata": [significant(number) for number in user_data(teeth)]}
    if surfaces.role == Role.LOBE:
        return {"quat": clockwise_quaternion(angle)}
    if surfaces.role == Role.OUTER and (seat_numbers := _seat_user_data(reducer, surfaces)):
        return {"quat": clockwise_quaternion(angle), "userdata": [significant(number) for number in seat_numbers]}
    if isinstance(reducer, RvReducer) and surfaces.role == Role.PLANET:
        return {"userdata": [significant(number) for number in mesh_numbers(reducer.planet_mesh, i)]}
    if surfaces.role != Role.PIN:
        return {}
    # A pin that rotates with its ring or is displaced by a preload has no fixed direction: the collider uses its pose.
    body = reducer.mechanism.body(surfaces.bodies[i])
    direction_varies = reducer.mechanism.turning in (body.name, body.carrier) or design.ring.preload > 0.0
    outward_direction = [0.0, 0.0] if direction_varies else on_grid([np.sin(angle), np.cos(angle)]).tolist()
    if not design.ring.has_massless_pins:
        return {"userdata": outward_direction}
    compliance_ratio = reducer.contacts[design.tooth_pair].stiffness / reducer.contacts[design.seat_pair].stiffness
    min_cosine = 1.0 + np.cos(surfaces.half_angle)
    return {
        "userdata": [*outward_direction, *map(significant, (float(surfaces.play[i]), compliance_ratio, min_cosine))]
    }


def _seat_user_data(reducer: Reducer, surfaces: Surfaces) -> list[float]:
    """Return the user data of a seat of a moving pin, which the collision function reads.

    `surfaces` is the group of the seats. The numbers are the cosine and sine of half the arc of a socket. Seats of
    tilting pins add the distance of their two planes of contact from their middle [m], after two zeros if they are
    closed circles. The list is empty for all other surfaces: bores, holes and closed seats.
    """
    half_angle, design = surfaces.half_angle, reducer.design
    arc = [np.cos(half_angle), np.sin(half_angle)] if half_angle < np.pi else []
    if surfaces.disc is None and design.has_tilting_pins:
        return [*(arc or [0.0, 0.0]), design.gear.disc_planes[-1]]
    return arc


def teeth_of_disc(reducer: Reducer, disc: int) -> Teeth:
    """Return the geometry and stiffness law of the teeth of a disc for contact searches; `disc` is its index from 0.

    Manufacturing errors and the modification of the profile are included.
    """
    curvature_law, gear, errors = reducer.contacts.teeth.curvature_law, reducer.gear_profile, reducer.deviations
    offset = reducer.profile_offset - float(errors.disc_radius[disc])
    rotation = reducer.design.modification.rotation
    flank_ends_of_lobe = flank_ends(gear, offset, rotation) if rotation else FlankEnds(0.0, 0.0, 0.0, 0.0)
    curve = Trochoid(gear.pin_circle_radius, gear.eccentricity, float(gear.ring_teeth))
    corners = (
        flank_ends_of_lobe.tip,
        flank_ends_of_lobe.tip_radius,
        flank_ends_of_lobe.valley,
        flank_ends_of_lobe.valley_radius,
    )
    flank = Flank(curve, offset, rotation, *corners, errors.waves_in_use)
    ring_curve = curve._replace(radius=reducer.design.ring.pin_circle_radius)
    return Teeth(flank, curvature_law.reference, curvature_law.constant, curvature_law.deflection, ring_curve)
