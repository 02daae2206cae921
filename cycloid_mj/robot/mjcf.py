"""The joint as MJCF for MuJoCo alone: `joint.xml` to include, `scene.xml` to open."""

import math
from dataclasses import dataclass

from cycloid_mj.base.array import significant
from cycloid_mj.base.units import RPM
from cycloid_mj.robot.reducer import ReducedJoint

OUTPUT = "output"
"""Name of the output's joint; its parts are named after it, as by `attach_reducer`."""


@dataclass(frozen=True)
class JointSettings:
    """Parameters of a joint in MJCF that are not of the reducer."""

    mass: float = 1e-9
    """Mass of the rotor's body [kg]: its inertia is the joint's armature, its weight belongs to the robot's link."""
    rotor_size: tuple[float, float] = (0.02, 0.01)
    """Radius and half length of the drawn rotor [m]."""
    sticking_time: float = 0.004
    sticking_impedance: tuple[float, ...] = (0.9999, 0.9999, 0.001, 0.5, 2.0)
    """Parameters of friction, `solreffriction` and `solimpfriction`: with MuJoCo's defaults, a sticking crank would
    creep at some rad/s, and a self-locking reducer would lower its load."""
    slip_time: float = 2e-3
    """Smallest period of a slip element over 2 pi [s]: resolved by time steps of 2 ms. It has half the critical
    damping."""
    noslip: int = 5
    """Iterations of MuJoCo's noslip solver in the scene of a joint with slip elements: without it, sticking friction
    creeps, and a slow loop is narrower than a fast one."""
    motor_peak: float = 3.0
    """Largest torque of the motor in the scene, over the rated input torque."""


MJCF = JointSettings()


def rotor_name(joint: str) -> str:
    """Return the name of a joint's crank: body, joint and geom."""
    return f"{joint}_rotor"


def reducer_name(joint: str, number: int = 0) -> str:
    """Return the name of a joint's spring, and of the tuple of all parts; the first spring has no number."""
    return f"{joint}_reducer_{number + 1}" if number else f"{joint}_reducer"


def slip_name(joint: str, number: int) -> str:
    """Return the name of a joint's slip element: its spring and body."""
    return f"{joint}_slip_{number + 1}"


def slip_inertias(reduced: ReducedJoint) -> list[tuple[float, float]]:
    """Compute armature (added inertia) and damping of each slip element of a reduced joint in MuJoCo.

    A slip element is a spring in series with constant friction; `reduced` has those of the joint. The armature is at
    least the smallest that is stable at the time step (`MJCF.slip_time`). Some are larger, so that all elements creep
    equally fast: without MuJoCo's noslip solver, creep is proportional to slip limit divided by armature.

    Returns
    -------
    list of tuple
        Armature [kg m2] and damping [N m s/rad] of each element.
    """
    min_armatures = [slip.stiffness * MJCF.slip_time**2 for slip in reduced.slips]
    total_limit = sum(slip.limit for slip in reduced.slips)
    armatures = [
        max(armature, sum(min_armatures) * slip.limit / total_limit)
        for armature, slip in zip(min_armatures, reduced.slips, strict=True)
    ]
    return [
        (armature, math.sqrt(slip.stiffness * armature))
        for armature, slip in zip(armatures, reduced.slips, strict=True)
    ]


def joint_xml(reduced: ReducedJoint, joint: str = OUTPUT) -> str:
    """Return the MJCF of a reducer for inclusion in a robot's model: crank, springs to the hinge `joint`, and motor.

    At the level `rigid` there are neither crank nor springs; the hinge itself has the friction and inertia.
    """
    name = reduced.name.replace("--", "- -")  # which would end a comment
    body = (
        _elements_without_springs(reduced, joint)
        if reduced.level == "rigid"
        else _elements_with_springs(reduced, joint)
    )
    return f"""<mujoco model="reducer">
  <!-- The reducer {name} as one joint, level {reduced.level}, by cycloid-mj reduce.
       {reduced.ratio:g}:1, rated {reduced.rated_torque:.4g} N m at {reduced.rated_speed / RPM:.0f} rpm of the crank.
       Include it in a robot whose hinge is called "{joint}" and has class="{reducer_name(joint)}". -->
{body}</mujoco>
"""


def scene_xml(reduced: ReducedJoint, load_inertia: float, timestep: float, integrator: str = "discrete") -> str:
    """Return the MJCF of a test scene: the joint model of a reducer, a motor on its crank, and a load on its output.

    The scene includes the joint model from ``joint.xml`` in the same folder. `load_inertia` is the inertia of the load
    [kg m2], `timestep` the time step [s], and `integrator` the value of MuJoCo's option of that name. The control of
    the motor is its torque on the crank [N m].
    """
    inertia = xml_number(load_inertia)
    direction = "against" if reduced.way < 0 else "with"
    noslip = f' noslip_iterations="{MJCF.noslip}"' if reduced.slips and reduced.level != "rigid" else ""
    return f"""<mujoco model="reducer {reduced.name}">
  <!-- ctrl is the motor's torque on the crank [N m]; the output turns {direction} it. -->
  <option timestep="{xml_number(timestep)}" integrator="{integrator}" gravity="0 0 0"{noslip}/>
  <statistic extent="0.4" center="0 0 0.05"/>
  <include file="joint.xml"/>
  <worldbody>
    <light pos="0.3 0.3 1" dir="-0.3 -0.3 -1"/>
    <body name="load" pos="0 0 0.05">
      <inertial pos="0 0 0" mass="1" diaginertia="{inertia} {inertia} {inertia}"/>
      <joint name="{OUTPUT}" class="{reducer_name(OUTPUT)}" axis="0 0 1"/>
      <geom type="box" pos="0.06 0 0" size="0.06 0.012 0.008" contype="0" conaffinity="0" rgba="0.25 0.69 0.54 1"/>
      <geom type="cylinder" size="0.04 0.006" contype="0" conaffinity="0" rgba="0.55 0.75 0.89 1"/>
    </body>
  </worldbody>
  <sensor>
    <jointpos name="output_angle" joint="{OUTPUT}"/>
    <jointvel name="output_speed" joint="{OUTPUT}"/>
  </sensor>
</mujoco>
"""


def _elements_with_springs(reduced: ReducedJoint, joint: str) -> str:
    """Return the MJCF elements of a reduced joint with springs: crank body, slip elements, tendons, motor and tuple.

    `joint` is the name of the hinge. The tuple lists the joints and tendons of the reducer, for `ReducedJoint.places`.
    """
    rotor = rotor_name(joint)
    tendons, elements = [], []
    for index, spring in enumerate(reduced.springs):
        name, damping = reducer_name(joint, index), reduced.damping if index == 0 else 0.0
        lower_end, upper_end = reduced.stops[0] - spring.start, reduced.stops[1] + spring.start
        tendons.append(
            f'    <fixed name="{name}" springlength="{xml_number(lower_end)} {xml_number(upper_end)}" '
            f'stiffness="{xml_number(spring.stiffness)}" damping="{xml_number(damping)}">'
            f'<joint joint="{rotor}" coef="{xml_number(reduced.coefficient)}"/>'
            f'<joint joint="{joint}" coef="1"/></fixed>\n'
        )
        elements.append(f'<element objtype="tendon" objname="{name}"/>')
    slip_bodies = []
    for index, (slip, (armature, damping)) in enumerate(zip(reduced.slips, slip_inertias(reduced), strict=True)):
        name = slip_name(joint, index)
        slip_bodies.append(
            f'    <body name="{name}">\n      <inertial pos="0 0 0" mass="{MJCF.mass}" '
            f'diaginertia="1e-12 1e-12 1e-12"/>\n      <joint name="{name}" axis="0 0 1" '
            f'armature="{xml_number(armature)}" frictionloss="{xml_number(slip.limit)}" {_sticking()} '
            'damping="0" limited="false"/>\n    </body>\n'
        )
        tendons.append(
            f'    <fixed name="{name}" springlength="0" stiffness="{xml_number(slip.stiffness)}" '
            f'damping="{xml_number(damping)}">'
            f'<joint joint="{rotor}" coef="{xml_number(reduced.coefficient)}"/><joint joint="{joint}" coef="1"/>'
            f'<joint joint="{name}" coef="-1"/></fixed>\n'
        )
    radius, length = MJCF.rotor_size
    return f"""  <default>
    <default class="{reducer_name(joint)}">
      <joint armature="{xml_number(reduced.output_inertia)}"/>
    </default>
  </default>
  <worldbody>
    <!-- Under the link that holds the motor, if that moves; the axis is that of the joint. -->
    <body name="{rotor}">
      <inertial pos="0 0 0" mass="{MJCF.mass}" diaginertia="1e-12 1e-12 1e-12"/>
      <joint name="{rotor}" axis="0 0 1" armature="{xml_number(reduced.rotor_inertia)}" \
frictionloss="{xml_number(reduced.no_load_torque)}" {_sticking()} damping="0" limited="false"/>
      <geom name="{rotor}" type="cylinder" size="{radius} {length}" contype="0" conaffinity="0" \
mass="{MJCF.mass}" rgba="0.93 0.65 0.49 1"/>
    </body>
{"".join(slip_bodies)}  </worldbody>
  <tendon>
{"".join(tendons)}  </tendon>
  <actuator>
    <motor name="motor" joint="{rotor}" ctrlrange="{_control_range(reduced)}"/>
  </actuator>
  <custom>
    <tuple name="{reducer_name(joint)}"><element objtype="joint" objname="{joint}" prm="{reduced.fingerprint}"/>\
<element objtype="joint" objname="{rotor}"/>{"".join(elements)}</tuple>
  </custom>
"""


def _elements_without_springs(reduced: ReducedJoint, joint: str) -> str:
    """Return the MJCF elements of a rigid reduced joint: default class of the hinge, motor and tuple.

    `joint` is the name of the hinge. The tuple lists it as the reducer's joint, for `ReducedJoint.places`.
    """
    friction, gear = xml_number(reduced.no_load_torque_at_output), xml_number(reduced.way * reduced.ratio)
    return f"""  <default>
    <default class="{reducer_name(joint)}">
      <joint armature="{xml_number(reduced.reflected_inertia)}" frictionloss="{friction}" {_sticking()}/>
    </default>
  </default>
  <actuator>
    <motor name="motor" joint="{joint}" gear="{gear}" ctrlrange="{_control_range(reduced)}"/>
  </actuator>
  <custom>
    <tuple name="{reducer_name(joint)}"><element objtype="joint" objname="{joint}" prm="{reduced.fingerprint}"/></tuple>
  </custom>
"""


def _sticking() -> str:
    """Return the MJCF attributes of friction with which a joint sticks."""
    solimp = " ".join(f"{value:g}" for value in MJCF.sticking_impedance)
    return f'solreffriction="{MJCF.sticking_time:g} 1" solimpfriction="{solimp}"'


def _control_range(reduced: ReducedJoint) -> str:
    limit = xml_number(MJCF.motor_peak * reduced.rated_torque / reduced.ratio)
    return f"-{limit} {limit}"


def xml_number(value: float) -> str:
    """Format a number for XML, without rounding errors in its last digits."""
    return f"{significant(value):.12g}"
