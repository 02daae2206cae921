"""One time step of the planar solver: implicit midpoint rule, solved by a semismooth Newton method.

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
    OPEN,
    SLIDES,
    SLIDES_BACK,
    STICKS,
    Contact,
    Contacts,
    friction_state,
    njit,
    rolling,
    speeds,
)
from cycloid_mj.dynamics.planar.settings import NEWTON
from cycloid_mj.dynamics.planar.system import System
from cycloid_mj.statics.kernel.newton import solve_linear as gauss

Nine = tuple[float, float, float, float, float, float, float, float, float]
"""A matrix of shape (3, 3), row by row."""


class Equations(NamedTuple):
    """Working memory of a step with N pins and n other unknowns.

    Attributes
    ----------
    matrix, right
        Equations of the other unknowns, shapes (n, n), (n,).
    pins, pins_right
        Diagonal blocks and right sides of the pins, shapes (3 N, 3), (3 N,).
    pin_columns, pin_rows
        Coupling blocks: columns of each pin in the other equations, and rows of the others in its own, shapes (n N, 3),
        (3 N, n).
    coupled
        Whether a pin touches a body that moves, shape (N,).
    settled
        Whether no contact of a pin has changed in this iteration, shape (N,).
    shaft_state
        States of the drags of output and crank, as those of contacts, shape (2,).
    """

    matrix: Array
    right: Array
    pins: Array
    pins_right: Array
    pin_columns: Array
    pin_rows: Array
    coupled: Integers
    settled: Integers
    shaft_state: Integers


def allocate_equations(system: System) -> Equations:
    """Return the working memory for a reducer."""
    size, pins = len(system.inertia), len(system.place) * system.free
    return Equations(
        matrix=np.zeros((size, size)),
        right=np.zeros(size),
        pins=np.zeros((3 * pins, 3)),
        pins_right=np.zeros(3 * pins),
        pin_columns=np.zeros((size * pins, 3)),
        pin_rows=np.zeros((3 * pins, size)),
        coupled=np.zeros(pins, dtype=np.int64),
        settled=np.zeros(pins, dtype=np.int64),
        shaft_state=np.full(2, STICKS),
    )


@njit
def solve(
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
    """Solve a time step [s] from pose q0 and speeds v0 for the midpoint speeds, which are written to v.

    Parameters
    ----------
    contacts, count
        Contacts, and their number, at the `predicted` midpoint speeds.
    command
        Commands of output and crank: an angle [rad] or a torque [N m].
    pin_span
        Time [s] in which forces accelerate pins from v0 to v: half a step, or a full step by implicit Euler.

    Returns
    -------
    int
        Number of Newton iterations; ``NEWTON.max_iterations`` + 1 if contact states still changed in the last one.
    """
    for iterations in range(1, NEWTON.max_iterations + 1):
        all_change, coupled = iterations <= NEWTON.block_iterations, iterations <= NEWTON.coupled_iterations
        _assemble(system, contacts, count, equations, q0, v0, predicted, command, timestep, pin_span, coupled)
        _condense_pins(system, equations)
        gauss(equations.matrix, equations.right, equations.right, 0.0)
        size = len(equations.right)
        for i in range(size):
            v[i] = equations.right[i]
        _recover_pins(equations, v)
        if not _update_states(system, contacts, count, equations, predicted, v, 0.5 * timestep, all_change, coupled):
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
    """Assemble the linear equations of an iteration: inertia, gravity, servos, drags and contacts."""
    matrix, right = equations.matrix, equations.right
    pins, pins_right = equations.pins, equations.pins_right
    size, half = len(right), 0.5 * timestep
    for i in range(size):
        for k in range(size):
            matrix[i, k] = 0.0
        matrix[i, i] = system.inertia[i] / half
        right[i] = matrix[i, i] * v0[i]
    gx, gy = system.gravity[0], system.gravity[1]
    for body in range(0, size - 2, 3):
        right[body] += system.inertia[body] * gx
        right[body + 1] += system.inertia[body] * gy
    for shaft in range(2):
        i = size - 2 + shaft
        mx, my = system.unbalance[shaft, 0], system.unbalance[shaft, 1]
        if mx != 0.0 or my != 0.0:
            turn = q0[i] + half * predicted[i]
            s, c = math.sin(turn), math.cos(turn)
            right[i] += (c * mx - s * my) * gy - (s * mx + c * my) * gx
        stiffness, damping = system.servo[shaft, 0], system.servo[shaft, 1]
        matrix[i, i] += stiffness * half + damping
        right[i] += stiffness * (command[shaft] - q0[i]) if stiffness != 0.0 else command[shaft]
        limit = system.drag[shaft, 0]
        if limit > 0.0:
            if equations.shaft_state[shaft] == STICKS:
                matrix[i, i] += system.drag[shaft, 1]
            else:
                right[i] -= limit if equations.shaft_state[shaft] == SLIDES else -limit
    coupled, pin_columns, pin_rows = equations.coupled, equations.pin_columns, equations.pin_rows
    mass, inertia = system.pin[0], system.pin[1]
    for i in range(len(coupled)):
        own, first = size + 3 * i, 3 * i
        for m in range(first, first + 3):
            for k in range(3):
                pins[m, k] = 0.0
        pins[first, 0], pins[first + 1, 1], pins[first + 2, 2] = mass / pin_span, mass / pin_span, inertia / pin_span
        pins_right[first] = mass / pin_span * v0[own] + mass * gx
        pins_right[first + 1] = mass / pin_span * v0[own + 1] + mass * gy
        pins_right[first + 2] = inertia / pin_span * v0[own + 2]
        if coupled[i]:
            for m in range(3):
                for k in range(size):
                    pin_columns[size * i + k, m] = 0.0
                    pin_rows[first + m, k] = 0.0
            coupled[i] = 0
    _add_contacts(contacts, count, equations, predicted, coupled_friction)


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
    contact: Contact, sign: float, normal: float, tangent: float, centre: float, sliding: float
) -> LeverArms:
    """Return the lever arms of a body that moves with a sign in the relative speed."""
    nx, ny = contact.nx, contact.ny
    along, aside = (sign * nx, sign * ny, sign * normal), (-sign * ny, sign * nx, sign * tangent)
    pushed = (along[0] - sliding * aside[0], along[1] - sliding * aside[1], along[2] - sliding * aside[2])
    return LeverArms(pushed, along, aside, (aside[0], aside[1], sign * centre))


@njit
def _tangent(contact: Contact, predicted: Array, coupled_friction: bool) -> Tangent:
    """Linearise the force of a contact in its state."""
    geometric, force = contact.geometric_stiffness * contact.normal_force, contact.force
    rolling_force = geometric * rolling(contact, predicted)
    if contact.state == STICKS:
        return Tangent(force, contact.slope, 0.0, contact.creep, 0.0, geometric, rolling_force)
    sliding = contact.friction if contact.state == SLIDES else -contact.friction
    if coupled_friction:
        return Tangent(force, contact.slope, sliding, 0.0, 0.0, geometric, rolling_force)
    return Tangent(force, contact.slope, 0.0, 0.0, sliding * contact.normal_force, geometric, rolling_force)


@njit
def _add_contacts(
    contacts: Contacts, count: int, equations: Equations, predicted: Array, coupled_friction: bool
) -> None:
    """Add the forces of closed contacts to the equations of their bodies.

    If friction is not coupled to the normal force, it follows the `normal_force` of the previous iteration.
    """
    for k in range(count):
        if contacts[k].state != OPEN:
            _add_contact(contacts[k], _tangent(contacts[k], predicted, coupled_friction), equations)


@njit
def _add_contact(contact: Contact, tangent: Tangent, equations: Equations) -> None:
    """Add the force of a contact and its derivatives to the equations of disc, pin and shaft."""
    matrix, right, pin_columns, pin_rows = equations.matrix, equations.right, equations.pin_columns, equations.pin_rows
    size, disc, own, shaft, sliding = len(right), contact.disc, contact.pin, contact.shaft, tangent.sliding
    number = (own - size) // 3
    pin, others = 3 * number, size * number
    if own >= 0 and (disc >= 0 or shaft >= 0):
        equations.coupled[number] = 1
    if disc >= 0:
        side = _lever_arms(contact, 1.0, contact.disc_normal, contact.disc_tangent, contact.disc_centre, sliding)
        _add_block(matrix, disc, disc, side, side, tangent)
        _add_force(right, disc, side, tangent)
        if shaft >= 0:
            _couple_shaft(contact, tangent, side, matrix, disc, shaft, matrix, shaft, disc)
        if own >= 0:
            other = _lever_arms(contact, -1.0, contact.pin_normal, contact.pin_tangent, 0.0, sliding)
            _add_block(pin_rows, pin, disc, other, side, tangent)
            _add_block(pin_columns, others + disc, 0, side, other, tangent)
    if own >= 0:
        side = _lever_arms(contact, contact.side, contact.pin_normal, contact.pin_tangent, 0.0, sliding)
        _add_block(equations.pins, pin, 0, side, side, tangent)
        _add_force(equations.pins_right, pin, side, tangent)
        if shaft >= 0:
            _couple_shaft(contact, tangent, side, pin_rows, pin, shaft, pin_columns, others + shaft, 0)
    if shaft >= 0:
        pushed = contact.shaft_normal - sliding * contact.shaft_tangent
        right[shaft] += (
            tangent.force * pushed
            + tangent.rolling_force * contact.shaft_centre
            - tangent.friction * contact.shaft_tangent
        )
        matrix[shaft, shaft] += (
            tangent.slope * pushed * contact.shaft_normal
            + tangent.creep * contact.shaft_tangent**2
            + tangent.geometric * contact.shaft_centre**2
        )


@njit
def _add_force(right: Array, first: int, side: LeverArms, tangent: Tangent) -> None:
    """Add the force at the predicted speeds to the right side of a body's equations."""
    for a in range(3):
        right[first + a] += (
            tangent.force * side.pushed[a] + tangent.rolling_force * side.centre[a] - tangent.friction * side.tangent[a]
        )


@njit
def _add_block(target: Array, row: int, column: int, on: LeverArms, other: LeverArms, tangent: Tangent) -> None:
    """Add the derivative of the force on body `on` by the speeds of the `other` body to a matrix."""
    for a in range(3):
        normal, slip, roll = (
            tangent.slope * on.pushed[a],
            tangent.creep * on.tangent[a],
            tangent.geometric * on.centre[a],
        )
        for b in range(3):
            target[row + a, column + b] += normal * other.normal[b] + slip * other.tangent[b] + roll * other.centre[b]


@njit
def _couple_shaft(
    contact: Contact,
    tangent: Tangent,
    side: LeverArms,
    columns: Array,
    row: int,
    column: int,
    rows: Array,
    shaft_row: int,
    first: int,
) -> None:
    """Add the derivatives of the force on a body by the shaft's speed, and of the torque on the shaft by the body's.

    They belong to `columns` at `row` and `column`, and to `rows` at `shaft_row` from column `first` on.
    """
    pushed = contact.shaft_normal - tangent.sliding * contact.shaft_tangent
    for a in range(3):
        slip, roll = tangent.creep * side.tangent[a], tangent.geometric * side.centre[a]
        columns[row + a, column] += (
            tangent.slope * side.pushed[a] * contact.shaft_normal
            + slip * contact.shaft_tangent
            + roll * contact.shaft_centre
        )
        rows[shaft_row, first + a] += (
            tangent.slope * pushed * side.normal[a] + slip * contact.shaft_tangent + roll * contact.shaft_centre
        )


@njit
def _condense_pins(system: System, equations: Equations) -> None:
    """Condense the block of every pin into the equations of the other unknowns (Schur complement)."""
    matrix, right, pins, pins_right = equations.matrix, equations.right, equations.pins, equations.pins_right
    pin_columns, pin_rows, coupled = equations.pin_columns, equations.pin_rows, equations.coupled
    size = len(right)
    most = max(size - 2, system.ring_shaft + 1)
    for i in range(len(coupled)):
        first, others = 3 * i, size * i
        inverse = _inverse(pins, first)
        x, y, z = _product(inverse, pins_right[first], pins_right[first + 1], pins_right[first + 2])
        pins_right[first], pins_right[first + 1], pins_right[first + 2] = x, y, z
        if not coupled[i]:
            continue
        for b in range(most):
            pin_rows[first, b], pin_rows[first + 1, b], pin_rows[first + 2, b] = _product(
                inverse, pin_rows[first, b], pin_rows[first + 1, b], pin_rows[first + 2, b]
            )
        for a in range(most):
            p0, p1, p2 = pin_columns[others + a, 0], pin_columns[others + a, 1], pin_columns[others + a, 2]
            if p0 == 0.0 and p1 == 0.0 and p2 == 0.0:
                continue
            right[a] -= p0 * x + p1 * y + p2 * z
            for b in range(most):
                matrix[a, b] -= p0 * pin_rows[first, b] + p1 * pin_rows[first + 1, b] + p2 * pin_rows[first + 2, b]


@njit
def _product(m: Nine, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return the product of a matrix and a vector."""
    return (m[0] * x + m[1] * y + m[2] * z, m[3] * x + m[4] * y + m[5] * z, m[6] * x + m[7] * y + m[8] * z)


@njit
def _inverse(m: Array, row: int) -> Nine:
    """Return the inverse of the (3, 3) matrix that begins at a row of m."""
    a, b, c = m[row, 0], m[row, 1], m[row, 2]
    d, e, f = m[row + 1, 0], m[row + 1, 1], m[row + 1, 2]
    g, h, i = m[row + 2, 0], m[row + 2, 1], m[row + 2, 2]
    x, y, z = e * i - f * h, f * g - d * i, d * h - e * g
    share = 1.0 / (a * x + b * y + c * z)
    return (
        x * share,
        (c * h - b * i) * share,
        (b * f - c * e) * share,
        y * share,
        (a * i - c * g) * share,
        (c * d - a * f) * share,
        z * share,
        (b * g - a * h) * share,
        (a * e - b * d) * share,
    )


@njit
def _recover_pins(equations: Equations, v: Array) -> None:
    """Compute the speeds of the condensed pins from the other speeds."""
    coupled, pin_rows, pins_right = equations.coupled, equations.pin_rows, equations.pins_right
    size = len(equations.right)
    for i in range(len(coupled)):
        for m in range(3):
            value = pins_right[3 * i + m]
            if coupled[i]:
                for b in range(size):
                    value -= pin_rows[3 * i + m, b] * v[b]
            v[size + 3 * i + m] = value


@njit
def _update_states(
    system: System,
    contacts: Contacts,
    count: int,
    equations: Equations,
    predicted: Array,
    v: Array,
    half: float,
    all_change: bool,
    coupled_friction: bool,
) -> bool:
    """Compute the contact forces at speeds v, update the contact states, and return whether one has changed.

    Of each moving pin the first contact changes; of all other contacts the first, or `all_change`. If friction is not
    coupled, the result is also True until it agrees with the normal force.
    """
    changed, others_settled, largest, moved = False, True, 0.0, 0.0
    size, settled = len(equations.right), equations.settled
    for i in range(len(settled)):
        settled[i] = 1
    for k in range(count):
        contact = contacts[k]
        before, previous, pin = contact.state, contact.normal_force, (contact.pin - size) // 3
        single = pin >= 0 or not all_change
        normal_force = _update_forces(contact, predicted, v, half)
        largest = max(largest, contact.normal_force)
        if before in (SLIDES, SLIDES_BACK):
            moved = max(moved, abs(contact.normal_force - previous))
        after = _next_state(contact, normal_force, single, coupled_friction)
        if after == before:
            continue
        changed = True
        if not single or (settled[pin] if pin >= 0 else others_settled):
            contact.state = after
        if pin >= 0:
            settled[pin] = 0
        else:
            others_settled = False
    for shaft in range(2):
        limit = system.drag[shaft, 0]
        if limit > 0.0:
            speed = v[size - 2 + shaft]
            after = STICKS
            if system.drag[shaft, 1] * abs(speed) > limit:
                after = SLIDES if speed > 0.0 else SLIDES_BACK
            if after != equations.shaft_state[shaft] and (all_change or others_settled):
                equations.shaft_state[shaft] = after
                changed, others_settled = True, False
    return changed or (not coupled_friction and moved > NEWTON.friction_rtol * largest)


@njit
def _update_forces(contact: Contact, predicted: Array, v: Array, half: float) -> float:
    """Compute speeds and forces of a contact at speeds v, and return its normal force, which may be negative [N].

    An open contact closes when its gap does; a closed one opens when its force vanishes.
    """
    contact.speed, contact.slip = speeds(contact, v)
    normal_force = contact.force - contact.slope * contact.speed
    if contact.state == OPEN:
        gap = contact.gap + half * (contact.speed - speeds(contact, predicted)[0])
        if gap >= 0.0:
            normal_force = 0.0
    contact.normal_force, contact.friction_force = max(normal_force, 0.0), 0.0
    if normal_force > 0.0:
        limit = contact.friction * normal_force
        contact.friction_force = -max(-limit, min(limit, contact.creep * contact.slip))
    return normal_force


@njit
def _next_state(contact: Contact, normal_force: float, single: bool, coupled_friction: bool) -> int:
    """Return the state that follows from the forces of a contact; `single` if contacts change one at a time."""
    before = contact.state
    if (before == SLIDES and contact.slip < 0.0) or (before == SLIDES_BACK and contact.slip > 0.0):
        return STICKS  # a contact that reverses comes to rest first, even if the previous friction opens it
    if normal_force > 0.0:
        if before == OPEN and not coupled_friction:
            return STICKS  # the normal force of an open contact is no measure of friction
        return friction_state(contact, contact.slip)
    if before == STICKS and single and contact.friction > 0.0:
        return SLIDES if contact.slip > 0.0 else SLIDES_BACK  # creep alone may open a contact that is pressed
    return OPEN
