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
from cycloid_mj.robot.full_model import full_model
from cycloid_mj.robot.ripple import Ripple

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


def solve_ripple(reducer: Reducer, on_part: Callable[[], None]) -> Ripple:
    """Compute the strongest harmonics of the transmission error at the loads `RIPPLE.loads` and nearly without load.

    The harmonics are computed in both directions of the crank; `on_part` is called after each of the `count_parts`
    parts of a turn that are solved.
    """
    lowest_load = next((load for load in RIPPLE.unloaded if _has_equilibrium(reducer, load)), RIPPLE.unloaded[-1])
    shares = (lowest_load, *RIPPLE.loads)
    spectra = {
        (load, direction): compute_amplitudes(solve_error(reducer, load, direction, on_part))
        for direction in (1, -1)
        for load in shares
    }
    indices = _select_harmonics([fine for fine, _ in spectra.values()])
    # with a forward crank, the load pushes a carrier output counter-clockwise, to its upper stop
    coefficients = {}
    for name, direction in (("low", -reducer.member.sense), ("high", reducer.member.sense)):
        spectra_at_stop = [spectra[load, direction] for load in shares]
        coefficients[f"{name}_cos"] = _rows([fine[indices].real for fine, _ in spectra_at_stop])
        coefficients[f"{name}_sin"] = _rows([-fine[indices].imag for fine, _ in spectra_at_stop])
        coefficients[f"{name}_error"] = _rows(
            [np.abs(fine[indices] - coarse[indices]) for fine, coarse in spectra_at_stop]
        )
    return Ripple(tuple((indices / reducer.design.reduction).tolist()), shares, **coefficients)


def count_parts(reducer: Reducer) -> int:
    """Return the number of parts of a turn of the output that `solve_ripple` solves."""
    return 2 * (1 + len(RIPPLE.loads)) * full_model(reducer).parts


def _has_equilibrium(reducer: Reducer, load: float) -> bool:
    """Return whether a static equilibrium exists over the first part of a turn, in both directions of the crank.

    `load` is a share of the nominal torque.
    """
    model, torque = full_model(reducer), load * reducer.design.rated_torque
    try:
        for direction in (1, -1):
            model.rotation_over_part(torque, direction, 0, RIPPLE.poses_per_period)
    except RunError:
        return False
    return True


def solve_error(reducer: Reducer, load: float, direction: int, on_part: Callable[[], None] = lambda: None) -> Array:
    """Compute the transmission error [rad], counter-clockwise, over a full turn of the output in static equilibrium.

    Parameters
    ----------
    load
        Output torque as a share of the nominal torque.
    direction
        Direction of the crank, 1 or -1.
    on_part
        Called after each of the `FullModel.parts` parts of the turn.

    Returns
    -------
    Array
        Errors (n,) at n evenly spaced crank angles from 0, `RIPPLE.poses_per_period` of them in each mesh period.
    """
    model, torque = full_model(reducer), load * reducer.design.rated_torque
    errors = []
    for part in range(model.parts):
        errors.append(model.rotation_over_part(torque, direction, part, RIPPLE.poses_per_period))
        on_part()
    return np.concatenate(errors)


def compute_amplitudes(values: Array) -> tuple[Waves, Waves]:
    """Compute the complex amplitudes of a periodic error by FFT, from all samples and from every second sample.

    The n-th amplitude A_n belongs to the harmonic Re(A_n exp(2 pi i n s)), where s is the position in the period, 0 to
    1. `values` are samples over one period. Both results have the same length and the unit of `values`. The amplitude
    of index 0 is set to 0, so the mean is not included.
    """

    def amplitudes(samples: Array) -> Waves:
        amplitudes = 2.0 * np.fft.rfft(samples) / samples.size
        amplitudes[0] = 0.0
        return amplitudes

    fine_amplitudes, coarse_amplitudes = amplitudes(values), amplitudes(values[::2])
    return fine_amplitudes[: coarse_amplitudes.size - 1], coarse_amplitudes[:-1]


def _select_harmonics(spectra: list[Waves]) -> npt.NDArray[np.int64]:
    """Return the indices of the fewest harmonics that represent every spectrum well enough, in increasing order.

    The rms value of the harmonics left out of a spectrum must not exceed `RippleSettings.max_remainder` of that of the
    spectrum. At most `max_harmonics` are selected, the strongest ones. The spectra are complex amplitudes of h
    harmonics (h,).
    """
    relative_amplitudes = [
        np.abs(spectrum) / max(float(np.linalg.norm(spectrum)), np.finfo(float).tiny) for spectrum in spectra
    ]
    largest_amplitudes: Array = np.stack(relative_amplitudes).max(axis=0)
    strongest_first = np.argsort(-largest_amplitudes, kind="stable")
    for count in range(1, RIPPLE.max_harmonics):
        strongest = strongest_first[:count]
        is_accurate = [
            np.linalg.norm(np.delete(spectrum, strongest)) <= RIPPLE.max_remainder * np.linalg.norm(spectrum)
            for spectrum in spectra
        ]
        if all(is_accurate):
            return np.sort(strongest)
    return np.sort(strongest_first[: RIPPLE.max_harmonics])


def _rows(arrays: list[Array]) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row.tolist()) for row in arrays)
