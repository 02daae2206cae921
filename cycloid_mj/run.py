"""The step loop: ``Design`` -> blocks of samples, or a whole ``Run``.

The loop is plain ``mj_step``, from sample to sample. It checks itself at every sample and ends with a ``RunError``
that says what went wrong; the samples up to then have been given out already.
"""

import math
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, NamedTuple

import mujoco
import numpy as np

from cycloid_mj.compiling import announced
from cycloid_mj.contact import collider, each_step
from cycloid_mj.contact.drag import drag_powers, dragged_joints
from cycloid_mj.contact.each_step import EachStep
from cycloid_mj.contact.forces import PairForces, pair_forces, pair_index
from cycloid_mj.contact.massless import idle
from cycloid_mj.contact.regime import pace
from cycloid_mj.contact.shared import Shared
from cycloid_mj.contact.swing import deepest
from cycloid_mj.contact.timestep import Step, chosen, timestep
from cycloid_mj.contact.working import for_slices, working_forces_told
from cycloid_mj.course import Course, initial_state, ramp_and_hold
from cycloid_mj.design import Design, dump
from cycloid_mj.errors import RunError, warn
from cycloid_mj.mechanism.reducer import mechanism
from cycloid_mj.mjcf import ReducerModel, build, sensors, xml
from cycloid_mj.names import (
    CRANK_JOINT,
    DRAGS,
    FORCE_X,
    FORCE_Y,
    FORCES,
    FRICTION_POWER,
    MOMENT,
    NORMAL_POWER,
    OUTPUT_JOINT,
    PEAK_FORCE,
    PINS,
    REDUCER,
    column,
)
from cycloid_mj.record import Deferred, Run
from cycloid_mj.types import Array

Groups = dict[str, dict[str, str]]

Contact = Literal["profile", "mesh"]
"""How parts meet: by their exact profiles, or as convex meshes in MuJoCo's own collision."""

MOST_STEPS = 10**9
"""A run of more steps would take a day and more; it is a slip of a value."""

_BLOCK = 100
# Every sample is checked for MuJoCo's warnings: they need not go to MUJOCO_LOG.TXT in the working folder as well.
_no_log_file = Shared(
    lambda: mujoco.set_mju_user_warning(lambda message: None), lambda: mujoco.set_mju_user_warning(None)
)


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


def schedule(design: Design, step: float = 0.0) -> Schedule:
    """Give the steps of a design's run: ramp and hold, sampled as near to the log rate as whole steps allow.

    `step` is the time step [s] of the model that runs it; 0: the design's own.
    """
    step = step or timestep(design)
    steps = max(1, round((design.drive.ramp + design.drive.hold) / step))
    stride = max(1, round(1.0 / (design.settings.log_rate * step)))
    return Schedule(step, steps, min(stride, steps))


def columns(reducer: ReducerModel, design: Design) -> Groups:
    """Give the log's columns with their units, by topic."""
    kinds = sorted(reducer.laws)
    groups = {topic: dict(names) for topic, names in sensors(design).items()}
    groups[REDUCER] |= {
        "contacts": "1",
        "penetration": "m",
        "peak_force": "N",
        "solver_iterations": "1",
        "potential_energy": "J",
        "kinetic_energy": "J",
    }
    groups[REDUCER] |= {column(kind, power): "W" for kind in kinds for power in (FRICTION_POWER, NORMAL_POWER)}
    groups[REDUCER] |= {column(name, FRICTION_POWER): "W" for name in dragged_joints(reducer.model, DRAGS)}
    acting = {FORCE_X: "N", FORCE_Y: "N", MOMENT: "N m", PEAK_FORCE: "N"}
    groups[FORCES] = {column(pair.name, part): unit for pair in reducer.pairs for part, unit in acting.items()}
    return groups


def reducer_model(design: Design, contact: Contact = "profile") -> ReducerModel:
    """Build the model of a design for a kind of contact.

    Raises
    ------
    DesignError
        A part of the design cannot be made, or sliced.
    ContactError
        MuJoCo cannot represent a contact's stiffness at this time step.
    """
    if contact == "profile":
        return build(design)
    from cycloid_mj.mjcf.mesh import build_mesh

    return build_mesh(design)


def contact_of(reducer: ReducerModel) -> Contact:
    """Tell the kind of contact of a model: what the collider needs to know of the exact profiles is user data."""
    return "profile" if reducer.model.nuser_geom else "mesh"


def simulate(
    design: Design,
    reducer: ReducerModel | None = None,
    course: Course | None = None,
    progress: Callable[[int, int], None] = lambda done, whole: None,
) -> Run:
    """Run a design in memory, on a model of its own or on one that is given, over its own course or another.

    `progress` is told the samples that are done, and all that there will be.

    Raises
    ------
    RunError
        The run went wrong; nothing is returned.

    Warns
    -----
    CycloidWarning
        Its figures may not be those of the design; `Run.warnings` keeps why.
    """
    reducer = reducer or build(design)
    groups = columns(reducer, design)
    samples, run = schedule(design, reducer.model.opt.timestep).samples, list[Block]()
    for block in blocks(reducer, design, course):
        run.append(block)
        progress(sum(len(one.time) for one in run), samples)
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
        provenance=provenance(design, contact_of(reducer), reducer.model.opt.timestep)
        | warned(warnings(reducer, design, course)),
        attachments=attachments(reducer, design),
        topics={topic: tuple(names) for topic, names in groups.items()},
    )


def provenance(design: Design, contact: Contact = "profile", step: float = 0.0) -> dict[str, str]:
    """Give what a run stands on: contact method, time step, the forces that stiffness is the secant of, versions.

    `step` is as in `schedule`.
    """
    from cycloid_mj import __version__

    made = for_slices(design) if contact == "mesh" else design
    own = chosen(made)
    step = step or own.seconds
    return {
        "design": design.name,
        "contact": contact,
        "timestep_s": repr(step),
        "timestep": str(own if own.seconds == step else Step(step, "the model's")),
        "working_forces": working_forces_told(made, mechanism(design).kinds),
        "cycloid_mj": __version__,
        "mujoco": mujoco.__version__,
        "numpy": np.__version__,
    }


def warnings(reducer: ReducerModel, design: Design, course: Course | None = None) -> tuple[str, ...]:
    """Tell why the figures of a run may not be those of its design; a course that starts at rest does not hurry."""
    hurries = course is None or course.speed != 0.0
    return (*reducer.warnings, *(pace(design) if hurries else ()), *(idle(design) if course is None else ()))


def warned(texts: Sequence[str]) -> dict[str, str]:
    """Give the entry of a run's provenance that keeps its warnings; none where there are none."""
    return {"warnings": "\n".join(texts)} if texts else {}


def attachments(reducer: ReducerModel, design: Design) -> Mapping[str, bytes]:
    """Give the files that make a log complete: the design file and the model, with the meshes that it refers to."""
    assets = {name: partial(bytes, content) for name, content in reducer.spec.assets.items()}
    own = {"design.toml": lambda: dump(design).encode(), "model.xml": lambda: xml(reducer.spec).encode()}
    return Deferred(own | assets)


def blocks(reducer: ReducerModel, design: Design, course: Course | None = None) -> Generator[Block, None, None]:
    """Run a model over a course, by default the design's own, and give its samples block by block.

    Raises
    ------
    RunError
        Not a number, a warning of MuJoCo's, penetration beyond ``contact.max_penetration_um``, a jumped tooth, or a
        solver that did not converge; raised after the samples before it were given.

    Warns
    -----
    CycloidWarning
        As `simulate`.
    """
    warn(design.name, warnings(reducer, design, course))
    plan = schedule(design, reducer.model.opt.timestep)
    course = course or ramp_and_hold(reducer, design)
    data = initial_state(reducer, design, course)
    recorder = _Recorder(reducer, design, data)
    profile = contact_of(reducer) == "profile"
    exact = collider.installed(design.ring.kind == "nonpin") if profile else nullcontext()
    with exact, each_step.installed(), _no_log_file.made():
        with announced():
            recorder.warm()
        for first in range(0, plan.samples, _BLOCK):
            taken, problem = _advance(
                reducer, data, plan, course, range(first, min(first + _BLOCK, plan.samples)), recorder
            )
            if len(taken.time):
                yield taken
            if problem:
                raise RunError(problem)


def _advance(
    reducer: ReducerModel,
    data: Any,
    plan: Schedule,
    course: Course,
    samples: range,
    recorder: "_Recorder",
) -> tuple[Block, str]:
    """Take the steps up to some samples; a sample is what the solver found at the start of its last step."""
    begin = (samples.start - 1) * plan.stride + 1 if samples.start else 0
    time = plan.timestep * np.arange(begin, (samples.stop - 1) * plan.stride + 1, dtype=np.float64)
    recorder.each_step.command(course.commands(time))
    taken: list[_Sample] = []
    problem = ""
    for number in samples:
        recorder.each_step.advance(reducer.model, plan.stride if number else 1)
        sample, problem = recorder.sample()
        taken.append(sample)
        if problem:
            problem = f"at t = {plan.timestep * number * plan.stride:.6f} s {problem}"
            break
    return Block(
        time[-1 - (len(samples) - 1) * plan.stride :: plan.stride][: len(taken)], recorder.tables(taken)
    ), problem


class _Sample(NamedTuple):
    """One sample as it is read, on the way to the tables of a block."""

    sensors: Array
    summary: list[float]
    forces: PairForces
    peaks: Array
    drag: Array


class _Recorder:
    """Reads samples out of ``MjData`` and judges them.

    Arrays that keep their place in ``MjData`` are taken hold of once: a sample comes between steps of a few
    microseconds each.
    """

    def __init__(self, reducer: ReducerModel, design: Design, data: Any) -> None:
        groups = sensors(design)
        self._first_pin = len(groups[REDUCER]) if PINS in groups else None
        self._index = pair_index(reducer.model, reducer.pairs)
        self.each_step = EachStep(data, self._index)
        self._dragged = dragged_joints(reducer.model, DRAGS)
        kinds = sorted(reducer.laws)
        self._kinds = [np.array([pair.kind == kind for pair in reducer.pairs]) for kind in kinds]
        self._deepest, self._design = deepest(design), design
        self._most_iterations = reducer.model.opt.iterations
        self._data = data
        self._sensors = data.sensordata[: sum(len(columns) for columns in groups.values())]
        self._acceleration, self._energy = data.qacc, data.energy
        self._warnings, self._iterations = data.warning.number, data.solver_niter
        self._gears = [data.joint(disc.joints[-1]).qpos for disc in mechanism(design).discs]
        self._crank, self._output = (data.joint(name).qpos for name in (CRANK_JOINT, OUTPUT_JOINT))

    def warm(self) -> None:
        """Have what reads contacts compiled."""
        pair_forces(self._data, self._index)

    def sample(self) -> tuple[_Sample, str]:
        """Give one sample, and what is wrong with it."""
        found = pair_forces(self._data, self._index)
        iterations = max(self._iterations.tolist())
        summary = [found.active, found.penetration, found.peak_force, iterations, *self._energy.tolist()]
        drag = drag_powers(self._data, self._dragged)
        sample = _Sample(self._sensors.copy(), summary, found, self.each_step.peaks(), drag)
        return sample, self._problem(sample, iterations)

    def tables(self, samples: Sequence[_Sample]) -> dict[str, Array]:
        """Give the values of samples by topic, one row for each."""
        count = len(samples)
        seen = np.array([sample.sensors for sample in samples])
        summary = np.array([sample.summary for sample in samples])
        friction = self._by_kind([sample.forces.friction_power for sample in samples])
        normal = self._by_kind([sample.forces.normal_power for sample in samples])
        powers = np.stack([friction, normal], axis=2).reshape(count, -1)
        drags = np.array([sample.drag for sample in samples])
        wrench = np.array([sample.forces.wrench for sample in samples])
        peak = np.array([sample.peaks for sample in samples])[:, :, np.newaxis]
        forces = np.concatenate([wrench, peak], axis=2).reshape(count, -1)
        reducer = np.concatenate([seen[:, : self._first_pin], summary, powers, drags], axis=1)
        if self._first_pin is None:
            return {REDUCER: reducer, FORCES: forces}
        return {REDUCER: reducer, PINS: seen[:, self._first_pin :], FORCES: forces}

    def _by_kind(self, powers: Sequence[Array]) -> Array:
        """Add up powers of pairs, shape (pairs,) each, by kind; without BLAS, whose last bits depend on its threads."""
        table = np.array(powers)
        return np.stack([table[:, of_kind].sum(axis=1) for of_kind in self._kinds], axis=1)

    def _problem(self, sample: _Sample, iterations: int) -> str:
        if not (np.isfinite(sample.sensors).all() and np.isfinite(self._acceleration).all()):
            return "the state is not a number; shorten settings.timestep_us or lower the contact stiffness"
        if any(self._warnings.tolist()):
            warning = int(np.argmax(self._warnings > 0))
            return f"MuJoCo warned: {mujoco.mju_warningText(warning, self._data.warning[warning].lastinfo)}"
        depth = sample.forces.penetration
        if depth > self._deepest:
            return (
                f"a contact is {depth * 1e6:.1f} um deep, beyond contact.max_penetration_um = "
                f"{self._deepest * 1e6:g}; shorten settings.timestep_us or lower the load"
            )
        if iterations >= self._most_iterations:
            return f"the constraint solver did not converge in {iterations} iterations; shorten settings.timestep_us"
        lobes = self._design.lobes
        ring = self._output[0] if self._design.output.turns_ring else 0.0
        for number, gear in enumerate(self._gears, start=1):
            error = gear[0] - ring + (self._crank[0] - ring) / lobes
            if abs(error) > 0.25 * 2.0 * math.pi / lobes:
                which = f"gear {number}" if len(self._gears) > 1 else "the gear"
                return (
                    f"{which} jumped a tooth: it is {math.degrees(error):.3f} deg from where the crank puts it; "
                    "check clearances and load"
                )
        return ""
