"""The equations of a step: the implicit midpoint rule, linear in the speeds but for what each contact does.

With the speeds v in the middle of a step h, v0 at its start and the force f in its middle,

    2 M/h (v - v0) = f(q0 + h/2 v, v)

Contacts are those of a pose near the middle, and their forces are linear about it: a normal force N - S n v that never
pulls, friction -creep t v up to Coulomb's limit, and what the normal turns by as round parts roll in each other. Which
of them press, creep or slide is changed until none changes (a semismooth Newton method). Moving pins meet no other pin:
each is eliminated by itself (Schur), which leaves discs, output and crank. Where a step is too long for what they do in
their play, their M/h (v - v0) takes the place of the left side: implicit Euler, which damps that.
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
    Contacts,
    njit,
    rolling,
    rubbing_state,
    speeds,
)
from cycloid_mj.dynamics.planar.system import System
from cycloid_mj.dynamics.planar.timestep import MAX_ITERATIONS
from cycloid_mj.statics.kernel.newton import solve as gauss

COUPLED_ROUNDS = 25
"""Rounds in which sliding friction follows its normal force; from then on it is that of the force of the round before.

Between two contacts that are wedged, friction and normal force may raise each other: what slides would stick, and what
sticks would slide. With friction as it was, the law of all is a P-matrix.
"""

LIKE = 1e-6
"""Share of the largest normal force by which friction of the round before may miss its limit at the end."""

AT_ONCE_ROUNDS = 6
"""Rounds in which all contacts without a moving pin change that ask for it; from then on it is the first of them alone.

Contacts may change each other for ever. One at a time they come to an end, where the law of all is a P-matrix (Murty,
Note on a Bard-type scheme for solving the complementarity problem, 1974). The two of a moving pin, gear and seat, do so
at once, as it is light: of each pin the first alone changes in every round. Pins meet each other by way of the discs
alone, which are heavy, so that all of them change in the rounds that one takes.
"""


Nine = tuple[float, float, float, float, float, float, float, float, float]
"""A matrix of shape (3, 3), row by row."""


class Equations(NamedTuple):
    """Room for the equations of a step with n unknowns but pins, and N pins.

    Attributes
    ----------
    matrix, right
        Of the unknowns but pins, shapes (n, n), (n,).
    pins, pins_right
        Of each pin, one after the other, shapes (3 N, 3), (3 N,).
    by_pin, of_pin
        What each pin adds to the equations of the others, and the others to its own, shapes (n N, 3), (3 N, n).
    coupled
        Whether a pin meets anything that moves, shape (N,).
    settled
        Whether no contact of a pin has changed in this round, shape (N,).
    shaft_state
        Of the drags of output and crank, as of contacts, shape (2,).
    """

    matrix: Array
    right: Array
    pins: Array
    pins_right: Array
    by_pin: Array
    of_pin: Array
    coupled: Integers
    settled: Integers
    shaft_state: Integers


def room_for_equations(system: System) -> Equations:
    """Make room for the equations of a reducer."""
    size, pins = len(system.inertia), len(system.place) * system.free
    return Equations(
        matrix=np.zeros((size, size)),
        right=np.zeros(size),
        pins=np.zeros((3 * pins, 3)),
        pins_right=np.zeros(3 * pins),
        by_pin=np.zeros((size * pins, 3)),
        of_pin=np.zeros((3 * pins, size)),
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
    near: Array,
    command: Array,
    step: float,
    pin_span: float,
    v: Array,
) -> int:
    """Solve a step [s] from the pose q0 at speeds v0 for the speeds v in its middle, with `count` contacts near `near`.

    `command` is that of output and crank, an angle [rad] or a torque [N m]; in the time `pin_span` [s] forces bring
    pins from v0 to v: half a step, or by implicit Euler a whole one. Returns the number of rounds, one more than
    `MAX_ITERATIONS` where contacts still change.
    """
    for rounds in range(1, MAX_ITERATIONS + 1):
        at_once, coupled = rounds <= AT_ONCE_ROUNDS, rounds <= COUPLED_ROUNDS
        _assemble(system, contacts, count, equations, q0, v0, near, command, step, pin_span, coupled)
        _eliminate(system, equations)
        gauss(equations.matrix, equations.right, equations.right, 0.0)
        size = len(equations.right)
        for i in range(size):
            v[i] = equations.right[i]
        _substitute(equations, v)
        if not _changes(system, contacts, count, equations, near, v, 0.5 * step, at_once, coupled):
            return rounds
    return MAX_ITERATIONS + 1


@njit
def _assemble(
    system: System,
    contacts: Contacts,
    count: int,
    equations: Equations,
    q0: Array,
    v0: Array,
    near: Array,
    command: Array,
    step: float,
    pin_span: float,
    coupled_friction: bool,
) -> None:
    matrix, right = equations.matrix, equations.right
    pins, pins_right = equations.pins, equations.pins_right
    size, half = len(right), 0.5 * step
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
            turn = q0[i] + half * near[i]
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
    coupled, by_pin, of_pin = equations.coupled, equations.by_pin, equations.of_pin
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
                    by_pin[size * i + k, m] = 0.0
                    of_pin[first + m, k] = 0.0
            coupled[i] = 0
    _add_contacts(contacts, count, equations, near, coupled_friction)


class Side(NamedTuple):
    """Three unknowns of a part in a contact.

    Attributes
    ----------
    pushed
        Force on them per force along the normal, with the friction that goes with it where the contact slides.
    normal, tangent, middle
        How they move it along normal and tangent, and the middle of a round surface along the tangent.
    """

    pushed: tuple[float, float, float]
    normal: tuple[float, float, float]
    tangent: tuple[float, float, float]
    middle: tuple[float, float, float]


@njit
def _side(sign: float, nx: float, ny: float, normal: float, tangent: float, middle: float, sliding: float) -> Side:
    along, aside = (sign * nx, sign * ny, sign * normal), (-sign * ny, sign * nx, sign * tangent)
    pushed = (along[0] - sliding * aside[0], along[1] - sliding * aside[1], along[2] - sliding * aside[2])
    return Side(pushed, along, aside, (aside[0], aside[1], sign * middle))


@njit
def _add_contacts(contacts: Contacts, count: int, equations: Equations, near: Array, coupled_friction: bool) -> None:
    """Add the forces of the contacts that press to the equations of the parts that they are on.

    Where friction is not coupled to the normal force, it is that of the `pressing` of the round before.
    """
    matrix, right, pins, pins_right = equations.matrix, equations.right, equations.pins, equations.pins_right
    by_pin, of_pin, coupled = equations.by_pin, equations.of_pin, equations.coupled
    size = len(right)
    for k in range(count):
        contact = contacts[k]
        if contact.state == OPEN:
            continue
        nx, ny, slope, bowl = contact.nx, contact.ny, contact.slope, contact.bowl * contact.pressing
        creep, sliding, dragging = contact.creep, 0.0, 0.0
        if contact.state != STICKS:
            creep, sliding = 0.0, contact.friction if contact.state == SLIDES else -contact.friction
            if not coupled_friction:
                sliding, dragging = 0.0, sliding * contact.pressing
        force, rolled = contact.force, bowl * rolling(contact, near)
        disc, own, shaft = contact.disc, contact.pin, contact.shaft
        pin = 3 * ((own - size) // 3)
        of_shaft = contact.shaft_normal - sliding * contact.shaft_tangent
        if disc >= 0:
            side = _side(1.0, nx, ny, contact.disc_normal, contact.disc_tangent, contact.disc_middle, sliding)
            _add_block(matrix, disc, disc, side, side, slope, creep, bowl)
            for a in range(3):
                right[disc + a] += force * side.pushed[a] + rolled * side.middle[a] - dragging * side.tangent[a]
            if shaft >= 0:
                for a in range(3):
                    by_slip, by_roll = creep * side.tangent[a], bowl * side.middle[a]
                    matrix[disc + a, shaft] += (
                        slope * side.pushed[a] * contact.shaft_normal
                        + by_slip * contact.shaft_tangent
                        + by_roll * contact.shaft_middle
                    )
                    matrix[shaft, disc + a] += (
                        slope * of_shaft * side.normal[a]
                        + by_slip * contact.shaft_tangent
                        + by_roll * contact.shaft_middle
                    )
            if own >= 0:
                other = _side(-1.0, nx, ny, contact.pin_normal, contact.pin_tangent, 0.0, sliding)
                coupled[pin // 3] = 1
                _add_block(of_pin, pin, disc, other, side, slope, creep, bowl)
                _add_block(by_pin, size * (pin // 3) + disc, 0, side, other, slope, creep, bowl)
        if own >= 0:
            side = _side(contact.side, nx, ny, contact.pin_normal, contact.pin_tangent, 0.0, sliding)
            _add_block(pins, pin, 0, side, side, slope, creep, bowl)
            for a in range(3):
                pins_right[pin + a] += force * side.pushed[a] + rolled * side.middle[a] - dragging * side.tangent[a]
            if shaft >= 0:
                coupled[pin // 3] = 1
                for a in range(3):
                    by_slip, by_roll = creep * side.tangent[a], bowl * side.middle[a]
                    by_pin[size * (pin // 3) + shaft, a] += (
                        slope * of_shaft * side.normal[a]
                        + by_slip * contact.shaft_tangent
                        + by_roll * contact.shaft_middle
                    )
                    of_pin[pin + a, shaft] += (
                        slope * side.pushed[a] * contact.shaft_normal
                        + by_slip * contact.shaft_tangent
                        + by_roll * contact.shaft_middle
                    )
        if shaft >= 0:
            right[shaft] += force * of_shaft + rolled * contact.shaft_middle - dragging * contact.shaft_tangent
            matrix[shaft, shaft] += (
                slope * of_shaft * contact.shaft_normal
                + creep * contact.shaft_tangent**2
                + bowl * contact.shaft_middle**2
            )


@njit
def _add_block(
    target: Array, row: int, column: int, on: Side, by: Side, slope: float, creep: float, bowl: float
) -> None:
    """Add what the force on one part changes by with the speeds of another, or of its own."""
    for a in range(3):
        by_normal, by_slip, by_roll = slope * on.pushed[a], creep * on.tangent[a], bowl * on.middle[a]
        for b in range(3):
            target[row + a, column + b] += by_normal * by.normal[b] + by_slip * by.tangent[b] + by_roll * by.middle[b]


@njit
def _eliminate(system: System, equations: Equations) -> None:
    """Eliminate every pin: invert its block, and take what it adds to the others off their equations."""
    matrix, right, pins, pins_right = equations.matrix, equations.right, equations.pins, equations.pins_right
    by_pin, of_pin, coupled = equations.by_pin, equations.of_pin, equations.coupled
    size = len(right)
    most = max(size - 2, system.ring_shaft + 1)
    for i in range(len(coupled)):
        first, others = 3 * i, size * i
        inverse = _inverted(pins, first)
        x, y, z = _times(inverse, pins_right[first], pins_right[first + 1], pins_right[first + 2])
        pins_right[first], pins_right[first + 1], pins_right[first + 2] = x, y, z
        if not coupled[i]:
            continue
        for b in range(most):
            of_pin[first, b], of_pin[first + 1, b], of_pin[first + 2, b] = _times(
                inverse, of_pin[first, b], of_pin[first + 1, b], of_pin[first + 2, b]
            )
        for a in range(most):
            p0, p1, p2 = by_pin[others + a, 0], by_pin[others + a, 1], by_pin[others + a, 2]
            if p0 == 0.0 and p1 == 0.0 and p2 == 0.0:
                continue
            right[a] -= p0 * x + p1 * y + p2 * z
            for b in range(most):
                matrix[a, b] -= p0 * of_pin[first, b] + p1 * of_pin[first + 1, b] + p2 * of_pin[first + 2, b]


@njit
def _times(m: Nine, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Multiply a matrix by a vector."""
    return (
        m[0] * x + m[1] * y + m[2] * z,
        m[3] * x + m[4] * y + m[5] * z,
        m[6] * x + m[7] * y + m[8] * z,
    )


@njit
def _inverted(m: Array, row: int) -> Nine:
    """Invert the matrix of shape (3, 3) that begins in a row."""
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
def _substitute(equations: Equations, v: Array) -> None:
    """Compute the speeds of pins from those of all others."""
    coupled, of_pin, pins_right = equations.coupled, equations.of_pin, equations.pins_right
    size = len(equations.right)
    for i in range(len(coupled)):
        for m in range(3):
            value = pins_right[3 * i + m]
            if coupled[i]:
                for b in range(size):
                    value -= of_pin[3 * i + m, b] * v[b]
            v[size + 3 * i + m] = value


@njit
def _changes(
    system: System,
    contacts: Contacts,
    count: int,
    equations: Equations,
    near: Array,
    v: Array,
    half: float,
    at_once: bool,
    coupled_friction: bool,
) -> bool:
    """Compute the forces at speeds v, set the states that they ask for, and tell whether one has changed.

    Of each moving pin the first contact changes; of all others the first, or all `at_once`. Where friction is not
    coupled, it is to come out as it was.

    A contact that was open closes where its gap does; one that has closed bears what it bears, until that is nothing.
    """
    changed, others_settled, largest, moved = False, True, 0.0, 0.0
    size, settled = len(equations.right), equations.settled
    for i in range(len(settled)):
        settled[i] = 1
    for k in range(count):
        contact = contacts[k]
        before, bore, pin = contact.state, contact.pressing, (contact.pin - size) // 3
        one_by_one = pin >= 0 or not at_once
        contact.speed, contact.slip = speeds(contact, v)
        pressing = contact.force - contact.slope * contact.speed
        if before == OPEN:
            gap = contact.gap + half * (contact.speed - speeds(contact, near)[0])
            if gap >= 0.0:
                pressing = 0.0
        contact.pressing, contact.rubbing = max(pressing, 0.0), 0.0
        largest = max(largest, contact.pressing)
        if before in (SLIDES, SLIDES_BACK):
            moved = max(moved, abs(contact.pressing - bore))
        after = OPEN
        if (before == SLIDES and contact.slip < 0.0) or (before == SLIDES_BACK and contact.slip > 0.0):
            after = STICKS  # what turns round comes to rest on the way, even if friction as it was parts it
        elif pressing > 0.0:
            after = rubbing_state(contact, contact.slip)
            if before == OPEN and not coupled_friction:
                after = STICKS  # the force that it would have had is no measure of friction
        elif before == STICKS and one_by_one and contact.friction > 0.0:
            after = SLIDES if contact.slip > 0.0 else SLIDES_BACK  # creep alone may part what presses
        if pressing > 0.0:
            limit = contact.friction * pressing
            contact.rubbing = -max(-limit, min(limit, contact.creep * contact.slip))
        if after == before:
            continue
        changed = True
        if not one_by_one or (settled[pin] if pin >= 0 else others_settled):
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
            if after != equations.shaft_state[shaft] and (at_once or others_settled):
                equations.shaft_state[shaft] = after
                changed, others_settled = True, False
    return changed or (not coupled_friction and moved > LIKE * largest)
