"""The gear's profile with its clearance and its modification, and where flanks end that are turned.

Flanks turned towards the middle of their lobes: the gear is what two copies of its profile, turned by +- the angle,
have in common. Each flank keeps its shape and ends at corners in the middle of tip and valley, beyond which its own
copy is cut away by the other. Equidistant and pin-circle modification need no geometry of their own: they are another
offset and another pin-circle radius of the profile. Symbols as in ``profile``; angles clockwise.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import Design
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.profile import CycloidGear, SmoothArc


@dataclass(frozen=True)
class FlankEnds:
    """End points of a rotated flank.

    Attributes
    ----------
    tip
        Parameter t of the tip minus that of the end at the tip [rad], not negative.
    tip_radius
        Distance of the end at the tip from the gear's centre [m].
    valley
        Parameter t of the valley minus that of the end at the valley [rad], not negative.
    valley_radius
        Distance of the end at the valley from the gear's centre [m].
    """

    tip: float
    tip_radius: float
    valley: float
    valley_radius: float


def tooth_profile(design: Design) -> CycloidGear:
    """Return the ideal mesh of a design, without clearance and modification: its ring, and its motion."""
    ring = design.ring
    return CycloidGear(ring.teeth, design.gear.eccentricity, ring.pin_circle_radius, ring.pin_radius)


def gear_profile(design: Design) -> CycloidGear:
    """Return the mesh whose profile the gear has, without clearance: its pin circle is that of the modification."""
    ring = design.ring
    generating = ring.pin_circle_radius + design.modification.pin_circle
    return CycloidGear(ring.teeth, design.gear.eccentricity, generating, ring.pin_radius)


def profile_offset(design: Design) -> float:
    """Compute the distance of the gear's profile from its trochoid [m].

    It is the sum of pin radius, clearance and equidistant modification.
    """
    clearance = design.clearance.pin_gear if design.ring.kind == "pin" else design.clearance.tooth
    return design.ring.pin_radius + clearance + design.modification.equidistant


def flank_ends(gear: CycloidGear, offset: float, rotation: float) -> FlankEnds:
    """Compute where the flanks end that are rotated by `rotation` >= 0 [rad] towards the middle of their lobe.

    The profile is at `offset` [m] from its trochoid. A rotated flank ends where it crosses the centre lines of tip and
    valley. For each of the two ends, first at the tip and then at the valley, the result has two values: the parameter
    t [rad] of the tip or valley minus that of the end, which is not negative, and the distance of the end from the
    gear's centre [m].

    Raises
    ------
    DesignError
        The rotation leaves nothing of the lobes.

    Notes
    -----
    An end is the point of the flank whose clockwise polar angle before the rotation is that of the centre line minus
    `rotation`.
    """
    half_pitch = np.pi / gear.lobes
    if rotation >= half_pitch / 2:
        limit = np.degrees(half_pitch / 2) * 3600
        raise DesignError(
            f"modification.rotation_arcsec = {np.degrees(rotation) * 3600:.6g} is too large, because at {limit:.6g} "
            f"arcsec the lobes vanish. Reduce it to less than {limit:.6g}"
        )
    centre_line_t = np.array([half_pitch, 0.0])
    t = profile.solve_monotone(
        lambda t: _Polar(gear, t, offset).angle,
        lambda t: _Polar(gear, t, offset).rate,
        centre_line_t - rotation,
        centre_line_t - half_pitch,
        centre_line_t,
    )
    radius, t_differences = _Polar(gear, t, offset).radius, centre_line_t - t
    return FlankEnds(float(t_differences[0]), float(radius[0]), float(t_differences[1]), float(radius[1]))


def sample_rotated_flanks(gear: CycloidGear, chord_error: float, offset: float, rotation: float) -> Array:
    """Compute the outline of a gear with rotated flanks as n points (n, 2) [m], clockwise from the valley on +y.

    Its chords deviate from the flanks by at most `chord_error` [m]. All lobes have the same points, which include the
    corners. The flanks are at the distance `offset` [m] outside of the trochoid. Both flanks of a lobe are
    rotated about the gear's centre by `rotation` [rad] towards the middle of the lobe.

    Raises
    ------
    DesignError
        The profile is undercut, the rotation leaves nothing of the lobes, or `chord_error` is below 1e-12 m.
    """
    profile.require_no_undercut(gear, offset)
    flank_end, half_pitch = flank_ends(gear, offset, rotation), np.pi / gear.lobes
    flank = SmoothArc(
        points=lambda t: profile.outline(gear, t, offset),
        normal_angle=lambda t: profile.normal_angle(gear, t),
        turning_rate=lambda t: profile.turning_rate(gear, t),
        arc_rate=lambda t: profile.arc_rate(gear, t, offset),
    )
    start_t, end_t = -flank_end.valley, half_pitch - flank_end.tip
    inflection = float(np.clip(profile.inflection_phase(gear) / gear.lobes, start_t, end_t))
    concave_t = profile.sagitta_nodes(flank, start_t, inflection, chord_error)
    t = np.concatenate([concave_t[:-1], profile.sagitta_nodes(flank, inflection, end_t, chord_error)])
    polar_points = _Polar(gear, t, offset)
    radius, angle = polar_points.radius, polar_points.angle + rotation
    angle[0], angle[-1] = 0.0, half_pitch
    lobe_angle = np.concatenate([angle, 2 * half_pitch - angle[-2:0:-1]])
    angles = 2 * half_pitch * np.arange(gear.lobes)[:, np.newaxis] + lobe_angle
    radii = np.tile(np.concatenate([radius, radius[-2:0:-1]]), gear.lobes)
    return np.asarray(radii[:, np.newaxis] * profile.unit(angles.ravel()))


class _Polar:
    """Points of an outline at parameters t [rad], shape (n,), in polar coordinates about the gear's centre."""

    def __init__(self, gear: CycloidGear, t: Array, offset: float) -> None:
        self._gear = gear
        self._t = t
        self._offset = offset

    @cached_property
    def _points(self) -> Array:
        return profile.outline(self._gear, self._t, self._offset)

    @property
    def radius(self) -> Array:
        """Distance from the centre [m]."""
        return np.asarray(np.linalg.norm(self._points, axis=1))

    @property
    def angle(self) -> Array:
        """Clockwise angle from +y [rad], within half a turn of t."""
        x, y = self._points.T
        return np.asarray(self._t + np.mod(np.arctan2(x, y) - self._t + np.pi, 2 * np.pi) - np.pi)

    @property
    def rate(self) -> Array:
        """Derivative of `angle` by t [1]."""
        normal_angle = profile.normal_angle(self._gear, self._t)
        across = np.cos(normal_angle - np.arctan2(self._points[:, 0], self._points[:, 1]))
        return np.asarray(profile.arc_rate(self._gear, self._t, self._offset) * across / self.radius)
