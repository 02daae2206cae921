"""Figures of the static data sheet, with friction, under the design's load or else its nominal torque."""

import math
from collections.abc import Mapping

from cycloid_mj.base.result import Quantity
from cycloid_mj.base.units import with_unit
from cycloid_mj.figures.figure import Compute, Figure, Need
from cycloid_mj.figures.sampled import BACKLASH, TOUCH
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.statics.balance import powers
from cycloid_mj.statics.sheet import sheet_part
from cycloid_mj.statics.sheet_figures import SHEET_FIGURES, SheetFigure, SheetPart

CREEP_SHARE = 1e-3
"""Speed over that of the design at which the discs' centrifugal force vanishes."""


@once
def quantities(reducer: Reducer, part: SheetPart) -> Mapping[str, Quantity]:
    """Compute a part of the sheet, once for all its figures."""
    return sheet_part(reducer, part)


def _figure(row: SheetFigure) -> Figure:
    """Return the row of a figure of the sheet; other keys are that of the sheet and that with the unit."""
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


OF_STATICS = tuple(map(_figure, SHEET_FIGURES.values()))


def no_load_torque(reducer: Reducer) -> float:
    """Compute the mean torque on the crank without load at the design's speed [N m]; errors as `powers`.

    The load is `TOUCH` of the nominal torque: without one the parts have no defined position within the clearances.
    """
    design = reducer.design
    return powers(reducer, TOUCH * design.rated_torque).lost / abs(design.drive.speed)


def starting_torque(reducer: Reducer) -> float:
    """Compute the mean torque on the crank from rest without load [N m], as that at a creep speed; errors as `powers`.

    It includes weight and seals, but no centrifugal forces.
    """
    return no_load_torque(reducer.but(drive={"speed": CREEP_SHARE * reducer.design.drive.speed}))


def back_driving_torque(reducer: Reducer) -> float:
    """Compute the torque on the output that turns a free crank slowly [N m]; NaN if the reducer is self-locking.

    It solves T w/i = L(T) by secants, with the losses L, the crank's speed w and the ratio i; errors as `powers`.
    """
    creeping = reducer.but(drive={"speed": CREEP_SHARE * reducer.design.drive.speed})
    arm = reducer.design.reduction / abs(creeping.design.drive.speed)
    least = torque = TOUCH * reducer.design.rated_torque
    for _ in range(4):
        near, far = (arm * powers(creeping, -load).lost for load in (torque, 2.0 * torque))
        share = (far - near) / torque
        if share >= 1.0:
            return math.nan
        driven = max(near - share * torque, 0.0) / (1.0 - share)
        if driven <= least:
            return driven
        torque = driven
    return torque


def _of_balance(key: str, name: str, function: Compute, definition: str) -> Figure:
    """Return the row of a torque [N m] that is not in the sheet."""
    return Figure(key=key, name=name, unit="N m", definition=definition, need=Need.STATICS, function=function)


# fmt: off
OF_BALANCE = (
    _of_balance("starting_torque_nm", "starting torque on the crank", starting_torque,
                "Torque on the crank that starts it without load, mean over a turn: weight of the discs, and drag of "
                "seals and lubricant, without shaft bearings."),
    _of_balance("back_driving_torque_free_nm", "back-driving torque, crank free", back_driving_torque,
                "Torque on the output that slowly turns a crank without load, mean over a turn; none if the reducer is "
                "self-locking."),
    _of_balance("no_load_torque_nm", "no-load torque on the crank", no_load_torque,
                "Torque on the crank without load at the design's speed, mean over a turn: weight and centrifugal "
                "force of the discs, and drag of seals and lubricant, without shaft bearings."),
)
# fmt: on
"""Figures of static equilibrium that are not in the sheet."""
