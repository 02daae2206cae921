"""The outline of an involute spur gear, as exact curves and as a polygon."""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.geometry.involute import InvoluteGear
from cycloid_mj.parts.curve import Arc, Curve, SmoothCurve, Spline, fit_splines, rotate_curve
from cycloid_mj.parts.polygon import arc, rotate_points

MIRROR = np.array([-1.0, 1.0])
"""Factors that mirror points at the axis y."""


@dataclass(frozen=True)
class SpurGearContour:
    """The outline of a spur gear, counter-clockwise, with the middle of a tooth space on +y."""

    gear: InvoluteGear

    def curves(self, splines: int) -> tuple[Curve, ...]:
        """Return the curves of all teeth of a spur gear: root arc, fillet and flank up, tip arc, flank, fillet down.

        Fillets and flanks are short, so each is one spline whatever the number of `splines`.
        """
        gear, pitch = self.gear, 2.0 * math.pi / self.gear.teeth
        fillet = SmoothCurve(gear.fillet, gear.fillet_length, gear.fillet_tangents, gear.fillet_curvature)
        flank = SmoothCurve(gear.flank, gear.flank_length, gear.flank_tangents, gear.flank_curvature)
        tooth_side = [
            *fit_splines(fillet, 0.0, gear.last_corner, 1),
            *fit_splines(flank, gear.first_roll, gear.last_roll, 1),
        ]
        upwards = [Spline(piece.knots, piece.controls * MIRROR) for piece in tooth_side]
        downwards = [
            rotate_curve(Spline(-piece.knots[::-1], piece.controls[::-1]), -pitch) for piece in reversed(tooth_side)
        ]
        root_half_angle, tip_half_angle, y_axis_angle = (
            gear.corner_offset / gear.reference_radius,
            gear.tip_half_angle,
            math.pi / 2.0,
        )
        tooth: tuple[Curve, ...] = (
            Arc((0.0, 0.0), gear.root_radius, y_axis_angle - root_half_angle, y_axis_angle + root_half_angle),
            *upwards,
            Arc(
                (0.0, 0.0),
                gear.tip_radius,
                y_axis_angle + pitch / 2.0 - tip_half_angle,
                y_axis_angle + pitch / 2.0 + tip_half_angle,
            ),
            *downwards,
        )
        return tuple(rotate_curve(curve, -number * pitch) for number in range(gear.teeth) for curve in tooth)

    def polygon(self, chord_error: float) -> Array:
        """Return the outline of a spur gear as a polygon of n points (n, 2) [m] on it, with a chord error [m]."""
        gear, pitch = self.gear, 2.0 * math.pi / self.gear.teeth
        chords = _count_chords(gear.last_corner, _fillet_acceleration(gear), chord_error)
        corners = np.linspace(0.0, gear.last_corner, chords + 1)
        chords = _count_chords(gear.last_roll - gear.first_roll, gear.base_radius * gear.last_roll, chord_error)
        rolls = np.linspace(gear.first_roll, gear.last_roll, chords + 1)
        tooth_side = np.concatenate([gear.fillet(corners), gear.flank(rolls)[1:]])
        root_half_angle, tip_half_angle, y_axis_angle = (
            gear.corner_offset / gear.reference_radius,
            gear.tip_half_angle,
            math.pi / 2.0,
        )
        root_arc = arc(gear.root_radius, y_axis_angle - root_half_angle, y_axis_angle + root_half_angle, chord_error)
        tip_arc = arc(
            gear.tip_radius,
            y_axis_angle + pitch / 2.0 - tip_half_angle,
            y_axis_angle + pitch / 2.0 + tip_half_angle,
            chord_error,
        )
        mirrored_side = rotate_points(tooth_side[::-1], pitch)
        tooth = np.concatenate([root_arc, (tooth_side * MIRROR)[1:], tip_arc[1:], mirrored_side[1:-1]])
        return np.concatenate([rotate_points(tooth, number * pitch) for number in range(gear.teeth)])


def _count_chords(span: float, acceleration: float, chord_error: float) -> int:
    """Return the number of equal steps of a curve's parameter over a span, so that the sagitta is the chord error [m].

    The sagitta of the chord of a step s is s^2/8 times the normal `acceleration`: the curvature times the squared
    derivative of the arc length by the parameter.
    """
    return max(2, math.ceil(span * math.sqrt(acceleration / (8.0 * chord_error))))


def _fillet_acceleration(gear: InvoluteGear) -> float:
    """Return the largest normal acceleration [1/m] of a fillet by corner position of the rack; see `_count_chords`."""
    corner = np.array([0.0, gear.last_corner])
    turning_rate = 1.0 / gear.reference_radius + gear.corner_depth / (corner**2 + gear.corner_depth**2)
    return float((turning_rate**2 / gear.fillet_curvature(corner)).max())
