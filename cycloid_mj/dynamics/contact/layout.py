"""Memory layout of MuJoCo: addresses of the arrays that compiled code reads, found from the Python bindings.

The C structures change between MuJoCo releases. Each array of the bindings is a view on MuJoCo's own memory, so its
address stands somewhere in ``mjModel`` or ``mjData``; the offset of that place is what the collider needs.
"""

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import mujoco

from cycloid_mj.base.errors import ContactError
from cycloid_mj.dynamics.contact.library import unfit

_WORD = ctypes.sizeof(ctypes.c_void_p)
_SPAN, _DATA_SPAN, _SIZES = 8192, 2048, 1024
"""Search ranges in bytes: pointers in ``mjModel`` from its start and in ``mjData`` after its energies; sizes at the
start of ``mjModel`` and before the energies of ``mjData``."""

_PROBE = """
<mujoco><size nuser_geom="{user}"/><worldbody>
<geom type="sphere" size="1" user="1"/>
<body><joint type="slide"/><geom type="cylinder" size="1 1" user="2"/></body>{more}
</worldbody></mujoco>
"""
_PROBE_OF_STEPS = """
<mujoco><option><flag island="disable"/></option><size nuserdata="{user}"/>
<worldbody><geom type="plane" size="1 1 1"/>{more}</worldbody></mujoco>
"""
_BALL = '<body pos="0 0 0.9"><joint type="slide" axis="0 0 1"/><geom type="sphere" size="1" contype="2"/></body>'


ROWS = ("efc_force", "efc_vel", "efc_aref", "efc_pos", "efc_R", "efc_D", "efc_KBIP")
"""Arrays of ``mjData`` with one number or more per constraint row."""

FIELDS = ("pos", "frame", "dim", "geom", "efc_address", "friction", "mu")
"""Required fields of an ``mjContact``."""


@dataclass(frozen=True)
class Layout:
    """Byte offsets of pointers, four in ``mjModel`` and two in ``mjData``, and of the number ``nuser_geom``."""

    geom_size: int
    geom_priority: int
    geom_user: int
    geom_type: int
    geom_xpos: int
    geom_xmat: int
    nuser_geom: int


@dataclass(frozen=True)
class StepLayout:
    """Offsets of the results of a step in ``mjData``, in an ``mjContact``, and of the size of user data in ``mjModel``.

    `contact`, `efc_...`, `qacc` and `userdata` are byte offsets of pointers in ``mjData``, `ncon` that of a number
    there, `nuserdata` that of one in ``mjModel``. `stride` is the size of an ``mjContact``; the fields after it are
    offsets in it. Its distance is at 0.
    """

    contact: int
    efc_force: int
    efc_vel: int
    efc_aref: int
    efc_pos: int
    efc_R: int
    efc_D: int
    efc_KBIP: int
    qacc: int
    userdata: int
    ncon: int
    nuserdata: int
    stride: int
    pos: int
    frame: int
    dim: int
    geom: int
    efc_address: int
    friction: int
    mu: int


@cache
def discover() -> Layout:
    """Return the layout of the installed MuJoCo release.

    Raises
    ------
    ContactError
        The structures are not as expected; the message names the field and the release.
    """
    body = '<body><joint/><geom type="box" size="1 1 1" user="5"/></body>'
    wide = {7919: "", 6101: body * 5}
    models = [mujoco.MjModel.from_xml_string(_PROBE.format(user=user, more=more)) for user, more in wide.items()]
    first, second = map(_pointers, models)
    if first != second:
        raise _strange(f"two models disagree: {first} and {second}")
    numbers = [set(_numbers(model._address, _SIZES, user)) for model, user in zip(models, wide, strict=True)]
    if not (common := set.intersection(*numbers)):
        raise _strange("mjModel.nuser_geom was not found")
    return Layout(**first, nuser_geom=min(common))


@cache
def discover_steps() -> StepLayout:
    """Return the offsets of the results of a step in the installed MuJoCo release.

    Raises
    ------
    ContactError
        The structures are not as expected; the message names the field and the release.
    """
    # What lies behind the structure may hold an address by chance, but not for both models at the same place.
    first, second = _StepPlaces.of(balls=2, user=7919), _StepPlaces.of(balls=5, user=6101)
    rows = {name: sorted(first.rows[name] & second.rows[name]) for name in ROWS}
    forces, numbers = rows["efc_force"], sorted(first.ncon & second.ncon)
    # The contacts begin the arena, whose own pointer comes before theirs; their forces come after them.
    contacts = sorted(place for place in first.contact & second.contact if forces and place < forces[0])
    data, sizes = sorted(first.userdata & second.userdata), sorted(first.nuserdata & second.nuserdata)
    accelerations = sorted(first.qacc & second.qacc)
    found = contacts and all(rows.values()) and numbers and accelerations and data and sizes
    if not found or first.fields != second.fields:
        raise _strange("contacts, forces, accelerations or user data were not found")
    offsets = {name: places[0] for name, places in rows.items()}
    of_contact = dict(zip(("stride", *FIELDS), first.fields, strict=True))
    return StepLayout(
        contact=contacts[-1],
        qacc=accelerations[0],
        userdata=data[-1],
        ncon=numbers[0],
        nuserdata=sizes[0],
        **offsets,
        **of_contact,
    )


@dataclass(frozen=True)
class _StepPlaces:
    """Candidates of these offsets in one ``mjData``; stride and offsets of the fields of a contact."""

    contact: frozenset[int]
    rows: Mapping[str, frozenset[int]]
    qacc: frozenset[int]
    userdata: frozenset[int]
    ncon: frozenset[int]
    nuserdata: frozenset[int]
    fields: tuple[int, ...]

    @classmethod
    def of(cls, balls: int, user: int) -> "_StepPlaces":
        """Return the candidates for a model with so many `balls` in contact and so much user data."""
        model = mujoco.MjModel.from_xml_string(_PROBE_OF_STEPS.format(more=_BALL * balls, user=user))
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        contact, start = data.contact, data.energy.ctypes.data - data._address
        # The distance is the first field of a contact.
        first = contact.dist.ctypes.data
        offsets = (getattr(contact, name).ctypes.data - first for name in FIELDS)
        places: dict[str, Any] = {
            "contact": frozenset(_places(data._address, start, first, _DATA_SPAN)),
            "rows": {
                name: frozenset(_places(data._address, start, getattr(data, name).ctypes.data, _DATA_SPAN))
                for name in ROWS
            },
            "qacc": frozenset(_places(data._address, start, data.qacc.ctypes.data, _DATA_SPAN)),
            "userdata": frozenset(_places(data._address, start, data.userdata.ctypes.data, _DATA_SPAN)),
            "nuserdata": frozenset(_numbers(model._address, _SIZES, user)),
        }
        touching = _numbers(data._address, start, data.ncon)
        data.qpos[0] = 1.0
        mujoco.mj_forward(model, data)
        # One ball is lifted: the number of contacts falls, that of balls and the most contacts so far stay.
        fewer = _numbers(data._address, start, data.ncon)
        return cls(**places, ncon=frozenset(touching) & frozenset(fewer), fields=(contact.dist.strides[0], *offsets))


def _pointers(model: Any) -> dict[str, int]:
    """Return the offsets of the pointers of `Layout` for one model."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    # Pointers of mjModel follow its sizes, which start the structure; those of mjData follow the energies.
    in_data = data.energy.ctypes.data - data._address
    return {
        "geom_size": _offset(model._address, 0, model.geom_size, "mjModel.geom_size"),
        "geom_priority": _offset(model._address, 0, model.geom_priority, "mjModel.geom_priority"),
        "geom_user": _offset(model._address, 0, model.geom_user, "mjModel.geom_user"),
        "geom_type": _offset(model._address, 0, model.geom_type, "mjModel.geom_type"),
        "geom_xpos": _offset(data._address, in_data, data.geom_xpos, "mjData.geom_xpos", _DATA_SPAN),
        "geom_xmat": _offset(data._address, in_data, data.geom_xmat, "mjData.geom_xmat", _DATA_SPAN),
    }


def _offset(structure: int, start: int, array: Any, name: str, span: int = _SPAN) -> int:
    """Return the offset of the last pointer to the array: empty arrays before it may share its address."""
    places = _places(structure, start, array.ctypes.data, span)
    if not places:
        raise _strange(f"{name} was not found")
    return places[-1]


def _places(structure: int, start: int, address: int, span: int) -> list[int]:
    """Return the offsets of all occurrences of an address in a structure."""
    words = (ctypes.c_size_t * (span // _WORD)).from_address(structure + start)
    return [start + _WORD * i for i, word in enumerate(words) if word == address]


def _numbers(structure: int, span: int, number: int) -> list[int]:
    """Return the offsets of all occurrences of a number in the first bytes of a structure."""
    words = (ctypes.c_int32 * (span // 4)).from_address(structure)
    return [4 * i for i, word in enumerate(words) if word == number]


def _strange(what: str) -> ContactError:
    return unfit(f"unexpected memory layout: {what}")
