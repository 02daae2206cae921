"""Rotation of the output along a slow torque path, with elastoplastic (stick-slip) friction.

There are two test benches. With the crank locked, surfaces slide only as far as contacts deflect. With the output
locked and the crank rotating, they slide with the crank, N - 1 times as fast; the torque is then that on the crank
times the ratio, the rotation that of the crank over the ratio, and the geometry that of the initial angle. Weight is
left out there: it presses parts that rest in their clearances onto the cam, which carries them around without effect on
a shaft.

A sticking surface is a tangential spring, much stiffer than its contact. Constant friction builds up over a travel, as
that of a seal or a bearing (Dahl 1976): its limits are distributed over elements that slip in turn, so that from rest
it grows as 1 - exp(-rotation/travel).
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import announce_compilation
from cycloid_mj.base.errors import RunError
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.gaps import arc_gaps, ideal_motion
from cycloid_mj.statics.kernel import PATH_RESIDUAL_RTOL, FrictionElements, KernelSprings, follow_path
from cycloid_mj.statics.springs import Springs, springs_of
from cycloid_mj.statics.structure import wind_up

Held = Literal["crank", "output"]


@dataclass(frozen=True)
class FrictionPathSettings:
    """Friction elements of surfaces and seals, and rows of a path.

    Attributes
    ----------
    sticking_stiffness
        Tangential stiffness of a sticking surface over the normal stiffness of its contact.
    unloading_stiffness
        Additional stiffness of a lossy material during unloading, over its own: glassy plastics at most double theirs.
    seal_elements
        Elements of constant friction.
    min_travel
        Smallest travel over which constant friction builds up [rad].
    max_rows
        Largest number of rows of a path with jumps, per point of the path.
    min_step
        Smallest part of a step of the path: a step that has no equilibrium is halved until it has one.
    """

    sticking_stiffness: float = 20.0
    unloading_stiffness: float = 1.0
    seal_elements: int = 8
    min_travel: float = 1e-6
    max_rows: int = 4
    min_step: float = 1.0 / 16.0


_SETTINGS = FrictionPathSettings()


@dataclass(frozen=True)
class Losses:
    """Losses of a hysteresis loop in addition to the friction of the design's contacts.

    Attributes
    ----------
    drag
        Constant friction at the output [N m].
    travel
        Rotation of the output over which it builds up [rad].
    material
        Share of the normal force of each contact that its material retains during unloading [1].
    load
        Friction proportional to the torque of the contacts [1], for `statics.locked` only: here contacts have friction.
    """

    drag: float = 0.0
    travel: float = 0.0
    material: float = 0.0
    load: float = 0.0


def follow_torque_path(
    reducer: Reducer,
    torque: Array,
    crank: float,
    losses: Losses,
    locked_shaft: Held = "crank",
    max_rotation: float = math.inf,
) -> tuple[Array, Array]:
    """Compute the rotation of the output along a torque path with stick-slip friction, from rest.

    Parameters
    ----------
    reducer
        The reducer. Its drive and load are ignored, and with the output locked also its weight.
    torque
        Torque path, shape (m,) [N m], counter-clockwise positive: torque on the output, or, with the output locked,
        torque on the crank times the ratio.
    crank
        Angle of the locked crank, or initial angle of the crank [rad].
    losses
        Losses in addition to the friction of the contacts.
    locked_shaft
        The locked shaft, "crank" or "output"; the torque acts on the other.
    max_rotation
        Largest rotation of the output between rows [rad].

    Returns
    -------
    tuple of Array
        Positions on the path as fractional indices of `torque`, and rotations there [rad], shape (rows,) each: a row
        for each point, and further rows where the output rotates by more than `max_rotation` between two points.

    Raises
    ------
    RunError
        A step has no equilibrium, even in small parts, for example because friction jams the reducer.
    """
    resting_reducer = reducer.but(drive={"speed": 0.0})
    if locked_shaft == "output":
        resting_reducer = resting_reducer.but(environment={"gravity_x": 0.0, "gravity_y": 0.0})
    springs = springs_of(resting_reducer, [crank], friction=False)
    friction_elements = build_friction_elements(resting_reducer, springs.contacts, crank, losses, locked_shaft)
    points = np.arange(len(torque), dtype=float)
    while True:
        point_torque = np.interp(points, np.arange(len(torque)), torque)
        residual, positions, rotations = _solve_path(springs, friction_elements, point_torque, max_rotation)
        if not residual:
            break
        failed_step = int(positions[-1]) + 1 if len(positions) else 0
        if failed_step == 0 or points[failed_step] - points[failed_step - 1] <= _SETTINGS.min_step:
            step_text = f"step {math.ceil(points[failed_step]) + 1} of {len(torque)}"
            raise _equilibrium_error(float(point_torque[failed_step]), locked_shaft, step_text, residual)
        points = np.insert(points, failed_step, 0.5 * (points[failed_step - 1] + points[failed_step]))
    positions = np.interp(positions, np.arange(len(points)), points)
    if math.isinf(max_rotation):
        positions, rotations = (column[positions == np.floor(positions)] for column in (positions, rotations))
    return positions, rotations + wind_up(reducer) * np.interp(positions, np.arange(len(torque)), torque)


def _solve_path(
    springs: Springs, friction_elements: FrictionElements, torque: Array, max_rotation: float
) -> tuple[float, Array, Array]:
    """Solve for the static equilibria along a torque path from rest, as far as they exist.

    Parameters
    ----------
    springs, friction_elements
        Contact springs at one crank angle without friction, and the friction elements.
    torque
        Torques on the output in the order of the path [N m], shape (torques,).
    max_rotation
        Rotation of the output [rad] above which a step of the path is halved, with a row for each part; inf: none.

    Returns
    -------
    tuple
        Residual of the failed step over the largest load [1], or 0; and of each row the position on the path as a
        fractional index, and the rotation of the output by contacts alone [rad], shape (rows,) each.
    """
    radius = springs.contacts.radius
    path = np.repeat(springs.load(0.0), len(torque), axis=0)
    path[:, -1] = torque / radius
    max_rows = len(path) * (1 if math.isinf(max_rotation) else _SETTINGS.max_rows)
    displacements, positions = np.zeros((max_rows, path.shape[1])), np.zeros(max_rows)
    with announce_compilation():
        residual, row_count = follow_path(
            springs.contacts, friction_elements, path, max_rotation * radius, positions, displacements
        )
    return residual.force, positions[:row_count], displacements[:row_count, -1] / radius


def _equilibrium_error(torque: float, locked_shaft: Held, step_text: str, residual: float) -> RunError:
    """Return the error to raise if the path of loads with friction has no equilibrium at a torque [N m].

    `locked_shaft` is the name of the locked shaft, `step_text` names the step of the path, and `residual` the residual
    force over the largest load [1].
    """
    shaft = "output" if locked_shaft == "crank" else "crank times the ratio"
    return RunError(
        f"no static equilibrium at {torque:.4g} N m on the {shaft}, {step_text} of the torque loop: the residual is "
        f"{residual:.3g} of the largest load, but at most {PATH_RESIDUAL_RTOL:.0e} is allowed. Compute the loop at "
        "more points, or reduce its torque"
    )


def build_friction_elements(
    reducer: Reducer, springs: KernelSprings, crank: float, losses: Losses, locked_shaft: Held
) -> FrictionElements:
    """Build the friction elements of contacts, cams and seals, in this order, with one shaft locked.

    Each element is a tangential spring that slips at a limit, see `FrictionElements`.

    Parameters
    ----------
    reducer
        The reducer.
    springs
        Contact springs at the angle `crank`, without friction.
    crank
        Angle of the locked crank, or initial angle of the crank [rad].
    losses
        Losses in addition to the friction of the contacts.
    locked_shaft
        The locked shaft. With a locked output, the last unknown is the output angle that corresponds to the crank's
        rotation.
    """
    design = reducer.design
    mesh_gaps = arc_gaps(reducer, [crank])
    contact_count, disc_count, seal_count = mesh_gaps.kind.size, springs.cam_position.shape[1], _SETTINGS.seal_elements
    radius, ring_teeth, bore_radius = springs.radius, design.ring.teeth, design.gear.bore_radius
    sliding = np.zeros((contact_count + disc_count + seal_count, springs.slope.shape[2]))
    sliding[:contact_count] = mesh_gaps.slip_slope[0]
    cam_rows, seal_rows = slice(contact_count, contact_count + disc_count), slice(contact_count + disc_count, None)
    sliding[range(contact_count, contact_count + disc_count), range(2, 3 * disc_count, 3)] = bore_radius / radius
    sliding[seal_rows, -1] = 1.0
    if locked_shaft == "output":
        # the crank rotates by N - 1 per rotation of the output, and carries the ideal parts along
        carried_motion = ideal_motion(reducer, [crank])[0] * (design.lobes / radius)
        sliding[:contact_count, -1] += mesh_gaps.slip_slope[0] @ carried_motion
        sliding[cam_rows, -1] = -ring_teeth * bore_radius / radius
    coefficients = {kind: design.friction_of(kind) for kind in ("cam", "output")} | {
        design.tooth_pair: design.mesh_friction
    }
    stiffness = np.concatenate([springs.stiffness[0], np.full(disc_count, springs.cam_stiffness)])
    seal_limits = np.full(seal_count, losses.drag / radius / seal_count)
    material_loss = losses.material * (np.arange(len(sliding)) < contact_count + disc_count)
    return FrictionElements(
        slip=sliding,
        coefficient=np.array(
            [*(coefficients[kind] for kind in mesh_gaps.kind), *[coefficients["cam"]] * disc_count, *[0.0] * seal_count]
        ),
        drag=seal_limits,
        stiffness=np.concatenate(
            [_SETTINGS.sticking_stiffness * stiffness, seal_limits / (radius * slip_rotations(losses.travel))]
        ),
        retained_share=material_loss,
        retained_stiffness=np.concatenate([_SETTINGS.unloading_stiffness * stiffness, np.zeros(seal_count)])
        * (material_loss > 0.0),
    )


def slip_rotations(travel: float, count: int = _SETTINGS.seal_elements) -> Array:
    """Compute the rotations at which `count` friction elements of equal limits slip [rad], increasing, shape (count,).

    Elements that slip at these rotations have together a friction that grows as 1 - exp(-x/travel) with the rotation x
    from rest. `travel` is in [rad].
    """
    from scipy.special import gammaincinv

    return np.asarray(max(travel, _SETTINGS.min_travel) * gammaincinv(2.0, (np.arange(count) + 0.5) / count))
