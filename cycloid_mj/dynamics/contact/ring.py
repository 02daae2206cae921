"""Exact contact of the cycloid gear with one lobe of the double-enveloping internal gear, in any pose near the ideal.

Offset gear and ring outwards by the pin radius rho: the gear becomes the trochoid T, the arc of a lobe shrinks to the
pin centre P, and the flanks Sigma become the curve S between two centres (``envelope`` with rho = 0). The gap between
the surfaces is the signed distance from S and P to T, and a line of contact is a minimum of it along the chain
P - S - P: at P where the distance grows to both sides, or inside a root where the common normal makes it stationary.

The root counter-clockwise of a lobe is B0 < B < 2 pi - B0; its half B <= pi belongs to this lobe, the other half to
the next lobe. Angles are clockwise from the lobe, as in Hsieh 2014, Eqs 8-11; lengths in metres. Points are given in
the lobe's frame: the ring's axis at the origin, the lobe on +y.
"""

import math
from typing import NamedTuple

from numba import njit

from cycloid_mj.dynamics.contact.gap import Flank, Pose, Trochoid, flank_curvature, flank_distance, inwards, outwards

_MARGIN = 0.03
"""Crank angle [rad] beyond the ideal range of a root in which a displaced gear may touch it."""

_MODIFIED_MARGIN = 0.2
"""The same for a gear that is not conjugate to the ring."""

_ROUNDS = 30
_PHASE_TOLERANCE = 1e-12
_SLOPE_TOLERANCE = 1e-9
"""Slope of the gap below which a minimum is found: in gap it is exact to rounding, in place to a nanometre."""

_BESIDE_END = 0.05
"""Angle [rad] beside the end of a root: a gap that falls from there on to the end has no minimum on the way.

It may have one farther off, where a gear is displaced by 10 um and more. In 173 000 tries, displaced by up to 0.5 mm,
flanks modified or not, every minimum found and passed over is the same as after a search to the end of all rounds.
"""


@njit
def offset_root(B: float, ring: Trochoid) -> tuple[float, float, float, float, float]:
    """Find the point x, y of S at B, the clockwise angle psi of its normal, its arc rate and its curvature 1/R [1/m].

    The arc rate is positive and R is the concave radius of S (``envelope.Sigma.radius`` at rho = 0).
    """
    radius, eccentricity, teeth = ring
    base = eccentricity * teeth
    sine, cosine = math.sin(B), math.cos(B)
    alpha = math.atan2(-base * sine, radius - base * cosine)
    K = radius * radius - base * base
    l2 = radius * radius + base * base - 2.0 * radius * base * cosine
    length = math.sqrt(l2)
    crank = ((teeth - 2.0) * B - (teeth - 1.0) * (math.pi + 2.0 * alpha)) / teeth
    psi = (math.pi - 2.0 * B - (teeth - 2.0) * alpha) / teeth
    h = ((teeth - 1.0) * K + l2) / (teeth * length)
    x = base * math.sin(crank) + h * math.sin(psi)
    y = base * math.cos(crank) + h * math.cos(psi)
    rate = ((teeth + 1.0) * length + (teeth - 1.0) * K * K / (l2 * length)) / (teeth * teeth)
    turning = (teeth + 2.0 - (teeth - 2.0) * K / l2) / (2.0 * teeth)
    return x, y, psi, rate, turning / rate


@njit
def is_monotone(ring: Trochoid) -> bool:
    """Return whether the contact passes a root once per revolution: c N / E <= (N-2)/N."""
    radius, eccentricity, teeth = ring
    return eccentricity * teeth * teeth <= radius * (teeth - 2.0)


@njit
def ideal_root_phase(crank: float, low: float, ring: Trochoid) -> float:
    """Compute B of the contact in the root at a clockwise crank angle in the ideal mesh (``is_monotone`` designs).

    ``low`` is B0, where the root begins: its cosine is c N / E.

    The crank angle rises with B from -B0 to B0 - 2 pi/N, point-symmetric about B = pi and concave before it, so that
    Newton's method from the end converges from one side.
    """
    radius, eccentricity, teeth = ring
    base = eccentricity * teeth
    K = radius * radius - base * base
    middle = -math.pi / teeth
    mirrored = crank > middle
    target = 2.0 * middle - crank if mirrored else crank
    B = low
    for _ in range(_ROUNDS):
        cosine = math.cos(B)
        alpha = math.atan2(-base * math.sin(B), radius - base * cosine)
        l2 = radius * radius + base * base - 2.0 * radius * base * cosine
        value = ((teeth - 2.0) * B - (teeth - 1.0) * (math.pi + 2.0 * alpha)) / teeth
        step = (target - value) * teeth / ((teeth - 1.0) * K / l2 - 1.0)
        B = min(math.pi, B + step)
        if abs(step) < 1e-3:
            break
    return 2.0 * math.pi - B if mirrored else B


class Minimum(NamedTuple):
    """The minimum of the gap inside a root.

    Attributes
    ----------
    exists
        Whether there is one strictly inside.
    B, distance, t
        Its phase, the signed distance [m] and the trochoid parameter of the gear's point.
    nx, ny
        Outward normal of the gear.
    """

    exists: bool
    B: float
    distance: float
    t: float
    nx: float
    ny: float


@njit(inline="always")
def _distance_slope(
    B: float, ring: Trochoid, flank: Flank, gear: Pose
) -> tuple[float, float, float, float, float, float]:
    """Distance of S(B) to the gear's flank, its slope along S, the slope's rate over B, foot t and the normal."""
    x, y, psi, rate, curvature = offset_root(B, ring)
    dx, dy = inwards(gear, x - gear.x, y - gear.y)
    t, distance, nx, ny, at_corner = flank_distance(dx, dy, flank)
    wx, wy = outwards(gear, nx, ny)
    # B runs counter-clockwise: the tangent of S is minus the derivative of u(psi).
    slope = -wx * math.cos(psi) + wy * math.sin(psi)
    # Both curvatures are large and nearly equal: that of the trochoid's parallel through S(B) counts; of a corner, that
    # of the circle around it.
    parallel = 1.0 / flank.offset if at_corner else flank_curvature(t, flank)
    bend = parallel / (1.0 + parallel * distance) - curvature
    return distance, slope, rate * bend, t, wx, wy


@njit
def root_slope(B: float, ring: Trochoid, flank: Flank, gear: Pose) -> float:
    """Compute the slope of the gap along a root [1] at a phase: negative where the gap falls as B grows.

    The `gear` is posed in the frame of the lobe clockwise of the root.
    """
    return _distance_slope(B, ring, flank, gear)[1]


@njit
def root_minimum(low: float, high: float, start: float, ring: Trochoid, flank: Flank, gear: Pose) -> Minimum:
    """Find the minimum of the gap inside a root between two phases, from a good start.

    Newton's method on the slope, kept in the bracket by the slope's sign: the gap falls, then rises.
    """
    bottom, top = low, high
    B = min(high, max(low, start))
    for _ in range(_ROUNDS):
        distance, slope, bend, t, wx, wy = _distance_slope(B, ring, flank, gear)
        if slope < 0.0:
            bottom = B
        else:
            top = B
        step = -slope / bend if bend > 0.0 else (0.5 * (top - B) if slope < 0.0 else 0.5 * (bottom - B))
        after = B + step
        if after <= bottom or after >= top:
            after = 0.5 * (bottom + top)
            end, untried = (high, top == high) if slope < 0.0 else (low, bottom == low)
            beside = untried and abs(after - end) < _BESIDE_END
            if beside and (root_slope(end, ring, flank, gear) < 0.0) == (slope < 0.0):
                break
        if abs(after - B) < _PHASE_TOLERANCE or abs(slope) < _SLOPE_TOLERANCE:
            inside = low + 1e-9 < B < high - 1e-9
            return Minimum(inside and bend > 0.0, B, distance, t, wx, wy)
        B = after
    return Minimum(False, B, distance, t, wx, wy)


@njit
def root_start(crank: float, low: float, ring: Trochoid, modified: bool) -> float:
    """Compute the phase to start the search of a root from, or 0 where it can have no contact.

    ``crank`` is the clockwise crank angle [rad] from the lobe that the root belongs to; the ideal mesh has contact for
    -B0 < crank < B0 - 2 pi/N, with ``low`` for B0, and poses within the clearances differ from it by less than the
    margin. The middle of a root is so nearly conformal that they move the contact there by many degrees, into either
    half or into both. A ``modified`` gear is not conjugate to the ring, and touches it farther from there.
    """
    last = low - 2.0 * math.pi / ring.teeth
    margin = _MODIFIED_MARGIN if modified else _MARGIN
    if not -low - margin <= crank <= last + margin:
        return 0.0
    phase = ideal_root_phase(min(last, max(-low, crank)), low, ring)
    return min(2.0 * math.pi - low - 1e-3, max(low + 1e-3, phase))
