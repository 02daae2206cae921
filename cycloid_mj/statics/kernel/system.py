"""System of the static equilibrium: energy of springs minus work of the load, residual forces, tangent stiffness."""

import math
from typing import NamedTuple

import numpy as np

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.base.compiling import cacheable, njit
from cycloid_mj.statics.kernel.contacts import FALSE, TRUE, KernelSprings, apart_of, gap_at, least_width, pose_of

RATE = 4
"""Column of a contact's stiffness, after those of its gradient."""


SKIN_FACTOR = 2.0
"""Safety factor of the displacements that the neighbour-list skin allows (Verlet, Phys. Rev. 159 (1967), 98).

The displacements are bounded by the gradients at the ideal pose: lever arms vary over a turn, and rotations count to
the second order.
"""


class State(NamedTuple):
    """Springs at some displacements: `energy` minus work of the load [J] and residual forces (u,) [N], its descent.

    `stiffness` (u, u) [N/m] is the second derivative of the energy.
    """

    energy: float
    residual: Array
    stiffness: Array


class _PinSystem(NamedTuple):
    """Arrays for an output pin that bends under D discs: gap `width` [m] and force `pressed` [N] of each disc.

    `normal`, `tangential` (D, 4) [1] and `rate` (D,) [1/m] are as in ``contacts.Gap``; `carries` and `held` (D,),
    `flexible` [m/N] and `stiff` [N/m] (D, D) as in `_solve_pin`.
    """

    width: Array
    pressed: Array
    normal: Array
    tangential: Array
    rate: Array
    carries: Mask
    held: Mask
    flexible: Array
    stiff: Array


class System(NamedTuple):
    """Residual forces (u,) [N] and tangent stiffness (u, u) [N/m] of the equilibrium, and workspace of its solution.

    `pressed` (n,) [N] are the forces of the springs, `warm` (n,) marks the warm-started active set, and `assembled`
    (1,) counts the assemblies. The Newton `step` (u,) begins at `start` (u,); `back` (u,) is the last solution of a
    continuation and `begun` (u,) its origin. The neighbour list was built at the displacements `seen` (u,) [m], where
    each contact was open by at least the `margin` (n,) [m]; `arm` (1,) [1] bounds the lever arms of the rotations.
    `row` (n, 5) has normal gradient and stiffness of each contact; `vectors` (u, u) are for `modified_newton_step`, and
    `pin` for one output pin after the other.
    """

    residual: Array
    tangent: Array
    pressed: Array
    step: Array
    start: Array
    back: Array
    row: Array
    warm: Mask
    assembled: Integers
    seen: Array
    margin: Array
    arm: Array
    begun: Array
    vectors: Array
    pin: _PinSystem


class _Cam(NamedTuple):
    """Contact of a disc and its cam: direction (u, v) [1] and deflection `depth`, minus that of the far side [m].

    Force and stiffness follow from `depth` and its rates along the direction, `along`, and across it, `around` [1]; the
    energy from `energy` [m2], and friction from the sum of both sides, `both` [m].
    """

    u: float
    v: float
    depth: float
    along: float
    around: float
    energy: float
    both: float


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def state(springs: KernelSprings, k: int, load: Array, z: Array) -> State:
    """Compute energy, residual and stiffness at crank angle `k`, load (u,) [N] and displacements z (u,) [m].

    Without friction.
    """
    system = new_system(springs)
    energy = assemble(springs, k, load, z, 1.0, 0.0, FALSE, TRUE, system)
    return State(energy, system.residual, system.tangent)


def system_of(springs: KernelSprings) -> System:
    """Allocate the system of a crank angle; `new_system` is the compiled version."""
    number, discs = springs.slope.shape[2], springs.cam_place.shape[1]
    arm = np.zeros(1)
    for i in range(springs.disc.size):
        for j in (3 * springs.disc[i] + 2, number - 1):
            arm[0] = max(arm[0], math.hypot(springs.slope[0, i, j], springs.shift_slope[0, i, j]))
    return System(
        np.zeros(number),
        np.zeros((number, number)),
        np.zeros(springs.disc.size + springs.cam_place.shape[1]),
        np.zeros(number),
        np.zeros(number),
        np.zeros(number),
        np.zeros((springs.disc.size, 5)),
        np.zeros(springs.disc.size + springs.cam_place.shape[1], np.bool_),
        np.zeros(1, np.int64),
        np.zeros(number),
        np.zeros(springs.disc.size),
        arm,
        np.zeros(number),
        np.zeros((number, number)),
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


new_system = njit(cache=cacheable(), nogil=True, error_model="numpy")(system_of)
"""`system_of` for compiled code."""


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def assemble(
    springs: KernelSprings,
    k: int,
    load: Array,
    z: Array,
    soft: float,
    friction: float,
    exact: bool,
    anew: bool,
    system: System,
) -> float:
    """Assemble residual and tangent at displacements z, with springs scaled by `soft` and friction by `friction`.

    With `anew`, all contacts are evaluated and the neighbour list is rebuilt; otherwise only those that may have
    closed.

    Returns
    -------
    float
        Energy of the springs minus work of the load [J].
    """
    number = z.size
    residual, tangent, pressed, row = system.residual, system.tangent, system.pressed, system.row
    warm, seen, margin = system.warm, system.seen, system.margin
    turning_curve, of_disc, radius = springs.turning, springs.disc, springs.radius
    rough = springs.rubbing.shape[0] > 0 and friction > 0.0
    energy, hard = 0.0, soft * springs.cam_stiffness
    system.assembled[0] += 1
    for j in range(number):
        energy -= load[j] * z[j]
        residual[j] = load[j]
        seen[j] = z[j] if anew else seen[j]
        for m in range(number):
            tangent[j, m] = 0.0
    straight, discs = _straight(springs), springs.cam_place.shape[1]
    for disc in range(discs):
        # sums are local variables: the compiler would write array elements at every contact
        rx = ry = rt = ro = xx = xy = yy = xt = yt = tt = xo = yo = to = oo = 0.0
        pose, moved = pose_of(springs, disc, z), SKIN_FACTOR * _displacement_bound(z, seen, 3 * disc, system.arm[0])
        for i in range(straight):
            if of_disc[i] != disc:
                continue
            pressed[i] = 0.0
            holds, wide = warm[i], margin[i]
            if not (anew or holds) and wide > moved:
                continue
            apart, stiffness = apart_of(springs, k, i, pose), soft * springs.stiffness[k, i]
            wide = least_width(springs, k, i, apart, exact)
            if anew:
                margin[i] = wide
            if not holds and wide > 0.0:
                continue
            found = gap_at(springs, k, i, pose, apart, exact)
            if found.width >= 0.0 and not holds:
                continue
            force = -stiffness * found.width
            pressed[i] = force
            energy -= 0.5 * force * found.width
            if rough or exact:
                row[i, 0], row[i, 1], row[i, 2], row[i, 3] = found.normal
                row[i, RATE] = stiffness
            # geometric stiffness of the rotation of the normal and of the parts
            turning, with_disc = -force * found.rate, force / radius if turning_curve[i] else 0.0
            alone = with_disc if turning_curve[i] else -force / radius
            (ax, ay, at, ao), (bx, by, bt, bo) = found.normal, found.tangential
            rx, ry, rt, ro = rx + force * ax, ry + force * ay, rt + force * at, ro + force * ao
            xx += stiffness * ax * ax + turning * bx * bx
            xy += stiffness * ax * ay + turning * bx * by
            yy += stiffness * ay * ay + turning * by * by
            xt += stiffness * ax * at + turning * bx * bt + with_disc * bx
            yt += stiffness * ay * at + turning * by * bt + with_disc * by
            tt += stiffness * at * at + turning * bt * bt + alone * bt
            xo += stiffness * ax * ao + turning * bx * bo
            yo += stiffness * ay * ao + turning * by * bo
            to += stiffness * at * ao + turning * bt * bo
            oo += stiffness * ao * ao + turning * bo * bo + alone * bo
        x, y, t, o = 3 * disc, 3 * disc + 1, 3 * disc + 2, number - 1
        cam = cam_at(springs, k, disc, z)
        i = springs.disc.size + disc
        pressed[i] = hard * cam.depth if cam.both > 0.0 else 0.0
        if cam.both > 0.0 or warm[i]:
            force, rate, u, v = hard * cam.depth, hard * cam.along, cam.u, cam.v
            energy += hard * cam.energy
            if rough:
                sliding = friction * springs.cam_rubbing * hard
                residual[t] += sliding * (cam.both if cam.both > 0.0 else cam.depth)
                if cam.both == cam.depth or cam.depth < 0.0:
                    tangent[t, x] -= sliding * u
                    tangent[t, y] -= sliding * v
            around = force / cam.depth * cam.around if cam.depth > 0.0 else hard * cam.around
            along = rate - around
            rx, ry = rx - force * u, ry - force * v
            xx += around + along * u * u
            xy += along * u * v
            yy += around + along * v * v
        residual[x], residual[y], residual[t] = residual[x] + rx, residual[y] + ry, residual[t] + rt
        residual[o] += ro
        tangent[x, x], tangent[y, y], tangent[t, t] = tangent[x, x] + xx, tangent[y, y] + yy, tangent[t, t] + tt
        tangent[x, y], tangent[y, x] = tangent[x, y] + xy, tangent[y, x] + xy
        tangent[x, t], tangent[t, x] = tangent[x, t] + xt, tangent[t, x] + xt
        tangent[y, t], tangent[t, y] = tangent[y, t] + yt, tangent[t, y] + yt
        tangent[x, o], tangent[o, x] = tangent[x, o] + xo, tangent[o, x] + xo
        tangent[y, o], tangent[o, y] = tangent[y, o] + yo, tangent[o, y] + yo
        tangent[t, o], tangent[o, t] = tangent[t, o] + to, tangent[o, t] + to
        tangent[o, o] += oo
    if rough:
        _add_friction(springs, k, friction, system)
    return energy + _add_bent_pins(springs.bending, springs, k, z, soft, friction, anew, system)


@njit(nogil=True, error_model="numpy", inline="always")
def _displacement_bound(z: Array, seen: Array, x: int, arm: float) -> float:
    """Return an upper bound of the displacement of a disc's contacts since the neighbour list was built [m]."""
    turned = abs(z[x + 2] - seen[x + 2]) + abs(z[z.size - 1] - seen[z.size - 1])
    return abs(z[x] - seen[x]) + abs(z[x + 1] - seen[x + 1]) + arm * turned


@njit(nogil=True, error_model="numpy", inline="always")
def _straight(springs: KernelSprings) -> int:
    """Return the number of independent contacts: all but those of output pins that bend under several discs."""
    return springs.disc.size - springs.pins * springs.cam_place.shape[1]


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _add_bent_pins(
    bending: Array | None,
    springs: KernelSprings,
    k: int,
    z: Array,
    soft: float,
    friction: float,
    anew: bool,
    system: System,
) -> float:
    """Add output pins that bend to the system at displacements z.

    Forces f on a pin with contacts of stiffness K and gaps w of the straight pin solve the linear complementarity
    problem K^-1 f + B f + w >= 0, f >= 0, with the `bending` B. If it is None, numba leaves out the following code.

    Returns
    -------
    float
        Energy of contacts and pins [J].
    """
    if bending is None:
        return 0.0
    discs, energy = bending.shape[0], 0.0
    first, o = _straight(springs), z.size - 1
    rough = springs.rubbing.shape[0] > 0 and friction > 0.0
    width, pressed, normal, tangential, rate, carries, held, flexible, stiff = system.pin
    for pin in range(springs.pins):
        closed = False
        for d in range(discs):
            i = first + d * springs.pins + pin
            if anew:
                system.margin[i] = least_width(springs, k, i, apart_of(springs, k, i, pose_of(springs, d, z)), FALSE)
            moved = SKIN_FACTOR * _displacement_bound(z, system.seen, 3 * d, system.arm[0])
            closed |= system.warm[i] or not system.margin[i] > moved
            system.pressed[i] = 0.0
        if not closed:
            continue
        for d in range(discs):
            i = first + d * springs.pins + pin
            pose = pose_of(springs, d, z)
            found = gap_at(springs, k, i, pose, apart_of(springs, k, i, pose), FALSE)
            width[d], rate[d], held[d] = found.width, found.rate, system.warm[i]
            for j in range(4):
                normal[d, j], tangential[d, j] = found.normal[j], found.tangential[j]
            for e in range(discs):
                flexible[d, e] = bending[d, e] / soft
            flexible[d, d] += 1.0 / (soft * springs.stiffness[k, i])
        _solve_pin(flexible, width, held, carries, pressed, stiff)
        for d in range(discs):
            system.pressed[first + d * springs.pins + pin] = pressed[d]
            energy -= 0.5 * pressed[d] * width[d]
        for d in range(discs):
            i = first + d * springs.pins + pin
            if not carries[d]:
                continue
            force, system.row[i, RATE] = pressed[d], 0.0
            for e in range(discs):
                system.row[i, RATE] += stiff[d, e]  # the clearances of all discs on a pin grow together
            turning, alone = -force * rate[d], -force / springs.radius
            for a in range(4):
                system.row[i, a] = normal[d, a]
                row = 3 * d + a if a < 3 else o
                rubs = friction * springs.rubbing[k, i, row] if rough else 0.0
                system.residual[row] += force * (normal[d, a] + rubs)
                for b in range(4):
                    system.tangent[row, 3 * d + b if b < 3 else o] += turning * tangential[d, a] * tangential[d, b]
                for e in range(discs):
                    if not carries[e]:
                        continue
                    for b in range(4):
                        column = 3 * e + b if b < 3 else o
                        system.tangent[row, column] += stiff[d, e] * (normal[d, a] + rubs) * normal[e, b]
            # geometric stiffness of the rotations of disc and output, as in `assemble`
            system.tangent[3 * d + 2, 3 * d + 2] += alone * tangential[d, 2]
            system.tangent[o, o] += alone * tangential[d, 3]
    return energy


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _solve_pin(flexible: Array, width: Array, held: Mask, carries: Mask, pressed: Array, stiff: Array) -> None:
    """Solve for the contact forces on a pin [N] and its active contacts, from gaps [m] and flexibility [m/N].

    A linear complementarity problem, solved by principal pivoting: the most violated condition is exchanged first
    (Cottle, Pang & Stone, The Linear Complementarity Problem, 1992, 4.2). `stiff` (D, D) [N/m] is filled in.
    """
    discs = width.size
    for d in range(discs):
        carries[d] = held[d] or width[d] < 0.0
    for _ in range(4 * discs):
        _stiffen(flexible, carries, stiff)
        changes, most = -1, 0.0
        for d in range(discs):
            pressed[d] = 0.0
            for e in range(discs):
                pressed[d] -= stiff[d, e] * width[e]
            if not held[d] and pressed[d] < most:
                changes, most = d, pressed[d]
        for d in range(discs if changes < 0 else 0):  # no contact pulls: check the open ones
            left = width[d]
            for e in range(discs):
                left += flexible[d, e] * pressed[e]
            if not carries[d] and left < most:
                changes, most = d, left
        if changes < 0:
            break
        carries[changes] = not carries[changes]


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _stiffen(flexible: Array, carries: Mask, stiff: Array) -> None:
    """Invert the flexibility of the active contacts of a pin to `stiff` [N/m], 0 for the others, by Gauss-Jordan."""
    discs = carries.size
    for d in range(discs):
        for e in range(discs):
            stiff[d, e] = flexible[d, e] if carries[d] and carries[e] else 0.0
    for pivot in range(discs):
        if not carries[pivot]:
            continue
        inverse = 1.0 / stiff[pivot, pivot]
        stiff[pivot, pivot] = 1.0
        for e in range(discs):
            stiff[pivot, e] *= inverse
        for d in range(discs):
            factor = stiff[d, pivot]
            if d == pivot or factor == 0.0:
                continue
            stiff[d, pivot] = 0.0
            for e in range(discs):
                stiff[d, e] -= factor * stiff[pivot, e]


@njit(nogil=True, error_model="numpy", inline="always")
def cam_at(springs: KernelSprings, k: int, disc: int, z: Array) -> _Cam:
    """Compute the contact of a disc and its cam at displacements z."""
    x, y = z[3 * disc] - springs.cam_place[k, disc, 0], z[3 * disc + 1] - springs.cam_place[k, disc, 1]
    return cam_contact(x, y, springs.cam_clearance)


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def cam_contact(x: float, y: float, clearance: float) -> _Cam:
    """Compute the contact of a disc displaced from its cam by x and y [m]: a circle in a circle.

    With negative clearance, both sides are in contact.
    """
    reach = math.sqrt(x * x + y * y)
    depth, share = reach - clearance, 1.0 / reach if reach > 0.0 else 0.0
    if reach < -clearance:
        within = reach * reach + clearance * clearance
        return _Cam(x * share, y * share, 2.0 * reach, 2.0, 2.0, within, -2.0 * clearance)
    return _Cam(x * share, y * share, depth, 1.0, depth * share, 0.5 * depth * depth, max(depth, 0.0))


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def _add_friction(springs: KernelSprings, k: int, friction: float, system: System) -> None:
    """Add the Coulomb friction of sliding contacts to the system, proportional to their normal forces."""
    o, residual, tangent, row = springs.slope.shape[2] - 1, system.residual, system.tangent, system.row
    for i in range(_straight(springs)):
        force, x = system.pressed[i], 3 * springs.disc[i]
        for a in range(4 if force != 0.0 else 0):
            to = x + a if a < 3 else o
            rubs = friction * springs.rubbing[k, i, to]
            residual[to] += force * rubs
            for b in range(4):
                tangent[to, x + b if b < 3 else o] += row[i, RATE] * rubs * row[i, b]
