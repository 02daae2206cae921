"""Standard test figures of accuracy, stiffness and friction, as makers and standards define them, of model and bench.

Loops of the model and of the bench are evaluated by the same functions; docs/protocol.md explains how to measure each.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np

from cycloid_mj.base.arguments import require_count, require_number
from cycloid_mj.base.array import Array
from cycloid_mj.base.engine import Engine, Progress, silent
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.frame import Frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.base.result import Table
from cycloid_mj.base.units import ARCMINUTE, ARCSECOND, DEGREE, RPM
from cycloid_mj.bench.loop import MeasuredLoop, measured_loop, read_columns, require_torque
from cycloid_mj.bench.loop_figures import NO_FIGURE, LoopFigure, loop_hysteresis, loop_lost_motion, stiffness_between
from cycloid_mj.bench.te import MeasuredError, compute_model_error
from cycloid_mj.design import Named, resolve
from cycloid_mj.design.layouts import Layout
from cycloid_mj.figures import figure
from cycloid_mj.measure import hysteresis
from cycloid_mj.measure.back_driving import START
from cycloid_mj.measure.bench import crank_angles
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.statics.locked import follow_locked_path, slip_elements, solve_locked_curve
from cycloid_mj.statics.rv_sheet import running_rotation

INTERVALS = {"low": (0.03, 0.15), "middle": (0.15, 0.5), "high": (0.5, 1.0)}
"""Ranges of torque over which stiffness is computed, as shares of the rated torque."""


@dataclass(frozen=True)
class ProtocolSettings:
    """Settings of the model's figures.

    Attributes
    ----------
    angles
        Default number of crank angles at which the model is locked.
    branch_points
        Number of torques of a branch of the model's loop by statics.
    unloaded_share
        Share of the rated torque under which the transmission error is computed: without it, parts are loose.
    min_full_torque
        Largest torque of a measured loop over the rated torque from which its figures count.
    complete_torque
        The same, from which a note does not mention that the loop is smaller.
    """

    angles: int = 6
    branch_points: int = 401
    unloaded_share: float = 0.01
    min_full_torque: float = 0.9
    complete_torque: float = 0.98


SETTINGS = ProtocolSettings()

CRANK, CRANK_TORQUE, OUTPUT_TORQUE = "crank_deg", "torque_crank_Nm", "torque_output_Nm"
"""Columns of a bench's files of friction."""


class StatedLine(NamedTuple):
    """Line of the protocol: name, unit, definition, and the source of that."""

    name: str
    unit: str
    definition: str
    source: str


RV_SOURCE = "Nabtesco, RV catalogues, torsional rigidity; Spinea, TwinSpin catalogue; GB/T 40731-2021"
HARMONIC = "Harmonic Drive, engineering data, glossary"
LOST_MOTION_DEFINITION = (
    "rotation between the middles of the loop's branches at +3 % and -3 % of the rated torque, crank locked"
)
STARTING = "torque on the crank at which it begins to turn, without a load on the output"
RUNNING = "mean torque on the crank that keeps its speed, without a load on the output"
BACK_DRIVING = "torque on the output at which the crank begins to turn, without a torque on the crank"

LINES: Mapping[str, StatedLine] = {
    "lost_motion_arcmin": StatedLine("lost motion", "arcmin", LOST_MOTION_DEFINITION, RV_SOURCE),
    "hysteresis_loss_arcmin": StatedLine(
        "hysteresis loss",
        "arcmin",
        "rotation between the loop's branches at zero torque, each unloaded from the rated torque of its side; "
        "Nabtesco calls it backlash",
        f"{HARMONIC}; {RV_SOURCE}",
    ),
    **{
        f"stiffness_{part}_nm_per_arcmin": StatedLine(
            f"torsional stiffness, {100.0 * low:g} to {100.0 * high:g} %",
            "N m/arcmin",
            f"mean slope of the loading branches of both sides from {100.0 * low:g} to {100.0 * high:g} % of the rated "
            "torque, and beyond 1.2 times the Coulomb torque",
            "in intervals of torque as K1, K2, K3 of Harmonic Drive; from half the rated torque on, b/a of Nabtesco",
        )
        for part, (low, high) in INTERVALS.items()
    },
    "te_arcsec": StatedLine(
        "transmission error",
        "arcsec",
        "largest less smallest deviation of the output's angle from the ideal one, over a turn of the output in one "
        "direction, "
        f"unloaded (the model: {100.0 * SETTINGS.unloaded_share:g} % of the rated torque, without friction)",
        f"{HARMONIC}, transmission accuracy; GB/T 35089-2018",
    ),
    "starting_torque_nm": StatedLine("no-load starting torque", "N m", STARTING, f"{HARMONIC}; GB/T 35089-2018"),
    "running_torque_nm": StatedLine("no-load running torque", "N m", RUNNING, f"{HARMONIC}; GB/T 35089-2018"),
    "back_driving_torque_nm": StatedLine("no-load back-driving torque", "N m", BACK_DRIVING, HARMONIC),
}
"""Lines by their keys in JSON, which end in the unit."""


@dataclass(frozen=True)
class BenchFiles:
    """Recordings of a bench, as far as they exist."""

    loops: tuple[MeasuredLoop, ...] = ()
    te: MeasuredError | None = None
    starting: Path | None = None
    running: Path | None = None
    back_driving: Path | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Protocol(Presented):
    """Standard test figures of one drive."""

    design: str
    rated: float
    """Name of the design, and rated torque on the output [N m]."""
    model: Mapping[str, LoopFigure]
    bench: Mapping[str, LoopFigure]
    """Figures by the keys of `LINES`, as far as they exist: the mean over the positions of the crank, and the smallest
    and largest with their intervals."""
    loops: tuple[MeasuredLoop, ...]
    bench_loops: tuple[MeasuredLoop, ...]
    """Loops from which the loop figures are computed."""
    notes: tuple[str, ...]
    """Assumptions, a sentence each."""

    @property
    def line(self) -> str:
        """Design, rated torque, and the first quantities of the model."""
        first_values = ", ".join(
            f"{LINES[key].name} {item.value:.4g} {LINES[key].unit}" for key, item in islice(self.model.items(), 3)
        )
        return f"{self.design}, rated torque {self.rated:.4g} N m; {first_values}"

    def table(self) -> Table:
        """Return the standard test quantities of model and bench, such as the lost motion, as a table of text."""
        rows = tuple(
            (line.name, line.unit, _in_words(self.model.get(key)), _in_words(self.bench.get(key)))
            for key, line in LINES.items()
        )
        title = f"protocol: {self.design}, rated torque {self.rated:.4g} N m"
        return Table(title, ("line", "unit", "model", "bench"), rows)

    @property
    def frame(self) -> Frame:
        """Return a table with named columns: each standard test quantity, computed and measured, with intervals.

        Missing values are NaN.
        """
        sources = {"model": self.model, "bench": self.bench}
        columns: dict[str, Array] = {
            f"{side}_{part}": np.array([getattr(figures.get(key), part, math.nan) for key in LINES])
            for side, figures in sources.items()
            for part in LoopFigure._fields
        }
        text_columns = {"line": np.array(list(LINES)), "unit": np.array([line.unit for line in LINES.values()])}
        return Frame({**text_columns, **columns})

    def as_json(self) -> dict[str, Any]:
        """Convert the standard test quantities of model and bench to JSON values.

        ``lines`` has the test quantities by keys that end in the unit. Each has name, unit, definition and source. Its
        ``model`` and ``bench`` are the simulated and the measured value with its interval, or None.
        """
        return {
            "design": self.design,
            "nominal_torque_nm": self.rated,
            "rated_torque_nm": self.rated,  # the former key, for one release
            "lines": {
                key: {
                    **line._asdict(),
                    "model": _json(self.model.get(key)),
                    "bench": _json(self.bench.get(key)),
                }
                for key, line in LINES.items()
            },
            "notes": list(self.notes),
        }


@shows_progress
def protocol_of(
    design: Named,
    rated_nm: float | None = None,
    *,
    loops: Sequence[MeasuredLoop] = (),
    te: MeasuredError | None = None,
    starting: Path | None = None,
    running: Path | None = None,
    back_driving: Path | None = None,
    angles: int = SETTINGS.angles,
    progress: Progress = silent,
) -> Protocol:
    """Evaluate standard test quantities of a design and of a bench; in Python ``cm.protocol(design)``.

    Parameters
    ----------
    design
        A valid design, or the name of a preset or a file.
    rated_nm
        Rated output torque [N m]; by default that of the design.
    loops, te
        Measured loops (`read_loop`), one for each crank angle, and measured transmission error (`read_te`).
    starting, running, back_driving
        CSV files of the tests of the same name; `docs/protocol.md` describes their columns.
    angles
        Number of crank angles at which the loops of the model are computed.
    progress
        Called with the number of finished crank angles and that of all.

    Returns
    -------
    Protocol
        Lost motion, hysteresis loss, stiffness, transmission error and torques of model and bench.

    Raises
    ------
    UsageError
        The design does not exist, a file is malformed, the torque of a loop is not in N m, or an argument is out of
        range.
    RunError
        The model has no static equilibrium, or a run failed.
    """
    if rated_nm:
        require_number("rated_nm", rated_nm, "N m", above=0.0)
    require_count("angles", angles, 1)
    reducer = reducer_of(resolve(design))
    files = BenchFiles(tuple(loops), te, starting, running, back_driving)
    return protocol(reducer, files, rated_nm or reducer.design.rated_torque, angles, progress)


def protocol(
    reducer: Reducer,
    files: BenchFiles,
    rated_torque: float,
    angles: int = SETTINGS.angles,
    progress: Progress = silent,
    engine: Engine | None = None,
) -> Protocol:
    """Compute lost motion, stiffness, transmission error and no-load torques of a model, and of a bench's recordings.

    Values of the bench for which there is no file are missing from the result.

    Parameters
    ----------
    reducer
        The model.
    files
        Files of the bench.
    rated_torque
        Rated torque on the output [N m].
    angles
        Number of crank angles at which the loops of the model are computed.
    progress, engine
        Called with the numbers of finished and of all crank angles; workers of the computation, by default threads.

    Raises
    ------
    UsageError
        A file is malformed, or the torque of a loop is not in N m.
    RunError
        The model has no static equilibrium, or a run failed.
    """
    for loop in files.loops:
        require_torque(loop, rated_torque)
    bench_quantities = (
        {**_loop_quantities(files.loops, rated_torque), **_read_bench_quantities(files)}
        if files != BenchFiles()
        else {}
    )
    loaded_reducer = reducer.working_at(rated_torque)
    cranks = crank_angles(reducer, angles).tolist()
    engine = engine or Engine(kind="threads")
    loops = tuple(engine.each(lambda crank: compute_model_loop(loaded_reducer, rated_torque, crank), cranks, progress))
    model_quantities = {**_loop_quantities(loops, rated_torque), **_model_quantities(loaded_reducer, rated_torque)}
    notes = list(_model_notes(loaded_reducer, rated_torque, angles))
    back_driving = model_quantities.get("back_driving_torque_nm")
    if back_driving and math.isnan(back_driving.value):
        notes.append("the model is self-locking: friction under a load consumes all of the output's power")
    incomplete_loops = [loop for loop in files.loops if loop.most < SETTINGS.complete_torque * rated_torque]
    notes += [f"{loop.name} reaches {loop.most:.4g} N m, not the rated torque" for loop in incomplete_loops]
    return Protocol(
        reducer.design.name,
        rated_torque,
        model_quantities,
        bench_quantities,
        loops,
        files.loops,
        tuple(notes),
    )


def compute_model_loop(reducer: Reducer, rated_torque: float, crank: float) -> MeasuredLoop:
    """Compute the hysteresis loop of a model with the crank locked at an angle [rad], as a bench would measure it.

    The torque on the output reverses at +-`rated_torque` [N m]. The loop is simulated. A design with friction elements
    parallel to the torsion spring (`slip_elements`) cannot be simulated. Its loop is computed by statics, in which
    these elements are the only friction. Two torque cycles are then computed, and the second is returned.

    Raises
    ------
    RunError
        The model has no static equilibrium, or the run failed.
    """
    elements = slip_elements(reducer)
    if len(elements.limits):
        rising_torque = rated_torque * np.linspace(-1.0, 1.0, SETTINGS.branch_points)
        torque_path = np.concatenate(
            [
                rising_torque[SETTINGS.branch_points // 2 :],
                -rising_torque[1:],
                rising_torque[1:],
                -rising_torque[1:],
                rising_torque[1:],
            ]
        )
        turn = follow_locked_path(solve_locked_curve(reducer, rated_torque, crank), elements, torque_path)
        torque, turn = torque_path[-2 * SETTINGS.branch_points + 1 :], turn[-2 * SETTINGS.branch_points + 1 :]
    else:
        loop = hysteresis.run_loop(reducer, crank, rated_torque, hysteresis.quasi_static_period(reducer, rated_torque))
        torque, turn = loop.torque, loop.turn
    return measured_loop(f"model at {crank / DEGREE:.3g} deg", torque, turn / DEGREE)


def find_breakaway_torque(crank: Array, torque: Array) -> float:
    """Return the magnitude of the torque [N m] at which a crank begins to turn; NaN if it does not turn.

    The torque is that of the last point whose crank angle differs from the first by at most 0.1 deg (`START.turned`).
    `crank` [rad] and `torque` [N m] are in chronological order, shape (n,).
    """
    has_moved = np.abs(crank - crank[0]) > START.turned
    if not has_moved[-1]:
        return math.nan
    resting_rows = np.flatnonzero(~has_moved)
    return float(abs(torque[resting_rows[-1]]))


def read_breakaway_torque(path: Path, torque_column: str) -> float:
    """Read a start from rest from a CSV file, and return the torque at which its crank begins to turn [N m].

    The file has the crank angle in the column ``crank_deg`` [deg] and the torque in the column named `torque_column`
    [N m]. The crank has begun to turn when its angle differs from the first by more than 0.1 deg (`START.turned`).

    Raises
    ------
    UsageError
        The file is malformed, or its crank does not turn.
    """
    columns = read_columns(path, (CRANK, torque_column), "a start from rest")
    breakaway_torque = find_breakaway_torque(DEGREE * columns[CRANK], columns[torque_column])
    if math.isnan(breakaway_torque):
        raise UsageError(
            f"{path}: {CRANK} stays within 0.1 deg of its first value, so the crank never starts to turn. Increase the "
            "torque during the measurement until the crank turns"
        )
    return breakaway_torque


def _loop_quantities(loops: Sequence[MeasuredLoop], rated_torque: float) -> dict[str, LoopFigure]:
    """Compute the test quantities that follow from loops: lost motion, hysteresis loss and stiffness, by key.

    The keys end in the units of the values, such as ``lost_motion_arcmin``. Each value is the mean over the loops; its
    interval extends from the lowest to the highest end of their intervals. Loops with too small a torque are left out:
    it must reach the fraction `SETTINGS.min_full_torque` of the rated torque [N m], or of the torque of the largest
    loop if that is smaller.
    """
    full_loops = [
        loop
        for loop in loops
        if loop.most >= SETTINGS.min_full_torque * min(rated_torque, max(item.most for item in loops))
    ]
    if not full_loops:
        return {}
    figures = [
        {
            "lost_motion_arcmin": loop_lost_motion(loop, rated_torque).scale(1.0 / ARCMINUTE),
            "hysteresis_loss_arcmin": loop_hysteresis(loop, rated_torque).scale(1.0 / ARCMINUTE),
            **{
                f"stiffness_{part}_nm_per_arcmin": stiffness_between(
                    loop, low * rated_torque, high * rated_torque
                ).scale(ARCMINUTE)
                for part, (low, high) in INTERVALS.items()
            },
        }
        for loop in full_loops
    ]
    return {key: _merge_quantities([item[key] for item in figures]) for key in figures[0]}


def _merge_quantities(figures: Sequence[LoopFigure]) -> LoopFigure:
    """Return the mean of a test quantity over several loops, with an interval that covers all of their intervals.

    `figures` are the values with intervals, one for each loop. NaN values are left out; without others, the result is
    NaN.
    """
    known_figures = [figure for figure in figures if not math.isnan(figure.value)]
    if not known_figures:
        return NO_FIGURE
    return LoopFigure(
        float(np.mean([figure.value for figure in known_figures])),
        min(figure.low for figure in known_figures),
        max(figure.high for figure in known_figures),
    )


TORQUE_FIGURES = {
    "starting_torque_nm": "starting_torque_nm",
    "running_torque_nm": "no_load_torque_nm",
    "back_driving_torque_nm": "back_driving_torque_free_nm",
}
"""Lines of torques without load -> figures of the catalogue."""


def _compute_rv_error(reducer: Reducer, torque: float) -> Array:
    return running_rotation(cast(RvReducer, reducer), torque)


MODEL_ERRORS: Mapping[Layout, Callable[[Reducer, float], Array]] = {
    "central": compute_model_error,
    "rv": _compute_rv_error,
}
"""Function of each layout: transmission error [rad] over a turn of the output, shape (n,), under a torque [N m]."""


def _model_quantities(reducer: Reducer, rated_torque: float) -> dict[str, LoopFigure]:
    """Compute ``te_arcsec`` and the no-load torques of a model, such as ``starting_torque_nm``, for a test protocol.

    The values have no intervals. ``te_arcsec`` is the peak-to-peak transmission error under `SETTINGS.unloaded_share`
    of the rated torque [N m]. Torques that the catalogue of quantities does not have for the reducer are left out.
    """
    transmission_error = MODEL_ERRORS[reducer.LAYOUT](reducer, SETTINGS.unloaded_share * rated_torque)
    torques = {line: figure(key) for line, key in TORQUE_FIGURES.items() if figure(key).applies_to(reducer)}
    return {
        "te_arcsec": LoopFigure.about(float(np.ptp(transmission_error)) / ARCSECOND),
        **{line: LoopFigure.about(torque_figure.value(reducer)) for line, torque_figure in torques.items()},
    }


def _model_notes(reducer: Reducer, rated_torque: float, angles: int) -> Iterator[str]:
    """Yield the assumptions of the computed test quantities, for an RV reducer also deviations from their definitions.

    Each is a clause for the notes of the result. `rated_torque` [N m] is that on the output, and `angles` the number of
    crank angles at which loops are computed.
    """
    yield (
        f"model: loops at {angles} crank angles, their mean, smallest and largest value; contacts have the stiffness "
        f"of {rated_torque:.4g} N m; {reducer.design.condition_words}"
    )
    speed = f"{abs(reducer.design.drive.speed) / RPM:.4g} rpm"
    if reducer.design.has_film:
        yield f"the model has film friction: the starting torque is that at a creep speed, the running one at {speed}"
    else:
        yield (
            "the model has Coulomb friction: starting and running torque differ only by what grows with the speed "
            f"({speed})"
        )
    yield "the model's torques include shaft bearings, seals and grease only as [drag] of the design"
    if not isinstance(reducer, RvReducer):
        return
    yield "the crank of the definitions is the sun; the transmission error of the model includes friction"
    yield "the model's back-driving torque is not computed: `measure efficiency` simulates it"
    if not reducer.design.has_film:
        yield (
            'the model\'s torques without load are not computed with friction.law = "coulomb", because statics does '
            'not include weight: set friction.law = "film", or simulate them with `measure efficiency`'
        )


def _read_bench_quantities(files: BenchFiles) -> dict[str, LoopFigure]:
    """Read peak-to-peak transmission error and no-load torques from the files of a test bench; return them by key.

    The keys, such as ``te_arcsec``, end in the units of the values. The values have no confidence intervals. Missing
    files are skipped. The running torque is the mean magnitude over its file. Raises UsageError if a file is malformed.
    """
    quantities = {}
    if files.te:
        quantities["te_arcsec"] = LoopFigure.about(float(np.ptp(files.te.error)) / ARCSECOND)
    if files.starting:
        quantities["starting_torque_nm"] = LoopFigure.about(read_breakaway_torque(files.starting, CRANK_TORQUE))
    if files.running:
        torque = np.abs(read_columns(files.running, (CRANK_TORQUE,), "a run without a load")[CRANK_TORQUE])
        quantities["running_torque_nm"] = LoopFigure.about(float(torque.mean()))
    if files.back_driving:
        quantities["back_driving_torque_nm"] = LoopFigure.about(
            read_breakaway_torque(files.back_driving, OUTPUT_TORQUE)
        )
    return quantities


def _in_words(item: LoopFigure | None) -> str:
    if item is None or math.isnan(item.value):
        return "-"
    return f"{item.value:.4g}" if item.low == item.high else f"{item.value:.4g} ({item.low:.4g} to {item.high:.4g})"


def _json(item: LoopFigure | None) -> dict[str, float] | None:
    return None if item is None or math.isnan(item.value) else item._asdict()
