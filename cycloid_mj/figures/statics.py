"""Figures of the data sheet by statics, with friction: the load is the design's, else its nominal torque."""

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
    "pin_gear": "gear on a ring pin",
    "pin_socket": "ring pin in its socket",
    "pin_sleeve": "sleeve on its ring pin",
    "tooth": "gear on a lobe of the ring",
    "cam": "cam in the bore of its disc",
    "output": "output pin in a hole",
}
"""Kinds of contacts, in words."""

MOST_DISCS = 4

CREEPING = 1e-3
"""Of the design's speed: where the discs' centrifugal force is none."""

FREE_ROUNDS, APART = 4, 2.0
"""Straight lines of the losses that are drawn for a free crank, through two torques that differ by a factor."""

_IDEAL = "without friction and weight, at a locked crank: mean of a turn"
_LOADED = "under the load, with friction, over a turn of the crank"


def _springs(reducer: Reducer) -> bool:
    return reducer.design.structure == "springs"


def _several(reducer: Reducer) -> bool:
    return reducer.design.gear.discs > 1


def _on_both_ends(reducer: Reducer) -> bool:
    return _several(reducer) and reducer.design.output.support == "both_ends"


def _has(kind: str) -> Callable[[Reducer], bool]:
    return lambda reducer: kind in reducer.design.pair_kinds


def _has_disc(number: int) -> Callable[[Reducer], bool]:
    return lambda reducer: reducer.design.gear.discs >= max(number, 2)


@once
def quantities(reducer: Reducer, part: SheetPart) -> Mapping[str, Quantity]:
    """Compute one part of the sheet, once for all its figures."""
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
    """Make the row of a figure that stands in the sheet under the key `of_sheet`."""
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
        aliases=tuple(dict.fromkeys(one for one in (of_sheet, column, column.replace("_per_", "_")) if one != key)),
        exists=exists,
    )


def _motions() -> Iterator[Figure]:
    yield _figure(
        "motions",
        "backlash",
        "arcmin",
        "backlash of the output, mean",
        "Turn of the output from stop to stop at a locked crank, which a vanishing torque leads to: mean of a turn, "
        "without friction and weight.",
        sampled=BACKLASH,
    )
    for end, word in (("min", "least"), ("max", "largest")):
        words = f"{word.capitalize()} turn of the output from stop to stop over the crank angle, as `backlash_arcmin`."
        yield _figure("motions", f"backlash_{end}", "arcmin", f"backlash, {word} over the crank angle", words)
    yield _figure(
        "motions",
        "lost_motion_ideal",
        "arcmin",
        "lost motion at +-3 % of the load",
        f"Turn of the output between 3 % of the load to either side, {_IDEAL}.",
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
        f"Torque over the turn of the output from 50 to 100 % of the load where parts are rigid, {_IDEAL}.",
        "stiffness_contacts_nm_per_arcmin",
        _springs,
    )
    for part, words in PARTS.items():
        yield _figure(
            "motions",
            f"compliance_{part}",
            "arcmin/(N m)",
            f"compliance of {words}, in series",
            f"What the give of {words} alone adds to the turn of the output by torque, {_IDEAL}.",
            f"compliance_{part}_arcmin_per_nm",
            exists=(lambda _: True) if part in ("output", "cam", "mesh") else _springs,
        )


def _errors() -> Iterator[Figure]:
    for shaft in SHAFTS:
        prefix = "" if shaft == "output" else f"{shaft}_"
        for case in CASES:
            for way in DIRECTIONS:
                under = f"{case}, {way}, with friction, over a turn of the crank"
                about = f"of the {shaft}'s angle about the ideal one, {under}."
                end = f"{case}_{way}"
                yield _figure(
                    "errors",
                    f"{shaft}_peak_to_peak_{end}_speed",
                    "arcsec",
                    f"transmission error, peak to peak, {shaft}, {case}, {way}",
                    f"Range {about}",
                    f"{prefix}te_{end}_arcsec",
                )
                yield _figure(
                    "errors",
                    f"{shaft}_rms_{end}_speed",
                    "arcsec",
                    f"transmission error, rms about its mean, {shaft}, {case}, {way}",
                    f"Standard deviation {about}",
                    f"{prefix}te_rms_{end}_arcsec",
                )
        yield _figure(
            "errors",
            f"{shaft}_reversal",
            "arcsec",
            f"mean of the {shaft}, forward less reverse, unloaded",
            f"Mean angle of the {shaft} forward less that in reverse, unloaded, with friction.",
        )
        yield _figure(
            "errors",
            f"{shaft}_wind_up",
            "arcsec",
            f"mean of the {shaft}, loaded less unloaded, forward",
            f"Mean angle of the {shaft} under the load less that under 1 % of it, forward, with friction.",
        )

    yield _figure(
        "errors",
        INERTIA_SHARE,
        "1",
        "inertia torque of the load, were it to follow the loaded error, over the load",
        "Inertia of what turns with the output times the second derivative of its loaded transmission error, forward, "
        "at the design's speed, over the load: rms of a turn; from 0.1 on runs depart from statics.",
    )


def _loads() -> Iterator[Figure]:
    for number in range(1, MOST_DISCS + 1):
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
            ("carrying", "1", "loaded contacts, mean number", f"Contacts that carry, {words}, {_LOADED}: mean."),
            ("pressure", "MPa", "largest Hertz pressure", f"Largest pressure by Hertz, {words}, {_LOADED}."),
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
                exists=_several,
            )
    for key, words in BEARINGS.items():
        yield _figure(
            "loads",
            f"{key}_force",
            "N",
            f"{words}: largest force",
            f"Largest force of the {words} from the discs' forces {_LOADED}.",
            exists=_on_both_ends if key.startswith("output") else _several,
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
            f"Mean power that friction takes, {KINDS[kind]}, under the load at the design's speed.",
            exists=_has(kind),
        )
    for key, name in {
        "seals_power": "drag of seals and lubricant",
        "input_power": "input power",
        "output_power": "output power",
    }.items():
        words = f"{name[0].upper()}{name[1:]} under the load at the design's speed: mean of a turn."
        yield _figure("losses", key, "W", name, words)
    yield _figure(
        "losses",
        "back_driving_torque_rated",
        "N m",
        "output torque that drives",
        "Torque on the output that drives the crank against its share of the load; none if it locks itself.",
    )
    yield _figure(
        "losses",
        "back_driving_efficiency",
        "%",
        "efficiency of back-driving",
        "Power of the crank over that of the output where the output drives against the crank's share of the load.",
    )


OF_STATICS = (*_motions(), *_errors(), *_loads(), *_losses())


def no_load_torque(reducer: Reducer) -> float:
    """Compute the mean torque on the crank [N m] that turns a reducer without a load at its speed; errors as `powers`.

    The load is `TOUCH` of the nominal torque: without any, nothing says on which side of the play the parts are.
    """
    design = reducer.design
    return powers(reducer, TOUCH * design.rated_torque).lost / abs(design.drive.speed)


def starting_torque(reducer: Reducer) -> float:
    """Compute the mean torque on the crank [N m] that turns a reducer from rest without a load: at a creeping speed.

    Weight and seals are left then, the centrifugal force of the discs is not; errors as `powers`.
    """
    return no_load_torque(reducer.but(drive={"speed": CREEPING * reducer.design.drive.speed}))


def back_driving_torque(reducer: Reducer) -> float:
    """Compute the torque on the output [N m] from which it turns a free crank slowly; NaN where it locks itself.

    Losses are straight lines of the load: where T w/i = L(T), with the crank's speed w and the ratio i; errors as
    `powers`.
    """
    creeping = reducer.but(drive={"speed": CREEPING * reducer.design.drive.speed})
    arm = reducer.design.reduction / abs(creeping.design.drive.speed)
    least = torque = TOUCH * reducer.design.rated_torque
    for _ in range(FREE_ROUNDS):
        near, far = (arm * powers(creeping, -load).lost for load in (torque, APART * torque))
        share = (far - near) / ((APART - 1.0) * torque)
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
        definition="Torque on the crank from which it turns without a load, mean of a turn: weight of the discs, and "
        "drag of seals and lubricant, without shaft bearings.",
        need=Need.STATICS,
        function=starting_torque,
    ),
    Figure(
        key="back_driving_torque_free_nm",
        name="back-driving torque, crank free",
        unit="N m",
        definition="Torque on the output from which it turns a crank without a load, slowly, mean of a turn; none if "
        "it locks itself.",
        need=Need.STATICS,
        function=back_driving_torque,
    ),
    Figure(
        key="no_load_torque_nm",
        name="no-load torque on the crank",
        unit="N m",
        definition="Torque on the crank that turns it without a load at the design's speed, mean of a turn: weight and "
        "centrifugal force of the discs, and drag of seals and lubricant, without shaft bearings.",
        need=Need.STATICS,
        function=no_load_torque,
    ),
)
"""Figures of the balance that the sheet has not."""
