"""The system of a balance: energy of springs less the work of the load, forces left over, and their stiffness."""

import math
from typing import NamedTuple

import numpy as np

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.base.compiling import cacheable, njit
from cycloid_mj.statics.kernel.contacts import NO, YES, KernelSprings, apart_of, curved, least_width, pose_of

RATE = 4
"""Column of a contact's stiffness, after those of its gradient."""


_SURELY = 2.0
"""By how much farther than their slopes tell curves are reckoned to have moved: arms vary over a turn, and turns count
to the second order."""


class State(NamedTuple):
    """Springs at some departures: `energy` less the work of the load [J] and forces left over (u,) [N], its descent.

    `stiffness` (u, u) [N/m] is the second derivative of that energy.
    """

    energy: float
    residual: Array
    stiffness: Array


class _PinSystem(NamedTuple):
    """Arrays for one output pin that bends under D discs: of each its `width` [m], and the force `pressed` [N] on it.

    `ahead`, `aside` (D, 4) [1] and `rate` (D,) [1/m] are as in ``contacts.Curved``, `carries` and `held` (D,), and
    `flexible` [m/N] and `stiff` [N/m] (D, D), as in `_hold`.
    """

    width: Array
    pressed: Array
    ahead: Array
    aside: Array
    rate: Array
    carries: Mask
    held: Mask
    flexible: Array
    stiff: Array


class Linearised(NamedTuple):
    """Generalised forces left over [N], shape (u,), and the springs' stiffness [N/m], shape (u, u).

    `pressed` (n,) [N] are the forces of the springs. The rest are arrays of the search: the Newton `step` and where it
    is from, `start` (u,), `ahead` (4,) [1], and `assembled` (1,), how often the system was put together. Where all
    contacts were `seen` last (u,) [m] each was open by the `margin` (n,) [m], 0 where it may have been closed; `arm`
    (1,) [1] is how far a contact's curves move with the turns of its parts, at most. At an angle the search has `begun`
    (u,) [m]; `vectors` (u, u) are for `roll_off`, and `pin` for one after the other.
    """

    residual: Array
    tangent: Array
    pressed: Array
    step: Array
    start: Array
    back: Array
    row: Array
    kept: Mask
    assembled: Integers
    seen: Array
    margin: Array
    arm: Array
    begun: Array
    vectors: Array
    pin: _PinSystem


class _Cam(NamedTuple):
    """Where a disc is from its cam: which way (u, v) [1], and how deep it presses, less what the far side presses [m].

    Force and stiffness of the cam go with that `depth`, with its rates along that way, `along`, and across, `around`
    [1]; the `energy` [m2] too, and friction with what both sides press, `both` [m].
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
    """Compute the springs of a crank angle under a load (u,) [N] at departures z (u,) [m], which need be no balance.

    Without friction.
    """
    system = new_system(springs)
    energy = assemble(springs, k, load, z, 1.0, 0.0, NO, YES, system)
    return State(energy, system.residual, system.tangent)


def system_of(springs: KernelSprings) -> Linearised:
    """Make room for the system of springs at one crank angle; for kernels there is `new_system`."""
    number, discs = springs.slope.shape[2], springs.cam_place.shape[1]
    arm = np.zeros(1)
    for i in range(springs.disc.size):
        for j in (3 * springs.disc[i] + 2, number - 1):
            arm[0] = max(arm[0], math.hypot(springs.slope[0, i, j], springs.shift_slope[0, i, j]))
    return Linearised(
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
"""`system_of`, for kernels: for Python it would have to be compiled first."""


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
    system: Linearised,
) -> float:
    """Put together the system at departures z, of springs that are `soft` and a share of the friction.

    All contacts are looked at `anew`; else, of the same springs, those alone that may have closed since.

    Returns
    -------
    The energy of the springs less the work of the load [J].
    """
    number = z.size
    residual, tangent, pressed, row = system.residual, system.tangent, system.pressed, system.row
    kept, seen, margin = system.kept, system.seen, system.margin
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
        # Sums stand in names, not in the arrays, which the compiler would write at every contact.
        rx = ry = rt = ro = xx = xy = yy = xt = yt = tt = xo = yo = to = oo = 0.0
        pose, moved = pose_of(springs, disc, z), _SURELY * _moved(z, seen, 3 * disc, system.arm[0])
        for i in range(straight):
            if of_disc[i] != disc:
                continue
            pressed[i] = 0.0
            holds, wide = kept[i], margin[i]
            if not (anew or holds) and wide > moved:
                continue
            apart, stiffness = apart_of(springs, k, i, pose), soft * springs.stiffness[k, i]
            wide = least_width(springs, k, i, apart, exact)
            if anew:
                margin[i] = wide
            if not holds and wide > 0.0:
                continue
            found = curved(springs, k, i, pose, apart, exact)
            if found.width >= 0.0 and not holds:
                continue
            force = -stiffness * found.width
            pressed[i] = force
            energy -= 0.5 * force * found.width
            if rough or exact:
                row[i, 0], row[i, 1], row[i, 2], row[i, 3] = found.ahead
                row[i, RATE] = stiffness
            # The normal's turning stiffens a concave contact and softens a convex one; so do the turns of the parts.
            turning, with_disc = -force * found.rate, force / radius if turning_curve[i] else 0.0
            alone = with_disc if turning_curve[i] else -force / radius
            (ax, ay, at, ao), (bx, by, bt, bo) = found.ahead, found.aside
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
        if cam.both > 0.0 or kept[i]:
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
        _drag(springs, k, friction, system)
    return energy + _bend(springs.bending, springs, k, z, soft, friction, anew, system)


@njit(nogil=True, error_model="numpy", inline="always")
def _moved(z: Array, seen: Array, x: int, arm: float) -> float:
    """Compute how far the curves of a disc's contacts have moved at most since they were seen [m], by their slopes."""
    turned = abs(z[x + 2] - seen[x + 2]) + abs(z[z.size - 1] - seen[z.size - 1])
    return abs(z[x] - seen[x]) + abs(z[x + 1] - seen[x + 1]) + arm * turned


@njit(nogil=True, error_model="numpy", inline="always")
def _straight(springs: KernelSprings) -> int:
    """Count the contacts that no other moves: all, or all but those of output pins that bend under several discs."""
    return springs.disc.size - springs.pins * springs.cam_place.shape[1]


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _bend(
    bending: Array | None,
    springs: KernelSprings,
    k: int,
    z: Array,
    soft: float,
    friction: float,
    anew: bool,
    system: Linearised,
) -> float:
    """Add output pins that bend, at departures z, to a system.

    Forces f on one pin in contacts of stiffness K, at widths w of the straight pin, hold where K^-1 f + B f + w = 0 and
    are 0 where that is positive, B the `bending`. Where it is None, as where no disc bends pins for another, nothing is
    added, and numba leaves out what follows.

    Returns
    -------
    The energy of contacts and pins [J].
    """
    if bending is None:
        return 0.0
    discs, energy = bending.shape[0], 0.0
    first, o = _straight(springs), z.size - 1
    rough = springs.rubbing.shape[0] > 0 and friction > 0.0
    width, pressed, ahead, aside, rate, carries, held, flexible, stiff = system.pin
    for pin in range(springs.pins):
        closed = False
        for d in range(discs):
            i = first + d * springs.pins + pin
            if anew:
                system.margin[i] = least_width(springs, k, i, apart_of(springs, k, i, pose_of(springs, d, z)), NO)
            moved = _SURELY * _moved(z, system.seen, 3 * d, system.arm[0])
            closed |= system.kept[i] or not system.margin[i] > moved
            system.pressed[i] = 0.0
        if not closed:
            continue
        for d in range(discs):
            i = first + d * springs.pins + pin
            pose = pose_of(springs, d, z)
            found = curved(springs, k, i, pose, apart_of(springs, k, i, pose), NO)
            width[d], rate[d], held[d] = found.width, found.rate, system.kept[i]
            for j in range(4):
                ahead[d, j], aside[d, j] = found.ahead[j], found.aside[j]
            for e in range(discs):
                flexible[d, e] = bending[d, e] / soft
            flexible[d, d] += 1.0 / (soft * springs.stiffness[k, i])
        _hold(flexible, width, held, carries, pressed, stiff)
        for d in range(discs):
            system.pressed[first + d * springs.pins + pin] = pressed[d]
            energy -= 0.5 * pressed[d] * width[d]
        for d in range(discs):
            i = first + d * springs.pins + pin
            if not carries[d]:
                continue
            force, system.row[i, RATE] = pressed[d], 0.0
            for e in range(discs):
                system.row[i, RATE] += stiff[d, e]  # as the plays of all discs on a pin open alike
            turning, alone = -force * rate[d], -force / springs.radius
            for a in range(4):
                system.row[i, a] = ahead[d, a]
                row = 3 * d + a if a < 3 else o
                rubs = friction * springs.rubbing[k, i, row] if rough else 0.0
                system.residual[row] += force * (ahead[d, a] + rubs)
                for b in range(4):
                    system.tangent[row, 3 * d + b if b < 3 else o] += turning * aside[d, a] * aside[d, b]
                for e in range(discs):
                    if not carries[e]:
                        continue
                    for b in range(4):
                        column = 3 * e + b if b < 3 else o
                        system.tangent[row, column] += stiff[d, e] * (ahead[d, a] + rubs) * ahead[e, b]
            # the turns of disc and output stiffen as in `assemble`
            system.tangent[3 * d + 2, 3 * d + 2] += alone * aside[d, 2]
            system.tangent[o, o] += alone * aside[d, 3]
    return energy


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _hold(flexible: Array, width: Array, held: Mask, carries: Mask, pressed: Array, stiff: Array) -> None:
    """Find the forces on one pin [N] and which contacts carry, from widths [m] and flexibility [m/N]; and stiffness.

    Contacts that would pull open, the strongest first.
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
        for d in range(discs if changes < 0 else 0):  # none pulls: does one that is open close?
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
    """Put the stiffness of the contacts of a pin that carry [N/m] into `stiff`, 0 for the others.

    It is the inverse of their flexibility, by Gauss and Jordan, in place.
    """
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
    """Compute how a disc presses on its cam at departures z."""
    x, y = z[3 * disc] - springs.cam_place[k, disc, 0], z[3 * disc + 1] - springs.cam_place[k, disc, 1]
    return pressing(x, y, springs.cam_clearance)


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def pressing(x: float, y: float, clearance: float) -> _Cam:
    """Compute how a disc that is off its cam by x and y [m] presses on it.

    As a circle in a circle, on both sides where it has no clearance.
    """
    reach = math.sqrt(x * x + y * y)
    depth, share = reach - clearance, 1.0 / reach if reach > 0.0 else 0.0
    if reach < -clearance:
        within = reach * reach + clearance * clearance
        return _Cam(x * share, y * share, 2.0 * reach, 2.0, 2.0, within, -2.0 * clearance)
    return _Cam(x * share, y * share, depth, 1.0, depth * share, 0.5 * depth * depth, max(depth, 0.0))


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def _drag(springs: KernelSprings, k: int, friction: float, system: Linearised) -> None:
    """Add the friction of contacts that slide, in proportion to their normal forces, to a system."""
    o, residual, tangent, row = springs.slope.shape[2] - 1, system.residual, system.tangent, system.row
    for i in range(_straight(springs)):
        force, x = system.pressed[i], 3 * springs.disc[i]
        for a in range(4 if force != 0.0 else 0):
            to = x + a if a < 3 else o
            rubs = friction * springs.rubbing[k, i, to]
            residual[to] += force * rubs
            for b in range(4):
                tangent[to, x + b if b < 3 else o] += row[i, RATE] * rubs * row[i, b]
