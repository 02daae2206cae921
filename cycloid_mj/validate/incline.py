"""Validation step "friction": a block and a cylinder on an incline, with the contact parameters of a pin on the disc.

The incline is a tilted gravity; both bodies touch the plane at one point. The block cannot rotate. Below Coulomb's
limit friction is proportional to the sliding speed, so that a sticking contact creeps.
"""

import math
from dataclasses import dataclass
from typing import Any

import mujoco

from cycloid_mj.base.validation import ValidationRow, relative
from cycloid_mj.design import PRESETS
from cycloid_mj.dynamics.law import FRICTION, ContactParameters, contact_law, solver_parameters
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class InclineConditions:
    """Conditions of a body on an incline."""

    mass: float = 0.25
    radius: float = 0.02
    gravity: float = 9.8
    creep_speed: float = 0.02
    """Mass [kg], radius [m], gravity [m/s2], and creep speed [m/s]."""
    timestep: float = 2e-6
    duration: float = 0.02
    """Time step and duration of a run [s]."""


INCLINE = InclineConditions()

_BODY = """<mujoco>
  <option timestep="{timestep!r}" gravity="{along!r} {down!r} 0" impratio="{impratio!r}"
    tolerance="1e-12" cone="elliptic"/>
  <worldbody>
    <geom name="plane" type="plane" size="1 1 1" zaxis="0 1 0"/>
    <body pos="0 {radius!r} 0">
      <joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>{turn}
      <inertial pos="0 0 0" mass="{mass!r}" diaginertia="{inertia!r} {inertia!r} {inertia!r}"/>
      <geom name="foot" type="sphere" size="{radius!r}"/></body>
  </worldbody>
  <contact>{pair}</contact>
</mujoco>"""
_PAIR = (
    '<pair geom1="plane" geom2="foot" condim="{condim}" friction="{friction}" solref="{solref}" '
    'solreffriction="{solreffriction}" solimp="{solimp}"/>'
)
_TURN = '<joint name="turn" type="hinge" axis="0 0 1"/>'


@dataclass(frozen=True)
class Descent:
    """Motion down the incline at its end: `acceleration` [m/s2], `speed` and `slip` speed in the contact [m/s]."""

    acceleration: float
    speed: float
    slip: float


def rows(quick: bool) -> list[ValidationRow]:
    """Compare creep, sliding and rolling of bodies on an incline in MuJoCo with closed forms.

    The slopes (tangents of the angle) are 0.5, 3 and 2 times the friction coefficient, in this order. `quick` is
    ignored.
    """
    contact_parameters = pair_law()
    small_angle, large_angle = (
        math.atan(0.5 * contact_parameters.friction),
        math.atan(3.0 * contact_parameters.friction),
    )
    creeping_block, sliding_block = (
        simulate_descent(contact_parameters, small_angle, False),
        simulate_descent(contact_parameters, large_angle, False),
    )
    rolling_cylinder = simulate_descent(contact_parameters, math.atan(2.0 * contact_parameters.friction), True)
    gravity_along = INCLINE.gravity * math.sin(math.atan(2.0 * contact_parameters.friction))
    creep_pair = (
        1e6 * creeping_block.speed,
        1e6 * INCLINE.mass * INCLINE.gravity * math.sin(small_angle) / contact_parameters.creep,
    )
    acceleration_pair = (
        sliding_block.acceleration,
        INCLINE.gravity * (math.sin(large_angle) - contact_parameters.friction * math.cos(large_angle)),
    )
    slip_pair, rolling_acceleration = (
        (1e6 * rolling_cylinder.slip, 1e6 * INCLINE.mass * gravity_along / 3.0 / contact_parameters.creep),
        2.0 * gravity_along / 3.0,
    )
    return [
        relative("creep of a block below the friction angle", *creep_pair, "um/s", "m g sin/creep", 5e-6),
        relative("acceleration of a block above it", *acceleration_pair, "m/s2", "g (sin - mu cos)", 1e-6),
        relative(
            "acceleration of a rolling cylinder",
            rolling_cylinder.acceleration,
            rolling_acceleration,
            "m/s2",
            "2/3 g sin",
            5e-5,
        ),
        relative("slip of the rolling cylinder", *slip_pair, "um/s", "m g sin/(3 creep)", 2.5e-3),
    ]


def pair_law() -> ContactParameters:
    """Compute the contact law of a pin on the disc for a body of `INCLINE.mass`."""
    design = Reducer(PRESETS["pin"]).at_rated_load
    friction = design.design.friction.pin_gear
    creep = friction * design.contacts["pin_gear"].force / INCLINE.creep_speed
    stiffness = design.contacts.teeth.curvature_law.stiffness
    return contact_law(stiffness, design.design.contact.damping_ratio, INCLINE.mass, friction, creep, INCLINE.timestep)


def simulate_descent(contact_parameters: ContactParameters, angle: float, is_cylinder: bool) -> Descent:
    """Simulate a block, or a cylinder if `is_cylinder`, on an incline of `angle` [rad], from rest.

    `contact_parameters` are MuJoCo's for the contact. At the start, the contact has the penetration of static
    equilibrium. Returns the mean acceleration over the second half of `INCLINE.duration` [m/s2], and speed and slip at
    the end [m/s].
    """
    model = incline_model(contact_parameters, angle, is_cylinder)
    data = mujoco.MjData(model)
    data.joint("y").qpos[0] = -INCLINE.mass * INCLINE.gravity * math.cos(angle) / contact_parameters.stiffness
    half_duration = 0.5 * INCLINE.duration
    half_steps = round(half_duration / INCLINE.timestep)
    mujoco.mj_step(model, data, half_steps)
    middle_speed = float(data.joint("x").qvel[0])
    mujoco.mj_step(model, data, half_steps)
    speed = float(data.joint("x").qvel[0])
    angular_speed = float(data.joint("turn").qvel[0]) if is_cylinder else 0.0
    return Descent((speed - middle_speed) / half_duration, speed, speed + INCLINE.radius * angular_speed)


def incline_model(contact_parameters: ContactParameters, angle: float, is_cylinder: bool) -> Any:
    """Compile the MuJoCo model (`MjModel`) of a block, or a cylinder if `is_cylinder`, on an incline of `angle` [rad].

    A cylinder can rotate and has the inertia m r^2/2. The model is compiled twice, as the solver parameters of the
    contact depend on its masses.
    """
    model = _compile_model("", angle, is_cylinder)
    bodies = [model.geom(name).bodyid[0] for name in ("plane", "foot")]
    parameters = solver_parameters(contact_parameters, float(sum(model.body_invweight0[body, 0] for body in bodies)))
    pair = _PAIR.format(
        condim=parameters.condim,
        friction=_words(parameters.friction),
        solref=_words(parameters.solref),
        solreffriction=_words(parameters.solreffriction),
        solimp=_words(parameters.solimp),
    )
    return _compile_model(pair, angle, is_cylinder)


def _compile_model(pair: str, angle: float, is_cylinder: bool) -> Any:
    """Compile the MuJoCo model of a body on an incline of an angle [rad] with the XML of its contact `pair`.

    The body is a cylinder, which can rotate, if `is_cylinder`, else a block.
    """
    xml = _BODY.format(
        timestep=INCLINE.timestep,
        along=INCLINE.gravity * math.sin(angle),
        down=-INCLINE.gravity * math.cos(angle),
        impratio=FRICTION.impratio,
        radius=INCLINE.radius,
        mass=INCLINE.mass,
        inertia=0.5 * INCLINE.mass * INCLINE.radius**2,
        turn=_TURN if is_cylinder else "",
        pair=pair,
    )
    return mujoco.MjModel.from_xml_string(xml)


def _words(values: tuple[float, ...]) -> str:
    return " ".join(map(repr, values))
