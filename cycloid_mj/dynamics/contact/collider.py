"""Exact conjugate contact at MuJoCo's extension point for collision functions.

MuJoCo looks up ``mjCOLLISIONFUNC[type][type]`` for each pair of geoms. All mating parts are cylinders in the model, so
one entry is replaced, [cylinder][cylinder]. A geom of ours carries its role as its ``priority``, which MuJoCo ignores
for explicit pairs; every other pair is passed to the original function. The collider has no state: its data are in the
``mjModel`` and ``mjData`` of the call. The callback of `reference_correction` is installed with it.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

import llvmlite.binding
from numba import types

from cycloid_mj.base.compiling import cacheable, cfunc
from cycloid_mj.base.errors import ContactError
from cycloid_mj.dynamics.contact import selftest
from cycloid_mj.dynamics.contact.layout import Layout, find_layout, find_step_layout
from cycloid_mj.dynamics.contact.library import CYLINDER, TYPES, callback, collision_table, set_callback
from cycloid_mj.dynamics.contact.mating import (
    write_bearing_contacts,
    write_lobe_contacts,
    write_pin_contact,
    write_planet_contacts,
    write_round_contacts,
)
from cycloid_mj.dynamics.contact.memory import read_address, read_int
from cycloid_mj.dynamics.contact.reference_correction import compile_control_callback
from cycloid_mj.dynamics.contact.shared import Shared
from cycloid_mj.reducer.bodies import Role

_SIGNATURE = types.int32(types.intp, types.intp, types.intp, types.int32, types.int32, types.float64)
_ENTRY = CYLINDER * TYPES + CYLINDER
_ORIGINAL = "cycloid_mj_original_cylinder_collider"
_GENERAL = "cycloid_mj_general_collider"
_original = types.ExternalFunction(_ORIGINAL, _SIGNATURE)
_general = types.ExternalFunction(_GENERAL, _SIGNATURE)


_PIN, _TEETH, _INNER, _OUTER, _LOBE, _SUN, _PLANET, _ECCENTRIC = (int(role) for role in Role)


def _compile_general_collider(layout: Layout) -> Any:
    """Compile or load MuJoCo's collision function for all exact contacts except those of teeth and lobes.

    Its pairs are the teeth of a disc and a ring pin, a cylinder or ring pin in a bore or socket, an eccentric in its
    bore, and the sun and a planet. The result is a numba ``cfunc``, which passes all others to MuJoCo's own collider.
    `layout` has the offsets of the arrays in MuJoCo's memory.
    """

    @cfunc(_SIGNATURE, cache=cacheable())
    def collide(model: int, data: int, contacts: int, geom1: int, geom2: int, margin: float) -> int:
        """Write the contacts of two cylinder geoms at the address `contacts`, and return their number.

        The signature is that of MuJoCo's ``mjfCollision``. `model` and `data` are the addresses of ``mjModel`` and
        ``mjData``, `contacts` that of an array of ``mjPreContact``, which has room for all contacts; `geom1` and
        `geom2` are the indices of the geoms. Only contacts with gaps below `margin` [m] are written.
        """
        priority = read_address(model + layout.geom_priority)
        role1, role2 = read_int(priority + 4 * geom1), read_int(priority + 4 * geom2)
        if role1 == _TEETH and role2 == _PIN:
            return write_pin_contact(layout, model, data, contacts, geom1, geom2, 1.0, margin)
        if role1 == _PIN and role2 == _TEETH:
            return write_pin_contact(layout, model, data, contacts, geom2, geom1, -1.0, margin)
        if role2 == _OUTER and role1 in (_INNER, _PIN):
            return write_round_contacts(layout, model, data, contacts, geom1, geom2, 1.0, margin)
        if role1 == _OUTER and role2 in (_INNER, _PIN):
            return write_round_contacts(layout, model, data, contacts, geom2, geom1, -1.0, margin)
        if role1 == _ECCENTRIC and role2 == _OUTER:
            return write_bearing_contacts(layout, model, data, contacts, geom1, geom2, 1.0, margin)
        if role1 == _OUTER and role2 == _ECCENTRIC:
            return write_bearing_contacts(layout, model, data, contacts, geom2, geom1, -1.0, margin)
        if role1 == _SUN and role2 == _PLANET:
            return write_planet_contacts(layout, model, data, contacts, geom1, geom2, 1.0, margin)
        if role1 == _PLANET and role2 == _SUN:
            return write_planet_contacts(layout, model, data, contacts, geom2, geom1, -1.0, margin)
        return _original(model, data, contacts, geom1, geom2, margin)

    return collide


def _compile_lobe_collider(layout: Layout) -> Any:
    """Compile or load MuJoCo's collision function for the teeth of a disc and the lobes of the internal gear.

    The result is a numba ``cfunc``, which passes all other pairs to the general collider. Its compilation takes as long
    as that of all other pairs together; rings of pins do not need it. `layout` has the offsets of the arrays in
    MuJoCo's memory.
    """

    @cfunc(_SIGNATURE, cache=cacheable())
    def collide(model: int, data: int, contacts: int, geom1: int, geom2: int, margin: float) -> int:
        """Write the contacts of a disc's teeth and a lobe at the address `contacts`, and return their number.

        Any other pair of cylinder geoms is passed to the general collider. The arguments are those of its ``collide``.
        """
        priority = read_address(model + layout.geom_priority)
        role1, role2 = read_int(priority + 4 * geom1), read_int(priority + 4 * geom2)
        if role1 == _TEETH and role2 == _LOBE:
            return write_lobe_contacts(layout, model, data, contacts, geom1, geom2, 1.0, margin)
        if role1 == _LOBE and role2 == _TEETH:
            return write_lobe_contacts(layout, model, data, contacts, geom2, geom1, -1.0, margin)
        return _general(model, data, contacts, geom1, geom2, margin)

    return collide


@cache
def _general_collider() -> Any:
    """Return the address of MuJoCo's own collision function for cylinders, and the exact one after its self-test.

    The latter, a numba ``cfunc``, computes all exact contacts except those of lobes.

    Raises
    ------
    ContactError
        MuJoCo has no collider for cylinders, or the self-test fails.
    """
    original = collision_table()[_ENTRY]
    if not original:
        raise ContactError(
            "the installed MuJoCo lacks its collision function for two cylinders, so cylinders that are not part of "
            "the reducer cannot collide: reinstall MuJoCo with `pip install --force-reinstall mujoco`"
        )
    llvmlite.binding.add_symbol(_ORIGINAL, original)
    collider = _compile_general_collider(find_layout())
    selftest.require_passed("collider", lambda: selftest.try_collider(collider.address))
    return original, collider


@cache
def _compile_correction() -> Any:
    control_callback = compile_control_callback(find_step_layout())
    selftest.require_passed("lift", lambda: selftest.try_correction(control_callback.address))
    return control_callback


@cache
def _lobe_collider() -> Any:
    _, collider = _general_collider()
    llvmlite.binding.add_symbol(_GENERAL, collider.address)
    return _compile_lobe_collider(find_layout())


def _install() -> None:
    _, collider = _general_collider()
    set_callback("mjcb_control", _compile_correction().address)
    collision_table()[_ENTRY] = collider.address


def _uninstall() -> None:
    original, _ = _general_collider()
    collision_table()[_ENTRY] = original
    callback("mjcb_control").value = None


_installation = Shared(_install, _uninstall)


@contextmanager
def install(lobes: bool = True) -> Iterator[None]:
    """Replace MuJoCo's collision functions by exact conjugate contact inside this ``with`` block.

    Nested and parallel blocks are allowed.

    Parameters
    ----------
    lobes
        Whether the model has an internal gear; without it, half of the compilation is skipped.

    Raises
    ------
    ContactError
        The callback ``mjcb_control`` is already in use, or this release of MuJoCo is not compatible.
    """
    with _installation.apply():
        if lobes:
            # It stays until the last block ends: it passes all pairs of the general collider on.
            collision_table()[_ENTRY] = _lobe_collider().address
        yield
