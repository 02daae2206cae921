"""Identification of a joint's parameters from the full model by statics: play, stiffness, damping, friction, error.

Play, springs and damping are means over the crank angle with a locked crank, without friction and weight. Friction is
that of a turning crank. The transmission error is solved over a full turn of the output.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError, RunError
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.base.result import Quantity, by_key
from cycloid_mj.base.units import ARCMINUTE, RPM
from cycloid_mj.checks import require_sound
from cycloid_mj.design import Named, resolve
from cycloid_mj.figures.statics import no_load_spread
from cycloid_mj.measure import spread
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.robot.friction import FrictionMap
from cycloid_mj.robot.full_model import full_model
from cycloid_mj.robot.reducer import Level, ReducedJoint, Slip, Spring
from cycloid_mj.robot.transmission import count_parts, solve_ripple
from cycloid_mj.statics.film_spread import Spread, back_driving_efficiency_spread
from cycloid_mj.statics.locked import slip_elements
from cycloid_mj.statics.sheet import describe_self_locking, sampled_efficiency, shaft_powers, solve_back_driving
from cycloid_mj.statics.springs import POSES
from cycloid_mj.statics.windup import STRAIGHT


@dataclass(frozen=True)
class IdentificationGrid:
    """Torques, speeds and crank angles at which the full model is solved."""

    small: float = 1e-4
    """Torque that presses the parts to a stop, over the rated one; it and twice that are extrapolated to zero."""
    springs: tuple[float, ...] = (0.03, 0.15, 0.5, 1.0)
    """Shares of the nominal torque at which the springs wind up as the full model; the last slope continues."""
    polynomial: tuple[float, ...] = (0.03, 0.06, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 1.0)
    """Shares of the nominal torque to which the polynomial of the stiffness is fitted."""
    torques: tuple[float, ...] = (0.05, 0.075, 0.1, 0.125, 0.15, 0.2, 0.25, 0.35, 0.5, 0.75, 1.0, 1.5, 2.0)
    speeds: tuple[float, ...] = (0.25, 0.5, 1.0, 1.5)
    """Points of the friction map besides no load, as shares of the nominal torque and of the design's speed: dense
    where teeth with play begin to carry one after the other, and losses are not linear."""
    no_load: tuple[float, ...] = (small, 1e-3, 1e-2, 2e-2)
    """Shares of the nominal torque that represent no load: the first under which friction does not jam the parts is
    used."""
    angles_factor: int = 4
    """Number of crank angles of the means, over that of `statics`; the change between both is the numerical error."""


GRID = IdentificationGrid()


Progress = Callable[[int, int], None]


@shows_progress
def reduce(design: Named, level: Level = "full", progress: Progress | None = None) -> ReducedJoint:
    """Compute the parameters of a reduced robot joint that behaves like a reducer, by statics of the full model.

    Parameters
    ----------
    design
        A design that passes its checks, or the name of a preset or file. Its load is not used.
    level
        Level of detail in a simulation: "rigid"; "backlash", with play and springs; or "full", with load-dependent
        friction and transmission error, too. All parameters are identified at any level, stiffness at nominal torque.
    progress
        Called after each piece of work with the number of finished pieces and their total number.

    Returns
    -------
    ReducedJoint
        Ratio, backlash, springs, friction, inertia and transmission error of the joint.

    Raises
    ------
    DesignError
        The design fails a check, or its speed is 0.
    ContactError
        The contact pressure at the nominal torque is beyond Hertz's line contact.
    RunError
        No static equilibrium exists, for example because friction jams the reducer.
    """
    reducer = reducer_of(resolve(design))
    require_sound(reducer)
    if reducer.design.drive.speed == 0.0:
        raise DesignError(
            f"{reducer.design.name}: drive.speed_rpm is 0, but friction is evaluated with a turning crank: set a speed "
            "other than 0, such as 1640 rpm"
        )
    reducer = reducer.but(load={"torque": reducer.design.rated_torque}).working_at(reducer.design.rated_torque)
    counter = _ProgressCounter(progress, 2 + (1 + 2 * len(GRID.torques)) * len(GRID.speeds) + count_parts(reducer))
    fine_play, coarse_play = solve_play(reducer, GRID.angles_factor * POSES), solve_play(reducer, POSES)
    counter.count_one()
    model = full_model(reducer)
    rotor_inertia, output_inertia = model.inertias()
    joint = ReducedJoint(
        name=reducer.design.name,
        level=level,
        ratio=float(reducer.design.reduction),
        way=1 if reducer.design.ratio > 0 else -1,
        rated_torque=reducer.design.rated_torque,
        rated_speed=abs(reducer.design.drive.speed),
        stops=fine_play.stops,
        springs=fine_play.springs,
        polynomial=tuple(fine_play.polynomial.tolist()),
        polynomial_error=tuple(np.abs(fine_play.polynomial - coarse_play.polynomial).tolist()),
        damping=model.damping(),
        rotor_inertia=rotor_inertia,
        output_inertia=output_inertia,
        friction=_compute_friction_map(reducer, counter.count_one),
        ripple=solve_ripple(reducer, counter.count_one),
        slips=tuple(Slip(*slip_values) for slip_values in np.stack(slip_elements(reducer), axis=1).tolist()),
    )
    counter.count_one()
    return replace(joint.at(level), quantities=by_key(_list_quantities(reducer, joint, fine_play, coarse_play)))


@dataclass(frozen=True)
class Play:
    """Play and wind-up with a locked crank, without friction and weight; means over crank angles."""

    rated: float
    """Nominal torque [N m]."""
    stops: tuple[float, float]
    """Angles of the stops [rad], clockwise first, extrapolated to zero from two small torques."""
    wind_up: dict[float, float]
    """Turn beyond the stop [rad] by the share of the nominal torque, mean of both sides."""

    @property
    def backlash(self) -> float:
        """Angle between the stops [rad]."""
        return self.stops[1] - self.stops[0]

    @property
    def springs(self) -> tuple[Spring, ...]:
        """Return springs with dead bands in parallel that reproduce the wind-up curve at the torques `GRID.springs`.

        Beyond its dead band, each spring adds its stiffness to that of the springs before it, so that the total can
        only grow. Where the full model softens with the load, neighbouring slopes are replaced by their mean (isotonic
        regression).
        """
        from scipy.optimize import isotonic_regression

        wind_ups = np.array([0.0, *(self.wind_up[share] for share in GRID.springs)])
        torques = self.rated * np.array([0.0, *GRID.springs])
        widths = np.maximum(np.diff(wind_ups), np.finfo(float).tiny)
        slopes = isotonic_regression(np.diff(torques) / widths, weights=widths).x
        increments = np.diff(slopes, prepend=0.0)
        return tuple(
            Spring(float(start), float(stiffness))
            for start, stiffness in zip(wind_ups, increments, strict=False)
            if stiffness > 0.0
        )

    @property
    def stiffness(self) -> float:
        """Slope of the straight part [N m/rad]."""
        low, high = STRAIGHT
        return (high - low) * self.rated / (self.wind_up[high] - self.wind_up[low])

    @property
    def polynomial(self) -> Array:
        """Return coefficients a, b, c of the torque a x + b x^2 + c x^3 at the angle x [rad] beyond the stop, (3,).

        Their units are N m/rad, N m/rad^2 and N m/rad^3. The relative error at the torques of `GRID.polynomial`, up to
        the nominal torque, is minimised by least squares.
        """
        wind_ups, torques = (
            np.array([self.wind_up[share] for share in GRID.polynomial]),
            self.rated * np.array(GRID.polynomial),
        )
        relative = wind_ups / wind_ups[-1]
        powers = np.stack([relative, relative**2, relative**3], axis=1) / torques[:, np.newaxis]
        coefficients = np.linalg.lstsq(powers, np.ones(len(wind_ups)))[0]
        return np.asarray(coefficients / wind_ups[-1] ** np.arange(1, 4))

    def polynomial_error(self) -> float:
        """Largest relative error of the polynomial's torque at `GRID.polynomial`."""
        a, b, c = self.polynomial.tolist()
        pairs = [(self.wind_up[share], share * self.rated) for share in GRID.polynomial]
        return max(abs((a * x + b * x**2 + c * x**3) / torque - 1.0) for x, torque in pairs)


def solve_play(reducer: Reducer, poses: int) -> Play:
    """Compute play and wind-up of a reducer in static equilibrium with a locked crank.

    Both are rotations of the output [rad], means over `poses` evenly spaced crank angles. The wind-up is that at
    several shares of the nominal torque. Raises RunError if there is no equilibrium.
    """
    rated_torque = reducer.design.rated_torque
    locked_rotation = full_model(reducer).locked_rotation(poses)

    def mean_output_angle(share: float) -> float:
        """Compute the mean rotation of the output [rad] under a share of the nominal torque."""
        return locked_rotation(share * rated_torque)

    lower_stop, upper_stop = (
        2.0 * mean_output_angle(sign * GRID.small) - mean_output_angle(2.0 * sign * GRID.small) for sign in (-1.0, 1.0)
    )
    if (
        lower_stop > upper_stop
    ):  # preloaded halves leave no play: both lines end in the same angle, except for their curvature
        lower_stop = upper_stop = 0.5 * (lower_stop + upper_stop)
    load_shares = sorted({*GRID.springs, *GRID.polynomial, *STRAIGHT})
    wind_up = {
        share: 0.5 * (mean_output_angle(share) - upper_stop + lower_stop - mean_output_angle(-share))
        for share in load_shares
    }
    return Play(rated_torque, (lower_stop, upper_stop), wind_up)


def _compute_friction_map(reducer: Reducer, on_step: Callable[[], None]) -> FrictionMap:
    """Compute the friction torques on the crank [N m] over a grid of output torques and crank speeds, `GRID`.

    The map has a table for a driving crank and one for a driving output. `on_step` is called after each computed
    torque. Raises RunError where the crank cannot turn against a load.
    """
    speed, rated_torque = reducer.design.drive.speed, reducer.design.rated_torque
    rows_by_sign: dict[float, list[tuple[float, ...]]] = {1.0: [], -1.0: []}
    for share in GRID.speeds:
        reducer_at_speed = reducer.but(drive={"speed": share * speed})
        no_load_torque = _compute_no_load_torque(reducer_at_speed)
        on_step()
        for sign, rows in rows_by_sign.items():
            rows.append(
                (
                    no_load_torque,
                    *(
                        _compute_friction_torque(reducer_at_speed, sign * share_of_torque * rated_torque, on_step)
                        for share_of_torque in GRID.torques
                    ),
                )
            )
    torques = (0.0, *(torque * rated_torque for torque in GRID.torques))
    speeds = tuple(share * abs(speed) for share in GRID.speeds)
    return FrictionMap(torques, speeds, tuple(rows_by_sign[1.0]), tuple(rows_by_sign[-1.0]))


def _compute_no_load_torque(reducer: Reducer) -> float:
    """Compute the friction torque on the crank without a load [N m].

    It is the friction torque at the first output torque of `GRID.no_load` that has a static equilibrium. If this is not
    the smallest torque, the result is extrapolated linearly to zero torque, but not below 0. The result is 0 if
    friction jams the parts at all of these torques.
    """
    rated_torque = reducer.design.rated_torque
    for torque in GRID.no_load:
        with suppress(RunError):
            friction_torque = _compute_friction_torque(reducer, torque * rated_torque)
            if torque == GRID.small:
                return friction_torque
            return max(
                0.0,
                _extrapolate_to_zero(
                    (torque, friction_torque),
                    (GRID.torques[0], _compute_friction_torque(reducer, GRID.torques[0] * rated_torque)),
                ),
            )
    return 0.0


def _extrapolate_to_zero(point: tuple[float, float], farther_point: tuple[float, float]) -> float:
    """Extrapolate the line through two points (x, y) to x = 0, and return its y there."""
    (nearer_x, nearer_y), (farther_x, farther_y) = point, farther_point
    return nearer_y - (farther_y - nearer_y) * nearer_x / (farther_x - nearer_x)


def _compute_friction_torque(reducer: Reducer, torque: float, on_step: Callable[[], None] = lambda: None) -> float:
    """Compute the friction torque on a turning crank [N m] under an output torque [N m], from the power balance.

    The crank drives under a positive torque, the output under a negative one. For a self-locking reducer the result is
    that of the driving crank. `on_step` is called when the result is ready.
    """
    try:
        mean_powers = shaft_powers(reducer, torque)
    except RunError:
        if torque > 0.0:
            raise
        mean_powers = shaft_powers(reducer, -torque)
    on_step()
    return mean_powers.lost / abs(reducer.design.drive.speed)


def _list_quantities(reducer: Reducer, joint: ReducedJoint, fine: Play, coarse: Play) -> Iterator[Quantity]:
    """Yield the identified quantities of a joint with units and numerical errors, for tables and JSON.

    `fine` and `coarse` are play and wind-up, computed with many and with fewer crank angles; their difference is the
    numerical error.
    """
    model = full_model(reducer)
    rated_torque = joint.rated_torque

    def value_and_error(quantity_of: Callable[[Play], float]) -> tuple[float, float]:
        """Return a quantity of the fine play, and its difference to the coarse play."""
        return quantity_of(fine), abs(quantity_of(fine) - quantity_of(coarse))

    direction = "the output turns against the crank" if joint.way < 0 else "the output turns as the crank does"
    yield Quantity("ratio", "ratio, turns of the crank for one of the output", joint.ratio, "1", 0.0, note=direction)
    play, wind_up = (
        value_and_error(lambda solution: solution.backlash),
        value_and_error(lambda solution: solution.wind_up[1.0]),
    )
    name = "backlash of the output, mean over the crank angle"
    yield Quantity("backlash_arcmin", name, *_convert_with_error(play, ARCMINUTE, "arcmin"))
    name = f"wind-up beyond the stop under {rated_torque:.4g} N m, crank locked"
    yield Quantity("wind_up_arcmin", name, *_convert_with_error(wind_up, ARCMINUTE, "arcmin"))
    name = f"largest relative error of the stiffness as a polynomial, up to {rated_torque:.4g} N m"
    yield Quantity("polynomial_error", name, *_convert_with_error(value_and_error(Play.polynomial_error), 1.0, "1"))
    name = "torsional stiffness, 50 to 100 % of the nominal torque"
    stiffness = value_and_error(lambda solution: solution.stiffness)
    yield Quantity("stiffness_nm_per_arcmin", name, *_convert_with_error(stiffness, 1.0 / ARCMINUTE, "N m/arcmin"))
    yield from _list_friction(reducer, joint, model.no_load_note)
    name = f"inertia on the crank: {model.crank_parts}"
    yield Quantity("rotor_inertia_kg_m2", name, joint.rotor_inertia, "kg m2", 0.0)
    yield Quantity("output_inertia_kg_m2", "inertia of discs and output", joint.output_inertia, "kg m2", 0.0)
    name = "inertia at the output, crank free"
    yield Quantity("reflected_inertia_kg_m2", name, joint.reflected_inertia, "kg m2", 0.0)
    yield Quantity("damping_nm_s_per_rad", "damping of the wind-up", joint.damping, "N m s/rad", None)


def _list_friction(reducer: Reducer, joint: ReducedJoint, no_load_note: str) -> Iterator[Quantity]:
    """Yield both efficiencies [%] and the no-load torque [N m] of a joint, with intervals under film friction.

    `no_load_note` names the causes of friction without load.
    """
    friction, torque, speed = joint.friction, joint.rated_torque, joint.rated_speed
    efficiency = 100.0 * friction.efficiency(torque, speed, joint.ratio, driving=True)
    error, spread_note = 100.0 * _efficiency_error(reducer, 1.0), _describe_efficiency_spread(reducer)
    name = f"efficiency at {torque:.4g} N m, {speed / RPM:.0f} rpm"
    row = Quantity("efficiency", name, efficiency, "%", error, note=spread_note)
    yield _add_film_interval(row, reducer, sampled_efficiency, torque)
    powers, driving_torque = solve_back_driving(reducer, torque)
    key, name = (
        "back_driving_efficiency",
        f"efficiency of back-driving against {torque / joint.ratio:.4g} N m on the crank",
    )
    if math.isnan(driving_torque):
        yield Quantity(key, name, 0.0, "%", 0.0, note=describe_self_locking(reducer, torque))
    else:
        error = 100.0 * _efficiency_error(reducer, -driving_torque / torque)
        row = Quantity(key, name, 100.0 * powers.efficiency, "%", error)
        if not isinstance(reducer, RvReducer):
            row = _add_film_interval(row, reducer, back_driving_efficiency_spread, driving_torque)
        yield row
    first_point, second_point = ((load, friction.torque(load, speed, driving=True)) for load in friction.torques[1:3])
    error = abs(joint.no_load_torque - max(0.0, _extrapolate_to_zero(first_point, second_point)))
    name = f"no-load torque on the crank at {speed / RPM:.0f} rpm"
    row = Quantity("no_load_torque_nm", name, joint.no_load_torque, "N m", error, note=no_load_note)
    yield _add_film_interval(row, reducer, no_load_spread)


def _add_film_interval(
    quantity: Quantity, reducer: Reducer, compute: Callable[..., Spread], *arguments: float
) -> Quantity:
    """Add the 5 to 95 % interval under film friction to a `quantity`; return it unchanged under Coulomb friction.

    `compute` is a function of the `reducer` and the `arguments` that returns this interval.
    """
    if not reducer.design.has_film:
        return quantity
    interval = compute(reducer, *arguments)
    return replace(quantity, low=interval.low, high=interval.high, causes=interval.causes)


def _describe_efficiency_spread(reducer: Reducer) -> str:
    """Describe the friction law, and by how much the efficiency changes if assumed inputs are varied one at a time.

    Under film friction only the law is described, because the efficiency then has an interval (`_add_film_interval`).
    """
    if reducer.design.has_film:
        return reducer.design.condition_words

    def efficiency_of(varied_reducer: Reducer) -> float:
        try:
            return shaft_powers(varied_reducer, reducer.design.rated_torque).efficiency
        except RunError:
            return 0.0

    assumed_inputs = spread.assumed_inputs(reducer)
    return f"{reducer.design.condition_words}; " + spread.spread_text(
        efficiency_of(reducer),
        spread.input_effects(
            assumed_inputs,
            {
                end_design: efficiency_of(reducer_of(end_design))
                for assumed_input in assumed_inputs
                for end_design in assumed_input.ends
            },
        ),
    )


def _efficiency_error(reducer: Reducer, share: float) -> float:
    """Estimate the numerical error of the efficiency [1] as its change when more crank angles are used.

    Their number is multiplied by `GRID.angles_factor`. `share` is the output torque relative to the nominal torque,
    negative if the output drives.
    """
    coarse_powers, fine_powers = (
        shaft_powers(reducer, share * reducer.design.rated_torque, poses)
        for poses in (POSES, GRID.angles_factor * POSES)
    )
    return abs(coarse_powers.efficiency - fine_powers.efficiency)


def _convert_with_error(values: Sequence[float], unit: float, name: str) -> tuple[float, str, float]:
    """Return value, unit and error of a quantity in another unit."""
    value, error = values
    return value / unit, name, error / unit


class _ProgressCounter:
    """Counter of finished pieces of work, for a progress."""

    def __init__(self, progress: Progress | None, total: int) -> None:
        self._progress, self._total, self._done = progress, total, 0

    def count_one(self) -> None:
        self._done += 1
        if self._progress:
            self._progress(self._done, self._total)
