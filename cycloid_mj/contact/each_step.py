"""What happens in every step of a run, inside MuJoCo: the largest forces are noted, the next commands are set.

A sample is one step in many, and an impact of a few steps falls between two of them; a shaft follows its command at
every step. Both are done by MuJoCo's callback for sensors, at the end of the forward dynamics. A model of ours has a
user sensor, which the callback answers, and one number of user data: the address of what the run keeps. Without a run
that is 0, and nothing happens.

Sensors and energies, which take a tenth of a step, are read at samples alone: after the first step since the last
sample the callback itself takes all that follow, but the sampled one, by the stages of ``mj_step`` that move anything.
So they are inside one call from Python, whose error a fatal one of MuJoCo's becomes.
"""

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

import llvmlite.binding
import mujoco
import numpy as np
from numba import cfunc, njit, types

from cycloid_mj.compiling import announced, cacheable
from cycloid_mj.contact.forces import PairIndex
from cycloid_mj.contact.layout import StepLayout, discover_steps
from cycloid_mj.contact.library import function_address, library
from cycloid_mj.contact.memory import read_address, read_float, read_int, write_address, write_float
from cycloid_mj.contact.shared import Shared
from cycloid_mj.errors import ContactError
from cycloid_mj.types import Array, Integers

SENSOR = "each_step"
"""Name of the user sensor: it reads 0."""

_CONTACTS, _COUNT, _FORCES, _STRIDE, _GEOM, _ROW = range(6)
_SURFACE, _PAIR, _SURFACES, _SUM, _PEAK, _CTRL, _ACTUATORS, _COMMAND, _LAST, _SILENT = range(6, 16)

_LAST_STAGE = int(mujoco.mjtStage.mjSTAGE_ACC)

_STAGE, _PREFIX = types.void(types.intp, types.intp), "cycloid_mj_"
_integrate, _position, _velocity, _actuation, _acceleration, _constraint = (
    types.ExternalFunction(_PREFIX + name, _STAGE)
    for name in (
        "mj_Euler",
        "mj_fwdPosition",
        "mj_fwdVelocity",
        "mj_fwdActuation",
        "mj_fwdAcceleration",
        "mj_fwdConstraint",
    )
)


def add_sensor(spec: Any) -> None:
    """Give an editable model the user sensor and the user data."""
    spec.nuserdata = 1
    spec.add_sensor(
        name=SENSOR,
        type=mujoco.mjtSensor.mjSENS_USER,
        dim=1,
        datatype=mujoco.mjtDataType.mjDATATYPE_REAL,
        needstage=mujoco.mjtStage.mjSTAGE_ACC,
    )


class EachStep:
    """What a run keeps for its steps, which must go on under `installed`, on the ``MjData`` that it was made for.

    The normal force of a pair is the sum over its contacts. It is that of the start of a step, as in a sample.
    """

    def __init__(self, data: Any, index: PairIndex) -> None:
        count = len(index.origin)
        self._data, self._index, self._peak, self._sum = data, index, np.zeros(count), np.zeros(count)
        self._commands = np.zeros((0, len(data.ctrl)))
        self._table = self._places(discover_steps())
        data.userdata[0] = self._table.ctypes.data

    def command(self, commands: Array) -> None:
        """Set the commands of the next steps, shape (steps, actuators); after them the last one stays."""
        self._commands = np.ascontiguousarray(commands)
        self._data.ctrl[:] = self._commands[0]
        width = self._commands.strides[0]
        self._table[_COMMAND] = self._commands.ctypes.data + width
        self._table[_LAST] = self._commands.ctypes.data + width * len(self._commands)

    def advance(self, model: Any, steps: int) -> None:
        """Take steps; what sensors and energies read afterwards is of the start of the last of them."""
        self._table[_SILENT] = max(0, steps - 2)
        mujoco.mj_step(model, self._data, nstep=min(steps, 2))

    def peaks(self) -> Array:
        """Give the largest normal force of each pair [N] since the last time, shape (pairs,), and begin anew."""
        peak = self._peak.copy()
        self._peak[:] = 0.0
        return peak

    def _places(self, at: StepLayout) -> Integers:
        table, data = np.zeros(_SILENT + 1, dtype=np.int64), self._data
        table[_CONTACTS], table[_FORCES] = data._address + at.contact, data._address + at.efc_force
        table[_COUNT] = data._address + at.ncon
        table[_STRIDE], table[_GEOM], table[_ROW] = at.stride, at.geom, at.efc_address
        table[_SURFACE], table[_PAIR] = self._index.surface.ctypes.data, self._index.pair.ctypes.data
        table[_SURFACES] = len(self._index.pair)
        table[_SUM], table[_PEAK] = self._sum.ctypes.data, self._peak.ctypes.data
        table[_CTRL], table[_ACTUATORS] = data.ctrl.ctypes.data, len(data.ctrl)
        return table


@contextmanager
def installed() -> Iterator[None]:
    """Do what `EachStep` keeps inside this ``with`` block; nested and parallel blocks are allowed.

    Raises
    ------
    ContactError
        Somebody else answers user sensors.
    """
    with _installation.made():
        yield


def _install() -> None:
    callback = ctypes.c_void_p.in_dll(library(), "mjcb_sensor")
    if callback.value:
        raise ContactError(
            "MuJoCo's callback for sensors is taken, and a run needs it: call mujoco.set_mjcb_sensor(None) before"
        )
    callback.value = _compiled().address


def _uninstall() -> None:
    ctypes.c_void_p.in_dll(library(), "mjcb_sensor").value = None


_installation = Shared(_install, _uninstall)


@cache
def _compiled() -> Any:
    layout = discover_steps()
    nuserdata, userdata = layout.nuserdata, layout.userdata
    for stage in (_integrate, _position, _velocity, _actuation, _acceleration, _constraint):
        llvmlite.binding.add_symbol(stage.symbol, function_address(stage.symbol.removeprefix(_PREFIX)))

    @cfunc(types.void(types.intp, types.intp, types.int32), cache=cacheable())
    def answer(model: int, data: int, stage: int) -> None:
        if stage != _LAST_STAGE or read_int(model + nuserdata) != 1:
            return
        table = int(read_float(read_address(data + userdata)))
        if table:
            _note(table)
            _command(table)
            steps = read_address(table + 8 * _SILENT)
            write_address(table + 8 * _SILENT, 0)
            for _ in range(steps):
                _integrate(model, data)
                _position(model, data)
                _velocity(model, data)
                _actuation(model, data)
                _acceleration(model, data)
                _constraint(model, data)
                _note(table)
                _command(table)

    with announced():
        return answer


@njit
def _command(table: int) -> None:
    """Set the commands of the next step."""
    command = read_address(table + 8 * _COMMAND)
    if command < read_address(table + 8 * _LAST):
        ctrl, actuators = read_address(table + 8 * _CTRL), read_address(table + 8 * _ACTUATORS)
        for k in range(actuators):
            write_float(ctrl + 8 * k, read_float(command + 8 * k))
        write_address(table + 8 * _COMMAND, command + 8 * actuators)


@njit
def _note(table: int) -> None:
    """Note the forces of the contacts of this step."""
    first, force = read_address(read_address(table + 8 * _CONTACTS)), read_address(read_address(table + 8 * _FORCES))
    stride, geom, row = (
        read_address(table + 8 * _STRIDE),
        read_address(table + 8 * _GEOM),
        read_address(table + 8 * _ROW),
    )
    surface, pairs = read_address(table + 8 * _SURFACE), read_address(table + 8 * _PAIR)
    surfaces, total = read_address(table + 8 * _SURFACES), read_address(table + 8 * _SUM)
    peak, contacts = read_address(table + 8 * _PEAK), read_int(read_address(table + 8 * _COUNT))
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
def _pair_of(geoms: int, surface: int, pairs: int, surfaces: int) -> int:
    """Give the number of the mating pair of a contact, -1 for none."""
    one, two = read_int(surface + 4 * read_int(geoms)), read_int(surface + 4 * read_int(geoms + 4))
    return abs(read_int(pairs + 4 * (surfaces * one + two))) - 1
