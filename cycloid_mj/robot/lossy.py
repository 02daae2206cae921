"""Load-dependent losses in stock MJCF: the springs of the joint press a brake shoe on the crank.

The shoe is on the crank's axis between two plates of the crank, on a lever. The length of each spring depends on the
lever's angle, so that the spring presses the shoe on one of the plates with a share of its torque. A contact with
torsional friction only brakes the crank. The lever's hinge is tilted, so that friction presses the shoe on or lifts it,
like the leading and the trailing shoe of a drum brake. Which of both depends on the plate and on the direction of the
crank, that is, on whether crank or output drives. So one shoe has the losses of driving and of back-driving.

Two details matter. The reference damping of friction is small, because MuJoCo's soft cone turns it into a force that
lifts a fast sliding shoe off (`SHOE.lift`). With nearly none, friction controls the acceleration of the tilted
shoe and not its speed, so that it drifts, and rubs in the wrong direction, for seconds. The shoe has an armature but no
mass: it carries the springs, deflects by `SHOE.deflection` of the wind-up, and has neither weight nor impacts.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import mujoco
import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.result import Table
from cycloid_mj.robot.friction import joint_powers
from cycloid_mj.robot.mjcf import OUTPUT, joint_xml, reducer_name, rotor_name, scene_xml, xml_number
from cycloid_mj.robot.reducer import ReducedJoint
from cycloid_mj.robot.trial import TrialScene


@dataclass(frozen=True)
class ShoeSettings:
    """Dimensions, contact and fit of the shoe, and its trial."""

    fitted: tuple[float, ...] = (0.05, 0.125, 0.25, 0.5, 0.75, 1.0)
    """Shares of the nominal torque at which the loss of the full model is fitted."""
    compared: tuple[float, ...] = (0.1, 0.5, 1.0)
    """Shares of the nominal torque at which the lossy joint is compared with the full model."""
    deflection: float = 0.01
    """Deflection of the shoe under the nominal torque, over the wind-up: with less, the shoe bounces off its plate."""
    stiffness: float = 1e4
    """Reference stiffness of the contact [1/s2], stable with a time step of 5 ms."""
    impedance: float = 0.9999
    """Impedance of the contact."""
    lift: float = 5e-3
    """Lift of the shoe by friction at the rated speed, over its deflection under the nominal torque."""
    max_leading: float = 0.9
    """Largest share of its force by which friction presses the shoe on: at 1 it would lock."""
    lever: float = 0.02
    """Lever of the shoe [m]."""
    radius: float = 0.005
    """Radius of the shoe [m]."""
    half: float = 0.001
    """Half the thickness of the plates [m]."""
    height: float = 0.03
    """Height of the shoe above the crank's middle [m]."""
    trial_time: float = 0.4
    trial_step: float = 1e-4
    """Duration of a trial, whose second half is evaluated, as the shoe rests by then; and its time step [s]."""


SHOE = ShoeSettings()


@dataclass(frozen=True)
class Shoe:
    """Shoe of a joint."""

    shares: Array
    """Coefficient of its axial position in the length of each spring [rad/m], shape (springs,)."""
    friction: float
    """Friction torque about the axis over the force on the plate [m]."""
    leading: float
    """Share t of its force by which its friction presses it on, or lifts it: the friction is S/(1 - t) or S/(1 + t)."""
    armature: float
    """Axial armature [kg]."""
    creep: float
    """Reference damping of the friction [1/s]."""


def fit_shoe(reduced: ReducedJoint) -> Shoe:
    """Fit a brake shoe in MJCF that imitates the load-dependent friction of a reduced joint.

    `reduced` is the joint model. The fit covers a driving crank and a driving output. Friction presses a leading shoe
    on and lifts a trailing shoe, by the share t of the force on the shoe (`Shoe.leading`). If S is the friction without
    this effect, the leading shoe has the friction S/(1 - t), the trailing shoe S/(1 + t). S is therefore the harmonic
    mean of both. It is a weighted sum of the springs' torques, whose weights are fitted by nonnegative least squares.
    The fitted values are the friction minus that without load, at `SHOE.fitted` of the nominal torque and the rated
    speed. t is limited to `SHOE.max_leading`, because the shoe would lock at 1.
    """
    from scipy.optimize import nnls

    loads = np.array(SHOE.fitted) * reduced.rated_torque
    wind_ups = [reduced.wind_up(load) for load in loads.tolist()]
    spring_torques = np.array(
        [[spring.stiffness * max(wind_up - spring.start, 0.0) for spring in reduced.springs] for wind_up in wind_ups]
    )
    driving_friction, driven_friction = (
        np.maximum(
            [
                reduced.friction.torque(load, reduced.rated_speed, is_driving) - reduced.no_load_torque
                for load in loads.tolist()
            ],
            np.finfo(float).tiny,
        )
        for is_driving in (True, False)
    )
    # a compromise between errors of torque and of efficiency: large loads have more weight
    weights, total_friction = 1.0 / np.sqrt(loads), driving_friction + driven_friction
    sums, differences = weights * total_friction, weights * (driving_friction - driven_friction)
    leading_share = float(np.clip(differences @ sums / (sums @ sums), -SHOE.max_leading, SHOE.max_leading))
    spring_weights, _ = nnls(
        weights[:, np.newaxis] * spring_torques, weights * 2.0 * driving_friction * driven_friction / total_friction
    )
    friction = max(float(spring_weights.max()), np.finfo(float).tiny)
    spring_shares = spring_weights / friction
    deflection = SHOE.deflection * reduced.wind_up(reduced.rated_torque)
    # a contact deflects by (1 - d) F/(m k d) under a force F, and the springs' lengths by their shares of that
    contact_force = float(spring_torques[-1] @ spring_shares)
    armature = (1.0 - SHOE.impedance) * contact_force / (SHOE.stiffness * SHOE.impedance * deflection)
    # the cone adds the coefficient times damping and speed to the reference acceleration along the axis
    creep = SHOE.lift * SHOE.stiffness * deflection / (friction * reduced.rated_speed)
    return Shoe(spring_shares, friction, leading_share, armature, creep)


def lossy_joint_xml(reduced: ReducedJoint) -> str:
    """Return the MJCF of a joint whose friction grows with the load by a brake shoe, without Python code.

    For the shoe, see `fit_shoe`. At the level `rigid`, it has no shoe. A model that includes it needs elliptic friction
    cones and the integrator of `lossy_scene_xml`. Slip elements (`ReducedJoint.slips`) are left out, because they creep
    with that integrator.
    """
    text = joint_xml(replace(reduced, slips=()))
    if reduced.level == "rigid":
        return text
    shoe, crank_name, name = fit_shoe(reduced), rotor_name(OUTPUT), f"{OUTPUT}_shoe"
    # tan(angle) of the hinge; its turn q moves the shoe by its lever cos(angle) q along the axis
    tilt = reduced.way * shoe.leading * SHOE.lever / shoe.friction
    axial_lever = SHOE.lever / math.hypot(1.0, tilt)
    plates, contact_pairs = [], []
    for index, side in enumerate((-1, 1)):
        plates.append(
            f'      <geom name="{name}_plate_{index}" type="box" '
            f'pos="0 0 {SHOE.height + side * (SHOE.radius + SHOE.half):g}" '
            f'size="{SHOE.radius} {SHOE.radius} {SHOE.half}" contype="0" conaffinity="0" mass="1e-9"/>\n'
        )
        contact_pairs.append(
            f'    <pair geom1="{name}_plate_{index}" geom2="{name}" condim="4" '
            f'friction="0 0 {xml_number(shoe.friction)} 0 0" '
            f'solref="{-SHOE.stiffness:g} {-2.0 * SHOE.stiffness**0.5:g}" '
            f'solreffriction="-1 {-shoe.creep:g}" solimp="{SHOE.impedance} {SHOE.impedance} 0.001 0.5 2"/>\n'
        )
    # a centre of mass off the axis: with one on the axis, MuJoCo counts only this body's mass as moving
    body = f"""    <body name="{name}" pos="0 0 {SHOE.height}">
      <inertial pos="0.001 0 0" mass="1e-9" diaginertia="1e-12 1e-12 1e-12"/>
      <joint name="{name}" type="hinge" pos="{SHOE.lever} 0 0" axis="0 1 {xml_number(tilt)}" \
armature="{xml_number(shoe.armature * axial_lever**2)}" limited="false"/>
      <geom name="{name}" type="sphere" size="{SHOE.radius}" contype="0" conaffinity="0" mass="1e-9"/>
    </body>
"""
    xml_head, xml_tail = text.split("    </body>\n  </worldbody>\n")
    xml_head += (
        f"{''.join(plates)}    </body>\n{body}  </worldbody>\n  <contact>\n{''.join(contact_pairs)}  </contact>\n"
    )
    for index, share in enumerate(shoe.shares.tolist()):
        tendon, remaining_text = xml_tail.split(f'<fixed name="{reducer_name(OUTPUT, index)}"')
        lever_joint = f'<joint joint="{name}" coef="{xml_number(axial_lever * share)}"/></fixed>'
        xml_tail = (
            f'{tendon}<fixed name="{reducer_name(OUTPUT, index)}"{remaining_text.replace("</fixed>", lever_joint, 1)}'
        )
    comment = f"Losses grow with the load by the shoe {name} on {crank_name}: for friction cones that are elliptic. "
    return (xml_head + xml_tail).replace("<!-- ", f"<!-- {comment}\n       ", 1)


def lossy_scene_xml(reduced: ReducedJoint, load_inertia: float, timestep: float) -> str:
    """Return `scene_xml` for lossy_joint.xml: elliptic cones, and an integrator with which the shoe does not drift.

    `load_inertia` is in kg m2, `timestep` in seconds.
    """
    scene = scene_xml(reduced, load_inertia, timestep, "discrete")
    return scene.replace("joint.xml", "lossy_joint.xml").replace("<option ", '<option cone="elliptic" ')


class StockEfficiency(NamedTuple):
    """Efficiency of the lossy joint in MuJoCo alone and of the full model [%], at a share of the nominal torque."""

    share: float
    driving: bool
    percent: float
    full_model_percent: float


def lossy_efficiencies(reduced: ReducedJoint) -> list[StockEfficiency]:
    """Compute the efficiencies [%] of joint and full model at several loads; the joint has the brake shoe in MuJoCo.

    The loads are shares of the nominal torque, `SHOE.compared`. All loads with the crank driving come first, then all
    with the output driving. `reduced` is the joint model of the drive.
    """
    return [
        StockEfficiency(
            share,
            is_driving,
            100.0 * lossy_efficiency(reduced, share, is_driving),
            100.0
            * reduced.friction.efficiency(share * reduced.rated_torque, reduced.rated_speed, reduced.ratio, is_driving),
        )
        for is_driving in (True, False)
        for share in SHOE.compared
    ]


def lossy_table(efficiencies: Sequence[StockEfficiency]) -> Table:
    """Tabulate the efficiencies [%] of the joint in lossy_joint.xml next to those of the full model, a row per load.

    In this file a brake shoe on the crank imitates the losses, in MuJoCo alone.
    """
    rows = tuple(
        (
            f"{'driving' if efficiency.driving else 'back-driven'}, {efficiency.share:.0%} of the nominal torque",
            f"{efficiency.percent:.2f}",
            f"{efficiency.full_model_percent:.2f}",
            f"{efficiency.percent - efficiency.full_model_percent:+.2f}",
        )
        for efficiency in efficiencies
    )
    return Table(
        "lossy_joint.xml: efficiency in MuJoCo alone [%]", ("condition", "joint", "full model", "difference"), rows
    )


def lossy_efficiency(reduced: ReducedJoint, share: float, driving: bool) -> float:
    """Measure the efficiency [1] of a joint with brake shoe at its rated speed, in MuJoCo without Python code.

    `share` is the torque on the output relative to the nominal torque. `driving` is True if the crank drives, False if
    the output does; the result is 0 for a self-locking joint. `reduced` is the joint model of the drive.
    """
    scene = lossy_scene_xml(reduced, reduced.reflected_inertia, SHOE.trial_step)
    files = {"lossy_joint.xml": lossy_joint_xml(reduced).encode()}
    model = mujoco.MjModel.from_xml_string(scene, files)
    # no step of Python: MJCF alone
    trial = TrialScene(replace(reduced, level="backlash"), model, mujoco.MjData(model), next(reduced.places(model)))
    torque, dof = share * reduced.rated_torque, trial.addresses.crank_speed
    trial.hold(reduced.rated_speed)
    trial.press_to_stop(reduced.way * (-torque if driving else torque))
    friction = []
    for _ in range(round(SHOE.trial_time / SHOE.trial_step)):
        trial.step()
        friction.append(-float(trial.data.qfrc_constraint[dof]))
    mean_friction = float(np.mean(friction[len(friction) // 2 :]))
    return joint_powers(torque / reduced.ratio, mean_friction, driving).efficiency
