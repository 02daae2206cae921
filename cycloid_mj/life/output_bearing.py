"""Load limits of the output flange in addition to the torque: tilting moment, radial and axial load.

Covers and bearings are those of ``parts.export.casing``. Both bearings are rigid rings on a rigid hub, with the
distance of their load centres: of their middles, or for angular contact bearings back to back of the points at which
the lines of contact meet the axis. They also carry the forces of the discs on the output, and of the shaft where its
bearing is in the hub. Load ratings are those of ``design.stock``. Balls, for the tilting stiffness, are estimated:
0.3 (D - d) in diameter, as many as fill 195 deg between the rings (Conrad assembly; Harris, Rolling Bearing Analysis),
or 270 deg of angular contact bearings (assumed).
"""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.design.stock import ANGULAR_CONTACT, DEEP_GROOVE_FILLED_ANGLE, StockBearing
from cycloid_mj.life import rolling
from cycloid_mj.life.duty import constant_duty
from cycloid_mj.life.loading import FAR, Loading, solve_loading
from cycloid_mj.life.rolling import magnitudes
from cycloid_mj.parts.export.casing import casing
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.statics.bearings import Planes


@dataclass(frozen=True)
class BallBearingData:
    """Data of ball bearings.

    Attributes
    ----------
    ball_share
        Diameter of balls over D - d (Harris).
    max_axial_share
        Largest axial load on a deep groove bearing of diameter series 8 over its static rating (SKF, 2018).
    radial_factor, axial_factor, static_axial_factor
        Equivalent loads P = X F_r + Y F_a and, of an axial load alone, P_0 = Y_0 F_a at a contact angle of 25 deg (ISO
        281, Table 3; ISO 76, Table 2).
    preload_share
        Preload of a pair over the dynamic rating: the least load of ball bearings (SKF, Rolling bearings, 2018).
    no_clearance, usual_clearance
        Z Q/F of the most loaded ball: without clearance (NSK E728g, 5.1), and with the usual clearance (Stribeck).
    approach
        Approach of both rings at a ball in um over (Q^2/D)^(1/3) in N and mm (Palmgren; NSK E728g, 5).
    """

    ball_share: float = 0.3
    max_axial_share: float = 0.25
    radial_factor: float = 0.41
    axial_factor: float = 0.87
    static_axial_factor: float = 0.38
    preload_share: float = 0.01
    no_clearance: float = 4.37
    usual_clearance: float = 5.0
    approach: float = 0.44


BALL_BEARINGS = BallBearingData()


@dataclass(frozen=True)
class BallRow:
    """The balls of a bearing: their number, diameter and pitch diameter [m]."""

    balls: int
    diameter: float
    pitch: float


@dataclass(frozen=True, eq=False)
class OutputBearings:
    """The two bearings of the output.

    Attributes
    ----------
    bearing, row
        The bearing of which there are two, and its balls.
    spacing
        Distance of their load centres [m].
    lever
        Distance from the load centre of the outer bearing to the flange's face [m]; negative if it is beyond the face.
    dynamic, static
        Load ratings of one bearing [N].
    capacity
        Radial load limit of one bearing [N]: standing, and for the life of the design at the speed of its output, where
        the load is multiplied by the service factor, as in a rating.
    own
        Largest force of discs and shaft on each at the nominal torque [N], the inner one first.
    """

    bearing: StockBearing
    row: BallRow
    spacing: float
    lever: float
    dynamic: float
    static: float
    capacity: float
    own: tuple[float, float]

    @property
    def moment(self) -> float:
        """Tilting moment limit in addition to the nominal torque [N m]: force times spacing."""
        return self.spacing * max(self.capacity - max(self.own), 0.0)

    @property
    def radial(self) -> float:
        """Limit of a radial load on the flange's face in addition to the nominal torque [N]."""
        inner, outer = (max(self.capacity - own, 0.0) for own in self.own)
        return min(inner * self.spacing / abs(self.lever), outer * self.spacing / (self.spacing + self.lever))

    @property
    def axial(self) -> float:
        """Limit of an axial load alone [N], which one bearing carries."""
        if not self.bearing.contact_angle:
            return BALL_BEARINGS.max_axial_share * self.static
        return min(self.capacity / BALL_BEARINGS.axial_factor, self.static / BALL_BEARINGS.static_axial_factor)

    def tilting_stiffness(self, ball_load_factor: float = BALL_BEARINGS.no_clearance) -> float:
        """Compute the tilting stiffness [N m/rad] of both bearings at half of the moment limit.

        The deflection of a ball follows from its force by Palmgren's formula. The most loaded of the Z balls of a
        bearing has the force Q; `ball_load_factor` is Z Q/F, with the force F on the bearing. Q and F are in the
        direction of contact.
        """
        bearing_force, cosine = 0.5 * self.moment / self.spacing, math.cos(self.bearing.contact_angle)
        ball_force = ball_load_factor * bearing_force / (self.row.balls * cosine)
        approach = 1e-6 * BALL_BEARINGS.approach * (ball_force**2 / (1e3 * self.row.diameter)) ** (1.0 / 3.0) / cosine
        return bearing_force * self.spacing**2 / (2.0 * approach) if bearing_force else 0.0


def equivalent_load(bearing: StockBearing, radial_force: Array) -> Array:
    """Compute the equivalent load of radial forces and of the preload, if the bearing has one [N]."""
    if not bearing.contact_angle:
        return radial_force
    preload = BALL_BEARINGS.preload_share * bearing.dynamic
    with_preload = BALL_BEARINGS.radial_factor * radial_force + BALL_BEARINGS.axial_factor * preload
    return np.maximum(radial_force, with_preload)


def balls_of(bearing: StockBearing) -> BallRow:
    """Estimate the balls of a bearing from its dimensions."""
    size, pitch = BALL_BEARINGS.ball_share * (bearing.outside - bearing.bore), 0.5 * (bearing.outside + bearing.bore)
    filled_angle = ANGULAR_CONTACT.filled_angle if bearing.contact_angle else DEEP_GROOVE_FILLED_ANGLE
    return BallRow(int(filled_angle / (2.0 * math.asin(size / pitch))) + 1, size, pitch)


@once
def output_bearings(reducer: Reducer) -> OutputBearings:
    """Compute dimensions, load ratings and load limits of the two bearings of the output's hub.

    The radial load limit of each bearing is that for the life of the design, at most its static rating. The forces at
    the nominal torque leave only a part of it for other loads.

    Raises
    ------
    DesignError
        The covers do not fit.
    RunError
        No static equilibrium exists.
    """
    sizes, design = casing(reducer), reducer.design
    row = balls_of(sizes.hub)
    dynamic, static = sizes.hub.dynamic, sizes.hub.static
    inner, outer = sizes.load_centres
    speed = abs(design.drive.speed) / design.reduction
    lasting_force = rolling.load_for_life(dynamic, design.service.life, speed, design.bearing.reliability)
    lasting_force /= design.bearing.service_factor
    return OutputBearings(
        bearing=sizes.hub,
        row=row,
        spacing=outer - inner,
        lever=sizes.ends[1] - outer,
        dynamic=dynamic,
        static=static,
        capacity=min(lasting_force, static),
        own=_own_forces(reducer),
    )


def output_bearing_forces(reducer: Reducer, loading: Loading) -> tuple[Array, Array]:
    """Compute the radial forces on both bearings of the output's hub at the m crank angles of a loading.

    They balance the forces of the discs on the output, and that of the shaft if its far bearing is in the hub.

    Returns
    -------
    tuple of Array
        Forces on the inner and on the outer bearing [N], shape (m, 2) each.

    Raises
    ------
    DesignError
        The covers do not fit.
    """
    sizes, planes = casing(reducer), list(reducer.design.gear.disc_planes)
    inner, outer = sizes.load_centres
    forces = loading.on_output
    if sizes.far:
        cosine, sine = np.cos(loading.crank), np.sin(loading.crank)
        x, y = loading.shaft[:, FAR].T  # the reaction of the bearing, in the shaft's frame
        hub_force = -np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=1)
        forces = np.concatenate([forces, hub_force[:, np.newaxis]], axis=1)
        planes.append(0.5 * sum(sizes.far))
    return Planes(forces, np.array(planes)).reactions_at(inner, outer)


def _own_forces(reducer: Reducer) -> tuple[float, float]:
    """Compute the largest forces on the inner and on the outer output bearing [N] at the nominal torque.

    They are caused by discs and shaft.
    """
    design = reducer.design
    point = constant_duty(design.rated_torque, design.drive.speed).points[0]
    at_rated = solve_loading(reducer, point, with_wind_up=False)
    inner, outer = (float(magnitudes(force).max()) for force in output_bearing_forces(reducer, at_rated))
    return inner, outer


def tilting_moment(reducer: Reducer) -> float:
    """Compute the limit of the tilting moment on the flange [N m]; errors as `output_bearings`."""
    return output_bearings(reducer).moment


def tilting_stiffness(reducer: Reducer) -> float:
    """Compute the tilting stiffness of the output's bearings [N m/arcmin]; errors as `output_bearings`."""
    return output_bearings(reducer).tilting_stiffness() * ARCMINUTE


def radial_load(reducer: Reducer) -> float:
    """Compute the limit of the radial load on the flange's face [N]; errors as `output_bearings`."""
    return output_bearings(reducer).radial


def axial_load(reducer: Reducer) -> float:
    """Compute the limit of the axial load on the flange [N]; errors as `output_bearings`."""
    return output_bearings(reducer).axial
