"""The largest normal force of each mating pair over many steps, read after every one of them.

A sample is one step in many: an impact of a few steps falls between two of them. What must happen at every step is one
call of compiled code, which reads MuJoCo's contacts where they are.
"""

from typing import Any

import numpy as np
from numba import njit

from cycloid_mj.compiling import cacheable
from cycloid_mj.contact.forces import PairIndex
from cycloid_mj.contact.layout import ContactLayout, discover_contacts
from cycloid_mj.contact.memory import read_address, read_float, read_int, write_float
from cycloid_mj.types import Array, Integers

_CONTACTS, _FORCES, _STRIDE, _GEOM, _ROW, _SURFACE, _PAIR, _SURFACES, _SUM, _PEAK = range(10)


class Peaks:
    """The largest normal force of each mating pair [N] since it was last asked for.

    The normal force of a pair is the sum over its contacts. It is that of the start of a step, as in a sample.
    """

    def __init__(self, data: Any, index: PairIndex) -> None:
        count = len(index.origin)
        self._data, self._peak, self._sum = data, np.zeros(count), np.zeros(count)
        self._index = index
        self._table = self._places(discover_contacts())
        self._address = self._table.ctypes.data

    def note(self) -> None:
        """Take note of the step that ``MjData`` has just taken."""
        _note(self._address, self._data.ncon)

    def taken(self) -> Array:
        """Give the peaks of the steps since the last time, shape (pairs,), and begin anew."""
        peak = self._peak.copy()
        self._peak[:] = 0.0
        return peak

    def _places(self, at: ContactLayout) -> Integers:
        table = np.zeros(10, dtype=np.int64)
        table[_CONTACTS], table[_FORCES] = self._data._address + at.contact, self._data._address + at.efc_force
        table[_STRIDE], table[_GEOM], table[_ROW] = at.stride, at.geom, at.efc_address
        table[_SURFACE], table[_PAIR] = self._index.surface.ctypes.data, self._index.pair.ctypes.data
        table[_SURFACES] = len(self._index.pair)
        table[_SUM], table[_PEAK] = self._sum.ctypes.data, self._peak.ctypes.data
        return table


@njit(cache=cacheable())
def _note(table: Any, contacts: Any) -> None:
    first, force = read_address(read_address(table + 8 * _CONTACTS)), read_address(read_address(table + 8 * _FORCES))
    stride, geom, row = (
        read_address(table + 8 * _STRIDE),
        read_address(table + 8 * _GEOM),
        read_address(table + 8 * _ROW),
    )
    surface, pairs = read_address(table + 8 * _SURFACE), read_address(table + 8 * _PAIR)
    surfaces, total = read_address(table + 8 * _SURFACES), read_address(table + 8 * _SUM)
    peak = read_address(table + 8 * _PEAK)
    for k in range(contacts):
        contact = first + stride * k
        pair, address = _pair_of(contact + geom, surface, pairs, surfaces), read_int(contact + row)
        if pair >= 0 and address >= 0:
            place = total + 8 * pair
            write_float(place, read_float(place) + read_float(force + 8 * address))
    for k in range(contacts):
        pair = _pair_of(first + stride * k + geom, surface, pairs, surfaces)
        if pair >= 0:
            place = peak + 8 * pair
            write_float(place, max(read_float(place), read_float(total + 8 * pair)))
            write_float(total + 8 * pair, 0.0)


@njit(inline="always")
def _pair_of(geoms: Any, surface: Any, pairs: Any, surfaces: Any) -> Any:
    """Give the number of the mating pair of a contact, -1 for none."""
    one, two = read_int(surface + 4 * read_int(geoms)), read_int(surface + 4 * read_int(geoms + 4))
    return abs(read_int(pairs + 4 * (surfaces * one + two))) - 1
