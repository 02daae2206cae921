"""Harmonics of the full model's transmission error over a full turn of the output.

After a full turn all parts are in their first pose: each order is an integer number of cycles, and the Fourier sum has
no leakage.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import RunError
from cycloid_mj.reducer import Reducer
from cycloid_mj.robot.ripple import Ripple
from cycloid_mj.statics.balance import loads
from cycloid_mj.statics.springs import springs_of

Waves = npt.NDArray[np.complex128]


@dataclass(frozen=True)
class RippleSettings:
    """Loads and crank angles of the transmission error, and the harmonics that are kept."""

    loads: tuple[float, float] = (0.3, 1.0)
    """Shares of the nominal torque, in both directions, in addition to nearly no load."""
    unloaded: tuple[float, ...] = (0.01, 0.03, 0.1)
    """Shares that represent no load, as in `measure te`: the first under which friction does not jam the parts is
    used."""
    poses_per_period: int = 8
    """Crank angles in a mesh period; half as many give the numerical error."""
    max_remainder: float = 0.02
    """Remainder of an error without its kept harmonics, as a share of its rms value."""
    max_harmonics: int = 32
    """Largest number of harmonics that are kept."""


RIPPLE = RippleSettings()


def turns(reducer: Reducer) -> int:
    """Return the number of crank turns after which the error repeats."""
    return round(reducer.design.reduction)


def solve_ripple(reducer: Reducer, on_turn: Callable[[], None]) -> Ripple:
    """Compute the significant harmonics of the error without a load and at `RIPPLE.loads`, in both directions.

    `on_turn` is called after each turn of the crank that is solved.
    """
    lightest = next((load for load in RIPPLE.unloaded if _balances(reducer, load)), RIPPLE.unloaded[-1])
    shares = (lightest, *RIPPLE.loads)
    spectra = {(load, sign): waves(solve_error(reducer, load, sign, on_turn)) for sign in (1, -1) for load in shares}
    kept = _strongest_harmonics([fine for fine, _ in spectra.values()])
    # with a forward crank, the load pushes a carrier output counter-clockwise, to its upper stop
    stops = {}
    for name, sign in (("low", -reducer.member.sense), ("high", reducer.member.sense)):
        each = [spectra[load, sign] for load in shares]
        stops[f"{name}_cos"] = _rows([fine[kept].real for fine, _ in each])
        stops[f"{name}_sin"] = _rows([-fine[kept].imag for fine, _ in each])
        stops[f"{name}_error"] = _rows([np.abs(fine[kept] - coarse[kept]) for fine, coarse in each])
    return Ripple(tuple((kept / turns(reducer)).tolist()), shares, **stops)


def count_turns(reducer: Reducer) -> int:
    """Return the number of crank turns that `solve_ripple` solves."""
    return 2 * (1 + len(RIPPLE.loads)) * turns(reducer)


def _balances(reducer: Reducer, load: float) -> bool:
    """Return whether a turn of the crank in either direction has a balance under a share of the nominal torque."""
    try:
        for direction in (1, -1):
            _solve_turn(reducer, load, direction, 0)
    except RunError:
        return False
    return True


def solve_error(reducer: Reducer, load: float, direction: int, on_turn: Callable[[], None] = lambda: None) -> Array:
    """Compute the error of the output [rad], counter-clockwise, over its full turn.

    Parameters
    ----------
    reducer
        The reducer.
    load
        Share of the nominal torque.
    direction
        Direction of the crank, 1 or -1.
    on_turn
        Called after each turn of the crank.

    Returns
    -------
    Array
        Errors at evenly spaced crank angles from 0, `RIPPLE.poses_per_period` in each mesh period, shape (n,).
    """
    errors = []
    for turn in range(turns(reducer)):
        errors.append(_solve_turn(reducer, load, direction, turn))
        on_turn()
    return np.concatenate(errors)


def _solve_turn(reducer: Reducer, load: float, direction: int, turn: int) -> Array:
    """Compute the error over one turn of the crank, by the number of the turn."""
    design = reducer.design
    turning = reducer.but(drive={"speed": direction * abs(design.drive.speed)})
    count = reducer.mesh_periods * RIPPLE.poses_per_period
    springs = springs_of(turning, 2.0 * np.pi * (np.arange(count) / count + turn))
    return (
        reducer.member.sense * loads(turning, springs, direction * load * design.rated_torque, follow=True).output_turn
    )


def waves(values: Array) -> tuple[Waves, Waves]:
    """Return the complex amplitudes of a periodic error, from all its samples and from every second one.

    The harmonic is the real part of A exp(i order theta). Both have the same shape, and no mean.
    """

    def amplitudes(item: Array) -> Waves:
        amplitudes = 2.0 * np.fft.rfft(item) / item.size
        amplitudes[0] = 0.0
        return amplitudes

    fine, coarse = amplitudes(values), amplitudes(values[::2])
    return fine[: coarse.size - 1], coarse[:-1]


def _strongest_harmonics(each: list[Waves]) -> npt.NDArray[np.int64]:
    """Return the indices of the fewest strongest harmonics whose remainder of each error is below the limit."""
    each_share = [np.abs(item) / max(float(np.linalg.norm(item)), np.finfo(float).tiny) for item in each]
    shares: Array = np.stack(each_share).max(axis=0)
    order = np.argsort(-shares, kind="stable")
    for count in range(1, RIPPLE.max_harmonics):
        chosen = order[:count]
        rest = [np.linalg.norm(np.delete(item, chosen)) <= RIPPLE.max_remainder * np.linalg.norm(item) for item in each]
        if all(rest):
            return np.sort(chosen)
    return np.sort(order[: RIPPLE.max_harmonics])


def _rows(arrays: list[Array]) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row.tolist()) for row in arrays)
