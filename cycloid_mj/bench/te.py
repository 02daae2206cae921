"""A measured transmission error held against a design's: orders matched, the crank's zero fitted, each order explained.

The model is the static balance under the load at crank angles over a whole turn of the output, without friction. Both
curves are taken apart by least squares into the orders that the measurement tells apart: whole ones, of what belongs to
the ring, and multiples of N/(N-1), of what belongs to gear and output.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.result import Table
from cycloid_mj.base.statistics import rms, rms_about_mean
from cycloid_mj.base.units import ARCSECOND, DEGREE
from cycloid_mj.bench.loop import read_columns
from cycloid_mj.design import Design
from cycloid_mj.measure.orders import causes
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import transmission_error

CRANK, ERROR = COLUMNS = ("crank_deg", "te_arcsec")

HARMONICS = 3
"""Multiples of the mesh order up to which orders are matched."""

ROUNDING = 1e-9
"""By how much less a zero may explain that is as good, as a share of what angles change."""

PER_MESH_PERIOD = 16
"""Angles in a mesh period at which the model is solved, and the crank's zero looked for."""

MOST_ERROR = 36_000.0
"""Largest transmission error [arcsec] that is one: ten degrees are no error."""

SHOWN = 1e-3
"""Least amplitude that is told, as a share of the strongest."""


@dataclass(frozen=True, eq=False)
class MeasuredError:
    """A measured transmission error [rad] against crank angle [rad], shape (n,) each, and its file's name."""

    name: str
    crank: Array
    error: Array

    @property
    def turns(self) -> float:
        """Crank turns that it goes over."""
        return float(np.ptp(self.crank)) / (2.0 * np.pi)


@dataclass(frozen=True, eq=False)
class BenchComparison:
    """A measured transmission error beside a design's.

    Attributes
    ----------
    design, load, zero
        The design's name, the torque of the model [N m], and the model's crank angle at the bench's zero [rad].
    measured
        What was measured.
    model
        The model's error at the measured angles, less its mean [rad], shape (n,).
    order
        Orders that are matched [1], shape (k,).
    bench_amplitude, model_amplitude
        Complex amplitudes by order [rad], shape (k,).
    causes
        What can give each order, in words.
    """

    design: str
    load: float
    zero: float
    measured: MeasuredError
    model: Array
    order: Array
    bench_amplitude: Array
    model_amplitude: Array
    causes: tuple[str, ...]

    @property
    def explained(self) -> Array:
        """Share of each order's power that the model explains, shape (k,): 1 all of it, below 0 worse than nothing."""
        left = np.abs(self.bench_amplitude - self.model_amplitude) ** 2
        return 1.0 - left / np.maximum(np.abs(self.bench_amplitude) ** 2, 1e-300)

    @property
    def whole(self) -> float:
        """Share of the measured curve's variance that the model explains, its mean left out."""
        measured = self.measured.error - self.measured.error.mean()
        return 1.0 - float(np.mean((measured - self.model) ** 2) / np.mean(measured**2))

    @property
    def strongest_first(self) -> list[int]:
        """Places of the orders that show in either curve, the strongest first."""
        size = np.maximum(np.abs(self.bench_amplitude), np.abs(self.model_amplitude))
        return [int(place) for place in np.argsort(-size) if size[place] > SHOWN * size.max()]

    def table(self, most: int = 20) -> Table:
        """Tabulate the strongest orders."""
        rows = tuple(
            (
                f"{self.order[place]:.6g}",
                float(np.abs(self.bench_amplitude[place])) / ARCSECOND,
                float(np.abs(self.model_amplitude[place])) / ARCSECOND,
                float(np.angle(self.model_amplitude[place] / self.bench_amplitude[place])) / DEGREE,
                f"{self.explained[place]:.1%}",
                self.causes[place],
            )
            for place in self.strongest_first[:most]
        )
        header = (
            "order",
            "measured [arcsec]",
            "model [arcsec]",
            "model leads by [deg]",
            "explained",
            "what can give it",
        )
        return Table(f"{self.measured.name} against {self.design}, {self.load:.4g} N m", header, rows)

    def as_json(self) -> dict[str, Any]:
        """Convert all of it to JSON values."""
        return {
            "design": self.design,
            "load_nm": self.load,
            "crank_zero_deg": self.zero / DEGREE,
            "turns": self.measured.turns,
            "explained": self.whole,
            "measured_rms_arcsec": rms_about_mean(self.measured.error) / ARCSECOND,
            "model_rms_arcsec": rms_about_mean(self.model) / ARCSECOND,
            "residual_rms_arcsec": rms(self.measured.error - self.measured.error.mean() - self.model) / ARCSECOND,
            "orders": [
                {
                    "order": float(self.order[place]),
                    "measured_arcsec": float(np.abs(self.bench_amplitude[place])) / ARCSECOND,
                    "model_arcsec": float(np.abs(self.model_amplitude[place])) / ARCSECOND,
                    "phase_deg": float(np.angle(self.model_amplitude[place] / self.bench_amplitude[place])) / DEGREE,
                    "explained": float(self.explained[place]),
                    "cause": self.causes[place],
                }
                for place in self.strongest_first
            ],
        }


def read_te(path: Path) -> MeasuredError:
    """Read a transmission error from a CSV file of the columns crank_deg and te_arcsec.

    Raises
    ------
    UsageError
        The file is not there, not of that form, or is no transmission error over at least a turn of the crank.
    """
    columns = read_columns(path, COLUMNS, "a transmission error")
    crank, error = DEGREE * columns[CRANK], ARCSECOND * columns[ERROR]
    measured = MeasuredError(path.stem, crank, error)
    if measured.turns < 1.0 - 2.0 / len(crank):
        span = f"{measured.turns * 360.0:.4g} deg"
        radians = f": is {CRANK} in radians?" if np.ptp(columns[CRANK]) < 70.0 and len(crank) > 70 else ""
        raise UsageError(f"{path}: {CRANK} goes over {span}; orders need at least a whole turn of 360 deg{radians}")
    if np.ptp(columns[ERROR]) > MOST_ERROR or not np.ptp(columns[ERROR]) > 0.0:
        raise UsageError(
            f"{path}: {ERROR} goes over {np.ptp(columns[ERROR]):.4g} arcsec, which is no transmission error: give the "
            "output's angle less the crank's over the ratio, in seconds of arc"
        )
    return measured


def compare_bench(design: Design, measured: MeasuredError, load: float | None = None) -> BenchComparison:
    """Hold a measured transmission error of the output against a design's, under a load on the output [N m].

    Without a `load` it is the design's own, or a hundredth of the rated torque.

    Raises
    ------
    UsageError
        The load is 0, or the measurement has fewer points than orders to tell apart.
    RunError
        No static balance was found.
    """
    reducer = Reducer(design)
    torque = (reducer.design.load.torque or 0.01 * reducer.design.rated_torque) if load is None else load
    if not torque:
        raise UsageError("--load-nm 0: without a load the parts float in their clearances; give a torque")
    lobes = reducer.design.lobes
    ideal = model_error(reducer, torque)
    zero = _zero(ideal, measured, lobes)
    model = _at(ideal, measured.crank + zero, lobes)
    order = _orders(reducer, measured)
    if len(measured.crank) < 2 * len(order) + 1:
        raise UsageError(
            f"{measured.name}: {len(measured.crank)} points cannot tell {len(order)} orders apart: give at least "
            f"{2 * len(order) + 1}"
        )
    waves = np.exp(1j * np.outer(measured.crank, order))
    basis = np.concatenate([np.ones((len(waves), 1)), waves.real, waves.imag], axis=1)
    solved = np.linalg.lstsq(basis, np.stack([measured.error, model], axis=1), rcond=None)[0]
    amplitude = solved[1 : len(order) + 1] - 1j * solved[len(order) + 1 :]
    known = causes(reducer)
    names = tuple(", ".join(one.name for one in known if one.has(float(each))) or "none" for each in order)
    return BenchComparison(
        reducer.design.name,
        torque,
        zero,
        measured,
        model - model.mean(),
        order,
        amplitude[:, 0],
        amplitude[:, 1],
        names,
    )


def model_error(reducer: Reducer, torque: float) -> Array:
    """Compute the output's error about its mean [rad] under a torque on it [N m], evenly over its turn, shape (n,)."""
    lobes = reducer.design.lobes
    count = PER_MESH_PERIOD * reducer.design.ring.teeth * lobes
    crank = 2.0 * np.pi * lobes * np.arange(count) / count
    error = transmission_error(reducer.but(environment={"gravity_x": 0.0, "gravity_y": 0.0}), crank, torque)[:, 1]
    return np.asarray(error - error.mean())


def _orders(reducer: Reducer, measured: MeasuredError) -> Array:
    """Find the orders that a measurement tells apart: whole ones, and of the gear's those that lie far enough off."""
    teeth, lobes = reducer.design.ring.teeth, reducer.design.lobes
    sampled = 0.4 * len(measured.crank) / measured.turns
    most = min(HARMONICS * teeth, int(sampled))
    whole = np.arange(1, most + 1, dtype=np.float64)
    gear = np.arange(1, most + 1) * teeth / lobes
    apart = np.abs(gear - np.rint(gear)) * measured.turns > 0.9
    return np.sort(np.concatenate([whole, gear[apart & (gear < most)]]))


def _zero(ideal: Array, measured: MeasuredError, lobes: int) -> float:
    """Compute the crank angle of the model at the bench's zero [rad] that explains most of the measured curve.

    The least of all that do so: where parts come to the same places after some turns of the crank, all are alike.
    """
    count, turn = len(ideal), 2.0 * np.pi * lobes
    step = turn / count
    # the measured curve on the model's angles, then all shifts at once
    places = np.floor(np.mod(measured.crank, turn) / step + 0.5).astype(int) % count
    error = measured.error - measured.error.mean()
    total, hits = np.zeros(count), np.zeros(count)
    np.add.at(total, places, error)
    np.add.at(hits, places, 1.0)
    spectrum = np.fft.rfft(ideal)
    cross = np.fft.irfft(np.conj(np.fft.rfft(total)) * spectrum, count)
    power = np.fft.irfft(np.conj(np.fft.rfft(hits)) * np.fft.rfft(ideal**2), count)
    left = power - 2.0 * cross
    best = int(np.argmax(left <= left.min() + ROUNDING * np.ptp(left)))
    near = [left[(best + way) % count] for way in (-1, 0, 1)]
    bend = near[0] - 2.0 * near[1] + near[2]
    return float((best + (0.5 * (near[0] - near[2]) / bend if bend > 0.0 else 0.0)) * step)


def _at(ideal: Array, crank: Array, lobes: int) -> Array:
    """Compute the model's error at crank angles [rad], between its own by cubic splines."""
    from scipy.interpolate import CubicSpline

    turn = 2.0 * np.pi * lobes
    grid = np.linspace(0.0, turn, len(ideal) + 1)
    return np.asarray(CubicSpline(grid, np.append(ideal, ideal[0]), bc_type="periodic")(np.mod(crank, turn)))
