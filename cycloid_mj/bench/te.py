"""Comparison of a measured transmission error with a design, order by order, with a fitted zero of the crank.

The model is the static equilibrium under the load over a full turn of the output, without friction except for an RV
reducer. Both curves are decomposed by least squares into the orders that the measurement resolves: those of the ring,
those of disc and output, and that of the run-out of an RV reducer's output (`measure.orders`). Angles and orders of an
RV reducer are those of its cranks; a bench measures them at the sun.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_mj.base.arguments import require_number
from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.frame import Frame, make_frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.result import Table
from cycloid_mj.base.statistics import rms, rms_about_mean
from cycloid_mj.base.units import ARCSECOND, DEGREE
from cycloid_mj.bench.loop import read_columns
from cycloid_mj.design import Named, resolve
from cycloid_mj.measure.orders import OUTPUT_RUNOUT, base_orders, causes
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.statics import transmission_error

CRANK, ERROR = COLUMNS = ("crank_deg", "te_arcsec")


@dataclass(frozen=True)
class TeSettings:
    """Settings of the comparison of a measured transmission error with the model."""

    max_harmonic: int = 3
    """Largest multiple of the mesh order that is compared."""
    max_cycles_per_point: float = 0.4
    """Highest resolved order in cycles per measured point: below the Nyquist limit of 0.5."""
    min_separation: float = 0.9
    """Smallest distance of two orders that are distinguished, in cycles over the measurement."""
    zero_rtol: float = 1e-9
    """Tolerance of equally good zeros of the crank, as a share of the range of the squared residual: protects against
    rounding."""
    poses_per_period: int = 16
    """Crank angles in a mesh period at which the model is solved, and among which the crank's zero is searched."""
    max_error: float = 36_000.0
    """Largest plausible transmission error [arcsec]: ten degrees."""
    min_amplitude: float = 1e-3
    """Smallest amplitude that is reported, relative to the strongest."""


TE = TeSettings()


@dataclass(frozen=True, eq=False)
class MeasuredError:
    """Measured transmission error [rad] against crank angle [rad], shape (n,) each, and the name of its file."""

    name: str
    crank: Array
    error: Array

    @property
    def turns(self) -> float:
        """Number of crank turns that it covers."""
        return float(np.ptp(self.crank)) / (2.0 * np.pi)


@dataclass(frozen=True, eq=False, repr=False)
class BenchComparison(Presented):
    """Measured transmission error and that of a design."""

    design: str
    load: float
    zero: float
    """Name of the design, torque of the model [N m], and the model's crank angle at the bench's zero [rad]."""
    measured: MeasuredError
    """The measured error."""
    model: Array
    """The model's error at the measured angles, about its mean [rad], shape (n,)."""
    order: Array
    """Orders that are compared [1], shape (k,)."""
    bench_amplitude: Array
    model_amplitude: Array
    """Complex amplitudes by order [rad], shape (k,)."""
    causes: tuple[str, ...]
    """Possible causes of each order, in words."""

    @property
    def frame(self) -> Frame:
        """The orders in both curves, one row each, the strongest first."""
        rows = self.as_json()["orders"]
        return make_frame(rows, rows[0] if rows else (), {"measured_arcsec": "arcsec", "model_arcsec": "arcsec"})

    @property
    def line(self) -> str:
        """Measurement, design and share of the variance that the model explains."""
        return (
            f"{self.measured.name}, {self.design} at {self.load:.4g} N m: the model explains {self.explained_share:.1%}"
        )

    @property
    def explained_shares(self) -> Array:
        """Share of each order's power that the model explains, shape (k,); negative where it is worse than no model."""
        residual = np.abs(self.bench_amplitude - self.model_amplitude) ** 2
        return 1.0 - residual / np.maximum(np.abs(self.bench_amplitude) ** 2, 1e-300)

    @property
    def explained_share(self) -> float:
        """Share of the measured curve's variance that the model explains."""
        measured_error = self.measured.error - self.measured.error.mean()
        return 1.0 - float(np.mean((measured_error - self.model) ** 2) / np.mean(measured_error**2))

    @property
    def strongest_first(self) -> list[int]:
        """Indices of the orders above `TE.min_amplitude` in either curve, the strongest first."""
        size = np.maximum(np.abs(self.bench_amplitude), np.abs(self.model_amplitude))
        return [int(index) for index in np.argsort(-size) if size[index] > TE.min_amplitude * size.max()]

    def table(self, max_rows: int = 20) -> Table:
        """Return a table of the strongest orders of the transmission error, at most `max_rows`.

        Columns are the measured and the computed amplitude [arcsec], the phase between them [deg], the fraction of the
        measured power that the model explains, and possible causes.
        """
        rows = tuple(
            (
                f"{self.order[index]:.6g}",
                float(np.abs(self.bench_amplitude[index])) / ARCSECOND,
                float(np.abs(self.model_amplitude[index])) / ARCSECOND,
                float(np.angle(self.model_amplitude[index] / self.bench_amplitude[index])) / DEGREE,
                f"{self.explained_shares[index]:.1%}",
                self.causes[index],
            )
            for index in self.strongest_first[:max_rows]
        )
        header = (
            "order",
            "measured [arcsec]",
            "model [arcsec]",
            "model leads by [deg]",
            "explained",
            "possible causes",
        )
        return Table(f"{self.measured.name} compared with {self.design}, {self.load:.4g} N m", header, rows)

    def as_json(self) -> dict[str, Any]:
        """Convert the comparison of measured and computed transmission error to JSON values; keys end in units.

        ``explained`` is the fraction of the variance, or of the power of an order, that the model explains. ``orders``
        has the amplitudes of each order, the strongest first. Its ``phase`` is positive if the model leads.
        """
        return {
            "design": self.design,
            "load_nm": self.load,
            "crank_zero_deg": self.zero / DEGREE,
            "turns": self.measured.turns,
            "explained": self.explained_share,
            "measured_rms_arcsec": rms_about_mean(self.measured.error) / ARCSECOND,
            "model_rms_arcsec": rms_about_mean(self.model) / ARCSECOND,
            "residual_rms_arcsec": rms(self.measured.error - self.measured.error.mean() - self.model) / ARCSECOND,
            "orders": [
                {
                    "order": float(self.order[index]),
                    "measured_arcsec": float(np.abs(self.bench_amplitude[index])) / ARCSECOND,
                    "model_arcsec": float(np.abs(self.model_amplitude[index])) / ARCSECOND,
                    "phase_deg": float(np.angle(self.model_amplitude[index] / self.bench_amplitude[index])) / DEGREE,
                    "explained": float(self.explained_shares[index]),
                    "cause": self.causes[index],
                }
                for index in self.strongest_first
            ],
        }


def read_te(path: Path | str) -> MeasuredError:
    """Read a transmission error from a CSV file with the columns crank_deg and te_arcsec.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    MeasuredError
        Crank angles and transmission error [rad].

    Raises
    ------
    UsageError
        The file is missing or malformed, or is no transmission error over at least a turn of the crank.
    """
    path = Path(path)
    columns = read_columns(path, COLUMNS, "a transmission error")
    crank_angles, errors = DEGREE * columns[CRANK], ARCSECOND * columns[ERROR]
    measured_error = MeasuredError(path.stem, crank_angles, errors)
    if measured_error.turns < 1.0 - 2.0 / len(crank_angles):
        span_text = f"{measured_error.turns * 360.0:.4g} deg"
        radians_hint = (
            " (these seem to be in radians)" if np.ptp(columns[CRANK]) < 70.0 and len(crank_angles) > 70 else ""
        )
        raise UsageError(
            f"{path}: {CRANK} covers {span_text}, but at least one full turn of 360 deg is needed. Record at least one "
            f"turn, with angles in degrees{radians_hint}"
        )
    if np.ptp(columns[ERROR]) > TE.max_error or not np.ptp(columns[ERROR]) > 0.0:
        raise UsageError(
            f"{path}: {ERROR} has a range of {np.ptp(columns[ERROR]):.4g} arcsec; the range of a transmission error "
            f"must be greater than 0 and at most {TE.max_error:g} arcsec. Compute it as output angle minus (crank "
            "angle / ratio), in arcseconds"
        )
    return measured_error


def compare_bench(design: Named, measured: MeasuredError, load: float | None = None) -> BenchComparison:
    """Compare a measured transmission error of the output with that of a design.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file.
    measured
        The measured error, from `read_te`.
    load
        Torque on the output [N m]; by default the load of the design or, if it has none, a hundredth of the rated
        torque.

    Returns
    -------
    BenchComparison
        Both curves, their amplitudes by order, and the share of the measured variance that the model explains.

    Raises
    ------
    UsageError
        The design does not exist, the load is 0 or not finite, or the measurement has too few points to resolve its
        orders.
    RunError
        No static equilibrium exists.
    """
    if load is not None:
        require_number("load", load, "N m")
    reducer = reducer_of(resolve(design))
    measured = _convert_to_cranks(reducer, measured)
    torque = (reducer.design.load.torque or 0.01 * reducer.design.rated_torque) if load is None else load
    if not torque:
        raise UsageError(
            "--load-nm 0 is not allowed, because without a load the parts float within their clearances: set a "
            "torque other than 0"
        )
    turn_count = _crank_turns(reducer)
    model_curve = compute_model_error(reducer, torque)
    zero_angle = _fit_zero(model_curve, measured, turn_count)
    model = _interpolate_error(model_curve, measured.crank + zero_angle, turn_count)
    orders = _resolved_orders(reducer, measured)
    if len(measured.crank) < 2 * len(orders) + 1:
        raise UsageError(
            f"{measured.name}: {len(measured.crank)} points are too few to resolve {len(orders)} orders; at least "
            f"{2 * len(orders) + 1} points are needed. Record more points"
        )
    harmonics = np.exp(1j * np.outer(measured.crank, orders))
    design_matrix = np.concatenate([np.ones((len(harmonics), 1)), harmonics.real, harmonics.imag], axis=1)
    coefficients = np.linalg.lstsq(design_matrix, np.stack([measured.error, model], axis=1), rcond=None)[0]
    amplitude = coefficients[1 : len(orders) + 1] - 1j * coefficients[len(orders) + 1 :]
    possible_causes = causes(reducer)
    cause_names = tuple(
        ", ".join(cause.name for cause in possible_causes if cause.has(float(compared_order))) or "none"
        for compared_order in orders
    )
    name, model = reducer.design.name, model - model.mean()
    return BenchComparison(
        name, torque, zero_angle, measured, model, orders, amplitude[:, 0], amplitude[:, 1], cause_names
    )


def compute_model_error(reducer: Reducer, torque: float) -> Array:
    """Compute the output's static transmission error [rad] about its mean under a torque on it [N m], shape (n,).

    The n crank angles are evenly spaced over a turn of the output, from 0 on. Weight is left out, and so is friction
    except for an RV reducer.
    """
    turn_count = _crank_turns(reducer)
    angle_count = TE.poses_per_period * reducer.design.ring.teeth * turn_count
    crank_angles = 2.0 * np.pi * turn_count * np.arange(angle_count) / angle_count
    weightless_reducer = reducer.but(environment={"gravity_x": 0.0, "gravity_y": 0.0})
    if isinstance(reducer, RvReducer):
        # a crank turn at a time, which bounds the memory
        blocks = [
            transmission_error(weightless_reducer, angles, torque)[:, 1]
            for angles in np.split(crank_angles, turn_count)
        ]
        error = np.concatenate(blocks)
    else:
        error = transmission_error(weightless_reducer, crank_angles, torque)[:, 1]
    return np.asarray(reducer.member.sense * (error - error.mean()))


def _crank_turns(reducer: Reducer) -> int:
    """Return the number of crank turns after which the model's error repeats."""
    return round(reducer.design.lobes * reducer.mesh_turn / (2.0 * np.pi))


def _convert_to_cranks(reducer: Reducer, measured: MeasuredError) -> MeasuredError:
    """Convert a measured transmission error of an RV reducer from the angle of the sun to that of its cranks.

    That of another reducer is returned unchanged. Raises UsageError if the measurement covers less than a turn of the
    cranks.
    """
    if not isinstance(reducer, RvReducer):
        return measured
    converted_error = replace(measured, crank=reducer.member.crank_angle(measured.crank))
    if converted_error.turns < 1.0 - 2.0 / len(measured.crank):
        min_angle_deg = abs(float(reducer.member.driven_angle(360.0)))
        raise UsageError(
            f"{measured.name}: {CRANK} covers {360.0 * measured.turns:.4g} deg of the sun, but a turn of the cranks "
            f"takes {min_angle_deg:.4g} deg. Record at least one turn of the cranks"
        )
    return converted_error


def _resolved_orders(reducer: Reducer, measured: MeasuredError) -> Array:
    """Return the k orders that a measurement resolves [cycles per crank turn], increasing, shape (k,).

    `measured` is the measured transmission error. The orders are the multiples of the two base orders of the design
    (`base_orders`): 1 and N/(N-1), where N is the number of teeth of the ring, or (N-1)/N and 1 if the ring rotates. A
    multiple is left out if its distance from an integer is at most `TE.min_separation`, about one cycle over the
    measurement. The highest order is `TE.max_harmonic` times N, or lower if the points are too far from each other to
    resolve it. The order of the output's run-out is included for an RV reducer if the measurement covers about a turn
    of the output.
    """
    tooth_count = reducer.design.ring.teeth
    resolution = TE.max_cycles_per_point * len(measured.crank) / measured.turns
    max_order = min(TE.max_harmonic * tooth_count, int(resolution))
    integer_orders = np.arange(1, max_order + 1, dtype=np.float64)
    (fractional_base,) = set(base_orders(reducer)) - {1}
    multiples = np.arange(1, max_order + 1) * float(fractional_base)
    is_distinct = np.abs(multiples - np.rint(multiples)) * measured.turns > TE.min_separation
    runout_orders = [
        cause.base
        for cause in causes(reducer)
        if cause.key == OUTPUT_RUNOUT and cause.base * measured.turns > TE.min_separation
    ]
    return np.sort(np.concatenate([runout_orders, integer_orders, multiples[is_distinct & (multiples < max_order)]]))


def _fit_zero(model_error: Array, measured: MeasuredError, turn_count: int) -> float:
    """Return the angle [rad] to add to measured crank angles for which the model is nearest to the measurement.

    `model_error` is the model's error [rad], shape (n,), at n equally spaced crank angles over a turn of the output,
    which is `turn_count` turns of the crank. The squared residual is computed for all shifts by FFT, and its minimum
    refined by a parabola. The smallest of equally good angles is returned.
    """
    angle_count, full_turn = len(model_error), 2.0 * np.pi * turn_count
    interval = full_turn / angle_count
    # the measured curve on the model's angles, then all shifts at once
    bins = np.floor(np.mod(measured.crank, full_turn) / interval + 0.5).astype(int) % angle_count
    error = measured.error - measured.error.mean()
    binned_sums, point_counts = np.zeros(angle_count), np.zeros(angle_count)
    np.add.at(binned_sums, bins, error)
    np.add.at(point_counts, bins, 1.0)
    model_spectrum, count_spectrum = np.fft.rfft(model_error), np.conj(np.fft.rfft(point_counts))
    cross_correlation = np.fft.irfft(np.conj(np.fft.rfft(binned_sums)) * model_spectrum, angle_count)
    model_power = np.fft.irfft(count_spectrum * np.fft.rfft(model_error**2), angle_count)
    model_sum = np.fft.irfft(count_spectrum * model_spectrum, angle_count)
    squared_residual = (
        model_power - 2.0 * cross_correlation - model_sum**2 / point_counts.sum()
    )  # about the mean of the model at the measured angles
    index = int(np.argmax(squared_residual <= squared_residual.min() + TE.zero_rtol * np.ptp(squared_residual)))
    neighbours = [squared_residual[(index + shift) % angle_count] for shift in (-1, 0, 1)]
    curvature = neighbours[0] - 2.0 * neighbours[1] + neighbours[2]
    return float((index + (0.5 * (neighbours[0] - neighbours[2]) / curvature if curvature > 0.0 else 0.0)) * interval)


def _interpolate_error(model_error: Array, crank_angles: Array, turn_count: int) -> Array:
    """Interpolate the model's error [rad] at n crank angles [rad], shape (n,), by periodic cubic splines.

    `model_error` is the error [rad] at equally spaced crank angles over a turn of the output, `turn_count` turns of the
    crank.
    """
    from scipy.interpolate import CubicSpline

    full_turn = 2.0 * np.pi * turn_count
    knots = np.linspace(0.0, full_turn, len(model_error) + 1)
    return np.asarray(
        CubicSpline(knots, np.append(model_error, model_error[0]), bc_type="periodic")(np.mod(crank_angles, full_turn))
    )
