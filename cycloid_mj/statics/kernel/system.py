"""System of the static equilibrium: energy of springs minus work of the load, residual forces, tangent stiffness."""

import math
from typing import NamedTuple

import numpy as np

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.base.compiling import cacheable, njit
from cycloid_mj.statics.kernel.contacts import (
    FALSE,
    TRUE,
    Gap,
    KernelSprings,
    bound_width,
    curve_offset,
    disc_pose,
    gap_at,
)

CONTACT_STIFFNESS = 4
"""Column of a contact's stiffness, after those of its gradient."""


SKIN_FACTOR = 2.0
"""Safety factor of the displacements that the neighbour-list skin allows (heuristic); Verlet, Phys. Rev. 159 (1967),
98.

The displacements are bounded by the gradients at the ideal pose: lever arms vary over a turn, and rotations count to
the second order.
"""


class State(NamedTuple):
    """Energy, forces and stiffness of all springs at some displacements.

    `energy` [J] is that of the springs minus the work of the load. `residual` (u,) [N], its negative gradient, are the
    forces that are out of balance, and `stiffness` (u, u) [N/m] is its second derivative.
    """

    energy: float
    residual: Array
    stiffness: Array


class _PinSystem(NamedTuple):
    """Arrays for an output pin that bends under D discs: gap `width` [m] and contact `forces` [N] of each disc.

    `normal`, `tangential` (D, 4) [1] and `rate` (D,) [1/m] are as in ``contacts.Gap``; `is_active` and `kept_closed`
    (D,), `flexibility` [m/N] and `stiffness` [N/m] (D, D) as in `_solve_pin`.
    """

    width: Array
    forces: Array
    normal: Array
    tangential: Array
    rate: Array
    is_active: Mask
    kept_closed: Mask
    flexibility: Array
    stiffness: Array


class System(NamedTuple):
    """Residual forces (u,) [N] and tangent stiffness (u, u) [N/m] of the equilibrium, and workspace of its solution.

    `spring_forces` (n,) [N] are the forces of the springs, `kept_closed` (n,) marks the warm-started active set, and
    `assembly_count` (1,) counts the assemblies. The Newton `step` (u,) begins at `start` (u,). If Newton's method fails
    from its start values `newton_start` (u,), a continuation begins at them or at `path_start` (u,), and
    `last_solution` (u,) is its last solution. The neighbour list was built at the displacements `list_origin` (u,) [m],
    where each contact was open by at least the `margin` (n,) [m]; `arm` (1,) [1] bounds the lever arms of the
    rotations. `row` (n, 5) has normal gradient and stiffness of each contact; `vectors` (u, u) are for
    `modified_newton_step`, and `pin` for one output pin after the other.
    """

    residual: Array
    tangent: Array
    spring_forces: Array
    step: Array
    start: Array
    last_solution: Array
    row: Array
    kept_closed: Mask
    assembly_count: Integers
    list_origin: Array
    margin: Array
    arm: Array
    path_start: Array
    newton_start: Array
    vectors: Array
    pin: _PinSystem


class _DiscSums(NamedTuple):
    """Sums over the contacts of a disc, by its x, y and rotation t and the output's rotation o.

    `force_x` to `force_o` are forces [N], `k_xx` to `k_oo` the upper half of the tangent stiffness [N/m].
    """

    force_x: float
    force_y: float
    force_t: float
    force_o: float
    k_xx: float
    k_xy: float
    k_yy: float
    k_xt: float
    k_yt: float
    k_tt: float
    k_xo: float
    k_yo: float
    k_to: float
    k_oo: float


class _Cam(NamedTuple):
    """Contact of a disc and its cam: direction (u, v) [1] and deflection `depth`, minus that of the far side [m].

    Force and stiffness follow from `depth` and its rates along the direction, `radial_rate`, and across it,
    `lateral_rate` [1]; the energy from `energy` [m2], and friction from the sum of both sides, `total_depth` [m].
    """

    u: float
    v: float
    depth: float
    radial_rate: float
    lateral_rate: float
    energy: float
    total_depth: float


def state(springs: KernelSprings, k: int, load: Array, z: Array) -> State:
    """Compute energy, residual forces and stiffness of the contact springs without friction, as `State`.

    The contact springs are evaluated at the crank angle of index `k`, under a generalised load (u,) [N], at the u
    unknown displacements `z` (u,) [m].
    """
    system = allocate_system(springs)
    return State(_assemble_springs(springs, k, load, z, system), system.residual, system.tangent)


def allocate_system(springs: KernelSprings) -> System:
    """Allocate a `System`: residual, tangent and workspace for the equilibria of contact springs at all crank angles.

    All its arrays are 0 except `arm` (1,) [1]: the largest displacement of a contact, along and across its normal, per
    displacement by rotation of its disc or of the output, at the first crank angle.
    """
    unknowns, discs = springs.slope.shape[2], springs.cam_position.shape[1]
    contacts, arm = np.arange(springs.disc.size), 0.0
    for j in (3 * springs.disc + 2, unknowns - 1):
        normal, tangential = springs.slope[0, contacts, j].tolist(), springs.shift_slope[0, contacts, j].tolist()
        arm = max([arm, *map(math.hypot, normal, tangential)])
    return System(
        np.zeros(unknowns),
        np.zeros((unknowns, unknowns)),
        np.zeros(springs.disc.size + springs.cam_position.shape[1]),
        np.zeros(unknowns),
        np.zeros(unknowns),
        np.zeros(unknowns),
        np.zeros((springs.disc.size, 5)),
        np.zeros(springs.disc.size + springs.cam_position.shape[1], np.bool_),
        np.zeros(1, np.int64),
        np.zeros(unknowns),
        np.zeros(springs.disc.size),
        np.array([arm]),
        np.zeros(unknowns),
        np.zeros(unknowns),
        np.zeros((unknowns, unknowns)),
        _PinSystem(
            np.zeros(discs),
            np.zeros(discs),
            np.zeros((discs, 4)),
            np.zeros((discs, 4)),
            np.zeros(discs),
            np.zeros(discs, np.bool_),
            np.zeros(discs, np.bool_),
            np.zeros((discs, discs)),
            np.zeros((discs, discs)),
        ),
    )


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def assemble(
    springs: KernelSprings,
    k: int,
    load: Array,
    z: Array,
    stiffness_factor: float,
    friction: float,
    use_foot_points: bool,
    rebuild_list: bool,
    system: System,
) -> float:
    """Assemble residual and tangent of the equilibrium at displacements `z` and write them to `system`.

    Parameters
    ----------
    springs, k, load
        Contact springs, index of the crank angle, and generalised load on the u unknown displacements (u,) [N].
    z
        The u unknown displacements [m], as in `KernelSprings`.
    stiffness_factor, friction
        Factors on all stiffnesses and on the friction [1].
    use_foot_points
        Whether the foot point of every tooth is computed, instead of the third-order expansion.
    rebuild_list
        True: evaluate all contacts and rebuild the neighbour list. False: evaluate only contacts that may have closed
        since it was built.
    system
        Residual, tangent and workspace, which are overwritten.

    Returns
    -------
    float
        Energy of the contact springs minus work of the load [J].
    """
    unknown_count, residual, tangent, list_origin = z.size, system.residual, system.tangent, system.list_origin
    has_friction = springs.friction_per_force.shape[0] > 0 and friction > 0.0
    energy = 0.0
    system.assembly_count[0] += 1
    for j in range(unknown_count):
        energy -= load[j] * z[j]
        residual[j] = load[j]
        list_origin[j] = z[j] if rebuild_list else list_origin[j]
        for column in range(unknown_count):
            tangent[j, column] = 0.0
    for disc in range(springs.cam_position.shape[1]):
        sums, energy = _sum_contacts(
            springs, k, disc, z, stiffness_factor, use_foot_points, has_friction, rebuild_list, energy, system
        )
        sums, energy = _add_cam(
            springs, k, disc, z, stiffness_factor, friction if has_friction else 0.0, sums, energy, system
        )
        _add_sums(sums, disc, residual, tangent)
    if has_friction:
        _add_friction(springs, k, friction, system)
    return energy + _add_bent_pins(springs, k, z, stiffness_factor, friction, rebuild_list, system)


@njit(cache=cacheable(), allocates=False, nogil=True, error_model="numpy")
def _assemble_springs(springs: KernelSprings, k: int, load: Array, z: Array, system: System) -> float:
    """Assemble residual and tangent as `assemble`, without friction and foot points; return the energy [J]."""
    return assemble(springs, k, load, z, 1.0, 0.0, FALSE, TRUE, system)


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def _sum_contacts(
    springs: KernelSprings,
    k: int,
    disc: int,
    z: Array,
    stiffness_factor: float,
    use_foot_points: bool,
    has_friction: bool,
    rebuild_list: bool,
    energy: float,
    system: System,
) -> tuple[_DiscSums, float]:
    """Sum the forces and the stiffness of the contacts of a disc, except those with output pins that bend.

    Only contacts that may have closed since the neighbour list was built are evaluated. Their forces are written to
    `system.spring_forces`, and gradients to `system.row` where friction or continuation needs them. `energy` [J] is the
    sum so far, and `has_friction` whether friction acts. `k` is the index of the crank angle, `z` (u,) [m] are the u
    unknown displacements, and `stiffness_factor` is a factor on all stiffnesses. `use_foot_points` is whether the foot
    point of every tooth is computed, and `rebuild_list` whether the neighbour list is rebuilt.

    Returns
    -------
    tuple
        The sums over the contacts, and `energy` plus the energy of the contacts [J].
    """
    spring_forces, row, kept_closed, margin = system.spring_forces, system.row, system.kept_closed, system.margin
    rotates, disc_index, radius = springs.rotates, springs.disc, springs.radius
    # sums are local variables: the compiler would write array elements at every contact
    sums = _DiscSums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    pose = disc_pose(springs, disc, z)
    max_displacement = SKIN_FACTOR * _displacement_bound(z, system.list_origin, 3 * disc, system.arm[0])
    for i in range(_independent_contacts(springs)):
        if disc_index[i] != disc:
            continue
        spring_forces[i] = 0.0
        is_kept_closed, bound = kept_closed[i], margin[i]
        if not (rebuild_list or is_kept_closed) and bound > max_displacement:
            continue
        offset, stiffness = curve_offset(springs, k, i, pose), stiffness_factor * springs.stiffness[k, i]
        bound = bound_width(springs, k, i, offset, use_foot_points)
        if rebuild_list:
            margin[i] = bound
        if not is_kept_closed and bound > 0.0:
            continue
        gap = gap_at(springs, k, i, pose, offset, use_foot_points)
        if gap.width >= 0.0 and not is_kept_closed:
            continue
        force = -stiffness * gap.width
        spring_forces[i] = force
        energy -= 0.5 * force * gap.width
        if has_friction or use_foot_points:
            row[i, 0], row[i, 1], row[i, 2], row[i, 3] = gap.normal
            row[i, CONTACT_STIFFNESS] = stiffness
        sums = _add_contact(sums, gap, force, stiffness, force / radius, rotates[i])
    return sums, energy


@njit(nogil=True, error_model="numpy", inline="always")
def _add_contact(
    sums: _DiscSums, gap: Gap, force: float, stiffness: float, rotation_stiffness: float, rotates: bool
) -> _DiscSums:
    """Add the force and the tangent stiffness of a contact to the sums of its disc, and return the new sums.

    The tangent includes the geometric stiffness of the rotation of the normal and of the parts.

    Parameters
    ----------
    sums
        Sums over the other contacts of the disc.
    gap
        Gap of the contact, with its gradients.
    force, stiffness
        Normal force [N] and stiffness [N/m] of the contact.
    rotation_stiffness
        Geometric stiffness of the rotation of the parts [N/m]. It acts on the disc if the profile `rotates` with it,
        and on disc and output if not.
    """
    # n, p: gradients along the normal and along the tangent, by the unknowns of `_DiscSums`
    force_x, force_y, force_t, force_o, k_xx, k_xy, k_yy, k_xt, k_yt, k_tt, k_xo, k_yo, k_to, k_oo = sums
    normal_rotation, disc_coupling = -force * gap.rate, rotation_stiffness if rotates else 0.0
    rotation_term = disc_coupling if rotates else -rotation_stiffness
    (n_x, n_y, n_t, n_o), (p_x, p_y, p_t, p_o) = gap.normal, gap.tangential
    return _DiscSums(
        force_x + force * n_x,
        force_y + force * n_y,
        force_t + force * n_t,
        force_o + force * n_o,
        k_xx + (stiffness * n_x * n_x + normal_rotation * p_x * p_x),
        k_xy + (stiffness * n_x * n_y + normal_rotation * p_x * p_y),
        k_yy + (stiffness * n_y * n_y + normal_rotation * p_y * p_y),
        k_xt + (stiffness * n_x * n_t + normal_rotation * p_x * p_t + disc_coupling * p_x),
        k_yt + (stiffness * n_y * n_t + normal_rotation * p_y * p_t + disc_coupling * p_y),
        k_tt + (stiffness * n_t * n_t + normal_rotation * p_t * p_t + rotation_term * p_t),
        k_xo + (stiffness * n_x * n_o + normal_rotation * p_x * p_o),
        k_yo + (stiffness * n_y * n_o + normal_rotation * p_y * p_o),
        k_to + (stiffness * n_t * n_o + normal_rotation * p_t * p_o),
        k_oo + (stiffness * n_o * n_o + normal_rotation * p_o * p_o + rotation_term * p_o),
    )


@njit(nogil=True, error_model="numpy", inline="always")
def _add_cam(
    springs: KernelSprings,
    k: int,
    disc: int,
    z: Array,
    stiffness_factor: float,
    friction: float,
    sums: _DiscSums,
    energy: float,
    system: System,
) -> tuple[_DiscSums, float]:
    """Add the contact of a disc and its cam to the sums of the disc; add its friction to `system`.

    `springs` are the contact springs, `k` is the index of the crank angle, and `z` (u,) [m] are the u unknown
    displacements; `stiffness_factor` and `friction` are factors on stiffness and friction [1]. `disc` is the index of
    the disc, `sums` and `energy` [J] are the sums so far.

    Returns
    -------
    tuple
        The new sums, and `energy` plus the energy of the contact [J].
    """
    force_x, force_y, force_t, force_o, k_xx, k_xy, k_yy, k_xt, k_yt, k_tt, k_xo, k_yo, k_to, k_oo = sums
    residual, tangent, x, y, t = system.residual, system.tangent, 3 * disc, 3 * disc + 1, 3 * disc + 2
    cam, i, cam_stiffness = (
        cam_at(springs, k, disc, z),
        springs.disc.size + disc,
        stiffness_factor * springs.cam_stiffness,
    )
    system.spring_forces[i] = cam_stiffness * cam.depth if cam.total_depth > 0.0 else 0.0
    if cam.total_depth > 0.0 or system.kept_closed[i]:
        force, rate, direction_x, direction_y = cam_stiffness * cam.depth, cam_stiffness * cam.radial_rate, cam.u, cam.v
        energy += cam_stiffness * cam.energy
        if friction > 0.0:
            sliding = friction * springs.cam_friction_per_force * cam_stiffness
            residual[t] += sliding * (cam.total_depth if cam.total_depth > 0.0 else cam.depth)
            if cam.total_depth == cam.depth or cam.depth < 0.0:
                tangent[t, x] -= sliding * direction_x
                tangent[t, y] -= sliding * direction_y
        tangential_stiffness = (
            force / cam.depth * cam.lateral_rate if cam.depth > 0.0 else cam_stiffness * cam.lateral_rate
        )
        radial_excess = rate - tangential_stiffness
        if friction > 0.0:
            lateral = friction * springs.cam_lateral
            residual[x] += lateral * force * direction_y
            residual[y] -= lateral * force * direction_x
            tangent[x, x] -= lateral * radial_excess * direction_x * direction_y
            tangent[x, y] -= lateral * (tangential_stiffness + radial_excess * direction_y * direction_y)
            tangent[y, x] += lateral * (tangential_stiffness + radial_excess * direction_x * direction_x)
            tangent[y, y] += lateral * radial_excess * direction_x * direction_y
        force_x, force_y = force_x - force * direction_x, force_y - force * direction_y
        k_xx += tangential_stiffness + radial_excess * direction_x * direction_x
        k_xy += radial_excess * direction_x * direction_y
        k_yy += tangential_stiffness + radial_excess * direction_y * direction_y
    return _DiscSums(
        force_x, force_y, force_t, force_o, k_xx, k_xy, k_yy, k_xt, k_yt, k_tt, k_xo, k_yo, k_to, k_oo
    ), energy


@njit(nogil=True, error_model="numpy", inline="always")
def _add_sums(sums: _DiscSums, disc: int, residual: Array, tangent: Array) -> None:
    """Add the summed contact forces and stiffness of a disc to the residual [N] and the tangent [N/m] of the system.

    `disc` is the index of the disc, `sums` are its forces and stiffness. The residual has the shape (u,), the tangent
    (u, u), for u unknowns; both are changed.
    """
    force_x, force_y, force_t, force_o, k_xx, k_xy, k_yy, k_xt, k_yt, k_tt, k_xo, k_yo, k_to, k_oo = sums
    x, y, t, output_dof = 3 * disc, 3 * disc + 1, 3 * disc + 2, residual.size - 1
    residual[x], residual[y], residual[t] = residual[x] + force_x, residual[y] + force_y, residual[t] + force_t
    residual[output_dof] += force_o
    tangent[x, x], tangent[y, y], tangent[t, t] = tangent[x, x] + k_xx, tangent[y, y] + k_yy, tangent[t, t] + k_tt
    tangent[x, y], tangent[y, x] = tangent[x, y] + k_xy, tangent[y, x] + k_xy
    tangent[x, t], tangent[t, x] = tangent[x, t] + k_xt, tangent[t, x] + k_xt
    tangent[y, t], tangent[t, y] = tangent[y, t] + k_yt, tangent[t, y] + k_yt
    tangent[x, output_dof], tangent[output_dof, x] = tangent[x, output_dof] + k_xo, tangent[output_dof, x] + k_xo
    tangent[y, output_dof], tangent[output_dof, y] = tangent[y, output_dof] + k_yo, tangent[output_dof, y] + k_yo
    tangent[t, output_dof], tangent[output_dof, t] = tangent[t, output_dof] + k_to, tangent[output_dof, t] + k_to
    tangent[output_dof, output_dof] += k_oo


@njit(nogil=True, error_model="numpy", inline="always")
def _displacement_bound(z: Array, list_origin: Array, index: int, arm: float) -> float:
    """Return an upper bound of the displacement of a disc's contacts since the neighbour list was built [m].

    `z` and `list_origin` are the displacements (u,) [m] now and when the list was built. `index` is the index of the
    disc's first unknown. `arm` [1] is the largest lever arm divided by the radius of the circle of output pins.
    """
    rotation = abs(z[index + 2] - list_origin[index + 2]) + abs(z[z.size - 1] - list_origin[z.size - 1])
    return abs(z[index] - list_origin[index]) + abs(z[index + 1] - list_origin[index + 1]) + arm * rotation


@njit(nogil=True, error_model="numpy", inline="always")
def _independent_contacts(springs: KernelSprings) -> int:
    """Return the number of independent contacts: all but those of output pins that bend under several discs."""
    return springs.disc.size - springs.pins * springs.cam_position.shape[1]


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _add_bent_pins(
    springs: KernelSprings,
    k: int,
    z: Array,
    stiffness_factor: float,
    friction: float,
    rebuild_list: bool,
    system: System,
) -> float:
    """Add output pins that bend to residual and tangent of the `system`; return the energy of contacts and pins [J].

    The forces f of the discs on a pin solve the linear complementarity problem K^-1 f + B f + w >= 0, f >= 0. K is the
    contact stiffness, w are the gaps of the straight pin, and B is the `bending` of the springs. `k` is the index of
    the crank angle, `z` (u,) [m] are the u unknown displacements, and `stiffness_factor` and `friction` are factors on
    stiffness and friction [1]; `rebuild_list` is whether the neighbour list of contacts is rebuilt.
    """
    disc_count, energy, first_contact = springs.cam_position.shape[1], 0.0, _independent_contacts(springs)
    width, forces, normal_gradients, tangential_gradients, rate, is_active, kept_closed, flexibility, stiffness = (
        system.pin
    )
    for pin in range(springs.pins):
        if not _may_touch_pin(springs, k, pin, z, rebuild_list, system):
            continue
        for disc in range(disc_count):
            i = first_contact + disc * springs.pins + pin
            pose = disc_pose(springs, disc, z)
            gap = gap_at(springs, k, i, pose, curve_offset(springs, k, i, pose), FALSE)
            width[disc], rate[disc], kept_closed[disc] = gap.width, gap.rate, system.kept_closed[i]
            for component in range(4):
                normal_gradients[disc, component], tangential_gradients[disc, component] = (
                    gap.normal[component],
                    gap.tangential[component],
                )
            for other_disc in range(disc_count):
                flexibility[disc, other_disc] = springs.bending[disc, other_disc] / stiffness_factor
            flexibility[disc, disc] += 1.0 / (stiffness_factor * springs.stiffness[k, i])
        _solve_pin(flexibility, width, kept_closed, is_active, forces, stiffness)
        for disc in range(disc_count):
            system.spring_forces[first_contact + disc * springs.pins + pin] = forces[disc]
            energy -= 0.5 * forces[disc] * width[disc]
        _add_pin_forces(springs, k, pin, friction, system)
    return energy


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _may_touch_pin(springs: KernelSprings, k: int, pin: int, z: Array, rebuild_list: bool, system: System) -> bool:
    """Return whether any disc may touch an output pin, by the neighbour list; set the forces on the pin to 0.

    `springs` are the contact springs, `k` and `pin` the indices of crank angle and pin, `z` (u,) [m] the u unknown
    displacements. With `rebuild_list`, the part of the list for this pin in `system` is first rebuilt at these
    displacements.
    """
    may_touch, first_contact = False, _independent_contacts(springs)
    for disc in range(springs.cam_position.shape[1]):
        i = first_contact + disc * springs.pins + pin
        if rebuild_list:
            offset = curve_offset(springs, k, i, disc_pose(springs, disc, z))
            system.margin[i] = bound_width(springs, k, i, offset, FALSE)
        max_displacement = SKIN_FACTOR * _displacement_bound(z, system.list_origin, 3 * disc, system.arm[0])
        may_touch |= system.kept_closed[i] or not system.margin[i] > max_displacement
        system.spring_forces[i] = 0.0
    return may_touch


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _add_pin_forces(springs: KernelSprings, k: int, pin: int, friction: float, system: System) -> None:
    """Add the solved forces on an output pin, with their tangent stiffness and friction, to residual and tangent.

    The forces are in `system.pin`. `springs` are the contact springs, `k` and `pin` the indices of crank angle and pin;
    `friction` is a factor on the friction coefficients.
    """
    disc_count, first_contact, output_dof = (
        springs.cam_position.shape[1],
        _independent_contacts(springs),
        system.residual.size - 1,
    )
    has_friction = springs.friction_per_force.shape[0] > 0 and friction > 0.0
    _, forces, normal_gradients, tangential_gradients, rate, is_active, _, _, stiffness = system.pin
    for disc in range(disc_count):
        i = first_contact + disc * springs.pins + pin
        if not is_active[disc]:
            continue
        force, system.row[i, CONTACT_STIFFNESS] = forces[disc], 0.0
        for other_disc in range(disc_count):
            system.row[i, CONTACT_STIFFNESS] += stiffness[
                disc, other_disc
            ]  # the clearances of all discs on a pin grow together
        normal_rotation, rotation_term = -force * rate[disc], -force / springs.radius
        for component in range(4):
            system.row[i, component] = normal_gradients[disc, component]
            row = 3 * disc + component if component < 3 else output_dof
            friction_term = friction * springs.friction_per_force[k, i, row] if has_friction else 0.0
            system.residual[row] += force * (normal_gradients[disc, component] + friction_term)
            for other_component in range(4):
                system.tangent[row, 3 * disc + other_component if other_component < 3 else output_dof] += (
                    normal_rotation
                    * tangential_gradients[disc, component]
                    * tangential_gradients[disc, other_component]
                )
            for other_disc in range(disc_count):
                if not is_active[other_disc]:
                    continue
                for other_component in range(4):
                    column = 3 * other_disc + other_component if other_component < 3 else output_dof
                    system.tangent[row, column] += (
                        stiffness[disc, other_disc]
                        * (normal_gradients[disc, component] + friction_term)
                        * normal_gradients[other_disc, other_component]
                    )
        # geometric stiffness of the rotations of disc and output, as in `_add_contact`
        system.tangent[3 * disc + 2, 3 * disc + 2] += rotation_term * tangential_gradients[disc, 2]
        system.tangent[output_dof, output_dof] += rotation_term * tangential_gradients[disc, 3]


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _solve_pin(
    flexibility: Array, width: Array, kept_closed: Mask, is_active: Mask, forces: Array, stiffness: Array
) -> None:
    """Solve for the contact forces on a pin that bends, a linear complementarity problem, by principal pivoting.

    In each step, the contact that violates its condition most is opened or closed (Cottle, Pang & Stone, The Linear
    Complementarity Problem, 1992, 4.2).

    Parameters
    ----------
    flexibility, width
        Flexibility of pin and contacts (D, D) [m/N], and gaps (D,) [m] between the straight pin and D discs.
    kept_closed
        Mask (D,) of contacts that stay closed, even if they pull.
    is_active, forces, stiffness
        Output arrays: mask of closed contacts (D,), their forces (D,) [N], and their stiffness (D, D) [N/m].
    """
    discs = width.size
    for disc in range(discs):
        is_active[disc] = kept_closed[disc] or width[disc] < 0.0
    for _ in range(4 * discs):
        _invert_flexibility(flexibility, is_active, stiffness)
        exchanged_index, violation = -1, 0.0
        for disc in range(discs):
            forces[disc] = 0.0
            for other_disc in range(discs):
                forces[disc] -= stiffness[disc, other_disc] * width[other_disc]
            if not kept_closed[disc] and forces[disc] < violation:
                exchanged_index, violation = disc, forces[disc]
        for disc in range(discs if exchanged_index < 0 else 0):  # no contact pulls: check the open ones
            gap = width[disc]
            for other_disc in range(discs):
                gap += flexibility[disc, other_disc] * forces[other_disc]
            if not is_active[disc] and gap < violation:
                exchanged_index, violation = disc, gap
        if exchanged_index < 0:
            break
        is_active[exchanged_index] = not is_active[exchanged_index]


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _invert_flexibility(flexibility: Array, is_active: Mask, stiffness: Array) -> None:
    """Write the inverse of the flexibility of a pin's active contacts with D discs to `stiffness` (D, D) [N/m].

    `flexibility` has the shape (D, D) [m/N]. Rows and columns of inactive contacts, for which `is_active` (D,) is
    false, are 0. The method is Gauss-Jordan elimination.
    """
    discs = is_active.size
    for disc in range(discs):
        for other_disc in range(discs):
            stiffness[disc, other_disc] = (
                flexibility[disc, other_disc] if is_active[disc] and is_active[other_disc] else 0.0
            )
    for pivot in range(discs):
        if not is_active[pivot]:
            continue
        inverse = 1.0 / stiffness[pivot, pivot]
        stiffness[pivot, pivot] = 1.0
        for other_disc in range(discs):
            stiffness[pivot, other_disc] *= inverse
        for disc in range(discs):
            factor = stiffness[disc, pivot]
            if disc == pivot or factor == 0.0:
                continue
            stiffness[disc, pivot] = 0.0
            for other_disc in range(discs):
                stiffness[disc, other_disc] -= factor * stiffness[pivot, other_disc]


@njit(nogil=True, error_model="numpy", inline="always")
def cam_at(springs: KernelSprings, k: int, disc: int, z: Array) -> _Cam:
    """Compute the contact of the disc of index `disc` and its cam at crank angle `k` and displacements `z` (u,) [m]."""
    x, y = z[3 * disc] - springs.cam_position[k, disc, 0], z[3 * disc + 1] - springs.cam_position[k, disc, 1]
    return cam_contact(x, y, springs.cam_clearance)


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def cam_contact(x: float, y: float, clearance: float) -> _Cam:
    """Compute deflection [m], direction, and energy over stiffness [m2] of a bore in contact with its cam.

    `x` and `y` [m] are the position of the bore's centre relative to the centre of the cam, a circle in a circle. With
    negative `clearance` [m], both sides may be in contact.
    """
    distance = math.sqrt(x * x + y * y)
    depth, inverse = distance - clearance, 1.0 / distance if distance > 0.0 else 0.0
    if distance < -clearance:
        squares = distance * distance + clearance * clearance
        return _Cam(x * inverse, y * inverse, 2.0 * distance, 2.0, 2.0, squares, -2.0 * clearance)
    return _Cam(x * inverse, y * inverse, depth, 1.0, depth * inverse, 0.5 * depth * depth, max(depth, 0.0))


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def _add_friction(springs: KernelSprings, k: int, friction: float, system: System) -> None:
    """Add the Coulomb friction of sliding contacts to residual and tangent of the system.

    `springs` are the contact springs, `k` is the index of the crank angle, `friction` is a factor on the friction
    coefficients.
    """
    output_dof, residual, tangent, row = springs.slope.shape[2] - 1, system.residual, system.tangent, system.row
    for i in range(_independent_contacts(springs)):
        force, x = system.spring_forces[i], 3 * springs.disc[i]
        for row_index in range(4 if force != 0.0 else 0):
            unknown = x + row_index if row_index < 3 else output_dof
            rate = friction * springs.friction_per_force[k, i, unknown]
            residual[unknown] += force * rate
            for column_index in range(4):
                tangent[unknown, x + column_index if column_index < 3 else output_dof] += (
                    row[i, CONTACT_STIFFNESS] * rate * row[i, column_index]
                )
