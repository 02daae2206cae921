"""Preload angle between the halves of a ring from the torque of the spring that rotates them before they are fixed."""

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError, RunError
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.design import Design, Named, resolve
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.balance import loads
from cycloid_mj.statics.springs import at_rest, springs_of, turn_evenly

MAX_ANGLE = 600.0 * ARCMINUTE
"""Largest preload angle [rad]: the bound of ring.preload_arcmin."""


def preloaded(design: Named) -> Design:
    """Return the design with the preload of its ring as an angle, ``ring.preload_arcmin``, instead of as a torque.

    A ring in two halves is preloaded by a rotation of the halves against each other. A design without
    ``ring.preload_torque_nm`` is returned unchanged. Brent's method determines the angle at which `halves_torque`
    equals this torque.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file.

    Raises
    ------
    DesignError
        No angle up to `MAX_ANGLE` has that torque, or the parts have no equilibrium.
    """
    design = resolve(design)
    torque = design.ring.preload_torque
    if not torque:
        return design
    from scipy.optimize import brentq

    def rotate_halves(angle: float) -> Design:
        return design.but(ring={"preload": angle, "preload_torque": 0.0})

    def torque_residual(angle: float) -> float:
        return halves_torque(Reducer(rotate_halves(angle))) - torque

    angle_bound = ARCMINUTE
    try:
        while (residual := torque_residual(angle_bound)) < 0.0:
            if angle_bound == MAX_ANGLE:
                raise DesignError(
                    f"{design.name}: ring.preload_torque_nm = {torque:g} is too large: the largest preload angle, "
                    f"{angle_bound / ARCMINUTE:g} arcmin, produces only {torque + residual:.4g} N m. Reduce the torque "
                    "to less than this"
                )
            angle_bound = min(2.0 * angle_bound, MAX_ANGLE)
        angle = float(brentq(torque_residual, 1e-6 * ARCMINUTE, angle_bound, rtol=1e-4))
    except RunError as error:
        raise DesignError(
            f"{design.name}: ring.preload_torque_nm = {torque:g} cannot be converted to a preload angle, because the "
            f"ring has no equilibrium at one of the angles tried ({error}). Reduce this torque, or set "
            f"ring.preload_arcmin from 0 to {MAX_ANGLE / ARCMINUTE:g} instead"
        ) from error
    return rotate_halves(angle)


def halves_torque(reducer: Reducer) -> float:
    """Compute the torque [N m] between the two halves of a ring that are rotated against each other by `ring.preload`.

    `ring.preload`, the angle, must not be 0. The reducer is at rest without load. The result is the magnitude of the
    mean over 13 crank angles.

    Raises
    ------
    RunError
        There is no equilibrium.

    Notes
    -----
    By virtual work, contact forces F have the torque -sum F dg/da about the axis, with the gaps g and the angle a of a
    half. Gaps are linear in a, so dg/da follows from the gaps of the same tooth in both halves.
    """
    static_reducer = at_rest(reducer)
    springs = springs_of(static_reducer, turn_evenly(static_reducer, 13), friction=False)
    # without any torque, the position of the output in its backlash is undefined
    force = _split_halves(reducer, loads(static_reducer, springs, 1e-3 * reducer.design.rated_torque).teeth)
    distance = _split_halves(reducer, springs.contacts.distance[:, : springs.teeth])
    rate = (distance[:, :, 0] - distance[:, :, 1]) / reducer.design.ring.preload
    first_torque, second_torque = (-np.sum(force[:, :, half_index] * rate, axis=(1, 2)).mean() for half_index in (0, 1))
    return abs(0.5 * float(first_torque - second_torque))


def _split_halves(reducer: Reducer, lines: Array) -> Array:
    """Return values of contact lines, shape (m, D 2 N), with axes for discs and halves, shape (m, D, 2, N)."""
    return lines.reshape(len(lines), reducer.design.gear.discs, 2, -1)
