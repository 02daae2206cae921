"""The rating of a design for a duty cycle."""

import warnings
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from typing import get_args

from cycloid_mj.base.arguments import require_choice, require_count, require_number
from cycloid_mj.base.errors import CycloidWarning
from cycloid_mj.design import Design, Named, resolve
from cycloid_mj.geometry.measured import part_notes
from cycloid_mj.life.as_built import Parts, default_parts, select_rated_samples
from cycloid_mj.life.bearings import rate_bearings
from cycloid_mj.life.cam import rate_cam_compliance
from cycloid_mj.life.duty import Duty, constant_duty, describe_condition, turning_points
from cycloid_mj.life.emergency_stop import rate_emergency_stop
from cycloid_mj.life.heat_items import rate_heat, rate_jam_difference, rate_thermal_limits
from cycloid_mj.life.item import ItemKind, RatedItem, Rating, sort_by_margin
from cycloid_mj.life.joints import rate_joints
from cycloid_mj.life.loading import POSES, solve_loading
from cycloid_mj.life.ranges import StressRange
from cycloid_mj.life.rv import rate_rv
from cycloid_mj.life.steady_state import estimate_temperatures, film_steady_state, oil_temperatures, warms_up
from cycloid_mj.life.strength import rate_strength
from cycloid_mj.life.surfaces import rate_surfaces
from cycloid_mj.life.wear import rate_wear
from cycloid_mj.reducer import Reducer, RvReducer, once, reducer_of


def rate(
    design: Named | Reducer,
    duty: Duty | None = None,
    life: float = 0.0,
    ranges: dict[str, StressRange] | None = None,
    compliance: bool = False,
    poses: int = POSES,
    stops: bool = True,
    give: bool | None = None,
    parts: Parts = "perfect",
    steady: bool = True,
) -> Rating:
    """Rate a design that can be built: life, safety factors, wear and heat of its parts.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file; or a reducer, whose cached tolerance samples are reused.
    duty, life
        Torques and speeds with their shares of the time, by default the nominal torque at the design's speed; and the
        required life [h], by default that of the design.
    ranges
        Stress range of disc or ring from a finite-element study, by name of the part.
    compliance, give
        Whether to compute the cam load for several stiffnesses of its bearing too (``life.cam``), and the torque that
        steady temperatures allow (``life.thermal``), in half a second each. `give` is the deprecated name.
    poses, stops
        Number of crank angles; whether to rate emergency stops and joints too, which takes half of the time.
    parts
        "perfect" to rate the parts as designed, "toleranced" to rate samples within the tolerances of the design
        (``life.as_built``).
    steady
        Whether, with the friction law ``film``, losses, temperatures and viscosity of the oil are those of the steady
        state. Otherwise, losses are those at 20 °C, and the temperature of the oil is estimated by them (RV reducer:
        20 °C). If ``[thermal]`` sets temperatures, all are at these temperatures.

    Returns
    -------
    Rating
        Life, safety factors, wear and heat; an item is a part with a kind of failure. `weakest` is the item with the
        smallest margin.

    Raises
    ------
    DesignError, RunError
        The crank does not turn; no static equilibrium exists at a torque of the duty.
    UsageError
        The parts are to be toleranced, but the design has no tolerances; the input turns without torque; an argument is
        out of range.
    """
    require_choice("parts", parts, get_args(Parts))
    require_count("poses", poses, 1)
    if life:
        require_number("life", life, "h", above=0.0)
    if give is not None:
        warnings.warn("the argument `give` of rate() is deprecated: use `compliance`", CycloidWarning, stacklevel=2)
        compliance = give
    reducer = design if isinstance(design, Reducer) else reducer_of(resolve(design))
    design = reducer.design
    life = life or design.service.life
    duty = duty or constant_duty(design.rated_torque, design.drive.speed)
    if parts == "toleranced":
        samples = select_rated_samples(reducer)
        ratings = [
            rate(sample, duty, life, ranges, compliance, poses, stops, steady=steady) for sample in samples.designs
        ]
        return _merge_sample_ratings(design.name, ratings, samples.words)
    if isinstance(reducer, RvReducer):
        state = film_steady_state(reducer, duty) if steady else None
        rating = rate_rv(reducer, duty, life, oil_temperatures(reducer, state.temperatures) if state else None)
        return _add_thermal_limits(rating, design, duty) if compliance else rating
    return _rate_parts(reducer, duty, life, ranges, compliance, poses, stops, steady)


def _rate_parts(
    reducer: Reducer,
    duty: Duty,
    life: float,
    ranges: dict[str, StressRange] | None,
    compliance: bool,
    poses: int,
    stops: bool,
    steady: bool,
) -> Rating:
    """Rate the parts of one reducer over a duty cycle for a required life [h], without samples within the tolerances.

    `ranges` are stress ranges of disc or ring from a finite-element study, by name of the part. `compliance` is whether
    to compute the cam load for several stiffnesses of its bearing, too, and the torque at steady temperatures. `poses`
    is the number of crank angles per point of the duty, and `stops` is whether to rate emergency stops and joints.
    `steady` is whether heat is rated in the steady state with the friction law ``film``.
    """
    design = reducer.design
    items, solver_effort = _rate_all_items(reducer, duty, ranges, poses, stops, steady)
    sorted_items = sort_by_margin(items, life)
    cam_compliance = rate_cam_compliance(reducer, duty) if compliance else None
    assumptions = *_assumptions(reducer, duty), *([cam_compliance.words] if cam_compliance else [])
    condition = describe_condition(design, duty)
    rating = Rating(
        design.name, condition, life, sorted_items, assumptions, cam_compliance, solver_effort, reducer.parts_text
    )
    return _add_thermal_limits(rating, design, duty) if compliance else rating


def _add_thermal_limits(rating: Rating, design: Design, duty: Duty) -> Rating:
    """Return a rating with the limits of the steady temperatures under a duty (`rate_thermal_limits`).

    A design whose dimensions already include thermal expansion (``thermal.applied``) has no such limits.
    """
    if design.thermal.applied:
        return rating
    items = [*rating.items.values(), *rate_thermal_limits(design, duty)]
    return replace(rating, items=sort_by_margin(items, rating.life))


def _merge_sample_ratings(design_name: str, ratings: list[Rating], sample_text: str) -> Rating:
    """Merge the ratings of tolerance samples of a design: each item is that of the sample with the least margin.

    An item is a part with a kind of failure. `design_name` becomes the name of the design; `sample_text` describes the
    samples, which are random drives within the tolerances, and becomes the first assumption.
    """
    first_rating = ratings[0]
    weakest_items = [
        min(
            (rating.items[key] for rating in ratings if key in rating.items),
            key=lambda item: item.margin(first_rating.life),
        )
        for key in first_rating.items
    ]
    return replace(
        first_rating,
        design=design_name,
        items=sort_by_margin(weakest_items, first_rating.life),
        assumptions=(sample_text, *first_rating.assumptions),
        parts="toleranced",
    )


def _rate_all_items(
    reducer: Reducer,
    duty: Duty,
    ranges: dict[str, StressRange] | None,
    crank_angles: int,
    with_stops: bool,
    steady: bool,
) -> tuple[list[RatedItem], float]:
    """Rate bearings, surfaces, strength, wear, heat, emergency stops and joints over a duty cycle.

    Parameters
    ----------
    ranges
        Stress ranges of disc or ring by part, from a finite-element study; None without one.
    crank_angles
        Number of crank angles per turn.
    with_stops
        Whether emergency stops and joints are rated.
    steady
        Whether heat is rated in the steady state with the friction law ``film``.

    Returns
    -------
    tuple
        The rated items (a part with a kind of failure each); and the solver effort: the mean number of assemblies of
        the equilibrium equations per crank angle (`Loading.work`), at the point of the duty where it is largest.

    Raises
    ------
    DesignError
        The crank does not turn.
    """
    points = turning_points(duty, reducer.design, "a life in hours can be computed")
    loadings = [solve_loading(reducer, point, crank_angles, with_stops) for point in points]
    worst_loading = max(loadings, key=lambda loading: abs(loading.point.torque))
    state = film_steady_state(reducer, duty) if steady else None
    temperatures = None
    if warms_up(reducer.design):
        temperatures = oil_temperatures(
            reducer, state.temperatures if state else estimate_temperatures(reducer, loadings)
        )
    items_by_kind = {
        ItemKind.BEARING: rate_bearings(reducer, loadings, duty.peak, temperatures),
        ItemKind.SURFACE: rate_surfaces(reducer, loadings),
        ItemKind.STRENGTH: rate_strength(reducer, worst_loading, ranges),
        ItemKind.WEAR: rate_wear(reducer, loadings),
        ItemKind.HEAT: chain(rate_heat(reducer, loadings, state), rate_jam_difference(reducer, loadings, state)),
    }
    if with_stops:
        items_by_kind[ItemKind.STOP] = rate_emergency_stop(reducer, duty.peak, worst_loading)
        items_by_kind[ItemKind.JOINT] = rate_joints(reducer, duty.peak, worst_loading)
    items = [replace(item, kind=kind) for kind, rated_items in items_by_kind.items() for item in rated_items]
    return items, max(loading.work for loading in loadings)


@once
def rate_at_rated_load(reducer: Reducer) -> Rating:
    """Rate perfect parts at nominal torque and speed for the life of the design; errors as `rate`."""
    return rate(reducer)


@once
def rate_for_verdict(reducer: Reducer) -> Rating:
    """Rate a reducer at its nominal torque and speed for its required life: samples if it has tolerances.

    Samples are random drives within the tolerances (`select_rated_samples`). The command ``cycloid-mj rate`` without
    options prints this rating. Unlike `rate_at_rated_load`, it includes heat for an RV reducer.
    """
    parts = default_parts(reducer.design)
    if isinstance(reducer, RvReducer):
        return rate(reducer, compliance=True, parts=parts)
    return rate(reducer, parts=parts) if parts == "toleranced" else rate_at_rated_load(reducer)


def _assumptions(reducer: Reducer, duty: Duty) -> Iterator[str]:
    """Yield the general assumptions of a rating over a duty cycle, a sentence each.

    They are about forces, reliability, peak torque, failures that are not rated, and materials.
    """
    yield "forces: statics with friction and the clearances of the design, at constant crank speed"
    yield f"reliability of bearings and parts: {reducer.design.bearing.reliability:.0%} (bearing.reliability)"
    yield f"peak torque: {duty.peak:.4g} N m{'' if duty.peak_given else ', twice the largest of the duty (--peak-nm)'}"
    yield "pitting is rated for steel only: no standard has a curve for other metals and plastics"
    yield "micropitting is not rated: it needs the film thickness and roughness of each flank (ISO/TS 6336-22)"
    yield "contacts that fit too closely for Hertz, such as pins in sockets, have no pressure rating"
    yield from part_notes(reducer.design)
