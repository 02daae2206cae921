"""Figures of the static data sheet, with friction, under the design's load or else its nominal torque."""

import math
from collections.abc import Callable, Mapping

from cycloid_mj.base.result import Quantity
from cycloid_mj.base.units import with_unit
from cycloid_mj.design.layouts import BOTH, CENTRAL, Layout
from cycloid_mj.figures.figure import Compute, Figure, Need
from cycloid_mj.figures.sampled import BACKLASH, TOUCH
from cycloid_mj.reducer import Reducer, RvReducer, once
from cycloid_mj.statics.film_spread import SAMPLES, Spread, compute_spread, sample_inputs
from cycloid_mj.statics.sheet import sampled_losses, shaft_powers, sheet_part
from cycloid_mj.statics.sheet_figures import SHEET_FIGURES, SheetFigure, SheetPart

MAX_SECANT_STEPS = 4
"""Most secant steps for the back-driving torque, whose drag is nearly linear in the torque."""

CREEP_SHARE = 1e-3
"""Speed over that of the design at which the discs' centrifugal force vanishes."""


@once
def quantities(reducer: Reducer, part: SheetPart) -> Mapping[str, Quantity]:
    """Compute a part of the static sheet, by its keys, once for all of its quantities."""
    return sheet_part(reducer, part)


def _make_entry(row: SheetFigure) -> Figure:
    """Return the catalogue entry (`Figure`) of a quantity of the static data sheet, which `row` describes.

    Its aliases are the key of the data sheet, without and with the unit.
    """
    column = with_unit(row.key, row.unit)
    key = row.catalogue_key or column
    aliases = dict.fromkeys((row.key, column, column.replace("_per_", "_")))
    return Figure(
        key=key,
        name=row.name,
        unit=row.unit,
        definition=row.definition,
        need=Need.STATICS,
        function=lambda reducer: quantities(reducer, row.part)[row.key].value,
        sampled=BACKLASH if row.key == "backlash" else None,
        aliases=tuple(alias for alias in aliases if alias != key),
        exists=row.exists,
        interval=lambda reducer: quantities(reducer, row.part)[row.key],
        layouts=row.layouts,
    )


OF_STATICS = tuple(map(_make_entry, SHEET_FIGURES.values()))


def no_load_torque(reducer: Reducer) -> float:
    """Compute the mean torque on the crank without load at the design's speed [N m].

    The load is `TOUCH` of the nominal torque: without a load the parts have no defined position within the clearances.
    Raises the errors of `shaft_powers`.
    """
    return shaft_powers(reducer, TOUCH * reducer.design.rated_torque).lost / abs(reducer.design.drive.speed)


def starting_torque(reducer: Reducer) -> float:
    """Compute the mean torque on the crank from rest without load [N m]; errors as `powers`.

    It is the torque at a creep speed, with weight and seals, but without centrifugal forces.
    """
    return no_load_torque(_at_creep_speed(reducer))


def back_driving_torque(reducer: Reducer) -> float:
    """Compute the torque on the output that turns a free crank slowly [N m]; NaN if the reducer is self-locking.

    The torque T covers the losses: T w/i = L(-T), with the losses L [W] under a driving torque on the output, the
    crank's speed w and the ratio i. It is determined by at most `MAX_SECANT_STEPS` steps with the secant of the losses
    between T and 2 T. The reducer is self-locking if the losses grow at least as fast as the input power. Raises
    RunError without a static equilibrium.
    """
    creeping = _at_creep_speed(reducer)
    torque_per_power = reducer.design.reduction / abs(creeping.design.drive.speed)
    smallest_load = torque = TOUCH * reducer.design.rated_torque
    for _ in range(MAX_SECANT_STEPS):
        drag, double_drag = (torque_per_power * shaft_powers(creeping, -load).lost for load in (torque, 2.0 * torque))
        drag_slope = (double_drag - drag) / torque
        if drag_slope >= 1.0:
            return math.nan
        balanced_torque = max(drag - drag_slope * torque, 0.0) / (1.0 - drag_slope)
        if balanced_torque <= smallest_load:
            return balanced_torque
        torque = balanced_torque
    return torque


def no_load_spread(reducer: Reducer, samples: int = SAMPLES) -> Spread:
    """Compute `no_load_torque` [N m] under the friction law ``film``, with the interval of its uncertainty.

    The interval follows from random `samples` of the law's uncertain inputs. Raises RunError without a static
    equilibrium.
    """
    speed, load = abs(reducer.design.drive.speed), TOUCH * reducer.design.rated_torque
    lost_power, sample_losses = sampled_losses(reducer, load, samples)
    return compute_spread(lost_power / speed, sample_losses / speed, sample_inputs(samples)[1])


def starting_spread(reducer: Reducer, samples: int = SAMPLES) -> Spread:
    """Compute `starting_torque` [N m] under the friction law ``film``, with the interval of its uncertainty.

    Raises the errors of `shaft_powers`.
    """
    return no_load_spread(_at_creep_speed(reducer), samples)


def back_driving_spread(reducer: Reducer, samples: int = SAMPLES) -> Spread:
    """Compute `back_driving_torque` [N m] under the friction law ``film``, with the interval of its uncertainty.

    The interval follows from random `samples` of the law's uncertain inputs, whose torques are assumed to be
    proportional to their losses. Raises RunError without a static equilibrium.
    """
    torque = back_driving_torque(reducer)
    lost_power, sample_losses = sampled_losses(_at_creep_speed(reducer), TOUCH * reducer.design.rated_torque, samples)
    return compute_spread(torque, torque * sample_losses / lost_power, sample_inputs(samples)[1])


def _at_creep_speed(reducer: Reducer) -> Reducer:
    """Return the drive at a speed at which the discs' centrifugal force vanishes."""
    return reducer.but(drive={"speed": CREEP_SHARE * reducer.design.drive.speed})


def _make_torque_entry(
    key: str,
    name: str,
    function: Compute,
    spread_function: Callable[[Reducer], Spread],
    definition: str,
    layouts: tuple[Layout, ...] = BOTH,
) -> Figure:
    """Return the catalogue entry (`Figure`) of a torque [N m] that the static data sheet does not have.

    Key, name, definition and layouts are attributes of `Figure`. `function` computes the torque, `spread_function` its
    interval under the friction law ``film``. RV reducers have the quantity under this law only, because statics leaves
    out their weight.
    """

    def interval(reducer: Reducer) -> Quantity:
        """Return the torque of a reducer [N m] with its interval; NaN without the friction law ``film``."""
        if not reducer.design.has_film:
            return Quantity(key, name, math.nan, "N m")
        torque_spread = spread_function(reducer)
        return Quantity(
            key,
            name,
            torque_spread.value,
            "N m",
            low=torque_spread.low,
            high=torque_spread.high,
            causes=torque_spread.causes,
        )

    return Figure(
        key=key,
        name=name,
        unit="N m",
        definition=definition,
        need=Need.STATICS,
        function=function,
        interval=interval,
        exists=lambda reducer: reducer.design.has_film or not isinstance(reducer, RvReducer),
        layouts=layouts,
    )


# fmt: off
OF_BALANCE = (
    _make_torque_entry("starting_torque_nm", "starting torque on the crank", starting_torque, starting_spread,
                "Torque on the crank (RV reducer: on the sun) that starts it without load, mean over a turn: weight of "
                "the discs (not of RV reducers), and drag of seals and lubricant, without shaft bearings."),
    _make_torque_entry("back_driving_torque_free_nm", "back-driving torque, crank free", back_driving_torque,
                back_driving_spread,
                "Torque on the output that slowly turns a crank without load, mean over a turn; none if the reducer is "
                "self-locking.", CENTRAL),
    _make_torque_entry("no_load_torque_nm", "no-load torque on the crank", no_load_torque, no_load_spread,
                "Torque on the crank (RV reducer: on the sun) without load at the design's speed, mean over a turn: "
                "weight and centrifugal force of the discs (not of RV reducers), and drag of seals and lubricant, "
                "without shaft bearings."),
)
# fmt: on
"""Figures of static equilibrium that are not in the sheet."""
