"""Largest force and pressure of each kind of contact, and the torque at first yield."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import RunError
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.balance import Loads, loads
from cycloid_mj.statics.springs import Springs


@dataclass(frozen=True)
class PressureTorqueSettings:
    """Settings of the secant iteration in log-log coordinates for the torque at a pressure (`torque_at_pressure`)."""

    max_iterations: int = 12
    rtol: float = 1e-3
    """Relative change of the torque at which the first iteration suffices."""
    secant_rtol: float = 0.01
    """The same for later iterations, whose error is a tenth of the change."""
    min_power: float = 0.2
    """Smallest exponent of the pressure over the torque, while clearances close and more contacts carry."""
    max_power: float = 1.0
    """Largest exponent of the pressure over the torque; it is 0.5 if the same contacts carry."""


PRESSURE_TORQUE = PressureTorqueSettings()


def peak_force(contact_loads: Loads, kind: str) -> float:
    """Compute the largest force on a contact of one kind, such as ring pins on the disc [N].

    Parameters
    ----------
    contact_loads
        Contact forces from `loads`.
    kind
        Kind of contact: ``pin_gear``, ``tooth``, ``output`` or ``cam``.
    """
    return float(forces(contact_loads, kind).max())


def peak_pressure(reducer: Reducer, springs: Springs, contact_loads: Loads, kind: str) -> float:
    """Compute the largest Hertz pressure on a contact of one kind, such as ring pins on the disc [Pa].

    Parameters
    ----------
    reducer
        The reducer.
    springs
        Its contact springs from `springs_of`.
    contact_loads
        Contact forces from `loads`.
    kind
        Kind of contact: ``pin_gear``, ``tooth``, ``output`` or ``cam``.
    """
    return float(reducer.contacts[kind].pressure(*line_loads(reducer, springs, contact_loads, kind)).max())


def line_loads(reducer: Reducer, springs: Springs, contact_loads: Loads, kind: str) -> tuple[Array, Array]:
    """Return forces [N] and relative curvatures [1/m] of the n line contacts of a kind at m crank angles, shape (m, n).

    `springs` are the contact springs at m crank angles, `contact_loads` the forces on them, `kind` is ``pin_gear``,
    ``tooth``, ``output`` or ``cam``. A rolling cam has the force of its most loaded roller.
    """
    contact = reducer.contacts[kind]
    curvature = springs.curvature if kind == reducer.design.tooth_pair else contact.relative_curvature
    force = forces(contact_loads, kind) * contact.line_share
    return force, np.broadcast_to(curvature, force.shape)


def torque_at_pressure(
    reducer: Reducer,
    springs: Springs,
    pressures: Mapping[str, float],
    torque: float,
    contact_loads: Loads | None = None,
    warm_start: bool = False,
) -> tuple[float, str]:
    """Find the output torque at which the first contact reaches its allowed pressure, to a relative accuracy of 0.001.

    The first step assumes that the pressure rises with the square root of the torque; the others are secant steps of
    the logarithms, with the exponent limited to `PRESSURE_TORQUE`. A step to a torque without equilibrium is halved
    (logarithmically): steps are long where few contacts carry, and the teeth skip at such a torque.

    Parameters
    ----------
    reducer
        The reducer.
    springs
        Its contact springs from `springs_of`.
    pressures
        Allowed peak pressures [Pa] by kind of contact: ``pin_gear``, ``tooth``, ``output`` or ``cam``.
    torque
        Initial torque [N m], not 0.
    contact_loads
        Contact forces under `torque`, if known.
    warm_start
        Whether to start each solution from the previous equilibria.

    Returns
    -------
    tuple of float and str
        The torque [N m] with the sign of `torque`, and the kind of contact that reaches its pressure.

    Raises
    ------
    RunError
        There is no equilibrium at the initial torque, or the pressure exceeds that of the largest torque with an
        equilibrium.
    """
    settings = PRESSURE_TORQUE
    previous_torque, previous_ratio = math.nan, math.nan
    failure: RunError | None = None
    for iteration in range(settings.max_iterations):
        try:
            contact_loads = contact_loads or loads(reducer, springs, torque, warm_start)
        except RunError as error:
            if math.isnan(previous_torque):
                raise
            torque, failure = math.copysign(math.sqrt(torque * previous_torque), torque), error
            continue
        failure = None
        ratios = {
            kind: peak_pressure(reducer, springs, contact_loads, kind) / pressure
            for kind, pressure in pressures.items()
        }
        kind = max(ratios, key=lambda candidate: ratios[candidate])
        exponent = (
            0.5 if iteration == 0 else math.log(ratios[kind] / previous_ratio) / math.log(torque / previous_torque)
        )
        previous_torque, previous_ratio = torque, ratios[kind]
        torque, contact_loads = (
            torque * previous_ratio ** (-1.0 / min(max(exponent, settings.min_power), settings.max_power)),
            None,
        )
        if abs(torque / previous_torque - 1.0) < (settings.secant_rtol if iteration else settings.rtol):
            break
    if failure is not None:
        raise RunError(f"no contact reaches its pressure limit up to {abs(previous_torque):.4g} N m: {failure}")
    return torque, kind


def is_hertzian(reducer: Reducer, springs: Springs, contact_loads: Loads, kind: str) -> bool:
    """Return whether Hertz theory applies at the largest pressure among all contacts of one kind.

    The contact with this pressure must be loaded, and its strip must be narrow compared with the thinner body.
    `springs` are the contact springs at m crank angles, `contact_loads` the forces on them, `kind` is ``pin_gear``,
    ``tooth``, ``output`` or ``cam``.
    """
    contact = reducer.contacts[kind]
    force, curvature = line_loads(reducer, springs, contact_loads, kind)
    highest_index = np.argmax(contact.pressure(force, curvature))
    return bool(force.flat[highest_index] > 0.0 and contact.hertz_holds(force, curvature).flat[highest_index])


def forces(contact_loads: Loads, kind: str) -> Array:
    """Return the forces of all contacts of a kind [N], shape (m, contacts); for "cam" the magnitudes, shape (m, D)."""
    forces_by_kind = {"cam": np.linalg.norm(contact_loads.cam, axis=-1), "output": contact_loads.output}
    return forces_by_kind.get(kind, contact_loads.teeth)
