"""The motion of a run and its closed form, sample by sample."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from cycloid_mj.analysis import window
from cycloid_mj.analysis.findings import Phase
from cycloid_mj.base import names
from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.errors import LogError, UsageError
from cycloid_mj.base.record import LARGEST, Run
from cycloid_mj.design import Design, loads
from cycloid_mj.geometry import kinematics
from cycloid_mj.geometry.kinematics import CrankLaw
from cycloid_mj.reducer import Reducer, reducer_of

DESIGN_FILE = "design.toml"
MOTION = ("load_torque", "output_angle", "output_speed", "contacts", "penetration", "peak_force")
PIN_1 = ("pin_1_x", "pin_1_y", "pin_1_speed")


@dataclass(frozen=True, eq=False)
class Compared:
    """A quantity, `simulated` and by `theory`, at the same samples: both (n,) or both (n, 2), read-only."""

    simulated: Array
    theory: Array

    def __post_init__(self) -> None:
        self.simulated.setflags(write=False)
        self.theory.setflags(write=False)

    @cached_property
    def error(self) -> Array:
        """Simulated values minus those of the closed form."""
        return self.simulated - self.theory

    @cached_property
    def error_size(self) -> Array:
        """Magnitude of the error, shape (n,)."""
        return np.linalg.norm(self.error, axis=1) if self.error.ndim == 2 else np.abs(self.error)

    @cached_property
    def size(self) -> "Compared":
        """Lengths of the simulated vectors and of those of the closed form, shape (n,)."""
        return Compared(np.linalg.norm(self.simulated, axis=1), np.linalg.norm(self.theory, axis=1))

    def select(self, rows: Mask | slice) -> "Compared":
        """Return the samples selected by `rows`, a mask or slice."""
        return Compared(self.simulated[rows], self.theory[rows])


@dataclass(frozen=True, eq=False)
class PinPath:
    """Motion of ring pin 1 in its socket, or of the sleeve on it.

    Attributes
    ----------
    position
        Displacement of its centre from the socket's (from the pin's) [m], shape (n, 2).
    radial
        Magnitude of that displacement [m], shape (n,).
    spin
        Its speed of rotation [rad/s], counter-clockwise positive, shape (n,).
    clearance
        Largest displacement of the centre without contact [m].
    """

    position: Array
    radial: Array
    spin: Array
    clearance: float


@dataclass(frozen=True, eq=False)
class Series:
    """A run and its closed form; n samples.

    Attributes
    ----------
    run
        The run, up to the first sample that is not all numbers.
    design
        Its design.
    disc
        Index of the disc whose `gear_angle`, `gear_speed` and motion of q these are; `of_disc` selects another disc.
    q
        The point q of the disc, in the disc's frame [m], shape (2,).
    ramp, hold
        Masks of the samples in the ramp and in the settled hold, shape (n,); a run that ended in its ramp has no hold.
    crank_speed
        Speed of the driven shaft, compared with the prescribed ramp and hold [rad/s]: of the crank, or of the sun of an
        RV reducer.
    gear_angle, gear_speed, output_angle, output_speed
        Compared with Eq. 12 at the measured crank angle and speed [rad], [rad/s]; if the ring is the output, with
        theta/N and a disc that does not rotate. The errors of the angles are the transmission errors.
    q_position, q_velocity
        Compared with Eqs 16 and 17 at the measured crank; from the initial centre of the first disc [m], [m/s], (n, 2).
    pin_1
        Ring pin 1; None if the ring has no free pins.
    """

    run: Run
    design: Design
    disc: int
    q: Array
    ramp: Mask
    hold: Mask
    crank_speed: Compared
    gear_angle: Compared
    gear_speed: Compared
    output_angle: Compared
    output_speed: Compared
    q_position: Compared
    q_velocity: Compared
    pin_1: PinPath | None

    @property
    def reducer(self) -> Reducer:
        """The reducer that ran."""
        return reducer_of(self.design)

    @property
    def time(self) -> Array:
        """Times of the samples [s], shape (n,)."""
        return self.run.time

    @property
    def crank_angle(self) -> Array:
        """Measured crank angle [rad], shape (n,); of an RV reducer, from the angle of the sun."""
        return self.reducer.member.crank_angle(self.run[f"{self.reducer.INPUT}_angle"])

    @property
    def orbit_speed(self) -> Array:
        """Speed of the cranks [rad/s], shape (n,), from that of the driven shaft."""
        return self.reducer.member.crank_angle(self.crank_speed.simulated)

    @property
    def gear(self) -> str:
        """Name of the disc: ``gear``, or of several ``gear_1``."""
        return names.gears(self.design.gear.discs)[self.disc]

    @property
    def gear_words(self) -> str:
        """Name of the disc in words: ``gear``, or of several ``gear 1 of 2``."""
        discs = self.design.gear.discs
        return "gear" if discs == 1 else f"gear {self.disc + 1} of {discs}"

    def of_disc(self, disc: int) -> "Series":
        """Return the series with the motion of another disc, by its index."""
        motion: dict[str, Any] = _disc_motion(self.run, self.reducer, self.q, disc)
        return replace(self, disc=disc, **motion)

    @property
    def phase(self) -> Phase:
        """The evaluated phase: the settled hold, or the ramp of a run that ended there."""
        return "hold" if self.hold.any() else "ramp"

    @property
    def evaluation_mask(self) -> Mask:
        """Mask of the evaluated samples, shape (n,): the settled hold, or the entire run without one."""
        return self.hold if self.hold.any() else np.ones_like(self.hold)

    @property
    def whole_periods(self) -> slice:
        """Samples of mean values: full crank turns of the evaluated samples, or else full mesh periods."""
        first_sample = int(np.argmax(self.evaluation_mask))
        part = window.whole_periods(self.crank_angle[first_sample:], 2 * np.pi / self.reducer.mesh_periods)
        return slice(first_sample, first_sample + part.stop)

    @property
    def one_turn(self) -> slice:
        """Samples of a crank turn: of the hold, from crank angle 0 if it is long enough, or the last of the ramp."""
        first_sample = int(np.argmax(self.evaluation_mask))
        find_turn = window.one_turn if self.phase == "hold" else window.last_turn
        part = find_turn(self.crank_angle[first_sample:])
        return slice(first_sample + part.start, first_sample + part.stop)


def series(run: Run, q: npt.ArrayLike | None = None, settle: float | None = None) -> Series:
    """Return the sampled motion of a run, each signal with its closed form: angles, speeds and motion of a point q.

    The series ends before the first sample that has a value which is not finite or exceeds `record.LARGEST`.

    Parameters
    ----------
    run
        Run with its ``design.toml``. With several discs, the series describes the first disc, see `Series.of_disc`.
    q
        Point of the disc in its frame [m], shape (2,); by default the centre of hole 1 (or crank bore 1), on +y.
    settle
        Time after the ramp of the crank speed that is not evaluated [s]; by default an estimate, see `window.in_hold`.

    Raises
    ------
    LogError
        The run has no design, the design does not match it, a column is missing, or it has fewer than two samples.
    DesignError
        The attached design is not valid.
    UsageError
        `q` is not two finite numbers, or `settle` is negative.
    """
    design = design_of(run)
    reducer = reducer_of(design)
    has_moving_pins = design.ring.has_pin_bodies
    disc_columns = [name for gear in names.gears(design.gear.discs) for name in _disc_columns(gear)]
    driven_angle, driven_speed, driven_torque = (
        names.column(reducer.INPUT, quantity) for quantity in ("angle", "speed", "torque")
    )
    required_columns = (driven_angle, driven_speed, driven_torque, *MOTION, *disc_columns)
    run = _cut_before_invalid(run, (*required_columns, *PIN_1) if has_moving_pins else required_columns)
    if len(run) < window.WINDOW.min_samples:
        raise LogError(
            f"{run.label} has {len(run)} usable samples; the analysis needs at least {window.WINDOW.min_samples}. "
            "Simulate the design again with a longer --hold-s"
        )
    if window.reaches_hold(reducer, run.time):
        is_in_hold = window.in_hold(reducer, run.time, settle)
    else:
        is_in_hold = np.zeros(len(run), dtype=np.bool_)
    q = _check_point(q, reducer)
    angle, speed = run[driven_angle], run[driven_speed]
    return Series(
        run=run,
        design=design,
        disc=0,
        q=q,
        ramp=window.in_ramp(reducer, run.time),
        hold=is_in_hold,
        crank_speed=Compared(speed, CrankLaw(design.drive.speed, design.drive.ramp).speed_at(run.time)),
        output_angle=Compared(run["output_angle"], reducer.member.output_angle(angle)),
        output_speed=Compared(run["output_speed"], reducer.member.output_angle(speed)),
        pin_1=_pin_1(run, reducer) if has_moving_pins else None,
        **_disc_motion(run, reducer, q, 0),
    )


def point_path(
    reducer: Reducer, q: Array, disc: int, crank_angle: Array, speed: Array, acceleration: npt.ArrayLike = 0.0
) -> kinematics.PointPath:
    """Compute the closed-form path, velocity and acceleration of a disc's point q: Hsieh 2014, Eqs 16 to 19.

    The crank angle is increased by the phase of the disc on the crank. If the ring is the output, the discs do not
    rotate.

    Parameters
    ----------
    reducer, q, disc
        The reducer, the point in the disc's frame [m], shape (2,), and the index of the disc.
    crank_angle, speed, acceleration
        Angle, speed and acceleration of the crank [rad], [rad/s], [rad/s2], shape (n,).

    Returns
    -------
    PointPath
        Vectors of shape (n, 2) in SI units; positions are relative to the centre of the first disc at crank angle 0.
    """
    gear, phase = reducer.tooth_profile, reducer.phases[disc]
    if reducer.design.output.turns_ring:
        return kinematics.point_path(gear, q, crank_angle + phase, speed, acceleration, turning=False)
    # the disc is turned as the first one is, not as a single disc whose crank is that far ahead
    cos, sin = np.cos(phase / gear.lobes), np.sin(phase / gear.lobes)
    rotated_point = np.array([q[0] * cos - q[1] * sin, q[0] * sin + q[1] * cos]) if phase else q
    return kinematics.point_path(gear, rotated_point, crank_angle + phase, speed, acceleration)


def design_of(run: Run) -> Design:
    """Return the design that is attached to a run.

    Raises
    ------
    LogError
        The attachment is missing or not UTF-8 text, or its numbers of pins or lobes differ from the run's.
    DesignError
        The attachment is not a valid design.
    """
    if DESIGN_FILE not in run.attachments:
        raise LogError(
            f"{run.label} lacks the attached file {DESIGN_FILE}, which the analysis needs. Run `cycloid-mj simulate` "
            "again to write a complete log"
        )
    try:
        text = run.attachments[DESIGN_FILE].decode()
    except UnicodeDecodeError as problem:
        raise LogError(
            f"the file {DESIGN_FILE} attached to {run.label} is not UTF-8 text ({problem}). Run `cycloid-mj simulate` "
            "again to write a complete log"
        ) from problem
    design = loads(text, f"the run's {DESIGN_FILE}")
    _require_matching_pairs(run, reducer_of(design))
    return design


def _require_matching_pairs(run: Run, reducer: Reducer) -> None:
    """Raise LogError if the numbers of pins, lobes or output pins in the run's forces differ from the design's.

    A run has a force of each of these parts on each disc.
    """
    part_names = {"pin_gear": "ring pins", "tooth": "lobes of the internal gear", "output": "output pins"}
    pairs, disc_count = reducer.mechanism.pairs, reducer.design.gear.discs
    for kind, part_name in part_names.items():
        expected_names = {pair.name for pair in pairs if pair.kind == kind}
        logged_names = set(run.pairs(kind))
        if logged_names and logged_names != expected_names:
            pairs_per_part = 1 if len(logged_names) % disc_count else disc_count
            expected, logged = (len(names) // pairs_per_part for names in (expected_names, logged_names))
            raise LogError(
                f"the {DESIGN_FILE} attached to {run.label} has {expected} {part_name}, but the log contains forces "
                f"for {logged}: the attachment belongs to another run. Use the original log, or simulate the design "
                "again"
            )


def _cut_before_invalid(run: Run, column_names: tuple[str, ...]) -> Run:
    """Cut a run before its first invalid sample, which has a value that is not finite or exceeds `LARGEST`.

    A failed run may end in such samples. All columns are checked, also those that the analysis does not need. The note
    of the shortened run states the time of the first omitted sample. Raises LogError if one of the columns
    `column_names`, which the analysis needs, is missing.
    """
    missing_names = [name for name in column_names if name not in run.columns]
    if missing_names:
        raise LogError(
            f"{run.label} lacks {len(missing_names)} of the {len(column_names)} columns that the analysis needs: "
            f"{', '.join(missing_names)}. Run `cycloid-mj simulate` again to write a complete log"
        )
    is_valid = np.ones(len(run), dtype=np.bool_)
    for column_values in run.columns.values():
        is_valid &= np.abs(column_values) <= LARGEST
    if is_valid.all():
        return run
    first_invalid = int(np.argmin(is_valid))
    note = f"samples from {run.time[first_invalid]:.9g} s on were left out: values are not finite or exceed {LARGEST:g}"
    return replace(run.select(slice(0, first_invalid)), note="; ".join(filter(None, (run.note, note))))


def _check_point(q: npt.ArrayLike | None, reducer: Reducer) -> Array:
    """Return the point q as a read-only array (2,) [m], by default the centre of hole 1, or of crank bore 1.

    Raises UsageError if `q` is not two finite numbers.
    """
    point = np.array([0.0, reducer.lever] if q is None else q, dtype=np.float64)
    if point.shape != (2,) or not np.isfinite(point).all():
        raise UsageError(
            f"the point q is {q!r}, which is not valid: give two finite coordinates x, y in the frame of the disc, in "
            "metres, such as (0.026, 0.0)"
        )
    point.setflags(write=False)
    return point


def _disc_columns(gear: str) -> tuple[str, ...]:
    """Return the names of the columns of a disc's motion: x, y, angle, and their speeds."""
    return (*names.planar_joints(gear), *names.planar_speeds(gear))


def _disc_motion(run: Run, reducer: Reducer, q: Array, disc: int) -> dict[str, Compared]:
    """Return the motion of a disc with its closed form, by names of attributes of `Series`.

    The motion consists of the disc's angle [rad] and speed [rad/s], and position [m] and velocity [m/s] of its point
    `q` (2,) [m].
    """
    design = reducer.design
    *_, angle_column, _, _, speed_column = _disc_columns(names.gears(design.gear.discs)[disc])
    angle, speed = (run[names.column(reducer.INPUT, quantity)] for quantity in ("angle", "speed"))
    path = point_path(reducer, q, disc, reducer.member.crank_angle(angle), reducer.member.crank_angle(speed))
    position, velocity = _point_motion(run, reducer, q, disc)
    return {
        "gear_angle": Compared(run[angle_column], reducer.member.gear_angle(angle)),
        "gear_speed": Compared(run[speed_column], reducer.member.gear_angle(speed)),
        "q_position": Compared(position, path.position),
        "q_velocity": Compared(velocity, path.velocity),
    }


def _point_motion(run: Run, reducer: Reducer, q: Array, disc: int) -> tuple[Array, Array]:
    """Position from the initial centre of the first disc [m] and velocity [m/s] of a disc's point q, each (n, 2)."""
    columns = _disc_columns(reducer.gears[disc])
    position, velocity = kinematics.point_motion(q, run.block(columns[:3]), run.block(columns[3:]))
    return position - kinematics.gear_centre(reducer.tooth_profile, 0.0), velocity


def _pin_1(run: Run, reducer: Reducer) -> PinPath:
    position = run.block(PIN_1[:2])
    radial = np.linalg.norm(position, axis=1)
    for values in (position, radial):
        values.setflags(write=False)
    return PinPath(position, radial, run["pin_1_speed"], reducer.design.pin_play)
