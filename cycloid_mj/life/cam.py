"""Cam load solved over the assumed stiffness of its bearing, compared with ideal sharing."""

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.life.bearing_compliance import IDEAL, CamCase, CamCompliance
from cycloid_mj.life.bearings import bearing_load, cam_ratings
from cycloid_mj.life.duty import Duty
from cycloid_mj.life.loading import POSES, relative_speed, solve_loading
from cycloid_mj.life.rolling import life_hours
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.ideal import ideal_cam
from cycloid_mj.statics.springs import turn_evenly

STIFFNESS_FACTORS = (0.1, 0.3, 1.0, 3.0, 10.0, 100.0)
"""Factors on the stiffness of the cam, which depends on the fit of rollers and rings and on the seat (heuristic)."""


def rate_cam_compliance(reducer: Reducer, duty: Duty) -> CamCompliance:
    """Compute equivalent load [N] and life [h] of the cam bearing for several assumed radial stiffnesses.

    Load and life are those over the duty cycle `duty`. There is a case for each of `STIFFNESS_FACTORS` times the
    assumed stiffness, without load and life if no static equilibrium exists. The last case is ideal load sharing of
    rigid parts.
    """
    design = reducer.design
    points = [point for point in duty.points if point.speed]
    weighted_speeds = np.array([relative_speed(reducer, point.speed) * point.share for point in points])

    def make_case(name: str, stiffness: float | None, cam_forces: list[Array]) -> CamCase:
        """Return the case of a stiffness [N/m] from the cam forces at the duty's points [N], shape (m, discs) each."""
        ratings, reliability = cam_ratings(reducer), design.bearing.reliability
        load = bearing_load(reducer, cam_forces, weighted_speeds, ratings.exponent)
        has_rolling_bearing, speed = design.gear.bearing == "rolling", float(weighted_speeds.sum())
        life = life_hours(ratings.dynamic, load, speed, reliability, ratings.exponent) if has_rolling_bearing else None
        return CamCase(name, stiffness, load, life)

    assumed_stiffness, cases = reducer.at_rated_load.contacts["cam"].stiffness, []
    for factor in STIFFNESS_FACTORS:
        name = "as assumed" if factor == 1.0 and not design.stiffness.cam else f"{factor:g} times"
        if factor == 1.0 and design.stiffness.cam:
            name = "of the design file"
        varied_reducer = reducer.but(stiffness={"cam": factor * assumed_stiffness})
        try:
            cases.append(
                make_case(
                    name,
                    factor * assumed_stiffness,
                    [solve_loading(varied_reducer, point, with_wind_up=False).cam for point in points],
                )
            )
        except CycloidError:
            cases.append(CamCase(name, factor * assumed_stiffness, None, None))
    crank_angles = design.lobes * turn_evenly(reducer, POSES)
    ideal_forces = []
    for point in points:
        loaded_reducer = reducer.turning_at(point.speed).but(load={"torque": point.torque})
        ideal_forces.append(ideal_cam(loaded_reducer, crank_angles))
    return CamCompliance((*cases, make_case(IDEAL, None, ideal_forces)))
