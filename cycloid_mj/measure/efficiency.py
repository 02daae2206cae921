"""Efficiency over output torque and speed, losses by kind of contact, and no-load and back-driving torques."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cycloid_mj.base.engine import Progress, silent
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.base.powers import SELF_LOCKING
from cycloid_mj.base.result import Curve, Quantity, Table, by_key
from cycloid_mj.base.units import RPM
from cycloid_mj.design import Named, resolve
from cycloid_mj.dynamics.massless import assumptions
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.measure import loss_breakdown, spread
from cycloid_mj.measure.closed_form import AS_BUILT, ideal_efficiency, published_efficiency
from cycloid_mj.measure.conditions import STEADY, drag_assumption, friction_assumption
from cycloid_mj.measure.efficiency_map import EfficiencyMap, OperatingPoint, run_map
from cycloid_mj.measure.measurement import Measurement
from cycloid_mj.measure.published import Published
from cycloid_mj.measure.sensitivity import interpolate_friction
from cycloid_mj.measure.steady import averaging_periods, periods_text, steady_design
from cycloid_mj.reducer import Reducer, reducer_of
from cycloid_mj.statics.sheet import sampled_efficiency


@dataclass(frozen=True)
class EfficiencyMapSettings:
    """Default operating points of the efficiency map."""

    torques: tuple[float, ...] = (0.25, 0.5, 1.0)
    """Output torques relative to the rated one without losses."""
    speeds: tuple[float, ...] = (0.5, 1.0, 1.5)
    """Crank speeds relative to the design's."""


MAP = EfficiencyMapSettings()

NO_FRICTION = "0, as the friction of this pair is 0"


@shows_progress
def efficiency(
    design: Named,
    loads: Sequence[float] = (),
    speeds: Sequence[float] = (),
    quick: bool = False,
    progress: Progress = silent,
    published: Sequence[Published] = (),
    solver: Solver = "planar",
) -> Measurement:
    """Measure the efficiency of a design and its losses by kind of mating pair, in simulations at several loads.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file.
    loads, speeds
        Output torques [N m] and speeds of crank or sun [rad/s] of the map, above 0; by default the rated torque and the
        design's speed times each of `MAP.torques` and `MAP.speeds`.
    quick
        Whether to average over a shorter time, without half the time step, by default only at the rated point.
    progress, published, solver
        Called after each run with the numbers of finished and of all runs; published torques of this design, for
        comparison; solver of the runs.

    Returns
    -------
    Measurement
        Efficiencies [%], losses [W] and no-load and back-driving torques [N m], with numerical errors and closed forms;
        curves over the torque, tables of the map and of the losses.
    """
    reducer = reducer_of(resolve(design))
    steady_reducer = steady_design(reducer)
    rated_torque, speed = steady_reducer.design.rated_torque, steady_reducer.design.drive.speed
    torques = loads or [share * rated_torque for share in ((1.0,) if quick else MAP.torques)]
    speeds = speeds or [share * speed for share in ((1.0,) if quick else MAP.speeds)]
    periods = STEADY.min_periods(quick)
    efficiency_map = run_map(steady_reducer, torques, speeds, periods, not quick, progress, solver)
    rated_point = efficiency_map.rated
    rated = _rated_quantities(steady_reducer, efficiency_map)
    published = [
        replace(paper, friction=interpolate_friction(efficiency_map.by_friction, paper.rate)) for paper in published
    ]
    return Measurement(
        measure="efficiency",
        design=steady_reducer.design,
        condition=(
            f"up to {max(torques):.4g} N m and {max(map(abs, speeds)) / RPM:.0f} rpm, "
            f"{steady_reducer.design.condition_words}, {SOLVERS[solver]}"
        ),
        quantities=by_key(rated, _loss_quantities(rated_point), _drag_quantities(steady_reducer, efficiency_map)),
        curves=_curves(efficiency_map),
        tables=(
            loss_breakdown.table(rated_point.powers, published, efficiency_map.error),
            spread.table(f"efficiency at {rated_torque:g} N m", rated_point.powers.efficiency, efficiency_map.by_input),
            *_tables(efficiency_map),
        ),
        assumptions=_assumptions(steady_reducer, averaging_periods(steady_reducer, periods)),
        details=_details(efficiency_map, published),
        runs={"rated": rated_point.run, "backward": efficiency_map.backward.run, "from-rest": efficiency_map.rest.run},
    )


def _details(efficiency_map: EfficiencyMap, published: Sequence[Published]) -> dict[str, Any]:
    """Return losses by kind of pair and by part, effects of assumed inputs, and break-away torques as JSON values.

    ``losses_by_pair`` are shares of the input power at each point of the map. ``sensitivity`` has the efficiencies at
    both ends of the plausible range of each assumed input, such as a friction coefficient. The other keys, such as
    ``build_up``, are those of `loss_breakdown.as_json`, `spread.as_json` and `BreakAway.as_json`. `published` are the
    torques of publications. `efficiency_map` has the simulated operating points.
    """
    rated_powers = efficiency_map.rated.powers
    return {
        "losses_by_pair": [
            {"torque_nm": point.torque, "speed_rpm": point.speed / RPM, **point.powers.loss_shares()}
            for point in efficiency_map.grid
        ],
        **loss_breakdown.as_json(rated_powers, published),
        **spread.as_json(rated_powers.efficiency, efficiency_map.by_input),
        **efficiency_map.rest.as_json(),
    }


def _rated_quantities(reducer: Reducer, efficiency_map: EfficiencyMap) -> list[Quantity]:
    """Return the efficiency at the rated torque, with and without clearances, and the energy balance's residual [%].

    `efficiency_map` has the simulated operating points, among them one that approaches ideal load sharing.
    """
    efficiency, load = 1e2 * efficiency_map.rated.powers.efficiency, efficiency_map.rated.torque
    ideal_sharing, formula = ideal_efficiency(reducer, load), published_efficiency(reducer)
    error, residual = 1e2 * efficiency_map.error, max((point.powers.residual for point in efficiency_map.grid), key=abs)
    condition = f"at {load:g} N m, {efficiency_map.rated.speed / RPM:g} rpm"
    inputs = spread.spread_text(efficiency_map.rated.powers.efficiency, efficiency_map.by_input)
    rated_quantity = Quantity(
        "efficiency", f"efficiency {condition}", efficiency, "%", error, note=f"{inputs}; {AS_BUILT[reducer.LAYOUT]}"
    )
    limit = Quantity(
        "efficiency_ideal_limit",
        f"the same with fixed pins or lobes, without clearance, with {reducer.RIGID_BEARING}",
        1e2 * efficiency_map.ideal.powers.efficiency,
        "%",
        1e2 * efficiency_map.ideal.shift,
    )
    balance = Quantity("balance_residual", "largest residual of the energy balance", 1e2 * residual, "% of input")
    if reducer.design.has_film:
        statics = sampled_efficiency(efficiency_map.rated.reducer, load)
        source = "statics with the film friction of each contact; low to high are its 5 to 95 %"
        rated_quantity = replace(
            rated_quantity, reference=statics.value, source=source, low=statics.low, high=statics.high
        )
        return [replace(rated_quantity, causes=statics.causes), limit, balance]
    limit_note = (
        f"{formula.source}: {1e2 * formula.efficiency:.2f} %, without the cam's bearing and without the moment by "
        "which friction turns the disc back, which increases the tooth forces"
        if formula
        else ""
    )
    reference, source = 1e2 * ideal_sharing.efficiency, ideal_sharing.source
    return [
        replace(rated_quantity, reference=reference, source=source),
        replace(limit, reference=reference, source=source, note=limit_note),
        balance,
    ]


def _loss_quantities(rated: OperatingPoint) -> list[Quantity]:
    """Return friction losses by kind of pair, power of normal forces, input and output power at the rated torque [W].

    Errors are the differences from the first half of the run; kinds without friction have a note.
    """
    powers, first_half = rated.powers, rated.shorter
    quantities = []
    for kind, power in powers.friction.items():
        error, friction_note = abs(power - first_half.friction[kind]), "" if power else NO_FRICTION
        quantities.append(
            Quantity(f"{kind}_friction_power", f"friction of {kind}", power, "W", error, note=friction_note)
        )
    normal_power = sum(powers.normal.values())
    damping_note = "damping, and errors of the time step, which cancel between the pairs"
    error = abs(normal_power - sum(first_half.normal.values()))
    return [
        *quantities,
        Quantity("normal_power", "normal forces, all pairs", normal_power, "W", error, note=damping_note),
        Quantity("input_power", "input power", powers.supplied, "W"),
        Quantity("output_power", "output power", powers.delivered, "W"),
    ]


def _drag_quantities(reducer: Reducer, efficiency_map: EfficiencyMap) -> list[Quantity]:
    """Return no-load torque and back-driving torques [N m], and the efficiency of back-driving [%].

    The torques are NaN, with a note, where the reducer is self-locking. The back-driving torque from rest is also NaN
    if it does not exceed its error. `efficiency_map` has the simulated operating points.
    """
    design, driven_shaft = reducer.design, reducer.INPUT
    ratio, start_from_rest = design.reduction, efficiency_map.rest
    forward_efficiency = efficiency_map.rated.powers.efficiency
    back_point = efficiency_map.backward
    back_efficiency, back_error = (
        (0.0, 0.0) if back_point.powers.note else (back_point.powers.efficiency, back_point.shift)
    )
    is_self_locking = not back_efficiency > 0.0
    driving_torque = math.nan if is_self_locking else design.rated_torque / back_efficiency
    lock_note = f"{SELF_LOCKING} against {design.drive.torque:g} N m on the {driven_shaft}"
    contact_note = f"contacts, {drag_assumption(reducer)}; the bearings of the shafts are neglected"
    unloaded_point, coasting = efficiency_map.unloaded, efficiency_map.coasting
    moving_torque, moving_error, moving_note = math.nan, None, f"{SELF_LOCKING} with no torque on the {driven_shaft}"
    if coasting is not None:
        moving_torque, moving_error, moving_note = ratio * coasting.drag, ratio * coasting.drag_shift, contact_note
    static_names = "back_driving_torque_static", f"back-driving torque from rest, {driven_shaft} free"
    static_torque = (
        (start_from_rest.torque, start_from_rest.error) if start_from_rest.exceeds_error else (math.nan, None)
    )
    moving_names = "back_driving_torque_moving", f"back-driving torque at speed, {driven_shaft} free"
    return [
        Quantity(
            "no_load_torque",
            f"no-load torque, on the {driven_shaft}",
            unloaded_point.drag,
            "N m",
            unloaded_point.drag_shift,
            note=contact_note,
        ),
        Quantity(*moving_names, moving_torque, "N m", moving_error, note=moving_note),
        Quantity(*static_names, static_torque[0], "N m", static_torque[1], note=start_from_rest.note),
        Quantity(
            "back_driving_torque_rated",
            f"output torque that drives against {design.drive.torque:g} N m on the {driven_shaft}",
            driving_torque,
            "N m",
            None if is_self_locking else driving_torque * back_error / back_efficiency,
            note=lock_note if is_self_locking else "from the efficiency of back-driving",
        ),
        Quantity(
            "back_driving_efficiency",
            "efficiency of back-driving, against the nominal torque",
            1e2 * back_efficiency,
            "%",
            1e2 * back_error,
            1e2 * (2.0 - 1.0 / forward_efficiency),
            "2 - 1/eta, for equal losses in both directions; self-locking below 0",
            lock_note if is_self_locking else "",
        ),
    ]


def _tables(efficiency_map: EfficiencyMap) -> tuple[Table, ...]:
    """Return a single table, with a row per operating point: efficiency, error, and losses by kind of mating pair [%].

    `efficiency_map` has the simulated operating points.
    """
    rows: list[tuple[str | float, ...]] = []
    for point in efficiency_map.grid:
        powers = point.powers
        percentages = [
            1e2 * powers.efficiency,
            1e2 * point.shift,
            *_loss_percentages(point).values(),
            1e2 * powers.residual,
        ]
        rows.append((f"{point.speed / RPM:g}", point.torque, *(round(percentage, 4) for percentage in percentages)))
    header = (
        "speed [rpm]",
        "torque [N m]",
        "efficiency",
        "num. error",
        *_loss_percentages(efficiency_map.grid[0]),
        "residual",
    )
    return (Table("efficiency, and losses by pair, in % of the input power", header, tuple(rows)),)


def _loss_percentages(point: OperatingPoint) -> dict[str, float]:
    """Compute the losses of an operating point in % of its input power: friction by pair, and "normal" forces."""
    powers = point.powers
    losses = {**powers.friction, "normal": sum(powers.normal.values())}
    return {name: 1e2 * power / powers.supplied for name, power in losses.items()}


def _curves(efficiency_map: EfficiencyMap) -> tuple[Curve, ...]:
    """Return curves over the output torque: efficiency at each speed, losses at one speed, and speed of a free input.

    Losses are drawn at the design's speed, or at the last speed of the map if the map does not contain the design's
    speed. Losses that are 0 are omitted. The free crank or sun starts from rest under a growing output torque.
    """
    x_label, run_from_rest, driven_shaft = (
        "output torque [N m]",
        efficiency_map.rest.run,
        efficiency_map.rest.run.driven_shaft,
    )
    speeds = list(dict.fromkeys(point.speed for point in efficiency_map.grid))
    curves = []
    for speed in speeds:
        points = _points_at_speed(efficiency_map.grid, speed)
        efficiency = [1e2 * point.powers.efficiency for point in points]
        curves.append(_curve_over_torque("efficiency", f"{speed / RPM:g} rpm", points, efficiency, "efficiency [%]"))
    shown_speed = efficiency_map.rated.speed if efficiency_map.rated.speed in speeds else speeds[-1]
    points = _points_at_speed(efficiency_map.grid, shown_speed)
    for loss in [loss for loss, percentage in _loss_percentages(points[0]).items() if percentage]:
        percentages = [_loss_percentages(point)[loss] for point in points]
        name = "normal forces" if loss == "normal" else f"friction of {loss}"
        curves.append(
            _curve_over_torque(
                f"losses at {shown_speed / RPM:g} rpm", name, points, percentages, "share of the input [%]"
            )
        )
    torque, free_speed = np.abs(run_from_rest["load_torque"]), np.abs(run_from_rest[f"{driven_shaft}_speed"])
    panel = f"from rest with free {driven_shaft} under growing output torque"
    return (*curves, Curve(panel, "", torque, free_speed, x_label, f"{driven_shaft} [rad/s]"))


def _points_at_speed(grid: Sequence[OperatingPoint], speed: float) -> list[OperatingPoint]:
    return sorted((point for point in grid if point.speed == speed), key=lambda point: point.torque)


def _curve_over_torque(
    panel: str, name: str, points: Sequence[OperatingPoint], values: Sequence[float], label: str
) -> Curve:
    """Return a curve of values, one per operating point, over the output torque [N m]."""
    style = "line" if len(points) > 1 else "points"
    torques = np.array([point.torque for point in points])
    return Curve(panel, name, torques, np.array(values), "output torque [N m]", label, style)


def _assumptions(reducer: Reducer, periods: int) -> tuple[str, ...]:
    """Return the assumptions of an efficiency measurement by simulation, a sentence each.

    They are about friction, contact stiffness, averaging and numerical errors of the runs. `periods` is the number of
    mesh periods of the averages.
    """
    kinds = reducer.mechanism.kinds
    creep_speed = 1e3 * reducer.contacts.creep_speed
    return (
        f"{friction_assumption(reducer, kinds)}; {drag_assumption(reducer)}; the bearings of the shafts are neglected",
        "contacts of each run have the secant stiffness of its load (that of the output torque without losses); from "
        "rest that of the rated load, which is "
        f"{reducer.at_rated_load.contacts.working_forces_text(kinds)}",
        f"{periods_text(reducer, periods)} (two crank turns under loads where the weight of the discs matters); "
        f"constant speed of the {reducer.INPUT}, or of the output where the {reducer.INPUT} is free",
        f"friction rises with the sliding speed up to {creep_speed:g} mm/s under the working force, and is constant "
        "above",
        "numerical error: change with half the time step (unless --quick) or half the averaging time, whichever is "
        "larger; elsewhere with half the averaging time",
        *assumptions(reducer, "the map, and the rated point with an input varied"),
    )
