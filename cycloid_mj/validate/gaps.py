"""Gaps of the mesh near the ideal pose by search over points of the curves, independent of `contact`.

The disc is the inward parallel curve of its trochoid, so the gap of a point of the ring, offset outwards by the pin
radius, is its signed distance from the trochoid plus the clearance. Modified flanks have a trochoid of their own, which
can be rotated and have waves. Lengths [m], angles [rad]; rotations counter-clockwise.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.geometry import envelope, profile
from cycloid_mj.geometry.modification import FlankEnds, flank_ends
from cycloid_mj.geometry.profile import CycloidGear, unit
from cycloid_mj.reducer import Reducer

Indices = Integers

_MAX_NEWTON_STEPS, _NEWTON_ATOL = 8, 1e-10
"""Maximum number of steps, and the step [rad] at which iteration stops: convergence is quadratic."""


@dataclass(frozen=True)
class GearPose:
    """Pose of the gear: `centre` from the reducer's axis [m], shape (2,), and `angle` [rad]."""

    centre: Array
    angle: float

    def to_gear(self, points: Array) -> Array:
        """Transform points (n, 2) from the frame of the ring to that of the disc."""
        return rotate(points - self.centre, -self.angle)


@dataclass(frozen=True)
class Flanks:
    """Manufactured flanks, generated for `gear` at an `offset` [m] from its trochoid.

    They are rotated by `rotation` >= 0 [rad] towards the middle of their lobes. `waves` lists the orders k (cycles per
    turn) by which the trochoid is set back, with the amplitudes [m] of cos(k t) and sin(k t).
    """

    gear: CycloidGear
    offset: float
    rotation: float
    waves: tuple[tuple[int, float, float], ...] = ()


def design_flanks(reducer: Reducer) -> Flanks:
    """Return profile, offset, rotation and waves of the flanks of a disc."""
    amplitudes = enumerate(reducer.deviations.waves.tolist(), start=1)
    waves = tuple((order, cosine, sine) for order, (cosine, sine) in amplitudes if cosine or sine)
    return Flanks(reducer.gear_profile, reducer.profile_offset, reducer.design.modification.rotation, waves)


@dataclass(frozen=True)
class NearestPoints:
    """The n pairs of nearest points of disc and ring.

    Attributes
    ----------
    distance
        Signed distance of the offset ring from the trochoid [m]; the gap is this plus the clearance. Shape (n,).
    normals
        Outward unit normals of the gear, ring frame, shape (n, 2).
    places
        Points on these normals [m], ring frame, shape (n, 2).
    t
        Trochoid parameter of the gear's point [rad], shape (n,).
    owner
        Index of the pin or lobe, 0 on +y, clockwise.
    B
        Phase on the root [rad]; not a number on an arc or pin.
    ring_curvature
        Of the ring's surface [1/m], positive where convex.
    """

    distance: Array
    normals: Array
    places: Array
    t: Array
    owner: Indices
    B: Array
    ring_curvature: Array


def rotate(points: Array, angle: npt.ArrayLike) -> Array:
    """Turn points (..., 2) counter-clockwise about the origin by `angle` [rad], shape (...)."""
    cos, sin, x, y = np.cos(angle), np.sin(angle), points[..., 0], points[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)


def trochoid_distance(gear: CycloidGear, points: Array) -> tuple[Array, Array, Array]:
    """Compute the signed distance of n points (n, 2) [m] in the gear's frame from the trochoid.

    From the nearest of many samples of the trochoid T(t), Newton's method determines the foot point of each point p,
    where (T - p) . T' = 0.

    Returns
    -------
    tuple of Array
        Distance [m], shape (n,), positive outside, outward normal (n, 2), and parameter t of the nearest point [rad],
        (n,).
    """
    tree, samples = _samples(gear)
    t = samples[tree.query(points)[1]]
    for _ in range(_MAX_NEWTON_STEPS):
        first_derivative, second_derivative = profile.trochoid_derivatives(gear, t)
        difference = profile.trochoid(gear, t) - points
        increment = _dot(difference, first_derivative) / (
            _dot(first_derivative, first_derivative) + _dot(difference, second_derivative)
        )
        t = t - increment
        if np.abs(increment).max(initial=0.0) < _NEWTON_ATOL:
            break
    normals = profile.normals(gear, t)
    return _dot(points - profile.trochoid(gear, t), normals), normals, t


def flank_distance(flanks: Flanks, points: Array) -> tuple[Array, Array, Array]:
    """Compute the distance of n points outside the gear from its flanks, minus the `offset` of the flanks.

    `points` are in the frame of the gear [m], shape (n, 2). Flanks that are rotated by a modification end at the tip
    and in the valley. If the nearest point would be beyond an end, the end is used. Of the two sides of a lobe, the
    nearer is used.

    Returns
    -------
    tuple of Array
        Distance [m], shape (n,), outward normal (n, 2), and parameter t of the nearest point [rad], (n,).
    """
    if not flanks.rotation:
        return _waved_distance(flanks, points)
    sides = [_rotated_flank_distance(flanks, points, side) for side in (1, -1)]
    is_first = (sides[0][0] <= sides[1][0])[:, np.newaxis]
    distance, normals, t = (
        np.where(is_first if values.ndim == 2 else is_first[:, 0], values, other_values)
        for values, other_values in zip(*sides, strict=True)
    )
    return distance, normals, t


def _waved_distance(flanks: Flanks, points: Array) -> tuple[Array, Array, Array]:
    """Compute the signed distance of n points [m] in the gear's frame, shape (n, 2), from flanks with waves.

    The curve is the trochoid with the profile waves of `flanks`. Newton's method starts from the nearest point of the
    trochoid without waves. Returned are the distance [m], shape (n,), the outward normal (n, 2), and the parameter t of
    the nearest point [rad], (n,).
    """
    distance, normals, t = trochoid_distance(flanks.gear, points)
    if not flanks.waves:
        return distance, normals, t
    for _ in range(_MAX_NEWTON_STEPS):
        curve, tangent = _waved_curve(flanks, t)
        difference, curvature_vector = curve - points, profile.trochoid_derivatives(flanks.gear, t)[1]
        t = t - _dot(difference, tangent) / (_dot(tangent, tangent) + _dot(difference, curvature_vector))
    curve, tangent = _waved_curve(flanks, t)
    normals = _outward_normals(tangent)
    return _dot(points - curve, normals), normals, t


def _waved_curve(flanks: Flanks, t: Array) -> tuple[Array, Array]:
    """Compute points T - w n of the trochoid T with profile waves at n parameters t [rad], and their derivatives by t.

    The waves w(t) [m] of `flanks` set the trochoid back along its normal n.

    Returns
    -------
    tuple of Array
        Points [m] and derivatives [m], shape (n, 2) each.
    """
    gear = flanks.gear
    offset, offset_rate = np.zeros(t.shape), np.zeros(t.shape)
    for order, cosine, sine in flanks.waves:
        offset += cosine * np.cos(order * t) + sine * np.sin(order * t)
        offset_rate += order * (sine * np.cos(order * t) - cosine * np.sin(order * t))
    normals = profile.normals(gear, t)
    normal_rate = profile.turning_rate(gear, t)[:, np.newaxis] * rotate(normals, -np.pi / 2)
    curve = profile.trochoid(gear, t) - offset[:, np.newaxis] * normals
    tangent = (
        profile.trochoid_derivatives(gear, t)[0]
        - offset_rate[:, np.newaxis] * normals
        - offset[:, np.newaxis] * normal_rate
    )
    return curve, tangent


def _outward_normals(tangents: Array) -> Array:
    """Compute the outward unit normals (n, 2) of a clockwise curve from its derivative."""
    return rotate(tangents / np.linalg.norm(tangents, axis=1, keepdims=True), np.pi / 2)


def _rotated_flank_distance(flanks: Flanks, points: Array, side: int) -> tuple[Array, Array, Array]:
    """Compute the distance of n points [m] in the gear's frame, (n, 2), from the flanks on one side of the tips.

    `side` is 1 for the flanks before the tips (with growing parameter), -1 for those after them; they are rotated by
    the modification.

    Returns
    -------
    tuple of Array
        Distance minus the offset of the flanks (n,) [m], positive outside; unit normal in the gear's frame (n, 2);
        parameter t of the nearest point (n,) [rad].
    """
    gear, flank_ends = flanks.gear, _flank_ends(flanks)
    rotated_points = rotate(points, side * flanks.rotation)
    t = _waved_distance(flanks, rotated_points)[2]
    pitch = 2 * np.pi / gear.lobes
    # From the valley of its lobe half; feet beyond the middle between tip and valley belong to the next valley.
    lobe_number = np.floor(side * t / pitch + 1 / 4)
    phase = np.clip(side * t - lobe_number * pitch, -flank_ends.valley, pitch / 2 - flank_ends.tip)
    t = side * (phase + lobe_number * pitch)
    curve, tangent = _waved_curve(flanks, t)
    difference = rotated_points - curve + flanks.offset * _outward_normals(tangent)
    distance = np.linalg.norm(difference, axis=1)
    return distance - flanks.offset, rotate(difference / distance[:, np.newaxis], -side * flanks.rotation), t


def pin_gaps(gear: CycloidGear, pose: GearPose, centres: Array, flanks: Flanks | None = None) -> NearestPoints:
    """Compute distance, disc normal and profile parameter of the disc's nearest point to each of N ring pins.

    The gap of a pin is this distance plus the clearance, which is not included here. `pose` is the position of the
    disc, and `centres` (N, 2) [m] are the centres of the pins in the ring's frame. `flanks` are those of the disc, by
    default the ideal flanks of `gear`.
    """
    distance, normals, t = flank_distance(flanks or _ideal(gear), pose.to_gear(centres))
    pin_count = gear.ring_teeth
    return NearestPoints(
        distance=distance,
        normals=rotate(normals, pose.angle),
        places=centres,
        t=t,
        owner=np.arange(pin_count),
        B=np.full(pin_count, np.nan),
        ring_curvature=np.full(pin_count, 1 / gear.pin_radius),
    )


def ring_gaps(gear: CycloidGear, pose: GearPose, roots: Indices, flanks: Flanks | None = None) -> NearestPoints:
    """Compute the nearest points of the disc at a `pose` and an internal gear.

    The gap is their distance plus the clearance. The first rows are the arcs that the disc can touch. The others are
    local minima of the distance in the roots with the indices `roots`. The disc can touch an arc only where its normal
    is at most asin(c N/E) from the radial direction, with the eccentricity c, N lobes of the ring and the pin-circle
    radius E. Root k is counter-clockwise of lobe k. The phase B of a point in a root (``envelope.Sigma``) is between
    B0 = `CycloidGear.best_phase` and 2 pi - B0; beyond pi, the point belongs to the next lobe. `flanks` are those of
    the disc, by default the ideal flanks of `gear`.
    """
    flanks = flanks or _ideal(gear)
    arc_points = pin_gaps(gear, pose, gear.pin_circle_radius * unit(profile.pin_angles(gear)), flanks)
    arc_directions = unit(profile.pin_angles(gear))
    sine = arc_points.normals[:, 0] * arc_directions[:, 1] - arc_points.normals[:, 1] * arc_directions[:, 0]
    is_on_arc = np.abs(sine) <= np.sin(envelope.largest_alpha(gear))
    return _concatenate(_select(arc_points, is_on_arc), _root_minima(gear, pose, roots, flanks))


def offset_root(gear: CycloidGear, root: int | Indices, B: Array) -> Array:
    """Compute points [m] of Sigma in roots `root` at phases B, offset outwards by the pin radius; shape (..., 2)."""
    flank = envelope.Sigma(gear, B)
    surface = flank.points + gear.pin_radius * unit(flank.normal_angle)
    return rotate(surface, -profile.pin_angles(gear)[root])


def _root_minima(gear: CycloidGear, pose: GearPose, roots: Indices, flanks: Flanks) -> NearestPoints:
    """Compute the local minima of the distance between the disc, at a `pose`, and the ring in the `roots` (indices).

    A root may have no minimum or several minima. Each is a sample lower than its two neighbours, and is refined by a
    parabola through the three. `flanks` are those of the disc, `gear` is its profile.
    """
    min_phase = gear.best_phase
    B = np.pi - (np.pi - min_phase) * np.cos(np.linspace(0, np.pi, 400))
    samples = pose.to_gear(offset_root(gear, roots[:, np.newaxis], B))
    distances = flank_distance(flanks, samples.reshape(-1, 2))[0].reshape(roots.size, B.size)
    root_rows, columns = np.nonzero((distances[:, 1:-1] < distances[:, :-2]) & (distances[:, 1:-1] <= distances[:, 2:]))
    sample_columns = [columns, columns + 1, columns + 2]
    phases = _parabola_minimum(
        *(B[column] for column in sample_columns), *(distances[root_rows, column] for column in sample_columns)
    )
    points = offset_root(gear, roots[root_rows], phases)
    distance, normals, t = flank_distance(flanks, pose.to_gear(points))
    return NearestPoints(
        distance=distance,
        normals=rotate(normals, pose.angle),
        places=points,
        t=t,
        owner=(roots[root_rows] - (phases > np.pi)) % gear.ring_teeth,
        B=phases,
        ring_curvature=-1 / envelope.Sigma(gear, phases).radius,
    )


def _parabola_minimum(x0: Array, x1: Array, x2: Array, y0: Array, y1: Array, y2: Array) -> Array:
    """Compute the position of the minimum of parabolas through three points each."""
    left_slope, right_slope = (y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1)
    return (x0 + x1) / 2 - left_slope * (x2 - x0) / (2 * (right_slope - left_slope))


def _ideal(gear: CycloidGear) -> Flanks:
    return Flanks(gear, gear.pin_radius, 0.0)


@cache
def _flank_ends(flanks: Flanks) -> FlankEnds:
    return flank_ends(flanks.gear, flanks.offset, flanks.rotation)


@cache
def _samples(gear: CycloidGear) -> tuple[cKDTree, Array]:
    t = np.linspace(0, 2 * np.pi, 200 * gear.lobes, endpoint=False)
    return cKDTree(profile.trochoid(gear, t)), t


def _select(gaps: NearestPoints, rows: Mask) -> NearestPoints:
    return NearestPoints(**{name: values[rows] for name, values in vars(gaps).items()})


def _concatenate(*parts: NearestPoints) -> NearestPoints:
    return NearestPoints(**{name: np.concatenate([vars(part)[name] for part in parts]) for name in vars(parts[0])})


def _dot(a: Array, b: Array) -> Array:
    return np.sum(a * b, axis=-1)
