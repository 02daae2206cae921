"""Forces of discs and shaft on the bearings of the output's hub, and their equivalent loads."""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.design.stock import StockBearing
from cycloid_mj.life.loading import FAR, Loading
from cycloid_mj.life.rolling import magnitudes
from cycloid_mj.parts.export.casing import casing
from cycloid_mj.reducer import Reducer
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
    half_loaded_thrust
        F_a/(F_r tan a) if half of the balls carry the load (Harris, Rolling Bearing Analysis: J_a/J_r = 0.2782/0.2288).
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
    half_loaded_thrust: float = 1.216
    approach: float = 0.44


BALL_BEARINGS = BallBearingData()


@dataclass(frozen=True)
class CrossedRollerData:
    """Data of crossed roller bearings.

    Attributes
    ----------
    contact_angle
        Angle of the rollers' contacts to the plane of the bearing [rad].
    axial_factor, static_axial_factor
        Equivalent loads P = Y F_a and P_0 = Y_0 F_a of an axial load alone (THK, No. 382-3E; IKO has the same).
    preload_share
        Least load over the dynamic rating, which the preload provides (SKF, Rolling bearings, 2018: roller bearings).
    roller_spacing
        Distance of rollers over their diameter, with a spacer between them (assumed).
    approach, load_exponent, length_exponent
        Approach of both rings at a roller [mm]: 3.84e-5 Q^0.9/L^0.8 in N and mm (Palmgren; Harris, Rolling Bearing
        Analysis).
    """

    contact_angle: float = math.radians(45.0)
    axial_factor: float = 0.67
    static_axial_factor: float = 0.44
    preload_share: float = 0.02
    roller_spacing: float = 1.1
    approach: float = 3.84e-5
    load_exponent: float = 0.9
    length_exponent: float = 0.8


CROSSED_ROLLERS = CrossedRollerData()


@dataclass(frozen=True)
class TaperedRollerData:
    """Data of tapered roller bearings, in addition to those of `CrossedRollerData` for any rollers.

    Attributes
    ----------
    radial_factor, axial_factor, static_axial_factor
        Equivalent loads P = X F_r + Y cot(a) F_a with the contact angle a, if F_a/F_r exceeds e = 1.5 tan(a), and, of
        an axial load alone, P_0 = Y_0 cot(a) F_a (ISO 281, Table 11; ISO 76, Table 5).
    diameter_share, spacing
        Diameter of rollers over D - d, as that of balls, and their distance over their diameter, with a web of the cage
        between them (assumed).
    no_clearance
        Z Q/F of the most loaded roller, without clearance (NSK E728g, 5.1).
    half_loaded_thrust
        As that of balls (Harris: 0.3090/0.2453).
    """

    radial_factor: float = 0.4
    axial_factor: float = 0.4
    static_axial_factor: float = 0.22
    diameter_share: float = 0.3
    spacing: float = 1.2
    no_clearance: float = 4.08
    half_loaded_thrust: float = 1.260


TAPERED_ROLLERS = TaperedRollerData()


@dataclass(frozen=True)
class ThrustFactors:
    """Factors of a bearing with a contact angle: X and Y of P = X F_r + Y F_a, and Y_0 of P_0 = Y_0 F_a."""

    radial: float
    axial: float
    static_axial: float


def thrust_factors(bearing: StockBearing) -> ThrustFactors:
    """Return the factors of axial loads on an angular contact or tapered roller bearing (ISO 281, ISO 76)."""
    if not bearing.has_tapered_rollers:
        return ThrustFactors(BALL_BEARINGS.radial_factor, BALL_BEARINGS.axial_factor, BALL_BEARINGS.static_axial_factor)
    cotangent = 1.0 / math.tan(bearing.contact_angle)
    axial, static_axial = TAPERED_ROLLERS.axial_factor, TAPERED_ROLLERS.static_axial_factor
    return ThrustFactors(TAPERED_ROLLERS.radial_factor, axial * cotangent, static_axial * cotangent)


def preload(bearing: StockBearing) -> float:
    """Return the axial preload of a bearing of the output [N], its least load; 0 of a deep groove bearing."""
    if bearing.has_crossed_rollers or bearing.has_tapered_rollers:
        return CROSSED_ROLLERS.preload_share * bearing.dynamic
    return BALL_BEARINGS.preload_share * bearing.dynamic if bearing.contact_angle else 0.0


def thrust_ratio(bearing: StockBearing) -> float:
    """Return the axial force that a radial load on a bearing with a contact angle causes, over this load [1].

    Half of its balls or rollers carry the load.
    """
    bearing_data = TAPERED_ROLLERS if bearing.has_tapered_rollers else BALL_BEARINGS
    return bearing_data.half_loaded_thrust * math.tan(bearing.contact_angle)


def pair_thrust(bearing: StockBearing, radial_load: float) -> float:
    """Compute the axial force between a pair of bearings back to back [N].

    It is the preload of `bearing`, or the axial force that the larger `radial_load` [N] of both causes, if this is
    larger.
    """
    return max(preload(bearing), thrust_ratio(bearing) * radial_load)


def equivalent_load(bearing: StockBearing, load: Array) -> Array:
    """Compute the equivalent load of a bearing [N] under an external load [N] and its own preload, if it has one.

    `load` is the radial load, or for crossed rollers F + 2 M/d_pw, with the radial force F, the tilting moment M and
    the pitch diameter d_pw. It has any shape; the result has the same shape.
    """
    if bearing.has_crossed_rollers:
        return np.maximum(load, preload(bearing))
    if not bearing.contact_angle:
        return load
    factors = thrust_factors(bearing)
    return np.maximum(load, factors.radial * load + factors.axial * preload(bearing))


def output_bearing_loads(reducer: Reducer, loading: Loading) -> tuple[Array, ...]:
    """Compute the equivalent loads on the bearings of the output's hub [N] at m crank angles, (m,) each, outer last.

    `loading` has the solved forces at m crank angles. Raises DesignError if the covers do not fit.
    """
    hub = casing(reducer).hub
    if hub.has_crossed_rollers:
        force, moment = crossed_roller_loads(reducer, loading)
        return (equivalent_load(hub, force + 2.0 * moment / hub.pitch),)
    return tuple(equivalent_load(hub, magnitudes(force)) for force in output_bearing_forces(reducer, loading))


def output_bearing_forces(reducer: Reducer, loading: Loading) -> tuple[Array, Array]:
    """Compute the radial forces on the inner and the outer bearing of the output's hub [N] at m angles, (m, 2) each.

    They are in equilibrium with the forces of the discs on the output in `loading`, and that of the shaft if it has a
    bearing in the hub. Raises DesignError if the covers do not fit.
    """
    return _output_planes(reducer, loading).reactions_at(*casing(reducer).load_centres)


def crossed_roller_loads(reducer: Reducer, loading: Loading) -> tuple[Array, Array]:
    """Compute radial force [N] and tilting moment [N m] on the crossed roller bearing of the output, (m,) each.

    `loading` has the solved forces at m crank angles. Force and moment are in equilibrium with the forces of the discs
    on the output, and that of the shaft if it has a bearing in the hub. Raises DesignError if the covers do not fit.
    """
    planes, bearing_position = _output_planes(reducer, loading), 0.5 * sum(casing(reducer).bearings[-1])
    planes_about_bearing = Planes(planes.force, planes.axial_position - bearing_position)
    return magnitudes(planes_about_bearing.net), magnitudes(planes_about_bearing.moment)


def _output_planes(reducer: Reducer, loading: Loading) -> Planes:
    """Return the forces of discs and shaft on the output [N] at m crank angles, with the positions of their planes [m].

    `loading` has the solved forces.
    """
    drive_casing, planes = casing(reducer), list(reducer.design.gear.disc_planes)
    forces = loading.on_output
    if drive_casing.far:
        cosine, sine = np.cos(loading.crank), np.sin(loading.crank)
        force_x, force_y = loading.shaft[:, FAR].T  # the reaction of the bearing, in the shaft's frame
        hub_force = -np.stack([cosine * force_x - sine * force_y, sine * force_x + cosine * force_y], axis=1)
        forces = np.concatenate([forces, hub_force[:, np.newaxis]], axis=1)
        planes.append(0.5 * sum(drive_casing.far))
    return Planes(forces, np.array(planes))
