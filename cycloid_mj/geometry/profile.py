"""The cycloid gear: its trochoid, its outline, and every closed form about them (Hsieh 2014, Eqs 2-7, corrected).

Symbols: N ring teeth, c eccentricity, E pin-circle radius, rho pin radius [m]; u(b) = (sin b, cos b), angles
clockwise from +y. A pin centre traces the trochoid T(t) = E u(t) - c u(N t) in the gear frame; the gear is its
inward parallel at the distance rho. The phase B of a pin (its angle minus the crank's) at T(t) is B = -(N-1) t,
modulo 2 pi: valley at B = 0, lobe tip at B = pi. The outline runs clockwise as t grows, from the valley on +y.
"""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError


@dataclass(frozen=True)
class CurveSettings:
    """Settings of outlines by chord error, and of `solve_monotone`."""

    max_iterations: int = 200
    sagitta_grid: int = 2049
    sagitta_rtol: float = 1e-6
    """Error of the farthest point of a chord, relative to its length: the sagitta is stationary there, and the square
    of this is its relative error."""
    min_chord_error: float = 1e-12


CURVE = CurveSettings()


@dataclass(frozen=True)
class CycloidGear:
    """The four numbers that define the mesh: N ring teeth, eccentricity c, pin-circle radius E and pin radius rho [m].

    Raises
    ------
    DesignError
        If N < 3, if a length is not positive and finite, or if c N >= E (the trochoid would have loops).
    """

    ring_teeth: int
    eccentricity: float
    pin_circle_radius: float
    pin_radius: float

    def __post_init__(self) -> None:
        """Raise DesignError unless the dimensions of a cycloid gear define a profile without loops."""
        if self.ring_teeth < 3:
            raise DesignError(
                f"the number of ring teeth is {self.ring_teeth}, but at least 3 are needed: increase ring_teeth"
            )
        for name in ("eccentricity", "pin_circle_radius", "pin_radius"):
            length = getattr(self, name)
            if not (math.isfinite(length) and length > 0):
                raise DesignError(f"{name} = {length} m is not allowed: give a finite length greater than 0 m")
        limit = self.pin_circle_radius / self.ring_teeth
        if self.eccentricity >= limit:
            raise DesignError(
                f"eccentricity = {1e3 * self.eccentricity:.6g} mm is too large: it must be less than "
                f"pin_circle_radius / ring_teeth = {1e3 * limit:.6g} mm, because at or above this value the profile "
                "crosses itself. Reduce eccentricity or ring_teeth, or increase pin_circle_radius"
            )

    @property
    def lobes(self) -> int:
        """Lobes of the gear, N - 1, which is also the reduction ratio."""
        return self.ring_teeth - 1

    @property
    def symbols(self) -> tuple[int, float, float, float]:
        """The same four values as the equations order them: N, c, E, rho."""
        return self.ring_teeth, self.eccentricity, self.pin_circle_radius, self.pin_radius

    @property
    def best_phase(self) -> float:
        """Phase B0 = acos(c N / E) [rad] of the largest moment arm, c (N-1), and the smallest pressure angle."""
        N, c, E, _ = self.symbols
        return math.acos(c * N / E)


@dataclass(frozen=True)
class Outline:
    """Points of the entire closed gear outline in the gear frame: clockwise, from the valley on +y, none repeated.

    `t` trochoid parameter [rad], `points` [m] and outward unit `normals` (n, 2), `curvature` [1/m] (positive where
    the gear is convex), `arc_length` from the first point [m].
    """

    t: Array
    points: Array
    normals: Array
    curvature: Array
    arc_length: Array


class ConjugatePoint(NamedTuple):
    """Contact point of a pin in the frames of disc and ring, each of shape (..., 2) [m]."""

    gear_frame: Array
    ring_frame: Array


def unit(angle: npt.ArrayLike) -> Array:
    """Return the unit vectors u(b) = (sin b, cos b), shape (..., 2), of angles clockwise from +y [rad]."""
    angle = np.asarray(angle, float)
    vectors = np.empty((*angle.shape, 2))  # np.stack takes three times as long for a few
    vectors[..., 0], vectors[..., 1] = np.sin(angle), np.cos(angle)
    return vectors


def pin_angles(gear: CycloidGear) -> Array:
    """Angles zeta_i of the N pins (or ring lobes), clockwise from +y, the first on +y, shape (N,) [rad]."""
    return 2 * np.pi * np.arange(gear.ring_teeth) / gear.ring_teeth


def phase(gear: CycloidGear, t: npt.ArrayLike) -> Array:
    """Phase B = -(N-1) t [rad] of the pin that touches the gear at trochoid parameter t [rad]."""
    return -gear.lobes * np.asarray(t, float)


def trochoid(gear: CycloidGear, t: npt.ArrayLike) -> Array:
    """Path of a pin centre in the gear frame (..., 2) [m]: T(t) = E u(t) - c u(N t), symbols as in `CycloidGear`."""
    N, c, E, _ = gear.symbols
    t = np.asarray(t, float)
    return E * unit(t) - c * unit(N * t)


def trochoid_derivatives(gear: CycloidGear, t: npt.ArrayLike) -> tuple[Array, Array]:
    """First and second derivative T', T'' of the trochoid by t, each (..., 2) [m]."""
    N, c, E, _ = gear.symbols
    t = np.asarray(t, float)
    first_derivative = E * unit(t + np.pi / 2) - c * N * unit(N * t + np.pi / 2)
    second_derivative = c * N**2 * unit(N * t) - E * unit(t)
    return first_derivative, second_derivative


def pitch_distance(gear: CycloidGear, B: npt.ArrayLike) -> Array:
    """Distance l of a pin centre from the pitch point c N u(crank) at phase B, also |T'(t)| [m]."""
    return _distance(gear, np.cos(B))


def conjugate_alpha(gear: CycloidGear, B: npt.ArrayLike) -> Array:
    """Angle alpha [rad] from the common normal to the pin's radius at phase B (Eq. 7, inner branch)."""
    N, c, E, _ = gear.symbols
    return np.arctan2(-c * N * np.sin(B), E - c * N * np.cos(B))


def conjugate_point(gear: CycloidGear, pin_angle: npt.ArrayLike, crank_angle_cw: npt.ArrayLike) -> ConjugatePoint:
    """Compute the contact point of a pin and the gear in the frames of gear and ring [m] (Hsieh 2014, Eqs 2 and 7).

    `pin_angle` zeta and `crank_angle_cw` phi_1 [rad] are both clockwise from +y and broadcast; a counter-clockwise
    crank angle theta is phi_1 = -theta. Eq. 2 is printed with the angle alpha + zeta; this function uses the correct
    angle alpha - zeta, with alpha of `conjugate_alpha`.
    """
    N, c, E, rho = gear.symbols
    zeta, phi = np.asarray(pin_angle, float), np.asarray(crank_angle_cw, float)
    disc_rotation = phi / (N - 1)
    alpha = conjugate_alpha(gear, zeta - phi)
    return ConjugatePoint(
        gear_frame=E * unit(zeta + disc_rotation)
        - rho * unit(zeta + disc_rotation - alpha)
        - c * unit(N * disc_rotation),
        ring_frame=E * unit(zeta) - rho * unit(zeta - alpha),
    )


def pressure_angle(gear: CycloidGear, B: npt.ArrayLike) -> Array:
    """Pressure angle pi/2 - |alpha| [rad] at phase B, smallest at +-`CycloidGear.best_phase`."""
    return np.pi / 2 - np.abs(conjugate_alpha(gear, B))


def moment_arm(gear: CycloidGear, B: npt.ArrayLike) -> Array:
    """Return the lever arm [m] about the gear centre of the common normal of the gear and a pin at the phase B [rad].

    B is the clockwise angle of the pin from the eccentric; the result has its shape. The arm is c (N-1) E sin B / l,
    and positive where the pin's push turns the gear counter-clockwise. l is the `pitch_distance`, other symbols are as
    in `CycloidGear`.
    """
    N, c, E, _ = gear.symbols
    return c * (N - 1) * E * np.sin(B) / pitch_distance(gear, B)


def normal_angle(gear: CycloidGear, t: npt.ArrayLike) -> Array:
    """Clockwise angle t - alpha [rad] of the outward normal from +y; continuous in t."""
    return np.asarray(t, float) - conjugate_alpha(gear, phase(gear, t))


def normals(gear: CycloidGear, t: npt.ArrayLike) -> Array:
    """Outward unit normals of the gear (and of its trochoid) at t, shape (..., 2)."""
    return unit(normal_angle(gear, t))


def outline(gear: CycloidGear, t: npt.ArrayLike, offset: float | None = None) -> Array:
    """Points (..., 2) [m] of the inward parallel of the trochoid at the distance `offset` [m], by default rho."""
    return trochoid(gear, t) - _offset(gear, offset) * normals(gear, t)


def curvature(gear: CycloidGear, t: npt.ArrayLike, offset: float | None = None) -> Array:
    """Compute the curvature of the disc's outline [1/m] at t [rad]: positive on the lobes' tips, negative in valleys.

    `offset` [m] is that of the outline from the trochoid, by default the pin radius. The result has the shape of t.

    Notes
    -----
    1/R with R = l^3 / [E^2 + c^2 N^3 - E c N (N+1) cos B] - offset, symbols as in `CycloidGear`, B the `phase` of t and
    l its `pitch_distance`.
    """
    cosine = np.cos(phase(gear, t))
    bracket = _curvature_bracket(gear, cosine)
    return bracket / (_distance(gear, cosine) ** 3 - _offset(gear, offset) * bracket)


def turning_rate(gear: CycloidGear, t: npt.ArrayLike) -> Array:
    """Differentiate `normal_angle` by t: [E^2 + c^2 N^3 - E c N (N+1) cos B] / l^2, shape (...)."""
    cosine = np.cos(phase(gear, t))
    return _curvature_bracket(gear, cosine) / _distance(gear, cosine) ** 2


def arc_rate(gear: CycloidGear, t: npt.ArrayLike, offset: float | None = None) -> Array:
    """Differentiate `arc_length` by t [m]: l - offset * turning rate, positive on a gear without undercut."""
    return pitch_distance(gear, phase(gear, t)) - _offset(gear, offset) * turning_rate(gear, t)


def arc_length(gear: CycloidGear, t: npt.ArrayLike, offset: float | None = None) -> Array:
    """Length [m] of the outline from the valley on +y to t: an elliptic integral less offset * normal angle."""
    scale, m = trochoid_ellipse(gear)
    half_phase = gear.lobes * np.asarray(t, float) / 2
    trochoid_length = 2 * scale / gear.lobes * (incomplete_elliptic(half_phase + np.pi / 2, m) - complete_elliptic(m))
    return trochoid_length - _offset(gear, offset) * normal_angle(gear, t)


def trochoid_ellipse(gear: CycloidGear) -> tuple[float, float]:
    """Return scale [m] and parameter m [1] of the elliptic integral that is the arc length of the trochoid.

    The arc length per parameter t is the `pitch_distance` l = (E + c N) sqrt(1 - m cos^2(B/2)) at the phase B, like
    that of an ellipse. The scale is E + c N; symbols as in `CycloidGear`.
    """
    N, c, E, _ = gear.symbols
    scale = E + c * N
    return scale, 4 * E * c * N / scale**2


def complete_elliptic(m: float) -> float:
    """Compute the complete elliptic integral of the second kind E(m) [1], 0 <= m < 1, by arithmetic-geometric means.

    Abramowitz & Stegun, 17.6.3 and 17.6.4.
    """
    mean, geometric_mean = 1.0, math.sqrt(1.0 - m)
    weight, energy_loss = 0.5, m / 2.0
    while (half_difference := (mean - geometric_mean) / 2.0) > 1e-9 * mean:
        mean, geometric_mean = (mean + geometric_mean) / 2.0, math.sqrt(mean * geometric_mean)
        weight *= 2.0
        energy_loss += weight * half_difference**2
    return math.pi / (mean + geometric_mean) * (1.0 - energy_loss)


def incomplete_elliptic(phi: npt.ArrayLike, m: float) -> Array:
    """Compute the incomplete elliptic integral of the second kind E(phi | m) of angles phi (...) [rad], shape (...).

    It uses arithmetic-geometric means and descending Landen transformations (Abramowitz & Stegun, 17.6.8 to 17.6.10),
    because importing SciPy takes longer than most of its uses.
    """
    angle, doubling = np.array(phi, float), 1.0
    mean, geometric_mean = 1.0, math.sqrt(1.0 - m)
    weight, energy_loss, sines = 0.5, m / 2.0, np.zeros_like(angle)
    while (half_difference := (mean - geometric_mean) / 2.0) > 1e-15 * mean:
        angle = _landen(angle, geometric_mean / mean)
        mean, geometric_mean = (mean + geometric_mean) / 2.0, math.sqrt(mean * geometric_mean)
        doubling, weight = 2.0 * doubling, 2.0 * weight
        energy_loss += weight * half_difference**2
        sines += half_difference * np.sin(angle)
    angle = _landen(angle, geometric_mean / mean)
    return angle / (doubling * (mean + geometric_mean)) * (1.0 - energy_loss) + sines


def _landen(angle: Array, ratio: float) -> Array:
    """Return the next angle a' of a Landen transformation, by tan(a' - a) = ratio tan(a), continuous in a [rad]."""
    sin, cos = np.sin(angle), np.cos(angle)
    return 2.0 * angle - np.arctan((1.0 - ratio) * sin * cos / (cos**2 + ratio * sin**2))


def length(gear: CycloidGear, offset: float | None = None) -> float:
    """Length of the closed outline [m]: 4 (E + c N) Ell(m) - 2 pi offset."""
    scale, m = trochoid_ellipse(gear)
    return 4 * scale * complete_elliptic(m) - 2 * math.pi * _offset(gear, offset)


def area(gear: CycloidGear, offset: float | None = None) -> float:
    """Return the area inside the disc's outline [m^2], without bore or holes.

    It is pi (E^2 + N c^2) - offset L + pi offset^2, with the length L of the trochoid and the symbols of `CycloidGear`.
    `offset` [m] is that of the outline from the trochoid, by default the pin radius.
    """
    N, c, E, _ = gear.symbols
    rho = _offset(gear, offset)
    return math.pi * (E**2 + N * c**2) - rho * length(gear, 0.0) + math.pi * rho**2


def radii(gear: CycloidGear) -> tuple[float, float]:
    """Root and tip radius of the gear, E - c - rho and E + c - rho [m]."""
    _, c, E, rho = gear.symbols
    return E - c - rho, E + c - rho


def inflection_phase(gear: CycloidGear) -> float:
    """Phase B in [0, pi) [rad] where the outline's curvature changes sign; 0 if it is convex everywhere."""
    N, c, E, _ = gear.symbols
    return math.acos(min(1.0, (E**2 + c**2 * N**3) / (E * c * N * (N + 1))))


def undercut_radius(gear: CycloidGear) -> float:
    """Compute the smallest convex radius of curvature of the trochoid [m], which is the limit of the pin radius.

    Notes
    -----
    The radius l^3 / [E^2 + c^2 N^3 - E c N (N+1) cos B] is stationary at B = 0 and B = pi, and at cos B = 3 (E^2 + c^2
    N^3) / [E c N (N+1)] - (E^2 + c^2 N^2) / (E c N) if this is between -1 and 1. Symbols as in `CycloidGear`; l is the
    `pitch_distance` at the phase B.
    """
    N, c, E, _ = gear.symbols
    stationary_cosine = 3 * (E**2 + c**2 * N**3) / (E * c * N * (N + 1)) - (E**2 + (c * N) ** 2) / (E * c * N)
    B = np.arccos(np.array([1.0, -1.0, stationary_cosine] if abs(stationary_cosine) < 1 else [1.0, -1.0]))
    numerator = _curvature_bracket(gear, np.cos(B))
    is_convex = numerator > 0
    return float(np.min(pitch_distance(gear, B[is_convex]) ** 3 / numerator[is_convex]))


def require_no_undercut(gear: CycloidGear, offset: float | None = None) -> None:
    """Raise DesignError if the disc's outline, at an `offset` from the trochoid [m], is undercut.

    The offset is by default the pin radius; it must be below `undercut_radius`. `gear` is the profile of the disc.
    """
    limit, rho = undercut_radius(gear), _offset(gear, offset)
    if rho >= limit:
        raise DesignError(
            f"pin_radius = {1e3 * rho:.6g} mm is too large: it must be less than {1e3 * limit:.6g} mm, because at or "
            "above this value the cycloid disc is undercut. Reduce pin_radius or eccentricity, or increase "
            "pin_circle_radius"
        )


def sample(gear: CycloidGear, points: int, offset: float | None = None) -> Outline:
    """Compute `points` >= 3 points of the disc's outline, at equal arc lengths, clockwise from the valley on +y.

    `offset` [m] is that of the outline from the trochoid, by default the pin radius. `gear` is the profile of the disc.

    Raises
    ------
    DesignError
        If the outline is undercut or `points` is below 3.
    """
    require_no_undercut(gear, offset)
    if points < 3:
        raise DesignError(
            f"points = {points} is too few: an outline of the cycloid disc needs at least 3 points. Increase points"
        )
    lobe, remainder = np.divmod(np.arange(points) * gear.lobes, points)
    lobe_angle = 2 * np.pi / gear.lobes
    t_in_lobe = solve_monotone(
        lambda t: arc_length(gear, t, offset),
        lambda t: arc_rate(gear, t, offset),
        length(gear, offset) / gear.lobes * (remainder / points),
        0.0,
        lobe_angle,
    )
    return _outline_at(gear, lobe_angle * lobe + t_in_lobe, offset)


@lru_cache(maxsize=16)  # what is drawn of a drive shares its profile: disc, counterweight, casing
def sagitta_parameters(gear: CycloidGear, chord_error: float, offset: float | None = None) -> Array:
    """Compute n parameters t (n,) [rad] of the disc's outline whose chords deviate by at most `chord_error` [m].

    `offset` [m] is that of the outline from the trochoid, by default the pin radius. There are as few as possible. All
    lobes have the same parameters. Each half lobe is divided at its inflection, so that a chord spans a purely concave
    or convex arc. The array is cached and read-only. `gear` is the profile of the disc.

    Raises
    ------
    DesignError
        The outline is undercut, or `chord_error` is below 1e-12 m.
    """
    require_no_undercut(gear, offset)
    flank = SmoothArc(
        points=lambda t: outline(gear, t, offset),
        normal_angle=lambda t: normal_angle(gear, t),
        turning_rate=lambda t: turning_rate(gear, t),
        arc_rate=lambda t: arc_rate(gear, t, offset),
    )
    arc_ends = sorted({0.0, inflection_phase(gear) / gear.lobes, np.pi / gear.lobes})
    arc_parameters = [
        sagitta_nodes(flank, start_t, end_t, chord_error)[:-1] for start_t, end_t in itertools.pairwise(arc_ends)
    ]
    half_lobe = np.concatenate(arc_parameters)
    lobe_angle = 2 * np.pi / gear.lobes
    one_lobe = np.concatenate([half_lobe, [lobe_angle / 2], lobe_angle - half_lobe[:0:-1]])
    parameters = np.asarray((lobe_angle * np.arange(gear.lobes)[:, None] + one_lobe).ravel())
    parameters.setflags(write=False)
    return parameters


@dataclass(frozen=True)
class SmoothArc:
    """A curve whose curvature keeps one sign, as vectorised functions of its parameter.

    `points` (n, 2) [m], `normal_angle` [rad] clockwise from +y, and the derivatives of the normal's angle and of the
    arc length by the parameter.
    """

    points: Callable[[Array], Array]
    normal_angle: Callable[[Array], Array]
    turning_rate: Callable[[Array], Array]
    arc_rate: Callable[[Array], Array]


def sagitta_nodes(arc: SmoothArc, low: float, high: float, chord_error: float) -> Array:
    """Compute n parameters (n,) from `low` to `high` of points of `arc` whose chords deviate about equally from it.

    The deviation is at most `chord_error` [m]. Chords of equal sagitta have equal shares of the integral of
    sqrt(|curvature|) ds.

    Raises
    ------
    DesignError
        `chord_error` is below 1e-12 m, the rounding of coordinates.
    """
    if not chord_error >= CURVE.min_chord_error:
        raise DesignError(f"chord_error = {chord_error} m is too small: choose at least {CURVE.min_chord_error} m")
    grid = np.linspace(low, high, CURVE.sagitta_grid)
    density = np.sqrt(np.abs(arc.turning_rate(grid) * arc.arc_rate(grid)))
    share = (
        np.concatenate([[0.0], np.cumsum(density[1:] + density[:-1])]) * (high - low) / (2 * (CURVE.sagitta_grid - 1))
    )
    chords = max(1, math.ceil(share[-1] / math.sqrt(8 * chord_error)))
    while True:
        nodes = np.interp(np.linspace(0.0, share[-1], chords + 1), share, grid)
        largest_sagitta = float(np.max(_chord_sagittas(arc, nodes)))
        if largest_sagitta <= chord_error:
            return nodes
        chords = max(chords + 1, math.floor(chords * math.sqrt(largest_sagitta / chord_error)))


def solve_monotone(
    function: Callable[[Array], Array],
    derivative: Callable[[Array], Array],
    target: npt.ArrayLike,
    low: npt.ArrayLike,
    high: npt.ArrayLike,
    rtol: float = 0.0,
) -> Array:
    """Solve function(x) = target in [low, high], elementwise, by Newton's method safeguarded by bisection.

    The iteration ends when a step is within rounding errors, or at most `rtol` times the length of the bracket. After
    `CURVE.max_iterations` steps, the last x is returned.

    Parameters
    ----------
    function, derivative
        Function of an array, monotone between `low` and `high`, and its derivative.
    target, low, high
        Values of the function, and both ends of the brackets; they broadcast to the shape of the result. For a target
        beyond the range of the function, the nearer end is returned.
    rtol
        Largest last step, relative to the length of the bracket.
    """
    target, low, high = (np.array(array, float) for array in np.broadcast_arrays(target, low, high))
    tolerance = np.maximum(2 * np.finfo(float).eps * np.maximum(np.abs(low), np.abs(high)), rtol * (high - low))
    sign = np.where(function(high) >= function(low), 1.0, -1.0)
    x = (low + high) / 2
    increment = high - low
    for _ in range(CURVE.max_iterations):
        residual, slope = sign * (function(x) - target), sign * derivative(x)
        low, high = np.where(residual <= 0, x, low), np.where(residual >= 0, x, high)
        newton_x = x - np.divide(residual, slope, out=np.full_like(x, np.inf), where=slope > 0)
        is_halved = np.abs(newton_x - x) <= np.abs(increment) / 2
        next_x = np.where((low <= newton_x) & (newton_x <= high) & is_halved, newton_x, (low + high) / 2)
        if rtol:  # elements that have converged stay: rounding errors would bisect their brackets again
            next_x = np.where(np.abs(increment) <= tolerance, x, next_x)
        x, increment = next_x, next_x - x
        if np.all(np.abs(increment) <= tolerance):
            break
    return x


def _offset(gear: CycloidGear, offset: float | None) -> float:
    return gear.pin_radius if offset is None else offset


def _distance(gear: CycloidGear, cosine: Array) -> Array:
    """Compute the `pitch_distance` l [m] from cos B."""
    N, c, E, _ = gear.symbols
    return np.sqrt(E**2 + (c * N) ** 2 - 2 * E * c * N * cosine)


def _curvature_bracket(gear: CycloidGear, cosine: Array) -> Array:
    """Compute the bracket E^2 + c^2 N^3 - E c N (N+1) cos B [m^2] of the curvature: l^2 times the turning rate."""
    N, c, E, _ = gear.symbols
    return E**2 + c**2 * N**3 - E * c * N * (N + 1) * cosine


def _outline_at(gear: CycloidGear, t: Array, offset: float | None) -> Outline:
    """Return points, normals, curvature and arc length of the disc's outline at n trochoid parameters t (n,) [rad].

    `offset` [m] is that of the outline from the trochoid; None is the pin radius. `gear` is the profile of the disc.
    """
    return Outline(
        t=t,
        points=outline(gear, t, offset),
        normals=normals(gear, t),
        curvature=curvature(gear, t, offset),
        arc_length=arc_length(gear, t, offset),
    )


def _chord_sagittas(arc: SmoothArc, nodes: Array) -> Array:
    """Compute the largest distance [m] of each chord from its arc, (n - 1,), for chords between n `nodes` (n,).

    The distance is largest where the tangent of the arc is parallel to the chord.
    """
    points, angles = arc.points(nodes), arc.normal_angle(nodes)
    dx, dy = np.diff(points, axis=0).T
    mean_angles = (angles[:-1] + angles[1:]) / 2
    chord_angle = mean_angles + np.mod(np.arctan2(-dy, dx) - mean_angles + np.pi / 2, np.pi) - np.pi / 2
    intervals = nodes[:-1], nodes[1:]
    farthest = solve_monotone(arc.normal_angle, arc.turning_rate, chord_angle, *intervals, CURVE.sagitta_rtol)
    return np.abs(np.sum((arc.points(farthest) - points[:-1]) * unit(chord_angle), axis=1))
