"""What the collider must know of the gear's teeth and of a pin, as it stands in ``geom user`` of the model."""

from typing import NamedTuple

from numba import njit

from cycloid_mj.contact.gap import Flank
from cycloid_mj.contact.memory import read_float


class Teeth(NamedTuple):
    """What stands as ``geom user`` with the gear's teeth, in this order.

    Attributes
    ----------
    radius, eccentricity, teeth, offset
        Of the gear's profile, as in ``gap.Flank``.
    reference, constant, deflection
        What makes the stiffness follow the relative curvature, ``law.CurvatureLaw``: reference and constant of the
        compliance [1]; the deflection at working force [m], 0 to keep lines of contact apart however near they are.
    ring_radius
        Pin-circle radius of the ring [m].
    rotation, tip, tip_radius, valley, valley_radius
        Of turned flanks, as in ``gap.Flank``.
    """

    radius: float
    eccentricity: float
    teeth: float
    offset: float
    reference: float
    constant: float
    deflection: float
    ring_radius: float
    rotation: float
    tip: float
    tip_radius: float
    valley: float
    valley_radius: float


USER_DATA = len(Teeth._fields)
"""Numbers of ``geom user`` in a model of ours: of the teeth, ``Teeth``; of a pin, sine and cosine of its home angle,
clockwise from +y, and of a massless one its play [m] and the stiffness of a pin on a flat over that of its seat."""


@njit(inline="always")
def read_teeth(user: int) -> Teeth:
    """Read them at an address."""
    return Teeth(
        read_float(user),
        read_float(user + 8),
        read_float(user + 16),
        read_float(user + 24),
        read_float(user + 32),
        read_float(user + 40),
        read_float(user + 48),
        read_float(user + 56),
        read_float(user + 64),
        read_float(user + 72),
        read_float(user + 80),
        read_float(user + 88),
        read_float(user + 96),
    )


@njit(inline="always")
def flank_of(teeth: Teeth) -> Flank:
    """Give the flanks of teeth."""
    return Flank(
        teeth.radius,
        teeth.eccentricity,
        teeth.teeth,
        teeth.offset,
        teeth.rotation,
        teeth.tip,
        teeth.tip_radius,
        teeth.valley,
        teeth.valley_radius,
    )
