"""Data-sheet figures of a reducer by statics, under the same keys as those of the measures."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, Literal, NamedTuple

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError, UsageError, warn
from cycloid_mj.base.frame import Frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.powers import Powers
from cycloid_mj.base.result import Quantity, by_key, quantity_frame
from cycloid_mj.base.statistics import peak_to_peak, rms_about_mean
from cycloid_mj.base.units import ARCMINUTE, ARCSECOND, RPM
from cycloid_mj.design.layouts import Layout
from cycloid_mj.design.materials import SHAKEDOWN_PRESSURE, YIELD_PRESSURE
from cycloid_mj.geometry.measured import part_notes
from cycloid_mj.reducer import Reducer, RvReducer, once
from cycloid_mj.statics import rv_sheet
from cycloid_mj.statics.balance import Loads, loads, powers
from cycloid_mj.statics.bearings import Planes, Reactions, compute_reactions
from cycloid_mj.statics.film import film_assumption, film_text
from cycloid_mj.statics.film_spread import (
    SAMPLES,
    Spread,
    back_driving_efficiency_spread,
    compute_spread,
    lost_powers,
    sample_inputs,
)
from cycloid_mj.statics.ideal import ideal_peak
from cycloid_mj.statics.kernel import CARRYING_SHARE
from cycloid_mj.statics.load_tracking import inertia_share, tracking_warnings
from cycloid_mj.statics.peaks import forces, is_hertzian, peak_force, peak_pressure, torque_at_pressure
from cycloid_mj.statics.sheet_figures import (
    BEARINGS,
    CASES,
    DIRECTIONS,
    INERTIA_SHARE,
    SheetPart,
    sheet_quantity,
    spread_quantity,
)
from cycloid_mj.statics.springs import POSES, Springs, at_rest, springs_of, turn_evenly
from cycloid_mj.statics.stops import stop_width
from cycloid_mj.statics.structure import structure_text, twisting_compliance
from cycloid_mj.statics.windup import SPRINGS, Windup, solve_windups

Part = Callable[[Reducer, float], Iterator[Quantity]]
"""A function that yields some figures of a design under a load [N m]."""


@dataclass(frozen=True)
class SheetSettings:
    """Settings of the figures of a sheet."""

    stop_torque_share: float = 1e-4
    """Torque that moves the parts to their stops, over the larger of load and nominal torque.

    Under less, deflections are within the rounding of the gaps. The stop is extrapolated linearly from this torque and
    twice this torque to zero.
    """
    angles_per_mesh_period: int = 8
    """Crank angles per mesh period for the transmission error."""
    angles_of_several_discs: int = 241
    """Crank angles for the forces of several discs: peaks are within 0.1 % of those of a full turn."""


SETTINGS = SheetSettings()

SEVERAL = (
    "each disc acts in its own plane and does not tilt; a moving ring pin deflects under each disc as if it carried "
    "that disc only; bearing forces are those of the discs, without weight and unbalance of other parts"
)

LoadSource = Literal["given", "load.torque_nm", "rated torque"]
"""Origin of the load of a sheet."""

CONFORMAL = "none: the surfaces are conformal, so the contact is not a narrow strip"
UNLOADED = "none: the output has no load"

LIMITS = {"capacity": YIELD_PRESSURE, "capacity_shakedown": SHAKEDOWN_PRESSURE}
"""Key of a torque limit -> its contact pressure over the tensile strength."""

KNOWN_DIFFERENCES = {
    "backlash": 0.001,
    "lost_motion_ideal": 0.004,
    "stiffness_ideal": 0.002,
    "output_peak_to_peak_loaded_forward_speed": 0.04,
    "efficiency": 0.001,
    "back_driving_efficiency": 0.0015,
    "capacity": 0.012,
    "capacity_shakedown": 0.015,
}
KNOWN_DIFFERENCES_OF_KINDS = {"peak_force": 0.01, "pressure": 0.005}
"""Largest relative differences from dynamic runs, by key, and by the end of the key for each kind of mating pair.

They are those of pin and nonpin in ``tests/data/measured.json``, rounded up; a test compares this table with them.
"""

SUMMARY_KEYS = ("backlash", "stiffness_ideal", "efficiency", "capacity")
"""Keys of the figures in the summary line of a sheet."""

COMPARED = "the dynamic runs of the presets pin and nonpin at 36.68 N m and 1640 rpm"


@dataclass(frozen=True, repr=False)
class Sheet(Presented):
    """The static figures of a design.

    Attributes
    ----------
    design
        Name of the design.
    condition
        Load and speed.
    load_source
        Origin of the load.
    quantities
        Quantities by key; keys are those of the measures.
    assumptions
        Assumptions, a sentence each.
    parts
        Whether the parts are perfect or have the errors of the design.
    has_known_differences
        Whether the figures of this layout were compared with dynamic runs.
    """

    design: str
    condition: str
    load_source: LoadSource
    quantities: dict[str, Quantity]
    assumptions: tuple[str, ...]
    parts: str
    has_known_differences: bool = True

    @property
    def frame(self) -> Frame:
        """The quantities, one per row."""
        return quantity_frame(self.quantities)

    @property
    def line(self) -> str:
        """Design, condition, and the main quantities."""
        main_quantities = [self.quantities[key] for key in SUMMARY_KEYS if key in self.quantities]
        return f"{self.design}, {self.condition}; " + ", ".join(
            f"{item.key} {item.value:.4g} {item.unit if item.unit != '1' else ''}".strip() for item in main_quantities
        )

    def known_difference(self, quantity: Quantity) -> float | None:
        """Return the largest relative difference of a quantity from the runs `COMPARED`; None if unknown."""
        return known_difference(quantity) if self.has_known_differences else None

    def as_json(self) -> dict[str, Any]:
        """Convert the static data sheet to JSON values.

        ``design`` and ``condition`` are texts, ``load_source`` is the origin of the load, and ``assumptions`` are
        sentences. ``quantities`` are by key (`Quantity.as_json`). ``known_difference`` of a quantity is its largest
        relative difference from the simulations that ``known_difference_from`` names, or None; its ``parts`` says
        whether the parts of the reducer are perfect or have the errors of the design.
        """
        return {
            "design": self.design,
            "condition": self.condition,
            "load_source": self.load_source,
            "quantities": {
                key: {**quantity.as_json(), "known_difference": self.known_difference(quantity), "parts": self.parts}
                for key, quantity in self.quantities.items()
            },
            "known_difference_from": COMPARED,
            "assumptions": list(self.assumptions),
        }


def sheet(reducer: Reducer, load: float | None = None) -> Sheet:
    """Compute the data-sheet quantities of a design under an output torque `load` [N m].

    The default torque is the load of the design, or its nominal torque (`load_of`). Warns if the inertia of the load
    affects the results (`tracking_warnings`).

    Raises
    ------
    UsageError
        The torque is not positive.
    DesignError
        The crank does not rotate.
    ContactError
        The load flattens a pin beyond the range of a line contact.
    RunError
        There is no static equilibrium, for example because friction jams the reducer.
    """
    static_sheet = _assemble_sheet(reducer, load, [_cached_part(part) for part in PARTS_OF_SHEET])
    if SHEETS[reducer.LAYOUT].is_compared:
        warn(reducer.design.name, tracking_warnings(reducer.design, static_sheet.quantities))
    return static_sheet


def quick_sheet(reducer: Reducer, load: float | None = None) -> Sheet:
    """Compute the main quantities of the static data sheet in less than half of the time of `sheet`.

    These are backlash, lost motion and stiffness, the forward transmission error under the load, forces and pressures
    with the torque at first yield, and the efficiency. `load` is the torque on the output [N m]; None: the design's
    load, or its nominal torque.

    Raises
    ------
    UsageError
        The torque is not positive.
    DesignError
        The crank does not rotate.
    ContactError
        The load flattens a pin beyond the range of a line contact.
    RunError
        There is no static equilibrium.
    """
    return _assemble_sheet(reducer, load, SHEETS[reducer.LAYOUT].quick_parts)


def _assemble_sheet(reducer: Reducer, load: float | None, parts: Iterable[Part]) -> Sheet:
    """Compute a static data sheet under a `load` on the output [N m]; None: the default of `load_of`.

    `parts` are functions from the reducer and its load to the quantities of a part of the sheet.
    """
    _, load_source = load_of(reducer, load)
    reducer, load = _apply_load(reducer, load)
    design, quantities = reducer.design, by_key(*(part(reducer, load) for part in parts))
    return Sheet(
        design=design.name,
        condition=", ".join(
            [
                f"{load:.4g} N m, {abs(design.drive.speed) / RPM:.0f} rpm, {SHEETS[reducer.LAYOUT].inertia}",
                *([design.thermal.words] if design.thermal.words else []),
                film_text(reducer),
            ]
        ),
        load_source=load_source,
        quantities=quantities,
        assumptions=SHEETS[reducer.LAYOUT].assumptions(reducer),
        parts=reducer.parts_text,
        has_known_differences=SHEETS[reducer.LAYOUT].is_compared,
    )


def sheet_part(reducer: Reducer, part: SheetPart, load: float | None = None) -> dict[str, Quantity]:
    """Compute the quantities of a part of the sheet, by key, in a fraction of the time of `sheet`.

    `part` is "motions", "errors", "loads" or "losses". `load` is the torque on the output [N m]; by default that of
    `load_of`. Raises as `sheet`.
    """
    return dict(_compute_part(*_apply_load(reducer, load), part))


@once
def _compute_part(reducer: Reducer, load: float, part: SheetPart) -> Mapping[str, Quantity]:
    """Compute the quantities of one `part` of the sheet, by key, under the `load` of the reducer's design [N m].

    The result is empty for a part that RV reducers do not have.
    """
    parts = SHEETS[reducer.LAYOUT].parts
    return by_key(parts[part](reducer, load)) if part in parts else {}


def _cached_part(part: SheetPart) -> Part:
    return lambda reducer, load: iter(_compute_part(reducer, load, part).values())


def load_of(reducer: Reducer, load: float | None = None) -> tuple[float, LoadSource]:
    """Return the torque on the output for which a sheet is computed [N m], and its origin.

    It is `load` unless this is None, else the load of the design unless this is 0, else the nominal torque.

    Returns
    -------
    tuple
        The torque [N m], and its origin, one of `LoadSource`.
    """
    design = reducer.design
    if load is not None:
        return load, "given"
    if design.load.torque:
        return abs(design.load.torque), "load.torque_nm"
    return design.rated_torque, "rated torque"


def _apply_load(reducer: Reducer, load: float | None) -> tuple[Reducer, float]:
    """Return the reducer with a `load` on the output [N m] in its design; None: the default of `load_of`.

    Returns
    -------
    tuple
        The reducer, with the contact stiffnesses at this load, and the load [N m].

    Raises
    ------
    UsageError
        The load is not positive.
    DesignError
        The crank does not rotate.
    """
    load, _ = load_of(reducer, load)
    if not load > 0.0:
        raise UsageError(
            f"{reducer.design.name}: the output torque is {load:g} N m, which is out of range: choose a torque greater "
            "than 0 N m, e.g. --load-nm 10"
        )
    if reducer.design.drive.speed == 0.0:
        raise DesignError(
            f"{reducer.design.name}: drive.speed_rpm is 0, but losses need a crank that turns: set a speed other than "
            "0, such as 1640 rpm"
        )
    return reducer.but(load={"torque": load}).working_at(load), load


def known_difference(quantity: Quantity) -> float | None:
    """Return the largest relative difference of a quantity from the runs `COMPARED`; None if unknown."""
    if math.isnan(quantity.value) or quantity.key in KNOWN_DIFFERENCES:
        return KNOWN_DIFFERENCES.get(quantity.key)
    return next((share for end, share in KNOWN_DIFFERENCES_OF_KINDS.items() if quantity.key.endswith(f"_{end}")), None)


def _motion_quantities(reducer: Reducer, load: float) -> Iterator[Quantity]:
    """Yield backlash [arcmin], lost motion [arcmin], stiffness [N m/arcmin] and compliances [arcmin/(N m)].

    They are means over angles of a locked crank, without friction and weight. The backlash is extrapolated to zero
    torque from two small torques in each direction. `load` is the torque on the output [N m]: lost motion is taken
    between +3 % and -3 % of it, stiffness from 50 to 100 % of it. If ``structure`` is "springs", the parts in
    torsion have compliances of their own.
    """
    static_reducer = at_rest(reducer)
    crank_angles = turn_evenly(reducer)
    springs = springs_of(static_reducer, crank_angles, friction=False)

    def rotation(torque: float) -> Array:
        """Return the rotation of the output under a torque on it [N m] in [rad], shape (m,)."""
        return loads(static_reducer, springs, torque, warm_start=True).output_turn

    stop_torque = SETTINGS.stop_torque_share * max(load, reducer.design.rated_torque)
    backlash = stop_width(rotation, stop_torque) / ARCMINUTE
    yield sheet_quantity("backlash", float(backlash.mean()))
    yield sheet_quantity("backlash_min", float(backlash.min()))
    yield sheet_quantity("backlash_max", float(backlash.max()))
    windup_solution = solve_windups(reducer, crank_angles, load, warm_start=True)
    yield sheet_quantity(
        "lost_motion_ideal", float(np.mean([windup.lost_motion for windup in windup_solution])) / ARCMINUTE
    )
    yield sheet_quantity("stiffness_ideal", _stiffness(windup_solution))
    by_crank_angle = [windup.compliance_by_spring(reducer) for windup in windup_solution]
    compliance = {part: float(np.mean([by_part[part] for by_part in by_crank_angle])) / ARCMINUTE for part in SPRINGS}
    if reducer.design.structure == "springs":
        rigid = reducer.but(structure="rigid")
        yield sheet_quantity(
            "stiffness_contacts", _stiffness(solve_windups(rigid, crank_angles, load, warm_start=True))
        )
        compliance |= {
            part: part_compliance / ARCMINUTE for part, part_compliance in twisting_compliance(reducer).items()
        }
    else:
        compliance.pop("bending")
    for part, part_compliance in compliance.items():
        yield sheet_quantity(f"compliance_{part}", part_compliance)


def _stiffness(windups: Sequence[Windup]) -> float:
    """Compute the mean stiffness of wind-ups over the linear part [N m/arcmin]."""
    return float(np.mean([ARCMINUTE / windup.compliance(windup.turn) for windup in windups]))


def _error_quantities(reducer: Reducer, load: float) -> Iterator[Quantity]:
    """Yield the peak-to-peak and rms transmission errors of disc and output [arcsec], unloaded and loaded.

    They are computed in both directions, with friction. Two differences of mean rotations follow [arcsec]: the reversal
    error, between forward and reverse motion without load, and the wind-up, between load and no load in forward motion.
    A reducer with a central crank also has the rms inertia torque of an output that follows the error, relative to
    `load` (`inertia_share`). `load` is the torque on the output [N m].
    """
    means: dict[tuple[str, str, str], float] = {}
    for case in CASES:
        for direction in DIRECTIONS:
            rotations = _compute_rotations(reducer, load, case, direction)
            means |= {
                (part, case, direction): float(rotation.mean()) / ARCSECOND for part, rotation in rotations.items()
            }
            yield from _range_quantities(rotations, case, direction)
            if (case, direction) == ("loaded", "forward") and SHEETS[reducer.LAYOUT].is_compared:
                yield sheet_quantity(INERTIA_SHARE, inertia_share(reducer, rotations["output"][:-1], load))
    for part in rotations:
        unloaded_error = means[part, "unloaded", "forward"]
        yield sheet_quantity(f"{part}_reversal", unloaded_error - means[part, "unloaded", "reverse"])
        yield sheet_quantity(f"{part}_wind_up", means[part, "loaded", "forward"] - unloaded_error)


def _loaded_error(reducer: Reducer, load: float) -> Iterator[Quantity]:
    """Yield the forward transmission error of disc and output under the `load` [N m]: peak to peak and rms [arcsec]."""
    return _range_quantities(_compute_rotations(reducer, load, "loaded", "forward"), "loaded", "forward")


def _compute_rotations(reducer: Reducer, load: float, case: str, direction: str) -> dict[str, Array]:
    """Compute the rotations of "gear" (disc) and "output" from their ideal angles [rad] at m angles of a turn, (m,).

    `case` is "unloaded" or "loaded" with the `load` [N m], `direction` the sense of the crank by name (`DIRECTIONS`).
    Crank angles are evenly spaced, both ends included. For an RV reducer, only the output is computed, over a turn of
    the carrier.
    """
    return SHEETS[reducer.LAYOUT].rotations(reducer, load, case, direction)


def _rv_rotations(reducer: RvReducer, load: float, case: str, direction: str) -> dict[str, Array]:
    """Compute the result of `_compute_rotations` for an RV reducer."""
    return {"output": rv_sheet.running_rotation(reducer, DIRECTIONS[direction] * CASES[case] * load)}


def _central_rotations(reducer: Reducer, load: float, case: str, direction: str) -> dict[str, Array]:
    """Compute the result of `_compute_rotations` for a drive with a central crank."""
    count, sign = SETTINGS.angles_per_mesh_period * reducer.mesh_periods, DIRECTIONS[direction]
    moving_reducer = reducer.but(drive={"speed": sign * abs(reducer.design.drive.speed)})
    springs = springs_of(moving_reducer, np.linspace(0.0, 2.0 * np.pi, count + 1))
    contact_loads = loads(moving_reducer, springs, sign * CASES[case] * load, warm_start=True)
    return {"gear": contact_loads.gear_turn, "output": contact_loads.output_turn}


def _range_quantities(rotations: Mapping[str, Array], case: str, direction: str) -> Iterator[Quantity]:
    """Yield peak-to-peak and rms values [arcsec] of the transmission errors of the disc ("gear") and the output.

    `rotations` has the rotations from the ideal angles [rad] at m angles of a turn, shape (m,), by these keys. `case`
    is "unloaded" or "loaded", and `direction` is the crank's direction by name; both are part of the keys of the
    quantities.
    """
    for shaft, rotation in rotations.items():
        suffix = f"{case}_{direction}_speed"
        yield sheet_quantity(f"{shaft}_peak_to_peak_{suffix}", peak_to_peak(rotation) / ARCSECOND)
        yield sheet_quantity(f"{shaft}_rms_{suffix}", rms_about_mean(rotation) / ARCSECOND)


def _load_quantities(reducer: Reducer, load: float, limit_count: int = len(LIMITS)) -> Iterator[Quantity]:
    """Yield forces [N], pressures [MPa] and margins of each kind of mating pair, and torques [N m] at `LIMITS`.

    Limits are first yield and shakedown; only the first `limit_count` are computed. A margin is the pressure of first
    yield over the largest pressure. `load` is the torque on the output [N m]. With several discs, their shares of the
    torque and the bearing reactions are included. If no contact is narrow enough for Hertz theory, the torques are NaN,
    with a note.
    """
    design = reducer.design
    torque = math.copysign(load, design.drive.speed)
    springs = springs_of(reducer, _force_angles(reducer))
    contact_loads = loads(reducer, springs, torque, warm_start=True)
    strength_ratios = {
        kind: reducer.contacts[kind].strength / peak_pressure(reducer, springs, contact_loads, kind)
        for kind in design.pair_kinds
        if is_hertzian(reducer, springs, contact_loads, kind)
    }
    yield from disc_shares(contact_loads.share)
    for kind in design.pair_kinds:
        yield from _pair_quantities(springs, contact_loads, kind, reducer, strength_ratios.get(kind, math.nan))
    if contact_loads.discs > 1:
        yield from reaction_quantities(compute_reactions(reducer, springs, contact_loads))
    for key, strength_share in islice(LIMITS.items(), limit_count):
        if not strength_ratios:
            yield sheet_quantity(key, math.nan, note="none: no contact is narrow enough for Hertz theory")
            continue
        pressures = {kind: strength_share * reducer.contacts[kind].strength for kind in strength_ratios}
        limit_torque, limiting_kind = torque_at_pressure(
            reducer, springs, pressures, torque, contact_loads, warm_start=True
        )
        yield sheet_quantity(key, abs(limit_torque), note=f"limited by {limiting_kind}")


def _loads_and_yield(reducer: Reducer, load: float) -> Iterator[Quantity]:
    """Yield the quantities of `_load_quantities` with the torque of the first of `LIMITS` only."""
    return _load_quantities(reducer, load, limit_count=1)


def _force_angles(reducer: Reducer) -> Array:
    """Return the crank angles for forces [rad], in order."""
    return turn_evenly(reducer, POSES if reducer.design.gear.discs == 1 else SETTINGS.angles_of_several_discs)


def disc_shares(shares: Array) -> Iterator[Quantity]:
    """Yield the mean share of each of D discs in the output torque [1], from `shares` at m crank angles, (m, D).

    Nothing is yielded for a single disc. If m is 0, because the output has no load, the shares are NaN with a note.
    """
    for disc, share in enumerate(shares.T if shares.shape[1] > 1 else (), start=1):
        mean_share = float(share.mean()) if share.size else math.nan
        note = f"from {share.min():.4g} to {share.max():.4g} over the crank angle" if share.size else UNLOADED
        yield sheet_quantity(f"disc_{disc}_share", mean_share, note=note)


def reaction_quantities(reactions: Reactions) -> Iterator[Quantity]:
    """Yield the largest forces [N] and tilting moments [N m] in `reactions`: on shaft, output, ring and bearings."""
    for member in ("shaft", "output", "ring"):
        disc_forces: Planes = getattr(reactions, member)
        yield sheet_quantity(f"{member}_net_force", float(np.hypot(*disc_forces.net.T).max()))
        yield sheet_quantity(f"{member}_tilting_moment", float(np.hypot(*disc_forces.moment.T).max()))
    for key in BEARINGS:
        forces = getattr(reactions, key.replace("_bearing", ""))
        if forces is not None:
            yield sheet_quantity(f"{key}_force", float(np.hypot(*forces.T).max()))


def _pair_quantities(
    springs: Springs, contact_loads: Loads, kind: str, reducer: Reducer, strength_ratio: float
) -> Iterator[Quantity]:
    """Yield the quantities of a kind of mating pair: forces [N], number of loaded contacts, pressure [MPa] and margin.

    The margin is the pressure of first yield over the largest pressure. `springs` are the contact springs,
    `contact_loads` the forces on them. `kind` is the kind of pair, such as "pin_gear". `strength_ratio` is the strength
    of the contact over its largest pressure [1]; NaN if Hertz theory does not apply.
    """
    largest_force, force = peak_force(contact_loads, kind), forces(contact_loads, kind).reshape(springs.crank.size, -1)
    is_loaded, note = force > CARRYING_SHARE * largest_force, CONFORMAL if math.isnan(strength_ratio) else ""
    turn_angles = np.linspace(0.0, 2.0 * np.pi, SETTINGS.angles_per_mesh_period * reducer.design.ring.teeth + 1)
    ideal_force = ideal_peak(reducer, kind, turn_angles)
    yield sheet_quantity(f"{kind}_peak_force", largest_force, reference=ideal_force, source="ideal sharing")
    yield sheet_quantity(f"{kind}_mean_force", float(force[is_loaded].mean()) if is_loaded.any() else 0.0)
    yield sheet_quantity(f"{kind}_carrying", float(is_loaded.sum(axis=1).mean()))
    yield sheet_quantity(f"{kind}_pressure", 1e-6 * reducer.contacts[kind].strength / strength_ratio, note=note)
    yield sheet_quantity(f"{kind}_margin", YIELD_PRESSURE * strength_ratio, note=note)


def _loss_quantities(reducer: Reducer, load: float) -> Iterator[Quantity]:
    """Yield efficiency [%] and losses [W] under a load [N m], and torque [N m] and efficiency [%] of back-driving.

    The torque of back-driving acts on the output and drives the crank (`solve_back_driving`); it is NaN for a
    self-locking reducer. With the law ``film``, the efficiencies include a 5 to 95 % interval.
    """
    yield from _efficiency_quantities(reducer, load)
    back_powers, back_torque = solve_back_driving(reducer, load)
    note = describe_self_locking(reducer, load) if math.isnan(back_torque) else ""
    yield sheet_quantity("back_driving_torque_rated", back_torque, note=note)
    if reducer.design.has_film and not math.isnan(back_torque):
        yield spread_quantity("back_driving_efficiency", back_driving_efficiency_spread(reducer, back_torque))
    else:
        yield sheet_quantity("back_driving_efficiency", 100.0 * back_powers.efficiency, note=note)


def _efficiency_quantities(reducer: Reducer, load: float) -> Iterator[Quantity]:
    """Yield efficiency [%], losses [W] and shaft powers [W] when the crank drives a `load` on the output [N m].

    With the law ``film``, the efficiency includes a 5 to 95 % interval.
    """
    design, sheet_layout = reducer.design, SHEETS[reducer.LAYOUT]
    mean_powers, sources = shaft_powers(reducer, load, sheet_layout.angles), sheet_layout.sources
    if design.has_film:
        yield spread_quantity("efficiency", sampled_efficiency(reducer, load))
    else:
        yield sheet_quantity("efficiency", 100.0 * mean_powers.efficiency)
    for kind, part in {design.tooth_pair: "teeth", **sources}.items():
        note = f"including {design.seat_pair}" if part == "teeth" and design.seat_pair else ""
        yield sheet_quantity(f"{kind}_friction_power", mean_powers.friction[part], note=note)
    yield sheet_quantity("seals_power", mean_powers.friction["seals"])
    yield sheet_quantity("input_power", mean_powers.supplied)
    yield sheet_quantity("output_power", mean_powers.delivered)


def shaft_powers(reducer: Reducer, torque: float, poses: int = POSES) -> Powers:
    """Compute the mean powers of input, output and friction [W] under a torque on the output [N m].

    The means are over `poses` crank angles. The reducer may have a central crank or be an RV reducer.
    """
    return SHEETS[reducer.LAYOUT].powers(reducer, torque, poses)


def _central_powers(reducer: Reducer, torque: float, poses: int) -> Powers:
    """Compute the result of `shaft_powers` for a drive with a central crank."""
    return powers(reducer, torque, turn_evenly(reducer, poses))


def sampled_losses(reducer: Reducer, torque: float, samples: int = SAMPLES) -> tuple[float, Array]:
    """Compute the power lost with the law ``film`` by a reducer of any layout; see `film_spread.lost_powers`."""
    return SHEETS[reducer.LAYOUT].lost_powers(reducer, torque, samples)


def sampled_efficiency(reducer: Reducer, torque: float, samples: int = SAMPLES, further_loss: float = 0.0) -> Spread:
    """Compute the efficiency [%] and its 5 to 95 % interval when the crank drives against an output torque [N m].

    `samples` is the number of samples of the film law's inputs. `further_loss` is the power lost in parts without a
    film law [W], such as the bearings of shaft and output.

    Raises
    ------
    RunError
        There is no equilibrium, for example because friction jams the reducer.
    """
    output_power = torque * abs(reducer.design.drive.speed) / reducer.design.reduction
    lost_power, sample_losses = sampled_losses(reducer, torque, samples)
    efficiencies = 100.0 * output_power / (output_power + sample_losses + further_loss)
    return compute_spread(
        100.0 * output_power / (output_power + lost_power + further_loss), efficiencies, sample_inputs(samples)[1]
    )


def solve_back_driving(reducer: Reducer, load: float) -> tuple[Powers, float]:
    """Solve for the output torque that drives the crank against a torque of `load` [N m] divided by the ratio.

    The output torque is `load` divided by the back-driving efficiency. The efficiency depends on this torque, so both
    are determined by a fixed-point iteration.

    Returns
    -------
    tuple
        Powers when the output drives, and the torque on the output [N m]; NaN if the reducer is self-locking.
    """
    torque = load
    mean_powers = shaft_powers(reducer, -torque)
    for _ in range(3):
        if not mean_powers.efficiency > 0.0:
            return mean_powers, math.nan
        torque = load / mean_powers.efficiency
        mean_powers = shaft_powers(reducer, -torque)
    return mean_powers, torque


def describe_self_locking(reducer: Reducer, load: float) -> str:
    """Describe self-locking against the crank's share of a load [N m], and whether the output drives a free crank."""
    drives_free_crank, crank_torque = shaft_powers(reducer, -load).crank < 0.0, load / reducer.design.reduction
    return (
        f"self-locking against {crank_torque:.4g} N m on the crank: friction takes all power of the output; "
        f"{load:.4g} N m on the output {'drives' if drives_free_crank else 'does not drive'} a crank without load"
    )


RV_PARTS: Mapping[SheetPart, Callable[[RvReducer, float], Iterator[Quantity]]] = {
    "motions": rv_sheet.motion_figures,
    "errors": _error_quantities,
    "loads": rv_sheet.force_figures,
    "losses": _efficiency_quantities,
}
"""The same for RV reducers."""

PARTS_OF_SHEET: Mapping[SheetPart, Part] = {
    "motions": _motion_quantities,
    "errors": _error_quantities,
    "loads": _load_quantities,
    "losses": _loss_quantities,
}
"""Functions that yield the figures of a sheet, by name."""


def _elastic_parts_text(reducer: Reducer) -> str:
    """Describe which parts are elastic and which are rigid."""
    if reducer.design.structure == "springs":
        return "output pins, carrier, shaft and housing are elastic, all other parts are rigid"
    return "parts are rigid"


def _assumptions(reducer: Reducer) -> tuple[str, ...]:
    """Return the assumptions behind the static data-sheet quantities, a sentence each."""
    design = reducer.design
    return (
        f"statics: {_elastic_parts_text(reducer)}, contacts are unilateral springs with all clearances, manufacturing "
        "errors and modifications; the only inertia force is the disc's centrifugal force",
        film_assumption(reducer)
        if design.has_film
        else f"Coulomb friction of a rotating crank at any sliding speed; none in backlash, lost motion and stiffness: "
        f"{', '.join(f'{kind} {design.friction_of(kind):g}' for kind in design.pair_kinds)}",
        f"contacts have the secant stiffness at the load: {reducer.contacts.working_forces_text(design.pair_kinds)}",
        "a flank of an internal gear and the arc next to it form a single contact patch",
        *([SEVERAL] if design.gear.discs > 1 else []),
        *([structure_text(reducer)] if design.structure == "springs" else []),
        f"forces and losses cover {_force_angles(reducer).size} crank angles, the transmission error "
        f"{SETTINGS.angles_per_mesh_period} per mesh period, unloaded under {CASES['unloaded']:.0%} of the load; "
        "the bearings of the shafts are not included",
        *part_notes(design),
    )


class SheetOfLayout(NamedTuple):
    """What the sheet of a layout consists of.

    Attributes
    ----------
    parts, quick_parts
        Functions that yield the quantities of a part of the sheet, by its name, and those of `quick_sheet`.
    assumptions
        Function that returns the assumptions of the quantities, a sentence each.
    inertia
        Which inertia forces the quantities include, in words.
    is_compared
        Whether differences from dynamic runs are known, and effects of the inertia are stated.
    rotations, powers, lost_powers
        Functions as `_compute_rotations`, `shaft_powers` and `sampled_losses`.
    sources, angles
        Kinds of friction next to the teeth -> their names in `Powers`, and number of crank angles of the losses.
    """

    parts: Mapping[SheetPart, Callable[[Any, float], Iterator[Quantity]]]
    quick_parts: tuple[Part, ...]
    assumptions: Callable[[Any], tuple[str, ...]]
    inertia: str
    is_compared: bool
    rotations: Callable[[Any, float, str, str], dict[str, Array]]
    powers: Callable[[Any, float, int], Powers]
    lost_powers: Callable[[Any, float, int], tuple[float, Array]]
    sources: Mapping[str, str]
    angles: int


SHEETS: Mapping[Layout, SheetOfLayout] = {
    "central": SheetOfLayout(
        parts=PARTS_OF_SHEET,
        quick_parts=(_motion_quantities, _loaded_error, _loads_and_yield, _efficiency_quantities),
        assumptions=_assumptions,
        inertia="quasi-static with disc centrifugal force",
        is_compared=True,
        rotations=_central_rotations,
        powers=_central_powers,
        lost_powers=lost_powers,
        sources={"cam": "cam", "output": "output"},
        angles=POSES,
    ),
    "rv": SheetOfLayout(
        parts=RV_PARTS,
        quick_parts=(_cached_part("motions"), _cached_part("loads"), _cached_part("losses"), _loaded_error),
        assumptions=rv_sheet.assumptions,
        inertia="quasi-static",
        is_compared=False,
        rotations=_rv_rotations,
        powers=rv_sheet.rv_powers,
        lost_powers=rv_sheet.rv_lost_powers,
        sources={"crank_bearing": "crank bearings", "planet": "planets"},
        angles=rv_sheet.SETTINGS.force_angles,
    ),
}
"""Layout -> its sheet."""
