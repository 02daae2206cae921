"""Memory layout of MuJoCo: offsets of the arrays that compiled code reads, determined from the Python bindings.

The C structures change between MuJoCo releases. Each array of the bindings is a view on MuJoCo's own memory, so its
address stands somewhere in ``mjModel`` or ``mjData``; the offset of that place is what compiled code needs.
"""

import ctypes
from enum import IntEnum
from functools import cache
from typing import Any, NamedTuple

import mujoco

from cycloid_mj.base.errors import ContactError
from cycloid_mj.dynamics.contact.library import incompatible_error


class _Span(IntEnum):
    """Search ranges [bytes]: pointers in ``mjModel``, and in ``mjData`` after its energies; sizes in ``mjModel``."""

    MODEL = 8192
    DATA = 2048
    SIZES = 1024


_PROBE = """
<mujoco><size nuser_geom="{user}"/><worldbody>
<geom type="sphere" size="1" user="1"/>
<body><joint type="slide"/><geom type="cylinder" size="1 1" user="2"/></body>{more}
</worldbody></mujoco>
"""
_STEP_PROBE = """
<mujoco><option><flag island="disable"/></option><size nuserdata="{user}"/>
<worldbody><geom type="plane" size="1 1 1"/>{more}</worldbody></mujoco>
"""
_BALL = '<body pos="0 0 0.9"><joint type="slide" axis="0 0 1"/><geom type="sphere" size="1" contype="2"/></body>'

POINTERS = ("efc_force", "efc_vel", "efc_aref", "efc_pos", "efc_R", "efc_D", "efc_KBIP", "qacc", "userdata")
"""Required arrays of ``mjData``; those of constraint rows have one number or more per row."""

FIELDS = ("pos", "frame", "dim", "geom", "efc_address", "friction", "mu")
"""Required fields of an ``mjContact``."""


class Layout(NamedTuple):
    """Byte offsets of three pointers in ``mjModel``, two in ``mjData``, and of the number ``nuser_geom``."""

    geom_size: int
    geom_priority: int
    geom_user: int
    geom_xpos: int
    geom_xmat: int
    nuser_geom: int


class StepLayout(NamedTuple):
    """Byte offsets of what compiled code reads and writes in a time step, by MuJoCo's names.

    `nuser_geom` and `nuserdata` are numbers in ``mjModel``, `ncon` is one in ``mjData``; `contact`, `efc_...`, `qacc`
    and `userdata` are pointers in ``mjData``. `stride` is the size of an ``mjContact``; the fields after it are offsets
    in it. Its distance is at 0.
    """

    nuser_geom: int
    nuserdata: int
    ncon: int
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
    stride: int
    pos: int
    frame: int
    dim: int
    geom: int
    efc_address: int
    friction: int
    mu: int


@cache
def find_layout() -> Layout:
    """Return the byte offsets, in ``mjModel`` and ``mjData``, of the arrays that the collider reads.

    They are found by a search in two small models with known contents, in the installed MuJoCo release.

    Raises
    ------
    ContactError
        MuJoCo's structures are not as expected; the message names the field and the installed release.
    """
    geom_xml = '<body><joint/><geom type="box" size="1 1 1" user="5"/></body>'
    xml_by_user_numbers = {7919: "", 6101: geom_xml * 5}
    probe_models = [
        mujoco.MjModel.from_xml_string(_PROBE.format(user=user_numbers, more=extra_xml))
        for user_numbers, extra_xml in xml_by_user_numbers.items()
    ]
    first_pointers, second_pointers = map(_find_pointers, probe_models)
    if first_pointers != second_pointers:
        raise _layout_error(f"two models disagree: {first_pointers} and {second_pointers}")
    offsets_of_size = [
        set(_find_number(model._address, _Span.SIZES, user_numbers))
        for model, user_numbers in zip(probe_models, xml_by_user_numbers, strict=True)
    ]
    if not (common_offsets := set.intersection(*offsets_of_size)):
        raise _layout_error("mjModel.nuser_geom is missing")
    return Layout(**first_pointers, nuser_geom=min(common_offsets))


@cache
def find_step_layout() -> StepLayout:
    """Return the byte offsets, in MuJoCo's structures, of the fields that compiled code uses in a time step.

    They are found by a search in two small models with known contents, in the installed MuJoCo release.

    Raises
    ------
    ContactError
        MuJoCo's structures are not as expected; the message names the field and the installed release.
    """
    # What lies behind the structure may be an address by chance, but not for both models at the same offset.
    (first_offsets, contact_fields), (second_offsets, other_contact_fields) = (
        _find_candidates(ball_count=2, user_count=7919),
        _find_candidates(ball_count=5, user_count=6101),
    )
    offsets = {name: sorted(first_offsets[name] & second_offsets[name]) for name in first_offsets}
    # The contacts begin the arena, whose own pointer comes before theirs; their forces come after them.
    forces = offsets["efc_force"]
    offsets["contact"] = [offset for offset in offsets["contact"] if forces and offset < forces[0]]
    if not all(offsets.values()) or contact_fields != other_contact_fields:
        raise _layout_error("contacts, forces, accelerations or user data are missing")
    offset_by_name = {
        name: candidates[-1 if name in ("contact", "userdata") else 0] for name, candidates in offsets.items()
    }
    return StepLayout(nuser_geom=find_layout().nuser_geom, **offset_by_name, **contact_fields)


def _find_candidates(ball_count: int, user_count: int) -> tuple[dict[str, set[int]], dict[str, int]]:
    """Return the possible byte offsets of each field of `StepLayout` in one model, and the known offsets in a contact.

    The fields are pointers and numbers of ``mjModel`` and ``mjData``, such as ``efc_force``. The offsets in a contact
    are those of `FIELDS`, such as ``pos``, with the size of a contact, ``stride``. The model has `ball_count` spheres
    in contact, and `user_count` numbers of user data.
    """
    model = mujoco.MjModel.from_xml_string(_STEP_PROBE.format(more=_BALL * ball_count, user=user_count))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    contact, data_start = data.contact, data.energy.ctypes.data - data._address
    # The distance is the first field of a contact.
    first_address = contact.dist.ctypes.data
    field_offsets = {name: getattr(contact, name).ctypes.data - first_address for name in FIELDS}
    arrays = {"contact": contact.dist} | {name: getattr(data, name) for name in POINTERS}
    offsets = {
        name: set(_find_address(data._address, data_start, array.ctypes.data, _Span.DATA))
        for name, array in arrays.items()
    }
    offsets["nuserdata"] = set(_find_number(model._address, _Span.SIZES, user_count))
    offsets["ncon"] = set(_find_number(data._address, data_start, data.ncon))
    # One ball is lifted: the number of contacts falls, that of balls and the most contacts so far stay.
    data.qpos[0] = 1.0
    mujoco.mj_forward(model, data)
    offsets["ncon"] &= set(_find_number(data._address, data_start, data.ncon))
    return offsets, {"stride": contact.dist.strides[0]} | field_offsets


def _find_pointers(model: Any) -> dict[str, int]:
    """Return the byte offsets of the five pointers of `Layout` in one model, by name, such as ``geom_size``.

    ContactError is raised if the address of one of these arrays does not occur in MuJoCo's structures. If an address
    occurs several times, the last occurrence is taken: empty arrays before it may have the same address.
    """
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    # Pointers of mjModel follow its sizes, which start the structure; those of mjData follow the energies.
    data_start = data.energy.ctypes.data - data._address
    offsets = {}
    for owner, range_start, search_range, array_names in (
        (model, 0, _Span.MODEL, ("geom_size", "geom_priority", "geom_user")),
        (data, data_start, _Span.DATA, ("geom_xpos", "geom_xmat")),
    ):
        for name in array_names:
            matches = _find_address(owner._address, range_start, getattr(owner, name).ctypes.data, search_range)
            if not matches:
                raise _layout_error(f"{type(owner).__name__}.{name} is missing")
            offsets[name] = matches[-1]
    return offsets


def _find_address(structure: int, start: int, address: int, span: int) -> list[int]:
    """Return the offsets of all occurrences of an address in a structure."""
    size = ctypes.sizeof(ctypes.c_void_p)
    words = (ctypes.c_size_t * (span // size)).from_address(structure + start)
    return [start + size * i for i, word in enumerate(words) if word == address]


def _find_number(structure: int, span: int, number: int) -> list[int]:
    """Return the offsets of all occurrences of a number in the first bytes of a structure."""
    words = (ctypes.c_int32 * (span // 4)).from_address(structure)
    return [4 * i for i, word in enumerate(words) if word == number]


def _layout_error(problem: str) -> ContactError:
    return incompatible_error(f"unexpected memory layout: {problem}")
