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
    """Return a design with ``ring.preload_arcmin`` in place of ``ring.preload_torque_nm``; others are unchanged.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file.

    Returns
    -------
    Design
        The design with a given preload angle.

    Raises
    ------
    DesignError
        No angle has that torque.
    """
    design = resolve(design)
    torque = design.ring.preload_torque
    if not torque:
        return design
    from scipy.optimize import brentq

    def rotate_halves(angle: float) -> Design:
        return design.but(ring={"preload": angle, "preload_torque": 0.0})

    def missing(angle: float) -> float:
        return halves_torque(Reducer(rotate_halves(angle))) - torque

    high = ARCMINUTE
    try:
        while missing(high) < 0.0:
            high *= 2.0
            if high > MAX_ANGLE:
                raise RunError(
                    f"the torque at {MAX_ANGLE / ARCMINUTE:g} arcmin, the largest angle allowed, is less than that"
                )
        angle = float(brentq(missing, 1e-6 * ARCMINUTE, high, rtol=1e-4))
    except RunError as error:
        raise DesignError(
            f"{design.name}: no preload angle produces ring.preload_torque_nm = {torque:g}: {error}. Reduce this "
            "torque, or set ring.preload_arcmin instead"
        ) from error
    return rotate_halves(angle)


def halves_torque(reducer: Reducer) -> float:
    """Compute the torque between two halves of a ring rotated by `ring.preload` [N m], without load and at rest.

    By virtual work, contact forces F have the torque -sum F dg/da about the axis, with the gaps g and the angle a of a
    half. Gaps are linear in a, so dg/da follows from the gaps of the same tooth in both halves.

    Raises
    ------
    RunError
        There is no equilibrium.
    """
    still = at_rest(reducer)
    springs = springs_of(still, turn_evenly(still, 13), friction=False)
    # without any torque, the position of the output in its backlash is undefined
    force = _of_halves(reducer, loads(still, springs, 1e-3 * reducer.design.rated_torque).teeth)
    distance = _of_halves(reducer, springs.contacts.distance[:, : springs.teeth])
    rate = (distance[:, :, 0] - distance[:, :, 1]) / reducer.design.ring.preload
    first, second = (-np.sum(force[:, :, half] * rate, axis=(1, 2)).mean() for half in (0, 1))
    return abs(0.5 * float(first - second))


def _of_halves(reducer: Reducer, lines: Array) -> Array:
    """Return values of contact lines, shape (m, D 2 N), with axes for discs and halves, shape (m, D, 2, N)."""
    return lines.reshape(len(lines), reducer.design.gear.discs, 2, -1)
