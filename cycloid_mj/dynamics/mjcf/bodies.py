"""The bodies of a mechanism in MuJoCo: joints, masses, visual meshes, and cylinders for the exact collider."""

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array, on_grid, significant
from cycloid_mj.dynamics.contact.gap import Flank, Trochoid
from cycloid_mj.dynamics.contact.teeth import Teeth, user_data
from cycloid_mj.geometry.modification import FlankEnds, flank_ends
from cycloid_mj.parts import MassProperties, attached_parts
from cycloid_mj.parts.parts import COLOURS, Colour, tint
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bodies import Body, Role, Surfaces
from cycloid_mj.statics.film import drag_torques

VISUAL_GROUP, CONTACT_GROUP = 2, 3

SEAL_TIME, SEAL_IMPEDANCE = 1e-4, [0.99, 0.99, 1.0, 0.5, 1.0]
"""Time [s] in which the drag of seals stops a shaft that it can hold, and how firmly: a shaft that turns feels all of
it above a creep of some mrad/s."""

_X, _Y, _Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def add_bodies(spec: Any, reducer: Reducer, masses: Mapping[str, MassProperties]) -> None:
    """Add every body with its joints, and with its mass if it moves."""
    # MuJoCo factorises from the last degree of freedom backwards: each pin is coupled with the gear only, so with pins
    # last an elimination fills in nothing between pins; before the gear each would couple all of them.
    for body in reducer.mechanism.bodies:
        carrier = spec.body(body.carrier) if body.carrier else spec.worldbody
        element = carrier.add_body(name=body.name, pos=point(body.place, body.plane))
        _add_joints(element, body, reducer)
        if body.joints:
            set_inertia(element, masses[body.part])


def add_shapes(spec: Any, reducer: Reducer) -> None:
    """Add the visual meshes, named as the parts, and the cylinders for the exact collider to the bodies."""
    planes = {body.name: body.plane for body in reducer.mechanism.bodies}
    for body in reducer.mechanism.bodies:
        for part, position in visible_parts(reducer, body):
            spec.body(body.name).add_geom(
                type=mujoco.mjtGeom.mjGEOM_MESH,
                meshname=part,
                group=VISUAL_GROUP,
                contype=0,
                conaffinity=0,
                mass=0.0,
                rgba=list(colour(part)),
                pos=point(position[:2], float(position[2])),
            )
    for surfaces in reducer.mechanism.surfaces:
        centre_z, half_width = axial_extent(reducer, surfaces)
        for i, name in enumerate(surfaces.names):
            spec.body(surfaces.bodies[i]).add_geom(
                name=name,
                type=mujoco.mjtGeom.mjGEOM_CYLINDER,
                size=[surfaces.radius[i], half_width, 0.0],
                pos=point(surfaces.place[i], centre_z - planes[surfaces.bodies[i]]),
                priority=int(surfaces.role),
                group=CONTACT_GROUP,
                contype=0,
                conaffinity=0,
                mass=0.0,
                rgba=[0.9, 0.4, 0.2, 0.3],
                **attributes(reducer, surfaces, i),
            )


def crank_inertia(reducer: Reducer, shaft: MassProperties) -> float:
    """Compute the inertia of shaft and rotor about the crank axis [kg m2]."""
    return float(
        shaft.inertia[2, 2] + shaft.mass * np.sum(shaft.centroid[:2] ** 2) + reducer.design.drive.rotor_inertia
    )


def visible_parts(reducer: Reducer, body: Body) -> list[tuple[str, Array]]:
    """List the visible parts of a body, and the position (x, y, z) of each in its frame, shape (3,) [m]."""
    return [(body.part, np.zeros(3)), *attached_parts(reducer, body.part).values()]


def colour(part: str) -> Colour:
    """Return the colour of a part by its name."""
    return tint(COLOURS[names.family(part)], part)


def axial_extent(reducer: Reducer, surfaces: Surfaces) -> tuple[float, float]:
    """Compute the centre of surfaces along z, and half their width [m]."""
    gear = reducer.design.gear
    if surfaces.disc is None:
        return 0.0, 0.5 * gear.stack_width
    return gear.disc_planes[surfaces.disc], 0.5 * gear.face_width


def point(position: Array, z: float = 0.0) -> list[float]:
    """Return a position in the plane [m], shape (2,), and its z [m] in MuJoCo's format."""
    return [*on_grid(position).tolist(), float(on_grid(np.array(z)))]


def turn(angle: float) -> list[float]:
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


def _add_joints(element: Any, body: Body, reducer: Reducer) -> None:
    hinge, slide = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE
    *slides, last = body.joints or [""]
    for name, axis, origin in zip(slides, (_X, _Y), body.origin, strict=False):
        element.add_joint(name=name, type=slide, axis=axis, ref=origin)
    if last:
        element.add_joint(name=last, type=hinge, axis=_Z, **_drag(reducer, last))


def _drag(reducer: Reducer, joint: str) -> dict[str, Any]:
    """Collect the joint attributes of seals and rotor on a shaft."""
    design = reducer.design
    drag = dict(zip((names.CRANK_JOINT, names.OUTPUT_JOINT), drag_torques(reducer), strict=True)).get(joint, 0.0)
    sealed = {"frictionloss": drag, "solref_friction": [SEAL_TIME, 1.0], "solimp_friction": SEAL_IMPEDANCE}
    rotor = {"armature": design.drive.rotor_inertia} if joint == names.CRANK_JOINT else {}
    return rotor | (sealed if drag > 0.0 else {})


def attributes(reducer: Reducer, surfaces: Surfaces, i: int) -> dict[str, Any]:
    """Collect the attributes of a surface for the collider, besides position and radius."""
    design = reducer.design
    angle = float(surfaces.angle[i])
    if surfaces.role == Role.TEETH:
        teeth = teeth_of_disc(reducer, surfaces.disc or 0)
        return {"quat": turn(angle), "userdata": [significant(number) for number in user_data(teeth)]}
    if surfaces.role == Role.LOBE:
        return {"quat": turn(angle)}
    if surfaces.role == Role.OUTER and surfaces.half_angle < np.pi:
        half = surfaces.half_angle
        return {"quat": turn(angle), "userdata": [significant(np.cos(half)), significant(np.sin(half))]}
    if surfaces.role != Role.PIN:
        return {}
    # A pin that its ring carries round, or that is turned from its place, has no home: the collider takes where it is.
    body = reducer.mechanism.body(surfaces.bodies[i])
    is_carried = reducer.mechanism.turning in (body.name, body.carrier) or design.ring.preload > 0.0
    home = [0.0, 0.0] if is_carried else on_grid([np.sin(angle), np.cos(angle)]).tolist()
    if not design.ring.has_massless_pins:
        return {"userdata": home}
    softness = reducer.contacts[design.tooth_pair].stiffness / reducer.contacts[design.seat_pair].stiffness
    grip = 1.0 + np.cos(surfaces.half_angle)
    return {"userdata": [*home, *map(significant, (float(surfaces.play[i]), softness, grip))]}


def teeth_of_disc(reducer: Reducer, disc: int) -> Teeth:
    """Compute the teeth of a disc for the collider."""
    law, gear, errors = reducer.contacts.teeth.curvature_law, reducer.gear_profile, reducer.deviations
    offset = reducer.profile_offset - float(errors.disc_radius[disc])
    rotation = reducer.design.modification.rotation
    ends = flank_ends(gear, offset, rotation) if rotation else FlankEnds(0.0, 0.0, 0.0, 0.0)
    curve = Trochoid(gear.pin_circle_radius, gear.eccentricity, float(gear.ring_teeth))
    corners = (ends.tip, ends.tip_radius, ends.valley, ends.valley_radius)
    flank = Flank(curve, offset, rotation, *corners, errors.waves_in_use)
    ring = curve._replace(radius=reducer.design.ring.pin_circle_radius)
    return Teeth(flank, law.reference, law.constant, law.deflection, ring)
