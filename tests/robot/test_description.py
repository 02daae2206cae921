"""URDF, SDF, Isaac Lab and MJX files of a joint: loaded, and compared with the joint."""

import json
import math
import sys
from pathlib import Path
from types import ModuleType
from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest
from commands import told

from cycloid_mj.design import PRESETS
from cycloid_mj.reducer import Reducer
from cycloid_mj.robot import ReducedJoint, reduce
from cycloid_mj.robot.bam import fit_bam_models
from cycloid_mj.robot.description import (
    DESCRIPTION,
    DRIVE,
    OUTPUT,
    compute_link_inertias,
    equivalent_motor,
    list_description_files,
    write_descriptions,
)
from cycloid_mj.robot.mjcf import MJCF

REDUCER = Reducer(PRESETS["printed"])


def configuration(name: str, schema: dict[str, dict[str, list[str]]]) -> type:
    """Return a class with the fields of a configuration of Isaac Lab."""

    def __init__(self: Any, **given: Any) -> None:
        fields = schema[name]
        assert set(given) <= {*fields["required"], *fields["optional"]}, f"{name} has no such field"
        assert set(fields["required"]) <= set(given), f"{name} lacks a field"
        self.__dict__.update(given)

    return type(name, (), {"__init__": __init__})


@pytest.fixture
def isaaclab(monkeypatch: pytest.MonkeyPatch) -> None:
    """Modules of Isaac Lab with the fields that its source publishes."""
    path = Path(__file__).parents[1] / "data" / "isaaclab" / "configurations.json"
    schema = json.loads(path.read_text(encoding="utf-8"))
    schema["ImplicitActuatorCfg"] = schema["ActuatorBaseCfg"]
    modules = {
        "isaaclab": (),
        "isaaclab.sim": ("UrdfFileCfg",),
        "isaaclab.actuators": ("BamActuatorCfg", "BamMotorCfg", "ImplicitActuatorCfg"),
        "isaaclab.assets": ("ArticulationCfg",),
        "isaaclab.managers": ("EventTermCfg", "SceneEntityCfg"),
        "isaaclab.envs": (),
        "isaaclab.envs.mdp": ("randomize_joint_parameters",),
        "isaaclab.utils": (),
    }
    for module, names in modules.items():
        made = ModuleType(module)
        made.__dict__.update({name: configuration(name, schema) for name in names})
        monkeypatch.setitem(sys.modules, module, made)
        parent, _, name = module.rpartition(".")
        if parent:
            setattr(sys.modules[parent], name, made)
    sys.modules["isaaclab.utils"].__dict__["configclass"] = lambda described: described


def execute(content: bytes, path: Path) -> dict[str, Any]:
    """Run a Python file; return its names."""
    names: dict[str, Any] = {"__file__": str(path), "__name__": path.stem}
    exec(compile(content, str(path), "exec"), names)
    return names


@pytest.fixture(scope="module")
def joint() -> ReducedJoint:
    return reduce(PRESETS["printed"], "backlash")


@pytest.fixture(scope="module")
def rigid() -> ReducedJoint:
    return reduce(PRESETS["printed"], "rigid")


def test_the_urdf_loads_in_mujoco_with_ratio_inertia_and_play(joint: ReducedJoint) -> None:
    files = write_descriptions(joint, REDUCER, "urdf")
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
    root = ElementTree.fromstring(write_descriptions(joint, REDUCER, "urdf")["printed.urdf"].decode())
    assert float(root.findtext(".//mechanicalReduction") or "nan") == pytest.approx(joint.way * joint.ratio)
    limit = root.find(f".//joint[@name='{DRIVE}']/limit")
    assert limit is not None
    assert float(limit.get("velocity", "nan")) == pytest.approx(joint.rated_speed / joint.ratio)


def test_a_rigid_joint_has_one_joint_with_all_inertia(rigid: ReducedJoint) -> None:
    links = compute_link_inertias(rigid, REDUCER)
    assert DRIVE not in links
    assert links[OUTPUT].izz == pytest.approx(rigid.reflected_inertia)
    root = ElementTree.fromstring(write_descriptions(rigid, REDUCER, "urdf")["printed.urdf"].decode())
    assert [each.get("name") for each in root.findall("joint")] == [OUTPUT]


@pytest.mark.parametrize("level", ["rigid", "backlash"])
def test_masses_add_up_to_the_drive_and_moments_are_possible(level: str, request: pytest.FixtureRequest) -> None:
    from cycloid_mj.parts.export.drive import drive_mass

    links = compute_link_inertias(request.getfixturevalue("rigid" if level == "rigid" else "joint"), REDUCER)
    assert sum(link.mass for link in links.values()) == pytest.approx(drive_mass(REDUCER), abs=2e-3)
    for link in links.values():
        moments = sorted((link.ixx, link.iyy, link.izz))
        assert moments[0] > 0.0
        assert moments[2] <= moments[0] + moments[1] + 1e-15, "triangle inequality of a rigid body"


def test_the_sdf_has_the_same_joints_with_the_stiffness_of_the_stops(joint: ReducedJoint) -> None:
    root = ElementTree.fromstring(write_descriptions(joint, REDUCER, "sdf")["printed.sdf"].decode())
    limit = root.find(f".//joint[@name='{OUTPUT}']/axis/limit")
    assert limit is not None
    assert float(limit.findtext("upper") or "nan") == pytest.approx(joint.stops[1], rel=1e-6)
    stiffness = sum(spring.stiffness for spring in joint.springs)
    assert float(limit.findtext("stiffness") or "nan") == pytest.approx(stiffness, rel=1e-6)
    assert [each.get("name") for each in root.findall(".//joint")] == [DRIVE, OUTPUT]


def test_the_isaaclab_module_is_valid_by_the_published_schema(
    joint: ReducedJoint, rigid: ReducedJoint, isaaclab: None, tmp_path: Path
) -> None:
    """Run without Isaac Lab: its classes are replaced by those of the schema, which refuse unknown fields."""
    for reduced in (joint, rigid):
        files = write_descriptions(reduced, REDUCER, "isaaclab")
        assert tuple(files) == list_description_files("printed", "isaaclab")
        loaded = execute(files["printed_cfg.py"], tmp_path / "printed_cfg.py")
        drive, motor = loaded["REDUCER_CFG"].actuators["drive"], loaded["MOTOR"]
        m5 = fit_bam_models(reduced)["m5"]
        common = set(vars(motor)) & set(m5) - {"model"}
        assert {"friction_base", "friction_viscous", "load_friction_motor", "load_friction_external"} <= common
        assert {key: getattr(motor, key) for key in common} == pytest.approx({key: m5[key] for key in common}, rel=1e-6)
        assert motor.model == "m5"
        root = ElementTree.fromstring(files["printed.urdf"].decode())
        names = [each.get("name") for each in root.findall("joint")]
        assert drive.joint_names_expr == names[:1]
        if reduced is joint:
            assert loaded["ACTUATORS"]["play"].joint_names_expr == names[1:] == ["passive_drive_backlash"]
        assert drive.armature + reduced.output_inertia == pytest.approx(reduced.reflected_inertia, rel=1e-6)


def test_the_equivalent_motor_has_rated_and_peak_torque(joint: ReducedJoint) -> None:
    motor = equivalent_motor(joint)

    def torque(speed: float) -> float:
        return motor["kt"] * (DESCRIPTION.supply - motor["kt"] * speed) / motor["resistance"]

    assert torque(0.0) == pytest.approx(MJCF.motor_peak * joint.rated_torque)
    assert torque(joint.rated_speed / joint.ratio) == pytest.approx(joint.rated_torque)
    assert motor["max_current"] == pytest.approx(DESCRIPTION.supply / motor["resistance"])


@pytest.mark.parametrize("level", ["rigid", "backlash"])
def test_the_urdf_loads_in_yourdfpy(level: str, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    yourdfpy = pytest.importorskip("yourdfpy", reason="yourdfpy is no requirement of the tests")
    reduced = request.getfixturevalue("rigid" if level == "rigid" else "joint")
    path = tmp_path / "printed.urdf"
    path.write_bytes(write_descriptions(reduced, REDUCER, "urdf")["printed.urdf"])
    robot = yourdfpy.URDF.load(str(path), mesh_dir="")
    assert robot.validate()
    assert robot.actuated_joint_names == ([OUTPUT] if level == "rigid" else [DRIVE, OUTPUT])
    robot.update_cfg(np.full(robot.num_actuated_joints, 0.001))
    turn = robot.get_transform(OUTPUT, "housing")
    assert math.atan2(turn[1, 0], turn[0, 0]) == pytest.approx(0.001 * robot.num_actuated_joints)


def test_the_mjx_scene_uses_what_mjx_has(joint: ReducedJoint, tmp_path: Path) -> None:
    for name, content in write_descriptions(joint, REDUCER, "mjx").items():
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


@pytest.mark.slow
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
