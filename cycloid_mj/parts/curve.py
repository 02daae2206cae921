"""Plane curves for CAD: circles, arcs, lines, and cubic splines that follow a flank within a tolerance."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

SPLINE_ERROR = 1e-8
"""Largest distance of a spline from its flank [m]: 1 % of a clearance of 1 um."""


@dataclass(frozen=True)
class SplineFit:
    """Settings of the fit of cubic splines to a flank, by doubling the spans until the error is met."""

    first_spans: int = 8  # spans of a spline in the first attempt
    max_spans: int = 4096  # largest number of spans of a flank
    checks: int = 8  # points of each span at which the error is measured
    grid: int = 8192  # points of the flank at which its curvature is differentiated
    min_density: float = 1e-3  # smallest density of knots relative to the largest, for straight segments


FIT = SplineFit()


@dataclass(frozen=True)
class SmoothCurve:
    """A smooth parametric curve, as vectorised functions.

    `points` (n, 2) [m], `arc_length` [m] (increasing), unit `tangents` (n, 2), and the signed `curvature` [1/m].
    """

    points: Callable[[Array], Array]
    arc_length: Callable[[Array], Array]
    tangents: Callable[[Array], Array]
    curvature: Callable[[Array], Array]


@dataclass(frozen=True)
class Circle:
    """A full circle [m]."""

    centre: tuple[float, float]
    radius: float


@dataclass(frozen=True)
class Arc:
    """An arc [m], counter-clockwise from the angle `start` to `end`, both from +x [rad]."""

    centre: tuple[float, float]
    radius: float
    start: float
    end: float


@dataclass(frozen=True)
class LineSegment:
    """A straight edge [m]."""

    start: tuple[float, float]
    end: tuple[float, float]


@dataclass(frozen=True)
class Spline:
    """A clamped cubic B-spline: `knots` (n + 4,) and `controls` (n, 2) [m]."""

    knots: Array
    controls: Array

    def points(self, count: int) -> Array:
        """Compute `count` points along it, including both ends, shape (count, 2) [m]."""
        from scipy.interpolate import BSpline

        parameter = np.linspace(self.knots[0], self.knots[-1], count)
        return np.asarray(BSpline(self.knots, self.controls, 3)(parameter), dtype=np.float64)


Curve = Circle | Arc | LineSegment | Spline


def fit_splines(flank: SmoothCurve, low: float, high: float, pieces: int) -> tuple[Spline, ...]:
    """Fit `pieces` consecutive cubic splines to a flank from parameter `low` to `high`, within ``SPLINE_ERROR`` [m].

    The splines have equal numbers of spans, and join with a common tangent. `low` and `high` are in the unit of the
    parameter of `flank`.

    Raises
    ------
    DesignError
        The splines need more than `FIT.max_spans` spans.
    """
    spans = FIT.first_spans
    while pieces * spans <= FIT.max_spans:
        knots = _spline_knots(flank, low, high, pieces * spans)
        segments = [knots[i * spans : (i + 1) * spans + 1] for i in range(pieces)]
        splines = [_interpolate(flank, segment) for segment in segments]
        if max(_deviation(flank, *fit) for fit in zip(splines, segments, strict=True)) <= SPLINE_ERROR:
            return tuple(Spline(fit.t, fit.c) for fit in splines)
        spans *= 2
    raise DesignError(
        f"the curvature of a tooth flank changes too fast for a spline: even with {FIT.max_spans} spans, the largest "
        f"number allowed, it deviates by more than {SPLINE_ERROR:g} m. Reduce ring.pin_radius_mm or "
        "gear.eccentricity_mm"
    )


def _spline_knots(flank: SmoothCurve, low: float, high: float, spans: int) -> Array:
    """Compute the flank parameters of spline knots that spread the interpolation error evenly, shape (`spans` + 1,).

    The first is `low`, the last `high`, in the unit of the flank's parameter.
    """
    # The error of a span of length h is proportional to h^4 r''''. In the moving frame of the curve the fourth
    # derivative by arc length is (-3 kappa kappa', kappa'' - kappa^3).
    parameters = np.linspace(low, high, FIT.grid)
    arc_length, curvature = flank.arc_length(parameters), flank.curvature(parameters)
    slope = np.gradient(curvature, arc_length)
    fourth_derivative = np.hypot(3.0 * curvature * slope, np.gradient(slope, arc_length) - curvature**3)
    density = np.maximum(fourth_derivative, FIT.min_density * fourth_derivative.max()) ** 0.25
    cumulative_density = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2.0 * np.diff(arc_length))])
    return np.interp(np.linspace(0.0, cumulative_density[-1], spans + 1), cumulative_density, parameters)


def _interpolate(flank: SmoothCurve, nodes: Array) -> "BSpline":
    """Interpolate the flank at nodes by a clamped cubic spline."""
    from scipy.interpolate import make_interp_spline

    end_tangents: Any = tuple([(1, tangent)] for tangent in flank.tangents(nodes[[0, -1]]))
    return make_interp_spline(flank.arc_length(nodes), flank.points(nodes), k=3, bc_type=end_tangents)


def _deviation(flank: SmoothCurve, spline: "BSpline", nodes: Array) -> float:
    """Compute the largest distance of a spline from its flank, normal to the tangent [m]."""
    parameters = np.interp(np.arange(FIT.checks * (len(nodes) - 1)) / FIT.checks, np.arange(len(nodes)), nodes)
    deviations, tangents = spline(flank.arc_length(parameters)) - flank.points(parameters), flank.tangents(parameters)
    return float(np.abs(deviations[:, 0] * tangents[:, 1] - deviations[:, 1] * tangents[:, 0]).max())


def rotate_curve(curve: Curve, angle: float) -> Curve:
    """Rotate a curve clockwise about the origin by an angle [rad]."""
    cosine, sine = np.cos(angle), np.sin(angle)
    rotation = np.array([[cosine, -sine], [sine, cosine]])

    def rotate_point(point: tuple[float, float]) -> tuple[float, float]:
        x, y = np.array(point) @ rotation
        return float(x), float(y)

    match curve:
        case Circle():
            return Circle(rotate_point(curve.centre), curve.radius)
        case Arc():
            return Arc(rotate_point(curve.centre), curve.radius, curve.start - angle, curve.end - angle)
        case LineSegment():
            return LineSegment(rotate_point(curve.start), rotate_point(curve.end))
        case Spline():
            return Spline(curve.knots, curve.controls @ rotation)
