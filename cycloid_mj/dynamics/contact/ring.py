"""Exact contact of the cycloid gear with one lobe of the double-enveloping internal gear, in any pose near the ideal.

Offset gear and ring outwards by the pin radius rho: the gear becomes the trochoid T, the arc of a lobe shrinks to the
pin centre P, and the flanks Sigma become the curve S between two centres (``envelope`` with rho = 0). The gap between
the surfaces is the signed distance from S and P to T, and a line of contact is a minimum of it along the chain
P - S - P: at P where the distance grows to both sides, or inside a root where the common normal makes it stationary.

The root counter-clockwise of a lobe is B0 < B < 2 pi - B0; its half B <= pi belongs to this lobe, the other half to
the next lobe. Angles are clockwise from the lobe, as in Hsieh 2014, Eqs 8-11; lengths in metres. Points are in
the lobe's frame: the ring's axis at the origin, the lobe on +y.
"""

import math
from typing import NamedTuple

from numba import njit

from cycloid_mj.dynamics.contact.gap import Flank, Pose, Trochoid, flank_curvature, flank_distance, inwards, outwards


class RootSettings(NamedTuple):
    """Settings of the minimum of the gap in a root: Newton's method on its slope, within a bracket (`root_minimum`)."""

    max_iterations: int = 30
    phase_tolerance: float = 1e-12
    """Change of the phase [rad] at which the iteration ends."""
    slope_tolerance: float = 1e-9
    """Slope of the gap [1] at which it ends: the gap is exact to rounding, its position to a nanometre."""
    start_tolerance: float = 1e-3
    """Accuracy of the start [rad] (`ideal_root_phase`), and its smallest distance from the ends of the root."""
    crank_margin: float = 0.03
    """Crank angle [rad] beyond the ideal range of a root in which a displaced disc may touch it."""
    modified_crank_margin: float = 0.2
    """The same for a disc that is not conjugate to the ring."""


SETTINGS = RootSettings()


@njit
def offset_root(B: float, ring: Trochoid) -> tuple[float, float, float, float, float]:
    """Compute a point at the phase B [rad] of a root of the internal gear, offset by the pin radius into the gear.

    The offset curve S leads from the centre of one lobe's arc to that of the next. `ring` has pin circle, eccentricity
    and number of teeth of the gear. In the code, K is E^2 - c^2 N^2, with the symbols of `Trochoid`.

    Returns
    -------
    tuple of float
        Position x, y [m]; clockwise angle psi of the normal [rad]; derivative of the arc length of S with respect to
        the phase, positive [m/rad]; and curvature 1/R [1/m], with the concave radius R of S (``envelope.Sigma.radius``
        with the pin radius rho = 0).
    """
    radius, eccentricity, teeth = ring
    pitch_radius = eccentricity * teeth
    sine, cosine = math.sin(B), math.cos(B)
    alpha = math.atan2(-pitch_radius * sine, radius - pitch_radius * cosine)
    K = radius * radius - pitch_radius * pitch_radius
    squared_pitch_distance = radius * radius + pitch_radius * pitch_radius - 2.0 * radius * pitch_radius * cosine
    pitch_distance = math.sqrt(squared_pitch_distance)
    crank = ((teeth - 2.0) * B - (teeth - 1.0) * (math.pi + 2.0 * alpha)) / teeth
    psi = (math.pi - 2.0 * B - (teeth - 2.0) * alpha) / teeth
    support = ((teeth - 1.0) * K + squared_pitch_distance) / (teeth * pitch_distance)
    x = pitch_radius * math.sin(crank) + support * math.sin(psi)
    y = pitch_radius * math.cos(crank) + support * math.cos(psi)
    arc_rate = ((teeth + 1.0) * pitch_distance + (teeth - 1.0) * K * K / (squared_pitch_distance * pitch_distance)) / (
        teeth * teeth
    )
    normal_rate = (teeth + 2.0 - (teeth - 2.0) * K / squared_pitch_distance) / (2.0 * teeth)
    return x, y, psi, arc_rate, normal_rate / arc_rate


@njit
def is_monotone(ring: Trochoid) -> bool:
    """Return whether the contact passes a root once per revolution: c N / E <= (N-2)/N."""
    radius, eccentricity, teeth = ring
    return eccentricity * teeth * teeth <= radius * (teeth - 2.0)


@njit
def ideal_root_phase(crank: float, min_phase: float, ring: Trochoid) -> float:
    """Solve for the phase B [rad] of the ideal contact in a root at a clockwise crank angle [rad], by Newton's method.

    It is valid for designs with ``is_monotone`` only, and for crank angles from -B0 to B0 - 2 pi/N. `min_phase` is B0,
    where the root begins: its cosine is c N / E, with the symbols of `Trochoid`, here `ring`. In the code, K is
    E^2 - c^2 N^2.
    """
    radius, eccentricity, teeth = ring
    pitch_radius = eccentricity * teeth
    K = radius * radius - pitch_radius * pitch_radius
    root_axis = -math.pi / teeth
    is_mirrored = crank > root_axis
    target_crank = 2.0 * root_axis - crank if is_mirrored else crank
    B = min_phase
    for _ in range(SETTINGS.max_iterations):
        cosine = math.cos(B)
        alpha = math.atan2(-pitch_radius * math.sin(B), radius - pitch_radius * cosine)
        squared_pitch_distance = radius * radius + pitch_radius * pitch_radius - 2.0 * radius * pitch_radius * cosine
        crank_of_phase = ((teeth - 2.0) * B - (teeth - 1.0) * (math.pi + 2.0 * alpha)) / teeth
        increment = (target_crank - crank_of_phase) * teeth / ((teeth - 1.0) * K / squared_pitch_distance - 1.0)
        B = min(math.pi, B + increment)
        if abs(increment) < SETTINGS.start_tolerance:
            break
    return 2.0 * math.pi - B if is_mirrored else B


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
def _gap_slope(B: float, ring: Trochoid, flank: Flank, gear: Pose) -> tuple[float, float, float, float, float, float]:
    """Compute the gap of the root at the phase B [rad] to the gear's flank, and its slope along the root.

    `ring` has the shape of the root, and `gear` is the pose of the gear in the frame of the root.

    Returns
    -------
    tuple of float
        Gap [m], its slope along the root [1], the derivative of that slope with respect to B [1/rad], the parameter t
        of the foot point on the gear [rad], and the gear's outward normal (x, y).
    """
    x, y, psi, arc_rate, curvature = offset_root(B, ring)
    x_in_gear, y_in_gear = inwards(gear, x - gear.x, y - gear.y)
    t, distance, gear_nx, gear_ny, at_corner = flank_distance(x_in_gear, y_in_gear, flank)
    normal_x, normal_y = outwards(gear, gear_nx, gear_ny)
    # B runs counter-clockwise: the tangent of S is minus the derivative of u(psi).
    slope = -normal_x * math.cos(psi) + normal_y * math.sin(psi)
    # Both curvatures are large and nearly equal: that of the trochoid's parallel through S(B) counts; of a corner, that
    # of the circle around it.
    gear_curvature = 1.0 / flank.offset if at_corner else flank_curvature(t, flank)
    relative_curvature = gear_curvature / (1.0 + gear_curvature * distance) - curvature
    return distance, slope, arc_rate * relative_curvature, t, normal_x, normal_y


@njit
def root_slope(B: float, ring: Trochoid, flank: Flank, gear: Pose) -> float:
    """Compute the slope of the gap along a root [1] at a phase B [rad]: negative where the gap falls as B grows.

    `gear` is the pose of the gear in the frame of the lobe clockwise of the root.
    """
    return _gap_slope(B, ring, flank, gear)[1]


@njit
def root_minimum(min_phase: float, max_phase: float, start: float, ring: Trochoid, flank: Flank, gear: Pose) -> Minimum:
    """Find the minimum of the gap inside a root of the internal gear, from a `start` phase [rad] close to it.

    The range is from `min_phase` to `max_phase` [rad]. `ring` has the shape of the root, `flank` that of the gear, and
    `gear` is the pose of the gear in the frame of the root. The gap must fall at the first phase and rise at the last.
    The method is Newton's on the slope of the gap, with bisection.

    Returns
    -------
    Minimum
        Phase, distance and normal at the minimum. `exists` is False if the gap is smallest at an end of the range, or
        if the iteration does not converge.
    """
    lower_phase, upper_phase = min_phase, max_phase
    B = min(max_phase, max(min_phase, start))
    for _ in range(SETTINGS.max_iterations):
        distance, slope, slope_rate, t, normal_x, normal_y = _gap_slope(B, ring, flank, gear)
        if slope < 0.0:
            lower_phase = B
        else:
            upper_phase = B
        increment = (
            -slope / slope_rate
            if slope_rate > 0.0
            else (0.5 * (upper_phase - B) if slope < 0.0 else 0.5 * (lower_phase - B))
        )
        next_phase = B + increment
        if next_phase <= lower_phase or next_phase >= upper_phase:
            next_phase = 0.5 * (lower_phase + upper_phase)
        if abs(next_phase - B) < SETTINGS.phase_tolerance or abs(slope) < SETTINGS.slope_tolerance:
            is_inside = min_phase + 1e-9 < B < max_phase - 1e-9
            return Minimum(is_inside and slope_rate > 0.0, B, distance, t, normal_x, normal_y)
        B = next_phase
    return Minimum(False, B, distance, t, normal_x, normal_y)


@njit
def root_start_phase(crank: float, min_phase: float, ring: Trochoid, is_modified: bool) -> float:
    """Compute the phase [rad] from which a root is searched for a contact; 0 where it can have no contact.

    The ideal mesh has contact for -B0 < `crank` < B0 - 2 pi/N, where B0 is `min_phase`. A margin beyond this range
    allows for clearances; it is larger for a gear that is not conjugate to the ring.

    Parameters
    ----------
    crank
        Clockwise crank angle from the lobe that the root belongs to [rad].
    min_phase
        Phase at which the root begins [rad].
    ring
        The trochoid of the ring.
    is_modified
        Whether the gear is not conjugate to the ring.
    """
    max_crank = min_phase - 2.0 * math.pi / ring.teeth
    margin = SETTINGS.modified_crank_margin if is_modified else SETTINGS.crank_margin
    if not -min_phase - margin <= crank <= max_crank + margin:
        return 0.0
    phase = ideal_root_phase(min(max_crank, max(-min_phase, crank)), min_phase, ring)
    return min(2.0 * math.pi - min_phase - SETTINGS.start_tolerance, max(min_phase + SETTINGS.start_tolerance, phase))
