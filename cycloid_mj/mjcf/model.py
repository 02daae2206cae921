"""``Design`` -> ``MjSpec``: bodies, joints, geoms, pairs, actuators and sensors of the reducer.

Frame: +x right, +y up, z along the crank axis; crank angle counter-clockwise, zero with the gear centre at (0, +c).
The gear and the free pins move in the plane (two slides and a hinge); shaft and output turn on hinges.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import mujoco
import numpy as np

from cycloid_mj import names
from cycloid_mj.contact.collider import Role
from cycloid_mj.contact.law import (
    IMPRATIO,
    ContactLaw,
    contact_law,
    curvature_law,
    damping_ratio,
    pair_stiffness,
    series_stiffness,
    solver_parameters,
)
from cycloid_mj.contact.library import exact_xml
from cycloid_mj.contact.regime import warnings
from cycloid_mj.contact.teeth import USER_DATA, Teeth
from cycloid_mj.contact.working import working_force
from cycloid_mj.design import Design
from cycloid_mj.deviations import deviations
from cycloid_mj.digits import on_grid, significant
from cycloid_mj.mjcf.solver import set_solver
from cycloid_mj.modification import FlankEnds, flank_ends
from cycloid_mj.names import Pair
from cycloid_mj.solid import VISUAL_CHORD_ERROR, MassProperties, Mesh, mass_properties, mesh, parts, sleeve_core_radius
from cycloid_mj.solid.gear import gear_profile, profile_offset

Held = Literal["crank", "output", ""]
"""The shaft that a servo holds; none: both feel a torque alone."""

SERVO_BANDWIDTH = 2e4
"""Bandwidth [rad/s] of the position servo that makes a shaft follow its command; critically damped."""

_VISUAL, _CONTACT = 2, 3
_COLOURS = {
    names.HOUSING: (0.55, 0.58, 0.62, 1.0),
    names.SHAFT: (0.80, 0.62, 0.25, 1.0),
    names.GEAR: (0.25, 0.47, 0.70, 1.0),
    "pin": (0.83, 0.84, 0.86, 1.0),
    names.OUTPUT: (0.36, 0.62, 0.42, 1.0),
}
SEAL_TIME, SEAL_IMPEDANCE = 1e-4, [0.99, 0.99, 1.0, 0.5, 1.0]
"""Time [s] in which the drag of seals stops a shaft that it can hold, and how firmly: a shaft that turns feels all of
it above a creep of some mrad/s."""

_PLANAR = (("x", (1.0, 0.0, 0.0)), ("y", (0.0, 1.0, 0.0)))
_Z = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class ReducerModel:
    """A model ready to run.

    Attributes
    ----------
    spec, model
        The editable and the compiled model.
    pairs
        Every mating pair, in the order of the log's force columns.
    laws
        The contact law of each kind of pair.
    servo_gains
        kp [N m/rad] and kv [N m s/rad] of the servo on the shaft that is held.
    crank_inertia
        Inertia of shaft and rotor about the crank axis [kg m2].
    warnings
        Why its figures may not be those of its design, see ``contact.regime``.
    """

    spec: Any
    model: Any
    pairs: tuple[Pair, ...]
    laws: Mapping[str, ContactLaw]
    servo_gains: tuple[float, float]
    crank_inertia: float
    warnings: tuple[str, ...] = ()


def build(design: Design, held: Held = "crank") -> ReducerModel:
    """Build the contact model of a design.

    Parameters
    ----------
    design
        What to build.
    held
        The shaft that a servo holds to a position command; the actuator of a shaft that is not held is a torque.

    Raises
    ------
    DesignError
        A part of the design cannot be made.
    ContactError
        MuJoCo cannot represent a contact's stiffness at this time step.
    """
    solids = parts(design)
    masses = {name: mass_properties(solid) for name, solid in solids.items()}
    spec = _empty(design)
    for name, solid in parts(design, VISUAL_CHORD_ERROR).items():
        _add_mesh(spec, name, mesh(solid))
    crank_inertia = _add_bodies(spec, design, masses)
    inertias = {"crank": crank_inertia, "output": float(masses[names.OUTPUT].inertia[2, 2]), "": 0.0}
    gains = _add_actuators(spec, inertias[held], held)
    _add_sensors(spec, design)
    mating = names.pairs(design)
    laws = contact_laws(design, masses)
    set_solver(spec, laws, design.ring.has_pin_bodies)
    model = _add_pairs(spec, mating, laws)
    return judged(ReducerModel(spec, model, mating, laws, gains, crank_inertia), design)


def judged(reducer: ReducerModel, design: Design) -> ReducerModel:
    """Give a model with its warnings."""
    return replace(reducer, warnings=warnings(design, reducer))


def xml(spec: Any) -> str:
    """Give the MJCF of a compiled spec with every digit of every number."""
    with exact_xml():
        return str(spec.to_xml())


def contact_laws(design: Design, masses: Mapping[str, MassProperties]) -> dict[str, ContactLaw]:
    """Give the contact law of each kind of pair: line-contact stiffness, damping by the pair's own effective mass.

    With massless pins the pair of gear and pin is one of gear and housing: both contacts in series, rubbing as easily
    as the easier of the two.
    """
    laws = {}
    for kind, mass in effective_masses(design, masses).items():
        through = kind == "pin_gear" and design.ring.has_massless_pins
        friction = design.mesh_friction if through else design.friction_of(kind)
        laws[kind] = contact_law(
            stiffness=series_stiffness(design) if through else pair_stiffness(design, kind),
            damping_ratio=damping_ratio(design, kind),
            effective_mass=mass,
            friction=friction,
            creep=friction * working_force(design, kind) / design.contact.creep_speed,
            timestep=design.settings.timestep,
        )
    return laws


def effective_masses(design: Design, masses: Mapping[str, MassProperties]) -> dict[str, float]:
    """Give the mass [kg] that moves on a contact of each kind of pair.

    Half of the ring's and of the output's contacts carry at a time; a free pin, or a sleeve, lies between two.
    """
    gear = 1.0 / masses[names.GEAR].mass
    output = design.output.pin_circle_radius**2 / masses[names.OUTPUT].inertia[2, 2]
    mobility = {"cam": gear, "output": (gear + output) * design.output.pins / 2.0}
    if design.ring.has_pin_bodies:
        pin = 1.0 / masses["pin"].mass
        mobility |= {"pin_gear": 2.0 * (gear + pin)}
        mobility |= {"pin_socket" if design.ring.has_sockets else "pin_sleeve": 2.0 * pin}
    else:
        mobility[design.tooth_pair] = gear * design.ring.teeth / 2.0
    return {kind: float(1.0 / mobile) for kind, mobile in mobility.items()}


def ring_angles(design: Design) -> Any:
    """Angles of the ring pins, clockwise from +y [rad], shape (N,)."""
    return 2.0 * np.pi * np.arange(design.ring.teeth) / design.ring.teeth


def output_angles(design: Design) -> Any:
    """Angles of the output pins and holes, clockwise from +y [rad]."""
    return 2.0 * np.pi * np.arange(design.output.pins) / design.output.pins


def _at(radius: float, angle: float, deviation: Any = (0.0, 0.0)) -> list[float]:
    """Give the place at an angle clockwise from +y, and how far a part is beside it [m]."""
    place = (radius * np.sin(angle) + deviation[0], radius * np.cos(angle) + deviation[1], 0.0)
    return on_grid(place).tolist()


def _empty(design: Design) -> Any:
    spec = mujoco.MjSpec()
    spec.modelname = f"cycloid_{design.name}"
    spec.nuser_geom = USER_DATA
    option = spec.option
    option.timestep = design.settings.timestep
    option.gravity = [design.environment.gravity_x, design.environment.gravity_y, 0.0]
    option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = IMPRATIO
    option.iterations = 100
    option.tolerance = 1e-10
    # One island holds everything in contact: looking for more only costs time.
    option.disableflags = int(mujoco.mjtDisableBit.mjDSBL_AUTORESET | mujoco.mjtDisableBit.mjDSBL_ISLAND)
    option.enableflags = int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    reach = design.housing.outer_radius
    spec.stat.extent = 2.0 * reach
    spec.stat.center = [0.0, 0.0, 0.0]
    spec.worldbody.add_light(pos=[reach, 2 * reach, 6 * reach], dir=[-0.2, -0.3, -1.0])
    spec.worldbody.add_camera(name="front", pos=[0.0, 0.0, -4 * reach], xyaxes=[-1, 0, 0, 0, 1, 0])
    return spec


def _add_mesh(spec: Any, part: str, shape: Mesh) -> None:
    spec.add_mesh(
        name=part,
        uservert=shape.vertices.ravel().tolist(),
        userface=shape.faces.ravel().tolist(),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_EXACT,
    )


def _visual(body: Any, part: str) -> None:
    """Show a part's mesh on a body, without mass or contact."""
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=part,
        group=_VISUAL,
        contype=0,
        conaffinity=0,
        mass=0.0,
        rgba=list(_COLOURS[part]),
    )


def _contact_geom(body: Any, name: str, role: Role, radius: float, half_width: float, **attributes: Any) -> None:
    """Add a cylinder for the collider: no mass, no contact but by explicit pair."""
    body.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[radius, half_width, 0.0],
        priority=int(role),
        group=_CONTACT,
        contype=0,
        conaffinity=0,
        mass=0.0,
        rgba=[0.9, 0.4, 0.2, 0.3],
        **attributes,
    )


def _inertial(body: Any, properties: MassProperties) -> None:
    inertia = properties.inertia
    body.explicitinertial = True
    body.mass = properties.mass
    body.ipos = properties.centroid.tolist()
    body.fullinertia = [inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]


def _planar(body: Any, name: str, start: tuple[float, float], turn: str) -> None:
    """Let a body move in the plane; the slides read its position, starting at ``start``."""
    for (axis, direction), ref in zip(_PLANAR, start, strict=True):
        body.add_joint(name=f"{name}_{axis}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=direction, ref=ref)
    body.add_joint(name=turn, type=mujoco.mjtJoint.mjJNT_HINGE, axis=_Z)


def _add_shaft_joint(body: Any, name: str, drag: float, **attributes: Any) -> None:
    """Let a shaft turn about the axis, against the drag of its seals [N m]."""
    if drag > 0.0:
        attributes |= {"frictionloss": drag, "solref_friction": [SEAL_TIME, 1.0], "solimp_friction": SEAL_IMPEDANCE}
    body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=_Z, **attributes)


def _add_bodies(spec: Any, design: Design, masses: Mapping[str, MassProperties]) -> float:
    """Add housing, ring, shaft, gear and output; give the inertia on the crank [kg m2]."""
    half = 0.5 * design.gear.face_width
    housing = spec.worldbody.add_body(name=names.HOUSING)
    _visual(housing, names.HOUSING)

    shaft = spec.worldbody.add_body(name=names.SHAFT)
    rotor = design.drive.rotor_inertia
    _add_shaft_joint(shaft, names.CRANK_JOINT, design.drag.crank, armature=rotor)
    _inertial(shaft, masses[names.SHAFT])
    _visual(shaft, names.SHAFT)
    cam = [0.0, design.gear.eccentricity + design.errors.eccentricity, 0.0]
    _contact_geom(shaft, names.CAM, Role.INNER, design.gear.bore_radius, half, pos=cam)

    _add_gear(spec, design, masses[names.GEAR])

    output = spec.worldbody.add_body(name=names.OUTPUT)
    _add_shaft_joint(output, names.OUTPUT_JOINT, design.drag.output)
    _inertial(output, masses[names.OUTPUT])
    _visual(output, names.OUTPUT)
    for number, angle in enumerate(output_angles(design), start=1):
        place = _at(design.output.pin_circle_radius, angle)
        _contact_geom(output, names.output_pin(number), Role.INNER, design.output.pin_radius, half, pos=place)

    # MuJoCo factorises from the last degree of freedom backwards: each pin meets the gear alone, so with the pins
    # last an elimination fills in nothing between pins; before the gear each would couple all of them.
    _add_ring(spec, housing, design, masses)

    properties = masses[names.SHAFT]
    return float(properties.inertia[2, 2] + properties.mass * np.sum(properties.centroid[:2] ** 2) + rotor)


def _add_ring(spec: Any, housing: Any, design: Design, masses: Mapping[str, MassProperties]) -> None:
    half, nominal, made = 0.5 * design.gear.face_width, design.ring.pin_radius, deviations(design)
    for number, angle in enumerate(ring_angles(design), start=1):
        place = _at(design.ring.pin_circle_radius, angle, made.pin_place[number - 1])
        radius, home = nominal + made.pin_radius[number - 1], on_grid([np.sin(angle), np.cos(angle)]).tolist()
        if design.ring.kind == "nonpin":
            turned = on_grid([np.cos(0.5 * angle), 0.0, 0.0, -np.sin(0.5 * angle)]).tolist()
            _contact_geom(housing, names.lobe(number), Role.LOBE, radius, half, pos=place, quat=turned)
            continue
        if not design.ring.has_pin_bodies:
            if design.ring.has_massless_pins:
                home += _give(design, float(made.pin_radius[number - 1]))
            _contact_geom(housing, names.pin(number), Role.PIN, radius, half, pos=place, userdata=home)
            continue
        if design.ring.has_sockets:
            socket = nominal + design.clearance.pin_socket
            _contact_geom(housing, names.socket(number), Role.OUTER, socket, half, pos=place)
        else:
            _contact_geom(housing, names.core(number), Role.INNER, sleeve_core_radius(design), half, pos=place)
        pin = spec.worldbody.add_body(name=names.pin(number), pos=place)
        _planar(pin, names.pin(number), (0.0, 0.0), f"{names.pin(number)}_angle")
        _inertial(pin, masses["pin"])
        _visual(pin, "pin")
        _contact_geom(pin, names.pin(number), Role.PIN, radius, half, userdata=home)
        if design.ring.has_sleeves:
            _contact_geom(pin, names.sleeve(number), Role.OUTER, design.ring.sleeve_bore_radius, half)


def _give(design: Design, larger: float) -> list[float]:
    """Give a massless pin's play [m], less where its radius is larger, and how soft its seat is, see `pin_on_teeth`."""
    play = design.pin_play - (larger if design.ring.has_sockets else 0.0)
    softness = pair_stiffness(design, design.tooth_pair) / pair_stiffness(design, design.seat_pair)
    return [significant(play), significant(softness)]


def _teeth(design: Design) -> Teeth:
    """Give what the collider must know of the gear's profile and its contact law."""
    law, gear, offset = curvature_law(design), gear_profile(design), profile_offset(design)
    rotation = design.modification.rotation
    ends = flank_ends(gear, offset, rotation) if rotation else FlankEnds(0.0, 0.0, 0.0, 0.0)
    return Teeth(
        radius=gear.pin_circle_radius,
        eccentricity=gear.eccentricity,
        teeth=float(gear.ring_teeth),
        offset=offset,
        reference=law.reference,
        constant=law.constant,
        deflection=law.deflection,
        ring_radius=design.ring.pin_circle_radius,
        rotation=rotation,
        tip=ends.tip,
        tip_radius=ends.tip_radius,
        valley=ends.valley,
        valley_radius=ends.valley_radius,
    )


def _add_gear(spec: Any, design: Design, properties: MassProperties) -> None:
    half, eccentricity = 0.5 * design.gear.face_width, design.gear.eccentricity
    gear = spec.worldbody.add_body(name=names.GEAR, pos=[0.0, eccentricity, 0.0])
    _planar(gear, names.GEAR, (0.0, eccentricity), "gear_angle")
    _inertial(gear, properties)
    _visual(gear, names.GEAR)
    made = deviations(design)
    # MuJoCo drops a pair whose bounding boxes are apart: this cylinder reaches every pin at every crank angle.
    reach = design.ring.pin_circle_radius + 2.0 * (eccentricity + made.largest)
    _contact_geom(gear, names.TEETH, Role.TEETH, reach, half, userdata=[significant(one) for one in _teeth(design)])
    _contact_geom(gear, names.BORE, Role.OUTER, design.gear.bore_radius + design.clearance.cam, half)
    hole = design.output.hole_radius + design.clearance.output
    for number, angle in enumerate(output_angles(design), start=1):
        place = _at(design.output.pin_circle_radius, angle, made.hole_place[number - 1])
        _contact_geom(gear, names.hole(number), Role.OUTER, hole, half, pos=place)


def _add_actuators(spec: Any, inertia: float, held: Held = "crank") -> tuple[float, float]:
    """Add the actuators of crank and output, a servo on the held shaft of this inertia; give the servo's gains."""
    kp, kv = significant(inertia * SERVO_BANDWIDTH**2), significant(2.0 * inertia * SERVO_BANDWIDTH)
    for shaft, name, joint in (("crank", names.DRIVE, names.CRANK_JOINT), ("output", names.LOAD, names.OUTPUT_JOINT)):
        actuator = spec.add_actuator(name=name, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        if shaft == held:
            actuator.set_to_position(kp=kp, kv=kv)
        else:
            actuator.set_to_motor()
    return kp, kv


def _add_sensors(spec: Any, design: Design) -> None:
    joint, actuator = mujoco.mjtObj.mjOBJ_JOINT, mujoco.mjtObj.mjOBJ_ACTUATOR
    kind = mujoco.mjtSensor
    seen = {
        "crank_angle": (kind.mjSENS_JOINTPOS, joint, names.CRANK_JOINT),
        "crank_speed": (kind.mjSENS_JOINTVEL, joint, names.CRANK_JOINT),
        "crank_torque": (kind.mjSENS_ACTUATORFRC, actuator, names.DRIVE),
        "gear_vx": (kind.mjSENS_JOINTVEL, joint, "gear_x"),
        "gear_vy": (kind.mjSENS_JOINTVEL, joint, "gear_y"),
        "gear_speed": (kind.mjSENS_JOINTVEL, joint, "gear_angle"),
        "output_angle": (kind.mjSENS_JOINTPOS, joint, names.OUTPUT_JOINT),
        "output_speed": (kind.mjSENS_JOINTVEL, joint, names.OUTPUT_JOINT),
        "load_torque": (kind.mjSENS_ACTUATORFRC, actuator, names.LOAD),
    }
    for group in names.sensors(design).values():
        for name in group:
            speed = name.endswith("_speed")
            angle = name.removesuffix("_speed") + "_angle" if speed else name
            default = (kind.mjSENS_JOINTVEL if speed else kind.mjSENS_JOINTPOS, joint, angle)
            sort, what, which = seen.get(name, default)
            spec.add_sensor(name=name, type=sort, objtype=what, objname=which)


def _add_pairs(spec: Any, mating: tuple[Pair, ...], laws: Mapping[str, ContactLaw]) -> Any:
    """Add the explicit pairs with each contact's physics; give the compiled model."""
    model = spec.compile()
    for pair in mating:
        bodies = [model.geom(name).bodyid[0] for name in (pair.on, pair.by)]
        inverse_weight = float(sum(model.body_invweight0[body, 0] for body in bodies))
        parameters = solver_parameters(laws[pair.kind], inverse_weight)
        spec.add_pair(
            name=pair.name,
            geomname1=pair.on,
            geomname2=pair.by,
            condim=parameters.condim,
            friction=list(parameters.friction),
            solref=list(parameters.solref),
            solreffriction=list(parameters.solreffriction),
            solimp=list(parameters.solimp),
            margin=0.0,
            gap=0.0,
        )
    return spec.compile()
