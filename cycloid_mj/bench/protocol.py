"""What makers and standards state of a reducer's accuracy, stiffness and friction, from the model and from a bench.

A loop of the model and a loop of a bench are read by the same functions; docs/protocol.md says how to measure each.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.engine import Engine, Progress, silent
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.frame import Frame
from cycloid_mj.base.result import Table
from cycloid_mj.base.units import ARCMINUTE, ARCSECOND, DEGREE, RPM
from cycloid_mj.bench.loop import MeasuredLoop, measured_loop, read_columns, require_torque
from cycloid_mj.bench.loop_figures import LoopFigure, hysteresis_of, lost_motion_of, stiffness_between
from cycloid_mj.bench.te import MeasuredError, model_error
from cycloid_mj.figures import figure
from cycloid_mj.measure import hysteresis
from cycloid_mj.measure.back_driving import TURNED
from cycloid_mj.measure.bench import crank_angles
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.locked import locked_course, locked_curve, slip_elements

INTERVALS = {"low": (0.03, 0.15), "middle": (0.15, 0.5), "high": (0.5, 1.0)}
"""Parts of the rated torque over which stiffness is given."""

ANGLES = 6
"""Crank angles at which the model is held, unless another number is asked for."""

POINTS = 401
"""Torques of a branch of the model's loop by statics."""

UNLOADED = 0.01
"""Share of the rated torque under which the model's transmission error is told: without any, parts float."""

CRANK, CRANK_TORQUE, OUTPUT_TORQUE = "crank_deg", "torque_crank_Nm", "torque_output_Nm"
"""Columns of a bench's files of friction."""


class StatedLine(NamedTuple):
    """One line of the protocol: what it is, its unit, how it is defined, and who defines it so."""

    name: str
    unit: str
    definition: str
    source: str


RV = "Nabtesco, RV catalogues, torsional rigidity; Spinea, TwinSpin catalogue; GB/T 40731-2021"
HARMONIC = "Harmonic Drive, engineering data, glossary"

LINES: Mapping[str, StatedLine] = {
    "lost_motion_arcmin": StatedLine(
        "lost motion",
        "arcmin",
        "turn between the middles of the loop's branches at +3 % and -3 % of the rated torque, crank held",
        RV,
    ),
    "hysteresis_loss_arcmin": StatedLine(
        "hysteresis loss",
        "arcmin",
        "turn between the loop's branches at no torque, each let go from the rated torque of its side; Nabtesco calls "
        "it backlash",
        f"{HARMONIC}; {RV}",
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
        "largest less least departure of the output's angle from the ideal one, over a turn of the output, one way, "
        f"unloaded (the model: {100.0 * UNLOADED:g} % of the rated torque, without friction)",
        f"{HARMONIC}, transmission accuracy; GB/T 35089-2018",
    ),
    "starting_torque_nm": StatedLine(
        "no-load starting torque",
        "N m",
        "torque on the crank at which it begins to turn, no load on the output",
        f"{HARMONIC}; GB/T 35089-2018",
    ),
    "running_torque_nm": StatedLine(
        "no-load running torque",
        "N m",
        "mean torque on the crank that keeps it at its speed, no load on the output",
        f"{HARMONIC}; GB/T 35089-2018",
    ),
    "back_driving_torque_nm": StatedLine(
        "no-load back-driving torque",
        "N m",
        "torque on the output at which the crank begins to turn, nothing on the crank",
        HARMONIC,
    ),
}
"""Lines by their keys in JSON, which end in the unit."""


@dataclass(frozen=True)
class BenchFiles:
    """What a bench recorded: files, as far as there are any."""

    loops: tuple[MeasuredLoop, ...] = ()
    te: MeasuredError | None = None
    starting: Path | None = None
    running: Path | None = None
    back_driving: Path | None = None


@dataclass(frozen=True, eq=False)
class Protocol:
    """The lines of one drive.

    Attributes
    ----------
    design, rated
        Name, and the torque on the output that is taken as rated [N m].
    model, bench
        Figures by the keys of `LINES`, those that there are: a mean over the positions of the crank, and the least and
        the largest of them with their intervals.
    loops, bench_loops
        What loop figures are read off.
    notes
        What the figures stand on, a sentence each.
    """

    design: str
    rated: float
    model: Mapping[str, LoopFigure]
    bench: Mapping[str, LoopFigure]
    loops: tuple[MeasuredLoop, ...]
    bench_loops: tuple[MeasuredLoop, ...]
    notes: tuple[str, ...]

    def table(self) -> Table:
        """Tabulate the lines, model beside bench."""
        rows = tuple(
            (line.name, line.unit, _in_words(self.model.get(key)), _in_words(self.bench.get(key)))
            for key, line in LINES.items()
        )
        title = f"protocol: {self.design}, rated torque {self.rated:.4g} N m"
        return Table(title, ("line", "unit", "model", "bench"), rows)

    @property
    def frame(self) -> Frame:
        """The lines, a row each; no number where there is none."""
        sides = {"model": self.model, "bench": self.bench}
        columns: dict[str, Array] = {
            f"{side}_{part}": np.array([getattr(of.get(key), part, math.nan) for key in LINES])
            for side, of in sides.items()
            for part in LoopFigure._fields
        }
        text = {"line": np.array(list(LINES)), "unit": np.array([line.unit for line in LINES.values()])}
        return Frame({**text, **columns})

    def as_json(self) -> dict[str, Any]:
        """Convert all of it to JSON values."""
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


def protocol(
    reducer: Reducer,
    files: BenchFiles,
    rated: float,
    angles: int = ANGLES,
    progress: Progress = silent,
    engine: Engine | None = None,
) -> Protocol:
    """Compute every line from the model, and those that a bench's files have from them.

    Parameters
    ----------
    reducer
        The model.
    files
        Of the bench.
    rated
        The rated torque [N m].
    angles
        Crank angles at which the model is held.
    progress, engine
        As the work of a command has them; by default none, and threads here.

    Raises
    ------
    UsageError
        A file is not of its form, or the torque of a loop not in N m.
    RunError
        The model has no balance, or a run went wrong.
    """
    for loop in files.loops:
        require_torque(loop, rated)
    of_bench = {**_of_loops(files.loops, rated), **_of_files(files)} if files != BenchFiles() else {}
    loaded = reducer.working_at(rated)
    cranks = crank_angles(reducer, angles).tolist()
    engine = engine or Engine(kind="threads")
    loops = tuple(engine.each(lambda crank: model_loop(loaded, rated, crank), cranks, progress))
    of_model = {**_of_loops(loops, rated), **_of_model(loaded, rated)}
    notes = [
        f"the model: loops at {angles} crank angles, the mean and the least and largest of them; contacts "
        f"have the stiffness of {rated:.4g} N m",
        "the model's friction is Coulomb's: what starts it is what keeps it turning, but for what grows with the speed "
        f"({abs(reducer.design.drive.speed) / RPM:.4g} rpm)",
        "shaft bearings, seals and grease are in neither of the model's torques, but for [drag] of the design",
    ]
    if math.isnan(of_model["back_driving_torque_nm"].value):
        notes.append("the model locks itself: friction under a load takes all that its output gives")
    short = [loop for loop in files.loops if loop.most < 0.98 * rated]
    notes += [f"{loop.name} goes to {loop.most:.4g} N m, not to the rated torque" for loop in short]
    return Protocol(
        reducer.design.name,
        rated,
        of_model,
        of_bench,
        loops,
        files.loops,
        tuple(notes),
    )


def model_loop(reducer: Reducer, rated: float, crank: float) -> MeasuredLoop:
    """Compute the loop to a torque on the output [N m] and back at a held crank [rad], as a bench would record it.

    A run as `measure lost-motion` makes it; where the design has friction of its wind-up (`springs`), which no run has,
    by statics, that friction standing for all.
    """
    slips = slip_elements(reducer)
    if len(slips.limits):
        up = rated * np.linspace(-1.0, 1.0, POINTS)
        course = np.concatenate([up[POINTS // 2 :], -up[1:], up[1:], -up[1:], up[1:]])
        turn = locked_course(locked_curve(reducer, rated, crank), slips, course)
        torque, turn = course[-2 * POINTS + 1 :], turn[-2 * POINTS + 1 :]
    else:
        loop = hysteresis.loop(reducer, crank, rated, hysteresis.slow_period(reducer, rated))
        torque, turn = loop.torque, loop.turn
    return measured_loop(f"model at {crank / DEGREE:.3g} deg", torque, turn / DEGREE)


def started(crank: Array, torque: Array) -> float:
    """Find the torque at which a crank begins to turn: the last before it leaves where it was by 0.1 deg for good.

    Angles [rad] and torques in the order of time, shape (n,); no number where it stays.
    """
    away = np.abs(crank - crank[0]) > TURNED
    if not away[-1]:
        return math.nan
    still = np.flatnonzero(~away)
    return float(abs(torque[still[-1]]))


def read_started(path: Path, torque: str) -> float:
    """Read the torque at which the crank begins to turn from a CSV file of the columns crank_deg and `torque` [N m].

    Raises
    ------
    UsageError
        The file is not of that form, or its crank does not turn.
    """
    columns = read_columns(path, (CRANK, torque), "a start from rest")
    value = started(DEGREE * columns[CRANK], columns[torque])
    if math.isnan(value):
        raise UsageError(f"{path}: {CRANK} stays within 0.1 deg of its first value: record until the crank turns")
    return value


def _of_loops(loops: Sequence[MeasuredLoop], rated: float) -> dict[str, LoopFigure]:
    """Read the loop figures of every loop that goes furthest; their mean, least and largest."""
    furthest = [loop for loop in loops if loop.most >= 0.9 * min(rated, max(one.most for one in loops))]
    if not furthest:
        return {}
    each = [
        {
            "lost_motion_arcmin": lost_motion_of(loop, rated).scaled(1.0 / ARCMINUTE),
            "hysteresis_loss_arcmin": hysteresis_of(loop, rated).scaled(1.0 / ARCMINUTE),
            **{
                f"stiffness_{part}_nm_per_arcmin": stiffness_between(loop, low * rated, high * rated).scaled(ARCMINUTE)
                for part, (low, high) in INTERVALS.items()
            },
        }
        for loop in furthest
    ]
    return {key: _over([one[key] for one in each]) for key in each[0]}


def _over(figures: Sequence[LoopFigure]) -> LoopFigure:
    """Compute the mean of a figure over the positions that show it, and the ends of all their intervals."""
    seen = [one for one in figures if not math.isnan(one.value)]
    if not seen:
        return LoopFigure(math.nan, math.nan, math.nan)
    return LoopFigure(
        float(np.mean([one.value for one in seen])), min(one.low for one in seen), max(one.high for one in seen)
    )


def _of_model(reducer: Reducer, rated: float) -> dict[str, LoopFigure]:
    """Compute the model's lines that no loop shows: those of the catalogue by its functions."""
    of_catalogue = {
        "starting_torque_nm": "starting_torque_nm",
        "running_torque_nm": "no_load_torque_nm",
        "back_driving_torque_nm": "back_driving_torque_free_nm",
    }
    return {
        "te_arcsec": _within(float(np.ptp(model_error(reducer, UNLOADED * rated))) / ARCSECOND, 0.0),
        **{line: _within(figure(key).value(reducer), 0.0) for line, key in of_catalogue.items()},
    }


def _of_files(files: BenchFiles) -> dict[str, LoopFigure]:
    """Read the lines that the files beside the loops show."""
    figures = {}
    if files.te:
        figures["te_arcsec"] = _within(float(np.ptp(files.te.error)) / ARCSECOND, 0.0)
    if files.starting:
        figures["starting_torque_nm"] = _within(read_started(files.starting, CRANK_TORQUE), 0.0)
    if files.running:
        torque = np.abs(read_columns(files.running, (CRANK_TORQUE,), "a run without a load")[CRANK_TORQUE])
        figures["running_torque_nm"] = _within(float(torque.mean()), 0.0)
    if files.back_driving:
        figures["back_driving_torque_nm"] = _within(read_started(files.back_driving, OUTPUT_TORQUE), 0.0)
    return figures


def _within(value: float, error: float) -> LoopFigure:
    return LoopFigure(value, value - error, value + error)


def _in_words(one: LoopFigure | None) -> str:
    if one is None or math.isnan(one.value):
        return "-"
    return f"{one.value:.4g}" if one.low == one.high else f"{one.value:.4g} ({one.low:.4g} to {one.high:.4g})"


def _json(one: LoopFigure | None) -> dict[str, float] | None:
    return None if one is None or math.isnan(one.value) else one._asdict()
