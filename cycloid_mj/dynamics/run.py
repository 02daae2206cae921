"""Simulation of a design: blocks of samples, or a complete ``Run`` in memory.

MuJoCo or the planar solver takes the time steps, several samples in one call. Every sample is checked. A run that fails
ends with a ``RunError``; the samples before it have been yielded already.
"""

import math
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from itertools import chain
from typing import Any, Literal

import mujoco
import numpy as np
import numpy.typing as npt

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.deprecated import deprecated_argument
from cycloid_mj.base.errors import RunError, UsageError, warn
from cycloid_mj.base.interrupt import check_interrupt
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.base.record import Deferred, Run, own
from cycloid_mj.base.version import __version__
from cycloid_mj.design import Named, dump, resolve
from cycloid_mj.dynamics.contact import collider, each_step, sample_layout
from cycloid_mj.dynamics.contact.each_step import EachStep
from cycloid_mj.dynamics.contact.forces import drag_rows, pair_index
from cycloid_mj.dynamics.contact.shared import Shared
from cycloid_mj.dynamics.drive_cycle import DriveCycle, initial_state, ramp_and_hold
from cycloid_mj.dynamics.film_table import film_rows
from cycloid_mj.dynamics.jam import jamming_power, moving_means
from cycloid_mj.dynamics.massless import idle_warning
from cycloid_mj.dynamics.mjcf import Held, ReducerModel, build, sensor_addresses, sensors, unused, xml
from cycloid_mj.dynamics.planar.model import PlanarModel, planar_model
from cycloid_mj.dynamics.planar.settings import CONTACT_SEARCH
from cycloid_mj.dynamics.planar.stepper import Stepper
from cycloid_mj.dynamics.planar.timestep import PLANAR_RULE
from cycloid_mj.dynamics.regime import pace_warnings
from cycloid_mj.dynamics.settling import penetration_limit
from cycloid_mj.dynamics.timestep import MUJOCO_RULE, TimeStep, describe_accuracy, timestep
from cycloid_mj.geometry.kinematics import point_motion
from cycloid_mj.geometry.measured import measurement_notes
from cycloid_mj.reducer import Reducer, reducer_of

Groups = dict[str, dict[str, str]]

Contact = Literal["profile", "mesh"]
"""Contact geometry: exact profiles, or convex meshes in MuJoCo's own collision detection."""

Solver = Literal["mujoco", "planar"]
"""Solver of a run: MuJoCo, or the planar equations of motion."""

STEP_RULES = {"mujoco": MUJOCO_RULE, "planar": PLANAR_RULE}
"""Choice of the time step for each solver."""

Model = ReducerModel | PlanarModel
"""A reducer, compiled for one of the solvers."""


@dataclass(frozen=True)
class RunSettings:
    """Sizes of a run."""

    max_steps: int = 10**9
    """Largest number of time steps of a run: more would take at least a day, so a value is probably wrong."""
    block_samples: int = 100
    """Smallest number of samples in a block; this many are lost if a run is stopped."""
    steps_per_call: int = 2000
    """Time steps per call of compiled code: they take 40 to 160 ms, for which Ctrl-C waits. With mesh contact, where a
    step takes some ms, a call ends at the next sample."""


RUN = RunSettings()


MESH_SWAYS = (
    "with mesh contact, mean values are valid (within 3 % of exact profiles), but rms values of disc speed, forces and "
    "accelerations include the ripple of the slices, up to ten times the exact value at idle; use --contact profile "
    "for rms values"
)
"""Warning about results that are not valid with mesh contact."""

Marks = npt.NDArray[np.bool_]

# Every sample is checked for MuJoCo's warnings: they need not go to MUJOCO_LOG.TXT in the working folder as well.
_no_log_file = Shared(
    lambda: mujoco.set_mju_user_warning(lambda message: None), lambda: mujoco.set_mju_user_warning(None)
)


@dataclass(frozen=True)
class SampleBlock:
    """Consecutive samples: times [s], shape (k,), and one array (k, columns) for each topic."""

    time: Array
    values: Mapping[str, Array]


@dataclass(frozen=True)
class Schedule:
    """Time steps and samples of a run.

    Attributes
    ----------
    timestep
        Time step [s].
    steps
        Number of time steps of the run.
    stride
        Time steps from one sample to the next.
    """

    timestep: float
    steps: int
    stride: int

    @property
    def samples(self) -> int:
        """Number of samples of the run, the first at t = 0."""
        return -(-self.steps // self.stride)


def schedule(reducer: Reducer, seconds: float = 0.0) -> Schedule:
    """Return the numbers of time steps and samples of a design's run over ramp and hold.

    `seconds` is the time step [s] of the model; 0 stands for that of the design. The sample interval is a multiple of
    it, close to that of the design's log rate. Duration and sample interval are at least one step.
    """
    design = reducer.design
    seconds = seconds or timestep(reducer)
    steps = max(1, round((design.drive.ramp + design.drive.hold) / seconds))
    stride = max(1, round(1.0 / (design.settings.log_rate * seconds)))
    return Schedule(seconds, steps, min(stride, steps))


def log_columns(model: Model, reducer: Reducer) -> Groups:
    """Return the unit of each column of a log: topic (``/reducer``) -> column (``crank_angle``) -> unit (``rad``)."""
    kinds = sorted(model.laws)
    groups = {topic: dict(columns) for topic, columns in sensors(reducer).items()}
    groups[names.REDUCER] |= {
        "contacts": "1",
        "penetration": "m",
        "peak_force": "N",
        "solver_iterations": "1",
        "potential_energy": "J",
        "kinetic_energy": "J",
    }
    groups[names.REDUCER] |= {
        names.column(kind, power): "W" for kind in kinds for power in (names.FRICTION_POWER, names.NORMAL_POWER)
    }
    groups[names.REDUCER] |= {names.column(name, names.FRICTION_POWER): "W" for name in model.drags}
    groups[names.REDUCER] |= names.POINT_Q
    force_units = {names.FORCE_X: "N", names.FORCE_Y: "N", names.MOMENT: "N m", names.PEAK_FORCE: "N"}
    groups[names.FORCES] = {
        names.column(pair.name, component): unit for pair in model.pairs for component, unit in force_units.items()
    }
    return groups


def model_for(solver: Solver, reducer: Reducer, contact: Contact = "profile", held: Held = "crank") -> Model:
    """Compile a reducer for simulation by a solver, with a kind of contact: exact profiles or convex meshes.

    `held` is the shaft with a servo, "crank" or "output"; with convex meshes, it is the crank.

    Raises
    ------
    UsageError
        The planar solver supports exact profiles only.
    DesignError
        A part of the design is not feasible, or does not support this kind of contact.
    ContactError
        MuJoCo cannot represent a contact's stiffness at this time step.
    """
    if solver == "mujoco":
        return build(reducer.design, held) if contact == "profile" else reducer_model(reducer, contact)
    if contact == "mesh":
        raise UsageError(
            "--contact mesh is not supported by the planar solver, which simulates exact profiles only: use --contact "
            "profile, or --solver mujoco"
        )
    return planar_model(reducer, held)


def reducer_model(reducer: Reducer, contact: Contact = "profile") -> ReducerModel:
    """Build the MuJoCo model of a design for a kind of contact: exact profiles, or convex meshes.

    Raises
    ------
    DesignError
        A part of the design is not feasible, or does not support convex meshes.
    ContactError
        MuJoCo cannot represent a contact's stiffness at this time step.
    """
    if contact == "profile":
        return build(reducer.design)
    from cycloid_mj.dynamics.mjcf.mesh import build_mesh

    return build_mesh(reducer)


def contact_kind(compiled: Model) -> Contact:
    """Return the kind of contact of a model; models with exact profiles have user data of geoms."""
    return "profile" if isinstance(compiled, PlanarModel) or compiled.model.nuser_geom else "mesh"


def solver_name(compiled: Model) -> Solver:
    """Return the solver that a model is for."""
    return "planar" if isinstance(compiled, PlanarModel) else "mujoco"


@deprecated_argument("course", "cycle")
@shows_progress
def simulate(
    design: Named,
    compiled: Model | None = None,
    cycle: DriveCycle | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Run:
    """Simulate a design in memory.

    Parameters
    ----------
    design
        A design, or the name of a preset or of a design file.
    compiled
        Its model, for either solver; by default a new model for MuJoCo.
    cycle
        Commands of crank and output; by default the ramp and the hold of the design.
    progress
        Called with the number of finished samples and the total number.

    Returns
    -------
    Run
        Signals of all bodies and forces of all contacts, for `analyze`, `report` and `write_log`.

    Raises
    ------
    RunError
        The run failed, for example because the drive jams or skips a tooth; see `blocks`.
    DesignError, ContactError
        The model cannot be built; see ``mjcf.build``.

    Warns
    -----
    CycloidWarning
        Results may be inaccurate; see `Run.warnings`.
    """
    reducer = reducer_of(resolve(design))
    compiled = compiled or build(reducer.design)
    groups = log_columns(compiled, reducer)
    sample_count, finished_blocks = schedule(reducer, compiled.timestep).samples, list[SampleBlock]()
    late_texts: tuple[str, ...] = ()

    def collect_blocks() -> Iterator[SampleBlock]:
        nonlocal late_texts
        late_texts = yield from blocks(compiled, reducer, cycle)

    for block in collect_blocks():
        finished_blocks.append(block)
        progress(sum(len(finished.time) for finished in finished_blocks), sample_count)
    return Run(
        time=own(np.concatenate([block.time for block in finished_blocks])),
        columns=_join_columns(groups, finished_blocks),
        units={name: unit for group in groups.values() for name, unit in group.items()},
        provenance=provenance(reducer, contact_kind(compiled), compiled.timestep, solver_name(compiled))
        | warnings_entry((*run_warnings(compiled, reducer, cycle), *late_texts)),
        attachments=attachments(compiled, reducer),
        topics={topic: tuple(columns) for topic, columns in groups.items()},
    )


def _join_columns(groups: Groups, sample_blocks: Sequence[SampleBlock]) -> dict[str, Array]:
    """Join the blocks of a run to one read-only array (n,) for each column, by its name."""
    columns: dict[str, Array] = {}
    for topic, column_names in groups.items():
        tables = [block.values[topic] for block in sample_blocks]
        columns |= {name: own(np.concatenate([table[:, i] for table in tables])) for i, name in enumerate(column_names)}
    return columns


def provenance(
    reducer: Reducer, contact: Contact = "profile", seconds: float = 0.0, solver: Solver = "mujoco"
) -> dict[str, str]:
    """Return the assumptions of a run as texts, by the keys of its log's metadata, such as ``timestep_s``.

    They are design, solver, contact, time step with its reason and accuracy, files of measured parts if any, working
    forces, and versions of the packages. Contacts have their secant stiffness at the working force. `seconds` is the
    time step [s], or 0 for the step that the solver's rule chooses.
    """
    stiffened_reducer = reducer.for_slices if contact == "mesh" else reducer
    step_rule = STEP_RULES[solver]
    chosen_step = step_rule.choose(stiffened_reducer)
    seconds = seconds or chosen_step.seconds
    return {
        "design": reducer.design.name,
        "solver": solver,
        "contact": contact,
        "timestep_s": repr(seconds),
        "timestep": str(chosen_step if chosen_step.seconds == seconds else TimeStep(seconds, "of the model")),
        "timestep_for": describe_accuracy(
            stiffened_reducer
            if chosen_step.seconds == seconds
            else stiffened_reducer.but(settings={"timestep": seconds}),
            step_rule.accuracy,
        ),
        **({"measured": "; ".join(measurement_notes(reducer.design))} if not reducer.design.measured.is_empty else {}),
        "working_forces": stiffened_reducer.contacts.working_forces_text(reducer.mechanism.kinds),
        "cycloid_mj": __version__,
        "mujoco": mujoco.__version__,
        "numpy": np.__version__,
    }


def run_warnings(compiled: Model, reducer: Reducer, cycle: DriveCycle | None = None) -> tuple[str, ...]:
    """Return the warnings that are known before a run: about the model, its speed, and a load that is too small.

    `compiled` is the model of the run, `cycle` its drive cycle; None is the cycle of the design. With a `cycle`, the
    warning of a small load is omitted, and if the crank starts from rest, those that depend on the speed are omitted,
    too.
    """
    is_turning = cycle is None or cycle.speed != 0.0
    mesh_texts = (MESH_SWAYS,) if contact_kind(compiled) == "mesh" and is_turning else ()
    min_steps = STEP_RULES[solver_name(compiled)].min_steps_per_tooth
    pace_texts = (
        pace_warnings(reducer.for_slices if contact_kind(compiled) == "mesh" else reducer, min_steps)
        if is_turning
        else ()
    )
    return (*mesh_texts, *compiled.warnings, *pace_texts, *(idle_warning(reducer) if cycle is None else ()))


def warnings_entry(texts: Sequence[str]) -> dict[str, str]:
    """Return the entry of a run's provenance with its warnings, empty without warnings."""
    return {"warnings": "\n".join(texts)} if texts else {}


def attachments(compiled: Model, reducer: Reducer) -> Mapping[str, bytes]:
    """Return the contents of the files to attach to a log, by name: the design file, the MuJoCo model and its meshes.

    They are created on first access. A planar `compiled` model has no meshes; a MuJoCo model of the design is built for
    it, with lumped needle bearings.
    """
    assets = {} if isinstance(compiled, PlanarModel) else compiled.spec.assets

    def model() -> bytes:
        if isinstance(compiled, PlanarModel):
            return xml(build(reducer.design.but(contact={"needles": "lumped"})).spec).encode()
        return xml(compiled.spec).encode()

    files = {"design.toml": lambda: dump(reducer.design).encode(), "model.xml": model}
    return Deferred(files | {name: partial(bytes, content) for name, content in assets.items()})


def blocks(
    compiled: Model, reducer: Reducer, cycle: DriveCycle | None = None
) -> Generator[SampleBlock, None, tuple[str, ...]]:
    """Run a `compiled` model over a drive cycle, by default the design's own, and yield its samples block by block.

    The generator returns the warnings that are known only at the end of the run, which it has issued as well.

    Raises
    ------
    RunError
        NaN, a warning of MuJoCo, a jam, penetration beyond ``contact.max_penetration_um``, a skipped tooth, or a solver
        that did not converge. The samples before it have been yielded.

    Warns
    -----
    CycloidWarning
        Results may be inaccurate.
    """
    plan = schedule(reducer, compiled.timestep)
    warn(reducer.design.name, run_warnings(compiled, reducer, cycle))
    has_own_cycle, cycle = cycle is None, cycle or ramp_and_hold(compiled, reducer)
    is_exact = contact_kind(compiled) == "profile"
    samples_per_call = max(1, RUN.steps_per_call // plan.stride) if is_exact else 1
    with ExitStack() as stack:
        if isinstance(compiled, PlanarModel):
            stepping = _Stepping(compiled.stepper(cycle, plan.stride))
        else:
            stepping = _make_mujoco_stepper(compiled, reducer, initial_state(compiled, reducer, cycle), plan)
            if is_exact:
                stack.enter_context(collider.install(reducer.design.ring.kind == "nonpin"))
            stack.enter_context(each_step.install())
            stack.enter_context(unused.disable_unused(compiled.model))
            stack.enter_context(_no_log_file.apply())
        recorder = _Recorder(compiled, reducer, stepping, plan, has_own_cycle)
        block_size = max(RUN.block_samples, samples_per_call)
        for first_sample in range(0, plan.samples, block_size):
            samples = range(first_sample, min(first_sample + block_size, plan.samples))
            block, problem = _advance_block(plan, cycle, samples, recorder, samples_per_call)
            if len(block.time):
                yield block
            if problem:
                raise RunError(problem)
    late_texts = stepping.late_warnings(recorder.unconverged_count, plan)
    warn(reducer.design.name, late_texts)
    return late_texts


def _advance_block(
    plan: Schedule, cycle: DriveCycle, samples: range, recorder: "_Recorder", samples_per_call: int
) -> tuple[SampleBlock, str]:
    """Take the time steps of the consecutive `samples` of a run; return the samples, and the problem that ended it.

    The problem is "" if all samples pass their checks; otherwise the samples end with the first that fails. `plan` has
    the numbers of steps and samples of the run, `cycle` the commands of crank and output, and `samples` are indices.
    The `recorder` takes and checks the samples, `samples_per_call` of them in one call of compiled code.
    """
    first_step = (samples.start - 1) * plan.stride + 1 if samples.start else 0
    time = plan.timestep * np.arange(first_step, (samples.stop - 1) * plan.stride + 1, dtype=np.float64)
    recorder.steps.command(cycle.commands(time))
    row_blocks, problem = list[Array](), ""
    for first_sample in samples[::samples_per_call]:
        check_interrupt()
        rows, problem = recorder.advance(min(samples_per_call, samples.stop - first_sample))
        row_blocks.append(rows)
        if problem:
            problem = f"at t = {plan.timestep * (first_sample + len(rows) - 1) * plan.stride:.6f} s {problem}"
            break
    rows = np.concatenate(row_blocks)
    time = time[-1 - (len(samples) - 1) * plan.stride :: plan.stride]
    return SampleBlock(time[: len(rows)], recorder.tables(rows)), problem


@dataclass(frozen=True)
class _Stepping:
    """The stepper of a run, with the limits of its solver.

    Attributes
    ----------
    steps
        Takes the steps and samples them.
    warning
        Describes the first warning of MuJoCo, which ends the run; None for the planar solver.
    most_iterations
        Number of iterations at which the solver has not converged.
    """

    steps: EachStep | Stepper
    warning: Callable[[], str] | None = None
    most_iterations: float = math.inf

    def late_warnings(self, unconverged_count: int, plan: Schedule) -> tuple[str, ...]:
        """Return the warnings at the end of a run about time steps in which the contact geometry did not converge.

        They apply to the planar solver only; `unconverged_count` is the number of these steps, `plan` has that of all
        steps.
        """
        if self.warning or not unconverged_count:
            return ()
        return (
            f"in {unconverged_count} of {plan.steps} time steps the planar solver's contact geometry did not converge "
            f"in {CONTACT_SEARCH.max_searches} searches: contact forces at these times may be wrong; reduce "
            f"settings.timestep_us (now {1e6 * plan.timestep:g})",
        )


def _make_mujoco_stepper(compiled: ReducerModel, reducer: Reducer, data: Any, plan: Schedule) -> _Stepping:
    """Return the stepper of a MuJoCo run, with two conditions that end the run: a warning, or too many iterations.

    `compiled` is the MuJoCo model of `reducer`. From the reducer, the stepper gets the contact laws and, for lubricated
    contacts (law ``film``), the table of friction coefficients. Its samples have the sensor values, and the losses by
    seals and lubricant (drags). `data` is the ``MjData`` to advance; `plan` has the number of steps per sample.
    """
    drag_row_by_loss = drag_rows(compiled.model, names.DRAGS)
    laws = [reducer.contacts[pair.kind].impact for pair in compiled.pairs]
    stepper = EachStep(
        compiled.model,
        data,
        pair_index(compiled.model, compiled.pairs),
        every=plan.stride,
        sources=sensor_addresses(data, reducer),
        drags=[*drag_row_by_loss.values()],
        impacts=[law for law in laws if law],
        orbit_dofs=disc_freedoms(compiled.model, reducer),
        film=film_rows(reducer, compiled.pairs),
    )

    def warning() -> str:
        first_warning = int(np.argmax(data.warning.number > 0))
        return f"MuJoCo issued a warning: {mujoco.mju_warningText(first_warning, data.warning[first_warning].lastinfo)}"

    return _Stepping(stepper, warning, compiled.model.opt.iterations)


def disc_freedoms(model: Any, reducer: Reducer) -> list[int]:
    """Return the index of the degree of freedom along x of each disc; those along y and of its rotation follow."""
    return [int(model.joint(disc.joints[0]).dofadr[0]) for disc in reducer.mechanism.discs]


class _Recorder:
    """Takes samples, checks them, and converts them into tables."""

    def __init__(
        self, compiled: Model, reducer: Reducer, stepping: _Stepping, plan: Schedule, has_own_cycle: bool
    ) -> None:
        """Store the indices of the columns of a run that are checked, and the limits of the checks.

        Parameters
        ----------
        compiled, reducer
            The model, and its reducer.
        stepping, plan
            Stepper of the run with the limits of its solver, and the numbers of steps and samples.
        has_own_cycle
            Whether the drive cycle is that of the design: only then friction is checked for a jam.
        """
        design = reducer.design
        groups = sensors(reducer)
        sensor_names = list(chain.from_iterable(groups.values()))
        self.steps, self._warning = stepping.steps, stepping.warning
        self.unconverged_count = 0
        self._sensor_count, self._first_pin_column = len(sensor_names), len(groups[names.REDUCER])
        self._has_pins = names.PINS in groups
        self._pairs_of_kind = [
            np.array([pair.kind == kind for pair in compiled.pairs]) for kind in sorted(compiled.laws)
        ]
        self._max_penetration, self._iteration_limit = penetration_limit(reducer), stepping.most_iterations
        self._reducer, self._design = reducer, design
        self._jamming_power = jamming_power(reducer) if has_own_cycle else math.inf
        orbit_speed = abs(reducer.orbit_speed)
        mesh_period = 2.0 * math.pi / (design.ring.teeth * orbit_speed) if orbit_speed else math.inf
        mesh_samples = min(mesh_period / (plan.stride * plan.timestep), plan.samples)
        self._friction_history = np.zeros(max(math.ceil(mesh_samples), 1) - 1)
        self._gear_columns = [sensor_names.index(disc.joints[-1]) for disc in reducer.mechanism.discs]
        first_disc = names.gears(design.gear.discs)[0]
        self._pose_columns = [sensor_names.index(name) for name in names.planar_joints(first_disc)]
        self._speed_columns = [sensor_names.index(name) for name in names.planar_speeds(first_disc)]
        self._input_column, self._output_column = (
            sensor_names.index(f"{reducer.INPUT}_angle"),
            sensor_names.index("output_angle"),
        )
        socket_pins = reducer.mechanism.pins if design.ring.has_sockets else ()
        self._free_pin_columns = np.array(
            [[sensor_names.index(joint) for joint in pin.joints[:2]] for pin in socket_pins], dtype=int
        )

    def advance(self, samples: int) -> tuple[Array, str]:
        """Take the next `samples` of a simulated run, and check them.

        Returns
        -------
        tuple
            Rows up to and including the first sample that fails a check, shape (rows, columns), and the problem ("" if
            all samples pass).
        """
        rows = self.steps.advance(samples)
        self.unconverged_count += int(rows[:, self.steps.solver][:, sample_layout.WARNINGS].sum())
        checks = list(self._sample_checks(rows))
        is_wrong = np.any([is_failed for is_failed, _ in checks], axis=0)
        if not is_wrong.any():
            return rows, ""
        first_wrong = int(np.argmax(is_wrong))
        return rows[: first_wrong + 1], next(
            describe(first_wrong) for is_failed, describe in checks if is_failed[first_wrong]
        )

    def tables(self, rows: Array) -> dict[str, Array]:
        """Convert rows of samples to the tables of the log by topic (``/reducer``), each of shape (samples, columns).

        `log_columns` lists the columns of each topic with their units. Powers are summed over the pairs of each kind,
        and the motion of q, the logged point of the disc, is computed from that of the first disc.
        """
        sensor_values, solver_values, drag_losses = (
            rows[:, columns] for columns in (self.steps.copied, self.steps.solver, self.steps.drags)
        )
        pair_values = rows[:, self.steps.pairs].reshape(len(rows), -1, sample_layout.OF_PAIR)
        powers = np.stack(
            [
                pair_values[:, is_of_kind, sample_layout.FRICTION_POWER :].sum(axis=1)
                for is_of_kind in self._pairs_of_kind
            ],
            axis=1,
        )
        energies = sensor_values[:, self._sensor_count :]
        motion_of_q = point_motion(
            (0.0, self._reducer.lever), sensor_values[:, self._pose_columns], sensor_values[:, self._speed_columns]
        )
        tables_of_reducer = [
            sensor_values[:, : self._first_pin_column],
            solver_values[:, : sample_layout.ITERATIONS + 1],
            energies,
            powers.reshape(len(rows), -1),
            drag_losses,
            *motion_of_q,
        ]
        tables = {names.REDUCER: np.concatenate(tables_of_reducer, axis=1)}
        if self._has_pins:
            tables[names.PINS] = sensor_values[:, self._first_pin_column : self._sensor_count]
        return tables | {names.FORCES: pair_values[:, :, : sample_layout.FRICTION_POWER].reshape(len(rows), -1)}

    def _sample_checks(self, rows: Array) -> Iterator[tuple[Marks, Callable[[int], str]]]:
        """Yield for each check of a run a mask (n,) of the n samples that fail it, and a function for its message.

        The function takes the index of a sample in `rows`, shape (n, values), and returns the message. The checks are
        for values that are not finite, warnings of MuJoCo, friction power, penetration, iterations of the solver,
        moving pins outside their sockets, and discs more than a quarter of a tooth pitch from their kinematic angle.
        """
        sensor_values = rows[:, self.steps.copied]
        _, penetration, _, iterations, acceleration_sum, warnings = rows[:, self.steps.solver].T
        is_finite = np.isfinite(sensor_values).all(axis=1) & np.isfinite(acceleration_sum)
        divergence = "the simulation diverged (NaN); reduce settings.timestep_us or the contact stiffness"
        yield ~is_finite, lambda sample: divergence
        if warning := self._warning:
            yield warnings > 0.0, lambda sample: warning()
        pair_values = rows[:, self.steps.pairs].reshape(len(rows), -1, sample_layout.OF_PAIR)
        friction_power = pair_values[:, :, sample_layout.FRICTION_POWER].sum(axis=1)
        normal_power = pair_values[:, :, sample_layout.NORMAL_POWER].sum(axis=1)
        mean_friction = moving_means(friction_power, self._friction_history)
        self._friction_history = np.concatenate([self._friction_history, friction_power])[len(friction_power) :]
        yield mean_friction > self._jamming_power, partial(self._describe_jam, "friction dissipates", mean_friction)
        # parts that wedge store the crank's power in their deflection; too long a time step generates power instead
        wedge_power = friction_power + np.maximum(normal_power, 0.0)
        yield (
            (wedge_power > self._jamming_power) & (penetration > self._max_penetration),
            partial(self._describe_jam, "friction and wedging dissipate", wedge_power),
        )
        yield (
            penetration > self._max_penetration,
            lambda sample: (
                f"a contact penetrates by {penetration[sample] * 1e6:.1f} um, more than contact.max_penetration_um = "
                f"{self._max_penetration * 1e6:g}; reduce settings.timestep_us or the load"
            ),
        )
        yield (
            iterations >= self._iteration_limit,
            lambda sample: (
                f"the constraint solver did not converge in {iterations[sample]:.0f} iterations; "
                "reduce settings.timestep_us"
            ),
        )
        if len(self._free_pin_columns):
            pin_distance = np.linalg.norm(sensor_values[:, self._free_pin_columns], axis=2)
            yield (
                (pin_distance > self._design.ring.pin_radius).any(axis=1),
                lambda sample: (
                    f"pin {np.argmax(pin_distance[sample]) + 1} left its socket: it is "
                    f"{1e3 * pin_distance[sample].max():.3g} mm from "
                    'its seat; see the design check pin_held, or set ring.socket = "closed"'
                ),
            )
        member = self._reducer.member
        ring_angle, _ = member.ring_and_carrier(sensor_values[:, self._output_column])
        crank_angle = member.mesh_angle(sensor_values[:, self._input_column], ring_angle)
        for number, gear_column in enumerate(self._gear_columns, start=1):
            angle_error = sensor_values[:, gear_column] - ring_angle + crank_angle / member.lobes
            disc_name = f"disc {number}" if len(self._gear_columns) > 1 else "the disc"
            quarter_pitch = 0.25 * 2.0 * math.pi / member.lobes
            yield (np.abs(angle_error) > quarter_pitch, partial(_describe_skip, disc_name, angle_error))

    def _describe_jam(self, cause: str, power: Array, sample: int) -> str:
        """Return the error message of a jam in the sample with the index `sample`.

        `cause` is the subject and verb of the message, such as "friction dissipates"; `power` (samples,) is the
        dissipated power [W], which the message contains.
        """
        drive = self._design.drive
        return (
            f"the drive jams: {cause} {power[sample]:.3g} W, which takes {power[sample] / abs(drive.speed):.3g} N m at "
            f"the crank (rated torque {drive.torque:.3g} N m). Either the teeth are self-locking with this friction, "
            "or parts interfere: reduce friction.*, or check clearances and errors"
        )


def _describe_skip(part: str, angle_error: Array, sample: int) -> str:
    return (
        f"{part} skipped a tooth: it is {math.degrees(angle_error[sample]):.3f} deg away from the angle that the crank "
        "dictates; check clearances and load"
    )
