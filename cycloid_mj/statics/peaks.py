"""The largest force and pressure on each kind of contact, and the torque at which one first yields."""

import math
from collections.abc import Mapping

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.balance import Loads, loads
from cycloid_mj.statics.springs import Springs

GUESSES, TOLERANCE = 12, 1e-3

LEAST_POWER, MOST_POWER = 0.2, 1.0
"""Of the torque with which a pressure may rise from one guess to the next: a half where the same contacts share it,
less where play closes and more of them do."""

NEAR = 0.01
"""By how much of itself a last guess may move that is made by how the pressure rose: it misses a tenth of that."""


def peak_force(contact_loads: Loads, kind: str) -> float:
    """Compute the largest force on a contact of a kind [N].

    Parameters
    ----------
    contact_loads
        As of `loads`.
    kind
        Of contact: ``pin_gear``, ``tooth``, ``output`` or ``cam``.
    """
    return float(forces(contact_loads, kind).max())


def peak_pressure(reducer: Reducer, springs: Springs, contact_loads: Loads, kind: str) -> float:
    """Compute the largest Hertz pressure on a kind of contact [Pa].

    Parameters
    ----------
    reducer
        Whose contacts are pressed.
    springs
        Of the reducer at crank angles, as of `springs_of`.
    contact_loads
        What they carry, as of `loads`.
    kind
        Of contact: ``pin_gear``, ``tooth``, ``output`` or ``cam``.
    """
    contact = reducer.contacts[kind]
    curvature = springs.curvature if kind == reducer.design.tooth_pair else contact.curvature
    return float(contact.pressure(forces(contact_loads, kind) * contact.line_share, curvature).max())


def torque_at_pressure(
    reducer: Reducer,
    springs: Springs,
    pressures: Mapping[str, float],
    torque: float,
    contact_loads: Loads | None = None,
    follow: bool = False,
) -> tuple[float, str]:
    """Compute the torque on the output at which contacts first have a peak pressure, to a thousandth [N m].

    The first guess is bettered as if the pressure rose with the square root of the torque, the others by how it rose
    between the last two.

    Parameters
    ----------
    reducer
        Whose contacts are pressed.
    springs
        Of the reducer at crank angles, as of `springs_of`.
    pressures
        Kind of contact -> the peak that is asked for [Pa]; kinds: ``pin_gear``, ``tooth``, ``output`` or ``cam``.
    torque
        The first guess [N m], not 0.
    contact_loads
        What `torque` loads, where that is known.
    follow
        As of `loads`.

    Returns
    -------
        The torque [N m], and the kind of contact that has its pressure there.

    Raises
    ------
    RunError
        No balance was found at a guess.
    """
    before, share = math.nan, math.nan
    for number in range(GUESSES):
        contact_loads = contact_loads or loads(reducer, springs, torque, follow)
        shares = {kind: peak_pressure(reducer, springs, contact_loads, kind) / most for kind, most in pressures.items()}
        kind = max(shares, key=lambda one: shares[one])
        power = 0.5 if number == 0 else math.log(shares[kind] / share) / math.log(torque / before)
        before, share = torque, shares[kind]
        torque, contact_loads = torque * share ** (-1.0 / min(max(power, LEAST_POWER), MOST_POWER)), None
        if abs(torque / before - 1.0) < (NEAR if number else TOLERANCE):
            break
    return torque, kind


def is_narrow(reducer: Reducer, springs: Springs, contact_loads: Loads, kind: str) -> bool:
    """Tell whether the most pressed contact of a kind is a narrow strip, for which Hertz holds, and pressed at all."""
    contact = reducer.contacts[kind]
    curvature = springs.curvature if kind == reducer.design.tooth_pair else np.array(contact.curvature)
    force = forces(contact_loads, kind) * contact.line_share
    worst = np.argmax(contact.pressure(force, curvature))
    return bool(force.flat[worst] > 0.0 and contact.hertz_holds(force, curvature).flat[worst])


def forces(contact_loads: Loads, kind: str) -> Array:
    """Compute the forces on the contacts of a kind [N], shape (m, contacts): of cams one a disc."""
    other = {"cam": np.linalg.norm(contact_loads.cam, axis=-1), "output": contact_loads.output}
    return other.get(kind, contact_loads.teeth)
