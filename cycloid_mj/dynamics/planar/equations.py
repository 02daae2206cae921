"""A time step of the planar solver: implicit midpoint rule, solved by a semismooth Newton method.

With the speeds v at the midpoint of a step h, v0 at its start and the force f at the midpoint,

    2 M/h (v - v0) = f(q0 + h/2 v, v)

Contacts are searched at a predicted midpoint, and their forces are linear about it: a normal force N - S n v that never
pulls, friction -creep t v up to the Coulomb limit, and a geometric stiffness from the rotation of the normal as round
bodies roll in each other. The states of the contacts (open, sticking, sliding) change until none changes. Pins do not
touch each other: the block of each pin is condensed (Schur complement), which leaves discs, output and crank. If a step
is too long for the motion of pins within their clearance, the left side of pins is M/h (v - v0), implicit Euler, which
damps this motion.
"""

import math
from typing import NamedTuple

import numpy as np

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.dynamics.planar.contacts import (
    NONE,
    OPEN,
    SLIDES,
    SLIDES_BACK,
    STICKS,
    Contact,
    Contacts,
    friction_state,
    njit,
    plane_shift,
    relative_speeds,
    rolling_speed,
)
from cycloid_mj.dynamics.planar.settings import NEWTON
from cycloid_mj.dynamics.planar.system import System
from cycloid_mj.statics.kernel.newton import solve_linear

Nine = tuple[float, float, float, float, float, float, float, float, float]
"""A matrix of shape (3, 3), row by row."""


class Equations(NamedTuple):
    """Working memory of a step with N pins and n other unknowns.

    Attributes
    ----------
    matrix, rhs
        Equations of the other unknowns, shapes (n, n), (n,).
    pins, pin_rhs
        Diagonal blocks and right sides of the pins, shapes (w N, w), (w N,), with w unknowns of each pin.
    pin_columns, pin_rows
        Coupling blocks: columns of each pin in the other equations, and rows of the others in its own, shapes (n N, w),
        (w N, n).
    coupled
        Whether a pin touches a body that moves, shape (N,).
    settled
        Whether no contact of a pin has changed in this iteration, shape (N,).
    shaft_state
        States of the drags of output and input, as those of contacts, shape (2,).
    """

    matrix: Array
    rhs: Array
    pins: Array
    pin_rhs: Array
    pin_columns: Array
    pin_rows: Array
    coupled: Integers
    settled: Integers
    shaft_state: Integers


def allocate_equations(system: System) -> Equations:
    """Allocate the matrices and vectors of a step of the planar solver, for the reducer `system`."""
    main_count, pin_count, pin_width = (
        len(system.inertia),
        len(system.ring_centres) * system.free,
        2 * len(system.pin_mass) + 1,
    )
    return Equations(
        matrix=np.zeros((main_count, main_count)),
        rhs=np.zeros(main_count),
        pins=np.zeros((pin_width * pin_count, pin_width)),
        pin_rhs=np.zeros(pin_width * pin_count),
        pin_columns=np.zeros((main_count * pin_count, pin_width)),
        pin_rows=np.zeros((pin_width * pin_count, main_count)),
        coupled=np.zeros(pin_count, dtype=np.int64),
        settled=np.zeros(pin_count, dtype=np.int64),
        shaft_state=np.full(2, STICKS),
    )


@njit
def solve_step(
    system: System,
    contacts: Contacts,
    count: int,
    equations: Equations,
    q0: Array,
    v0: Array,
    predicted: Array,
    command: Array,
    timestep: float,
    pin_span: float,
    v: Array,
) -> int:
    """Solve a time step for the speeds at its midpoint, by a semismooth Newton method.

    Each iteration assembles the linear equations for the current contact states, condenses the pins, solves by Gaussian
    elimination and updates the states.

    Parameters
    ----------
    system, equations
        The reducer, and the workspace of a step.
    contacts, count
        Contacts and their number; their states and forces are updated.
    predicted
        Speeds of all unknowns that were expected at the midpoint, at which the contacts were linearised, shape
        (unknowns,).
    q0, v0
        Positions [m], [rad] and speeds [m/s], [rad/s] of all unknowns at the beginning of the step, shape (unknowns,):
        x, y and rotation of each disc, the rotations of output and crank, and x, y and rotation of each moving pin.
    command
        Commands of output and crank, shape (2,): the angle [rad] of a shaft with a servo, else its torque [N m].
    timestep
        Time step [s].
    pin_span
        Time [s] in which forces accelerate moving pins from v0 to v: half a step by the midpoint rule, or a full step
        by implicit Euler.
    v
        Array for the result: the midpoint speeds of all unknowns, shape (unknowns,).

    Returns
    -------
    int
        Number of Newton iterations; ``NEWTON.max_iterations`` + 1 if contact states still changed in the last of them.
    """
    for iterations in range(1, NEWTON.max_iterations + 1):
        change_all, couple_friction = iterations <= NEWTON.block_iterations, iterations <= NEWTON.coupled_iterations
        _assemble(system, contacts, count, equations, q0, v0, predicted, command, timestep, pin_span, couple_friction)
        _condense_pins(system, equations)
        solve_linear(equations.matrix, equations.rhs, equations.rhs, 0.0)
        main_count = len(equations.rhs)
        for unknown in range(main_count):
            v[unknown] = equations.rhs[unknown]
        _recover_pins(equations, v)
        if not _update_states(
            system, contacts, count, equations, predicted, v, 0.5 * timestep, change_all, couple_friction
        ):
            return iterations
    return NEWTON.max_iterations + 1


@njit
def _assemble(
    system: System,
    contacts: Contacts,
    count: int,
    equations: Equations,
    q0: Array,
    v0: Array,
    predicted: Array,
    command: Array,
    timestep: float,
    pin_span: float,
    coupled_friction: bool,
) -> None:
    """Assemble the linear equations of a Newton iteration: inertia, gravity, servos, drags and contacts.

    They are written to `equations`; `system` is the reducer as arrays. `count` is the number of `contacts`. `q0` and
    `v0` (unknowns,) are all coordinates and their speeds at the beginning of the step, `predicted` (unknowns,) are the
    midpoint speeds at which the contacts were linearised. `command` (2,) are the commands of output and crank,
    `timestep` is in [s], and `pin_span` is the time [s] in which forces accelerate pins, see `solve_step`. Sliding
    friction is in proportion to the normal force of this iteration if `coupled_friction`, else of the previous
    iteration.
    """
    matrix, rhs = equations.matrix, equations.rhs
    pin_blocks, pin_rhs = equations.pins, equations.pin_rhs
    main_count, half_step = len(rhs), 0.5 * timestep
    for unknown in range(main_count):
        for column in range(main_count):
            matrix[unknown, column] = 0.0
        matrix[unknown, unknown] = system.inertia[unknown] / half_step
        rhs[unknown] = matrix[unknown, unknown] * v0[unknown]
    gx, gy = system.gravity[0], system.gravity[1]
    for body in range(0, 3 * system.bodies, 3):
        rhs[body] += system.inertia[body] * gx
        rhs[body + 1] += system.inertia[body] * gy
    for unknown in range(len(system.support)):
        matrix[unknown, unknown] += system.support[unknown] * half_step
        rhs[unknown] -= system.support[unknown] * q0[unknown]
    for shaft in range(2):
        _add_shaft_torques(system, equations, shaft, q0, predicted, command[shaft], half_step)
    coupled, pin_columns, pin_rows = equations.coupled, equations.pin_columns, equations.pin_rows
    pin_width = pin_blocks.shape[1]
    for pin in range(len(coupled)):
        pin_unknown, row = main_count + pin_width * pin, pin_width * pin
        for pin_equation in range(row, row + pin_width):
            pin_rhs[pin_equation] = 0.0
            for column in range(pin_width):
                pin_blocks[pin_equation, column] = 0.0
        _add_pin_inertia(system, equations, v0, row, pin_unknown, pin_span)
        if coupled[pin]:
            for pin_equation in range(pin_width):
                for column in range(main_count):
                    pin_columns[main_count * pin + column, pin_equation] = 0.0
                    pin_rows[row + pin_equation, column] = 0.0
            coupled[pin] = 0
    _add_contacts(contacts, count, equations, predicted, coupled_friction)


@njit
def _add_shaft_torques(
    system: System, equations: Equations, shaft: int, q0: Array, predicted: Array, command: float, half_step: float
) -> None:
    """Add unbalance, servo and drag of the output (`shaft` 0) or the input (1) to the equations.

    `system` is the reducer as arrays. `q0` are all coordinates at the beginning of the step, `predicted` their speeds
    at its middle, shape (unknowns,). `command` is the angle [rad] that the servo has to keep, or the torque [N m] of a
    shaft without servo, and `half_step` half of the time step [s].
    """
    matrix, rhs, unknown = equations.matrix, equations.rhs, system.shafts[shaft]
    moment_x, moment_y = system.unbalance[shaft, 0], system.unbalance[shaft, 1]
    if moment_x != 0.0 or moment_y != 0.0:
        angle = q0[unknown] + half_step * predicted[unknown]
        sine, cosine = math.sin(angle), math.cos(angle)
        rhs[unknown] += (cosine * moment_x - sine * moment_y) * system.gravity[1] - (
            sine * moment_x + cosine * moment_y
        ) * system.gravity[0]
    stiffness, damping = system.servo[shaft, 0], system.servo[shaft, 1]
    matrix[unknown, unknown] += stiffness * half_step + damping
    rhs[unknown] += stiffness * (command - q0[unknown]) if stiffness != 0.0 else command
    limit = system.drag[shaft, 0]
    if limit > 0.0:
        if equations.shaft_state[shaft] == STICKS:
            matrix[unknown, unknown] += system.drag[shaft, 1]
        else:
            rhs[unknown] -= limit if equations.shaft_state[shaft] == SLIDES else -limit


@njit
def _add_pin_inertia(
    system: System, equations: Equations, v0: Array, row: int, pin_unknown: int, pin_span: float
) -> None:
    """Add inertia and gravity of a pin to its block of the equations, whose first row is `row`.

    `system` is the reducer as arrays. `pin_unknown` is the index of its first unknown, `v0` (unknowns,) are the speeds
    of all coordinates at the beginning of the step, and `pin_span` is the time [s] in which forces accelerate pins, see
    `solve_step`.
    """
    pin_blocks, pin_rhs, gx, gy = equations.pins, equations.pin_rhs, system.gravity[0], system.gravity[1]
    for plane in range(len(system.pin_mass)):
        x_offset = plane_shift(plane)
        for other_plane in range(len(system.pin_mass)):
            mass, other_x_offset = system.pin_mass[plane, other_plane], plane_shift(other_plane)
            pin_blocks[row + x_offset, other_x_offset], pin_blocks[row + x_offset + 1, other_x_offset + 1] = (
                mass / pin_span,
                mass / pin_span,
            )
            pin_rhs[row + x_offset] += mass / pin_span * v0[pin_unknown + other_x_offset] + mass * gx
            pin_rhs[row + x_offset + 1] += mass / pin_span * v0[pin_unknown + other_x_offset + 1] + mass * gy
    pin_blocks[row + 2, 2] = system.pin_inertia / pin_span
    pin_rhs[row + 2] = system.pin_inertia / pin_span * v0[pin_unknown + 2]


class LeverArms(NamedTuple):
    """Effect of a contact on the three unknowns of a body, and of these on the contact.

    Attributes
    ----------
    pushed
        Generalised force per normal force, with the friction of a sliding contact.
    normal, tangent, centre
        Motion of the contact point along normal and tangent, and of the centre of a round surface along the tangent,
        per speed of each unknown.
    """

    pushed: tuple[float, float, float]
    normal: tuple[float, float, float]
    tangent: tuple[float, float, float]
    centre: tuple[float, float, float]


class Tangent(NamedTuple):
    """Linearised force of a contact.

    Attributes
    ----------
    force, slope
        Normal force at zero speed [N], and its decrease with the speed along the normal [N s/m].
    sliding, creep
        Friction per normal force [1] of a sliding contact, and per speed [N s/m] of a sticking one.
    friction
        Friction force that does not depend on the unknowns [N].
    geometric, rolling_force
        Tangential force per speed of the centres [N s/m], and that at the predicted speeds [N].
    """

    force: float
    slope: float
    sliding: float
    creep: float
    friction: float
    geometric: float
    rolling_force: float


@njit
def _lever_arms(
    contact: Contact, sign: float, normal: float, tangent: float, centre: float, friction: float
) -> LeverArms:
    """Return two sets of factors for one body, each with a factor for its unknowns x, y and rotation (`LeverArms`).

    One set converts the normal force of a contact to force and torque on the body. The other converts the body's
    speeds to the speeds of the contact along the normal (nx, ny) and along the tangent (-ny, nx), and to the tangential
    speed of the centre of a round surface.

    Parameters
    ----------
    contact
        The contact, for its unit normal.
    sign
        Sign with which the motion of the body counts in the relative speed of both bodies, 1 or -1.
    normal, tangent
        Displacement of the contact point along normal and tangent per rotation of the body [m].
    centre
        Displacement of the centre of the round surface along the tangent per rotation of the body [m].
    friction
        Friction force per normal force [1] of a sliding contact; 0 if the contact sticks.
    """
    nx, ny = contact.nx, contact.ny
    normal_arms, tangent_arms = (sign * nx, sign * ny, sign * normal), (-sign * ny, sign * nx, sign * tangent)
    push_arms = (
        normal_arms[0] - friction * tangent_arms[0],
        normal_arms[1] - friction * tangent_arms[1],
        normal_arms[2] - friction * tangent_arms[2],
    )
    return LeverArms(push_arms, normal_arms, tangent_arms, (tangent_arms[0], tangent_arms[1], sign * centre))


@njit
def _linearise_force(contact: Contact, predicted: Array, coupled_friction: bool) -> Tangent:
    """Return the force of a contact as a linear function of the speeds, for its current state (sticking or sliding).

    `predicted` (unknowns,) are the midpoint speeds at which the contact was linearised. Sliding friction is in
    proportion to the normal force of this iteration if `coupled_friction`, else of the previous iteration.
    """
    roll_stiffness, force = contact.geometric_stiffness * contact.normal_force, contact.force
    rolling_force = roll_stiffness * rolling_speed(contact, predicted)
    if contact.state == STICKS:
        return Tangent(force, contact.slope, 0.0, contact.creep, 0.0, roll_stiffness, rolling_force)
    sliding = contact.friction if contact.state == SLIDES else -contact.friction
    if coupled_friction:
        return Tangent(force, contact.slope, sliding, 0.0, 0.0, roll_stiffness, rolling_force)
    return Tangent(force, contact.slope, 0.0, 0.0, sliding * contact.normal_force, roll_stiffness, rolling_force)


@njit
def _add_contacts(
    contacts: Contacts, count: int, equations: Equations, predicted: Array, coupled_friction: bool
) -> None:
    """Add the forces of all closed contacts, among the first `count`, to the equations of their bodies.

    `predicted` (unknowns,) are the midpoint speeds at which the contacts were linearised. Sliding friction is in
    proportion to the normal force of this iteration if `coupled_friction`, else of the previous iteration.
    """
    for i in range(count):
        if contacts[i].state != OPEN:
            _add_contact(contacts[i], _linearise_force(contacts[i], predicted, coupled_friction), equations)


@njit
def _add_contact(contact: Contact, tangent: Tangent, equations: Equations) -> None:
    """Add the force of a contact, and its derivatives with respect to the speeds, to the equations of its bodies.

    These are disc, pin, shaft and crank, as far as the contact has them. `tangent` is the force as a linear function of
    the speeds.
    """
    matrix, rhs, pin_columns, pin_rows = equations.matrix, equations.rhs, equations.pin_columns, equations.pin_rows
    main_count, disc, pin_unknown, sliding = len(rhs), contact.disc, contact.pin, tangent.sliding
    shaft, crank = contact.shaft, contact.crank
    shaft_arms = _shaft_arms(contact.shaft_normal, contact.shaft_tangent, contact.shaft_centre, sliding)
    crank_arms = _shaft_arms(contact.crank_normal, contact.crank_tangent, contact.crank_centre, sliding)
    pin_width, shift = equations.pins.shape[1], contact.pin_shift
    pin_index = (pin_unknown - main_count) // pin_width
    pin_row, column_row = pin_width * pin_index, main_count * pin_index
    if pin_unknown >= 0 and (disc >= 0 or shaft >= 0):
        equations.coupled[pin_index] = 1
    if disc >= 0:
        body = _lever_arms(contact, 1.0, contact.disc_normal, contact.disc_tangent, contact.disc_centre, sliding)
        _add_force_derivative(matrix, disc, disc, body, body, tangent, NONE, NONE)
        _add_force(rhs, disc, body, tangent, NONE)
        if shaft >= 0:
            _couple_shaft(shaft_arms, tangent, body, matrix, disc, shaft, matrix, shaft, disc, NONE)
        if crank >= 0:
            _couple_shaft(crank_arms, tangent, body, matrix, disc, crank, matrix, crank, disc, NONE)
        if pin_unknown >= 0:
            pin_arms = _lever_arms(contact, -1.0, contact.pin_normal, contact.pin_tangent, 0.0, sliding)
            _add_force_derivative(pin_rows, pin_row, disc, pin_arms, body, tangent, shift, NONE)
            _add_force_derivative(pin_columns, column_row + disc, 0, body, pin_arms, tangent, NONE, shift)
    if pin_unknown >= 0:
        body = _lever_arms(contact, contact.side, contact.pin_normal, contact.pin_tangent, 0.0, sliding)
        _add_force_derivative(equations.pins, pin_row, 0, body, body, tangent, shift, shift)
        _add_force(equations.pin_rhs, pin_row, body, tangent, shift)
        if shaft >= 0:
            shaft_row = column_row + shaft
            _couple_shaft(shaft_arms, tangent, body, pin_rows, pin_row, shaft, pin_columns, shaft_row, 0, shift)
    if shaft >= 0:
        _add_shaft(matrix, rhs, shaft, shaft_arms, tangent)
    if crank >= 0:
        _add_shaft(matrix, rhs, crank, crank_arms, tangent)
        if shaft >= 0:
            matrix[shaft, crank] += _shaft_slope(shaft_arms, crank_arms, tangent)
            matrix[crank, shaft] += _shaft_slope(crank_arms, shaft_arms, tangent)


class ShaftArms(NamedTuple):
    """Effect of a contact on a shaft's rotation, and of this on the contact, as in `LeverArms`."""

    pushed: float
    normal: float
    tangent: float
    centre: float


@njit
def _shaft_arms(normal: float, tangent: float, centre: float, sliding: float) -> ShaftArms:
    """Return the effect of a contact on a shaft, from its lever arms [m] and the friction per normal force."""
    return ShaftArms(normal - sliding * tangent, normal, tangent, centre)


@njit
def _shaft_slope(loaded_shaft: ShaftArms, other: ShaftArms, tangent: Tangent) -> float:
    """Return the decrease of the torque on `loaded_shaft` [N m] per speed [rad/s] of `other`, which may be the same."""
    return (
        tangent.slope * loaded_shaft.pushed * other.normal
        + tangent.creep * loaded_shaft.tangent * other.tangent
        + tangent.geometric * loaded_shaft.centre * other.centre
    )


@njit
def _add_shaft(matrix: Array, rhs: Array, shaft: int, arms: ShaftArms, tangent: Tangent) -> None:
    """Add the torque of a contact on a shaft, and its derivative by the shaft's own speed."""
    rhs[shaft] += tangent.force * arms.pushed + tangent.rolling_force * arms.centre - tangent.friction * arms.tangent
    matrix[shaft, shaft] += _shaft_slope(arms, arms, tangent)


@njit
def _add_force(rhs: Array, first_row: int, arms: LeverArms, tangent: Tangent, shift: int) -> None:
    """Add the contact force at the predicted speeds to the right side `rhs` (n,) of the equations of motion of a body.

    `arms` are the lever arms of the contact about the body, `tangent` is the contact force as a linear function of the
    speeds. The rows of x, y and rotation are `first_row` + `shift`, the next row, and `first_row` + 2.
    """
    for component in range(3):
        rhs[first_row + component + (shift if component < 2 else 0)] += (
            tangent.force * arms.pushed[component]
            + tangent.rolling_force * arms.centre[component]
            - tangent.friction * arms.tangent[component]
        )


@njit
def _add_force_derivative(
    target: Array,
    row: int,
    column: int,
    loaded_body: LeverArms,
    moving_body: LeverArms,
    tangent: Tangent,
    row_shift: int,
    column_shift: int,
) -> None:
    """Add the derivative of a contact's force on one body with respect to the speeds of another to the matrix `target`.

    It is a block for x, y and rotation of both bodies. Its rows are `row` + `row_shift`, the next, and `row` + 2, its
    columns `column` + `column_shift`, the next, and `column` + 2. `loaded_body` and `moving_body` are the lever arms of
    the contact about both bodies, which may be the same. `tangent` is the contact force as a linear function of the
    speeds.
    """
    for i in range(3):
        normal_term, creep_term, roll_term = (
            tangent.slope * loaded_body.pushed[i],
            tangent.creep * loaded_body.tangent[i],
            tangent.geometric * loaded_body.centre[i],
        )
        for j in range(3):
            target[row + i + (row_shift if i < 2 else 0), column + j + (column_shift if j < 2 else 0)] += (
                normal_term * moving_body.normal[j]
                + creep_term * moving_body.tangent[j]
                + roll_term * moving_body.centre[j]
            )


@njit
def _couple_shaft(
    arms: ShaftArms,
    tangent: Tangent,
    body: LeverArms,
    column_block: Array,
    row: int,
    column: int,
    row_block: Array,
    shaft_row: int,
    first_column: int,
    shift: int,
) -> None:
    """Add the derivatives by which a contact couples a body and a shaft to two blocks of the matrix of equations.

    The derivative of the body's force with respect to the shaft's speed is added to `column` of the matrix
    `column_block`: for x, y and rotation in the rows `row` + `shift`, the next, and `row` + 2. That of the shaft's
    torque with respect to the body's speeds is added to `shaft_row` of the matrix `row_block`, in the columns
    `first_column` + `shift`, the next, and `first_column` + 2. `arms` and `body` are the lever arms of the contact
    about shaft and body, `tangent` is the contact force as a linear function of the speeds.
    """
    for i in range(3):
        creep_term, roll_term = tangent.creep * body.tangent[i], tangent.geometric * body.centre[i]
        index = i + (shift if i < 2 else 0)
        column_block[row + index, column] += (
            tangent.slope * body.pushed[i] * arms.normal + creep_term * arms.tangent + roll_term * arms.centre
        )
        row_block[shaft_row, first_column + index] += (
            tangent.slope * arms.pushed * body.normal[i] + creep_term * arms.tangent + roll_term * arms.centre
        )


@njit
def _condense_pins(system: System, equations: Equations) -> None:
    """Eliminate the unknowns of every pin from the equations of the other unknowns (Schur complement), in place.

    `system` is the reducer as arrays. For `_recover_pins`, `pin_rhs` and `pin_rows` of the equations are multiplied by
    the inverse of each pin's own block.
    """
    if equations.pins.shape[1] > 3:
        _condense_tilting_pins(system, equations)
        return
    matrix, rhs, pin_blocks, pin_rhs = equations.matrix, equations.rhs, equations.pins, equations.pin_rhs
    pin_columns, pin_rows, coupled = equations.pin_columns, equations.pin_rows, equations.coupled
    main_count = len(rhs)
    coupled_size = max(3 * len(system.offset), system.ring_shaft + 1)
    for pin in range(len(coupled)):
        pin_row, column_row = 3 * pin, main_count * pin
        inverse = _invert_block(pin_blocks, pin_row)
        speed_x, speed_y, spin = _multiply(inverse, pin_rhs[pin_row], pin_rhs[pin_row + 1], pin_rhs[pin_row + 2])
        pin_rhs[pin_row], pin_rhs[pin_row + 1], pin_rhs[pin_row + 2] = speed_x, speed_y, spin
        if not coupled[pin]:
            continue
        for unknown in range(coupled_size):
            pin_rows[pin_row, unknown], pin_rows[pin_row + 1, unknown], pin_rows[pin_row + 2, unknown] = _multiply(
                inverse, pin_rows[pin_row, unknown], pin_rows[pin_row + 1, unknown], pin_rows[pin_row + 2, unknown]
            )
        for equation in range(coupled_size):
            factor_x, factor_y, factor_spin = (
                pin_columns[column_row + equation, 0],
                pin_columns[column_row + equation, 1],
                pin_columns[column_row + equation, 2],
            )
            if factor_x == 0.0 and factor_y == 0.0 and factor_spin == 0.0:
                continue
            rhs[equation] -= factor_x * speed_x + factor_y * speed_y + factor_spin * spin
            for unknown in range(coupled_size):
                matrix[equation, unknown] -= (
                    factor_x * pin_rows[pin_row, unknown]
                    + factor_y * pin_rows[pin_row + 1, unknown]
                    + factor_spin * pin_rows[pin_row + 2, unknown]
                )


@njit
def _condense_tilting_pins(system: System, equations: Equations) -> None:
    """Eliminate the unknowns of pins in several planes from the `equations` by Gauss-Jordan elimination, in place.

    This is `_condense_pins` for tilting pins; there is no pivoting. The block of a pin is its positive definite mass
    matrix with the slopes of its contacts. `system` is the reducer as arrays.
    """
    matrix, rhs, pin_blocks, pin_rhs = equations.matrix, equations.rhs, equations.pins, equations.pin_rhs
    pin_columns, pin_rows, coupled = equations.pin_columns, equations.pin_rows, equations.coupled
    main_count, pin_width = len(rhs), pin_blocks.shape[1]
    coupled_size = max(3 * len(system.offset), system.ring_shaft + 1)
    for pin in range(len(coupled)):
        pin_row, column_row = pin_width * pin, main_count * pin
        column_count = coupled_size if coupled[pin] else 0
        for pivot in range(pin_width):
            scale = 1.0 / pin_blocks[pin_row + pivot, pivot]
            _scale_row(pin_blocks, pin_row + pivot, scale, pin_width)
            _scale_row(pin_rows, pin_row + pivot, scale, column_count)
            pin_rhs[pin_row + pivot] *= scale
            for row in range(pin_width):
                factor = pin_blocks[pin_row + row, pivot]
                if row == pivot or factor == 0.0:
                    continue
                _subtract_row(pin_blocks, pin_row + row, pin_row + pivot, factor, pin_width)
                _subtract_row(pin_rows, pin_row + row, pin_row + pivot, factor, column_count)
                pin_rhs[pin_row + row] -= factor * pin_rhs[pin_row + pivot]
        for equation in range(column_count):
            for pin_equation in range(pin_width):
                factor = pin_columns[column_row + equation, pin_equation]
                if factor == 0.0:
                    continue
                rhs[equation] -= factor * pin_rhs[pin_row + pin_equation]
                for unknown in range(column_count):
                    matrix[equation, unknown] -= factor * pin_rows[pin_row + pin_equation, unknown]


@njit
def _scale_row(matrix: Array, row: int, factor: float, column_count: int) -> None:
    for column in range(column_count):
        matrix[row, column] *= factor


@njit
def _subtract_row(matrix: Array, row: int, other_row: int, factor: float, column_count: int) -> None:
    for column in range(column_count):
        matrix[row, column] -= factor * matrix[other_row, column]


@njit
def _multiply(matrix: Nine, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return the product of a matrix and a vector."""
    return (
        matrix[0] * x + matrix[1] * y + matrix[2] * z,
        matrix[3] * x + matrix[4] * y + matrix[5] * z,
        matrix[6] * x + matrix[7] * y + matrix[8] * z,
    )


@njit
def _invert_block(matrix: Array, row: int) -> Nine:
    """Return the inverse of a (3, 3) matrix, row by row, by cofactors.

    The matrix that is inverted consists of the three rows of `matrix` (..., 3) from `row` on.
    """
    a, b, c = matrix[row, 0], matrix[row, 1], matrix[row, 2]
    d, e, f = matrix[row + 1, 0], matrix[row + 1, 1], matrix[row + 1, 2]
    g, h, i = matrix[row + 2, 0], matrix[row + 2, 1], matrix[row + 2, 2]
    x, y, z = e * i - f * h, f * g - d * i, d * h - e * g
    inverse_determinant = 1.0 / (a * x + b * y + c * z)
    return (
        x * inverse_determinant,
        (c * h - b * i) * inverse_determinant,
        (b * f - c * e) * inverse_determinant,
        y * inverse_determinant,
        (a * i - c * g) * inverse_determinant,
        (c * d - a * f) * inverse_determinant,
        z * inverse_determinant,
        (b * g - a * h) * inverse_determinant,
        (a * e - b * d) * inverse_determinant,
    )


@njit
def _recover_pins(equations: Equations, v: Array) -> None:
    """Compute the speeds of the pins in `v` (unknowns,) from its other speeds, after `_condense_pins` eliminated them.

    `equations` has the products with the inverse of each pin's block that the elimination leaves.
    """
    coupled, pin_rows, pin_rhs = equations.coupled, equations.pin_rows, equations.pin_rhs
    main_count, pin_width = len(equations.rhs), equations.pins.shape[1]
    for pin in range(len(coupled)):
        for component in range(pin_width):
            speed = pin_rhs[pin_width * pin + component]
            if coupled[pin]:
                for unknown in range(main_count):
                    speed -= pin_rows[pin_width * pin + component, unknown] * v[unknown]
            v[main_count + pin_width * pin + component] = speed


@njit
def _update_states(
    system: System,
    contacts: Contacts,
    count: int,
    equations: Equations,
    predicted: Array,
    v: Array,
    half_step: float,
    change_all: bool,
    coupled_friction: bool,
) -> bool:
    """Compute the contact forces at speeds `v`, update the contact states, and return whether a state has changed.

    A contact is open, sticks, or slides to either side; a shaft with drag sticks or slides. At most one contact of each
    moving pin changes its state per call, the first that has to. Of all other contacts and the shafts, only one changes
    its state, or with `change_all` every one that has to. Without `coupled_friction`, the result is also True while the
    normal force of a sliding contact changes by more than `NEWTON.friction_rtol` of the largest force. `system` and
    `equations` are the arrays of reducer and step. `v` (unknowns,) are the speeds of the solution, `predicted`
    (unknowns,) the midpoint speeds at which the `count` contacts were linearised, and `half_step` is half of the time
    step [s].
    """
    has_changed, no_other_changed, largest_force, largest_change = False, True, 0.0, 0.0
    main_count, pin_width, no_change = len(equations.rhs), equations.pins.shape[1], equations.settled
    for i in range(len(no_change)):
        no_change[i] = 1
    for i in range(count):
        contact = contacts[i]
        old_state, old_force, pin = contact.state, contact.normal_force, (contact.pin - main_count) // pin_width
        one_at_a_time = pin >= 0 or not change_all
        normal_force = _update_forces(contact, predicted, v, half_step)
        largest_force = max(largest_force, contact.normal_force)
        if old_state in (SLIDES, SLIDES_BACK):
            largest_change = max(largest_change, abs(contact.normal_force - old_force))
        new_state = _next_state(contact, normal_force, one_at_a_time, coupled_friction)
        if new_state == old_state:
            continue
        has_changed = True
        if not one_at_a_time or (no_change[pin] if pin >= 0 else no_other_changed):
            contact.state = new_state
        if pin >= 0:
            no_change[pin] = 0
        else:
            no_other_changed = False
    for shaft in range(2):
        limit = system.drag[shaft, 0]
        if limit > 0.0:
            speed = v[system.shafts[shaft]]
            new_state = STICKS
            if system.drag[shaft, 1] * abs(speed) > limit:
                new_state = SLIDES if speed > 0.0 else SLIDES_BACK
            if new_state != equations.shaft_state[shaft] and (change_all or no_other_changed):
                equations.shaft_state[shaft] = new_state
                has_changed, no_other_changed = True, False
    return has_changed or (not coupled_friction and largest_change > NEWTON.friction_rtol * largest_force)


@njit
def _update_forces(contact: Contact, predicted: Array, v: Array, half_step: float) -> float:
    """Update a contact's speeds [m/s] and forces [N], in place; return its normal force, which is negative if it pulls.

    `v` (unknowns,) are the new midpoint speeds of all coordinates, `predicted` those at which the contact was
    linearised, and `half_step` is half of the time step [s]. An open contact has a force if its gap at the midpoint is
    below 0. The friction force opposes the slip: it is the slip times the contact's `creep` [N s/m], limited to the
    friction coefficient times the normal force.
    """
    contact.speed, contact.slip = relative_speeds(contact, v)
    normal_force = contact.force - contact.slope * contact.speed
    if contact.state == OPEN:
        gap = contact.gap + half_step * (contact.speed - relative_speeds(contact, predicted)[0])
        if gap >= 0.0:
            normal_force = 0.0
    contact.normal_force, contact.friction_force = max(normal_force, 0.0), 0.0
    if normal_force > 0.0:
        limit = contact.friction * normal_force
        contact.friction_force = -max(-limit, min(limit, contact.creep * contact.slip))
    return normal_force


@njit
def _next_state(contact: Contact, normal_force: float, one_at_a_time: bool, coupled_friction: bool) -> int:
    """Return the state of a contact that follows from its forces and slip: open, sticking, or sliding to either side.

    `normal_force` [N] may be negative. `one_at_a_time` is whether only one contact changes its state per iteration,
    `coupled_friction` whether sliding friction is in proportion to the normal force of this iteration.
    """
    old_state = contact.state
    if (old_state == SLIDES and contact.slip < 0.0) or (old_state == SLIDES_BACK and contact.slip > 0.0):
        return STICKS  # a contact that reverses comes to rest first, even if the previous friction opens it
    if normal_force > 0.0:
        if old_state == OPEN and not coupled_friction:
            return STICKS  # the normal force of an open contact is no measure of friction
        return friction_state(contact, contact.slip)
    if old_state == STICKS and one_at_a_time and contact.friction > 0.0:
        return SLIDES if contact.slip > 0.0 else SLIDES_BACK  # creep alone may open a contact that is pressed
    return OPEN
