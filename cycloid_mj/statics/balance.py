"""The balance of a reducer's springs under a load, and the powers of a crank that turns slowly through it."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import announced
from cycloid_mj.base.errors import RunError
from cycloid_mj.base.powers import Powers
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.jam import BORNE, friction_borne
from cycloid_mj.statics.kernel import BALANCED, KernelSprings, Left, balance
from cycloid_mj.statics.springs import Springs, springs_of
from cycloid_mj.statics.structure import wind_up

REPEATS = 8
"""Most corrections of the carrier's torque for the losses: two do, but near a jam, where these are a hundred times what
comes out."""

CORRECTED = 1e-5
"""Share of the load by which the last correction may change what the losses take of it."""

HALVINGS = 3
"""How often the carrier's torque is halved to begin with, where it jams under more than it bears in truth."""

SMALL_LOSS = 0.5
"""Share of the load up to which the crank's torque for the losses is as good as what they were under the load alone."""


@dataclass(frozen=True)
class Loads:
    """Forces at m crank angles under one load, and motions, seen from the ring; those of each contact disc after disc.

    Attributes
    ----------
    teeth, output
        On each contact line with the ring, shape (m, D lines), and of each disc on each output pin [N], (m, D pins).
    cam
        Of each cam on its disc [N], shape (m, D, 2).
    departures
        Of discs and output from their ideal places, as in ``reducer.gaps``, shape (m, 3 D + 1) [m].
    gear_turn, output_turn
        Of the discs, in the mean, and of the output from their ideal angles, shape (m,) [rad], in the sense of
        `member.share`; the output's with the twist of carrier, shaft and housing.
    share
        Of each disc in the torque on the output, shape (m, D) [1].
    work
        Steps of Newton's method at a crank angle, in the mean: some 50, where parts snap over in their play hundreds.
    """

    teeth: Array
    output: Array
    cam: Array
    departures: Array
    gear_turn: Array
    output_turn: Array
    share: Array
    work: float

    @property
    def discs(self) -> int:
        """Number of discs."""
        return self.cam.shape[1]

    def by_disc(self, forces: Array) -> Array:
        """Compute forces on teeth or output pins with an axis for the discs, shape (m, D, n)."""
        return forces.reshape(len(forces), self.discs, -1)


def loads(reducer: Reducer, springs: Springs, torque: float | Array, follow: bool = False) -> Loads:
    """Compute what the contacts carry under a torque on the output [N m], not 0; its sense is that of `member.share`.

    A ring that turns under friction leaves the carrier its torque less the crank's, which the losses raise.

    Parameters
    ----------
    reducer
        Whose contacts carry.
    springs
        Of the reducer at crank angles, as of `springs_of`.
    torque
        On the output [N m], one or one for each crank angle, shape (m,).
    follow
        Whether angles and torques follow each other closely: each search then starts from the balances before.

    Raises
    ------
    RunError
        No balance was found.
    """
    if reducer.design.output.turns_ring:
        return _on_ring(reducer, springs, torque, follow)
    balanced = _balanced(reducer, springs, torque, follow)
    return replace(balanced, output_turn=balanced.output_turn + wind_up(reducer) * torque)


def _on_ring(reducer: Reducer, springs: Springs, torque: float | Array, follow: bool) -> Loads:
    """Find the balance under a torque on a ring [N m], of which the carrier bears what the crank does not.

    Losses take lost/speed of the torque, and the carrier bears the rest over 1 + 1/lobes: by the secant, as what is
    lost follows from what is borne.
    """
    speed, parts = float(reducer.member.against_ring(reducer.design.drive.speed)), 1.0 + 1.0 / reducer.design.lobes
    rubs, mean, taken = bool(springs.contacts.rubbing.size and speed), float(np.mean(torque)), 0.0
    for halved in range(HALVINGS + 1):
        try:
            balanced = _balanced(reducer, springs, (torque - taken) / parts, follow)
            break
        except RunError:
            if not rubs or halved == HALVINGS:
                raise
            taken = 0.5 * (mean + taken)
    before = None
    for _ in range(REPEATS if rubs else 0):
        lost = sum(float(np.mean(power)) for power in _friction_losses(reducer, springs, balanced).values()) / speed
        missing = lost - taken
        if before is not None and missing != before[1]:
            step = -missing * (taken - before[0]) / (missing - before[1])
        elif abs(missing) < SMALL_LOSS * abs(mean):
            step = missing
        else:  # losses in proportion to what is borne
            step = (mean - taken) * missing / (mean - taken + lost)
        before, taken = (taken, missing), taken + step
        balanced = _balanced(reducer, springs, (torque - taken) / parts, follow)
        if abs(step) < CORRECTED * abs(mean):
            break
    carried = (torque - taken) / parts
    output_turn = reducer.share * balanced.output_turn + wind_up(reducer) * carried / reducer.share
    return replace(balanced, gear_turn=balanced.output_turn - balanced.gear_turn, output_turn=output_turn)


def _balanced(reducer: Reducer, springs: Springs, torque: float | Array, follow: bool) -> Loads:
    """Compute what the contacts carry under a torque on the carrier [N m], all seen from the ring, and twist aside."""
    contacts, lever = springs.contacts, reducer.design.output.pin_circle_radius
    load = springs.load(torque)
    z, force = np.zeros(load.shape), np.zeros(contacts.distance.shape)
    of_discs = z[:, :-1].reshape(len(z), -1, 3)
    of_discs[..., :2] = contacts.cam_place
    with announced():
        search = balance(contacts, load, z, force, follow)
    require_balance(search, contacts, load)
    away = of_discs[..., :2] - contacts.cam_place
    distance = np.maximum(np.linalg.norm(away, axis=-1), np.finfo(float).tiny)
    pressed = contacts.cam_stiffness * np.maximum(distance - contacts.cam_clearance, 0.0)
    output = force[:, springs.teeth :]
    moments = (-output * contacts.slope[:, springs.teeth :, -1]).reshape(len(z), of_discs.shape[1], -1).sum(axis=-1)
    return Loads(
        teeth=force[:, : springs.teeth],
        output=output,
        cam=-(pressed / distance)[..., np.newaxis] * away,
        departures=z,
        gear_turn=of_discs[..., 2].mean(axis=1) / lever,
        output_turn=z[:, -1] / lever,
        share=moments / moments.sum(axis=1, keepdims=True),
        work=search.work / len(z),
    )


def require_balance(left: Left, contacts: KernelSprings, load: Array) -> None:
    """Raise RunError unless a balance was found under loads (k, u) [N]: a jam if friction alone forbids one."""
    if left.force <= BALANCED:
        return
    lost = f"no static balance was found: {left.force:.1%} of the load is left over"
    ways = "try a torque that differs by a per cent (--load-nm), or another play (clearance)"
    if not contacts.rubbing.size:
        raise RunError(f"{lost}; {ways}")
    borne = friction_borne(contacts, left.angle, load[left.angle])
    if borne < BORNE:
        near = ", and next to that limit forces are many times the load: play and give take the rest" * (borne >= 1.0)
        raise RunError(
            "no static balance: the friction is too large for the crank to turn under this load, whatever the torque "
            f"on the crank (even without play, a balance is found under at most {borne:.0%} of the friction{near})"
        )
    raise RunError(f"{lost}; it is not known to jam, as without play {BORNE:.0%} of the friction is borne; {ways}")


def transmission_error(reducer: Reducer, crank: npt.ArrayLike, torque: float) -> Array:
    """Compute the turn of gear and output from the ideal one [rad], shape (k, 2), at crank angles [rad], shape (k,).

    Without friction, and without inertia but the gear's centrifugal force at the speed of the design.

    Parameters
    ----------
    reducer
        Whose error.
    crank
        Crank angles [rad], shape (k,), which follow each other.
    torque
        On the output, in the sense of `member.share` [N m].

    Raises
    ------
    RunError
        No balance was found.
    """
    contact_loads = loads(reducer, springs_of(reducer, crank, friction=False), torque, follow=True)
    return np.stack([contact_loads.gear_turn, contact_loads.output_turn], axis=1)


def powers(reducer: Reducer, torque: float, crank: npt.ArrayLike | None = None) -> Powers:
    """Compute the mean powers under a torque on the output [N m] that brakes, or drives where it is negative.

    The mean is over crank angles [rad], shape (m,), one after the other; by default all round. Each search starts from
    the balances before: where friction is high, parts may also wedge, and a search of its own may end there.

    The crank turns at the design's speed, not 0; its torque is what the losses leave over of the load's. Seals on the
    output are carried by the contacts.

    Parameters
    ----------
    reducer
        Whose powers.
    torque
        On the output [N m].
    crank
        Crank angles [rad], shape (m,).

    Raises
    ------
    RunError
        No balance was found, as where the friction jams the reducer.
    """
    design = reducer.design
    springs, way, speed = springs_of(reducer, crank), np.sign(design.drive.speed), abs(design.drive.speed)
    contact_loads = loads(reducer, springs, float(way) * (torque + design.drag.output), follow=True)
    losses = _friction_losses(reducer, springs, contact_loads)
    seals = np.array(design.drag.crank * speed + design.drag.output * speed / design.reduction)
    mean = {part: float(np.mean(lost)) for part, lost in {**losses, "seals": seals}.items()}
    supplied = torque * speed / design.reduction
    return Powers(supplied + sum(mean.values()), -supplied, mean)


def _friction_losses(reducer: Reducer, springs: Springs, contact_loads: Loads) -> dict[str, Array]:
    """Compute the powers that friction takes at each crank angle [W], shape (m,)."""
    design = reducer.design
    slip, count = np.abs(springs.slip), springs.teeth
    turning = abs(float(design.drive.speed - reducer.member.gear_angle(design.drive.speed)))
    pressed = np.linalg.norm(contact_loads.cam, axis=-1).sum(axis=1)
    return {
        "teeth": design.mesh_friction * np.sum(contact_loads.teeth * slip[:, :count], axis=1),
        "cam": design.friction_of("cam") * design.gear.bore_radius * turning * pressed,
        "output": design.friction_of("output") * np.sum(contact_loads.output * slip[:, count:], axis=1),
    }
