"""The transmission error of the full model over a whole turn of the output, in its harmonics.

After one everything is where it was: there every order is a whole number of cycles, and the Fourier sum has no leakage.
"""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import RunError
from cycloid_mj.reducer import Reducer
from cycloid_mj.robot.ripple import Ripple
from cycloid_mj.statics.balance import loads
from cycloid_mj.statics.springs import springs_of

Waves = npt.NDArray[np.complex128]

LOADS = (0.3, 1.0)
"""Shares of the rated torque, both ways, beside next to no load."""

UNLOADED = (0.01, 0.03, 0.1)
"""Shares that stand for no load, as in `measure te`: the first under which friction does not jam the parts."""

PER_MESH_PERIOD = 8
"""Crank angles in a mesh period; half as many are the check."""

LEFT = 0.02
"""What is left out of an error, as a share of its rms value: the harmonics that are kept explain the rest."""

MOST = 32
"""Harmonics that are kept at most."""


def turns(reducer: Reducer) -> int:
    """Count the crank turns after which the error repeats."""
    return reducer.design.reduction


def ripple(reducer: Reducer, on_step: Callable[[], None]) -> Ripple:
    """Solve the error without a load and at `LOADS`, both ways, keep what matters of it; `on_step` counts the turns."""
    lightest = next((load for load in UNLOADED if _balances(reducer, load)), UNLOADED[-1])
    shares = (lightest, *LOADS)
    spectra = {(load, way): waves(error(reducer, load, way, on_step)) for way in (1, -1) for load in shares}
    kept = _kept([fine for fine, _ in spectra.values()])
    # forward, the load pushes the output of a carrier counter-clockwise, to its upper stop
    stops = {}
    for name, way in (("low", -reducer.member.sense), ("high", reducer.member.sense)):
        each = [spectra[load, way] for load in shares]
        stops[f"{name}_cos"] = _rows([fine[kept].real for fine, _ in each])
        stops[f"{name}_sin"] = _rows([-fine[kept].imag for fine, _ in each])
        stops[f"{name}_error"] = _rows([np.abs(fine[kept] - coarse[kept]) for fine, coarse in each])
    return Ripple(tuple((kept / turns(reducer)).tolist()), shares, **stops)


def works(reducer: Reducer) -> int:
    """Count the turns of the crank that `ripple` solves."""
    return 2 * (1 + len(LOADS)) * turns(reducer)


def _balances(reducer: Reducer, load: float) -> bool:
    """Tell whether a turn of the crank each way has a balance under a share of the rated torque."""
    try:
        for way in (1, -1):
            _turn(reducer, load, way, 0)
    except RunError:
        return False
    return True


def error(reducer: Reducer, load: float, way: int, on_step: Callable[[], None] = lambda: None) -> Array:
    """Compute the error of the output [rad] under a share of the rated torque, all over its turn; counter-clockwise.

    `way` is that of the crank; the angles rise evenly from 0, `PER_MESH_PERIOD` in each mesh period.
    """
    errors = []
    for turn in range(turns(reducer)):
        errors.append(_turn(reducer, load, way, turn))
        on_step()
    return np.concatenate(errors)


def _turn(reducer: Reducer, load: float, way: int, turn: int) -> Array:
    design = reducer.design
    turning = reducer.but(drive={"speed": way * abs(design.drive.speed)})
    count = reducer.mesh_periods * PER_MESH_PERIOD
    springs = springs_of(turning, 2.0 * np.pi * (np.arange(count) / count + turn))
    return reducer.member.sense * loads(turning, springs, way * load * design.rated_torque, follow=True).output_turn


def waves(values: Array) -> tuple[Waves, Waves]:
    """Return the complex amplitudes of a periodic error by whole cycles of all of it, and by every second sample.

    The real part of A exp(i order theta) is the harmonic; both have the same shape, the mean left out.
    """

    def amplitudes(one: Array) -> Waves:
        amplitudes = 2.0 * np.fft.rfft(one) / one.size
        amplitudes[0] = 0.0
        return amplitudes

    fine, coarse = amplitudes(values), amplitudes(values[::2])
    return fine[: coarse.size - 1], coarse[:-1]


def _kept(each: list[Waves]) -> npt.NDArray[np.int64]:
    """Compute the places of the fewest strongest harmonics that leave `LEFT` of every error, `MOST` at the most."""
    each_share = [np.abs(one) / max(float(np.linalg.norm(one)), np.finfo(float).tiny) for one in each]
    shares: Array = np.stack(each_share).max(axis=0)
    order = np.argsort(-shares, kind="stable")
    for count in range(1, MOST):
        chosen = order[:count]
        rest = [np.linalg.norm(np.delete(one, chosen)) <= LEFT * np.linalg.norm(one) for one in each]
        if all(rest):
            return np.sort(chosen)
    return np.sort(order[:MOST])


def _rows(arrays: list[Array]) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row.tolist()) for row in arrays)
