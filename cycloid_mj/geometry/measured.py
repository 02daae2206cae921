"""Measured parts as deviations: waves of the disc's profile, displacements and radii of ring pins.

A profile is measured as deviations at angles, or as points that are aligned with the drawing first. Its deviation is
described by Fourier coefficients over the parameter t of the gear's trochoid, by which the mechanism finds its
contacts.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from cycloid_mj.base.array import Array, rotate
from cycloid_mj.design import Design, describe_plastic_limits
from cycloid_mj.design.measured import Measured
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.modification import gear_profile, profile_offset
from cycloid_mj.geometry.profile import CycloidGear


@dataclass(frozen=True)
class ProfileFitSettings:
    """Settings of the fit of a measured profile."""

    orders_per_lobe: int = 8  # highest order over the number of lobes: a lobe's own shape has few undulations
    orders: int = 600  # highest order of any profile: the fit's cost grows with its square
    tail: float = 1e-9  # rms of the highest orders that are left out [m]: a tenth of what a machine resolves
    samples_per_lobe: int = 400  # samples of the drawing: by linear interpolation, angles are exact to 1e-6 of a lobe
    steps: int = 30  # Gauss-Newton steps of the alignment; it needs about 5
    foot_point_steps: int = 4  # Newton steps to a foot point: quadratic convergence from a 400th of a lobe
    step_size: float = 1e-12  # change at which the alignment ends [m]


FIT = ProfileFitSettings()

ROUNDING = 1e-9
"""Relative rounding error of a gap between equally spaced points."""


@dataclass(frozen=True)
class Alignment:
    """Displacement of measured points from the drawing that is removed before their deviations are computed.

    Attributes
    ----------
    x, y
        Position of the profile's centre in the frame of the measurement [m].
    rotation
        Clockwise rotation of the profile there [rad].
    """

    x: float
    y: float
    rotation: float


@dataclass(frozen=True)
class MeasuredProfile:
    """A measured profile of a disc.

    Attributes
    ----------
    mean
        Mean deviation outwards [m].
    waves
        Inward offset by order, as ``Deviations.waves``, shape (orders, 2) [m].
    points
        Number of points.
    left_out
        Rms of the deviation that the waves do not describe [m].
    alignment
        Alignment of points; None for deviations at angles.
    """

    mean: float
    waves: Array
    points: int
    left_out: float
    alignment: Alignment | None

    @property
    def words(self) -> str:
        """Return a sentence on a measured profile: number of points, mean, highest order of waves, rms of the rest."""
        waves = f"waves up to order {len(self.waves)}" if len(self.waves) else "no waves"
        mean, rest_rms = round(1e6 * self.mean, 4), round(1e6 * self.left_out, 4)
        summary = f"{self.points} points, mean {mean:g} um, {waves}, {rest_rms:g} um rms left out"
        if self.alignment is None:
            return summary
        alignment, rotation = self.alignment, math.degrees(self.alignment.rotation) * 3600.0
        return f"{summary}; aligned by {1e6 * alignment.x:.4g} um, {1e6 * alignment.y:.4g} um and {rotation:.4g} arcsec"


@dataclass(frozen=True)
class MeasuredDeviations:
    """The part of ``Deviations`` that is measured [m]; 0, and no waves, for parts that are not.

    Attributes are `pin_displacement` (N, 2), `pin_radius` (N,), `disc_radius` of all discs, and `waves` (orders, 2).
    """

    pin_displacement: Array
    pin_radius: Array
    disc_radius: float
    waves: Array


def measurement_notes(design: Design) -> tuple[str, ...]:
    """Describe the measured gear and pins of a design, one sentence for each; empty if nothing is measured.

    Raises
    ------
    DesignError
        The profile of the drawing is undercut.
    """
    measured_outline, measured_files = measured_profile(design), design.measured
    pins_text = f"{len(measured_files.pins_radial)} pins" if measured_files.pins_radial else ""
    description_by_part = {"gear": measured_outline.words if measured_outline else "", "pins": pins_text}
    return tuple(
        f"measured {part} ({getattr(measured_files, part) or 'values of the design file'}): {description}"
        for part, description in description_by_part.items()
        if description
    )


def part_notes(design: Design) -> tuple[str, ...]:
    """Describe the measurements of a design's parts and the limits of their materials, a sentence each."""
    return (*measurement_notes(design), *describe_plastic_limits(design))


def measured_deviations(design: Design) -> MeasuredDeviations:
    """Compute the deviations of a design's parts that are measured; 0 for others.

    Raises
    ------
    DesignError
        The gear is measured, but the profile of the drawing is undercut.
    """
    measured_files, ring_teeth = design.measured, design.ring.teeth
    position, radius = np.zeros((ring_teeth, 2)), np.zeros(ring_teeth)
    if measured_files.pins_radial:
        angles = 2.0 * np.pi * np.arange(ring_teeth) / ring_teeth
        position += np.array(measured_files.pins_radial)[:, np.newaxis] * profile.unit(angles)
        position += np.array(measured_files.pins_tangential)[:, np.newaxis] * profile.unit(angles + 0.5 * np.pi)
        radius += measured_files.pins_radius
    gear = measured_profile(design)
    return MeasuredDeviations(position, radius, gear.mean if gear else 0.0, gear.waves if gear else np.zeros((0, 2)))


def measured_profile(design: Design) -> MeasuredProfile | None:
    """Fit mean and harmonics (waves) per turn to the deviation of a design's measured disc from its nominal profile.

    Return None if the design has no measured profile.

    Raises
    ------
    DesignError
        The nominal profile is undercut.
    """
    measured_files = design.measured
    if not (measured_files.gear_angle or measured_files.gear_x):
        return None
    return _fit_profile(measured_files, gear_profile(design), profile_offset(design))


@lru_cache(maxsize=8)
def _fit_profile(measured_files: Measured, gear: CycloidGear, offset: float) -> MeasuredProfile:
    """Fit mean and harmonics (waves) per turn to the deviation of a measured profile from its nominal shape.

    The nominal shape is the parallel of the trochoid of `gear` at an `offset` [m]. `measured_files` are the points or
    deviations that were read from the files.

    Raises
    ------
    DesignError
        That parallel is undercut.
    """
    profile.require_no_undercut(gear, offset)
    if measured_files.gear_x:
        points = np.stack([measured_files.gear_x, measured_files.gear_y], axis=1)
        t, deviation, alignment = align(gear, offset, points)
    else:
        angles = np.array(measured_files.gear_angle)
        t, deviation, alignment = parameters_at(gear, offset, angles), np.array(measured_files.gear_deviation), None
    return fit_waves(t, deviation, min(FIT.orders, FIT.orders_per_lobe * gear.lobes), alignment)


def parameters_at(gear: CycloidGear, offset: float, angles: Array) -> Array:
    """Compute the trochoid parameters t [rad] of an outline at n polar angles [rad], clockwise from +y, (n,).

    The outline is the parallel of the trochoid at the `offset` [m]. Its polar angle is a monotone function of t, which
    is inverted by linear interpolation. `gear` is the profile of the disc.
    """
    t = np.linspace(0.0, 2.0 * np.pi, FIT.samples_per_lobe * gear.lobes + 1)
    x, y = profile.outline(gear, t, offset).T
    polar = np.unwrap(np.arctan2(x, y))
    return np.interp(np.mod(angles, 2.0 * np.pi), polar - polar[0], t)


def align(gear: CycloidGear, offset: float, points: Array) -> tuple[Array, Array, Alignment]:
    """Align n measured points (n, 2) [m] with an outline by least squares, in position and rotation.

    The outline is the parallel of the trochoid at the `offset` [m]. The deviations from their mean are minimised by
    Gauss-Newton steps, with new foot points in each. The rotation is at most half a pitch, as lobes are identical.
    `gear` is the profile of the disc.

    Returns
    -------
    tuple
        Parameters t (n,) [rad] of the foot points, deviations (n,) [m] along the outward normals, and the alignment.
    """
    from scipy.linalg import lstsq
    from scipy.spatial import cKDTree

    t = np.linspace(0.0, 2.0 * np.pi, FIT.samples_per_lobe * gear.lobes, endpoint=False)
    outline_tree = cKDTree(profile.outline(gear, t, offset))
    centre, rotation = _initial_alignment(gear, points)
    for _ in range(FIT.steps):
        local_points = rotate(points - centre, rotation)
        foot_t = _foot_points(gear, offset, local_points, t[outline_tree.query(local_points)[1]])
        normals, foot_points = profile.normals(gear, foot_t), profile.outline(gear, foot_t, offset)
        deviation = np.sum((local_points - foot_points) * normals, axis=1)
        # a counter-clockwise rotation of the points moves them by (-y, x)
        rotation_arm = np.sum(np.stack([-local_points[:, 1], local_points[:, 0]], axis=1) * normals, axis=1)
        radius_scale = gear.pin_circle_radius
        jacobian = np.column_stack([-rotate(normals, -rotation), rotation_arm / radius_scale, np.ones(len(points))])
        correction = lstsq(jacobian, -deviation)[0]
        centre, rotation = centre + correction[:2], rotation + correction[2] / radius_scale
        if np.abs(correction[:3]).max() < FIT.step_size:
            break
    return foot_t, deviation, Alignment(float(centre[0]), float(centre[1]), float(rotation))


def fit_waves(t: Array, deviation: Array, max_order: int, alignment: Alignment | None) -> MeasuredProfile:
    """Fit mean and harmonics (waves) to n outward deviations [m] at parameters t [rad] of an outline, (n,).

    The fit is by weighted least squares. The parameter t of the trochoid increases by 2 pi per turn. The weight of a
    point is the part of the range of t that is nearest to it. The highest order is `max_order`, or less if the points
    are too far apart: it must be below pi over the largest gap (Gröchenig 1992, "Reconstruction algorithms in irregular
    sampling"). The highest orders are left out as long as their rms is at most `FIT.tail`. `alignment` is stored in the
    result.
    """
    from scipy.linalg import lstsq

    sort_order = np.argsort(t, kind="stable")
    gaps = np.diff(t[sort_order], append=t[sort_order[0]] + 2.0 * np.pi)
    weights = np.empty(t.size)
    weights[sort_order] = (gaps + np.roll(gaps, 1)) / (4.0 * np.pi)
    orders = np.arange(1, min(max_order, math.ceil(np.pi / gaps.max() * (1.0 - ROUNDING)) - 1) + 1)
    phases, sqrt_weights = np.outer(t, orders), np.sqrt(weights)
    basis = np.concatenate([np.ones((t.size, 1)), np.cos(phases), np.sin(phases)], axis=1)
    coefficients = lstsq(sqrt_weights[:, np.newaxis] * basis, sqrt_weights * deviation, lapack_driver="gelsy")[0]
    cosines, sines = np.split(coefficients[1:], 2)
    tail_power = np.cumsum((cosines**2 + sines**2)[::-1] / 2.0)[::-1]
    orders_in_use = int(np.sum(tail_power > FIT.tail**2))
    is_used = np.concatenate([[True], orders <= orders_in_use, orders <= orders_in_use])
    rest_rms = math.sqrt(weights @ (deviation - basis[:, is_used] @ coefficients[is_used]) ** 2)
    waves = -np.stack([cosines, sines], axis=1)[:orders_in_use]
    return MeasuredProfile(float(coefficients[0]), waves, t.size, rest_rms, alignment)


def _initial_alignment(gear: CycloidGear, points: Array) -> tuple[Array, float]:
    """Estimate centre and rotation of n measured points (n, 2) [m] by a circle fit (Kasa) and the lobes' phase.

    `gear` is the profile of the disc.

    Returns
    -------
    tuple
        Centre (2,) [m], and clockwise rotation [rad].
    """
    from scipy.linalg import lstsq

    x, y = points.T
    # x^2 + y^2 = 2 a x + 2 b y + c (Kåsa 1976)
    centre = lstsq(np.column_stack([2.0 * x, 2.0 * y, np.ones(x.size)]), x**2 + y**2)[0][:2]
    x, y = (points - centre).T
    radius, polar = np.hypot(x, y), np.arctan2(x, y)
    # the valleys, of the smallest radius, are at whole pitches
    lobe_harmonic = np.sum((radius.mean() - radius) * np.exp(1j * gear.lobes * polar))
    return centre, float(np.angle(lobe_harmonic)) / gear.lobes


def _foot_points(gear: CycloidGear, offset: float, points: Array, t: Array) -> Array:
    """Compute the parameters [rad] of the foot points of n `points` (n, 2) [m] on an outline, shape (n,).

    The outline has an `offset` [m] from the trochoid. Newton's method starts from the parameters `t` (n,) [rad], which
    must be close. `gear` is the profile of the disc.
    """
    for _ in range(FIT.foot_point_steps):
        offset_vectors = points - profile.outline(gear, t, offset)
        normals, rate = profile.normals(gear, t), profile.arc_rate(gear, t, offset)
        tangents = np.stack([normals[:, 1], -normals[:, 0]], axis=1)
        straightness = 1.0 + profile.curvature(gear, t, offset) * np.sum(offset_vectors * normals, axis=1)
        t = t + np.sum(offset_vectors * tangents, axis=1) / (rate * straightness)
    return t
