"""Work of a run in every MuJoCo step: set commands, record peak forces, take samples.

One in many steps is sampled, and an impact of a few steps can fall between two samples; a shaft follows its command in
every step. MuJoCo's speeds lag its positions and forces by half a step, so sampled speeds are advanced by half a step;
their powers agree with the change of energy.

MuJoCo's sensor callback does all of this at the end of the forward dynamics. Our models have a user sensor, which
triggers the callback, and one number of user data, the address of the state of the run (0 outside of a run). The
callback takes the following steps by calling the stages of ``mj_step`` and writes the samples among them, without
returning to Python. A fatal error of MuJoCo therefore occurs within one call from Python.
"""

import ctypes
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import astuple
from functools import cache
from typing import Any

import llvmlite.binding
import mujoco
import numpy as np
from numba import njit, types

from cycloid_mj.base import compiling
from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import cacheable, cfunc
from cycloid_mj.dynamics.contact import sample_layout, selftest
from cycloid_mj.dynamics.contact.forces import PairIndex, pair_of, sum_contacts
from cycloid_mj.dynamics.contact.layout import find_step_layout
from cycloid_mj.dynamics.contact.library import callback, function_address, set_callback
from cycloid_mj.dynamics.contact.memory import read_address, read_float, read_int, write_float
from cycloid_mj.dynamics.contact.reference_correction import bind_multiplication, correct_references, multiply_jacobian
from cycloid_mj.dynamics.contact.shared import Shared
from cycloid_mj.dynamics.contact.step_state import ARRAYS, FIELDS, INDEX, POINTERS, STEP_STATE, StepState, step_state_at
from cycloid_mj.dynamics.film_table import SEAT, TEETH, FilmRows, look_up, phase_cosine
from cycloid_mj.reducer import impact
from cycloid_mj.reducer.impact import ImpactLaw

SENSOR, IMPACT_SENSOR = "each_step", "impact"
"""Names of the user sensors: they read 0."""

_FIRST_STAGE, _LAST_STAGE = int(mujoco.mjtStage.mjSTAGE_POS), int(mujoco.mjtStage.mjSTAGE_ACC)
_spring, _damper = njit(impact.spring), njit(impact.damper)
_MIN_ADDED_MASS = 1e-7
"""Smallest added mass [kg] of a contact that follows IMPACT: a ten-thousandth of a pin."""
_STAGE, _PREFIX = types.void(types.intp, types.intp), "cycloid_mj_"
_STAGES = [
    types.ExternalFunction(_PREFIX + name, _STAGE)
    for name in (
        "mj_Euler",
        "mj_fwdPosition",
        "mj_fwdVelocity",
        "mj_fwdActuation",
        "mj_fwdAcceleration",
        "mj_fwdConstraint",
        "mj_energyPos",
        "mj_energyVel",
    )
]
(
    _integrate,
    _position,
    _velocity,
    _actuation,
    _acceleration,
    _constraint,
    _compute_potential_energy,
    _compute_kinetic_energy,
) = _STAGES


def add_sensor(spec: Any, changes_contacts: bool = False) -> None:
    """Add the sensor by which MuJoCo calls back `EachStep`, to advance and sample a run, to the editable model `spec`.

    One element of user data is added, too, for the memory address of the state of the run. With `changes_contacts` a
    second sensor is added, which is evaluated before the forces. Its call applies the contact law IMPACT of Adams or
    the friction law ``film`` (lubricated contacts) to each contact.
    """
    spec.nuserdata = 1
    stage_by_sensor = {IMPACT_SENSOR: mujoco.mjtStage.mjSTAGE_POS} if changes_contacts else {}
    stages = {SENSOR: mujoco.mjtStage.mjSTAGE_ACC} | stage_by_sensor
    for name, stage in stages.items():
        spec.add_sensor(
            name=name,
            type=mujoco.mjtSensor.mjSENS_USER,
            dim=1,
            datatype=mujoco.mjtDataType.mjDATATYPE_REAL,
            needstage=stage,
        )


class EachStep:
    """Stepper of a MuJoCo run on one ``MjData``; it must be used within `install`.

    The first step is sampled, at its start. A sample is a row of the values at `sources`, potential and kinetic energy
    [J] (`copied`), ``sample_layout.SOLVER_COLUMNS`` (`solver`), ``sample_layout.PAIR_COLUMNS`` of each pair (`pairs`),
    and the power of each drag [W] (`drags`). The normal force of a pair is the sum over its contacts.

    Parameters
    ----------
    model, data
        Model and state.
    index
        Mating pairs of the model.
    every
        Time steps from one sample to the next.
    sources
        Addresses of values in ``MjData``.
    drags
        Constraint rows of the joint drags.
    impacts
        Law IMPACT of each pair; none if contacts follow the model's own law.
    film
        Table and rows of the friction law ``film``; None with the law ``coulomb``.
    orbit_dofs
        Index of the degree of freedom along x of each disc; that along y comes next. Their positions are the disc
        centres.
    """

    def __init__(
        self,
        model: Any,
        data: Any,
        index: PairIndex,
        every: int = 1,
        sources: Sequence[int] = (),
        drags: Sequence[int] = (),
        impacts: Sequence[ImpactLaw] = (),
        orbit_dofs: Sequence[int] = (),
        film: FilmRows | None = None,
    ) -> None:
        """Allocate the arrays of a MuJoCo run, and store the address of its state in the user data of the model.

        Parameters
        ----------
        model, data
            Model and data of MuJoCo.
        index
            Mating pairs of the model.
        every
            Steps per sample.
        sources
            Memory addresses, in ``mjData``, of the doubles that each sample copies.
        drags
            Constraint rows of the losses by seals and lubricant, see `drag_rows`.
        impacts
            Parameters of the contact law IMPACT of Adams for each pair; empty with other laws.
        orbit_dofs
            Degrees of freedom of the discs that orbit.
        film
            Friction table and its rows for lubricated contacts (law ``film``); None with other friction laws.
        """
        self._model, self._data, self._index = model, data, index
        energies = data.energy.ctypes.data + 8 * np.arange(2)
        self._sources = np.array([*sources, *energies], dtype=np.int64)
        self._drags = np.array(drags, dtype=np.int32)
        self._impacts = np.array([astuple(impact) for impact in impacts], dtype=np.float64)
        self._orbits, self._orbit_velocity = np.array(orbit_dofs, dtype=np.int32), np.zeros(model.nv)
        self._film = film
        self._pin_forces_and_cosines = np.zeros((2, film.pins if film else 0))
        self._timestep = np.array([model.opt.timestep])
        self._peak_forces = np.zeros(len(index.origin))
        self._force_sums = np.zeros_like(self._peak_forces)
        self._commands = np.zeros((0, len(data.ctrl)))
        self._half_timestep, self._saved_qvel = np.array([0.5 * model.opt.timestep]), np.zeros(model.nv)
        self.copied, self.solver, self.pairs, self.drags, self._sample_width = sample_layout.sample_slices(
            self._sources.size, self._peak_forces.size, self._drags.size
        )
        self._every = every
        self._state = self._state_record()
        data.userdata[0] = self._state.ctypes.data

    def command(self, commands: Array) -> None:
        """Set the commands of the next steps, shape (steps, actuators); the last one persists."""
        self._commands = np.ascontiguousarray(commands)
        self._data.ctrl[:] = self._commands[0]
        width = self._commands.strides[0]
        self._state["command"] = self._commands.ctypes.data + width
        self._state["last"] = self._commands.ctypes.data + width * len(self._commands)

    def advance(self, samples: int) -> Array:
        """Take the time steps up to and including a number of samples; return the samples, shape (samples, columns)."""
        rows = np.zeros((samples, self._sample_width))
        self._state["rows"] = rows.ctypes.data
        self._state["left"] = self._state["due"] - 1 + (samples - 1) * self._every
        mujoco.mj_step(self._model, self._data)
        return rows

    def _state_record(self) -> Any:
        """Return the memory addresses and sizes of a run's arrays as a record, for compiled code in each step.

        Its fields are those of `STEP_STATE`, such as the number of steps per sample and the address of the forces.
        """
        model, data, index = self._model, self._data, self._index
        layout = find_step_layout()._asdict()
        integers = {name: data._address + layout[name] for name in POINTERS} | {name: layout[name] for name in FIELDS}
        integers |= {
            "nv": model.nv,
            "nu": len(data.ctrl),
            "nuser_geom": model.nuser_geom,
            "surfaces": len(index.pair),
            "pairs": len(index.origin),
            "source_count": self._sources.size,
            "drag_count": self._drags.size,
            "discs": self._orbits.size,
            "islands": data.solver_niter.size,
            "warning_kinds": data.warning.number.size,
            "warning_stride": data.warning.number.strides[0],
            "impact": self._impacts.ctypes.data if self._impacts.size else 0,
            "pins": self._pin_forces_and_cosines.shape[1],
            "second_plane": self._film.second_plane if self._film else 0,
            "due": 1,
            "every": self._every,
            "width": 8 * self._sample_width,
        }
        arrays = {name: getattr(data, name) for name in ARRAYS} | {name: getattr(index, name) for name in INDEX}
        arrays |= {
            "warning_number": data.warning.number,
            "timestep": self._timestep,
            "half_timestep": self._half_timestep,
            "saved_qvel": self._saved_qvel,
            "orbits": self._orbits,
            "circling": self._orbit_velocity,
            "sources": self._sources,
            "drags": self._drags,
            "sum": self._force_sums,
            "peak": self._peak_forces,
        }
        if self._film is not None:
            arrays |= {"film": self._film.table, "film_kind": self._film.kind, "film_pin": self._film.pin}
            arrays |= {"pin_force": self._pin_forces_and_cosines[0], "pin_cosine": self._pin_forces_and_cosines[1]}
        record = np.zeros((), STEP_STATE)
        for name, integer in (integers | {name: array.ctypes.data for name, array in arrays.items()}).items():
            record[name] = integer
        return record


@contextmanager
def install() -> Iterator[None]:
    """Install the callback of `EachStep` inside this ``with`` block; nested and parallel blocks are allowed.

    MuJoCo's timers are disabled: reading the clock some twenty times takes 4 % of a step.

    Raises
    ------
    ContactError
        The sensor callback is already in use, or this release of MuJoCo is not compatible.
    """
    with _installation.apply():
        _require_self_test()
        yield


@cache
def _require_self_test() -> None:
    selftest.require_passed("samples", lambda: selftest.try_steps(add_sensor, EachStep))


def _install() -> None:
    set_callback("mjcb_sensor", _compile_callback().address)
    timer = callback("mjcb_time")
    _timer.value, timer.value = timer.value, None


def _uninstall() -> None:
    callback("mjcb_sensor").value = None
    callback("mjcb_time").value = _timer.value


_timer = ctypes.c_void_p()
_installation = Shared(_install, _uninstall)


@cache
def _compile_callback() -> Any:
    """Compile or load MuJoCo's sensor callback that advances and samples a run; return it as a numba ``cfunc``.

    It takes all time steps of a call of `EachStep.advance` without returning to Python. In each step it applies the
    contact laws, records peak forces, and writes a sample if one is due.
    """
    layout = find_step_layout()
    bind_multiplication()
    for stage in _STAGES:
        llvmlite.binding.add_symbol(stage.symbol, function_address(stage.symbol.removeprefix(_PREFIX)))

    @cfunc(types.void(types.intp, types.intp, types.int32), cache=cacheable())
    def during_step(model: int, data: int, stage: int) -> None:
        """Apply the contact laws before the forces, or end a step and take the following steps, depending on `stage`.

        The signature is that of MuJoCo's ``mjfSensor``: `model` and `data` are the addresses of ``mjModel`` and
        ``mjData``, `stage` is MuJoCo's stage of the step (``mjtStage``). The following steps are those that remain in
        the current call of `EachStep.advance`.
        """
        if (stage != _LAST_STAGE and stage != _FIRST_STAGE) or read_int(model + layout.nuserdata) != 1:
            return
        address = int(read_float(read_address(data + layout.userdata)))
        if not address:
            return
        run = step_state_at(address)
        if stage == _FIRST_STAGE:
            _apply_impact(run)
            _apply_film(run)
            return
        _end_step(model, data, run)
        while run.left > 0:
            run.left -= 1
            _integrate(model, data)
            _position(model, data)
            _apply_impact(run)
            _apply_film(run)
            _velocity(model, data)
            correct_references(layout, model, data)
            _actuation(model, data)
            _acceleration(model, data)
            _constraint(model, data)
            _end_step(model, data, run)

    return during_step


@compiling.njit(inner=True)
def _end_step(model: int, data: int, run: StepState) -> None:
    """Update peak forces after a step, write a sample if it is due, and set the commands of the next step.

    `model` and `data` are the memory addresses of ``mjModel`` and ``mjData``; the state `run` is updated.
    """
    _update_peaks(run)
    run.due -= 1
    if run.due == 0:
        run.due = run.every
        _advance_speeds(run)
        multiply_jacobian(model, data, read_address(run.efc_vel), run.qvel)
        _compute_potential_energy(model, data)
        _compute_kinetic_energy(model, data)
        _write_sample(run)
        for dof in range(run.nv):
            write_float(run.qvel + 8 * dof, read_float(run.saved_qvel + 8 * dof))
    _set_command(run)


@compiling.njit(inner=True)
def _apply_impact(run: StepState) -> None:
    """Set stiffness and damping of every contact by Adams' law IMPACT at its current depth, if a run uses this law.

    `run` is the state of the run. A row of MuJoCo's constraints obeys R f + a + b v + k r = 0 (module `law`), with
    force f, relative acceleration a and velocity v, and gap r. The function sets k, b and R, which is the inverse of
    the added mass. The added mass is K dt^2/4 + C dt/2, with the law's tangent stiffness K and damping C; it is stable
    at any time step dt. The tangential rows are scaled so that friction coefficient and creep stay the same. Arrays are
    addressed in bytes, 8 for each number: a pair has the four numbers of `ImpactLaw`; a row of ``efc_KBIP`` has k, b,
    impedance and its derivative.
    """
    if not run.impact:
        return
    contacts_address, positions = read_address(run.contact), read_address(run.efc_pos)
    regularisations, added_masses = read_address(run.efc_R), read_address(run.efc_D)
    constants, timestep = read_address(run.efc_KBIP), read_float(run.timestep)
    for contact_index in range(read_int(run.ncon)):
        contact = contacts_address + run.stride * contact_index
        pair, row = abs(pair_of(run, contact)) - 1, read_int(contact + run.efc_address)
        if pair < 0 or row < 0:
            continue
        parameters = run.impact + 32 * pair
        exponent = read_float(parameters + 8)
        depth = max(-read_float(positions + 8 * row), impact.MIN_DEPTH)
        force = _spring(depth, read_float(parameters), exponent)
        damping = _damper(depth, read_float(parameters + 16), read_float(parameters + 24))
        added_mass = max(
            0.25 * exponent * force / depth * timestep * timestep + 0.5 * damping * timestep, _MIN_ADDED_MASS
        )
        scale = 1.0 / (added_mass * read_float(regularisations + 8 * row))
        for axis in range(read_int(contact + run.dim)):
            regularisation, row_constants = regularisations + 8 * (row + axis), constants + 32 * (row + axis)
            write_float(regularisation, scale * read_float(regularisation))
            write_float(added_masses + 8 * (row + axis), 1.0 / read_float(regularisation))
            write_float(row_constants + 8, scale * read_float(row_constants + 8))
        normal_constants = constants + 32 * row
        write_float(normal_constants, force / (depth * added_mass))
        write_float(normal_constants + 8, damping / added_mass)
        write_float(normal_constants + 16, 1.0)


@compiling.njit(inner=True)
def _apply_film(run: StepState) -> None:
    """Set the friction coefficient of each contact by the law ``film`` of lubricated contacts, if a run uses this law.

    The coefficient depends on the normal force, and at ring pins on the phase of the pin: the angle between the
    directions of the pin and of the disc's centre. Contacts of teeth are set before those of seats, because the disc
    that presses hardest on a moving pin determines the phase of the pin in its seat. A tilting pin has a phase in the
    plane of each disc. `run` is the state of the run.
    """
    if not run.film:
        return
    for pin in range(run.pins):
        write_float(run.pin_force + 8 * pin, 0.0)
        write_float(run.pin_cosine + 8 * pin, 1.0)
    for are_seats in (False, True):
        for contact_index in range(read_int(run.ncon)):
            contact = read_address(run.contact) + run.stride * contact_index
            pair, first_row = abs(pair_of(run, contact)) - 1, read_int(contact + run.efc_address)
            if pair < 0 or first_row < 0 or (read_int(run.film_kind + 4 * pair) == SEAT) != are_seats:
                continue
            _set_film_friction(run, contact, pair, first_row)


@compiling.njit(inner=True)
def _set_film_friction(run: StepState, contact: int, pair: int, row: int) -> None:
    """Set the friction coefficient of one contact from the table of lubricated friction (law ``film``).

    The table is interpolated at the normal force and the phase of the ring pin. `contact` is the memory address of the
    ``mjContact``, `pair` the index of its mating pair, `row` its first constraint row, and `run` the state of the run.
    """
    constants = read_address(run.efc_KBIP) + 32 * row
    depth = max(-read_float(read_address(run.efc_pos) + 8 * row), 0.0)
    force = read_float(constants) * read_float(constants + 16) * depth / read_float(read_address(run.efc_R) + 8 * row)
    kind, pin = read_int(run.film_kind + 4 * pair), read_int(run.film_pin + 4 * pair)
    cosine = 1.0
    if kind == TEETH:
        cosine = _phase_cosine(run, contact, pair)
        if force > read_float(run.pin_force + 8 * pin):
            write_float(run.pin_force + 8 * pin, force)
            write_float(run.pin_cosine + 8 * pin, cosine)
    elif kind == SEAT:
        if read_float(contact + run.pos + 16) > 0.0:  # z of the contact; that of the middle of all discs is 0
            pin += run.second_plane
        cosine = read_float(run.pin_cosine + 8 * pin)
    old_friction = read_float(contact + run.friction)
    coefficient = look_up(run.film, kind, cosine, force)
    if old_friction > 0.0 and coefficient > 0.0:
        write_float(contact + run.friction, coefficient)
        write_float(contact + run.friction + 8, coefficient)
        write_float(contact + run.mu, read_float(contact + run.mu) * coefficient / old_friction)


@compiling.njit(inner=True)
def _phase_cosine(run: StepState, contact: int, pair: int) -> float:
    """Compute the cosine of the angle between the directions of a ring pin or lobe and of the disc's centre.

    Both directions are from the reducer's axis. `contact` is the memory address of their ``mjContact``, `pair` the
    index of their mating pair, and `run` the state of the run.
    """
    first_geom, second_geom = read_int(contact + run.geom), read_int(contact + run.geom + 4)
    mate_geom = second_geom if read_address(run.teeth + 8 * first_geom) else first_geom
    pin_position, disc_position = run.geom_xpos + 24 * mate_geom, run.xpos + 24 * read_int(run.origin + 4 * pair)
    return phase_cosine(
        read_float(pin_position), read_float(pin_position + 8), read_float(disc_position), read_float(disc_position + 8)
    )


@compiling.njit(inner=True)
def _advance_speeds(run: StepState) -> None:
    """Save the speeds of the joints, and advance them by half a step."""
    half_timestep = read_float(run.half_timestep)
    for dof in range(run.nv):
        speed = read_float(run.qvel + 8 * dof)
        write_float(run.saved_qvel + 8 * dof, speed)
        write_float(run.qvel + 8 * dof, speed + half_timestep * read_float(run.qacc + 8 * dof))


@compiling.njit(inner=True)
def _set_command(run: StepState) -> None:
    """Set the commands of the next step; the last commands persist."""
    if run.command < run.last:
        for actuator in range(run.nu):
            write_float(run.ctrl + 8 * actuator, read_float(run.command + 8 * actuator))
        run.command += 8 * run.nu


@compiling.njit(inner=True)
def _update_peaks(run: StepState) -> None:
    """Update the peak normal force of each mating pair [N] in the state `run` with the pair's force in this step."""
    contacts_address, forces = read_address(run.contact), read_address(run.efc_force)
    count = read_int(run.ncon)
    for contact_index in range(count):
        contact = contacts_address + run.stride * contact_index
        pair, first_row = abs(pair_of(run, contact)) - 1, read_int(contact + run.efc_address)
        if pair >= 0 and first_row >= 0:
            address = run.sum + 8 * pair
            write_float(address, read_float(address) + read_float(forces + 8 * first_row))
    for contact_index in range(count):
        pair = abs(pair_of(run, contacts_address + run.stride * contact_index)) - 1
        if pair >= 0:
            address = run.peak + 8 * pair
            write_float(address, max(read_float(address), read_float(run.sum + 8 * pair)))
            write_float(run.sum + 8 * pair, 0.0)


@compiling.njit(inner=True)
def _write_sample(run: StepState) -> None:
    """Write a sample of a run at the memory address `run.rows`, and reset the peak forces.

    The address is advanced to the next row. A sample has the values at the addresses `run.sources`, solver statistics
    such as iterations, forces and powers of all pairs, and the powers of drags; see ``sample_layout``.
    """
    address = run.rows
    run.rows += run.width
    for source in range(run.source_count):
        write_float(address, read_float(read_address(run.sources + 8 * source)))
        address += 8
    summary, pair_table = address, address + 8 * sample_layout.OF_SOLVER
    for pair in range(run.pairs):
        peak_address = pair_table + 8 * (sample_layout.OF_PAIR * pair + sample_layout.PEAK_FORCE)
        write_float(peak_address, read_float(run.peak + 8 * pair))
        write_float(run.peak + 8 * pair, 0.0)
    sum_contacts(run, summary, pair_table)
    iterations, acceleration_sum, warnings = 0, 0.0, 0
    for island in range(run.islands):
        iterations = max(iterations, read_int(run.solver_niter + 4 * island))
    for dof in range(run.nv):
        acceleration_sum += read_float(run.qacc + 8 * dof)
    for kind in range(run.warning_kinds):
        warnings += read_int(run.warning_number + run.warning_stride * kind)
    write_float(summary + 8 * sample_layout.ITERATIONS, float(iterations))
    write_float(summary + 8 * sample_layout.ACCELERATION_SUM, acceleration_sum)
    write_float(summary + 8 * sample_layout.WARNINGS, float(warnings))
    drag_powers = pair_table + 8 * sample_layout.OF_PAIR * run.pairs
    for drag in range(run.drag_count):
        offset = 8 * read_int(run.drags + 4 * drag)
        force, speed = read_float(read_address(run.efc_force) + offset), read_float(read_address(run.efc_vel) + offset)
        write_float(drag_powers + 8 * drag, -force * speed)
