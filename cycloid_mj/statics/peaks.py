"""The largest force and pressure on each kind of contact, and the torque at which one first yields."""

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.design.materials import YIELD_PRESSURE
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.balance import Loads, loads
from cycloid_mj.statics.springs import Springs

GUESSES, TOLERANCE = 12, 1e-3


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
    kind: str,
    pressure: float,
    torque: float,
    contact_loads: Loads | None = None,
    follow: bool = False,
) -> float:
    """Compute the torque on the output at which a kind of contact has a peak pressure [Pa], to a thousandth [N m].

    Better guesses follow the first, as if the pressure rose with the square root of the torque.

    Parameters
    ----------
    reducer
        Whose contacts are pressed.
    springs
        Of the reducer at crank angles, as of `springs_of`.
    kind
        Of contact: ``pin_gear``, ``tooth``, ``output`` or ``cam``.
    pressure
        The peak that is asked for [Pa].
    torque
        The first guess [N m], not 0.
    contact_loads
        What `torque` loads, where that is known.
    follow
        As of `loads`.

    Raises
    ------
    RunError
        No balance was found at a guess.
    """
    for _ in range(GUESSES):
        contact_loads = contact_loads or loads(reducer, springs, torque, follow)
        factor = (pressure / peak_pressure(reducer, springs, contact_loads, kind)) ** 2
        torque, contact_loads = factor * torque, None
        if abs(factor - 1.0) < TOLERANCE:
            break
    return torque


def yield_torque(reducer: Reducer, springs: Springs, kind: str, torque: float) -> float:
    """Compute the torque on the output at which a kind of contact first yields, as `torque_at_pressure` [N m].

    Parameters
    ----------
    reducer
        Whose contacts are pressed.
    springs
        Of the reducer at crank angles, as of `springs_of`.
    kind
        Of contact: ``pin_gear``, ``tooth``, ``output`` or ``cam``.
    torque
        The first guess [N m], not 0.
    """
    return torque_at_pressure(reducer, springs, kind, YIELD_PRESSURE * reducer.contacts[kind].strength, torque)


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
