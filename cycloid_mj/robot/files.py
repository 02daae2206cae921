"""Files of a joint: MJCF to include in a robot's model, scenes to open in MuJoCo, and its step without this package."""

from dataclasses import replace
from inspect import getsource
from json import dumps

from cycloid_mj.base.result import to_json_values
from cycloid_mj.robot import standalone
from cycloid_mj.robot.bam import fit_bam_models
from cycloid_mj.robot.lossy import lossy_joint_xml, lossy_scene_xml
from cycloid_mj.robot.mjcf import joint_xml, scene_xml
from cycloid_mj.robot.reducer import ReducedJoint
from cycloid_mj.robot.stability import StepTrial, choose_time_step
from cycloid_mj.robot.trial import Integrator

BASE_FILES = ("joint.xml", "scene.xml", "bam.json")
SPRING_FILES = ("lossy_joint.xml", "lossy_scene.xml", "joint.py")
"""Files at the levels with springs."""


def without_slip(reduced: ReducedJoint) -> ReducedJoint:
    """Return the joint without friction of the wind-up, which neither the full model nor the reference impact has."""
    return replace(reduced, slips=())


def choose_scenes(
    reduced: ReducedJoint,
    inertia: float | None = None,
    timestep: float | None = None,
    integrator: Integrator | None = None,
) -> tuple[StepTrial, StepTrial | None]:
    """Choose time step and integrator of the test scenes scene.xml and lossy_scene.xml of a reduced joint.

    The joint in lossy_scene.xml has load-dependent friction without Python code, see `lossy.lossy_joint_xml`.

    Parameters
    ----------
    inertia
        Inertia on the output [kg m2]; by default the inertia of the reducer itself, reflected to the output.
    timestep, integrator
        Time step [s] and integrator; by default those that `stability.choose_time_step` selects.

    Returns
    -------
    tuple of StepTrial
        Trials of the time steps of scene.xml and lossy_scene.xml; the second is None at the level `rigid`.
    """
    inertia = reduced.reflected_inertia if inertia is None else inertia
    if reduced.slips:
        integrator = "implicitfast"  # with the other integrator, slip elements creep
    joint_without_slip = without_slip(reduced)
    main_scene = choose_time_step(
        joint_without_slip, inertia, timestep, *([] if integrator is None else [(integrator,)])
    )
    if reduced.level == "rigid":
        return main_scene, None
    if main_scene.integrator == "discrete":
        return main_scene, main_scene
    return main_scene, choose_time_step(joint_without_slip, inertia, timestep, ("discrete",))


def joint_files(reduced: ReducedJoint, main_scene: StepTrial, lossy: StepTrial | None) -> dict[str, bytes]:
    """Return the MJCF and other files of a reduced joint: name -> content.

    `reduced` is the joint model. The files are `BASE_FILES` and, unless `lossy` is None, `SPRING_FILES`. `main_scene`
    and `lossy` are the results of `choose_scenes`: trials whose time steps scene.xml and lossy_scene.xml have.
    """
    texts = [
        joint_xml(reduced),
        scene_xml(reduced, main_scene.inertia, main_scene.timestep, main_scene.integrator),
        f"{dumps(to_json_values(fit_bam_models(reduced)), indent=2)}\n",
    ]
    file_names: tuple[str, ...] = BASE_FILES
    if lossy:
        file_names += SPRING_FILES
        texts += [lossy_joint_xml(reduced), lossy_scene_xml(reduced, lossy.inertia, lossy.timestep)]
        texts += [getsource(standalone)]
    return {name: text.encode() for name, text in zip(file_names, texts, strict=True)}
