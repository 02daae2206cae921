"""MuJoCo's convex friction lifts what slides; here the lift is taken off before the constraints are solved.

In the elliptic cone a contact that slides has the normal force D/(1 + m^2) (n - a + mu |t - b|), D = 1/R and
m = mu/sqrt(impratio), where n and t are the reference accelerations of its normal and its tangential rows, a and b the
accelerations (MuJoCo, "Computation: elliptic cones"). Without friction it would be D (n - a). While friction is below
Coulomb's limit, mu |t| <= m^2 n, it is; beyond, n is lowered by mu |t| - m^2 n, and the contact bears what it would
bear. What is left is the part of both accelerations: that of the added mass, a by m^2 less of it, b by mu of it.

The normal row is lowered in ``efc_aref``, where contacts that only lift could have brought about stay in the solver:
a gap widened in the collider would drop them.
"""

import math
from functools import cache
from typing import Any, NamedTuple

from numba import types

from cycloid_mj.base import compiling
from cycloid_mj.base.compiling import cacheable, cfunc, digest
from cycloid_mj.dynamics.contact import memory, teeth
from cycloid_mj.dynamics.contact.layout import discover, discover_steps
from cycloid_mj.dynamics.contact.memory import read_address, read_float, read_int, write_float
from cycloid_mj.dynamics.contact.teeth import USER_DATA

_RUBBING = 3
"""Dimensions of a contact that rubs."""


class Places(NamedTuple):
    """What stands where: sizes in ``mjModel``, contacts and references in ``mjData``, fields in an ``mjContact``."""

    nuserdata: int
    nuser_geom: int
    contact: int
    contacts: int
    reference: int
    stride: int
    dim: int
    row: int
    friction: int
    regularised: int


@cache
def places() -> Places:
    """Return the places in the MuJoCo release that is installed."""
    model, step = discover(), discover_steps()
    return Places(
        nuserdata=step.nuserdata,
        nuser_geom=model.nuser_geom,
        contact=step.contact,
        contacts=step.ncon,
        reference=step.efc_aref,
        stride=step.stride,
        dim=step.dim,
        row=step.efc_address,
        friction=step.friction,
        regularised=step.mu,
    )


@cache
def between_speeds_and_forces(where: Places) -> Any:
    """Compile the answer to ``mjcb_control``, or load it: `take_off`."""
    at = where, digest(memory, teeth)

    @cfunc(types.void(types.intp, types.intp), cache=cacheable())
    def answer(model: int, data: int) -> None:
        take_off(at[0], model, data)

    return answer


@compiling.njit(inner=True)
def take_off(at: Any, model: int, data: int) -> None:
    """Take the lift off all contacts of a model with exact contact; of any other, nothing.

    `at` is a `Places`; `model` and `data` are addresses. It stands between speeds and forces of a step.
    """
    if read_int(model + at.nuserdata) != 1 or read_int(model + at.nuser_geom) < USER_DATA:
        return
    first, references = read_address(data + at.contact), read_address(data + at.reference)
    for k in range(read_int(data + at.contacts)):
        contact = first + at.stride * k
        row = read_int(contact + at.row)
        if row < 0 or read_int(contact + at.dim) != _RUBBING:
            continue
        reference = references + 8 * row
        pressing, ratio = read_float(reference), read_float(contact + at.regularised)
        sliding = math.hypot(read_float(reference + 8), read_float(reference + 16))
        lift = read_float(contact + at.friction) * sliding - ratio * ratio * max(pressing, 0.0)
        if lift > 0.0:
            write_float(reference, pressing - lift)
