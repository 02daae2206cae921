"""Load limits of the output flange in addition to the torque: tilting moment, radial and axial load.

Covers and bearings are those of ``parts.export.casing``. A pair of bearings (`life.bearing_pair`) also carries the
forces of the discs on the output, and of the shaft where its bearing is in the hub. Load ratings are those of
``design.stock``. Seats in a cover of plastic are elastic (`seat_stiffness`); those in metal, and the hub, are rigid.
Main bearings of an RV reducer are in `life.rv_output_bearing`.

A crossed roller bearing carries a force F and a moment M together by the load F + 2 M/d_pw (THK, No. 382-3E). Its
rollers, for the tilting stiffness, are estimated from its static rating by ISO 76; its retainer must not gape.
"""

import math
from dataclasses import dataclass

from cycloid_mj.base import names
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.design.stock import StockBearing
from cycloid_mj.life.bearing_pair import (
    FLANGE_SOURCE,
    OutputBearings,
    balls_of,
    equivalent_load_limit,
    roller_approach,
    tapered_row_of,
)
from cycloid_mj.life.duty import constant_duty
from cycloid_mj.life.joints import flange_joint, gaping_moment, retainer_joint, second_disc_seat
from cycloid_mj.life.loading import Loading, solve_loading
from cycloid_mj.life.output_loads import (
    CROSSED_ROLLERS,
    crossed_roller_loads,
    output_bearing_forces,
    output_bearing_loads,
)
from cycloid_mj.life.rolling import magnitudes
from cycloid_mj.life.rv_output_bearing import rv_output_bearings
from cycloid_mj.parts.export.casing import casing
from cycloid_mj.reducer import Reducer, RvReducer, once


@dataclass(frozen=True, eq=False)
class CrossedRollerBearing:
    """The crossed roller bearing of the output.

    Attributes
    ----------
    bearing
        The bearing, with its load ratings.
    lever
        Distance from its middle to the flange's face [m].
    capacity
        Limit of its equivalent load [N], standing and for the life of the design, as in `OutputBearings`.
    own
        Largest equivalent load by discs and shaft at the nominal torque [N].
    retainer_moment, retainer_force
        Tilting moment [N m] in addition to the nominal torque, and axial force [N], at which the retainer gapes.
    flange_moment
        Tilting moment at which the joint of output flange and hub gapes [N m].
    """

    bearing: StockBearing
    lever: float
    capacity: float
    own: float
    retainer_moment: float
    retainer_force: float
    flange_moment: float = math.inf

    @property
    def layout(self) -> str:
        """Bearing and pitch circle of its rollers, in words."""
        return f"{self.bearing.designation}, rollers on {1e3 * self.bearing.pitch:.4g} mm"

    @property
    def stiffness_note(self) -> str:
        """Condition of the tilting stiffness, in words."""
        return "preloaded; rollers alone, an upper bound"

    @property
    def axial_source(self) -> str:
        """Source of the limit of the axial load."""
        return "ISO 281, 76; preload of the retainer"

    @property
    def moment(self) -> float:
        """Tilting moment limit in addition to the nominal torque [N m]."""
        return max(min(self._bearing_moment, self.retainer_moment, self.flange_moment), 0.0)

    @property
    def _bearing_moment(self) -> float:
        """Tilting moment limit of the bearing [N m]; negative if its own load is too large."""
        return 0.5 * self.bearing.pitch * (self.capacity - self.own)

    @property
    def moment_source(self) -> str:
        """Source of the limit of the tilting moment."""
        if self.moment == self.flange_moment:
            return FLANGE_SOURCE
        return "preload of the retainer" if self.moment == self.retainer_moment else "ISO 281 and 76"

    @property
    def radial(self) -> float:
        """Limit of a radial load on the flange's face in addition to the nominal torque [N]."""
        load = max(self.capacity - self.own, 0.0) / (1.0 + 2.0 * abs(self.lever) / self.bearing.pitch)
        return min(load, max(self.retainer_moment, 0.0) / abs(self.lever))

    @property
    def axial(self) -> float:
        """Limit of an axial load alone [N]."""
        life_limit = self.capacity / CROSSED_ROLLERS.axial_factor
        return min(life_limit, self.bearing.static / CROSSED_ROLLERS.static_axial_factor, self.retainer_force)

    @property
    def rollers(self) -> tuple[float, float]:
        """Return number of all rollers of a crossed roller bearing [1], and their length [m], which is their diameter.

        They follow from the spacing of the rollers and the static rating C0 = 44 Z L D cos 45 deg (ISO 76), without the
        factor of their curvature. Every second roller carries load of one direction.
        """
        diameter_sum = math.pi * self.bearing.pitch / CROSSED_ROLLERS.roller_spacing
        length = 1e-6 * self.bearing.static / (44.0 * diameter_sum * math.cos(CROSSED_ROLLERS.contact_angle))
        return diameter_sum / length, length

    def tilting_stiffness(self) -> float:
        """Compute the tilting stiffness of a crossed roller bearing [N m/rad] at half of its moment limit.

        At each roller the two rings approach each other by Palmgren's formula. Half of the rollers carry, with forces
        in proportion to the power 1/0.9 of the sine of their angle around the bearing. Rings and seats are rigid.
        """
        (roller_count, length), cosine = self.rollers, math.cos(CROSSED_ROLLERS.contact_angle)
        radius, moment, power = 0.5 * self.bearing.pitch, 0.5 * self.moment, 1.0 / CROSSED_ROLLERS.load_exponent + 1.0
        mean_sine = math.gamma(0.5 * (power + 1.0)) / (math.sqrt(math.pi) * math.gamma(0.5 * power + 1.0))
        force = moment / (0.5 * roller_count * mean_sine * cosine * radius)
        return moment * radius * cosine / roller_approach(force, length) if moment else 0.0


def seat_stiffness(bore: float, outside: float, width: float, modulus: float, poisson: float) -> float:
    """Compute the radial stiffness of the seat of a rigid ring in a plate that is fixed at its outside [N/m].

    The plate is an annulus in plane stress, bonded to the ring: with kappa = (3 - nu)/(1 + nu) and the shear modulus G,
    k = 2 pi G (1 + kappa) t/(kappa ln(b/a) - (b^2 - a^2)/(kappa (a^2 + b^2))). For kappa = 1 it is the stiffness of a
    rubber bush by Adkins and Gent (Brit. J. Appl. Phys. 5, 1954, 354).

    Parameters
    ----------
    bore, outside, width
        Diameters a and b, and thickness t of the plate [m].
    modulus, poisson
        Young's modulus [Pa] and Poisson's ratio of the plate.
    """
    kappa, shear_modulus = (3.0 - poisson) / (1.0 + poisson), modulus / (2.0 * (1.0 + poisson))
    ring_ratio = (outside**2 - bore**2) / (outside**2 + bore**2)
    return (
        2.0 * math.pi * shear_modulus * (1.0 + kappa) * width / (kappa * math.log(outside / bore) - ring_ratio / kappa)
    )


def _cover_seat_stiffness(reducer: Reducer) -> float:
    """Compute the radial stiffness of each seat of the output's bearings in its cover [N/m]; infinite in metal.

    A plastic cover deforms between the outer ring of the bearing and the circle of its screws (`seat_stiffness`).
    """
    drive_casing, cover_material = casing(reducer), reducer.design.material_of(names.HOUSING)
    if not cover_material.is_plastic:
        return math.inf
    screw_circle_diameter = 2.0 * drive_casing.screws.circle
    return seat_stiffness(
        drive_casing.hub.outside,
        screw_circle_diameter,
        drive_casing.hub.width,
        cover_material.youngs_modulus,
        cover_material.poisson,
    )


@once
def output_bearings(reducer: Reducer) -> OutputBearings | CrossedRollerBearing:
    """Compute dimensions, load ratings and load limits of the bearings of the output's hub.

    The load limit of each bearing is the load for the life that the design requires, at most its static rating. The
    forces at the nominal torque leave only a part of it for other loads.

    Raises
    ------
    DesignError
        The covers do not fit, or an RV reducer has no main bearings that fit.
    RunError
        No static equilibrium exists.
    """
    if isinstance(reducer, RvReducer):
        return rv_output_bearings(reducer)
    drive_casing = casing(reducer)
    hub, flange_face = drive_casing.hub, drive_casing.ends[1]
    load_limit = equivalent_load_limit(reducer, hub)
    flange_moment = gaping_moment(flange_joint(reducer))
    if hub.has_crossed_rollers:
        own_load, own_moment = _own_load_and_moment(reducer)
        retainer = retainer_joint(reducer)
        lever, preload = flange_face - 0.5 * sum(drive_casing.bearings[-1]), retainer.count * retainer.preload
        retainer_moment = gaping_moment(retainer) - own_moment
        return CrossedRollerBearing(hub, lever, load_limit, own_load, retainer_moment, preload, flange_moment)
    inner, outer = drive_casing.load_centres
    return OutputBearings(
        bearing=hub,
        row=tapered_row_of(hub) if hub.has_tapered_rollers else balls_of(hub),
        spacing=outer - inner,
        lever=flange_face - outer,
        dynamic=hub.dynamic,
        static=hub.static,
        capacity=load_limit,
        own=_own_forces(reducer),
        seat_stiffness=_cover_seat_stiffness(reducer),
        disc_force=second_disc_seat(reducer).force if drive_casing.stop_ring else math.inf,
        flange_moment=flange_moment,
    )


def _own_load_and_moment(reducer: Reducer) -> tuple[float, float]:
    """Compute the largest equivalent load [N] and tilting moment [N m] of the crossed roller bearing at nominal torque.

    The forces of discs and shaft on the output cause them; external loads are not included.
    """
    rated_loading = _rated_loading(reducer)
    _, moment = crossed_roller_loads(reducer, rated_loading)
    return float(output_bearing_loads(reducer, rated_loading)[0].max()), float(moment.max())


def _rated_loading(reducer: Reducer) -> Loading:
    """Return the forces at the nominal torque and speed."""
    design = reducer.design
    point = constant_duty(design.rated_torque, design.drive.speed).points[0]
    return solve_loading(reducer, point, with_wind_up=False)


def _own_forces(reducer: Reducer) -> tuple[float, float]:
    """Compute the largest forces on the inner and on the outer output bearing [N] at the nominal torque.

    They are caused by discs and shaft.
    """
    inner, outer = (float(magnitudes(force).max()) for force in output_bearing_forces(reducer, _rated_loading(reducer)))
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
