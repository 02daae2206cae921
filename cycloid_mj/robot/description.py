"""The joint in the formats of other simulators: URDF, SDF, Isaac Lab, and MJCF for MJX.

All have the same bodies. `housing` is the fixed side. `drive` turns by the crank's angle over the ratio: it has the
inertia of the crank reflected to the output, the friction without load and the motor's torque. `output` turns against
it within the play; a rigid joint has no play, and `drive` is a part of `output`.

URDF and SDF have no armature: the reflected inertia is that of a link, which also resists tilting if the housing moves.
Isaac Lab has one, so that its links have their own inertia only.
"""

from dataclasses import dataclass
from typing import Literal
from xml.etree import ElementTree

from cycloid_mj.base.array import significant
from cycloid_mj.base.units import RPM
from cycloid_mj.figures.geometry import mass as mechanism_mass
from cycloid_mj.parts import moving_masses
from cycloid_mj.parts.export.drive import drive_diameter, drive_length, drive_mass, has_casing
from cycloid_mj.parts.rv import axial_layout
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.robot.bam import fit_bam_models
from cycloid_mj.robot.files import choose_scenes
from cycloid_mj.robot.mjcf import MJCF, OUTPUT, joint_xml, scene_xml
from cycloid_mj.robot.reducer import ReducedJoint

Format = Literal["mjcf", "urdf", "sdf", "isaaclab", "mjx"]
"""Format of the files of a joint; ``mjcf`` are those of `robot.files`."""

HOUSING, DRIVE = "housing", "drive"
"""Links of the fixed side, and of what turns by the crank's angle over the ratio; the third is `OUTPUT`."""


@dataclass(frozen=True)
class DescriptionSettings:
    """Values in the files of other simulators that do not follow from the drive."""

    drive_mass: float = 1e-3
    """Mass of the link `drive` [kg], small against any drive: URDF and SDF have no inertia without mass."""
    side_share: float = 0.501
    """Smallest moment of inertia across the axis, over that about it: 0.5 for a flat body, and some rounding."""
    supply: float = 24.0
    """Supply voltage of the equivalent motor [V]; its torque and speed do not depend on it."""
    full_voltage_error: float = 0.1
    """Position error at which the equivalent servo applies its full voltage [rad]; assumed."""
    mjx_step_share: float = 0.5
    """Time step in MJX over that recommended for MuJoCo: speeds then differ by less than 1 % (docs/joint.md)."""


DESCRIPTION = DescriptionSettings()


PLAY = "passive_drive_backlash"
"""Name of the play joint for Isaac Lab, whose servo model finds the play of a joint `drive` by this name."""


SDF_VERSION = "1.11"


@dataclass(frozen=True)
class LinkInertia:
    """Mass [kg] and principal moments of inertia about the centre of mass [kg m2], z along the axis of the joint."""

    mass: float
    ixx: float
    iyy: float
    izz: float


def compute_link_inertias(reduced: ReducedJoint, reducer: Reducer, armature: bool = False) -> dict[str, LinkInertia]:
    """Compute mass [kg] and inertia [kg m2] of the links `housing`, `drive` and `output` of a reduced joint.

    The link `drive` has the crank's inertia, reflected to the output. With `armature`, the simulator adds the reflected
    inertia to the joint, and `drive` has the crank's own inertia only. At the level `rigid` there is no link `drive`,
    and its inertia is added to the output. The housing is a solid cylinder with diameter and length of the whole
    reducer, and with the mass of the reducer minus output and crank. Covers are included if the casing fits.
    """
    masses = moving_masses(reducer)
    crank_part = next(body.part for body in reducer.mechanism.bodies if reducer.INPUT_JOINT in body.joints)
    output_body, crank_body = masses[reducer.mechanism.turning], masses[crank_part]
    total_mass, radius, length = _measure_cylinder(reducer)
    housing_mass = total_mass - output_body.mass - crank_body.mass
    housing_transverse = housing_mass * (3.0 * radius**2 + length**2) / 12.0
    rotor_inertia = reduced.rotor_inertia if armature else reflected_rotor(reduced)
    izz = reduced.output_inertia + (rotor_inertia if reduced.level == "rigid" and not armature else 0.0)
    output_transverse = max(float(output_body.inertia[0, 0]), DESCRIPTION.side_share * izz)
    links = {
        HOUSING: LinkInertia(housing_mass, housing_transverse, housing_transverse, 0.5 * housing_mass * radius**2),
        OUTPUT: LinkInertia(output_body.mass + crank_body.mass, output_transverse, output_transverse, izz),
    }
    if reduced.level != "rigid":
        links[DRIVE] = LinkInertia(
            DESCRIPTION.drive_mass,
            DESCRIPTION.side_share * rotor_inertia,
            DESCRIPTION.side_share * rotor_inertia,
            rotor_inertia,
        )
    return links


def _measure_cylinder(reducer: Reducer) -> tuple[float, float, float]:
    """Compute the mass of the reducer [kg], and radius and length [m] of the cylinder that stands for its housing."""
    if has_casing(reducer):
        return drive_mass(reducer), 0.5 * drive_diameter(reducer), drive_length(reducer)
    if isinstance(reducer, RvReducer):
        length = axial_layout(reducer).length
    else:
        length = reducer.design.gear.stack_width + reducer.design.output.disc_thickness
    return mechanism_mass(reducer), reducer.design.housing.outer_radius, length


def reflected_rotor(reduced: ReducedJoint) -> float:
    """Compute the inertia of the crank at the output [kg m2]."""
    return reduced.ratio**2 * reduced.rotor_inertia


def write_descriptions(reduced: ReducedJoint, reducer: Reducer, file_format: Format) -> dict[str, bytes]:
    """Return the model files of a joint in a format other than ``mjcf``: name -> content.

    Parameters
    ----------
    reduced, reducer
        The joint, and the reducer whose masses its links have.
    file_format
        One of these:

        - ``urdf``, ``sdf``: NAME.urdf or NAME.sdf;
        - ``isaaclab``: NAME.urdf, and NAME_cfg.py with actuator configurations for Isaac Lab;
        - ``mjx``: joint.xml and scene.xml, with an integrator and a time step that suit MJX.
    """
    name = reduced.name
    if file_format == "mjx":
        scene, _ = choose_scenes(reduced, integrator="implicitfast")
        timestep = DESCRIPTION.mjx_step_share * scene.timestep
        text_by_file = {"joint.xml": joint_xml(reduced), "scene.xml": _without_noslip(reduced, scene.inertia, timestep)}
    elif file_format == "sdf":
        text_by_file = {f"{name}.sdf": sdf_text(reduced, reducer)}
    else:
        text_by_file = {f"{name}.urdf": urdf_text(reduced, reducer, armature=file_format == "isaaclab")}
        if file_format == "isaaclab":
            text_by_file[f"{_module_name(name)}_cfg.py"] = isaaclab_text(reduced, f"{name}.urdf")
    return {file: text.encode() for file, text in text_by_file.items()}


def list_description_files(name: str, file_format: Format) -> tuple[str, ...]:
    """Return the names of the files that `write_descriptions` returns for a design of this name in a format.

    The format is "urdf", "sdf", "isaaclab" or "mjx".
    """
    names_of_format = {
        "urdf": (f"{name}.urdf",),
        "sdf": (f"{name}.sdf",),
        "isaaclab": (f"{name}.urdf", f"{_module_name(name)}_cfg.py"),
        "mjx": ("joint.xml", "scene.xml"),
    }
    return names_of_format[file_format]


def urdf_text(reduced: ReducedJoint, reducer: Reducer, armature: bool = False) -> str:
    """Return the URDF of a reduced joint: links, the actuated joint `drive`, and the play, a passive joint `output`.

    A reduced joint is a robot joint with springs, backlash and losses instead of a reducer with parts; its levels of
    detail are `LEVELS`. The links have the masses of the reducer's parts. With `armature`, the simulator adds the
    crank's reflected inertia to the actuated joint, so that no link has it, and the passive joint is named `PLAY`. At
    the level `rigid` there is no play. All values are in SI units.
    """
    robot = ElementTree.Element("robot", name=reduced.name)
    robot.append(ElementTree.Comment(_describe_joint(reduced)))
    for name, link in compute_link_inertias(reduced, reducer, armature).items():
        inertial = ElementTree.SubElement(ElementTree.SubElement(robot, "link", name=name), "inertial")
        ElementTree.SubElement(inertial, "origin", xyz="0 0 0", rpy="0 0 0")
        ElementTree.SubElement(inertial, "mass", value=_format_number(link.mass))
        moments = {"ixx": link.ixx, "iyy": link.iyy, "izz": link.izz, "ixy": 0.0, "ixz": 0.0, "iyz": 0.0}
        ElementTree.SubElement(inertial, "inertia", {key: _format_number(moment) for key, moment in moments.items()})
    for joint in _list_joints(reduced, play=PLAY if armature else OUTPUT):
        element = ElementTree.SubElement(robot, "joint", name=joint.name, type=joint.kind)
        ElementTree.SubElement(element, "parent", link=joint.parent)
        ElementTree.SubElement(element, "child", link=joint.child)
        ElementTree.SubElement(element, "axis", xyz="0 0 1")
        limit = {"effort": _format_number(joint.effort), "velocity": _format_number(joint.speed)}
        if joint.stops:
            limit |= {"lower": _format_number(joint.stops[0]), "upper": _format_number(joint.stops[1])}
        ElementTree.SubElement(element, "limit", limit)
        dynamics = {"damping": _format_number(joint.damping), "friction": _format_number(joint.friction)}
        ElementTree.SubElement(element, "dynamics", dynamics)
    transmission = ElementTree.SubElement(robot, "transmission", name="reducer")
    ElementTree.SubElement(transmission, "type").text = "transmission_interface/SimpleTransmission"
    ElementTree.SubElement(transmission, "joint", name=_list_joints(reduced)[0].name)
    actuator = ElementTree.SubElement(transmission, "actuator", name="motor")
    ElementTree.SubElement(actuator, "mechanicalReduction").text = _format_number(reduced.way * reduced.ratio)
    return _format_xml(robot)


def sdf_text(reduced: ReducedJoint, reducer: Reducer) -> str:
    """Return the SDFormat model of a reduced joint (`SDF_VERSION`): links, the driven joint, and the play as a joint.

    The links have the masses of the reducer's parts. The stops at the ends of the play have the stiffness of the drive
    [N m/rad]. All values are in SI units.
    """
    root = ElementTree.Element("sdf", version=SDF_VERSION)
    model = ElementTree.SubElement(root, "model", name=reduced.name)
    model.append(ElementTree.Comment(_describe_joint(reduced)))
    for name, link in compute_link_inertias(reduced, reducer).items():
        inertial = ElementTree.SubElement(ElementTree.SubElement(model, "link", name=name), "inertial")
        ElementTree.SubElement(inertial, "mass").text = _format_number(link.mass)
        inertia = ElementTree.SubElement(inertial, "inertia")
        for key, value in (("ixx", link.ixx), ("iyy", link.iyy), ("izz", link.izz), ("ixy", 0.0), ("ixz", 0.0)):
            ElementTree.SubElement(inertia, key).text = _format_number(value)
        ElementTree.SubElement(inertia, "iyz").text = "0"
    for joint in _list_joints(reduced):
        element = ElementTree.SubElement(model, "joint", name=joint.name, type=joint.kind)
        ElementTree.SubElement(element, "parent").text = joint.parent
        ElementTree.SubElement(element, "child").text = joint.child
        axis = ElementTree.SubElement(element, "axis")
        ElementTree.SubElement(axis, "xyz").text = "0 0 1"
        limit = ElementTree.SubElement(axis, "limit")
        limits = {"effort": joint.effort, "velocity": joint.speed}
        if joint.stops:
            limits |= {"lower": joint.stops[0], "upper": joint.stops[1], "stiffness": joint.stiffness}
        for key, value in limits.items():
            ElementTree.SubElement(limit, key).text = _format_number(value)
        dynamics = ElementTree.SubElement(axis, "dynamics")
        ElementTree.SubElement(dynamics, "damping").text = _format_number(joint.damping)
        ElementTree.SubElement(dynamics, "friction").text = _format_number(joint.friction)
    return _format_xml(root)


def equivalent_motor(reduced: ReducedJoint) -> dict[str, float]:
    """Compute the parameters of a DC motor with the rated and peak torque of a reduced joint, for BAM.

    BAM (Better Actuator Models) simulates the motor of a robot joint. The robot's own motor is not known, so this motor
    replaces it; its values are those at the joint, not at the crank. Its torque decreases linearly with the speed, from
    the peak torque at rest to the rated torque at the rated speed.

    Returns
    -------
    dict
        Torque constant ``kt`` [N m/A]; ``resistance`` [ohm]; ``error_gain``, the share of the supply voltage per
        position error [1/rad]; and ``max_current`` [A].
    """
    stall_torque = MJCF.motor_peak * reduced.rated_torque
    no_load_speed = reduced.rated_speed / reduced.ratio / (1.0 - 1.0 / MJCF.motor_peak)
    torque_constant = DESCRIPTION.supply / no_load_speed
    return {
        "kt": torque_constant,
        "resistance": DESCRIPTION.supply * torque_constant / stall_torque,
        "error_gain": 1.0 / DESCRIPTION.full_voltage_error,
        "max_current": stall_torque / torque_constant,
    }


def isaaclab_text(reduced: ReducedJoint, urdf: str) -> str:
    """Return a Python module with the configurations of Isaac Lab for a reduced joint: motor, actuators and asset.

    `urdf` is the name of the URDF file. The configuration of the motor, `BamMotorCfg`, has the parameters of BAM's
    friction model M5. The play is a passive joint.
    """
    drive_joint = _list_joints(reduced)[0]
    friction = {key: value for key, value in fit_bam_models(reduced)["m5"].items() if isinstance(value, float)}
    del friction["armature"]
    motor_values = {**equivalent_motor(reduced), **friction}
    parameters = "".join(f"    {key}={_format_number(value)},\n" for key, value in motor_values.items())
    play_actuator = (
        ""
        if reduced.level == "rigid"
        else f'''    "play": ImplicitActuatorCfg(
        joint_names_expr=["{PLAY}"],
        stiffness=0.0,
        damping={_format_number(reduced.damping)},
    ),
'''
    )
    return f'''"""{_describe_joint(reduced)}

Isaac Lab 3: `REDUCER_CFG` is the asset with its actuators. The servo model needs the solver MJWarp of Newton. kt,
resistance, error_gain, max_current, kp_fw and vin are those of an equivalent motor at the joint: replace them by yours.
"""

from pathlib import Path

import isaaclab.sim as sim_utils
from isaaclab.actuators import BamActuatorCfg, BamMotorCfg, ImplicitActuatorCfg
from isaaclab.assets import ArticulationCfg

MOTOR = BamMotorCfg(
    model="m5",
{parameters})

ACTUATORS = {{
    "drive": BamActuatorCfg(
        joint_names_expr=["{drive_joint.name}"],
        motor=MOTOR,
        kp_fw=1.0,
        vin={_format_number(DESCRIPTION.supply)},
        actuator_effort_limit={_format_number(drive_joint.effort)},
        actuator_velocity_limit={_format_number(drive_joint.speed)},
        armature={_format_number(reflected_rotor(reduced))},
    ),
{play_actuator}}}

REDUCER_CFG = ArticulationCfg(
    spawn=sim_utils.UrdfFileCfg(
        asset_path=str(Path(__file__).with_name("{urdf}")),
        fix_base=True,
        joint_drive=None,
    ),
    actuators=ACTUATORS,
)
'''


@dataclass(frozen=True)
class _Joint:
    """A joint of URDF and SDF: its limits [N m, rad/s, rad], stiffness [N m/rad], damping and friction [N m]."""

    name: str
    kind: str
    parent: str
    child: str
    effort: float
    speed: float
    damping: float
    friction: float
    stops: tuple[float, float] | None = None
    stiffness: float = 0.0


def _list_joints(reduced: ReducedJoint, play: str = OUTPUT) -> tuple[_Joint, ...]:
    """List the joints of a reduced joint in URDF and SDF: the driven joint and, unless rigid, that of the play.

    `play` is the name of the joint of the play.
    """
    effort, speed = MJCF.motor_peak * reduced.rated_torque, reduced.rated_speed / reduced.ratio
    friction, viscous = reduced.no_load_torque_at_output, reduced.no_load_damping_at_output
    if reduced.level == "rigid":
        return (_Joint(OUTPUT, "continuous", HOUSING, OUTPUT, effort, speed, viscous, friction),)
    return (
        _Joint(DRIVE, "continuous", HOUSING, DRIVE, effort, speed, viscous, friction),
        _Joint(
            *(play, "revolute", DRIVE, OUTPUT, effort, speed, reduced.damping, 0.0),
            reduced.stops,
            sum(spring.stiffness for spring in reduced.springs),
        ),
    )


def _without_noslip(reduced: ReducedJoint, inertia: float, timestep: float) -> str:
    """Return the scene for MJX, which has neither the noslip solver nor the integrator ``discrete``."""
    scene = scene_xml(reduced, inertia, timestep, "implicitfast")
    return scene.replace(f' noslip_iterations="{MJCF.noslip}"', "")


def _describe_joint(reduced: ReducedJoint) -> str:
    """Return a sentence on the joint for the head of a file."""
    text = (
        f"The reducer {reduced.name} as a joint, level {reduced.level}, by cycloid-mj reduce: {reduced.ratio:g}:1, "
        f"rated {reduced.rated_torque:.4g} N m at {reduced.rated_speed / RPM:.0f} rpm of the crank."
    )
    return text.replace("--", "- -")


def _format_xml(root: ElementTree.Element) -> str:
    """Return an indented XML document."""
    ElementTree.indent(root)
    return f'<?xml version="1.0"?>\n{ElementTree.tostring(root, encoding="unicode")}\n'


def _module_name(name: str) -> str:
    """Return a name as that of a Python module."""
    return "".join(letter if letter.isalnum() else "_" for letter in name)


def _format_number(value: float) -> str:
    return f"{significant(value):.9g}"
