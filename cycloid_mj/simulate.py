"""The drive and the step loop: ``Design`` -> blocks of samples, or a whole ``Run``.

The loop is plain ``mj_step``. It checks itself at every sample and ends with a ``RunError`` that says what went
wrong; the samples up to then have been given out already.
"""

import math
from collections.abc import Generator, Mapping
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from cycloid_mj.contact.collider import installed
from cycloid_mj.contact.forces import PairForces, pair_forces, pair_index
from cycloid_mj.contact.shared import Shared
from cycloid_mj.design import Design, dump
from cycloid_mj.errors import RunError
from cycloid_mj.kinematics import CrankLaw
from cycloid_mj.mjcf import ReducerModel, build, sensors, xml
from cycloid_mj.record import Run

Array = npt.NDArray[np.float64]
Groups = dict[str, dict[str, str]]

_BLOCK = 100
# Every sample is checked for MuJoCo's warnings: they need not go to MUJOCO_LOG.TXT in the working folder as well.
_no_log_file = Shared(
    lambda: mujoco.set_mju_user_warning(lambda message: None), lambda: mujoco.set_mju_user_warning(None)
)
_REDUCER, _PINS, _FORCES = "/reducer", "/pins", "/forces"


@dataclass(frozen=True)
class Block:
    """Consecutive samples: times [s], shape (k,), and one array (k, columns) for each topic."""

    time: Array
    values: Mapping[str, Array]


@dataclass(frozen=True)
class Schedule:
    """Steps of a run.

    Attributes
    ----------
    timestep
        Time step [s].
    steps
        Steps of the whole run.
    stride
        Steps from one sample to the next.
    """

    timestep: float
    steps: int
    stride: int

    @property
    def samples(self) -> int:
        """Samples of the whole run, the first at t = 0."""
        return -(-self.steps // self.stride)


def schedule(design: Design) -> Schedule:
    """Give the steps of a design's run: ramp and hold, sampled as near to the log rate as whole steps allow."""
    timestep = design.settings.timestep
    steps = max(1, round((design.drive.ramp + design.drive.hold) / timestep))
    stride = max(1, round(1.0 / (design.settings.log_rate * timestep)))
    return Schedule(timestep, steps, min(stride, steps))


def columns(reducer: ReducerModel, design: Design) -> Groups:
    """Give the log's columns with their units, by topic."""
    kinds = sorted(reducer.laws)
    groups = {topic: dict(names) for topic, names in sensors(design).items()}
    groups[_REDUCER] |= {
        "contacts": "1",
        "penetration": "m",
        "peak_force": "N",
        "solver_iterations": "1",
        "potential_energy": "J",
        "kinetic_energy": "J",
    }
    for kind in kinds:
        groups[_REDUCER] |= {f"{kind}_friction_power": "W", f"{kind}_normal_power": "W"}
    forces: dict[str, str] = {}
    for pair in reducer.pairs:
        forces |= {f"{pair.name}_force_x": "N", f"{pair.name}_force_y": "N", f"{pair.name}_moment": "N m"}
    groups[_FORCES] = forces
    return groups


def simulate(design: Design) -> Run:
    """Run a design in memory.

    Raises
    ------
    RunError
        The run went wrong; nothing is returned.
    """
    reducer = build(design)
    groups = columns(reducer, design)
    run = list(blocks(reducer, design))
    time = np.concatenate([block.time for block in run])
    units = {name: unit for group in groups.values() for name, unit in group.items()}
    values: dict[str, Array] = {}
    for topic, names in groups.items():
        table = np.concatenate([block.values[topic] for block in run])
        values |= {name: table[:, i] for i, name in enumerate(names)}
    return Run(
        time=time,
        columns=values,
        units=units,
        provenance=provenance(design),
        attachments=attachments(reducer, design),
    )


def provenance(design: Design) -> dict[str, str]:
    """Give what a run stands on: contact method, time step, versions."""
    from cycloid_mj import __version__

    return {
        "design": design.name,
        "contact": "profile",
        "timestep_s": repr(design.settings.timestep),
        "cycloid_mj": __version__,
        "mujoco": mujoco.__version__,
        "numpy": np.__version__,
    }


def attachments(reducer: ReducerModel, design: Design) -> dict[str, bytes]:
    """Give the files that make a log complete: the design file and the model."""
    return {"design.toml": dump(design).encode(), "model.xml": xml(reducer.spec).encode()}


def blocks(reducer: ReducerModel, design: Design) -> Generator[Block, None, None]:
    """Run a model and give its samples block by block.

    Raises
    ------
    RunError
        Not a number, a warning of MuJoCo's, penetration beyond ``contact.max_penetration_um``, a jumped tooth, or a
        solver that did not converge; raised after the samples before it were given.
    """
    plan = schedule(design)
    law = CrankLaw(design.drive.speed, design.drive.ramp)
    data = initial_state(reducer, design)
    recorder = _Recorder(reducer, design)
    with installed(), _no_log_file.made():
        for first in range(0, plan.samples, _BLOCK):
            taken, problem = _advance(
                reducer, design, data, plan, law, range(first, min(first + _BLOCK, plan.samples)), recorder
            )
            if len(taken.time):
                yield taken
            if problem:
                raise RunError(problem)


def initial_state(reducer: ReducerModel, design: Design) -> Any:
    """Give the state at t = 0: crank at 0, everything centred, at rest or (without a ramp) at full speed."""
    data = mujoco.MjData(reducer.model)
    if design.drive.ramp == 0.0:
        speed = design.drive.speed
        slow = -speed / design.lobes
        start = {"crank": speed, "gear_x": -design.gear.eccentricity * speed, "gear_angle": slow, "output": slow}
        for joint, velocity in start.items():
            data.joint(joint).qvel[0] = velocity
    return data


def load_torque(design: Design, time: npt.ArrayLike) -> Array:
    """Torque of the load on the output [N m], against its rotation; it rises as a half cosine from zero."""
    share = np.clip(np.asarray(time, dtype=np.float64) / design.load.rise, 0.0, 1.0)
    direction = math.copysign(1.0, design.drive.speed)
    return direction * design.load.torque * 0.5 * (1.0 - np.cos(np.pi * share))


def servo_target(reducer: ReducerModel, law: CrankLaw, time: Array) -> Array:
    """Position command [rad] with which the servo follows the crank law without lag in speed or acceleration."""
    kp, kv = reducer.servo_gains
    torque = reducer.crank_inertia * law.acceleration_at(time)
    return law.angle_at(time) + (kv * law.speed_at(time) + torque) / kp


def _advance(
    reducer: ReducerModel,
    design: Design,
    data: Any,
    plan: Schedule,
    law: CrankLaw,
    samples: range,
    recorder: "_Recorder",
) -> tuple[Block, str]:
    """Take the steps of some samples; a sample is what the solver found at the start of its first step."""
    model, ctrl, step = reducer.model, data.ctrl, mujoco.mj_step
    begin, end = samples.start * plan.stride, min(samples.stop * plan.stride, plan.steps)
    time = plan.timestep * np.arange(begin, end, dtype=np.float64)
    target = servo_target(reducer, law, time)
    load = load_torque(design, time)
    rows: list[dict[str, Array]] = []
    problem = ""
    for number in range(begin, end):
        ctrl[0] = target[number - begin]
        ctrl[1] = load[number - begin]
        step(model, data)
        if number % plan.stride == 0:
            row, problem = recorder.sample(data)
            rows.append(row)
            if problem:
                problem = f"at t = {time[number - begin]:.6f} s {problem}"
                break
    values = {topic: np.array([row[topic] for row in rows]) for topic in recorder.topics}
    return Block(time[:: plan.stride][: len(rows)], values), problem


class _Recorder:
    """Reads one sample out of ``MjData`` and judges it."""

    def __init__(self, reducer: ReducerModel, design: Design) -> None:
        model = reducer.model
        groups = sensors(design)
        self._counts = [len(names) for names in groups.values()]
        self._has_pins = _PINS in groups
        self.topics = tuple(columns(reducer, design))
        self._index = pair_index(model, reducer.pairs)
        self._origins = np.array([model.geom(pair.on).bodyid[0] for pair in reducer.pairs], dtype=np.int32)
        kinds = sorted(reducer.laws)
        self._kinds = np.array([[pair.kind == kind for pair in reducer.pairs] for kind in kinds], dtype=np.float64)
        self._design = design
        self._iterations = model.opt.iterations

    def sample(self, data: Any) -> tuple[dict[str, Array], str]:
        """Give the values of one sample by topic, and what is wrong with it."""
        found = pair_forces(data, self._index, self._origins)
        seen = np.array(data.sensordata)
        powers = np.stack([self._kinds @ found.friction_power, self._kinds @ found.normal_power], axis=1).ravel()
        iterations = float(np.max(data.solver_niter))
        summary = [found.active, found.penetration, found.peak_force, iterations, *data.energy]
        count = self._counts[0]
        row = {_REDUCER: np.concatenate([seen[:count], summary, powers]), _FORCES: found.wrench.ravel()}
        if self._has_pins:
            row[_PINS] = seen[count:]
        return row, self._problem(data, seen, found, iterations)

    def _problem(self, data: Any, seen: Array, found: PairForces, iterations: float) -> str:
        if not (np.isfinite(seen).all() and np.isfinite(data.qacc).all()):
            return "the state is not a number; shorten settings.timestep_us or lower the contact stiffness"
        for warning in range(int(mujoco.mjtWarning.mjNWARNING)):
            if data.warning[warning].number:
                return f"MuJoCo warned: {mujoco.mju_warningText(warning, data.warning[warning].lastinfo)}"
        limit = self._design.contact.max_penetration
        if found.penetration > limit:
            return (
                f"a contact is {found.penetration * 1e6:.1f} um deep, beyond contact.max_penetration_um = "
                f"{limit * 1e6:g}; shorten settings.timestep_us or lower the load"
            )
        if iterations >= self._iterations:
            return (
                f"the constraint solver did not converge in {iterations:.0f} iterations; shorten settings.timestep_us"
            )
        error = float(data.joint("gear_angle").qpos[0] + data.joint("crank").qpos[0] / self._design.lobes)
        if abs(error) > 0.25 * 2.0 * math.pi / self._design.lobes:
            return (
                f"the gear jumped a tooth: it is {math.degrees(error):.3f} deg from where the crank puts it; "
                "check clearances and load"
            )
        return ""
