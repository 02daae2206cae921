"""A crank turn of a run: the samples nearest to requested crank angles, in the settled hold."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from cycloid_mj.analysis.series import design_of
from cycloid_mj.analysis.window import in_hold
from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.errors import LogError, UsageError
from cycloid_mj.base.names import CAM, FORCE_X, column, of_disc
from cycloid_mj.base.record import Run
from cycloid_mj.design import PARTS
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.member import view_columns_from_ring

DEGREES = np.radians(np.arange(360.0))
"""All degrees of a crank turn [rad]: the sampling of Hsieh 2014, section 3.3."""

FREE = {
    "load": None,
    "environment": None,
    "settings": None,
    "drive": {"power", "torque", "speed", "ramp", "hold"},
    **{table: {"name"} for table in ("material", *(f"{part}_material" for part in PARTS))},
}
"""Tables in which a log may differ from the design: operating conditions and names."""


def cam_force(reducer: Reducer) -> str:
    """Name a column that every run with forces has."""
    return column(of_disc(CAM, 0, reducer.design.gear.discs), FORCE_X)


@dataclass(frozen=True, eq=False)
class Turn:
    """Samples of a run at k crank angles.

    Attributes
    ----------
    reducer
        The reducer that ran.
    angle
        Crank angle relative to the ring of each sample [rad], within half a sampling step of the requested angle, (k,);
        of an RV reducer relative to the carrier.
    run, rows
        The columns in the frame of the ring, of a run or of statics, and the indices of the samples, shape (k,).
    ring_angle, ring_speed
        Angle and speed of the ring [rad], [rad/s], shape (k,): 0 for a fixed ring.
    """

    reducer: Reducer
    angle: Array
    run: Run | Mapping[str, Array]
    rows: npt.NDArray[np.intp]
    ring_angle: Array
    ring_speed: Array

    def __getitem__(self, name: str) -> Array:
        """Return a column at the samples, shape (k,); raise LogError if there is none."""
        return self.run[name][self.rows]

    def vectors(self, x: str, y: str) -> Array:
        """Stack two columns side by side, shape (k, 2)."""
        return np.stack([self[x], self[y]], axis=-1)


def select_turn(run: Run, reducer: Reducer | None = None, angles: npt.ArrayLike = DEGREES) -> Turn:
    """Return the logged columns of a run in its last crank turn, at the samples nearest to k crank angles [rad], (k,).

    The turn is the last at constant speed and load. Angles and forces are relative to the ring. The run must be a run
    of the design of `reducer`, unless this is None.

    Raises
    ------
    LogError
        The run contains no design or no forces, or too few samples at constant speed and load.
    UsageError
        The run is a run of another design.
    """
    logged_design = design_of(run)
    if logged_design.layout != Reducer.LAYOUT:
        raise LogError(
            f"{run.label} belongs to an RV reducer. The stress of RV reducers is computed from static equilibrium, not "
            "from a log: give the design with --design instead"
        )
    if reducer is not None:
        require_same(reducer, Reducer(logged_design))
    force_column = cam_force(Reducer(logged_design))
    if force_column not in run.columns:
        raise LogError(
            f"{run.label} lacks the contact forces (column {force_column!r}) from which stress is computed. Run "
            "`cycloid-mj simulate` again: it logs all contact forces"
        )
    run = run.usable()
    member = Reducer(logged_design).member
    (angle, _), (speed, _) = (member.ring_and_carrier(run[f"output_{quantity}"]) for quantity in ("angle", "speed"))
    run = replace(run, columns=view_columns_from_ring(Reducer(logged_design), run.columns))
    requested_angles = np.atleast_1d(np.asarray(angles, dtype=np.float64))
    turn_rows = _last_turn(
        run, in_hold(Reducer(logged_design), run.time) & np.isfinite(run[cam_force(Reducer(logged_design))])
    )
    crank_angles = run["crank_angle"][turn_rows]
    _require_resolution(crank_angles, requested_angles, run, turn_rows)
    nearest_rows = np.array([np.argmin(np.abs(_wrap_angles(crank_angles - angle))) for angle in requested_angles])
    selected_rows = turn_rows[nearest_rows]
    return Turn(
        Reducer(logged_design),
        requested_angles + _wrap_angles(crank_angles[nearest_rows] - requested_angles),
        run,
        selected_rows,
        angle[selected_rows],
        speed[selected_rows],
    )


def require_same(reducer: Reducer, ran: Reducer) -> None:
    """Raise UsageError if a design differs from the one that ran in more than load, speed, environment and settings."""
    if differing := list_differences(reducer, ran):
        raise UsageError(
            f"the log does not belong to the design {reducer.design.name!r}: it differs in {'; '.join(differing[:3])} "
            "(SI units). Use the design of the run, or omit --design"
        )


def list_differences(reducer: Reducer, logged_reducer: Reducer) -> list[str]:
    """List the values in which a design differs from that of a log, as text: key, value in the design and in the log.

    `logged_reducer` is the reducer of the log. Differences of load, speed, environment and settings are left out.
    """
    design_values, logged_values = _compared_values(reducer), _compared_values(logged_reducer)
    return [
        f"{key} ({design_values.get(key)} in the design, {logged_values.get(key)} in the log)"
        for key in {**design_values, **logged_values}
        if design_values.get(key) != logged_values.get(key)
    ]


def _compared_values(reducer: Reducer) -> dict[str, Any]:
    """Collect the values of a design that must agree with those of a log, by ``table.key``."""
    free_keys = {"name": True} | {table: keys or True for table, keys in FREE.items()}
    tables = {
        table: value for table, value in reducer.design.model_dump(exclude=free_keys).items() if value is not None
    }
    top_level = {table: value for table, value in tables.items() if not isinstance(value, dict)}
    keyed = {table: keys for table, keys in tables.items() if isinstance(keys, dict)}
    return top_level | {f"{table}.{key}": value for table, keys in keyed.items() for key, value in keys.items()}


def _last_turn(run: Run, is_steady: Mask) -> npt.NDArray[np.intp]:
    """Return the indices of the samples of the last full crank turn of a run, both ends included, shape (samples,).

    Only samples at constant speed and load are used, which the mask `is_steady` marks.

    Raises
    ------
    LogError
        The samples cover less than a turn.
    """
    steady_rows = np.flatnonzero(is_steady)
    crank_angle = run["crank_angle"][steady_rows]
    rotation = abs(crank_angle[-1] - crank_angle[0]) if steady_rows.size else 0.0
    sample_step = rotation / max(steady_rows.size - 1, 1)
    if rotation < 2 * np.pi - sample_step:
        span = float(np.ptp(run.time[steady_rows])) if steady_rows.size else 0.0
        raise LogError(
            f"{run.label}: at constant speed and load the run lasts {span:.4g} s ({rotation / (2 * np.pi):.3f} crank "
            "turns), but at least one turn is needed. Simulate the design again with a longer --hold-s"
        )
    return steady_rows[np.abs(crank_angle[-1] - crank_angle) <= 2 * np.pi + 1e-9]


def _require_resolution(crank_angles: Array, requested: Array, run: Run, rows: npt.NDArray[np.intp]) -> None:
    """Raise LogError if the samples are so coarse that one sample would be used for more than two requested angles.

    `crank_angles` [rad] are the angles of the samples `rows` of the run, `requested` are the angles [rad] at which
    samples are needed.
    """
    sample_step = float(np.median(np.abs(np.diff(crank_angles))))
    requested_step = 2 * np.pi / max(requested.size, 1)
    if requested.size > 1 and sample_step > 1.5 * requested_step:  # no sample is used for more than two angles
        rate = (rows.size - 1) / float(np.ptp(run.time[rows]))
        raise LogError(
            f"{run.label} has one sample per {np.degrees(sample_step):.3g} deg of crank rotation, but one per "
            f"{np.degrees(requested_step):.3g} deg is needed. Simulate the design again with settings.log_rate_hz of "
            f"{rate * sample_step / requested_step:.0f} or more"
        )


def _wrap_angles(angle: Array) -> Array:
    """Compute angles in [-pi, pi) [rad]."""
    return np.mod(angle + np.pi, 2 * np.pi) - np.pi
