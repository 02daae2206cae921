"""Pairs of ball or tapered roller bearings of an output: load limits, and stiffness by their balls or rollers.

Two bearings are rigid rings on a rigid hub or flange, with the distance of their load centres: of their middles, or for
bearings with a contact angle back to back of the points at which the lines of contact meet the axis. Balls, for the
tilting stiffness, are estimated: 0.3 (D - d) in diameter, as many as fill 195 deg between the rings (Conrad assembly;
Harris, Rolling Bearing Analysis), or 270 deg of angular contact bearings (assumed).
"""

import math
from dataclasses import dataclass

from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.design.stock import ANGULAR_CONTACT, DEEP_GROOVE_FILLED_ANGLE, StockBearing
from cycloid_mj.life import rolling
from cycloid_mj.life.output_loads import (
    BALL_BEARINGS,
    CROSSED_ROLLERS,
    TAPERED_ROLLERS,
    thrust_factors,
    thrust_ratio,
)
from cycloid_mj.reducer import Reducer

FLANGE_SOURCE = "gaping of the output flange, n F d/4"
"""Source of a limit of the tilting moment by the screws of the output flange."""


@dataclass(frozen=True)
class BallRow:
    """The balls of a bearing: their number, diameter and pitch diameter [m]."""

    count: int
    diameter: float
    pitch: float

    @property
    def no_clearance(self) -> float:
        """Load factor Z Q/F of the most loaded ball without clearance."""
        return BALL_BEARINGS.no_clearance

    def approach(self, force: float) -> float:
        """Compute the approach of both rings at a ball under a `force` [N] by Palmgren's formula [m]."""
        return 1e-6 * BALL_BEARINGS.approach * (force**2 / (1e3 * self.diameter)) ** (1.0 / 3.0)


@dataclass(frozen=True)
class TaperedRow:
    """The rollers of a tapered roller bearing: number (need not be an integer), diameter, length and pitch [m]."""

    count: float
    diameter: float
    length: float
    pitch: float

    @property
    def no_clearance(self) -> float:
        """Load factor Z Q/F of the most loaded roller without clearance."""
        return TAPERED_ROLLERS.no_clearance

    def approach(self, force: float) -> float:
        """Compute the approach of both rings at a roller under a `force` [N] by Palmgren's formula [m]."""
        return roller_approach(force, self.length)


def roller_approach(force: float, length: float) -> float:
    """Compute the approach [m] of both rings at a roller of a `length` [m] under a `force` [N] (Palmgren)."""
    load_share = force**CROSSED_ROLLERS.load_exponent / (1e3 * length) ** CROSSED_ROLLERS.length_exponent
    return 1e-3 * CROSSED_ROLLERS.approach * load_share


@dataclass(frozen=True, eq=False)
class OutputBearings:
    """The two bearings of the output.

    Attributes
    ----------
    bearing, row
        The bearing of which there are two, and its balls or rollers.
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
    seat_stiffness
        Radial stiffness of each seat in the cover [N/m]; infinite in a metal.
    disc_force
        Axial force that the press fits of the second disc withstand [N], if it clamps the pair; else infinite.
    flange_moment
        Tilting moment at which the joint of output flange and hub gapes [N m].
    """

    bearing: StockBearing
    row: BallRow | TaperedRow
    spacing: float
    lever: float
    dynamic: float
    static: float
    capacity: float
    own: tuple[float, float]
    seat_stiffness: float = math.inf
    disc_force: float = math.inf
    flange_moment: float = math.inf

    @property
    def load_limit(self) -> float:
        """Limit of the radial load of one bearing [N], whose axial force the second disc withstands as well."""
        if math.isinf(self.disc_force):
            return self.capacity
        return min(self.capacity, self.disc_force / thrust_ratio(self.bearing))

    @property
    def layout(self) -> str:
        """Bearings and their distance, in words."""
        centres = "load centres " if self.bearing.contact_angle else ""
        return f"2 x {self.bearing.designation}, {centres}{1e3 * self.spacing:.4g} mm apart"

    @property
    def stiffness_note(self) -> str:
        """Return the conditions under which the tilting stiffness applies, in words: preload, plastic seats.

        For bearings without preload, the text states the stiffness with the usual clearance [N m/arcmin] as well.
        """
        seats = "" if math.isinf(self.seat_stiffness) else "; with the plastic of their seats"
        if self.bearing.contact_angle:
            bound = "; rollers alone, an upper bound" if self.bearing.has_tapered_rollers else ""
            return f"preloaded{bound}{seats}"
        loose_stiffness = self.tilting_stiffness(BALL_BEARINGS.usual_clearance) * ARCMINUTE
        return f"{loose_stiffness:.3g} with the usual clearance, closed{seats}"

    @property
    def axial_source(self) -> str:
        """Source of the limit of the axial load."""
        if not self.bearing.contact_angle:
            return "0.25 C0 (SKF)"
        return "ISO 281, 76" if math.isinf(self.disc_force) else "ISO 281, 76; press fits of the second disc"

    @property
    def moment(self) -> float:
        """Tilting moment limit in addition to the nominal torque [N m]: force times spacing, or that of the flange."""
        return min(self._bearing_moment, self.flange_moment)

    @property
    def _bearing_moment(self) -> float:
        """Tilting moment limit of bearings and their seats [N m]."""
        return self.spacing * max(self.load_limit - max(self.own), 0.0)

    @property
    def moment_source(self) -> str:
        """Source of the limit of the tilting moment."""
        if self.flange_moment < self._bearing_moment:
            return FLANGE_SOURCE
        return "ISO 281 and 76" if self.load_limit == self.capacity else "press fits of the second disc"

    @property
    def radial(self) -> float:
        """Limit of a radial load on the flange's face in addition to the nominal torque [N]."""
        inner, outer = (max(self.load_limit - own, 0.0) for own in self.own)
        return min(inner * self.spacing / abs(self.lever), outer * self.spacing / (self.spacing + self.lever))

    @property
    def axial(self) -> float:
        """Limit of an axial load alone [N], which one bearing carries."""
        if not self.bearing.contact_angle:
            return BALL_BEARINGS.max_axial_share * self.static
        factors = thrust_factors(self.bearing)
        return min(self.capacity / factors.axial, self.static / factors.static_axial, self.disc_force)

    def tilting_stiffness(self, ball_load_factor: float = 0.0) -> float:
        """Compute the tilting stiffness of a pair of output bearings [N m/rad] at half of their moment limit.

        The deflection of a ball or roller follows from its force by Palmgren's formula. The most loaded of the Z balls
        of a bearing has the force Q; `ball_load_factor` is Z Q/F, with the force F on the bearing, 0 for the factor
        without clearance. Q and F are in the direction of contact. Each seat yields by F over its stiffness.
        """
        bearing_force, cosine = 0.5 * self.moment / self.spacing, math.cos(self.bearing.contact_angle)
        ball_force = (ball_load_factor or self.row.no_clearance) * bearing_force / (self.row.count * cosine)
        deflection = self.row.approach(ball_force) / cosine + bearing_force / self.seat_stiffness
        return bearing_force * self.spacing**2 / (2.0 * deflection) if bearing_force else 0.0


def balls_of(bearing: StockBearing) -> BallRow:
    """Estimate the balls of a bearing from its dimensions."""
    ball_diameter = BALL_BEARINGS.ball_share * (bearing.outside - bearing.bore)
    pitch = 0.5 * (bearing.outside + bearing.bore)
    filled_angle = ANGULAR_CONTACT.filled_angle if bearing.contact_angle else DEEP_GROOVE_FILLED_ANGLE
    return BallRow(int(filled_angle / (2.0 * math.asin(ball_diameter / pitch))) + 1, ball_diameter, pitch)


def tapered_row_of(bearing: StockBearing) -> TaperedRow:
    """Estimate number, diameter, length and pitch diameter of the rollers of a tapered roller bearing.

    The pitch diameter is the mean of bore and outside diameter. The diameter D of a roller is a share of their
    difference, and the number Z follows from the spacing (`TAPERED_ROLLERS`). The length L follows from the static
    rating, C0 = 44 (1 - D cos(a)/d_pw) Z L D cos(a) (ISO 76), with the contact angle a.
    """
    roller_diameter = TAPERED_ROLLERS.diameter_share * (bearing.outside - bearing.bore)
    pitch, cosine = 0.5 * (bearing.outside + bearing.bore), math.cos(bearing.contact_angle)
    count = math.pi * pitch / (TAPERED_ROLLERS.spacing * roller_diameter)
    length = (
        1e-6 * bearing.static / (44.0 * (1.0 - roller_diameter * cosine / pitch) * count * roller_diameter * cosine)
    )
    return TaperedRow(count, roller_diameter, length, pitch)


def equivalent_load_limit(reducer: Reducer, bearing: StockBearing) -> float:
    """Compute the limit of the equivalent load [N] on a `bearing` of the output, such as `OutputBearings.capacity`.

    It is the load for the life that the design requires at the speed of the output, over the service factor, but at
    most the static rating.
    """
    design = reducer.design
    speed = abs(design.drive.speed) / design.reduction
    exponent = rolling.BALL_EXPONENT if bearing.has_balls else rolling.EXPONENT
    force_for_life = rolling.load_for_life(
        bearing.dynamic, design.service.life, speed, design.bearing.reliability, exponent
    )
    return min(force_for_life / design.bearing.service_factor, bearing.static)
