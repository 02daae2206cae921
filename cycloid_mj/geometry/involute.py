"""External involute spur gears as a rack cuts them: flanks, fillets and radii.

The rack is profile A of ISO 53: addendum m, dedendum 1.25 m, corners of radius 0.38 m. Points are in the frame of the
gear, with the middle of a tooth space on +y. The functions return the side of that space at x > 0, from root to tip.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array

DEDENDUM = 1.25
"""Dedendum of the rack per module (ISO 53, profile A)."""

CORNER_RADIUS = 0.38
"""Radius of the corners of the rack per module (ISO 53, profile A)."""

TIP_CLEARANCE = DEDENDUM - 1.0
"""Clearance between tip and mating root per module."""

SHIFT_STEP = 0.05
"""Step of the profile shift coefficient of a pinion (heuristic): above the least shift, the flank does not begin in a
cusp."""

PATH_NODES = 4
"""Gauss-Legendre nodes of each interval of a path of contact: exact for polynomials up to the seventh degree."""


@dataclass(frozen=True)
class InvoluteGear:
    """An external spur gear.

    Attributes
    ----------
    teeth
        Number of teeth z.
    module
        Module m [m].
    pressure_angle
        At the reference circle [rad].
    shift
        Profile shift coefficient x.
    tip_radius
        Radius of the tip circle [m].
    thinning
        Decrease of the tooth thickness at the reference circle, for backlash [m].
    """

    teeth: int
    module: float
    pressure_angle: float
    shift: float
    tip_radius: float
    thinning: float = 0.0

    @property
    def reference_radius(self) -> float:
        """Radius of the reference circle [m]: m z/2."""
        return self.module * self.teeth / 2.0

    @property
    def base_radius(self) -> float:
        """Radius of the base circle [m]."""
        return self.reference_radius * math.cos(self.pressure_angle)

    @property
    def root_radius(self) -> float:
        """Radius of the root circle [m]."""
        return self.reference_radius - self.module * (DEDENDUM - self.shift)

    @property
    def corner_depth(self) -> float:
        """Depth of the centre of the rack's corner below the reference circle, at the middle of the space [m]."""
        return self.module * (DEDENDUM - CORNER_RADIUS - self.shift)

    @property
    def corner_offset(self) -> float:
        """Distance of the centre of the rack's corner from the middle of the rack's tooth [m]."""
        half_tooth = math.pi * self.module / 4.0 + self.thinning / 4.0
        slope = math.tan(self.pressure_angle) * (DEDENDUM - CORNER_RADIUS)
        return half_tooth - self.module * (slope + CORNER_RADIUS / math.cos(self.pressure_angle))

    @property
    def space_half_angle(self) -> float:
        """Half of the angle of a tooth space at the base circle, extrapolated from the flanks [rad]."""
        thickness = self.module * (math.pi / 2.0 + 2.0 * self.shift * math.tan(self.pressure_angle)) - self.thinning
        half_tooth = thickness / (2.0 * self.reference_radius)
        return math.pi / self.teeth - half_tooth - involute(self.pressure_angle)

    @property
    def first_roll(self) -> float:
        """Roll angle at the lower end of the involute [rad]; negative: the rack undercuts the flank."""
        along_line = self.corner_depth / math.sin(self.pressure_angle) + self.module * CORNER_RADIUS
        return math.tan(self.pressure_angle) - along_line / self.base_radius

    @property
    def last_roll(self) -> float:
        """Roll angle at the tip [rad]."""
        return math.sqrt((self.tip_radius / self.base_radius) ** 2 - 1.0)

    @property
    def last_corner(self) -> float:
        """Position of the rack's corner where it leaves the fillet and cuts the involute [m]; see `fillet`."""
        return self.corner_depth / math.tan(self.pressure_angle)

    @property
    def tip_half_angle(self) -> float:
        """Half of the angle of a tooth at the tip [rad]; not positive: the tooth is pointed below its tip circle."""
        roll = self.last_roll
        return math.pi / self.teeth - (self.space_half_angle + roll - math.atan(roll))

    @property
    def fault(self) -> str:
        """Reason why the teeth are unusable: "undercut" or "pointed"; empty if they are usable."""
        if self.corner_depth <= 0.0 or self.first_roll < 0.0:
            return "undercut"
        return "pointed" if self.tip_half_angle <= 0.0 else ""

    def flank(self, roll: npt.ArrayLike) -> Array:
        """Compute points (n, 2) [m] of the involute at roll angles (n,) [rad], the tangents of the pressure angles."""
        t = np.asarray(roll, dtype=np.float64)
        turned = self.space_half_angle + t
        along, across = np.stack([np.sin(turned), np.cos(turned)], -1), np.stack([-np.cos(turned), np.sin(turned)], -1)
        return self.base_radius * (along + t[..., np.newaxis] * across)

    def flank_tangents(self, roll: npt.ArrayLike) -> Array:
        """Compute unit tangents (n, 2) of the involute towards the tip, at roll angles (n,) [rad]."""
        turned = self.space_half_angle + np.asarray(roll, dtype=np.float64)
        return np.stack([np.sin(turned), np.cos(turned)], -1)

    def flank_length(self, roll: npt.ArrayLike) -> Array:
        """Compute the arc length of the involute from the base circle [m], at roll angles (n,) [rad]."""
        return np.asarray(self.base_radius * np.square(roll) / 2.0)

    def flank_curvature(self, roll: npt.ArrayLike) -> Array:
        """Compute the signed curvature of the involute [1/m] at roll angles [rad], negative: clockwise."""
        return np.asarray(-1.0 / (self.base_radius * np.asarray(roll, dtype=np.float64)))

    def fillet(self, corner: npt.ArrayLike) -> Array:
        """Compute n points (n, 2) [m] of the fillet of a tooth, which the corner of the rack cuts.

        The +y axis is the middle of the tooth space. `corner` (n,) [m] is the position of the corner's centre along the
        rack, from 0 (its point on the root circle) to `last_corner` (on the involute). The contact normal of rack and
        gear passes through the pitch point.
        """
        position = np.asarray(corner, dtype=np.float64)
        depth, radius = self.corner_depth, self.reference_radius
        distance = np.hypot(position, depth)
        scale = 1.0 + self.module * CORNER_RADIUS / distance
        return _rotate(position * scale, radius - depth * scale, (position - self.corner_offset) / radius)

    def fillet_tangents(self, corner: npt.ArrayLike) -> Array:
        """Compute unit tangents (n, 2) of the fillet towards the involute, at positions (n,) [m] as in `fillet`."""
        s = np.asarray(corner, dtype=np.float64)
        distance = np.hypot(s, self.corner_depth)
        angle = (s - self.corner_offset) / self.reference_radius
        return _rotate(self.corner_depth / distance, s / distance, angle)

    def fillet_length(self, corner: npt.ArrayLike) -> Array:
        """Compute the arc length [m] of the fillet of a tooth from the root circle to n points (n,).

        `corner` (n,) [m] are the positions of the rack's corner that cuts these points, as in `fillet`.
        """
        position = np.asarray(corner, dtype=np.float64)
        depth, radius = self.corner_depth, self.reference_radius
        centre_length = (position * np.hypot(position, depth) + depth * depth * np.arcsinh(position / depth)) / (
            2.0 * radius
        )
        return np.asarray(
            centre_length + self.module * CORNER_RADIUS * (position / radius + np.arctan(position / depth))
        )

    def fillet_curvature(self, corner: npt.ArrayLike) -> Array:
        """Compute the curvature of the fillet [1/m], positive, at positions [m] as in `fillet`."""
        s = np.asarray(corner, dtype=np.float64)
        h, r = self.corner_depth, self.reference_radius
        distance = np.hypot(s, h)
        turn = 1.0 / r + h / distance**2
        return np.asarray(turn / (distance / r + self.module * CORNER_RADIUS * turn))


def involute(angle: float) -> float:
    """Compute the involute function tan(angle) - angle [rad]."""
    return math.tan(angle) - angle


def least_shift(teeth: int, pressure_angle: float) -> float:
    """Compute the smallest profile shift coefficient, not below 0, at which the rack does not undercut the flanks."""
    sine = math.sin(pressure_angle)
    straight = DEDENDUM - CORNER_RADIUS * (1.0 - sine)  # depth of the straight flanks of the rack
    return max(0.0, straight - teeth * sine**2 / 2.0)


def shift_sum(teeth: int, module: float, pressure_angle: float, centre_distance: float) -> float:
    """Compute the sum of the profile shift coefficients [1] of a pair of gears without backlash.

    ISO 21771, equation for a_w. If the centre distance is smaller than the sum of the base radii, no flanks touch; the
    result is then that for a centre distance equal to the sum of the base radii.

    Parameters
    ----------
    teeth
        Sum of both numbers of teeth.
    module, centre_distance
        Lengths [m].
    pressure_angle
        Pressure angle at the reference circle [rad].
    """
    base_distance = module * teeth / 2.0 * math.cos(pressure_angle)
    working_angle = math.acos(min(1.0, base_distance / centre_distance))
    return teeth * (involute(working_angle) - involute(pressure_angle)) / (2.0 * math.tan(pressure_angle))


def gear_pair(
    teeth: tuple[int, int], module: float, pressure_angle: float, centre_distance: float, backlash: float
) -> tuple[InvoluteGear, InvoluteGear]:
    """Return a pinion without undercut and its mate, which fit a centre distance.

    The pinion has the profile shift that avoids undercut, and its mate the shift with which the pair has no backlash;
    then each tooth is thinned by half of the backlash. The tips have the clearance of the rack from the mating roots.

    Parameters
    ----------
    teeth
        Numbers of teeth of pinion and mate.
    module, centre_distance, backlash
        Lengths [m]; the backlash is circumferential, at the reference circles.
    pressure_angle
        Pressure angle at the reference circle [rad].

    Returns
    -------
    tuple of InvoluteGear
        Pinion and mate.
    """
    shift = SHIFT_STEP * math.ceil(least_shift(teeth[0], pressure_angle) / SHIFT_STEP)
    shifts = shift, shift_sum(sum(teeth), module, pressure_angle, centre_distance) - shift
    clear_distance = centre_distance - TIP_CLEARANCE * module
    gears_without_tips = [
        InvoluteGear(tooth_count, module, pressure_angle, gear_shift, 0.0, backlash / 2.0)
        for tooth_count, gear_shift in zip(teeth, shifts, strict=True)
    ]
    pinion, mate = (
        replace(gear_without_tips, tip_radius=clear_distance - mate.root_radius)
        for gear_without_tips, mate in zip(gears_without_tips, reversed(gears_without_tips), strict=True)
    )
    return pinion, mate


def span_measurement(gear: InvoluteGear) -> tuple[int, float]:
    """Compute the number k of teeth and the span W [m] over them, from flank to flank along the base tangent.

    W = m cos(alpha) ((k - 1/2) pi + z inv(alpha) + 2 x tan(alpha)) less the thinning times cos(alpha) (DIN 3960, 3.5).
    `gear` has the teeth of the wheel.
    """
    angle = gear.pressure_angle
    span_teeth = max(round(gear.teeth * angle / math.pi + 0.5 + 2.0 * gear.shift * math.tan(angle) / math.pi), 1)
    terms = (span_teeth - 0.5) * math.pi + gear.teeth * involute(angle) + 2.0 * gear.shift * math.tan(angle)
    return span_teeth, math.cos(angle) * (gear.module * terms - gear.thinning)


@dataclass(frozen=True)
class ContactPath:
    """Path of contact of a gear pair as nodes of a quadrature; arrays of shape (k,).

    Attributes
    ----------
    tangents
        Distances of the pitch point from the base circles of pinion and mate along the line of action [m].
    distance
        Distance of each node from the pitch point along the line of action [m], positive towards the mate.
    load_share
        Share of a flank in the force of the mesh [1]: 1 where one pair of teeth is in contact, 1/2 where two are.
    weight
        Weight of each node in an integral over the path [m].
    """

    tangents: tuple[float, float]
    distance: Array
    load_share: Array
    weight: Array

    @property
    def radius(self) -> Array:
        """Reduced radius of both flanks [m], shape (k,)."""
        pinion, mate = self.tangents[0] + self.distance, self.tangents[1] - self.distance
        return np.asarray(pinion * mate / (pinion + mate))


def contact_path(pair: tuple[InvoluteGear, InvoluteGear], centre_distance: float) -> ContactPath:
    """Return the path of contact of pinion and mate at a centre distance [m], with nodes for Gauss-Legendre quadrature.

    The path is limited by the tips and by the base circles. It is divided at the pitch point and where the number of
    tooth pairs in contact changes; each part has `PATH_NODES` nodes.
    """
    base_radii = [gear.base_radius for gear in pair]
    tangent = math.tan(math.acos(min(1.0, sum(base_radii) / centre_distance)))
    tangents = base_radii[0] * tangent, base_radii[1] * tangent
    recess, approach = (
        min(gear.base_radius * gear.last_roll - tangent, mate_tangent)
        for gear, tangent, mate_tangent in zip(pair, tangents, reversed(tangents), strict=True)
    )
    base_pitch = 2.0 * math.pi * base_radii[0] / pair[0].teeth
    division_points = (
        point for point in (-approach + base_pitch, recess - base_pitch, 0.0) if -approach < point < recess
    )
    edges = np.array(sorted({-approach, recess, *division_points}))
    nodes, weights = np.polynomial.legendre.leggauss(PATH_NODES)
    half_length, middle = 0.5 * np.diff(edges)[:, np.newaxis], 0.5 * (edges[1:] + edges[:-1])[:, np.newaxis]
    distance = np.ravel(middle + half_length * nodes)
    has_second_pair = (distance - base_pitch > -approach) | (distance + base_pitch < recess)
    return ContactPath(tangents, distance, np.where(has_second_pair, 0.5, 1.0), np.ravel(half_length * weights))


def _rotate(x: npt.ArrayLike, y: npt.ArrayLike, angle: Array) -> Array:
    """Rotate vectors (x, y), shape (n,) each, counter-clockwise by angles (n,) [rad]; return them as (n, 2)."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([cos * x - sin * y, sin * x + cos * y], -1)
