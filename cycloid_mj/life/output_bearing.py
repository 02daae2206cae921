"""What the output's flange carries beside the torque: tilting moment, radial and axial load, by the hub's two bearings.

Covers and bearings are those of ``parts.export.casing``. Both bearings are rigid rings a distance apart on a rigid hub;
they carry what the discs put on the output as well, and the shaft whose bearing is in the hub. Their ratings are of a
catalogue (``design.stock``); the balls that give under a moment are estimated: 0.3 (D - d) thick, as many as go in at
an angle of 195 deg between the rings (Harris, Rolling Bearing Analysis, Conrad's assembly).
"""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.design.stock import StockBearing
from cycloid_mj.life import rolling
from cycloid_mj.life.duty import steady
from cycloid_mj.life.loading import FAR, Loading, loading
from cycloid_mj.life.rolling import magnitudes
from cycloid_mj.parts.export.casing import casing
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.statics.bearings import Planes

BALL_SHARE, FILLED = 0.3, math.radians(195.0)
"""Diameter of balls over D - d, and the angle between the rings that they fill."""

AXIAL_SHARE = 0.25
"""Axial load on a deep groove bearing of diameter series 8 over its static rating, at most (SKF, 2018)."""

EVEN, USUAL = 4.37, 5.0
"""Z Q/F of the ball that bears the most: without clearance (NSK E728g, 5.1), and usual (Stribeck)."""

APPROACH = 0.44
"""Of both rings at a ball in um, (Q^2/D)^(1/3) in N and mm (Palmgren; NSK E728g, 5)."""


@dataclass(frozen=True)
class BallRow:
    """The balls of a deep groove bearing: their number, diameter and pitch diameter [m]."""

    balls: int
    diameter: float
    pitch: float


@dataclass(frozen=True, eq=False)
class Hub:
    """The two bearings of the output.

    Attributes
    ----------
    bearing, row
        Of which there are two, and its balls.
    spacing
        Of their middles [m].
    lever
        From the outer one's middle to the flange's face [m].
    dynamic, static
        Load ratings of one [N].
    bears
        Radial load that one supports [N]: standing, and for the life of the design at the speed of its output, where
        it is multiplied by the service factor, as in a rating.
    own
        Largest force on each that discs and shaft put there at the nominal torque [N], the inner one first.
    """

    bearing: StockBearing
    row: BallRow
    spacing: float
    lever: float
    dynamic: float
    static: float
    bears: float
    own: tuple[float, float]

    @property
    def moment(self) -> float:
        """Tilting moment that both bear beside the nominal torque [N m]: force times spacing."""
        return self.spacing * max(self.bears - max(self.own), 0.0)

    @property
    def radial(self) -> float:
        """Radial load on the flange's face that both bear beside the nominal torque [N]."""
        inner, outer = (max(self.bears - own, 0.0) for own in self.own)
        return min(inner * self.spacing / self.lever, outer * self.spacing / (self.spacing + self.lever))

    @property
    def axial(self) -> float:
        """Axial load on the flange alone [N]: one bearing holds it."""
        return AXIAL_SHARE * self.static

    def tilting_stiffness(self, share: float = EVEN) -> float:
        """Compute the moment over the tilt that it makes [N m/rad], at half of what is borne; `share` is Z Q/F."""
        force = 0.5 * self.moment / self.spacing
        pressed = share * force / self.row.balls
        approach = 1e-6 * APPROACH * (pressed**2 / (1e3 * self.row.diameter)) ** (1.0 / 3.0)
        return force * self.spacing**2 / (2.0 * approach) if force else 0.0


def balls_of(bearing: StockBearing) -> BallRow:
    """Estimate the balls of a deep groove bearing from its sizes."""
    size, pitch = BALL_SHARE * (bearing.outside - bearing.bore), 0.5 * (bearing.outside + bearing.bore)
    return BallRow(int(FILLED / (2.0 * math.asin(size / pitch))) + 1, size, pitch)


@once
def hub(reducer: Reducer) -> Hub:
    """Rate the bearings of the output's hub, beside the nominal torque.

    Raises
    ------
    DesignError
        The casing has no room.
    RunError
        No static balance was found.
    """
    sizes, design = casing(reducer), reducer.design
    row = balls_of(sizes.hub)
    dynamic, static = sizes.hub.dynamic, sizes.hub.static
    inner, outer = (0.5 * sum(ends) for ends in sizes.bearings)
    speed = abs(design.drive.speed) / design.reduction
    lasts = rolling.load_for_life(dynamic, design.service.life, speed, design.bearing.reliability)
    lasts /= design.bearing.service_factor
    return Hub(
        bearing=sizes.hub,
        row=row,
        spacing=outer - inner,
        lever=sizes.ends[1] - outer,
        dynamic=dynamic,
        static=static,
        bears=min(lasts, static),
        own=_own(reducer),
    )


def held_by_hub(reducer: Reducer, one: Loading) -> tuple[Array, Array]:
    """Compute what each bearing of the hub holds [N], (m, 2), the inner one first: discs, and the shaft in the hub.

    Raises
    ------
    DesignError
        The casing has no room.
    """
    sizes, planes = casing(reducer), reducer.design.gear.disc_planes
    inner, outer = (0.5 * sum(ends) for ends in sizes.bearings)
    forces, places = one.on_output, [*planes]
    if sizes.far:
        cosine, sine = np.cos(one.crank), np.sin(one.crank)
        x, y = one.shaft[:, FAR].T  # what the bearing answers with, in the shaft's frame
        on_hub = -np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=1)
        forces, places = np.concatenate([forces, on_hub[:, np.newaxis]], axis=1), [*places, 0.5 * sum(sizes.far)]
    return Planes(forces, np.array(places)).held_at(inner, outer)


def _own(reducer: Reducer) -> tuple[float, float]:
    """Compute the largest forces on both bearings by what discs and shaft put there at the nominal torque [N]."""
    design = reducer.design
    at_rated = loading(reducer, steady(design.rated_torque, design.drive.speed).points[0])
    inner, outer = (float(magnitudes(force).max()) for force in held_by_hub(reducer, at_rated))
    return inner, outer


def tilting_moment(reducer: Reducer) -> float:
    """Compute the tilting moment on the flange that its bearings bear [N m]; errors as `hub`."""
    return hub(reducer).moment


def tilting_stiffness(reducer: Reducer) -> float:
    """Compute the tilting stiffness of the output's bearings [N m/arcmin]; errors as `hub`."""
    return hub(reducer).tilting_stiffness() * ARCMINUTE


def radial_load(reducer: Reducer) -> float:
    """Compute the radial load on the flange's face that its bearings bear [N]; errors as `hub`."""
    return hub(reducer).radial


def axial_load(reducer: Reducer) -> float:
    """Compute the axial load on the flange that its bearings bear [N]; errors as `hub`."""
    return hub(reducer).axial
