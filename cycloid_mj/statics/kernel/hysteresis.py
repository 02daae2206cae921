"""Equilibria along a load path with elastoplastic friction: backward Euler with return mapping."""

from typing import NamedTuple

import numpy as np

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.compiling import cacheable, njit
from cycloid_mj.statics.kernel.contacts import (
    FALSE,
    FIRST,
    TRUE,
    Gap,
    KernelSprings,
    bound_width,
    curve_offset,
    disc_pose,
    gap_at,
)
from cycloid_mj.statics.kernel.newton import (
    PATH_RESIDUAL_RTOL,
    RIGID_BODY_STIFFNESS,
    ROUNDING,
    Residual,
    clear,
    copy,
    largest,
    modified_newton_step,
    solve_cholesky,
    solve_linear,
)
from cycloid_mj.statics.kernel.system import State, cam_at

MAX_SUBSTEPS = 1024
"""Largest number of parts of a step along a path in which the output jumps (heuristic)."""


class HysteresisSettings(NamedTuple):
    """Settings of the steps along a path with elastoplastic friction (`follow_path`).

    A step is solved by Newton's method with the consistent tangent (Simo & Hughes, Computational Inelasticity, 1998),
    then by a fixed-point iteration of Tresca friction problems (Haslinger 1983), then by pseudo-transient continuation
    (Kelley & Keyes, SIAM J. Numer. Anal. 35 (1998), 508-523).

    Attributes
    ----------
    newton_steps
        Newton steps before the Tresca iteration.
    tresca_iterations
        Tresca iterations, and Newton steps in each.
    tresca_work
        Largest number of assemblies in a Tresca iteration.
    undamped_iterations
        Tresca iterations before the update of the limits is damped, and largest number of halvings of a Newton step.
    damped_update
        Share by which the limits are updated then.
    work_per_step
        Largest number of assemblies per step of the path, on average; beyond it, pseudo-transient continuation follows.
    min_step
        Smallest share of a step before pseudo-transient continuation.
    max_step
        Largest component of a Newton step, relative to the smallest radius of curvature of the contacts.
    pseudo_steps
        Largest number of pseudo time steps.
    decrease, increase
        Factors on the inverse pseudo time step after a step that converged, and after one that did not.
    max_stiffness
        Inverse pseudo time step beyond which the continuation fails, relative to the cam's stiffness, its first value.
    """

    newton_steps: int = 12
    tresca_iterations: int = 40
    tresca_work: int = 2000
    undamped_iterations: int = 20
    damped_update: float = 0.3
    work_per_step: int = 150
    min_step: float = 1.0 / 16.0
    max_step: float = 0.5
    pseudo_steps: int = 2000
    decrease: float = 0.5
    increase: float = 8.0
    max_stiffness: float = 1e8


_HYSTERESIS = HysteresisSettings()


class FrictionElements(NamedTuple):
    """Friction elements (Prandtl-Jenkin) of n contacts, D cams and e seals, in this order: s = n + D + e.

    Each is a tangential spring that slips at its limit and keeps its force between steps. `slip` (s, u) [1] is the
    sliding per unknown; the sliding of a disc across its cam is added during the solution. `coefficient` (s,) [1] is
    the limit per normal force, and `drag` (e,) [N] the limit of the seals. `stiffness` (s,) [N/m] is that below the
    limit.

    `retained_share` (s,) [1] is the share of a contact's normal force that its material retains during unloading, as a
    further spring of the stiffness `retained_stiffness` (s,) [N/m] along the normal that slips, too.
    """

    slip: Array
    coefficient: Array
    drag: Array
    stiffness: Array
    retained_share: Array
    retained_stiffness: Array


class _ElastoplasticState(NamedTuple):
    """State at the end of a step: displacements `z` (u,) [m], and forces of s elements, each of shape (s,).

    `friction_force` [N], and `retained_force` [N] of the lossy material; `spring_force` [N] and deflection `depth` [m]
    of the contact spring. `slip` (s, u) [1] is the sliding per unknown in the next step.
    """

    z: Array
    friction_force: Array
    retained_force: Array
    spring_force: Array
    depth: Array
    slip: Array


class _Increment(NamedTuple):
    """A step of a path: `load` [N], `residual`, `tangent` and Newton step, and workspace.

    `friction_limit` and `retained_limit` (s,) are the fixed limits of friction and material in a Tresca iteration;
    otherwise the limits follow from the normal forces, and the tangent is not symmetric. `drag` (1,) [N/m] is the
    inverse pseudo time step, or the regularization of rigid-body modes. `gradient` (u,) [1] is that of the current
    contact's depth. `work` (1,) counts the assemblies; `vectors` (u, u) are for `modified_newton_step`.
    """

    load: Array
    residual: Array
    tangent: Array
    step: Array
    start: Array
    gradient: Array
    friction_limit: Array
    retained_limit: Array
    drag: Array
    work: Integers
    vectors: Array


def follow_path(
    springs: KernelSprings,
    friction_elements: FrictionElements,
    path: Array,
    max_motion: float,
    positions: Array,
    z: Array,
) -> tuple[Residual, int]:
    """Solve for equilibrium along a load path at the first crank angle of `springs`, with elastoplastic friction.

    Each step is an equilibrium with the friction forces at its end (backward Euler). A step without solution is halved,
    and then solved by pseudo-transient continuation. A step in which the output jumps, as across the backlash, is
    halved too, into at most ``MAX_SUBSTEPS`` parts. There are u unknown displacements.

    Parameters
    ----------
    springs, friction_elements
        Contact springs without friction, and friction elements.
    path
        Generalised loads (m, u) [N]. The first step leads from no load to the first of them.
    max_motion
        Displacement of the output [m], as an arc length at `springs.radius`, above which a step is halved.
    positions, z
        Output arrays (rows,) and (rows, u) [m], rows >= m: position on the path, as a fractional index of its loads,
        and displacements there. Each load has a row, from the first load on; rows beyond m are for the parts of halved
        steps. On entry, the first row of z must contain the displacements at rest; it is overwritten.

    Returns
    -------
    tuple of Residual and int
        Residual, and number of rows that are filled in. The residual force is 0 if the whole path was solved. If a step
        has no equilibrium, it is the residual of this step divided by the largest load of the path.
    """
    element_count, unknowns = friction_elements.stiffness.size, path.shape[1]
    old_state, new_state = _allocate_state(element_count, unknowns), _allocate_state(element_count, unknowns)
    increment = _allocate_increment(element_count, unknowns)
    return _follow_path(springs, friction_elements, path, max_motion, positions, z, increment, old_state, new_state)


@njit(cache=cacheable(), allocates=False, nogil=True, error_model="numpy")
def _follow_path(
    springs: KernelSprings,
    friction_elements: FrictionElements,
    path: Array,
    max_motion: float,
    positions: Array,
    z: Array,
    increment: _Increment,
    old: _ElastoplasticState,
    new: _ElastoplasticState,
) -> tuple[Residual, int]:
    """Solve for equilibrium of contact springs with friction along a `path` of loads, with a given workspace.

    `path` (m, u) [N] are m loads on the u unknown displacements, and `friction_elements` are springs that slip at a
    limit. `max_motion` [m] is the displacement of the output above which a step is halved. Output arrays are
    `positions` (rows,), the fractional index in `path` of each solved step, and `z` (rows, u) [m], the displacements
    there. Residual and number of filled rows are returned, as by `follow_path`. `increment`, and the states `old` and
    `new` before and after a step, are the workspace, from `_allocate_increment` and `_allocate_state`.
    """
    load_count, unknowns = path.shape
    increment.drag[0] = RIGID_BODY_STIFFNESS * springs.cam_stiffness
    copy(z[0], old.z)
    load_size, filled_rows, spare_rows = 0.0, 0, positions.size - load_count
    min_share = 1.0 / MAX_SUBSTEPS if spare_rows > 0 else 1.0
    for load_index in range(load_count):
        load_size = max(load_size, largest(path[load_index]))
    tolerance = PATH_RESIDUAL_RTOL * load_size
    for load_index in range(load_count):
        share, solved_share, min_step = 1.0, 0.0, min_share
        while solved_share < 1.0:
            share = min(share, 1.0 - solved_share)
            _interpolate_load(path, load_index, solved_share + share, increment.load)
            _update_slip(springs, friction_elements, old)
            norm = _solve_newton(springs, friction_elements, tolerance, increment, old, new) / load_size
            is_rejected = not norm <= PATH_RESIDUAL_RTOL or abs(new.z[unknowns - 1] - old.z[unknowns - 1]) > max_motion
            if is_rejected and load_index > 0 and share > min_step and spare_rows > 0:
                share *= 0.5
                continue
            if not norm <= PATH_RESIDUAL_RTOL and increment.work[0] <= _HYSTERESIS.work_per_step * load_count:
                norm = _solve_tresca(springs, friction_elements, tolerance, increment, old, new) / load_size
            if not norm <= PATH_RESIDUAL_RTOL:
                if share < _HYSTERESIS.min_step and min_step < _HYSTERESIS.min_step:
                    # close to a jump there is no equilibrium: it is taken in a longer step
                    share, min_step = _HYSTERESIS.min_step, _HYSTERESIS.min_step
                    continue
                if share > _HYSTERESIS.min_step and increment.work[0] <= _HYSTERESIS.work_per_step * load_count:
                    share *= 0.5
                    continue
                norm = _solve_pseudo_transient(springs, friction_elements, tolerance, increment, old, new) / load_size
                if not norm <= PATH_RESIDUAL_RTOL:
                    return Residual(norm, 0, increment.work[0]), filled_rows
            solved_share += share
            share *= 2.0
            old, new = new, old
            if solved_share >= 1.0 or (load_index > 0 and spare_rows > 0):
                copy(old.z, z[filled_rows])
                positions[filled_rows] = float(load_index) if solved_share >= 1.0 else load_index - 1.0 + solved_share
                spare_rows -= 0 if solved_share >= 1.0 else 1
                filled_rows += 1
    return Residual(0.0, 0, increment.work[0]), filled_rows


@njit(nogil=True, error_model="numpy", inline="always")
def _interpolate_load(path: Array, load_index: int, share: float, load: Array) -> None:
    """Interpolate a load path: write the load [N] at a `share` [1] of a step to `load` (u,).

    The step leads from the load of index `load_index` - 1 to that of index `load_index`; the first begins without load.
    `path` has the shape (loads, u) for u unknowns.
    """
    for j in range(load.size):
        previous_load = path[load_index - 1, j] if load_index else 0.0
        load[j] = previous_load + (path[load_index, j] - previous_load) * share


def assemble_after(
    springs: KernelSprings,
    friction_elements: FrictionElements,
    middle: Array,
    load: Array,
    z: Array,
    fixed_limits: bool,
) -> State:
    """Assemble energy, residual and tangent of the second of two load steps, with friction.

    The first step leads from rest to the displacements `middle`, the second from there to `z`, (u,) [m] for u unknowns.
    Contacts are `springs` without friction; `friction_elements` slip at a limit. The `load` (u,) [N] acts at z. Neither
    displacement needs to be an equilibrium. The friction limits follow from the normal forces at z, as in
    `follow_path`. With `fixed_limits` they follow from those at `middle`; then the residual is the negative gradient of
    the energy, and the tangent is symmetric.
    """
    unknown_count, element_count = z.size, friction_elements.stiffness.size
    rest_state, old_state, new_state = (_allocate_state(element_count, unknown_count) for _ in range(3))
    increment = _allocate_increment(element_count, unknown_count)
    old_state.z[:], new_state.z[:], increment.load[:] = middle, z, load
    energy = _assemble_two_steps(springs, friction_elements, fixed_limits, increment, rest_state, old_state, new_state)
    return State(energy, increment.residual, increment.tangent)


@njit(cache=cacheable(), allocates=False, nogil=True, error_model="numpy")
def _assemble_two_steps(
    springs: KernelSprings,
    friction_elements: FrictionElements,
    fixed_limits: bool,
    increment: _Increment,
    rest_state: _ElastoplasticState,
    old_state: _ElastoplasticState,
    new_state: _ElastoplasticState,
) -> float:
    """Assemble load steps from rest to the displacements of `old_state`, then to `new_state`; return the last energy.

    Contacts are `springs` without friction; `friction_elements` slip at a limit. Returned energy [J], and residual and
    tangent in `increment`, refer to the second step, under ``increment.load``. `rest_state` is the unloaded state
    before both steps. With `fixed_limits`, the friction limits follow from the normal forces of `old_state`.
    """
    increment.drag[0] = RIGID_BODY_STIFFNESS * springs.cam_stiffness
    _update_slip(springs, friction_elements, rest_state)
    _assemble_step(springs, friction_elements, FALSE, increment, rest_state, old_state)
    _update_slip(springs, friction_elements, old_state)
    _update_limits(friction_elements, increment, old_state, 1.0)
    return _assemble_step(springs, friction_elements, fixed_limits, increment, old_state, new_state)[1]


def _allocate_increment(element_count: int, unknown_count: int) -> _Increment:
    """Allocate the workspace of a load step, for `element_count` friction elements and `unknown_count` unknowns."""
    return _Increment(
        np.zeros(unknown_count),
        np.zeros(unknown_count),
        np.zeros((unknown_count, unknown_count)),
        np.zeros(unknown_count),
        np.zeros(unknown_count),
        np.zeros(unknown_count),
        np.zeros(element_count),
        np.zeros(element_count),
        np.zeros(1),
        np.zeros(1, np.int64),
        np.zeros((unknown_count, unknown_count)),
    )


def _allocate_state(element_count: int, unknown_count: int) -> _ElastoplasticState:
    """Allocate the state of unloaded parts at rest, by the numbers `element_count` and `unknown_count`.

    These are the numbers of friction elements and of unknown displacements.
    """
    return _ElastoplasticState(
        np.zeros(unknown_count),
        np.zeros(element_count),
        np.zeros(element_count),
        np.zeros(element_count),
        np.zeros(element_count),
        np.zeros((element_count, unknown_count)),
    )


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _update_slip(springs: KernelSprings, friction_elements: FrictionElements, state: _ElastoplasticState) -> None:
    """Overwrite ``state.slip``: derivatives of the sliding distance of each friction element by the displacements.

    Its shape is (elements, unknowns). Derivatives of contacts and seals are copied from `friction_elements`; the
    sliding direction of a cam depends on the displacement of its disc, see `springs`.
    """
    for i in range(len(state.slip)):
        copy(friction_elements.slip[i], state.slip[i])
    for disc in range(springs.cam_position.shape[1]):
        contact, element = cam_at(springs, FIRST, disc, state.z), springs.disc.size + disc
        state.slip[element, 3 * disc] -= contact.v
        state.slip[element, 3 * disc + 1] += contact.u


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _solve_newton(
    springs: KernelSprings,
    friction_elements: FrictionElements,
    tolerance: float,
    increment: _Increment,
    old_state: _ElastoplasticState,
    new_state: _ElastoplasticState,
) -> float:
    """Solve for the equilibrium after a load step by Newton's method with the consistent tangent.

    Contacts are `springs` without friction; `friction_elements` slip at a limit. `old_state` is the state before the
    step, `new_state` the state after it, which is overwritten. Returns the residual norm [N]; up to `tolerance` it is a
    solution. `increment` has the load and the workspace.
    """
    copy(old_state.z, new_state.z)
    max_length = _HYSTERESIS.max_step / largest(springs.curvature[0])
    norm = _assemble_step(springs, friction_elements, FALSE, increment, old_state, new_state)[0]
    for _ in range(_HYSTERESIS.newton_steps):
        if norm <= tolerance or solve_linear(increment.tangent, increment.residual, increment.step, 0.0) == 0.0:
            break
        step_share = min(1.0, max_length / max(largest(increment.step), 1e-300))
        for j in range(increment.step.size):
            new_state.z[j] += step_share * increment.step[j]
        norm = _assemble_step(springs, friction_elements, FALSE, increment, old_state, new_state)[0]
    return norm


@njit(nogil=True, error_model="numpy", inline="always")
def _solve_tresca(
    springs: KernelSprings,
    friction_elements: FrictionElements,
    tolerance: float,
    increment: _Increment,
    old_state: _ElastoplasticState,
    new_state: _ElastoplasticState,
) -> float:
    """Solve for the equilibrium after a load step by a fixed-point iteration of the friction limits (Tresca).

    Contacts are `springs` without friction; `friction_elements` slip at a limit. While the limits are fixed, the
    solution minimizes an energy, and Newton's method with backtracking finds it. `tolerance` is the residual norm of a
    solution [N], `old_state` the state before the step and `new_state` that after it, which is overwritten. `increment`
    has the load and the workspace. Returns the residual norm [N].
    """
    copy(old_state.z, new_state.z)
    max_length = _HYSTERESIS.max_step / largest(springs.curvature[0])
    regularization = RIGID_BODY_STIFFNESS * springs.cam_stiffness
    norm = np.inf
    work_before = increment.work[0]
    for iteration in range(_HYSTERESIS.tresca_iterations):
        if increment.work[0] - work_before > _HYSTERESIS.tresca_work:
            break
        relaxation = 1.0 if iteration < _HYSTERESIS.undamped_iterations else _HYSTERESIS.damped_update
        _update_limits(friction_elements, increment, new_state if iteration else old_state, relaxation)
        inner_norm, energy = _assemble_step(springs, friction_elements, TRUE, increment, old_state, new_state)
        for _ in range(_HYSTERESIS.tresca_iterations):
            if inner_norm <= 0.1 * tolerance:
                break
            if not solve_cholesky(increment.tangent, increment.residual, increment.step, regularization):
                _assemble_step(springs, friction_elements, TRUE, increment, old_state, new_state)
                modified_newton_step(
                    increment.tangent, increment.residual, increment.step, regularization, increment.vectors
                )
            copy(new_state.z, increment.start)
            step_share = min(1.0, max_length / max(largest(increment.step), 1e-300))
            for _ in range(_HYSTERESIS.undamped_iterations):
                for j in range(increment.step.size):
                    new_state.z[j] = increment.start[j] + step_share * increment.step[j]
                inner_norm, trial_energy = _assemble_step(
                    springs, friction_elements, TRUE, increment, old_state, new_state
                )
                if trial_energy <= energy + ROUNDING * abs(energy):
                    break
                step_share *= 0.5
            energy = trial_energy
        norm = _assemble_step(springs, friction_elements, FALSE, increment, old_state, new_state)[0]
        if norm <= tolerance:
            break
    return norm


@njit(nogil=True, error_model="numpy", inline="always")
def _solve_pseudo_transient(
    springs: KernelSprings,
    friction_elements: FrictionElements,
    tolerance: float,
    increment: _Increment,
    old_state: _ElastoplasticState,
    new_state: _ElastoplasticState,
) -> float:
    """Solve for the equilibrium after a load step by pseudo-transient continuation; return the residual norm [N].

    If there is no equilibrium nearby, parts jump to a distant equilibrium, which depends on the work of friction on the
    way to it. With enough viscous drag (a short pseudo time step), the solution of each pseudo time step is unique.
    Contacts are `springs` without friction; `friction_elements` slip at a limit. `increment` has the load and the
    workspace. `tolerance` is the residual norm of a solution [N]. Both states, `old_state` before and `new_state` after
    the step, are overwritten by the solution.
    """
    regularization = RIGID_BODY_STIFFNESS * springs.cam_stiffness
    drag, norm = springs.cam_stiffness, np.inf
    for _ in range(_HYSTERESIS.pseudo_steps):
        increment.drag[0] = drag
        _update_slip(springs, friction_elements, old_state)
        if (
            _solve_newton(springs, friction_elements, 0.5 * tolerance, increment, old_state, new_state)
            <= 0.5 * tolerance
        ):
            norm = 0.0
            for j in range(increment.load.size):
                norm = max(norm, abs(drag * (new_state.z[j] - old_state.z[j])))
            _copy_state(new_state, old_state)
            if norm <= 0.5 * tolerance:
                break
            drag = max(_HYSTERESIS.decrease * drag, regularization)
        else:
            norm = np.inf
            drag *= _HYSTERESIS.increase
            if drag > _HYSTERESIS.max_stiffness * springs.cam_stiffness:
                break
    increment.drag[0] = regularization
    return norm


@njit(nogil=True, error_model="numpy", inline="always")
def _copy_state(source: _ElastoplasticState, target: _ElastoplasticState) -> None:
    """Copy the arrays of a state to the `target`, except its sliding per unknown, `slip`."""
    copy(source.z, target.z)
    copy(source.friction_force, target.friction_force)
    copy(source.retained_force, target.retained_force)
    copy(source.spring_force, target.spring_force)
    copy(source.depth, target.depth)


@njit(nogil=True, error_model="numpy", inline="always")
def _update_limits(
    friction_elements: FrictionElements, increment: _Increment, state: _ElastoplasticState, share: float
) -> None:
    """Move the fixed slip limits of `friction_elements`, in `increment`, towards those under the forces of `state`.

    `share` [1] is the share of the difference by which they move.
    """
    for i in range(increment.friction_limit.size):
        spring_force = state.spring_force[i]
        increment.retained_limit[i] += share * (
            friction_elements.retained_share[i] * spring_force - increment.retained_limit[i]
        )
        increment.friction_limit[i] += share * (
            friction_elements.coefficient[i] * (spring_force + state.retained_force[i]) - increment.friction_limit[i]
        )


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _assemble_step(
    springs: KernelSprings,
    friction_elements: FrictionElements,
    fixed_limits: bool,
    increment: _Increment,
    old_state: _ElastoplasticState,
    new_state: _ElastoplasticState,
) -> tuple[float, float]:
    """Assemble residual and tangent of a load step at the displacements of `new_state`, and write them to `increment`.

    Contacts are `springs` without friction; `friction_elements` slip at a limit. `old_state` is the state before the
    step. The forces of springs and friction, and those that the material retains during unloading, are written to
    `new_state`. With `fixed_limits`, the limits of friction and of the retained forces are taken from `increment`; the
    residual is then the negative gradient of the energy, and the tangent is symmetric.

    Returns
    -------
    tuple of float
        Residual norm [N] and energy [J].
    """
    increment.work[0] += 1
    unknown_count, contacts, z = increment.load.size, springs.disc.size, new_state.z
    drag, energy, gradient = increment.drag[0], 0.0, increment.gradient
    for j in range(unknown_count):
        displacement_change = z[j] - old_state.z[j]
        increment.residual[j] = increment.load[j] - drag * displacement_change
        energy += (0.5 * drag * displacement_change - increment.load[j]) * displacement_change
        for column in range(unknown_count):
            increment.tangent[j, column] = drag if j == column else 0.0
    for i in range(contacts):
        x_dof, rotation_dof, output_dof = 3 * springs.disc[i], 3 * springs.disc[i] + 2, unknown_count - 1
        pose = disc_pose(springs, springs.disc[i], z)
        offset = curve_offset(springs, FIRST, i, pose)
        clear(gradient)
        depth = 0.0
        if bound_width(springs, FIRST, i, offset, FALSE) == 0.0:
            gap = gap_at(springs, FIRST, i, pose, offset, FALSE)
            depth = max(-gap.width, 0.0)
            if depth > 0.0:
                gradient[x_dof], gradient[x_dof + 1], gradient[rotation_dof], gradient[output_dof] = gap.normal
        energy += _add_contact(
            friction_elements, fixed_limits, i, springs.stiffness[0, i], depth, increment, old_state, new_state
        )
        if depth == 0.0:
            continue
        force = new_state.spring_force[i] + new_state.retained_force[i]
        _add_geometric_stiffness(increment.tangent, x_dof, gap, force, force / springs.radius, springs.rotates[i])
    for disc in range(springs.cam_position.shape[1]):
        energy += _add_cam(springs, friction_elements, fixed_limits, disc, increment, old_state, new_state)
    for seal in range(friction_elements.drag.size):
        i = contacts + springs.cam_position.shape[1] + seal
        energy += _add_friction(
            friction_elements, i, friction_elements.drag[seal], 0.0, increment, old_state, new_state
        )
    return largest(increment.residual), energy


@njit(nogil=True, error_model="numpy", inline="always")
def _add_geometric_stiffness(
    tangent: Array, x: int, gap: Gap, force: float, rotation_stiffness: float, rotates: bool
) -> None:
    """Add the geometric stiffness of a contact under a `force` [N] to the tangent stiffness [N/m].

    It has two terms. Because the contact normal rotates, -`force` ``gap.rate`` times the outer product of the gradients
    ``gap.tangential`` is added. Because the parts rotate, `rotation_stiffness` [N/m] couples their rotation with the
    motion along these gradients. Rotations are multiplied by the radius of the output pins. The disc's unknowns begin
    at index `x`; `rotates` is whether the profile rotates with the disc.
    """
    y, t, output_dof = x + 1, x + 2, len(tangent) - 1
    # p: gradient along the tangent by x, y and rotation t of the disc, and by the rotation o of the output
    (p_x, p_y, p_t, p_o), normal_rotation = gap.tangential, -force * gap.rate
    disc_coupling = rotation_stiffness if rotates else 0.0
    rotation_term = disc_coupling if rotates else -rotation_stiffness
    tangent[x, x] += normal_rotation * p_x * p_x
    tangent[y, y] += normal_rotation * p_y * p_y
    tangent[t, t] += normal_rotation * p_t * p_t + rotation_term * p_t
    tangent[output_dof, output_dof] += normal_rotation * p_o * p_o + rotation_term * p_o
    for row, column, rate in (
        (x, y, normal_rotation * p_x * p_y),
        (x, t, normal_rotation * p_x * p_t + disc_coupling * p_x),
        (y, t, normal_rotation * p_y * p_t + disc_coupling * p_y),
        (x, output_dof, normal_rotation * p_x * p_o),
        (y, output_dof, normal_rotation * p_y * p_o),
        (t, output_dof, normal_rotation * p_t * p_o),
    ):
        tangent[row, column] += rate
        tangent[column, row] += rate


@njit(nogil=True, error_model="numpy", inline="always")
def _add_cam(
    springs: KernelSprings,
    friction_elements: FrictionElements,
    fixed_limits: bool,
    disc: int,
    increment: _Increment,
    old_state: _ElastoplasticState,
    new_state: _ElastoplasticState,
) -> float:
    """Add the contact of a disc and its cam, with friction, to residual and tangent of a step; return its energy [J].

    `springs` are the contact springs without friction, `friction_elements` slip at a limit. `disc` is the index of the
    disc, `old_state` and `new_state` are the states before and after the step, and `fixed_limits` is whether the
    friction limits are taken from `increment`, which also contains residual and tangent.
    """
    x, y, i = 3 * disc, 3 * disc + 1, springs.disc.size + disc
    contact, gradient, tangent = cam_at(springs, FIRST, disc, new_state.z), increment.gradient, increment.tangent
    clear(gradient)
    if contact.depth > 0.0:
        gradient[x], gradient[y] = -contact.u, -contact.v
    stiffness, depth = springs.cam_stiffness, max(contact.depth, 0.0)
    energy = _add_contact(friction_elements, fixed_limits, i, stiffness, depth, increment, old_state, new_state)
    if contact.depth > 0.0:
        tangential_stiffness = (
            (new_state.spring_force[i] + new_state.retained_force[i]) / contact.depth * contact.lateral_rate
        )
        tangent[x, x] += tangential_stiffness * contact.v * contact.v
        tangent[y, y] += tangential_stiffness * contact.u * contact.u
        tangent[x, y] -= tangential_stiffness * contact.u * contact.v
        tangent[y, x] -= tangential_stiffness * contact.u * contact.v
    return energy


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _add_contact(
    friction_elements: FrictionElements,
    fixed_limits: bool,
    i: int,
    stiffness: float,
    depth: float,
    increment: _Increment,
    old_state: _ElastoplasticState,
    new_state: _ElastoplasticState,
) -> float:
    """Add contact `i`, including friction, to residual and tangent of a step; return its energy [J].

    The contact has the `stiffness` [N/m] and the deflection `depth` [m]; `increment.gradient` must be the gradient of
    the depth by the unknowns. Its friction is in `friction_elements`. A further spring along the normal, which slips at
    a limit, represents the force that the material retains during unloading. `old_state` is the state before the step;
    the forces are written to `new_state`. With `fixed_limits`, the limits of friction and material are taken from
    `increment`.
    """
    spring_force = stiffness * depth
    retained_stiffness, retained_share = friction_elements.retained_stiffness[i], friction_elements.retained_share[i]
    new_state.depth[i], new_state.spring_force[i], new_state.retained_force[i] = depth, spring_force, 0.0
    energy, force, rate = 0.5 * spring_force * depth, spring_force, stiffness
    if retained_share > 0.0:
        limit = increment.retained_limit[i] if fixed_limits else retained_share * spring_force
        trial_force, slope = (
            old_state.retained_force[i] + retained_stiffness * (depth - old_state.depth[i]),
            retained_stiffness,
        )
        energy += _slip_energy(trial_force, limit, retained_stiffness)
        if abs(trial_force) > limit:
            sign = 1.0 if trial_force > 0.0 else -1.0
            trial_force, slope = sign * limit, 0.0 if fixed_limits else sign * retained_share * stiffness
        new_state.retained_force[i] = trial_force
        force, rate = force + trial_force, rate + slope
    gradient = increment.gradient
    for j in range(gradient.size):
        increment.residual[j] += force * gradient[j]
        for column in range(gradient.size):
            increment.tangent[j, column] += rate * gradient[j] * gradient[column]
    limit, limit_rate = increment.friction_limit[i], 0.0
    if not fixed_limits:
        limit, limit_rate = friction_elements.coefficient[i] * force, friction_elements.coefficient[i] * rate
    return energy + _add_friction(friction_elements, i, limit, limit_rate, increment, old_state, new_state)


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _add_friction(
    friction_elements: FrictionElements,
    i: int,
    limit: float,
    rate: float,
    increment: _Increment,
    old_state: _ElastoplasticState,
    new_state: _ElastoplasticState,
) -> float:
    """Add the friction of an element of index `i` to residual and tangent of a load step; return its energy [J].

    An element is a spring that slips at a limit. Its elastic trial force is reduced to the `limit` [N] (return
    mapping). Residual and tangent are in `increment`. `rate` [N/m] is the derivative of the limit by the deflection of
    the contact. `old_state` is the state before the step; the friction force is written to
    ``new_state.friction_force``.
    """
    slip, stiffness, unknown_count = old_state.slip[i], friction_elements.stiffness[i], increment.load.size
    new_state.friction_force[i] = 0.0
    if not limit > 0.0:
        return 0.0
    trial_force = old_state.friction_force[i]
    for j in range(unknown_count):
        trial_force += stiffness * slip[j] * (new_state.z[j] - old_state.z[j])
    energy = _slip_energy(trial_force, limit, stiffness)
    if abs(trial_force) > limit:
        sign = 1.0 if trial_force > 0.0 else -1.0
        trial_force = sign * limit
        for j in range(unknown_count):
            for column in range(unknown_count):
                increment.tangent[j, column] -= sign * rate * slip[j] * increment.gradient[column]
    else:
        for j in range(unknown_count):
            for column in range(unknown_count):
                increment.tangent[j, column] += stiffness * slip[j] * slip[column]
    new_state.friction_force[i] = trial_force
    for j in range(unknown_count):
        increment.residual[j] -= trial_force * slip[j]
    return energy


@njit(nogil=True, error_model="numpy", inline="always")
def _slip_energy(force: float, limit: float, stiffness: float) -> float:
    """Return elastic energy plus dissipation [J] of a spring with a trial `force` [N] that slips at a limit [N]."""
    magnitude = abs(force)
    return (
        0.5 * magnitude * magnitude / stiffness if magnitude <= limit else limit * (magnitude - 0.5 * limit) / stiffness
    )
