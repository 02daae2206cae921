"""Static equilibrium of a reducer under load, and the power balance of a slowly rotating crank."""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import announce_compilation
from cycloid_mj.base.deprecated import deprecated_argument
from cycloid_mj.base.errors import RunError
from cycloid_mj.base.powers import Powers
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.statics.cam_needles import cam_needles
from cycloid_mj.statics.film import FilmFriction, drag_power, drag_torques
from cycloid_mj.statics.jam import JAM, friction_limit
from cycloid_mj.statics.kernel import RESIDUAL_RTOL, KernelSprings, Residual, solve_equilibria
from cycloid_mj.statics.roller_needles import roller_springs
from cycloid_mj.statics.rv_motion import rv_transmission_error
from cycloid_mj.statics.springs import Springs, springs_of
from cycloid_mj.statics.structure import wind_up


@dataclass(frozen=True)
class RingTorqueSettings:
    """Settings of the secant iteration for the friction torque of a ring output (`_solve_ring_output`)."""

    max_iterations: int = 8
    """Two suffice, except close to a jam, where the losses are a hundred times the output power."""
    rtol: float = 1e-5
    """Largest change of the friction torque in the last iteration, relative to the load."""
    max_halvings: int = 3
    """Largest number of halvings of the first torque of the carrier if there is no equilibrium under it."""
    direct_share: float = 0.5
    """Relative residual below which the first iteration sets the friction torque to that of the losses."""


RING_TORQUE = RingTorqueSettings()


@dataclass(frozen=True)
class FilmSettings:
    """Settings of the fixed point of contact forces and film friction (`loads`)."""

    max_rounds: int = 8
    rtol: float = 1e-4
    """Change of the friction power in the last round, relative to it."""


FILM = FilmSettings()

MAX_ROLLER_STEPS = 30
"""Largest number of Newton steps for output rollers on separate needles; usually 3 to 6 are needed."""

ROLLER_RTOL = 1e-6
"""Largest error of the force of an output roller on separate needles, over the largest of these forces."""

NEEDLE_ROUNDS = 2
"""Solutions with separate rollers of the cams (heuristic): the friction of a cam acts on the resultant of the
previous one."""


@dataclass(frozen=True)
class Loads:
    """Contact forces and displacements at m crank angles under a load, in the frame of the ring, disc by disc.

    Attributes
    ----------
    teeth, output
        Force of each contact line with the ring, shape (m, D lines), and of each disc on each output pin, shape
        (m, D pins) [N].
    cam
        Force of each cam on its disc, with the friction of a plain cam, shape (m, D, 2) [N].
    departures
        Displacements of discs and output from their ideal poses, as in ``reducer.gaps``, shape (m, 3 D + 1) [m].
    gear_turn, output_turn
        Rotation of the discs (mean) and of the output from their ideal angles, shape (m,) [rad], in the sense of
        `member.share`; that of the output includes the torsion of carrier, shaft and housing.
    share
        Share of each disc in the output torque, shape (m, D) [1].
    work
        How often the equations were assembled per crank angle, on average: about 50, hundreds if parts snap.
    friction
        Friction of the contacts with the law ``film``; None with the law ``coulomb`` or without friction.
    """

    teeth: Array
    output: Array
    cam: Array
    departures: Array
    gear_turn: Array
    output_turn: Array
    share: Array
    work: float
    friction: FilmFriction | None = None

    @property
    def discs(self) -> int:
        """Number of discs."""
        return self.cam.shape[1]

    def by_disc(self, forces: Array) -> Array:
        """Reshape forces on teeth or output pins, (m, D n), so that discs have an axis of their own, (m, D, n)."""
        return forces.reshape(len(forces), self.discs, -1)


@deprecated_argument("follow", "warm_start")
def loads(reducer: Reducer, springs: Springs, torque: float | Array, warm_start: bool = False) -> Loads:
    """Compute contact forces and displacements under an output torque at the crank angles of the contact springs.

    With the friction law ``film``, the solution is repeated with the friction coefficients of the lubricating film
    under the previous forces, until the losses change by less than `FILM.rtol` (fixed-point iteration).

    Parameters
    ----------
    reducer
        The reducer.
    springs
        Its contact springs at m crank angles, from `springs_of`.
    torque
        Output torque [N m], not 0: a number, or a torque per crank angle, shape (m,). It is positive if it brakes a
        crank that rotates counter-clockwise (`Member.sense`).
    warm_start
        Whether each solution starts from the equilibria at the previous crank angles. Use it if angles and torques vary
        smoothly.

    Returns
    -------
    Loads
        Forces [N], displacements [m] and rotations [rad] at the m crank angles.

    Raises
    ------
    RunError
        There is no equilibrium.
    """
    contact_loads = solve_at_friction(reducer, springs, torque, warm_start)
    if springs.film is None:
        return contact_loads
    loss = math.inf
    for _ in range(FILM.max_rounds):
        cam_force = np.linalg.norm(contact_loads.cam, axis=-1)
        film_contacts = springs.film.displaced(contact_loads.departures)
        springs = springs.with_friction(film_contacts.friction(contact_loads.teeth, contact_loads.output, cam_force))
        contact_loads = solve_at_friction(reducer, springs, torque, warm_start, contact_loads)
        previous_loss, loss = (
            loss,
            sum(float(np.mean(power)) for power in friction_losses(reducer, springs, contact_loads).values()),
        )
        if abs(loss - previous_loss) <= FILM.rtol * loss:
            break
    return contact_loads


def solve_at_friction(
    reducer: Reducer, springs: Springs, torque: float | Array, warm_start: bool, start: Loads | None = None
) -> Loads:
    """Solve for equilibrium with the friction coefficients of the `springs`; add the structure's twist to rotations.

    Parameters
    ----------
    reducer, springs
        The reducer, and its contact springs at m crank angles.
    torque
        Output torque [N m], not 0: a number, or of shape (m,).
    warm_start
        Whether to start each solution from the previous equilibria, as in `loads`; ignored with a `start`.
    start
        Solution for similar friction coefficients, whose displacements are the starting point.

    Returns
    -------
    Loads
        Forces [N], displacements [m] and rotations [rad] at the m crank angles.

    Raises
    ------
    RunError
        There is no equilibrium.
    """
    if reducer.design.output.turns_ring:
        return _solve_ring_output(reducer, springs, torque, warm_start, start)
    contact_loads = _solve_carrier_output(reducer, springs, torque, warm_start, start)
    return replace(contact_loads, output_turn=contact_loads.output_turn + wind_up(reducer) * torque)


def _solve_ring_output(
    reducer: Reducer, springs: Springs, torque: float | Array, warm_start: bool, start: Loads | None
) -> Loads:
    """Solve for the contact forces in equilibrium under a torque on the ring [N m], a number or of shape (m,).

    The carrier supports ``(torque - friction_torque) / (1 + 1 / lobes)``. The friction torque is the power of the
    losses divided by the crank speed relative to the ring. As it depends on the contact forces, a secant iteration
    determines it. `springs` are the contact springs. `warm_start` starts each crank angle from the previous solution,
    and `start` is a solution to start from. The rotation of the output includes the twist of the structure.
    """
    settings = RING_TORQUE
    speed, torque_ratio = reducer.speed_against_ring, 1.0 + 1.0 / reducer.design.lobes
    has_friction, mean_torque, friction_torque = (
        bool(springs.contacts.friction_per_force.size and speed),
        float(np.mean(torque)),
        0.0,
    )
    for halvings in range(settings.max_halvings + 1):
        try:
            contact_loads = _solve_carrier_output(
                reducer, springs, (torque - friction_torque) / torque_ratio, warm_start, start
            )
            break
        except RunError:
            if not has_friction or halvings == settings.max_halvings:
                raise
            friction_torque = 0.5 * (mean_torque + friction_torque)
    previous_point = None
    for _ in range(settings.max_iterations if has_friction else 0):
        loss_torque = (
            sum(float(np.mean(power)) for power in friction_losses(reducer, springs, contact_loads).values()) / speed
        )
        residual = loss_torque - friction_torque
        if previous_point is not None and residual != previous_point[1]:
            torque_step = -residual * (friction_torque - previous_point[0]) / (residual - previous_point[1])
        elif abs(residual) < settings.direct_share * abs(mean_torque):
            torque_step = residual
        else:  # losses in proportion to the supported torque
            torque_step = (mean_torque - friction_torque) * residual / (mean_torque - friction_torque + loss_torque)
        previous_point, friction_torque = (friction_torque, residual), friction_torque + torque_step
        contact_loads = _solve_carrier_output(
            reducer, springs, (torque - friction_torque) / torque_ratio, warm_start, start and contact_loads
        )
        if abs(torque_step) < settings.rtol * abs(mean_torque):
            break
    carrier_torque = (torque - friction_torque) / torque_ratio
    output_turn = reducer.share * contact_loads.output_turn + wind_up(reducer) * carrier_torque / reducer.share
    return replace(
        contact_loads, gear_turn=contact_loads.output_turn - contact_loads.gear_turn, output_turn=output_turn
    )


def _solve_carrier_output(
    reducer: Reducer, springs: Springs, torque: float | Array, warm_start: bool, start: Loads | None
) -> Loads:
    """Solve for the contact forces in equilibrium under a torque on the carrier [N m], in the frame of the ring.

    `torque` is a number or has shape (m,). The twist of the structure is not included. `springs` are the contact
    springs. `warm_start` starts each crank angle from the previous solution, and `start` is a solution to start from.
    """
    contacts, radius = springs.contacts, reducer.design.output.pin_circle_radius
    load = springs.load(torque)
    z = np.zeros(load.shape)
    disc_displacements = z[:, :-1].reshape(len(z), -1, 3)
    disc_displacements[..., :2] = contacts.cam_position
    if start is not None:
        z[:] = start.departures
    force, cam_force, assemblies = _solve_contacts(reducer, springs, load, z, warm_start and start is None)
    pin_force = force[:, springs.teeth :]
    moments = (
        (-pin_force * contacts.slope[:, springs.teeth :, -1])
        .reshape(len(z), disc_displacements.shape[1], -1)
        .sum(axis=-1)
    )
    moment = moments.sum(axis=1, keepdims=True)
    return Loads(
        teeth=force[:, : springs.teeth],
        output=pin_force,
        cam=cam_force,
        departures=z,
        gear_turn=disc_displacements[..., 2].mean(axis=1) / radius,
        output_turn=z[:, -1] / radius,
        share=moments / np.where(moment == 0.0, 1.0, moment),  # a torque below the tolerance closes no contact
        work=assemblies / len(z),
        friction=springs.friction,
    )


def _solve_contacts(
    reducer: Reducer, springs: Springs, load: Array, z: Array, warm_start: bool
) -> tuple[Array, Array, float]:
    """Solve for the contact forces in equilibrium; linearise output rollers on separate needles repeatedly.

    There are u unknown displacements at each of m crank angles, n contacts and D discs. `springs` are the contact
    springs, `load` (m, u) [N] the generalised forces. `z` (m, u) [m] are start values of the displacements, which are
    overwritten by the solution. `warm_start` starts each crank angle from the previous solution. Returns the forces of
    contacts (m, n) and cams (m, D, 2) [N] and the number of assemblies of the equations, as `_solve_with_cams`.

    Raises
    ------
    RunError
        There is no equilibrium, or the forces of the rollers do not converge.
    """
    rollers = roller_springs(reducer, springs)
    if rollers is None:
        return _solve_with_cams(reducer, springs, load, z, warm_start)
    total_assemblies = 0.0
    for step in range(MAX_ROLLER_STEPS):
        current_springs = replace(springs, contacts=rollers.insert(springs.contacts, springs.teeth))
        force, cam_force, assemblies = _solve_with_cams(reducer, current_springs, load, z, warm_start and step == 0)
        total_assemblies, linear_force = total_assemblies + assemblies, force[:, springs.teeth :]
        rollers, roller_force = rollers.linearise(rollers.approach(linear_force))
        error, largest_force = float(np.abs(roller_force - linear_force).max()), float(linear_force.max())
        if error <= ROLLER_RTOL * largest_force:
            return force, cam_force, total_assemblies
    raise RunError(
        f"the forces of the output rollers on their needles did not converge in {MAX_ROLLER_STEPS} steps: the last "
        f'error is {error:.3g} N of {largest_force:.3g} N; set contact.needles = "lumped"'
    )


def _solve_with_cams(
    reducer: Reducer, springs: Springs, load: Array, z: Array, warm_start: bool
) -> tuple[Array, Array, float]:
    """Solve for equilibrium from the displacements `z` (m, u) [m], which are overwritten by the solution.

    `springs` are the contact springs. There are u unknown displacements at each of m crank angles, n contacts and D
    discs. `load` (m, u) [N] are the generalised forces. `warm_start` starts each crank angle from the previous
    solution.

    Returns
    -------
    tuple
        Forces of the contacts (m, n) and of the cams on their discs (m, D, 2) [N], and the number of times that the
        equations were assembled, over all angles.

    Raises
    ------
    RunError
        There is no equilibrium, or a cam is displaced beyond the range of the equations of its rollers.
    """
    contacts, needles, assemblies = springs.contacts, cam_needles(reducer, springs), 0.0
    if needles is None:
        force = np.zeros(contacts.distance.shape)
        with announce_compilation():
            residual = solve_equilibria(contacts, load, z, force, warm_start)
        require_equilibrium(residual, springs, load)
        return force, _cam_forces(contacts, z), residual.work
    for round_index in range(NEEDLE_ROUNDS if contacts.friction_per_force.size else 1):
        all_springs = needles.extend(contacts, springs.teeth)
        all_forces = np.zeros(all_springs.distance.shape)
        with announce_compilation():
            residual = solve_equilibria(all_springs, load, z, all_forces, warm_start and round_index == 0)
        require_equilibrium(residual, springs, load)
        force, needle_forces = needles.split(all_forces, springs.teeth)
        needles, assemblies = needles.with_shares(needle_forces), assemblies + residual.work
    if float(np.linalg.norm(_cam_offsets(contacts, z), axis=-1).max()) > needles.reach:
        raise RunError(
            f"a cam is displaced by more than {1e6 * needles.reach:.3g} um in its bore; the equations of its rollers "
            'are not valid beyond this displacement: reduce the load (--load-nm), or set contact.needles = "lumped"'
        )
    return force, needles.resultants(needle_forces), assemblies


def _cam_forces(contacts: KernelSprings, z: Array) -> Array:
    """Return the force of each cam on its disc at displacements `z` (m, u) [m], shape (m, D, 2) [N]."""
    cam_offsets = _cam_offsets(contacts, z)
    distance = np.maximum(np.linalg.norm(cam_offsets, axis=-1), np.finfo(float).tiny)
    cam_forces = contacts.cam_stiffness * np.maximum(distance - contacts.cam_clearance, 0.0)
    lateral_offsets = contacts.cam_lateral * cam_offsets[..., ::-1] * (1.0, -1.0)
    return np.asarray((cam_forces / distance)[..., np.newaxis] * (lateral_offsets - cam_offsets))


def _cam_offsets(contacts: KernelSprings, z: Array) -> Array:
    """Return the displacement of each disc from its cam at displacements `z` (m, u) [m], shape (m, D, 2) [m]."""
    return np.asarray(z[:, :-1].reshape(len(z), -1, 3)[..., :2] - contacts.cam_position)


def require_equilibrium(residual: Residual, springs: Springs, load: Array) -> None:
    """Raise RunError if a residual exceeds `RESIDUAL_RTOL` of the load; the message says whether friction is the cause.

    `load` (k, u) [N] are the generalised forces on the u unknowns at the k crank angles of the contact `springs`, from
    `Springs.load`. Friction is the cause if the parts have no equilibrium with it even without clearance
    (`jam.friction_limit`).
    """
    if residual.force <= RESIDUAL_RTOL:
        return
    location = f"at a crank angle of {math.degrees(springs.crank[residual.angle]) % 360.0:.4g} deg relative to the ring"
    failure = (
        f"no static equilibrium found {location}: the residual is {residual.force:.3g} of the load (allowed: "
        f"{RESIDUAL_RTOL:.0e})"
    )
    remedy = "check the clearances (clearance.*), or reduce the load (--load-nm)"
    if not springs.contacts.friction_per_force.size:
        raise RunError(f"{failure}; {remedy}")
    limit = friction_limit(springs.contacts, residual.angle, load[residual.angle])
    if limit < JAM.max_friction:
        near_limit = ", and close to this limit, forces are many times the load" * (limit >= 1.0)
        raise RunError(
            f"no static equilibrium {location}: friction jams the drive under this load at any crank torque. A "
            f"drive without clearance has an equilibrium only if its friction coefficients are at most {limit:.0%} of "
            f"those of the design{near_limit}. Reduce the friction coefficients (friction.*)"
        )
    raise RunError(
        f"{failure}. Friction is not the cause: a drive without clearance has an equilibrium even if its friction "
        f"coefficients are raised to {JAM.max_friction:.0%} of those of the design. {remedy[0].upper()}{remedy[1:]}"
    )


def transmission_error(reducer: Reducer, crank: npt.ArrayLike, torque: float) -> Array:
    """Compute the rotations of discs and output from their ideal angles under a torque, without friction.

    The only inertia force is the disc's centrifugal force at the speed of the design. In an RV reducer, there are no
    inertia forces, but the friction of the running drive is included.

    Parameters
    ----------
    reducer
        The reducer.
    crank
        Crank angles in order [rad], shape (k,).
    torque
        Output torque [N m], not 0; positive if it brakes a crank that rotates counter-clockwise (`Member.sense`). The
        rotations have the same sign convention.

    Returns
    -------
    Array
        Rotations of the discs (their mean) and of the output [rad], shape (k, 2).

    Raises
    ------
    RunError
        There is no equilibrium.
    """
    if isinstance(reducer, RvReducer):
        return rv_transmission_error(reducer, crank, torque)
    contact_loads = loads(reducer, springs_of(reducer, crank, friction=False), torque, warm_start=True)
    return np.stack([contact_loads.gear_turn, contact_loads.output_turn], axis=1)


def powers(reducer: Reducer, torque: float, crank: npt.ArrayLike | None = None) -> Powers:
    """Compute the mean powers through both shafts and the friction losses at the design's speed, which must not be 0.

    The torque of the crank follows from the power balance. The contacts also transmit the drag of the output's seals.
    Each solution starts from the equilibrium at the previous crank angle. At high friction, parts may also wedge, and a
    solution with another starting point may end in such a state.

    Parameters
    ----------
    reducer
        The reducer.
    torque
        Output torque [N m]: it brakes if positive, and drives if negative.
    crank
        Crank angles in order [rad], shape (m,); by default evenly over a turn.

    Returns
    -------
    Powers
        Mean powers into the reducer through crank and output [W], and lost to friction [W] by part: "teeth", "cam",
        "output" (its pins) and "seals".

    Raises
    ------
    RunError
        There is no equilibrium, for example because friction jams the reducer.
    """
    design = reducer.design
    springs, direction, speed = springs_of(reducer, crank), np.sign(design.drive.speed), abs(design.drive.speed)
    contact_loads = loads(reducer, springs, float(direction) * (torque + drag_torques(reducer)[1]), warm_start=True)
    losses = friction_losses(reducer, springs, contact_loads)
    mean_losses = {part: float(np.mean(power_loss)) for part, power_loss in losses.items()}
    mean_losses["seals"] = drag_power(reducer)
    input_power = torque * speed / design.reduction
    return Powers(input_power + sum(mean_losses.values()), -input_power, mean_losses)


def friction_losses(reducer: Reducer, springs: Springs, contact_loads: Loads) -> dict[str, Array]:
    """Compute the friction power [W] at m crank angles by part, "teeth", "cam" and "output" (its pins): part -> (m,).

    The power of a contact is its friction coefficient times normal force times sliding speed; a part has the sum over
    its contacts. `springs` are the contact springs at the m crank angles, which also have the sliding speeds, and
    `contact_loads` are the forces on them. With the friction law ``film`` each contact has its own coefficient,
    otherwise each kind of pair has one.
    """
    design = reducer.design
    slip, tooth_count = np.abs(springs.slip), springs.teeth
    cam_speed = abs(float(design.drive.speed - reducer.member.gear_angle(design.drive.speed)))
    cam_force = springs.cam_normal_share * np.linalg.norm(contact_loads.cam, axis=-1).sum(axis=1)
    film = contact_loads.friction
    if film is not None:
        power_per_force = film.contacts * slip
        return {
            "teeth": np.sum(power_per_force[:, :tooth_count] * contact_loads.teeth, axis=1),
            "cam": film.cam * design.gear.bore_radius * cam_speed * cam_force,
            "output": np.sum(power_per_force[:, tooth_count:] * contact_loads.output, axis=1),
        }
    return {
        "teeth": design.mesh_friction * np.sum(contact_loads.teeth * slip[:, :tooth_count], axis=1),
        "cam": design.friction_of("cam") * design.gear.bore_radius * cam_speed * cam_force,
        "output": design.friction_of("output") * np.sum(contact_loads.output * slip[:, tooth_count:], axis=1),
    }
