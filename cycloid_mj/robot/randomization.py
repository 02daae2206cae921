"""Randomization of a joint in the formats of frameworks for reinforcement learning, from the spread of built drives.

The ranges are the 5 and 95 % percentiles of the drives, as factors of the nominal design: for Isaac Lab event terms,
and for MJX (Brax, MuJoCo Playground) a function of a model. For Gymnasium, a wrapper draws whole drives from
samples.csv, which keeps the correlation of their parameters.
"""

from collections.abc import Callable

import numpy as np

from cycloid_mj.base.array import significant
from cycloid_mj.robot.description import DRIVE, PLAY, Format
from cycloid_mj.robot.mjcf import OUTPUT
from cycloid_mj.robot.population import Population
from cycloid_mj.robot.reducer import ReducedJoint

RANGE = (5.0, 95.0)
"""Percentiles of the drives at the ends of a range."""

VARIED = {"play": "backlash_arcmin", "stiffness": "stiffness_nm_per_arcmin", "friction": "no_load_torque_nm"}
"""Parameters that a model can change during training -> their keys in samples.csv."""

ISAACLAB, MJX, GYMNASIUM = "randomize_isaaclab.py", "randomize_mjx.py", "randomize_gymnasium.py"

FILES: dict[Format, tuple[str, ...]] = {
    "mjcf": (MJX, GYMNASIUM),
    "mjx": (MJX,),
    "isaaclab": (ISAACLAB,),
    "urdf": (),
    "sdf": (),
}
"""Files of a format; all are Python modules."""


def factor_ranges(population: Population) -> dict[str, tuple[float, float]]:
    """Compute the range of each parameter of `VARIED` over random drives, relative to the nominal value.

    `population` has the parameters of these drives.

    Returns
    -------
    dict
        Parameter -> its percentiles `RANGE`, each divided by the nominal value; (1, 1) if that is 0.
    """
    ranges = {}
    for name, key in VARIED.items():
        nominal_value = population.nominal[key]
        low_factor, high_factor = (
            np.percentile(population.values[key], RANGE) / nominal_value if nominal_value else (1.0, 1.0)
        )
        ranges[name] = (significant(float(low_factor)), significant(float(high_factor)))
    return ranges


def randomization_files(reduced: ReducedJoint, population: Population, file_format: Format) -> dict[str, bytes]:
    """Return the files in `file_format` for domain randomization of a reduced joint: name -> content.

    Domain randomization varies the parameters while a robot policy is trained. `population` has the joint parameters of
    a sample of drives. A rigid joint has no such files, because it has neither play nor springs.
    """
    if reduced.level == "rigid":
        return {}
    texts: dict[str, Callable[[ReducedJoint, Population], str]] = {
        ISAACLAB: _isaaclab_events,
        MJX: _mjx_randomization,
        GYMNASIUM: lambda reduced, population: GYMNASIUM_TEXT,
    }
    return {name: texts[name](reduced, population).encode() for name in FILES[file_format]}


def _describe_ranges(population: Population) -> str:
    return (
        f"Ranges of {population.samples} drives of {population.design}: {RANGE[0]:g} to {RANGE[1]:g} % percentiles, "
        "relative to the nominal design."
    )


def _isaaclab_events(reduced: ReducedJoint, population: Population) -> str:
    """Return a Python module with Isaac Lab's event terms, which draw a friction factor and limits of the play [rad].

    Drawn limits are symmetric to the middle of the play of `reduced`. `population` has the joint parameters of a sample
    of drives.
    """
    ranges = factor_ranges(population)
    play_middle, half_play = reduced.middle, 0.5 * reduced.backlash
    min_half, max_half = (half_play * factor for factor in ranges["play"])
    return f'''"""{_describe_ranges(population)}

Use the terms in the events of an environment whose robot has the joints of NAME_cfg.py.
"""

import isaaclab.envs.mdp as mdp
from isaaclab.managers import EventTermCfg, SceneEntityCfg
from isaaclab.utils import configclass


@configclass
class ReducerEventsCfg:
    """Friction and play of the reducer, drawn once for each environment."""

    friction = EventTermCfg(
        func=mdp.randomize_joint_parameters,
        mode="startup",
        params={{
            "asset_cfg": SceneEntityCfg("robot", joint_names=["{DRIVE}"]),
            "friction_distribution_params": {_format_pair(ranges["friction"])},
            "operation": "scale",
            "distribution": "uniform",
        }},
    )
    play = EventTermCfg(
        func=mdp.randomize_joint_parameters,
        mode="startup",
        params={{
            "asset_cfg": SceneEntityCfg("robot", joint_names=["{PLAY}"]),
            "lower_limit_distribution_params": {_format_pair((play_middle - max_half, play_middle - min_half))},
            "upper_limit_distribution_params": {_format_pair((play_middle + min_half, play_middle + max_half))},
            "operation": "abs",
            "distribution": "uniform",
        }},
    )
'''


def _mjx_randomization(reduced: ReducedJoint, population: Population) -> str:
    """Return a Python module with a domain randomization function of a reduced joint for Brax and MuJoCo Playground.

    `population` has the joint parameters of a sample of drives.
    """
    lines = "".join(f'    "{name}": {_format_pair(limits)},\n' for name, limits in factor_ranges(population).items())
    tendons = [f"{OUTPUT}_reducer" + (f"_{index + 1}" if index else "") for index in range(len(reduced.springs))]
    return f'''"""{_describe_ranges(population)}

    randomize = randomizer(mj_model)  # mujoco.MjModel with joint.xml
    model, in_axes = randomize(mjx.put_model(mj_model), jax.random.split(key, environments))

`randomize` is a randomization function of Brax and MuJoCo Playground.
"""

import jax
import jax.numpy as jnp

RANGES = {{
{lines}}}
"""Factors of play, stiffness and friction without load."""

SPRINGS = {tendons}


def randomizer(mj_model, joint="{OUTPUT}"):
    """Return the function that draws a drive for each key; `joint` is the hinge with the reducer."""
    springs = jnp.array([mj_model.tendon(name.replace("{OUTPUT}", joint, 1)).id for name in SPRINGS])
    crank = mj_model.joint(f"{{joint}}_rotor").dofadr[0]

    def randomize(model, rng):
        @jax.vmap
        def draw(key):
            keys = jax.random.split(key, 3)
            play, stiffness, friction = (
                jax.random.uniform(each, minval=RANGES[name][0], maxval=RANGES[name][1])
                for each, name in zip(keys, ("play", "stiffness", "friction"))
            )
            low, high = model.tendon_lengthspring[springs].T
            middle, half = 0.5 * (low + high), 0.5 * (high - low)
            # the first spring starts at the stop; a stiffer drive reaches the others sooner
            half = half[0] * play + (half - half[0]) / stiffness
            length = jnp.stack([middle - half, middle + half], axis=1)
            return {{
                "tendon_lengthspring": model.tendon_lengthspring.at[springs].set(length),
                "tendon_stiffness": model.tendon_stiffness.at[springs].multiply(stiffness),
                "tendon_damping": model.tendon_damping.at[springs].multiply(stiffness),
                "dof_frictionloss": model.dof_frictionloss.at[crank].multiply(friction),
            }}

        drawn = draw(rng)
        axes = jax.tree_util.tree_map(lambda _: None, model)
        return model.tree_replace(drawn), axes.tree_replace(dict.fromkeys(drawn, 0))

    return randomize
'''


GYMNASIUM_TEXT = f'''"""Draw a built drive at each reset of a Gymnasium environment, from samples.csv next to this file.

    env = RandomDrive(gymnasium.make(...))  # its model includes joint.xml
"""

import csv
from pathlib import Path

import gymnasium
from joint import Joint

HERE = Path(__file__).parent


class RandomDrive(gymnasium.Wrapper):
    """Environment whose joint is another drive of the design in each episode; `drive` has its effects of the load."""

    def __init__(self, env, joint="{OUTPUT}", folder=HERE):
        super().__init__(env)
        self.joint = joint
        self.nominal = Joint(Path(folder) / "reducer.json")
        with open(Path(folder) / "samples.csv", encoding="utf-8") as file:
            self.samples = list(csv.DictReader(file))
        self.drive = self.nominal

    def reset(self, *, seed=None, options=None):
        """Reset the environment, and write a drive into its model."""
        result = self.env.reset(seed=seed, options=options)
        number = self.env.unwrapped.np_random.integers(len(self.samples))
        self.drive = self.nominal.varied(self.samples[number])
        self.drive.write(self.env.unwrapped.model, self.joint)
        return result
'''


def _format_pair(ends: tuple[float, float]) -> str:
    return f"({ends[0]:.6g}, {ends[1]:.6g})"
