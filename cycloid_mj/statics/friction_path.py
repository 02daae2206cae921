"""How far the output turns along a slow course of torque, with friction that remembers which way it slid.

Two benches are told apart. Where the crank is held, surfaces slide only as far as contacts give. Where the output is
held and the crank is turned, they slide with the crank, N - 1 times as fast; the torque is then that on the crank times
the ratio, the turn that of the crank over it, and the geometry that of the angle that it starts from. Weight is left
out there: of parts that lie in their play it alone presses the cam, which carries them round as it turns, and none of
that shows on a shaft.

A surface sticks on a tangential spring of its own, `STICK` times as stiff as its contact: parts that stick are rigid,
next to those that give. Constant friction comes on over a travel, as that of a seal or a bearing does (Dahl 1976): its
limits are shared by elements that slip one after the other, so that from rest it grows as 1 - exp(-turn/travel).
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import announced
from cycloid_mj.base.errors import RunError
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.gaps import arc_gaps, ideal_motion
from cycloid_mj.statics.kernel import KernelSprings, Rubbing, follow_path
from cycloid_mj.statics.springs import springs_of
from cycloid_mj.statics.structure import wind_up

Held = Literal["crank", "output"]

STICK = 20.0
"""Stiffness of a surface that sticks, over that of its contact across it: a creep law, as in a run, has no limit."""

BACKING = 1.0
"""Stiffness that a lossy material adds while it is let go, over its own: glassy plastics at most double theirs."""

SEALS = 8
"""Elements that share constant friction."""

LEAST_TRAVEL = 1e-6
"""Travel over which constant friction comes on at least [rad]."""

MOST_ROWS = 4
"""Most rows of a course that follows leaps, for each of its points on average."""


@dataclass(frozen=True)
class Losses:
    """What a loop loses beside the friction of the design's contacts.

    Attributes
    ----------
    drag
        Constant friction, at the output [N m].
    travel
        Turn of the output over which it comes on [rad].
    material
        Share of every contact's normal force that its material holds back while it is let go [1].
    load
        Friction in proportion to the torque that the contacts carry [1] (`statics.locked` alone: contacts that rub have
        their own).
    """

    drag: float = 0.0
    travel: float = 0.0
    material: float = 0.0
    load: float = 0.0


def course_along(
    reducer: Reducer, torque: Array, crank: float, losses: Losses, held: Held = "crank", reach: float = math.inf
) -> tuple[Array, Array]:
    """Compute where along a course of torque the output is, and its turn [rad], shape (rows,) each; it begins at rest.

    Where is counted in points of `torque` from its first. Each of them has a row; where the output turns by more than
    `reach` between two, there are rows between them, so that a leap across the play has the torque that it has.

    Parameters
    ----------
    reducer
        Whose clearances, errors, stiffness and friction count, and at a held crank its weight; drive and load do not.
    torque
        Shape (m,) [N m]: on the output, counter-clockwise; or on the crank times the ratio, that way.
    crank
        Angle at which the crank is held, or starts [rad].
    losses
        Beside the friction of the contacts.
    held
        Which shaft is held.
    reach
        Most turn of the output from row to row [rad].

    Raises
    ------
    RunError
        A step has no balance, as where friction jams the reducer.
    """
    still = reducer.but(drive={"speed": 0.0})
    if held == "output":
        still = still.but(environment={"gravity_x": 0.0, "gravity_y": 0.0})
    springs = springs_of(still, [crank], friction=False)
    radius = springs.contacts.radius
    path = np.repeat(springs.load(0.0), len(torque), axis=0)
    path[:, -1] = torque / radius
    rubbing = rubbing_of(still, springs.contacts, crank, losses, held)
    most = len(path) * (1 if math.isinf(reach) else MOST_ROWS)
    z, when = np.zeros((most, path.shape[1])), np.zeros(most)
    with announced():
        left, rows = follow_path(springs.contacts, rubbing, path, reach * radius, when, z)
    if left.force:
        raise RunError(f"no static balance along the loop: {left.force:.3g} of the load is left over")
    twisted = wind_up(reducer) * np.interp(when[:rows], np.arange(len(torque)), torque)
    return when[:rows], z[:rows, -1] / radius + twisted


def rubbing_of(reducer: Reducer, springs: KernelSprings, crank: float, losses: Losses, held: Held) -> Rubbing:
    """Return the friction of contacts, cams and seals, and how far each slides with the unknowns; as `course_along`.

    The springs are those at the crank angle [rad].
    """
    design = reducer.design
    mesh_gaps = arc_gaps(reducer, [crank])
    contacts, discs = mesh_gaps.kind.size, springs.cam_place.shape[1]
    radius, teeth, bore = springs.radius, design.ring.teeth, design.gear.bore_radius
    slip = np.zeros((contacts + discs + SEALS, springs.slope.shape[2]))
    slip[:contacts] = mesh_gaps.slip_slope[0]
    cams, seals = slice(contacts, contacts + discs), slice(contacts + discs, None)
    slip[range(contacts, contacts + discs), range(2, 3 * discs, 3)] = bore / radius
    slip[seals, -1] = 1.0
    if held == "output":
        # a crank that turns by N - 1 for each turn that the output is behind carries the ideal parts along
        ahead = ideal_motion(reducer, [crank])[0] * (design.lobes / radius)
        slip[:contacts, -1] += mesh_gaps.slip_slope[0] @ ahead
        slip[cams, -1] = -teeth * bore / radius
    friction = {kind: design.friction_of(kind) for kind in ("cam", "output")} | {
        design.tooth_pair: design.mesh_friction
    }
    stiffness = np.concatenate([springs.stiffness[0], np.full(discs, springs.cam_stiffness)])
    drag = np.full(SEALS, losses.drag / radius / SEALS)
    lossy = losses.material * (np.arange(len(slip)) < contacts + discs)
    return Rubbing(
        slip=slip,
        coefficient=np.array(
            [*(friction[kind] for kind in mesh_gaps.kind), *[friction["cam"]] * discs, *[0.0] * SEALS]
        ),
        drag=drag,
        stick=np.concatenate([STICK * stiffness, drag / (radius * slip_turns(losses.travel))]),
        loss=lossy,
        backing=np.concatenate([BACKING * stiffness, np.zeros(SEALS)]) * (lossy > 0.0),
    )


def slip_turns(travel: float, count: int = SEALS) -> Array:
    """Compute the turn at which each of the elements that share constant friction slips [rad], shape (count,).

    Friction that grows as 1 - exp(-x/travel) is that of elements whose limits are spread as x exp(-x/travel) is.
    """
    from scipy.special import gammaincinv

    return np.asarray(max(travel, LEAST_TRAVEL) * gammaincinv(2.0, (np.arange(count) + 0.5) / count))
