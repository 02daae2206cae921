"""The rating of a design under a duty: every item, the weakest first."""

from collections.abc import Iterator

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import Named, material_limits, resolve
from cycloid_mj.life.bearings import rate_bearings
from cycloid_mj.life.cam import cam_give
from cycloid_mj.life.duty import Duty, steady
from cycloid_mj.life.emergency_stop import peaks
from cycloid_mj.life.heat import heat
from cycloid_mj.life.item import Rating
from cycloid_mj.life.loading import POSES, loading
from cycloid_mj.life.ranges import StressRange
from cycloid_mj.life.strength import strength
from cycloid_mj.life.surfaces import surfaces
from cycloid_mj.life.wear import wear
from cycloid_mj.reducer import Reducer, once


def rate(
    design: Named,
    duty: Duty | None = None,
    life: float = 0.0,
    ranges: dict[str, StressRange] | None = None,
    give: bool = False,
    poses: int = POSES,
    stops: bool = True,
) -> Rating:
    """Rate a sound design under a duty for a life.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file: what is rated.
    duty
        Torques and speeds with their shares of the time; by default the nominal torque at the design's speed.
    life
        Hours that are asked for; by default the design's own.
    ranges
        Part -> stress range of gear or ring that a study by finite elements found.
    give
        Whether the cam is solved over the stiffness that is assumed for it as well, see ``life.cam``.
    poses
        Crank angles; fewer are quicker and less exact: a tenth of them, 0.5 % of the margins.
    stops
        Whether emergency stops are rated, which takes half of the time.

    Raises
    ------
    DesignError
        The crank does not turn.
    RunError
        The drive cannot hold a torque of the duty.
    """
    design = resolve(design)
    reducer = Reducer(design)
    life = life or design.service.life
    duty = duty or steady(reducer.design.rated_torque, reducer.design.drive.speed)
    turning = [point for point in duty.points if point.speed]
    if not turning:
        raise DesignError("drive.speed_rpm is 0, but lives need a crank that turns: give another speed, such as 1640")
    loadings = [loading(reducer, point, poses, stops) for point in turning]
    worst = max(loadings, key=lambda one: abs(one.point.torque))
    items = [
        *rate_bearings(reducer, loadings, duty.peak),
        *surfaces(reducer, loadings),
        *strength(reducer, worst, ranges),
        *wear(reducer, loadings),
        *heat(reducer, loadings),
        *(peaks(reducer, duty.peak, worst) if stops else ()),
    ]
    ordered = sorted(items, key=lambda item: item.margin(life))
    spread = cam_give(reducer, duty) if give else None
    assumptions = *_assumptions(reducer, duty), *([spread.words] if spread else [])
    by_key, work = {item.key: item for item in ordered}, max(one.work for one in loadings)
    return Rating(reducer.design.name, duty.words, life, by_key, assumptions, spread, work)


@once
def rate_at_rated_load(reducer: Reducer) -> Rating:
    """Rate a design at its nominal torque and speed for its own life, once for all who ask; errors as `rate`."""
    return rate(reducer.design)


def _assumptions(reducer: Reducer, duty: Duty) -> Iterator[str]:
    yield "forces by statics with friction at the clearances of the design, a crank that turns evenly"
    yield f"reliability {reducer.design.bearing.reliability:.0%} of bearings and of parts (bearing.reliability)"
    yield f"peak torque {duty.peak:.4g} N m{'' if duty.peak_given else ', twice the largest of the duty (--peak-nm)'}"
    yield "pitting has a standard curve for steel alone: other metals and plastics are not rated for it"
    yield from material_limits(reducer.design)
