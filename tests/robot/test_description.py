"""URDF, SDF, Isaac Lab and MJX files of a joint: loaded, and compared with the joint."""

import ast
import math
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest
from commands import told

from cycloid_mj.design import PRESETS
from cycloid_mj.reducer import Reducer
from cycloid_mj.robot import ReducedJoint, reduce
from cycloid_mj.robot.bam import bam
from cycloid_mj.robot.description import DRIVE, OUTPUT, description_files, description_names, link_inertias

REDUCER = Reducer(PRESETS["printed"])


@pytest.fixture(scope="module")
def joint() -> ReducedJoint:
    return reduce(PRESETS["printed"], "backlash")


@pytest.fixture(scope="module")
def rigid() -> ReducedJoint:
    return reduce(PRESETS["printed"], "rigid")


def test_the_urdf_loads_in_mujoco_with_ratio_inertia_and_play(joint: ReducedJoint) -> None:
    files = description_files(joint, REDUCER, "urdf")
    assert list(files) == ["printed.urdf"]
    model = mujoco.MjModel.from_xml_string(files["printed.urdf"].decode())
    assert [model.joint(name).name for name in (DRIVE, OUTPUT)] == [DRIVE, OUTPUT]
    assert model.joint(OUTPUT).range == pytest.approx(joint.stops, rel=1e-6)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    inertia = full[model.joint(DRIVE).dofadr[0], model.joint(DRIVE).dofadr[0]]
    assert inertia == pytest.approx(joint.reflected_inertia, rel=1e-6), "crank and output about the axis"


def test_the_transmission_states_the_signed_ratio(joint: ReducedJoint) -> None:
    root = ElementTree.fromstring(description_files(joint, REDUCER, "urdf")["printed.urdf"].decode())
    assert float(root.findtext(".//mechanicalReduction") or "nan") == pytest.approx(joint.way * joint.ratio)
    limit = root.find(f".//joint[@name='{DRIVE}']/limit")
    assert limit is not None
    assert float(limit.get("velocity", "nan")) == pytest.approx(joint.rated_speed / joint.ratio)


def test_a_rigid_joint_has_one_joint_with_all_inertia(rigid: ReducedJoint) -> None:
    links = link_inertias(rigid, REDUCER)
    assert DRIVE not in links
    assert links[OUTPUT].izz == pytest.approx(rigid.reflected_inertia)
    root = ElementTree.fromstring(description_files(rigid, REDUCER, "urdf")["printed.urdf"].decode())
    assert [each.get("name") for each in root.findall("joint")] == [OUTPUT]


@pytest.mark.parametrize("level", ["rigid", "backlash"])
def test_masses_add_up_to_the_drive_and_moments_are_possible(level: str, request: pytest.FixtureRequest) -> None:
    from cycloid_mj.parts.export.drive import drive_mass

    links = link_inertias(request.getfixturevalue("rigid" if level == "rigid" else "joint"), REDUCER)
    assert sum(link.mass for link in links.values()) == pytest.approx(drive_mass(REDUCER), abs=2e-3)
    for link in links.values():
        moments = sorted((link.ixx, link.iyy, link.izz))
        assert moments[0] > 0.0
        assert moments[2] <= moments[0] + moments[1] + 1e-15, "triangle inequality of a rigid body"


def test_the_sdf_has_the_same_joints_with_the_stiffness_of_the_stops(joint: ReducedJoint) -> None:
    root = ElementTree.fromstring(description_files(joint, REDUCER, "sdf")["printed.sdf"].decode())
    limit = root.find(f".//joint[@name='{OUTPUT}']/axis/limit")
    assert limit is not None
    assert float(limit.findtext("upper") or "nan") == pytest.approx(joint.stops[1], rel=1e-6)
    stiffness = sum(spring.stiffness for spring in joint.springs)
    assert float(limit.findtext("stiffness") or "nan") == pytest.approx(stiffness, rel=1e-6)
    assert [each.get("name") for each in root.findall(".//joint")] == [DRIVE, OUTPUT]


def test_the_isaaclab_module_has_the_parameters_of_bam(joint: ReducedJoint) -> None:
    """Parsed without Isaac Lab: keywords are fields of BamActuatorCfg, overrides are BAM's M5."""
    files = description_files(joint, REDUCER, "isaaclab")
    assert tuple(files) == description_names("printed", "isaaclab")
    tree = ast.parse(files["printed_cfg.py"])
    calls = {
        call.func.id: {keyword.arg: keyword.value for keyword in call.keywords}
        for call in ast.walk(tree)
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name)
    }
    fields = {"joint_names_expr", "effort_limit", "velocity_limit", "armature", "parameter_overrides"}
    assert set(calls["BamActuatorCfg"]) == fields
    overrides = ast.literal_eval(calls["BamActuatorCfg"]["parameter_overrides"])
    m5 = bam(joint)["m5"]
    assert overrides == pytest.approx({key: m5[key] for key in overrides}, rel=1e-6)
    assert {"friction_base", "friction_viscous", "load_friction_motor", "load_friction_external"} <= set(overrides)
    assert ast.literal_eval(calls["ImplicitActuatorCfg"]["joint_names_expr"]) == [OUTPUT]
    armature = ast.literal_eval(calls["BamActuatorCfg"]["armature"])
    assert armature + joint.output_inertia == pytest.approx(joint.reflected_inertia, rel=1e-6)


def test_the_mjx_scene_uses_what_mjx_has(joint: ReducedJoint, tmp_path: Path) -> None:
    for name, content in description_files(joint, REDUCER, "mjx").items():
        (tmp_path / name).write_bytes(content)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    assert model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert model.opt.noslip_iterations == 0
    data = mujoco.MjData(model)
    data.ctrl[0] = 0.2 * model.actuator("motor").ctrlrange[1]
    for _ in range(200):
        mujoco.mj_step(model, data)
    assert math.isfinite(data.joint(OUTPUT).qvel[0])
    assert data.joint(OUTPUT).qvel[0] * joint.way > 0.0


@pytest.mark.parametrize("file_format", ["urdf", "sdf"])
def test_the_command_writes_the_format(file_format: str, tmp_path: Path) -> None:
    code, _, err = told(
        *("reduce", "--design", "printed", "--level", "rigid", "--format", file_format, "--out", tmp_path / "joint"),
        "--quiet",
    )
    assert (code, err) == (0, "")
    assert len(list((tmp_path / "joint").glob(f"*.{file_format}"))) == 1
    assert not (tmp_path / "joint" / "joint.xml").exists()


def test_an_unknown_format_names_the_choices() -> None:
    code, _, err = told("reduce", "--design", "pin", "--format", "usd")
    assert code == 2
    assert "isaaclab" in err
