"""Where MuJoCo keeps the arrays that compiled code reads: found from the Python bindings, checked on two models.

The C structures change between MuJoCo releases. Each array of the bindings is a view on MuJoCo's own memory, so its
address stands somewhere in ``mjModel`` or ``mjData``; the offset of that place is what the collider needs.
"""

import ctypes
from dataclasses import astuple, dataclass
from functools import cache
from typing import Any

import mujoco

from cycloid_mj.errors import ContactError

_WORD = ctypes.sizeof(ctypes.c_void_p)
_SPAN, _DATA_SPAN = 8192, 2048
"""Bytes in which pointers are looked for: of ``mjModel`` from its start, of ``mjData`` after its energies."""

_PROBE = """
<mujoco><size nuser_geom="{user}"/><worldbody>
<geom type="sphere" size="1" user="1"/>
<body><joint type="slide"/><geom type="cylinder" size="1 1" user="2"/></body>{more}
</worldbody></mujoco>
"""
_PROBE_OF_CONTACTS = '<mujoco><worldbody><geom type="plane" size="1 1 1"/>{more}</worldbody></mujoco>'
_BALL = '<body pos="0 0 0.9"><joint type="slide" axis="0 0 1"/><geom type="sphere" size="1" contype="2"/></body>'


@dataclass(frozen=True)
class Layout:
    """Byte offsets of pointers: four in ``mjModel``, two in ``mjData``."""

    geom_size: int
    geom_priority: int
    geom_user: int
    geom_type: int
    geom_xpos: int
    geom_xmat: int


@dataclass(frozen=True)
class ContactLayout:
    """Byte offsets of two pointers in ``mjData``, size of an ``mjContact``, and byte offsets of two fields in it."""

    contact: int
    efc_force: int
    stride: int
    geom: int
    efc_address: int


@cache
def discover() -> Layout:
    """Find the layout of the MuJoCo release that is installed.

    Raises
    ------
    ContactError
        The structures are not as expected; the message names the field and the release.
    """
    first = _layout(mujoco.MjModel.from_xml_string(_PROBE.format(user=3, more="")))
    body = '<body><joint/><geom type="box" size="1 1 1" user="5"/></body>'
    second = _layout(mujoco.MjModel.from_xml_string(_PROBE.format(user=7, more=body * 5)))
    if first != second:
        raise ContactError(_strange(f"two models disagree: {astuple(first)} and {astuple(second)}"))
    return first


@cache
def discover_contacts() -> ContactLayout:
    """Find where the MuJoCo release that is installed keeps its contacts and their forces.

    Raises
    ------
    ContactError
        The structures are not as expected; the message names the field and the release.
    """
    # What lies behind the structure may hold an address by chance, but not for both models at the same place.
    first, second = (_ContactPlaces.of(_PROBE_OF_CONTACTS.format(more=_BALL * balls)) for balls in (1, 5))
    forces = sorted(first.efc_force & second.efc_force)
    # The contacts begin the arena, whose own pointer comes before theirs; their forces come after them.
    contacts = sorted(place for place in first.contact & second.contact if forces and place < forces[0])
    if not contacts or first.fields != second.fields:
        raise ContactError(_strange("mjData.contact or mjData.efc_force was not found"))
    return ContactLayout(contacts[-1], forces[0], *first.fields)


@dataclass(frozen=True)
class _ContactPlaces:
    """Where the addresses of contacts and their forces stand in one ``mjData``; stride and offsets of the fields."""

    contact: frozenset[int]
    efc_force: frozenset[int]
    fields: tuple[int, int, int]

    @classmethod
    def of(cls, probe: str) -> "_ContactPlaces":
        model = mujoco.MjModel.from_xml_string(probe)
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        contact, start = data.contact, data.energy.ctypes.data - data._address
        # The distance is the first field of a contact.
        first = contact.dist.ctypes.data
        offsets = (contact.geom.ctypes.data - first, contact.efc_address.ctypes.data - first)
        return cls(
            contact=frozenset(_places(data._address, start, first, _DATA_SPAN)),
            efc_force=frozenset(_places(data._address, start, data.efc_force.ctypes.data, _DATA_SPAN)),
            fields=(contact.dist.strides[0], *offsets),
        )


def _layout(model: Any) -> Layout:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    # Pointers of mjModel follow its sizes, which start the structure; those of mjData follow the energies.
    in_data = data.energy.ctypes.data - data._address
    return Layout(
        geom_size=_offset(model._address, 0, model.geom_size, "mjModel.geom_size"),
        geom_priority=_offset(model._address, 0, model.geom_priority, "mjModel.geom_priority"),
        geom_user=_offset(model._address, 0, model.geom_user, "mjModel.geom_user"),
        geom_type=_offset(model._address, 0, model.geom_type, "mjModel.geom_type"),
        geom_xpos=_offset(data._address, in_data, data.geom_xpos, "mjData.geom_xpos", _DATA_SPAN),
        geom_xmat=_offset(data._address, in_data, data.geom_xmat, "mjData.geom_xmat", _DATA_SPAN),
    )


def _offset(structure: int, start: int, array: Any, name: str, span: int = _SPAN) -> int:
    """Give the offset of the last pointer to the array: empty arrays before it may share its address."""
    places = _places(structure, start, array.ctypes.data, span)
    if not places:
        raise ContactError(_strange(f"{name} was not found"))
    return places[-1]


def _places(structure: int, start: int, address: int, span: int) -> list[int]:
    """Give the offsets at which an address stands in a structure."""
    words = (ctypes.c_size_t * (span // _WORD)).from_address(structure + start)
    return [start + _WORD * i for i, word in enumerate(words) if word == address]


def _strange(what: str) -> str:
    return (
        f"MuJoCo {mujoco.__version__} keeps its structures in a way this collider does not know ({what}); "
        "install a release it was tested with: pip install 'mujoco==3.17.0'"
    )
