"""Figures of the static data sheet, with friction, under the design's load or else its nominal torque."""

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Literal

from cycloid_mj.base.result import Quantity
from cycloid_mj.base.units import with_unit
from cycloid_mj.figures.figure import Figure, Need
from cycloid_mj.figures.sampled import BACKLASH, TOUCH, Sampled
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.statics.balance import powers
from cycloid_mj.statics.bearings import BEARINGS
from cycloid_mj.statics.load_tracking import INERTIA_SHARE
from cycloid_mj.statics.sheet import CASES, DIRECTIONS, PARTS, SHAFTS, sheet_part

SheetPart = Literal["motions", "errors", "loads", "losses"]

KINDS = {
    "pin_gear": "disc on a ring pin",
    "pin_socket": "ring pin in its socket",
    "pin_sleeve": "sleeve on its ring pin",
    "tooth": "disc on a lobe of the ring",
    "cam": "cam in the bore of its disc",
    "output": "output pin in a hole",
}
"""Kinds of contacts, in words."""

MAX_DISCS = 4
"""Largest number of discs of a design."""

CREEP_SHARE = 1e-3
"""Speed over that of the design at which the discs' centrifugal force vanishes."""

BACK_DRIVING_ITERATIONS, SECANT_FACTOR = 4, 2.0
"""Secant steps for the torque that drives a free crank, and the factor between the two torques of a secant."""

_IDEAL = "without friction and weight, at a locked crank: mean over a turn"
_LOADED = "under the load, with friction, over a turn of the crank"


def _has_springs(reducer: Reducer) -> bool:
    return reducer.design.structure == "springs"


def _has_several_discs(reducer: Reducer) -> bool:
    return reducer.design.gear.discs > 1


def _has_two_output_discs(reducer: Reducer) -> bool:
    return _has_several_discs(reducer) and reducer.design.output.support == "both_ends"


def _has(kind: str) -> Callable[[Reducer], bool]:
    return lambda reducer: kind in reducer.design.pair_kinds


def _has_disc(number: int) -> Callable[[Reducer], bool]:
    return lambda reducer: reducer.design.gear.discs >= max(number, 2)


@once
def quantities(reducer: Reducer, part: SheetPart) -> Mapping[str, Quantity]:
    """Compute a part of the sheet, once for all its figures."""
    return sheet_part(reducer, part)


def _figure(
    part: SheetPart,
    of_sheet: str,
    unit: str,
    name: str,
    definition: str,
    key: str = "",
    exists: Callable[[Reducer], bool] = lambda _: True,
    sampled: Sampled | None = None,
) -> Figure:
    """Return the row of a figure that the sheet has under the key `of_sheet`."""
    column = with_unit(of_sheet, unit)
    key = key or column
    return Figure(
        key=key,
        name=name,
        unit=unit,
        definition=definition,
        need=Need.STATICS,
        function=lambda reducer: quantities(reducer, part)[of_sheet].value,
        sampled=sampled,
        aliases=tuple(
            dict.fromkeys(alias for alias in (of_sheet, column, column.replace("_per_", "_")) if alias != key)
        ),
        exists=exists,
    )


def _motions() -> Iterator[Figure]:
    """Yield backlash, lost motion, stiffness and compliances."""
    yield _figure(
        "motions",
        "backlash",
        "arcmin",
        "backlash of the output, mean",
        "Turn of the output from stop to stop at a locked crank under a vanishing torque: mean over a turn, without "
        "friction and weight.",
        sampled=BACKLASH,
    )
    for end, word in (("min", "smallest"), ("max", "largest")):
        words = f"{word.capitalize()} turn of the output from stop to stop over the crank angle, as `backlash_arcmin`."
        yield _figure("motions", f"backlash_{end}", "arcmin", f"backlash, {word} over the crank angle", words)
    yield _figure(
        "motions",
        "lost_motion_ideal",
        "arcmin",
        "lost motion at +-3 % of the load",
        f"Turn of the output between -3 and 3 % of the load, {_IDEAL}.",
        "lost_motion_arcmin",
    )
    yield _figure(
        "motions",
        "stiffness_ideal",
        "N m/arcmin",
        "torsional stiffness, 50 to 100 % of the load",
        f"Torque over the turn of the output from 50 to 100 % of the load, {_IDEAL}.",
        "stiffness_nm_per_arcmin",
    )
    yield _figure(
        "motions",
        "stiffness_contacts",
        "N m/arcmin",
        "torsional stiffness of the contacts only",
        f"Torque over the turn of the output from 50 to 100 % of the load with rigid parts, {_IDEAL}.",
        "stiffness_contacts_nm_per_arcmin",
        _has_springs,
    )
    for part, words in PARTS.items():
        yield _figure(
            "motions",
            f"compliance_{part}",
            "arcmin/(N m)",
            f"compliance of {words}, in series",
            f"Turn of the output per torque by the compliance of {words} only, {_IDEAL}.",
            f"compliance_{part}_arcmin_per_nm",
            exists=(lambda _: True) if part in ("output", "cam", "mesh") else _has_springs,
        )


def _errors() -> Iterator[Figure]:
    """Yield the transmission errors."""
    for shaft in SHAFTS:
        prefix = "" if shaft == "output" else f"{shaft}_"
        for case in CASES:
            for direction in DIRECTIONS:
                under = f"{case}, {direction}, with friction, over a turn of the crank"
                about = f"of the {shaft}'s angle about the ideal one, {under}."
                end = f"{case}_{direction}"
                yield _figure(
                    "errors",
                    f"{shaft}_peak_to_peak_{end}_speed",
                    "arcsec",
                    f"transmission error, peak to peak, {shaft}, {case}, {direction}",
                    f"Range {about}",
                    f"{prefix}te_{end}_arcsec",
                )
                yield _figure(
                    "errors",
                    f"{shaft}_rms_{end}_speed",
                    "arcsec",
                    f"transmission error, rms about its mean, {shaft}, {case}, {direction}",
                    f"Standard deviation {about}",
                    f"{prefix}te_rms_{end}_arcsec",
                )
        yield _figure(
            "errors",
            f"{shaft}_reversal",
            "arcsec",
            f"mean of the {shaft}, forward minus reverse, unloaded",
            f"Mean angle of the {shaft} forward minus that in reverse, unloaded, with friction.",
        )
        yield _figure(
            "errors",
            f"{shaft}_wind_up",
            "arcsec",
            f"mean of the {shaft}, loaded minus unloaded, forward",
            f"Mean angle of the {shaft} under the load minus that under 1 % of it, forward, with friction.",
        )

    yield _figure(
        "errors",
        INERTIA_SHARE,
        "1",
        "inertia torque of the load if it followed that error, over the load",
        "Inertia of what turns with the output times the second derivative of its loaded transmission error, forward, "
        "at the design's speed, over the load: rms over a turn; from 0.1 on runs differ from statics.",
    )


def _loads() -> Iterator[Figure]:
    """Yield load shares, forces, pressures and capacities."""
    for number in range(1, MAX_DISCS + 1):
        yield _figure(
            "loads",
            f"disc_{number}_share",
            "1",
            f"share of disc {number} in the torque",
            f"Mean share of disc {number} in the torque on the output {_LOADED}.",
            exists=_has_disc(number),
        )
    for kind, words in KINDS.items():
        for end, unit, name, definition in (
            ("peak_force", "N", "largest force", f"Largest normal force, {words}, {_LOADED}."),
            ("mean_force", "N", "mean force of the loaded contacts", f"Mean normal force, {words}, {_LOADED}."),
            ("carrying", "1", "loaded contacts, mean number", f"Number of loaded contacts, {words}, {_LOADED}: mean."),
            ("pressure", "MPa", "largest Hertz pressure", f"Largest Hertz pressure, {words}, {_LOADED}."),
            ("margin", "1", "margin against first yield", f"Pressure of first yield over the largest, {words}."),
        ):
            yield _figure("loads", f"{kind}_{end}", unit, f"{kind}: {name}", definition, exists=_has(kind))
    for member in ("shaft", "output", "ring"):
        for end, unit, name in (("net_force", "N", "net force"), ("tilting_moment", "N m", "tilting moment")):
            yield _figure(
                "loads",
                f"{member}_{end}",
                unit,
                f"{name} of the discs on the {member}, largest",
                f"Largest {name} of all discs together on the {member} {_LOADED}.",
                exists=_has_several_discs,
            )
    for key, words in BEARINGS.items():
        yield _figure(
            "loads",
            f"{key}_force",
            "N",
            f"{words}: largest force",
            f"Largest force of the {words} from the discs' forces {_LOADED}.",
            exists=_has_two_output_discs if key.startswith("output") else _has_several_discs,
        )
    yield _figure(
        "loads",
        "capacity",
        "N m",
        "capacity: torque at which a contact first yields, below its surface",
        "Torque on the output at which the first contact yields below its surface.",
    )
    yield _figure(
        "loads",
        "capacity_shakedown",
        "N m",
        "shakedown limit: largest torque with elastic repeated rolling",
        "Torque on the output at which the first contact reaches the shakedown limit of rolling.",
    )


def _losses() -> Iterator[Figure]:
    """Yield efficiencies and losses."""
    yield _figure(
        "losses",
        "efficiency",
        "%",
        "efficiency",
        "Power of the output over that of the crank under the load, at the design's speed, without the bearings of "
        "shaft and output.",
    )
    for kind in ("pin_gear", "tooth", "cam", "output"):
        yield _figure(
            "losses",
            f"{kind}_friction_power",
            "W",
            f"friction of {kind}",
            f"Mean power lost to friction, {KINDS[kind]}, under the load at the design's speed.",
            exists=_has(kind),
        )
    for key, name in {
        "seals_power": "drag of seals and lubricant",
        "input_power": "input power",
        "output_power": "output power",
    }.items():
        words = f"{name[0].upper()}{name[1:]} under the load at the design's speed: mean over a turn."
        yield _figure("losses", key, "W", name, words)
    yield _figure(
        "losses",
        "back_driving_torque_rated",
        "N m",
        "output torque that drives",
        "Torque on the output that drives the crank against its share of the load; none if self-locking.",
    )
    yield _figure(
        "losses",
        "back_driving_efficiency",
        "%",
        "efficiency of back-driving",
        "Power of the crank over that of the output when the output drives against the crank's share of the load.",
    )


OF_STATICS = (*_motions(), *_errors(), *_loads(), *_losses())


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
    for _ in range(BACK_DRIVING_ITERATIONS):
        near, far = (arm * powers(creeping, -load).lost for load in (torque, SECANT_FACTOR * torque))
        share = (far - near) / ((SECANT_FACTOR - 1.0) * torque)
        if share >= 1.0:
            return math.nan
        driven = max(near - share * torque, 0.0) / (1.0 - share)
        if driven <= least:
            return driven
        torque = driven
    return torque


OF_BALANCE = (
    Figure(
        key="starting_torque_nm",
        name="starting torque on the crank",
        unit="N m",
        definition="Torque on the crank that starts it without load, mean over a turn: weight of the discs, and "
        "drag of seals and lubricant, without shaft bearings.",
        need=Need.STATICS,
        function=starting_torque,
    ),
    Figure(
        key="back_driving_torque_free_nm",
        name="back-driving torque, crank free",
        unit="N m",
        definition="Torque on the output that slowly turns a crank without load, mean over a turn; none if the reducer "
        "is self-locking.",
        need=Need.STATICS,
        function=back_driving_torque,
    ),
    Figure(
        key="no_load_torque_nm",
        name="no-load torque on the crank",
        unit="N m",
        definition="Torque on the crank without load at the design's speed, mean over a turn: weight and "
        "centrifugal force of the discs, and drag of seals and lubricant, without shaft bearings.",
        need=Need.STATICS,
        function=no_load_torque,
    ),
)
"""Figures of static equilibrium that are not in the sheet."""
