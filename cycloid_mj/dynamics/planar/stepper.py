"""Time stepping of planar runs, with samples in the layout of ``contact.each_step``.

Steps start and end half a step before and after the times of samples, so that a sample is the state at a midpoint,
where positions, speeds and forces belong to the same time.
"""

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from cycloid_mj.base import compiling
from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import announce_compilation, cacheable
from cycloid_mj.dynamics.contact import sample_layout
from cycloid_mj.dynamics.contact.contact_search import STRIDE
from cycloid_mj.dynamics.planar.contacts import (
    MAX_TOUCHES,
    OPEN,
    Contacts,
    allocate_contacts,
    find_contacts,
    njit,
    plane_shift,
)
from cycloid_mj.dynamics.planar.crank_train import CrankTrain, find_crank_contacts
from cycloid_mj.dynamics.planar.equations import Equations, allocate_equations, solve_step
from cycloid_mj.dynamics.planar.settings import CONTACT_SEARCH
from cycloid_mj.dynamics.planar.system import System


class Motion(NamedTuple):
    """State of a run.

    Attributes
    ----------
    q, v
        Positions [m], [rad] and speeds [m/s], [rad/s] of all unknowns at the end of the last step, shape (unknowns,).
        The module ``system`` describes the order of the unknowns.
    midpoint, before
        Speeds of all unknowns at the midpoint of the last step, and of the step before it.
    peak
        Largest normal force of each pair since the last sample [N].
    """

    q: Array
    v: Array
    midpoint: Array
    before: Array
    peak: Array


class Stepper:
    """Stepper of a planar run, with the interface and the sample layout of ``contact.each_step.EachStep``.

    Parameters
    ----------
    system
        The reducer.
    timestep
        Time step [s].
    positions, speeds
        Positions [m], [rad] and speeds [m/s], [rad/s] of all unknowns at time 0, shape (unknowns,).
    stride
        Time steps from one sample to the next.
    midpoint_pins
        Whether moving pins are integrated by the midpoint rule as well, for steps that resolve their motion.
    train
        Cranks of an RV reducer; None for a central crank.
    """

    def __init__(
        self,
        system: System,
        timestep: float,
        positions: Array,
        speeds: Array,
        stride: int = 1,
        midpoint_pins: bool = False,
        train: CrankTrain | None = None,
    ) -> None:
        """Allocate contacts and equations of the planar solver, and set the positions half a step before time 0.

        `system` is the reducer as arrays. `positions` and `speeds` (unknowns,) are those of all coordinates at time 0;
        the earlier positions are extrapolated with these speeds. `timestep` is in [s], `stride` in steps per sample.
        `midpoint_pins` is whether moving pins are integrated by the midpoint rule, like all other bodies. `train` has
        the cranks of an RV reducer.
        """
        self._system, self._train, self._timestep, self._stride = system, train, timestep, stride
        self._pin_span = 0.5 * timestep if midpoint_pins else timestep
        self._contacts, self._equations = allocate_contacts(system), allocate_equations(system)
        disc_count, tooth_count = len(system.offset), len(system.ring_centres)
        pair_count = (
            tooth_count * (disc_count + system.free)
            + len(system.cams) * (1 + len(system.studs))
            + system.cranks * (disc_count + 1)
        )
        self._motion = Motion(
            q=positions - 0.5 * timestep * speeds,
            v=speeds.copy(),
            midpoint=speeds.copy(),
            before=speeds.copy(),
            peak=np.zeros(pair_count),
        )
        self._commands = np.zeros((1, 2))
        self._steps_taken, self._next_sample = 0, 1
        # angle, speed and torque of two shafts; position and speeds of a floating sun; pose and speeds of discs; angle
        # and speed of cranks; position and spin of pins; two energies
        copied_count = (
            2 * 3 + 4 * system.floating + 6 * disc_count + 2 * system.cranks + 4 * tooth_count * system.free + 2
        )
        drag_count = int((system.drag[:, 0] > 0.0).sum())
        self.copied, self.solver, self.pairs, self.drags, self._width = sample_layout.sample_slices(
            copied_count, pair_count, drag_count
        )

    def command(self, commands: Array) -> None:
        """Set the commands of crank and output for the next steps, shape (steps, 2); the last one persists."""
        self._commands, self._steps_taken = np.ascontiguousarray(commands[:, ::-1]), 0

    def advance(self, samples: int) -> Array:
        """Advance the run up to and including its next `samples` samples, and return these, shape (samples, columns).

        Each step uses the next row of the commands that `command` has set; after the last row, this is repeated. The
        columns are positions, speeds and energies, solver statistics, forces and powers of all pairs, and losses by
        drags (seals, lubricant); `sample_slices` has the slice of each group.
        """
        rows = np.zeros((samples, self._width))
        steps = self._next_sample + (samples - 1) * self._stride
        commands = self._commands[
            np.minimum(np.arange(self._steps_taken, self._steps_taken + steps), len(self._commands) - 1)
        ]
        system = self._system
        lobes = np.ascontiguousarray(system.ring[:, 0]) if system.lobes else None
        with announce_compilation():  # the first steps compile
            _compile_steps()(
                system,
                lobes,
                self._train,
                self._contacts,
                self._equations,
                self._motion,
                commands,
                self._timestep,
                self._pin_span,
                self._next_sample,
                self._stride,
                rows,
            )
        self._steps_taken, self._next_sample = self._steps_taken + steps, self._stride
        return rows


@cache
def _compile_steps() -> Any:
    """Compile or load the function that advances a planar run, with versions for lobes, pins, cranks; return it."""

    @compiling.njit(cache=cacheable(), error_model="numpy", nogil=True)
    def advance(
        system: System,
        lobes: Array | None,
        train: CrankTrain | None,
        contacts: Contacts,
        equations: Equations,
        motion: Motion,
        commands: Array,
        timestep: float,
        pin_span: float,
        next_sample: int,
        stride: int,
        rows: Array,
    ) -> None:
        """Take a time step for each row of `commands`; update `motion`, and write samples to `rows`.

        `system` is the reducer as arrays. A row of `commands`, shape (steps, 2), has the commands of output and crank:
        the angle [rad] of a shaft with a servo, else its torque [N m]. There is a sample every `stride` steps from step
        `next_sample` on, counted from 1. In each step, contact search and solution are repeated until both agree.
        `contacts` and `equations` are working memory. `lobes` [m] are radii, None without an internal gear; `train` is
        None without cranks. Forces accelerate pins in `pin_span` [s]: half of a `timestep`, or all of it.
        """
        main_count, half_step = len(equations.rhs), 0.5 * timestep
        midpoint, predicted, q = np.empty_like(motion.v), np.empty_like(motion.v), np.empty_like(motion.q)
        force_sums, scratch = np.zeros_like(motion.peak), np.zeros((MAX_TOUCHES, STRIDE // 8))
        row, max_iterations, unconverged = 0, 0, 0
        for step in range(len(commands)):
            _extrapolate_speeds(motion, main_count, predicted)
            count, iterations = 0, 0
            for search in range(CONTACT_SEARCH.max_searches):
                _integrate(motion.q, half_step, predicted, q)
                count = find_contacts(system, lobes, q, predicted, half_step, scratch, contacts)
                if train is not None:
                    count = find_crank_contacts(system, train, contacts, count, q, predicted, half_step)
                q0, v0, command = motion.q, motion.v, commands[step]
                iterations = solve_step(
                    system, contacts, count, equations, q0, v0, predicted, command, timestep, pin_span, midpoint
                )
                if not _is_far_from_search(system, half_step, predicted, midpoint, main_count):
                    break
                _relax(predicted, midpoint, 1.0 if search < CONTACT_SEARCH.unrelaxed_searches else 0.5)
            else:
                unconverged += 1
            max_iterations = max(max_iterations, iterations)
            _update_peaks(contacts, count, force_sums, motion.peak)
            next_sample -= 1
            if next_sample == 0:
                next_sample = stride
                _integrate(motion.q, half_step, midpoint, q)
                _write_sample(
                    system, contacts, count, motion, q, midpoint, commands[step], max_iterations, unconverged, rows[row]
                )
                row, max_iterations, unconverged = row + 1, 0, 0
            _finish_step(motion, main_count, timestep, pin_span, midpoint)

    return advance


@njit
def _extrapolate_speeds(motion: Motion, main_count: int, predicted: Array) -> None:
    """Write the expected midpoint speeds of the next step to `predicted`, from those of the last two steps in `motion`.

    `predicted` has the shape (unknowns,). The first `main_count` unknowns are extrapolated linearly. The others are
    those of pins; they keep their speeds.
    """
    for unknown in range(len(predicted)):
        predicted[unknown] = motion.midpoint[unknown]
        if unknown < main_count:
            predicted[unknown] += motion.midpoint[unknown] - motion.before[unknown]


@njit
def _integrate(start: Array, time: float, speeds: Array, end: Array) -> None:
    """Compute the positions after a time [s] at constant speeds."""
    for i in range(len(end)):
        end[i] = start[i] + time * speeds[i]


@njit
def _relax(predicted: Array, midpoint: Array, share: float) -> None:
    """Move the speeds of the contact search (`predicted`) a share of the way to the solution (`midpoint`)."""
    for i in range(len(predicted)):
        predicted[i] += share * (midpoint[i] - predicted[i])


@njit
def _finish_step(motion: Motion, main_count: int, timestep: float, pin_span: float, midpoint: Array) -> None:
    """Advance the state of a run, `motion`, in place to the end of a step with the speeds `midpoint` at its midpoint.

    `midpoint` has the shape (unknowns,); all but the first `main_count` unknowns are those of pins. `timestep` is in
    [s], and `pin_span` [s] is the time in which forces accelerate pins to their midpoint speeds, half a step or a step.
    """
    pin_factor = timestep / pin_span
    for unknown in range(len(midpoint)):
        motion.before[unknown], motion.midpoint[unknown] = motion.midpoint[unknown], midpoint[unknown]
        motion.q[unknown] += timestep * midpoint[unknown]
        motion.v[unknown] += (2.0 if unknown < main_count else pin_factor) * (midpoint[unknown] - motion.v[unknown])


@njit
def _is_far_from_search(system: System, half_step: float, predicted: Array, midpoint: Array, main_count: int) -> bool:
    """Return whether a disc or a moving pin is so far from the pose of the contact search that it has to be repeated.

    `system` is the reducer as arrays. The search is at the pose that follows from the `predicted` midpoint speeds,
    which is compared with that by the speeds `midpoint` of the solution, both of shape (unknowns,) [m/s, rad/s].
    `half_step` is half of the time step [s]; all but the first `main_count` unknowns are those of pins. A disc may be
    `CONTACT_SEARCH.disc_tolerance` [m] away, with its rotation as a path at the pin circle, and a pin `pin_tolerance`
    [1] times the difference of the radii of its seat.
    """
    pin_circle_radius, tolerance = system.teeth.ring.radius, CONTACT_SEARCH.disc_tolerance
    for body in range(0, 3 * system.bodies, 3):
        speed_x, speed_y = midpoint[body] - predicted[body], midpoint[body + 1] - predicted[body + 1]
        rim_speed = pin_circle_radius * (midpoint[body + 2] - predicted[body + 2])
        if (
            half_step * half_step * (speed_x * speed_x + speed_y * speed_y + rim_speed * rim_speed)
            > tolerance * tolerance
        ):
            return True
    plane_count = len(system.pin_mass)
    for pin in range(len(system.inner)):
        tolerance = CONTACT_SEARCH.pin_tolerance * (system.outer[pin] - system.inner[pin])
        for plane in range(plane_count):
            pin_x = main_count + (2 * plane_count + 1) * pin + plane_shift(plane)
            speed_x, speed_y = midpoint[pin_x] - predicted[pin_x], midpoint[pin_x + 1] - predicted[pin_x + 1]
            if half_step * half_step * (speed_x * speed_x + speed_y * speed_y) > tolerance * tolerance:
                return True
    return False


@njit
def _update_peaks(contacts: Contacts, count: int, force_sums: Array, peak_forces: Array) -> None:
    """Update the peak of the normal force of each mating pair [N] with the pair's force in this step.

    `count` is the number of contacts. `force_sums` (pairs,) is working memory, zero before and after.
    """
    for contact_index in range(count):
        force_sums[contacts[contact_index].pair] += contacts[contact_index].normal_force
    for contact_index in range(count):
        pair = contacts[contact_index].pair
        peak_forces[pair] = max(peak_forces[pair], force_sums[pair])
        force_sums[pair] = 0.0


@njit
def _write_sample(
    system: System,
    contacts: Contacts,
    count: int,
    motion: Motion,
    q: Array,
    v: Array,
    command: Array,
    iterations: int,
    unconverged: int,
    row: Array,
) -> None:
    """Write the sample of a step to a row: positions and speeds, energies, solver statistics, pairs and drags.

    `system` is the reducer as arrays. The first `count` of the `contacts` are written, and the peak forces in `motion`,
    which are set to 0. `q` and `v` are all coordinates and their speeds, shape (unknowns,), at the midpoint of the
    step, `command` (2,) the commands of output and input. `iterations` is the largest number of Newton iterations in
    the steps since the last sample; only the last contact search of a step counts. `unconverged` is the number of these
    steps whose contact geometry did not converge.
    """
    column = _write_motion(system, q, v, command, row)
    row[column], row[column + 1] = _compute_energies(system, q, v, len(system.inertia))
    solver_column = column + 2
    pairs_column = solver_column + sample_layout.OF_SOLVER
    for pair in range(len(motion.peak)):
        row[pairs_column + sample_layout.OF_PAIR * pair + sample_layout.PEAK_FORCE] = motion.peak[pair]
        motion.peak[pair] = 0.0
    _write_contacts(contacts, count, row, solver_column, pairs_column)
    row[solver_column + sample_layout.ITERATIONS], row[solver_column + sample_layout.WARNINGS] = iterations, unconverged
    for unknown in range(len(v)):
        row[solver_column + sample_layout.ACCELERATION_SUM] += v[unknown]
    column = pairs_column + sample_layout.OF_PAIR * len(motion.peak)
    for shaft in (1, 0):
        limit = system.drag[shaft, 0]
        if limit > 0.0:
            speed = v[system.shafts[shaft]]
            row[column] = min(limit, system.drag[shaft, 1] * abs(speed)) * abs(speed)
            column += 1


@njit
def _write_motion(system: System, q: Array, v: Array, command: Array, row: Array) -> int:
    """Write positions and speeds of input, discs, output, cranks and moving pins to a row; return the next column.

    `system` is the reducer as arrays. `q` and `v` are all coordinates and their speeds, shape (unknowns,), `command`
    (2,) the commands of output and input. The columns of a floating sun's position and velocity come after those of its
    rotation, which is the input. Angles of cranks are relative to the carrier, positions of pins to the seats in the
    ring. The position of a tilting pin is that of its middle.
    """
    main_count, sun_unknown = len(system.inertia), 3 * len(system.offset)
    column = _write_shaft(system, 1, system.shafts[1], q, v, command, row, 0)
    if system.floating:
        for axis in range(2):
            row[column + axis], row[column + 2 + axis] = q[sun_unknown + axis], v[sun_unknown + axis]
        column += 4
    for body in range(0, sun_unknown, 3):
        for axis in range(3):
            row[column + axis], row[column + 3 + axis] = q[body + axis], v[body + axis]
        column += 6
    column = _write_shaft(system, 0, system.shafts[0], q, v, command, row, column)
    carrier_unknown = system.stud_shaft
    carrier_angle, carrier_speed = (q[carrier_unknown], v[carrier_unknown]) if carrier_unknown >= 0 else (0.0, 0.0)
    for crank in range(main_count - system.cranks, main_count):
        row[column], row[column + 1] = q[crank] - carrier_angle, v[crank] - carrier_speed
        column += 2
    ring_angle, ring_speed = (q[system.ring_shaft], v[system.ring_shaft]) if system.ring_shaft >= 0 else (0.0, 0.0)
    sine, cosine = math.sin(ring_angle), math.cos(ring_angle)
    pin_width = 2 * len(system.pin_mass) + 1
    for pin_unknown in range(main_count, len(q), pin_width):
        pin = (pin_unknown - main_count) // pin_width
        x, y = q[pin_unknown], q[pin_unknown + 1]
        if pin_width > 3:
            x, y = 0.5 * (x + q[pin_unknown + 3]), 0.5 * (y + q[pin_unknown + 4])
        row[column] = cosine * x + sine * y - system.seat_centres[pin, 0]
        row[column + 1] = cosine * y - sine * x - system.seat_centres[pin, 1]
        row[column + 2], row[column + 3] = q[pin_unknown + 2] - ring_angle, v[pin_unknown + 2] - ring_speed
        column += 4
    return column


@njit
def _write_contacts(contacts: Contacts, count: int, row: Array, solver_column: int, pairs_column: int) -> None:
    """Write number, depth, forces and powers of the first `count` contacts to a sample, the array `row` (columns,).

    The values for all contacts start at `solver_column`, those of each pair at `pairs_column`, where the row must be
    zero before; see `sample_layout`.
    """
    active_contacts, max_depth, largest_force = 0, 0.0, 0.0
    for contact_index in range(count):
        contact = contacts[contact_index]
        max_depth = max(max_depth, -contact.gap)
        if contact.state == OPEN:
            continue
        normal_force, friction_force = contact.normal_force, contact.friction_force
        active_contacts += 1
        largest_force = max(largest_force, math.hypot(normal_force, friction_force))
        column = pairs_column + sample_layout.OF_PAIR * contact.pair
        arms = contact.disc_normal, contact.disc_tangent
        if contact.disc < 0:
            arms = contact.pin_normal, contact.pin_tangent
        row[column + sample_layout.FORCE_X] += normal_force * contact.nx - friction_force * contact.ny
        row[column + sample_layout.FORCE_Y] += normal_force * contact.ny + friction_force * contact.nx
        row[column + sample_layout.MOMENT] += normal_force * arms[0] + friction_force * arms[1]
        row[column + sample_layout.FRICTION_POWER] -= friction_force * contact.slip
        row[column + sample_layout.NORMAL_POWER] -= normal_force * contact.speed
    (
        row[solver_column + sample_layout.ACTIVE],
        row[solver_column + sample_layout.PENETRATION],
        row[solver_column + sample_layout.LARGEST_FORCE],
    ) = (
        active_contacts,
        max_depth,
        largest_force,
    )


@njit
def _write_shaft(
    system: System, shaft: int, unknown: int, q: Array, v: Array, command: Array, row: Array, column: int
) -> int:
    """Write angle [rad], speed [rad/s] and actuator torque [N m] of a shaft to a `row`; return the next column.

    They are written from `column` on. `system` is the reducer as arrays. `q` and `v` are all coordinates and their
    speeds, shape (unknowns,), `command` (2,) the commands of output and input. `shaft` is the index of the shaft in
    `command`, `unknown` that of its rotation in `q` and `v`.
    """
    stiffness, damping = system.servo[shaft, 0], system.servo[shaft, 1]
    torque = stiffness * (command[shaft] - q[unknown]) if stiffness != 0.0 else command[shaft]
    torque -= damping * v[unknown]
    row[column], row[column + 1], row[column + 2] = q[unknown], v[unknown], torque
    return column + 3


@njit
def _compute_energies(system: System, q: Array, v: Array, main_count: int) -> tuple[float, float]:
    """Compute the potential and the kinetic energy of all bodies [J].

    `q` and `v` (unknowns,) are the coordinates of all bodies [m], [rad] and their speeds [m/s], [rad/s], in the order
    that the module ``system`` describes. The first `main_count` unknowns are those of discs, sun, output and cranks;
    the others are those of moving pins.
    """
    gx, gy = system.gravity[0], system.gravity[1]
    potential, kinetic = 0.0, 0.0
    for unknown in range(main_count):
        kinetic += 0.5 * system.inertia[unknown] * v[unknown] * v[unknown]
    for body in range(0, 3 * system.bodies, 3):
        potential -= system.inertia[body] * (gx * q[body] + gy * q[body + 1])
    for unknown in range(len(system.support)):
        potential += 0.5 * system.support[unknown] * q[unknown] * q[unknown]
    for shaft in range(2):
        angle = q[system.shafts[shaft]]
        sine, cosine = math.sin(angle), math.cos(angle)
        moment_x, moment_y = system.unbalance[shaft, 0], system.unbalance[shaft, 1]
        potential -= gx * (cosine * moment_x - sine * moment_y) + gy * (sine * moment_x + cosine * moment_y)
    plane_count = len(system.pin_mass)
    for pin_unknown in range(main_count, len(q), 2 * plane_count + 1):
        translational_energy = 0.0
        for plane in range(plane_count):
            pin_x = pin_unknown + plane_shift(plane)
            for other_plane in range(plane_count):
                mass, other_pin_x = system.pin_mass[plane, other_plane], pin_unknown + plane_shift(other_plane)
                potential -= mass * (gx * q[other_pin_x] + gy * q[other_pin_x + 1])
                translational_energy += 0.5 * mass * (v[pin_x] * v[other_pin_x] + v[pin_x + 1] * v[other_pin_x + 1])
        kinetic += translational_energy + 0.5 * system.pin_inertia * v[pin_unknown + 2] ** 2
    return potential, kinetic
