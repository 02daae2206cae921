"""The angle between both halves of a ring that a spring of some torque turns them by, and is then fixed."""

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError, RunError
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.design import Design, Named, resolve
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.balance import loads
from cycloid_mj.statics.springs import springs_of, turn_evenly

POSES = 13
"""Crank angles over which the torque is averaged."""

IDLE = 1e-3
"""Share of the rated torque under which the drive rests: without any, the output has no place in its play."""

MOST = 600.0 * ARCMINUTE
"""Largest angle that is looked for [rad]: that of the key."""

NEAR = 1e-4
"""Share of the angle within which it is found."""


def preloaded(design: Named) -> Design:
    """Return a design with ``ring.preload_arcmin`` in place of ``ring.preload_torque_nm``; any other as it is.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file: whose halves a spring turns against each other.

    Raises
    ------
    DesignError
        No angle gives that torque.
    """
    design = resolve(design)
    torque = design.ring.preload_torque
    if not torque:
        return design
    from scipy.optimize import brentq

    def turned(angle: float) -> Design:
        return design.but(ring={"preload": angle, "preload_torque": 0.0})

    def missing(angle: float) -> float:
        return halves_torque(Reducer(turned(angle))) - torque

    high = ARCMINUTE
    try:
        while missing(high) < 0.0:
            high *= 2.0
            if high > MOST:
                raise RunError(f"{MOST / ARCMINUTE:g} arcmin give less")
        found = float(brentq(missing, 1e-6 * ARCMINUTE, high, rtol=NEAR))
    except RunError as error:
        raise DesignError(
            f"{design.name}: no angle was found at which ring.preload_torque_nm = {torque:g} is met: {error}; "
            "give ring.preload_arcmin, or less torque"
        ) from error
    return turned(found)


def halves_torque(reducer: Reducer) -> float:
    """Compute the torque [N m] that holds two halves of a ring turned, which turn by `ring.preload`; no load, at rest.

    A half that turns on by an angle closes each gap g by -dg/da: by virtual work its forces F have the torque
    -sum F dg/da about the axis; gaps are straight in that angle, so that the same tooth of both halves tells dg/da.

    Raises
    ------
    RunError
        No balance was found.
    """
    still = reducer.but(drive={"speed": 0.0}, environment={"gravity_x": 0.0, "gravity_y": 0.0})
    springs = springs_of(still, turn_evenly(still, POSES), friction=False)
    force = _of_halves(reducer, loads(still, springs, IDLE * reducer.design.rated_torque).teeth)
    distance = _of_halves(reducer, springs.contacts.distance[:, : springs.teeth])
    rate = (distance[:, :, 0] - distance[:, :, 1]) / reducer.design.ring.preload
    first, second = (-np.sum(force[:, :, half] * rate, axis=(1, 2)).mean() for half in (0, 1))
    return abs(0.5 * float(first - second))


def _of_halves(reducer: Reducer, lines: Array) -> Array:
    """Compute lines on the ring, shape (m, D 2 N), with axes for discs and halves, shape (m, D, 2, N)."""
    return lines.reshape(len(lines), reducer.design.gear.discs, 2, -1)
