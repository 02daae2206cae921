"""Randomization files for reinforcement learning, compared with the spread of the drives and with joint.py."""

import csv
import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest
from commands import told

from cycloid_mj.base.result import to_json_values
from cycloid_mj.design import PRESETS
from cycloid_mj.robot import ReducedJoint, reduce
from cycloid_mj.robot.files import choose_scenes, joint_files
from cycloid_mj.robot.population import Population
from cycloid_mj.robot.randomization import randomization_files

SAMPLES = 8


@pytest.fixture(scope="module")
def joint() -> ReducedJoint:
    return reduce(PRESETS["printed"], "backlash")


@pytest.fixture(scope="module")
def population(joint: ReducedJoint) -> Population:
    """Drives of given parameters, in place of those that `draw_population` computes."""
    nominal = {"backlash_arcmin": 3.0, "stiffness_nm_per_arcmin": 0.2, "no_load_torque_nm": 0.01}
    nominal |= {"loss_percent": 9.0, "te_loaded_forward_arcsec": 100.0}
    factors = np.random.default_rng(0).uniform(0.7, 1.5, (len(nominal), SAMPLES))
    values = {key: value * row for (key, value), row in zip(nominal.items(), factors, strict=True)}
    return Population("printed", SAMPLES, 0, nominal, values, {}, (), True)


@pytest.fixture(scope="module")
def folder(joint: ReducedJoint, population: Population, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Files of the joint with the spread of the drives."""
    into = tmp_path_factory.mktemp("drives")
    scene, _ = choose_scenes(joint)
    content = joint.as_json() | {"scene": scene.as_json(), "spread": population.as_json()}
    files = {
        **joint_files(joint, scene, scene),
        **randomization_files(joint, population, "mjcf"),
        "reducer.json": json.dumps(to_json_values(content)).encode(),
        "samples.csv": population.frame.as_csv().encode(),
    }
    for name, text in files.items():
        (into / name).write_bytes(text)
    return into


def ranges_of_samples(folder: Path) -> dict[str, tuple[float, float]]:
    """Return the percentiles of the drives relative to the nominal design, from the other files."""
    nominal = json.loads((folder / "reducer.json").read_text())["spread"]["parameters"]
    with (folder / "samples.csv").open() as file:
        rows = list(csv.DictReader(file))
    keys = {
        "play": "backlash_arcmin",
        "stiffness": "stiffness_nm_per_arcmin",
        "friction": "no_load_torque_nm",
    }
    return {
        name: tuple(np.percentile([float(row[key]) for row in rows], (5, 95)) / nominal[key]["nominal"])
        for name, key in keys.items()
    }


DRAW = """
import json, sys
import jax
import numpy as np
import mujoco
from mujoco import mjx
import randomize_mjx
model = mujoco.MjModel.from_xml_path("scene.xml")
many, axes = randomize_mjx.randomizer(model)(mjx.put_model(model), jax.random.split(jax.random.PRNGKey(0), 50))
jax.vmap(lambda one: one.tendon_stiffness.sum(), in_axes=(axes,))(many)  # the axes fit the model
names = ("tendon_lengthspring", "tendon_stiffness", "tendon_damping", "dof_frictionloss")
print(json.dumps({name: np.asarray(getattr(many, name)).tolist() for name in names}))
"""


@pytest.mark.slow
def test_mjx_models_are_within_the_ranges_of_the_drives(folder: Path) -> None:
    pytest.importorskip("jax", reason="JAX is no requirement of the tests: see pyproject.toml")
    words = [sys.executable, "-W", "ignore", "-c", DRAW]
    run = subprocess.run(words, capture_output=True, text=True, cwd=folder, check=False)
    assert run.returncode == 0, run.stderr
    drawn = {name: np.array(values) for name, values in json.loads(run.stdout.splitlines()[-1]).items()}
    model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    first = model.tendon("output_reducer").id
    play = np.ptp(drawn["tendon_lengthspring"][:, first], axis=1) / np.ptp(model.tendon_lengthspring[first])
    stiffness = drawn["tendon_stiffness"][:, first] / model.tendon_stiffness[first]
    crank = model.joint("output_rotor").dofadr[0]
    friction = drawn["dof_frictionloss"][:, crank] / model.dof_frictionloss[crank]
    for name, factors in {"play": play, "stiffness": stiffness, "friction": friction}.items():
        low, high = ranges_of_samples(folder)[name]
        assert low - 1e-4 <= factors.min() < factors.max() <= high + 1e-4
        assert np.ptp(factors) > 0.5 * (high - low), "the whole range is drawn"
    # the torque at the start of each further spring is that of the nominal drive
    starts = 0.5 * (np.ptp(drawn["tendon_lengthspring"], axis=2) - np.ptp(drawn["tendon_lengthspring"], axis=2)[:, :1])
    nominal = 0.5 * (np.ptp(model.tendon_lengthspring, axis=1) - np.ptp(model.tendon_lengthspring[0]))
    assert starts * stiffness[:, np.newaxis] == pytest.approx(np.tile(nominal, (50, 1)), rel=1e-2, abs=1e-7)


def test_isaaclab_events_have_the_ranges_of_the_drives(
    joint: ReducedJoint, population: Population, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (content,) = randomization_files(joint, population, "isaaclab").values()
    term = lambda **given: SimpleNamespace(**given)  # noqa: E731
    modules = {
        "isaaclab": {},
        "isaaclab.envs": {},
        "isaaclab.envs.mdp": {"randomize_joint_parameters": "randomize_joint_parameters"},
        "isaaclab.managers": {"EventTermCfg": term, "SceneEntityCfg": lambda name, joint_names: (name, joint_names)},
        "isaaclab.utils": {"configclass": lambda described: described},
    }
    for name, members in modules.items():
        monkeypatch.setitem(sys.modules, name, SimpleNamespace(**members))
    sys.modules["isaaclab"].envs = sys.modules["isaaclab.envs"]
    sys.modules["isaaclab.envs"].mdp = sys.modules["isaaclab.envs.mdp"]
    names: dict[str, type] = {}
    exec(content.decode(), names)
    events, expected = names["ReducerEventsCfg"], ranges_of_samples(folder)
    assert events.friction.params["friction_distribution_params"] == pytest.approx(expected["friction"], rel=1e-4)
    assert events.friction.params["asset_cfg"] == ("robot", ["drive"])
    assert events.play.params["asset_cfg"] == ("robot", ["passive_drive_backlash"])
    low, high = joint.stops
    upper = 0.5 * (low + high) + 0.5 * (high - low) * np.array(expected["play"])
    assert events.play.params["upper_limit_distribution_params"] == pytest.approx(upper, rel=1e-4, abs=1e-9)
    schema = json.loads((Path(__file__).parents[1] / "data" / "isaaclab" / "configurations.json").read_text())
    fields = schema["randomize_joint_parameters"]
    for event in (events.friction, events.play):
        assert set(event.params) <= {*fields["required"], *fields["optional"]}


def test_a_rigid_joint_has_no_play_to_draw(joint: ReducedJoint, population: Population) -> None:
    assert randomization_files(joint.at("rigid"), population, "mjcf") == {}


@pytest.mark.slow
def test_the_command_writes_the_files(tmp_path: Path) -> None:
    code, _, err = told(
        *("reduce", "--design", "printed", "--level", "backlash", "--format", "isaaclab", "--spread", "--samples", "4"),
        *("--set", 'tolerance.cam="uniform 4"', "--out", tmp_path / "drives", "--quiet"),
    )
    assert (code, err) == (0, "")
    names = {path.name for path in (tmp_path / "drives").iterdir()}
    assert {"randomize_isaaclab.py", "samples.csv", "printed_cfg.py"} <= names


def test_a_gymnasium_environment_gets_a_drive_at_each_reset(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gymnasium = pytest.importorskip("gymnasium")

    class Environment(gymnasium.Env):
        observation_space = action_space = gymnasium.spaces.Discrete(1)
        model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))

        def reset(self, *, seed=None, options=None):
            super().reset(seed=seed)
            return 0, {}

    monkeypatch.syspath_prepend(str(folder))
    monkeypatch.delitem(sys.modules, "joint", raising=False)
    import randomize_gymnasium

    environment = randomize_gymnasium.RandomDrive(Environment())
    first = environment.unwrapped.model.tendon("output_reducer").id
    plays = []
    for seed in range(6):
        environment.reset(seed=seed)
        plays.append(float(np.ptp(environment.unwrapped.model.tendon_lengthspring[first])))
    sampled = [float(row["backlash_arcmin"]) for row in environment.samples]
    factors = (
        np.array(plays)
        / np.diff(environment.nominal.values["stops"])[0]
        * environment.nominal.nominal["backlash_arcmin"]
    )
    assert all(np.isclose(factor, sampled, rtol=1e-6).any() for factor in factors)
    assert len(set(plays)) > 1
    environment.reset(seed=0)
    assert float(np.ptp(environment.unwrapped.model.tendon_lengthspring[first])) == plays[0], "seeded"
    del sys.modules["joint"], sys.modules["randomize_gymnasium"]
