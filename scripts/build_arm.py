"""Make the folder models/arm: an arm with three printed reducers, for MuJoCo and MJX, with its README.

With --pictures, its picture is rendered, too (OpenGL off-screen is needed; its bytes depend on the machine).
"""

import sys
from pathlib import Path

import mujoco
import numpy as np

import cycloid_mj as cm
from cycloid_mj.parts.export.drive import drive_diameter, drive_length, drive_mass
from cycloid_mj.robot.files import choose_scenes

MODEL = Path(__file__).parent.parent / "models" / "arm"
README = Path(__file__).with_name("model_arm_readme.md")

DESIGN = "printed"
"""Preset of the reducer of each joint."""

JOINTS = ("yaw", "shoulder", "elbow")

LINK_INERTIA = 0.1
"""Inertia of the forearm about the elbow [kg m2], the smallest on a joint: the time step is chosen for it."""

MJX_STEP_SHARE = 0.5
"""Time step for MJX relative to that for MuJoCo, as of ``reduce --format mjx`` (heuristic)."""

ARM = """<mujoco model="arm">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="{step}" integrator="implicitfast"/>
  <default>
    <geom contype="0" conaffinity="1"/>
    <default class="drive"><geom type="cylinder" size="{radius} {half}" mass="{mass}" rgba="0.07 0.2 0.31 1"/></default>
    <default class="motor"><geom type="box" size="0.0282 0.0282 0.028" mass="0.7" rgba="0.35 0.38 0.41 1"/></default>
    <default class="link"><geom type="capsule" size="0.022" rgba="0.86 0.88 0.9 1"/></default>
    <default class="hub"><geom type="cylinder" size="0.034 0.006" mass="0.03" rgba="0.25 0.69 0.54 1"/></default>
    <default class="servo"><position kp="600" kv="60" forcerange="-{torque} {torque}" ctrlrange="-3 3"/></default>
  </default>
  <worldbody>
    <body name="base" pos="0 0 0.08">
      <geom name="foot" type="cylinder" size="0.09 0.01" pos="0 0 -0.07" mass="2" rgba="0.35 0.38 0.41 1"/>
      <geom class="motor" pos="0 0 -0.03"/>
      <geom class="drive" pos="0 0 {half}"/>
      <body name="turret" pos="0 0 {turret}">
        <joint name="yaw" axis="0 0 1" range="-3 3"/>
        <geom class="hub" pos="0 0 -0.006"/>
        <geom class="link" fromto="0 -0.02 0.02 0 0.02 0.02" mass="0.15"/>
        <geom class="drive" pos="0 0 {shoulder}" euler="{quarter} 0 0"/>
        <geom class="motor" pos="0 -{motor} {shoulder}" euler="{quarter} 0 0"/>
        <body name="upper_arm" pos="0 {offset} {shoulder}">
          <joint name="shoulder" axis="0 1 0" range="-2.2 2.2"/>
          <geom class="hub" pos="0 -0.018 0" euler="{quarter} 0 0"/>
          <geom class="link" fromto="0 0 0 0 0 0.3" mass="0.25"/>
          <geom class="drive" pos="0 {inner} 0.3" euler="{quarter} 0 0"/>
          <geom class="motor" pos="0 {outer} 0.3" euler="{quarter} 0 0"/>
          <body name="forearm" pos="0 -0.03 0.3">
            <joint name="elbow" axis="0 1 0" range="-2.6 2.6"/>
            <geom class="hub" pos="0 0.018 0" euler="{quarter} 0 0"/>
            <geom class="link" fromto="0 0 0 0 0 0.25" mass="0.2"/>
            <geom name="tool" type="sphere" size="0.03" pos="0 0 0.27" mass="0.3" rgba="0.93 0.65 0.49 1"/>
            <site name="tip" pos="0 0 0.3" size="0.005"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="yaw" class="servo" joint="yaw"/>
    <position name="shoulder" class="servo" joint="shoulder"/>
    <position name="elbow" class="servo" joint="elbow"/>
  </actuator>
  <keyframe>
    <key name="home" qpos="0 0.5 1.2" ctrl="0 0.5 1.2"/>
  </keyframe>
</mujoco>
"""
"""The arm without its reducers. Lengths in m, masses in kg; those of links, motors (NEMA 23) and tool are assumed."""

SCENE = """<mujoco model="arm scene">
  <include file="arm.xml"/>
{option}  <statistic center="0 0 0.35" extent="0.7"/>
  <visual>
    <headlight ambient="0.35 0.35 0.35" diffuse="0.45 0.45 0.45"/>
    <global azimuth="140" elevation="-15" offwidth="1280" offheight="960"/>
  </visual>
  <asset>
    <texture type="skybox" builtin="gradient" rgb1="0.97 0.98 0.99" rgb2="0.62 0.68 0.75" width="512" height="512"/>
    <texture name="floor" type="2d" builtin="checker" rgb1="0.85 0.87 0.89" rgb2="0.78 0.81 0.84" width="300" \
height="300"/>
    <material name="floor" texture="floor" texuniform="true" texrepeat="5 5"/>
  </asset>
  <worldbody>
    <light pos="0.6 -0.8 1.8" dir="-0.3 0.4 -0.9" diffuse="0.5 0.5 0.5"/>
    <geom name="floor" type="plane" size="0 0 0.05" material="floor"/>
  </worldbody>
</mujoco>
"""


def bare_arm(reducer: cm.Reducer, rated_torque: float, timestep: float) -> str:
    """Return the MJCF of the arm without reducers, with the sizes of their housings.

    The servos are limited to `rated_torque` [N m]; `timestep` is the time step [s].
    """
    half = 0.5 * drive_length(reducer)
    radius = 0.5 * drive_diameter(reducer)
    offset = half + 0.024
    return ARM.format(
        step=f"{timestep:g}",
        radius=f"{radius:g}",
        half=f"{half:g}",
        mass=f"{drive_mass(reducer):.4g}",
        torque=f"{rated_torque:g}",
        turret=f"{2.0 * half + 0.012:g}",
        shoulder=f"{radius + 0.03:g}",
        motor=f"{half + 0.028:g}",
        offset=f"{offset:g}",
        inner=f"{half - 0.006:g}",
        outer=f"{2.0 * half + 0.022:g}",
        quarter=f"{0.5 * np.pi:.9g}",
    )


def arm_files(reduced: cm.ReducedJoint) -> dict[str, bytes]:
    """Return the files of models/arm without its picture, with the reduced `DESIGN`: name -> content."""
    reducer = cm.Reducer(cm.load(DESIGN))
    scene, _ = choose_scenes(reduced, LINK_INERTIA, integrator="implicitfast")
    spec = mujoco.MjSpec.from_string(bare_arm(reducer, reduced.rated_torque, scene.timestep))
    for joint in JOINTS:
        cm.attach_reducer(spec, joint, reduced)
    spec.compile()
    mjx_step = MJX_STEP_SHARE * scene.timestep
    texts = {
        "arm.xml": spec.to_xml(),
        "scene.xml": SCENE.format(option=""),
        "scene_mjx.xml": SCENE.format(option=f'  <option timestep="{mjx_step:g}"/>\n'),
        "README.md": format_readme(reduced, reducer, scene.timestep, mjx_step),
    }
    return {name: text.encode() for name, text in texts.items()}


def format_readme(reduced: cm.ReducedJoint, reducer: cm.Reducer, timestep: float, mjx_step: float) -> str:
    """Return the README of the folder with the figures of the reducer and the time steps [s]."""
    low, high = reduced.stops
    return README.read_text(encoding="utf-8").format(
        ratio=f"{reduced.ratio:g}",
        torque=f"{reduced.rated_torque:.3g}",
        backlash=f"{60.0 * np.degrees(high - low):.3g}",
        stiffness=f"{reduced.quantities['stiffness_nm_per_arcmin'].value:.3g}",
        inertia=f"{reduced.reflected_inertia:.3g}",
        diameter=f"{1e3 * drive_diameter(reducer):.0f}",
        length=f"{1e3 * drive_length(reducer):.0f}",
        mass=f"{drive_mass(reducer):.2g}",
        step=f"{1e3 * timestep:g}",
        mjx_step=f"{1e3 * mjx_step:g}",
        mujoco=mujoco.__version__,
    )


def render(folder: Path) -> None:
    """Render the arm in its pose `home` as picture.png."""
    from PIL import Image

    from cycloid_mj.scene.render import render_model

    model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    data, camera = mujoco.MjData(model), mujoco.MjvCamera()
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    mujoco.mj_forward(model, data)
    camera.lookat, camera.distance, camera.azimuth, camera.elevation = [0.1, 0.0, 0.32], 1.25, 140.0, -14.0
    Image.fromarray(render_model(model, data, camera, (960, 720))).save(folder / "picture.png", optimize=True)


def main(arguments: list[str]) -> int:
    """Write the folder of the arm, with pictures if `arguments` contain ``--pictures``; return the exit code."""
    if set(arguments) - {"--pictures"}:
        print(__doc__, file=sys.stderr)
        return 2
    MODEL.mkdir(exist_ok=True)
    for name, content in arm_files(cm.reduce(DESIGN, "backlash")).items():
        (MODEL / name).write_bytes(content)
    if "--pictures" in arguments:
        render(MODEL)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
