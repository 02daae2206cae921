"""The files of a joint: what a robot's model includes, what MuJoCo opens by itself, its step without this package."""

from dataclasses import replace
from inspect import getsource
from json import dumps

from cycloid_mj.base.result import plain
from cycloid_mj.robot import standalone
from cycloid_mj.robot.bam import bam
from cycloid_mj.robot.lossy import lossy_joint_xml, lossy_scene_xml
from cycloid_mj.robot.mjcf import joint_xml, scene_xml
from cycloid_mj.robot.reducer import ReducedJoint
from cycloid_mj.robot.stability import Tried, scene
from cycloid_mj.robot.trial import Integrator

FILES = ("joint.xml", "scene.xml", "bam.json")
BESIDE = ("lossy_joint.xml", "lossy_scene.xml", "joint.py")
"""Written at the levels that have springs."""


def without_slip(reduced: ReducedJoint) -> ReducedJoint:
    """Leave out the friction that holds the wind-up: the full model has none, nor what an impact is held against."""
    return replace(reduced, slips=())


def scenes(
    reduced: ReducedJoint,
    inertia: float | None = None,
    timestep: float | None = None,
    integrator: Integrator | None = None,
) -> tuple[Tried, Tried | None]:
    """Choose the step of scene.xml and that of lossy_scene.xml, which the level `rigid` lacks.

    Parameters
    ----------
    reduced
        The joint.
    inertia
        On the output [kg m2]; by default the reducer's own, reflected.
    timestep, integrator
        [s]; by default the longest, and the first, with which an impact is right, as `stability.scene` has it.
    """
    inertia = reduced.reflected_inertia if inertia is None else inertia
    if reduced.slips:
        integrator = "implicitfast"  # under the other one what slips does not hold still
    free = without_slip(reduced)
    asked = scene(free, inertia, timestep, *([] if integrator is None else [(integrator,)]))
    if reduced.level == "rigid":
        return asked, None
    return asked, asked if asked.integrator == "discrete" else scene(free, inertia, timestep, ("discrete",))


def joint_files(reduced: ReducedJoint, asked: Tried, lossy: Tried | None) -> dict[str, bytes]:
    """Write `FILES`, and `BESIDE` where there is a `lossy` scene; both scenes are those of `scenes`."""
    texts = [
        joint_xml(reduced),
        scene_xml(reduced, asked.inertia, asked.timestep, asked.integrator),
        f"{dumps(plain(bam(reduced)), indent=2)}\n",
    ]
    names: tuple[str, ...] = FILES
    if lossy:
        names += BESIDE
        texts += [lossy_joint_xml(reduced), lossy_scene_xml(reduced, lossy.inertia, lossy.timestep)]
        texts += [getsource(standalone)]
    return {name: text.encode() for name, text in zip(names, texts, strict=True)}
