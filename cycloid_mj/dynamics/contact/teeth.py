"""Teeth and pins in the format of the collider, the ``geom user`` data of a model."""

from typing import NamedTuple

from numba import njit

from cycloid_mj.base.array import Array
from cycloid_mj.dynamics.contact.gap import Flank, Trochoid
from cycloid_mj.dynamics.contact.memory import array_at, read_float


class Teeth(NamedTuple):
    """Teeth of a disc, as stored by `user_data`.

    Attributes
    ----------
    flank
        Its flanks.
    reference, constant, deflection
        Parameters of the stiffness as a function of the relative curvature, ``CurvatureLaw``: reference and constant of
        the compliance [1]; the deflection at working force [m], 0 to keep all lines of contact separate.
    ring
        The trochoid of the ring: of its pins' circle, which that of a modified gear is not.
    """

    flank: Flank
    reference: float
    constant: float
    deflection: float
    ring: Trochoid


USER_DATA = 13
"""Numbers of ``geom user`` in a model: of teeth, `user_data`, followed by waves; of a pin, the fields of ``RingPin``
after the radius; of an open socket, cosine and sine of half the angle on which it supports its pin, from the +y of its
geom."""

DEFLECTION = 6
"""Index of the deflection in `user_data`."""

PLAY = 2
"""Index of the clearance in the user data of a pin."""


def user_data(teeth: Teeth) -> tuple[float, ...]:
    """Return teeth as ``geom user``, shape (``USER_DATA`` + 2 orders of waves,)."""
    curve, offset, *ends, waves = teeth.flank
    law = (teeth.reference, teeth.constant, teeth.deflection)
    return (*curve, offset, *law, teeth.ring.radius, *ends, *waves.ravel().tolist())


def teeth_of(numbers: Array) -> Teeth:
    """Return the teeth stored by `user_data`."""
    radius, eccentricity, ring_teeth, offset, reference, constant, deflection, ring_radius = numbers[:8].tolist()
    rotation, tip, tip_radius, valley, valley_radius = numbers[8:USER_DATA].tolist()
    curve, waves = Trochoid(radius, eccentricity, ring_teeth), numbers[USER_DATA:].reshape(-1, 2)
    flank = Flank(curve, offset, rotation, tip, tip_radius, valley, valley_radius, waves)
    return Teeth(flank, reference, constant, deflection, Trochoid(ring_radius, eccentricity, ring_teeth))


@njit(inline="always")
def _number(user: int, index: int) -> float:
    return read_float(user + 8 * index)


@njit(inline="always")
def read_teeth(address: int, numbers: int) -> Teeth:
    """Read the tooth geometry of a disc from the user data of its geom at an address; `numbers` is their count."""
    eccentricity, ring_teeth = _number(address, 1), _number(address, 2)
    flank = Flank(
        Trochoid(_number(address, 0), eccentricity, ring_teeth),
        _number(address, 3),
        _number(address, 8),
        _number(address, 9),
        _number(address, 10),
        _number(address, 11),
        _number(address, 12),
        array_at(address + 8 * USER_DATA, (numbers - USER_DATA) // 2, 2),
    )
    ring = Trochoid(_number(address, 7), eccentricity, ring_teeth)
    return Teeth(flank, _number(address, 4), _number(address, 5), _number(address, 6), ring)
