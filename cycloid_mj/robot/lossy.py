"""Losses that grow with the load in stock MJCF: the springs press a shoe on the crank, on which it rubs.

The shoe sits on the crank's axis between two plates of the crank, on a lever. Each spring of the joint has a share of
the lever's angle in its length, so that it presses the shoe on one of the plates with that share of its torque, however
the joint is wound up; contact with friction about the axis alone brakes the crank. The lever's hinge is tilted, so that
friction turns it a little, and presses the shoe on or lifts it, as with the leading and the trailing shoe of a drum
brake: which of both, goes by the plate and by the way of the crank, that is by whether crank or output drives. So one
shoe has the losses of driving and of back-driving.

Two things make it serve. The reference damping of friction is small: of a pair that slides fast, MuJoCo's soft cone
turns that into a force that lifts the shoe off (`LIFT`); but friction that has next to none holds the acceleration of
the tilted shoe and not its speed, so that the shoe drifts, and rubs the wrong way, for seconds. And the shoe has an
armature, no mass: it bears the springs, gives way by `GIVE` of the wind-up, and neither weighs nor hammers.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import mujoco
import numpy as np

from cycloid_mj.base.array import Array, significant
from cycloid_mj.base.result import Table
from cycloid_mj.robot.friction import joint_powers
from cycloid_mj.robot.mjcf import OUTPUT, joint_xml, reducer_name, rotor_name, scene_xml
from cycloid_mj.robot.reducer import ReducedJoint
from cycloid_mj.robot.trial import TrialScene

SHARES = (0.05, 0.125, 0.25, 0.5, 0.75, 1.0)
"""Of the rated torque, at which the loss of the full model is followed."""

COMPARED = (0.1, 0.5, 1.0)
"""Of the rated torque, at which the lossy joint is held against the full model."""

GIVE = 0.01
"""What the shoe gives way under the rated torque, as a share of the wind-up: with less it is shaken off its plate."""

REFERENCE, IMPEDANCE = 1e4, 0.9999
"""Of the contact: reference stiffness [1/s2], which a step of 5 ms bears, and impedance."""

LIFT = 5e-3
"""By how much friction lifts the shoe at the rated speed, as a share of what it gives way under the rated torque."""

STEEPEST = 0.9
"""Largest share by which friction presses the shoe on: at 1 it would lock."""

LEVER = 0.02
"""Of the shoe [m]."""

RADIUS, HALF = 0.005, 0.001
"""Of the shoe, and half the thickness of the plates [m]."""

HEIGHT = 0.03
"""Of the shoe above the crank's middle [m]."""

TIME, TIMESTEP = 0.4, 1e-4
"""How long a trial runs, the second half of which is read: by then the shoe has come to rest; and its step [s]."""


@dataclass(frozen=True)
class Shoe:
    """The shoe of a joint.

    Attributes
    ----------
    shares
        Of its place along the axis in the length of each spring [rad/m], shape (springs,).
    friction
        Torque about the axis over the force on the plate [m].
    leading
        Share t of its force by which friction presses it on, or lifts it: the force is S/(1 - t) or S/(1 + t).
    armature
        Along the axis [kg].
    creep
        Reference damping of the friction [1/s].
    """

    shares: Array
    friction: float
    leading: float
    armature: float
    creep: float


def shoe_of(reduced: ReducedJoint) -> Shoe:
    """Fit the shoe to the losses of a joint over the rated torque, driving and back-driven, beside those of no load.

    Both are as S/(1 -+ t), so that their harmonic mean is as S, which the springs make.
    """
    from scipy.optimize import nnls

    loads = np.array(SHARES) * reduced.rated_torque
    pulls = np.array([_pulls(reduced, load) for load in loads.tolist()])
    driving, driven = (
        np.maximum(
            [
                reduced.friction.torque(load, reduced.rated_speed, way) - reduced.no_load_torque
                for load in loads.tolist()
            ],
            np.finfo(float).tiny,
        )
        for way in (True, False)
    )
    # between errors of the torque and of the efficiency: large loads count more
    weights, both = 1.0 / np.sqrt(loads), driving + driven
    sums, differences = weights * both, weights * (driving - driven)
    leading = float(np.clip(differences @ sums / (sums @ sums), -STEEPEST, STEEPEST))
    by_spring, _ = nnls(weights[:, np.newaxis] * pulls, weights * 2.0 * driving * driven / both)
    friction = max(float(by_spring.max()), np.finfo(float).tiny)
    shares = by_spring / friction
    given = GIVE * reduced.wind_up(reduced.rated_torque)
    # a contact gives way by (1 - d) F/(m k d) under a force F, and the springs' lengths by as many shares of that
    pressed = float(pulls[-1] @ shares)
    armature = (1.0 - IMPEDANCE) * pressed / (REFERENCE * IMPEDANCE * given)
    # the cone adds the coefficient times damping and speed to the reference acceleration along the axis
    creep = LIFT * REFERENCE * given / (friction * reduced.rated_speed)
    return Shoe(shares, friction, leading, armature, creep)


def lossy_joint_xml(reduced: ReducedJoint, joint: str = OUTPUT) -> str:
    """Write `joint_xml` with a shoe; at the level `rigid`, which has no springs, without one.

    The model that includes it needs elliptic friction cones, and the integrator of `lossy_scene_xml`, under which what
    slips (`ReducedJoint.slips`) does not hold still: it is left out.
    """
    text = joint_xml(replace(reduced, slips=()), joint)
    if reduced.level == "rigid":
        return text
    shoe, crank, name = shoe_of(reduced), rotor_name(joint), f"{joint}_shoe"
    # tan(angle) of the hinge; its turn q moves the shoe by LEVER cos(angle) q along the axis
    tilt = reduced.way * shoe.leading * LEVER / shoe.friction
    lever = LEVER / math.hypot(1.0, tilt)
    plates, pairs = [], []
    for number, side in enumerate((-1, 1)):
        plates.append(
            f'      <geom name="{name}_plate_{number}" type="box" pos="0 0 {HEIGHT + side * (RADIUS + HALF):g}" '
            f'size="{RADIUS} {RADIUS} {HALF}" contype="0" conaffinity="0" mass="1e-9"/>\n'
        )
        pairs.append(
            f'    <pair geom1="{name}_plate_{number}" geom2="{name}" condim="4" '
            f'friction="0 0 {_number(shoe.friction)} 0 0" solref="{-REFERENCE:g} {-2.0 * REFERENCE**0.5:g}" '
            f'solreffriction="-1 {-shoe.creep:g}" solimp="{IMPEDANCE} {IMPEDANCE} 0.001 0.5 2"/>\n'
        )
    # a centre of mass beside the axis, or MuJoCo takes the mass alone for all that moves
    body = f"""    <body name="{name}" pos="0 0 {HEIGHT}">
      <inertial pos="0.001 0 0" mass="1e-9" diaginertia="1e-12 1e-12 1e-12"/>
      <joint name="{name}" type="hinge" pos="{LEVER} 0 0" axis="0 1 {_number(tilt)}" \
armature="{_number(shoe.armature * lever**2)}" limited="false"/>
      <geom name="{name}" type="sphere" size="{RADIUS}" contype="0" conaffinity="0" mass="1e-9"/>
    </body>
"""
    before, after = text.split("    </body>\n  </worldbody>\n")
    head = f"{before}{''.join(plates)}    </body>\n{body}  </worldbody>\n  <contact>\n{''.join(pairs)}  </contact>\n"
    for number, share in enumerate(shoe.shares.tolist()):
        tendon, rest = after.split(f'<fixed name="{reducer_name(joint, number)}"')
        crossed = f'<joint joint="{name}" coef="{_number(lever * share)}"/></fixed>'
        after = f'{tendon}<fixed name="{reducer_name(joint, number)}"{rest.replace("</fixed>", crossed, 1)}'
    comment = f"Losses grow with the load by the shoe {name} on {crank}: for friction cones that are elliptic. "
    return (head + after).replace("<!-- ", f"<!-- {comment}\n       ", 1)


def lossy_scene_xml(reduced: ReducedJoint, load_inertia: float, timestep: float) -> str:
    """Write `scene_xml` for lossy_joint.xml: elliptic cones, and the integrator under which a shoe holds still."""
    scene = scene_xml(reduced, load_inertia, timestep, "discrete")
    return scene.replace("joint.xml", "lossy_joint.xml").replace("<option ", '<option cone="elliptic" ')


class StockEfficiency(NamedTuple):
    """Efficiency of the lossy joint in MuJoCo alone beside the full model's [%], at a share of the rated torque."""

    share: float
    driving: bool
    percent: float
    full_model_percent: float


def lossy_efficiencies(reduced: ReducedJoint) -> list[StockEfficiency]:
    """Measure the lossy joint at 10, 50 and 100 % of the rated torque, with the crank and with the output driving."""
    return [
        StockEfficiency(
            share,
            driving,
            100.0 * lossy_efficiency(reduced, share, driving),
            100.0
            * reduced.friction.efficiency(share * reduced.rated_torque, reduced.rated_speed, reduced.ratio, driving),
        )
        for driving in (True, False)
        for share in COMPARED
    ]


def lossy_table(efficiencies: Sequence[StockEfficiency]) -> Table:
    """Tabulate the lossy joint's efficiencies beside the full model's."""
    rows = tuple(
        (
            f"{'driving' if one.driving else 'back-driven'}, {one.share:.0%} of the rated torque",
            f"{one.percent:.2f}",
            f"{one.full_model_percent:.2f}",
            f"{one.percent - one.full_model_percent:+.2f}",
        )
        for one in efficiencies
    )
    return Table(
        "lossy_joint.xml: efficiency in MuJoCo alone [%]", ("condition", "joint", "full model", "difference"), rows
    )


def lossy_efficiency(reduced: ReducedJoint, share: float, driving: bool) -> float:
    """Compute the efficiency of the lossy joint in MuJoCo alone, at the rated speed under a share of the rated torque.

    The share of the power supplied that is given out; 0 where friction holds the output.
    """
    scene = lossy_scene_xml(reduced, reduced.reflected_inertia, TIMESTEP)
    files = {"lossy_joint.xml": lossy_joint_xml(reduced).encode()}
    model = mujoco.MjModel.from_xml_string(scene, files)
    # no step of Python's: what MJCF says alone
    on = TrialScene(replace(reduced, level="backlash"), model, mujoco.MjData(model), next(reduced.places(model)))
    torque, dof = share * reduced.rated_torque, on.place.crank_speed
    on.hold(reduced.rated_speed)
    on.press(reduced.way * (-torque if driving else torque))
    taken = []
    for _ in range(round(TIME / TIMESTEP)):
        on.step()
        taken.append(-float(on.data.qfrc_constraint[dof]))
    lost = float(np.mean(taken[len(taken) // 2 :]))
    return joint_powers(torque / reduced.ratio, lost, driving).efficiency


def _pulls(reduced: ReducedJoint, torque: float) -> Array:
    """Compute the torque of each spring under one on the joint [N m], shape (springs,)."""
    wound = reduced.wind_up(torque)
    return np.array([spring.stiffness * max(wound - spring.start, 0.0) for spring in reduced.springs])


def _number(value: float) -> str:
    return f"{significant(value):.12g}"
