"""The double-enveloping internal gear: arcs of the pins and second envelope Sigma, closed form (Hsieh 2014, Eqs 8-11).

Ring frame, lobe 1 on +y; symbols, u(b) and phase B as in `profile`, and K = E^2 - c^2 N^2, l the `pitch_distance`. On
its orbit the gear sweeps, next to each lobe (the pin's own arc), a second flank: at every crank angle the common normal
intersects the pitch circle c N u(crank) of the ring twice, once for each envelope. Sigma(1) is B in [B0, pi], on the
counter-clockwise side of its lobe, and Sigma(2), its mirror image, B in [pi, 2 pi - B0], on the clockwise side of the
next lobe. Arcs and Sigma join at B0 and 2 pi - B0 with a common tangent.

No design without undercut fails here: `Sigma.radius` >= the gear's own radius of curvature at the contact, so Sigma has
no cusps. Normals point out of the ring's material, into the bore; curvature is positive where the ring is convex.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.errors import DesignError
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.profile import CycloidGear, SmoothArc, unit

Labels = npt.NDArray[np.str_]


@dataclass(frozen=True)
class RingOutline:
    """Points of the entire closed ring in the ring frame: clockwise, from the tip of lobe 1 on +y, none repeated.

    `points` [m] and unit `normals` (n, 2) into the bore, `curvature` [1/m] (positive on the convex arcs), `part`
    ("arc", "sigma1", "sigma2"), `arc_length` from the first point [m].
    """

    points: Array
    normals: Array
    curvature: Array
    part: Labels
    arc_length: Array


@dataclass(frozen=True)
class RingContacts:
    """Contacts of disc and ring at one crank angle; each array has one row per contact.

    `lobe` index (0 on +y, clockwise) and phase `B` [rad] of the ring point, `t` trochoid parameter of the gear point,
    `points` [m] and unit `normals` (n, 2) in the ring frame, into the bore, and the `relative_curvature` [1/m], gear's
    plus ring's, of the line contact. The normal's `moment_arm` is that of B.
    """

    lobe: Integers
    B: Array
    t: Array
    points: Array
    normals: Array
    relative_curvature: Array


def largest_alpha(gear: CycloidGear) -> float:
    """Half angle asin(c N / E) of the arc of each lobe [rad], where Sigma takes over (B = B0)."""
    return math.pi / 2 - gear.best_phase


def arc_points(gear: CycloidGear, alpha: npt.ArrayLike) -> Array:
    """Points (..., 2) [m] of the arc of lobe 1: E u(0) - rho u(-alpha), |alpha| <= `largest_alpha`."""
    return gear.pin_circle_radius * unit(0.0) - gear.pin_radius * unit(-np.asarray(alpha, float))


class Sigma:
    """Points of the second envelope of a gear, counter-clockwise of lobe 1, at phases `B` in [B0, 2 pi - B0] [rad]."""

    def __init__(self, gear: CycloidGear, B: npt.ArrayLike) -> None:
        self.gear = gear
        self.B = np.asarray(B, float)

    @cached_property
    def crank_angle_cw(self) -> Array:
        """Clockwise crank angle [(N-2) B - (N-1) (pi + 2 alpha)] / N at which the gear touches it there [rad]."""
        N = self.gear.ring_teeth
        return ((N - 2) * self.B - (N - 1) * (np.pi + 2 * self.alpha)) / N

    @cached_property
    def normal_angle(self) -> Array:
        """Clockwise angle psi = [pi - 2 B - (N-2) alpha] / N of the normal, out of the bore, from +y [rad]."""
        N = self.gear.ring_teeth
        return (np.pi - 2 * self.B - (N - 2) * self.alpha) / N

    @property
    def points(self) -> Array:
        """Return points (..., 2) [m] of the flank in the ring frame, on the common normal through the pitch point.

        They are c N u(crank) + (h - rho) u(psi), with h = [(N-1) K + l^2] / (N l), K = E^2 - c^2 N^2 and u(b) = (sin b,
        cos b). `crank` is `crank_angle_cw`, psi is `normal_angle`, l is `profile.pitch_distance`; N, c, E and rho are
        those of `CycloidGear`.
        """
        N, c, _, rho = self.gear.symbols
        h = ((N - 1) * _K(self.gear) + self._l**2) / (N * self._l)
        return c * N * unit(self.crank_angle_cw) + (h - rho)[..., np.newaxis] * unit(self.normal_angle)

    @property
    def radius(self) -> Array:
        """Concave radius of curvature [m].

        It is 2 [(N+1) l^4 + (N-1) K^2] / (N l [(N+2) l^2 - (N-2) K]) - rho, which is the arc rate over the turning
        rate.
        """
        return self.arc_rate / -self.turning_rate

    @property
    def arc_rate(self) -> Array:
        """Derivative of `arc_length` by B [m/rad]: [(N+1) l + (N-1) K^2 / l^3] / N^2 + rho `turning_rate`."""
        N, _, _, rho = self.gear.symbols
        return ((N + 1) * self._l + (N - 1) * _K(self.gear) ** 2 / self._l**3) / N**2 + rho * self.turning_rate

    @property
    def turning_rate(self) -> Array:
        """Derivative of `normal_angle` by B: -[(N+2) l^2 - (N-2) K] / (2 N l^2), negative all along."""
        N = self.gear.ring_teeth
        return -(N + 2 - (N - 2) * _K(self.gear) / self._l**2) / (2 * N)

    @property
    def crank_rate(self) -> Array:
        """Derivative of `crank_angle_cw` by B: [(N-1) K / l^2 - 1] / N."""
        N = self.gear.ring_teeth
        return ((N - 1) * _K(self.gear) / self._l**2 - 1) / N

    @property
    def arc_length(self) -> Array:
        """Length [m] from the junction B0."""
        return self._arc_integral - Sigma(self.gear, self.gear.best_phase)._arc_integral

    @property
    def _arc_integral(self) -> Array:
        """Return the arc length along Sigma [m] plus a constant, in the shape of the phase B.

        It is the antiderivative of `arc_rate` over B [rad]: (4/N) [(E + c N) Ell(B/2 + pi/2 | m) + M] + rho psi. N, E,
        c and rho are those of `CycloidGear`; Ell is the incomplete elliptic integral of the second kind with the
        parameter m of `profile.trochoid_ellipse`; M is `profile.moment_arm` and psi is `normal_angle`, both at B.
        """
        N, _, _, rho = self.gear.symbols
        scale, m = profile.trochoid_ellipse(self.gear)
        elliptic = scale * profile.incomplete_elliptic(self.B / 2 + np.pi / 2, m)
        return 4 / N * (elliptic + profile.moment_arm(self.gear, self.B)) + rho * self.normal_angle

    @cached_property
    def _l(self) -> Array:
        return profile.pitch_distance(self.gear, self.B)

    @cached_property
    def alpha(self) -> Array:
        """Angle from the common normal to the pin's radius [rad]; ``profile.conjugate_alpha``."""
        return profile.conjugate_alpha(self.gear, self.B)


def tightest_radius(gear: CycloidGear) -> float:
    """Compute the smallest concave radius of curvature of the internal gear [m], which is on the flanks `Sigma`.

    Notes
    -----
    With y = l^2/K, K = E^2 - c^2 N^2 and the pitch distance l, the radius is stationary at the only root above 1 of
    (N+1)(N+2) y^3 - 3 (N+1)(N-2) y^2 - 3 (N-1)(N+2) y + (N-1)(N-2). It is smallest at this root, or at the end of
    Sigma, y = (E + c N)/(E - c N), if this is smaller than the root. Symbols as in `CycloidGear`.
    """
    N, c, E, _ = gear.symbols
    cubic = [(N + 1) * (N + 2), -3 * (N + 1) * (N - 2), -3 * (N - 1) * (N + 2), (N - 1) * (N - 2)]
    y = min(float(np.max(np.roots(cubic).real)), (E + c * N) / (E - c * N))
    cos_B = (E**2 + (c * N) ** 2 - y * _K(gear)) / (2 * E * c * N)
    return float(Sigma(gear, math.acos(max(-1.0, cos_B))).radius)


def junction(gear: CycloidGear) -> Array:
    """Points (2, 2) [m] where the arc of lobe 1 joins Sigma: counter-clockwise side first, then clockwise."""
    alpha = largest_alpha(gear)
    return arc_points(gear, [-alpha, alpha])


def radii(gear: CycloidGear) -> tuple[float, float]:
    """Root and lobe-tip radius of the ring, E + 2 c - rho and E - rho [m]."""
    _, c, E, rho = gear.symbols
    return E + 2 * c - rho, E - rho


def perimeter(gear: CycloidGear) -> float:
    """Perimeter of the ring [m]: the gear's plus 8 c (Fagnano's theorem sums the elliptic integrals)."""
    return profile.length(gear) + 8 * gear.eccentricity


def area(gear: CycloidGear) -> float:
    """Compute the area of the bore of the internal gear [m^2], bounded by the arcs of the lobes and the flanks `Sigma`.

    Notes
    -----
    It is A0 - rho (L + 8 c) + pi rho^2, with the trochoid's length L and A0 = pi (N+1) (E^2/N + 2 c^2) - 2 B0 (E^2/N +
    2 N c^2) + 6 c sqrt(E^2 - c^2 N^2). Symbols as in `CycloidGear`, with B0 its `best_phase`.
    """
    N, c, E, rho = gear.symbols
    B0 = gear.best_phase
    A0 = math.pi * (N + 1) * (E**2 / N + 2 * c**2) - 2 * B0 * (E**2 / N + 2 * N * c**2) + 6 * c * math.sqrt(_K(gear))
    return A0 - rho * (profile.length(gear, 0.0) + 8 * c) + math.pi * rho**2


def require_envelope(gear: CycloidGear) -> None:
    """Raise DesignError unless the gear is free of undercut, which is all that the envelope needs."""
    profile.require_no_undercut(gear)


def sample_ring(gear: CycloidGear, points: int) -> RingOutline:
    """Compute `points` >= 3 points on the outline of the internal gear, clockwise from the tip of lobe 1 on +y.

    They are equally spaced by arc length.

    Raises
    ------
    DesignError
        If the gear is undercut or `points` is below 3.
    """
    require_envelope(gear)
    if points < 3:
        raise DesignError(
            f"points = {points} is too few: an outline of the internal gear needs at least 3 points. Increase points"
        )
    pitch = perimeter(gear) / gear.ring_teeth
    lobe, remainder = np.divmod(np.arange(points) * gear.ring_teeth, points)
    is_in_second_half = 2 * remainder > points
    signed_share = np.where(is_in_second_half, remainder - points, remainder) / points
    return _ring_points(gear, lobe + is_in_second_half, pitch * signed_share)


def sample_ring_by_sagitta(gear: CycloidGear, chord_error: float) -> RingOutline:
    """Compute few points on the outline of the internal gear; chords deviate from it by at most `chord_error` [m].

    Each lobe of the internal gear is a circular arc with the pin radius at its tip, and on each side a flank (`Sigma`,
    the second envelope of the disc). All lobes have the same points. The points at which arc and flank meet are
    included, so that no chord spans parts of both. The order is clockwise, from the tip of lobe 1 on +y.

    Raises
    ------
    DesignError
        The gear is undercut, or `chord_error` is below 1e-12 m.
    """
    flank_phases, arc_half_angle, arc_radius = sigma_nodes(gear, chord_error), largest_alpha(gear), gear.pin_radius
    arc_chords = max(1, math.ceil(arc_half_angle / (2 * math.acos(max(0.0, 1 - chord_error / arc_radius)))))
    half_lobe_lengths = np.concatenate(
        [
            np.linspace(0, arc_radius * arc_half_angle, arc_chords + 1),
            arc_radius * arc_half_angle + Sigma(gear, flank_phases[1:]).arc_length,
        ]
    )
    half_lobe_lengths[-1] = perimeter(gear) / gear.ring_teeth / 2
    signed_lengths = np.concatenate([half_lobe_lengths, -half_lobe_lengths[-2:0:-1]])
    lobe = np.arange(gear.ring_teeth)[:, np.newaxis] + (signed_lengths < 0)
    return _ring_points(gear, lobe.ravel(), np.tile(signed_lengths, gear.ring_teeth))


def sigma_nodes(gear: CycloidGear, chord_error: float) -> Array:
    """Compute n phases B (n,) [rad] of points on half a flank Sigma, which joins two arcs of the internal gear.

    The half is from the junction with the arc to the middle of the root. There are as few points as possible. The
    chords between the points deviate about equally from Sigma, by at most `chord_error` [m].

    Raises
    ------
    DesignError
        The gear is undercut, or `chord_error` is below 1e-12 m.
    """
    require_envelope(gear)
    flank = SmoothArc(
        points=lambda B: Sigma(gear, B).points,
        normal_angle=lambda B: Sigma(gear, B).normal_angle,
        turning_rate=lambda B: Sigma(gear, B).turning_rate,
        arc_rate=lambda B: Sigma(gear, B).arc_rate,
    )
    return profile.sagitta_nodes(flank, gear.best_phase, np.pi, chord_error)


def arc_contacts(gear: CycloidGear, crank_angle: float | Array) -> RingContacts:
    """Compute the contacts of the gear with the N arcs (or pins) at a counter-clockwise `crank_angle` [rad].

    `gear` is the profile of the disc. For k crank angles of shape (k, 1), numbers have shape (k, N) and vectors (k, N,
    2).
    """
    zeta = profile.pin_angles(gear)
    B = zeta + crank_angle
    alpha = profile.conjugate_alpha(gear, B)
    normals, t = -unit(zeta - alpha), zeta - alpha - crank_angle / gear.lobes + alpha
    return RingContacts(
        lobe=np.arange(gear.ring_teeth),
        B=B,
        t=t,
        points=gear.pin_circle_radius * unit(zeta) + gear.pin_radius * normals,
        normals=normals,
        relative_curvature=1 / gear.pin_radius + profile.curvature(gear, t),
    )


def sigma_contacts(gear: CycloidGear, crank_angle: float) -> RingContacts:
    """Compute the contacts of the gear with Sigma at a counter-clockwise `crank_angle` [rad], in order of lobes.

    Sigma are the flanks between the arcs of the ring. A lobe may have no contact with them or several.

    Raises
    ------
    DesignError
        The gear is undercut.

    Notes
    -----
    The equation `Sigma.crank_angle_cw` = -crank_angle minus the lobe's angle, modulo 2 pi, is solved for the phase B on
    each interval where the left side is monotone: one interval if c N / E <= (N-2)/N, three otherwise.
    """
    require_envelope(gear)
    zeta = profile.pin_angles(gear)
    contacts = []
    for min_phase, max_phase in _monotone_intervals(gear):
        end_angles = Sigma(gear, [min_phase, max_phase]).crank_angle_cw
        contact_phase = end_angles.min() + np.mod(-crank_angle - zeta - end_angles.min(), 2 * np.pi)
        lobe = np.flatnonzero(contact_phase < end_angles.max())
        B = profile.solve_monotone(
            lambda B: Sigma(gear, B).crank_angle_cw,
            lambda B: Sigma(gear, B).crank_rate,
            contact_phase[lobe],
            min_phase,
            max_phase,
        )
        contacts.append((lobe, B))
    lobe, B = (np.concatenate(column) for column in zip(*contacts, strict=True))
    sort_order = np.lexsort((B, lobe))
    lobe, B = lobe[sort_order], B[sort_order]
    contact_flank = Sigma(gear, B)
    angle = zeta[lobe] + contact_flank.normal_angle
    t = angle - crank_angle / gear.lobes + contact_flank.alpha
    return RingContacts(
        lobe=lobe,
        B=B,
        t=t,
        normals=-unit(angle),
        relative_curvature=-1 / contact_flank.radius + profile.curvature(gear, t),
        points=_rotate(contact_flank.points, zeta[lobe]),
    )


def _K(gear: CycloidGear) -> float:
    N, c, E, _ = gear.symbols
    return E**2 - (c * N) ** 2


def _monotone_intervals(gear: CycloidGear) -> list[tuple[float, float]]:
    """Return the intervals of the phase B in which the crank angle of the contact, `Sigma.crank_angle_cw`, is monotone.

    There are one or three. They are between B0 = `CycloidGear.best_phase` and 2 pi - B0, and end where l^2 = (N-1) (E^2
    - c^2 N^2), with the pitch distance l and the symbols of `CycloidGear`.

    Returns
    -------
    list of tuple
        Both ends of each interval [rad].
    """
    N, c, E, _ = gear.symbols
    B0 = gear.best_phase
    turning_cosine = (E**2 + (c * N) ** 2 - (N - 1) * _K(gear)) / (2 * E * c * N)
    if turning_cosine <= -1:
        return [(B0, 2 * math.pi - B0)]
    B1 = math.acos(turning_cosine)
    return [(B0, B1), (B1, 2 * math.pi - B1), (2 * math.pi - B1, 2 * math.pi - B0)]


def _rotate(points: Array, angle: Array) -> Array:
    """Rotate points (n, 2) [m] clockwise about the ring's axis by angles (n,) [rad]."""
    x, y = points.T
    return np.stack([x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)], axis=1)


def _ring_points(gear: CycloidGear, lobe: Integers, arc_lengths: Array) -> RingOutline:
    """Compute points of the internal gear's outline at n arc lengths [m] from the tips of lobes, up to half a lobe.

    Arc lengths are positive clockwise. `lobe` (n,) are the n indices of the lobes, 0 on +y, clockwise.
    """
    rho, arc_half = gear.pin_radius, gear.pin_radius * largest_alpha(gear)
    distance, sign = np.abs(arc_lengths), np.where(arc_lengths < 0, -1.0, 1.0)
    # Lobes are alike: each distance is solved once.
    unique_distances, unique_index = np.unique(distance, return_inverse=True)
    B = profile.solve_monotone(
        lambda B: Sigma(gear, B).arc_length,
        lambda B: Sigma(gear, B).arc_rate,
        unique_distances - arc_half,
        gear.best_phase,
        np.pi,
    )[unique_index]
    alpha = np.minimum(distance / rho, largest_alpha(gear))
    is_on_arc = distance <= arc_half
    flank = Sigma(gear, B)
    half_lobe_points = np.where(is_on_arc[:, np.newaxis], arc_points(gear, alpha), flank.points * [-1, 1])
    half_lobe_angle = np.where(is_on_arc, -alpha, -flank.normal_angle)
    zeta = 2 * np.pi * lobe / gear.ring_teeth
    return RingOutline(
        normals=-unit(zeta + sign * half_lobe_angle),
        points=_rotate(half_lobe_points * np.stack([sign, np.ones_like(sign)], axis=1), zeta),
        curvature=np.where(is_on_arc, 1 / rho, -1 / flank.radius),
        part=np.where(is_on_arc, "arc", np.where(sign < 0, "sigma1", "sigma2")),
        arc_length=perimeter(gear) / gear.ring_teeth * lobe + arc_lengths,
    )
