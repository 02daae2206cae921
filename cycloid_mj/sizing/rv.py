"""RV reducers for a requirement: a catalogue-like search over teeth, crank bearings and widths, then the rating.

Proportions are those of `rv80e`, with crank bearings in stock. For each assembly of sun, planets and pins, closed forms
estimate the torque for which crank bearings and pins last. The shortest candidate that should carry the torque is
checked and rated; each rating corrects the estimates of the others, until a drive passes or none is left.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import ClassVar

import numpy as np

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.units import HOUR, MILLIMETRES
from cycloid_mj.checks import soundness
from cycloid_mj.design import PRESETS, Design, override, stock
from cycloid_mj.design.layouts import Layout
from cycloid_mj.geometry.rv_loads import ideal_rv_loads, mean_force
from cycloid_mj.life import rate
from cycloid_mj.life.duty import PEAK_FACTOR
from cycloid_mj.life.item import ItemKind, RatedItem, Rating
from cycloid_mj.life.rated import rated_and_momentary_torque
from cycloid_mj.life.rolling import EXPONENT
from cycloid_mj.life.rv import crank_bearing_ratings, flange_forces
from cycloid_mj.life.surfaces import AGMA_2001, pitting_limit
from cycloid_mj.life.thermal import thermal
from cycloid_mj.parts.export.rv_assembly import rv_mass
from cycloid_mj.parts.rv import axial_layout
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.gaps import mesh_gaps
from cycloid_mj.reducer.rv_main_bearings import min_flange_thickness
from cycloid_mj.sizing.answer import Answer, FeasibleChange, SizedDrive
from cycloid_mj.sizing.candidates import POWER_RESERVE, conditions
from cycloid_mj.sizing.remedies import better_cooling, first_feasible, list_changes
from cycloid_mj.sizing.requirement import Requirement
from cycloid_mj.sizing.solve import change_length, round_up_length
from cycloid_mj.statics.rv_sheet import motion_figures

MODULES = tuple(1e-3 * item for item in (0.5, 0.6, 0.8, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0))
"""Modules of sun and planets [m]: ISO 54, series I, and 1.75 mm of series II."""


@dataclass(frozen=True)
class RvShares:
    """Proportions of a drive over the radius E of its pin circle, unless another length is named.

    Attributes
    ----------
    crank_circle
        Smallest and largest radius of the circle of cranks.
    min_bore
        Smallest radius of the crank bores.
    special
        Searched outer radii of special crank bearings, for drives into which none in stock fits.
    widths, trochoids
        Searched widths of a disc, and eccentricities times pins over E (K1).
    pitch
        Distance of pins over their radius.
    wall
        Smallest wall between holes.
    needle_gap
        Pitch of the needles over their diameter.
    post
        Smallest radius of the posts.
    """

    crank_circle: tuple[float, float] = (0.46, 0.6)
    min_bore: float = 0.18
    special: tuple[float, ...] = (0.17, 0.2, 0.235, 0.27)
    widths: tuple[float, ...] = (0.13, 0.16, 0.19, 0.23, 0.28, 0.34)
    trochoids: tuple[float, ...] = (0.65, 0.75)
    pitch: float = 3.0
    wall: float = 0.05
    needle_gap: float = 1.12
    post: float = 0.06


SHARES = RvShares()

MODEL = RvReducer(PRESETS["rv80e"])
"""Preset from which all candidates take the proportions, clearances and stiffnesses that are not searched."""

POST_PLAY = 0.5e-3
"""Smallest play of a post in its window next to a crank bore [m] (heuristic)."""

TEETH = {"ring": range(28, 61, 2), "sun": range(10, 31), "planet": range(15, 121)}
"""Numbers of teeth that are searched; an even number of pins balances two discs."""

MAX_RATINGS = 8
"""Largest number of candidates that a search evaluates (heuristic)."""

ESTIMATE_ANGLES = 48
"""Crank angles of an estimate (heuristic)."""

OUTPUT_RPM = 15.0
"""Usual speed of the output [rpm], at which catalogues state the rated torque."""

DUTY_SHARE = 0.4
"""Share of the time under load, if none is required [1]: assumed, an intermittent duty (S3, IEC 60034-1)."""

CLEARANCE = 0.5e-6
"""Clearance of pins on discs and in their sockets, if none is required [m] (heuristic): parts are matched."""


class RvRequirement(Requirement):
    """Requirement of an RV reducer: its ratio is that of sun and carrier, its speed that of the sun."""

    LAYOUT: ClassVar[Layout] = "rv"
    RATIOS: ClassVar[tuple[int, int]] = (31, 321)
    STAGES: ClassVar[str] = "an RV reducer"

    def _two_stages(self) -> str:
        return ""


@dataclass(frozen=True, eq=False)
class Candidate:
    """An RV reducer of a requirement."""

    reducer: RvReducer
    requirement: RvRequirement

    @cached_property
    def estimate(self) -> float:
        """Estimated torque for which crank bearings and pins last [N m], with ideal sharing of the load."""
        return _estimate_torque(self.reducer, self.requirement)

    @cached_property
    def length(self) -> float:
        """Length from the outer flange to the planets [m]."""
        return axial_layout(self.reducer).length


@dataclass(frozen=True, eq=False)
class RatedRv:
    """A candidate with its rating at the required torque, the torque that it carries [N m], and what limits it."""

    candidate: Candidate
    rating: Rating
    torque: float
    momentary: float
    weakest: RatedItem


def size_rv(requirement: RvRequirement, on_progress: Callable[[Answer], None] = lambda _: None) -> Answer:
    """Find the shortest RV reducer that meets a requirement, and the longest-lived of the evaluated candidates.

    If no reducer meets the requirement, the answer has the largest feasible torque, and changes of the requirement that
    make it feasible. `on_progress` is called with the answer before these changes are known.
    """
    pool = candidates(requirement)
    if not pool:
        reason = _describe_empty_pool(requirement)
        return Answer(requirement, (), 0.0, reason, remedies=tuple(_remedies(requirement, None)))
    best, strongest = _search_shortest(requirement, pool)
    if best is None:
        max_torque = float(f"{strongest.torque:.3g}") if strongest else 0.0
        limit = strongest.weakest.name if strongest else "no candidate passes its checks"
        answer = Answer(requirement, (), max_torque, limit)
        on_progress(answer)
        return replace(answer, remedies=tuple(_remedies(requirement, strongest)))
    drives = [_sized_drive(requirement, best, "lightest", "shortest of the candidates that pass, hence the lightest")]
    if strongest and strongest.rating.shortest_life > 1.5 * best.rating.shortest_life:
        drives.append(_sized_drive(requirement, strongest, "longest life", "longest life of the rated candidates"))
    return Answer(requirement, tuple(drives))


def _describe_empty_pool(requirement: RvRequirement) -> str:
    """Return the reason why there are no candidates for a requirement: its length, or its diameter."""
    longer_drives = candidates(requirement.but(length=math.inf))
    if longer_drives:
        return f"no drive is shorter than {MILLIMETRES * longer_drives[0].length:.4g} mm"
    has_main_bearings = RvReducer(override(MODEL.design, requirement.changes)).cranks.main_bearings != "none"
    bearing_text = " and main bearings" if has_main_bearings else ""
    return (
        f"no planets and discs with a ratio of {requirement.ratio}{bearing_text} fit into "
        f"{MILLIMETRES * requirement.diameter:g} mm"
    )


def candidates(requirement: RvRequirement) -> list[Candidate]:
    """List the candidate drives for a requirement that have room for their bearings, the shortest first.

    Only where no crank bearing in stock fits, crank bearings are special, with the proportions of `rv80e`.
    """
    bore_ratio = MODEL.journal_radius / MODEL.cranks.taper_radius
    outside_diameters = [round(2.0 * share * _pin_circle_radius(requirement), 4) for share in SHARES.special]
    special = [stock.StockBearing("", bore_ratio * outside, outside, 0.0, 0.0, 0.0) for outside in outside_diameters]
    pool = _candidates_with(requirement, stock.crank_bearings()) or _candidates_with(requirement, special)
    return sorted(pool, key=lambda item: item.length)


def _candidates_with(requirement: RvRequirement, bearings: Iterable[stock.StockBearing]) -> list[Candidate]:
    """List the candidate drives with some of the `bearings` at the ends of their cranks."""
    return [
        candidate
        for cranks in (2, 3)
        for sun, planet, ring in assemblies(requirement.ratio, cranks)
        for trochoid in SHARES.trochoids
        for bearing in bearings
        for width in SHARES.widths
        if (candidate := _lay_out_candidate(requirement, cranks, (sun, planet, ring), trochoid, bearing, width))
        and candidate.length <= requirement.length
    ]


def _pin_circle_radius(requirement: RvRequirement) -> float:
    """Return the radius of the pin circle [m], in proportion to the outer radius."""
    design = MODEL.design
    return round(requirement.diameter / 2.0 * design.ring.pin_circle_radius / design.housing.outer_radius, 4)


def assemblies(ratio: int, cranks: int) -> Iterator[tuple[int, int, int]]:
    """Yield numbers of teeth (sun, planet, ring) with ``ratio = 1 + ring * planet / sun`` that can be assembled.

    There is a planet on each of the `cranks`, larger than the sun; ring is the number of ring pins. For each ring only
    the smallest possible sun is used.
    """
    for ring in TEETH["ring"]:
        quotient = Fraction(ratio - 1, ring)
        for sun in TEETH["sun"]:
            planet = quotient * sun
            is_usual = planet > 1.5 * sun and planet in TEETH["planet"]
            if is_usual and planet.denominator == 1 and (sun + planet) % cranks == 0:
                yield sun, int(planet), ring
                break


def _lay_out_candidate(
    requirement: RvRequirement,
    cranks: int,
    teeth: tuple[int, int, int],
    trochoid: float,
    bearing: stock.StockBearing,
    width: float,
) -> Candidate | None:
    """Return a candidate drive with given numbers of teeth and proportions; None if its parts do not fit.

    `teeth` are the numbers of teeth of sun, planet and ring. `trochoid` is the trochoid ratio K1 = c N/E, with
    eccentricity c, N ring pins and radius E of the pin circle. `bearing` is that of a crank in a flange, and `width`
    the width of a disc, divided by E; see `RvShares`. `requirement` is that for the drive.
    """
    sun, planet, ring = teeth
    model, model_cranks = MODEL.design, MODEL.cranks
    circle = _pin_circle_radius(requirement)
    ideal_pin = 2.0 * math.pi * circle / (ring * SHARES.pitch)
    pin = min((0.5 * size for size in stock.dowel_diameters()), key=lambda radius: abs(radius - ideal_pin))
    eccentricity = round(trochoid * circle / ring, 5)
    low, high = (share * circle for share in SHARES.crank_circle)
    modules = [item for item in MODULES if low <= item * (sun + planet) / 2.0 <= high]
    if not modules:
        return None
    module, wall = max(modules), SHARES.wall * circle
    radius, root = module * (sun + planet) / 2.0, circle - pin - eccentricity
    taper, eccentric = 0.5 * bearing.outside, 0.5 * bearing.bore + eccentricity
    ideal_needle = eccentric * model_cranks.needle_radius / model_cranks.eccentric_radius
    needle = min((0.5 * size for size in stock.needle_diameters()), key=lambda item: abs(item - ideal_needle))
    bore_radius = eccentric + 2.0 * needle
    chord = 2.0 * radius * math.sin(math.pi / (2.0 * cranks))
    middle = radius - max(taper, bore_radius) - wall
    post = min(chord - taper, chord - bore_radius - eccentricity - POST_PLAY, root - radius - eccentricity) - wall
    post = min(post, radius - middle - wall - eccentricity)
    margins = post - SHARES.post * circle, bore_radius - SHARES.min_bore * circle
    if min(root - wall - radius - max(taper, bore_radius), middle, *margins) < 0.0:
        return None
    needles = math.floor(2.0 * math.pi * (eccentric + needle) / (2.0 * needle * SHARES.needle_gap))
    face = round(width * circle, 4)
    width_ratio = face / model.gear.face_width
    needle_ratio = width_ratio * needles / model_cranks.needles
    design = model.but(
        name="rv",
        ring={"teeth": ring, "pin_circle_radius": circle, "pin_radius": pin},
        gear={"eccentricity": eccentricity, "face_width": face},
        planet={
            "sun_teeth": sun,
            "planet_teeth": planet,
            "module": module,
            "face_width": width_ratio * MODEL.planet.face_width,
        },
        cranks={
            "count": cranks,
            "eccentric_radius": eccentric,
            "needle_radius": needle,
            "needles": needles,
            "needle_stiffness": needle_ratio * model_cranks.needle_stiffness,
            "taper_stiffness": needle_ratio * model_cranks.taper_stiffness,
            "taper_radius": taper,
            "middle_hole_radius": middle,
            "post_radius": post,
            "flange_thickness": max(
                round(circle * model_cranks.flange_thickness / model.ring.pin_circle_radius, 5),
                round_up_length(bearing.width + wall),
            ),
        },
        housing={"outer_radius": requirement.diameter / 2.0},
        clearance=dict.fromkeys(("pin_gear", "pin_socket"), requirement.clearance or CLEARANCE),
        stiffness={pair: width_ratio * getattr(model.stiffness, pair) for pair in ("pin_gear", "pin_socket")},
        load={"torque": requirement.torque},
        **conditions(requirement, requirement.torque),
    )
    reducer = _fit_main_bearings(design, requirement)
    return Candidate(reducer, requirement) if reducer else None


def _fit_main_bearings(design: Design, requirement: RvRequirement) -> RvReducer | None:
    """Return the reducer of a design with the required values, and flanges that have the seats of main bearings.

    Flanges without main bearings, and a required thickness, are unchanged. None: no main bearing fits.
    """
    reducer = RvReducer(override(design, requirement.changes))
    if reducer.cranks.main_bearings == "none":
        return reducer
    bearing = reducer.main_bearing
    if bearing is None:
        return None
    min_thickness = math.ceil(round(1e4 * min_flange_thickness(reducer, bearing), 5)) / 1e4
    thickness = max(reducer.cranks.flange_thickness, min_thickness)
    return RvReducer(override(design.but(cranks={"flange_thickness": thickness}), requirement.changes))


def _estimate_torque(reducer: RvReducer, requirement: RvRequirement) -> float:
    """Estimate the output torque [N m] at which crank bearings and pins last the required life.

    The lives are those of ISO 281 for the bearings and of AGMA 2001-D04 for the pins.
    """
    crank = np.linspace(0.0, reducer.crank_turn, ESTIMATE_ANGLES, endpoint=False)
    loads = ideal_rv_loads(reducer.stage, reducer.share, crank)
    forces = loads.bearings.reshape(crank.size, -1), flange_forces(reducer, loads.cranks)
    crank_turns = requirement.life * HOUR * reducer.crank_speed / (2.0 * math.pi)
    bearings = (
        ratings.dynamic * (1e6 / crank_turns) ** (1.0 / EXPONENT) / max(map(mean_force, force.T))
        for ratings, force in zip(crank_bearing_ratings(reducer), forces, strict=True)
    )
    kind = reducer.design.tooth_pair
    curvature = mesh_gaps(reducer, crank).relative_curvature
    pressure = float(reducer.contacts[kind].pressure(loads.pins.reshape(crank.size, -1), curvature).max())
    allowed_pressure = min(pitting_limit(material)[0] for material in reducer.design.partners(kind))
    return min(*bearings, (AGMA_2001.factor * allowed_pressure * crank_turns**-AGMA_2001.power / pressure) ** 2)


def _search_shortest(requirement: RvRequirement, pool: list[Candidate]) -> tuple[RatedRv | None, RatedRv | None]:
    """Compute the torque limits of candidates, the shortest first, until one carries the required torque.

    Returns this candidate or None, and the strongest candidate. `pool` is sorted by length, and at most `MAX_RATINGS`
    of its candidates are evaluated. Candidates are skipped whose estimated torque is too small; the ratios of computed
    and estimated torques correct these estimates. The strongest has the largest torque of the evaluated candidates.
    """
    strongest, correction, remaining = None, 1.0, list(pool)
    for _ in range(MAX_RATINGS):
        promising = next((item for item in remaining if correction * item.estimate >= requirement.torque), None)
        candidate = promising or max(remaining, key=lambda item: item.estimate, default=None)
        if candidate is None:
            break
        remaining.remove(candidate)
        rated = rate_candidate(requirement, candidate)
        if rated is None:
            continue
        strongest = rated if strongest is None or rated.torque > strongest.torque else strongest
        if rated.torque >= requirement.torque:
            return rated, strongest
        if promising is None:
            break
        correction = min(correction, rated.torque / candidate.estimate)
    return None, strongest


def rate_candidate(requirement: RvRequirement, candidate: Candidate) -> RatedRv | None:
    """Check a candidate and compute its torque limits; return None if it fails a check or has no equilibrium.

    `requirement` is that for the drive.
    """
    if any(item.severity == "error" and not item.passed for item in soundness(candidate.reducer)):
        return None
    torque = requirement.torque
    try:
        rating = rate(candidate.reducer, requirement.duty_at(torque), requirement.life, compliance=True)
    except CycloidError:
        return None
    (continuous, weakest), (momentary, stop) = rated_and_momentary_torque(
        rating.items.values(), torque, rating.life, candidate.reducer
    )
    weakest = stop if momentary < PEAK_FACTOR * continuous else weakest
    return RatedRv(candidate, rating, min(continuous, momentary / PEAK_FACTOR), momentary, weakest)


def _remedies(requirement: RvRequirement, strongest: RatedRv | None) -> Iterator[FeasibleChange]:
    """Yield changes that make a requirement feasible, each verified by a search.

    If a life limits the torque, the change is a shorter life. If heat limits it, the changes are a smaller share of the
    time under load, and better cooling. The last two are a larger length, if it is limited, and a larger diameter.
    `strongest` is the drive with the largest torque T that was evaluated for the requirement, if any. The search of
    each change starts at the life of this drive, or where T should suffice by similarity: losses ~ T, diameter ~ T^1/3.
    """
    share = strongest.torque / requirement.torque if strongest else 1.0
    is_hot = strongest is not None and strongest.weakest.kind is ItemKind.HEAT
    max_values: dict[str, float] = {}
    if strongest and not requirement.duty:
        max_values |= {"life": strongest.rating.shortest_life} if strongest.weakest.life is not None else {}
        max_values |= {"duty_share": share * requirement.duty_share} if is_hot else {}
    for key, max_value in max_values.items():
        changes = [item for item in list_changes(requirement, key) if getattr(item.requirement, key) <= max_value]
        yield from first_feasible(changes, _is_feasible)
    yield from first_feasible(better_cooling(requirement) if is_hot else (), _is_feasible)
    any_length = requirement.but(length=math.inf)
    best = _search_shortest(any_length, candidates(any_length))[0] if requirement.length < math.inf else None
    if best:
        yield change_length(requirement, round_up_length(best.candidate.length))
    diameter = share ** (-1.0 / 3.0) * requirement.diameter
    changes = [item for item in list_changes(requirement, "diameter") if item.requirement.diameter >= diameter]
    yield from first_feasible(changes, _is_feasible)


def _is_feasible(requirement: RvRequirement) -> bool:
    """Return whether the search finds a drive that meets a requirement."""
    return _search_shortest(requirement, candidates(requirement))[0] is not None


def _sized_drive(requirement: RvRequirement, rated: RatedRv, title: str, why: str) -> SizedDrive:
    """Return a candidate with its main quantities by key, and the reason for each value of its design file.

    `rated` is the candidate with its computed torque limits, `requirement` is that for the drive. `title` is its
    heading, such as "lightest", and `why` a sentence on why it was chosen.
    """
    reducer, torque = rated.candidate.reducer, requirement.torque
    motion = {item.key: item.value for item in motion_figures(reducer, torque)}
    figures = {
        "ratio": reducer.design.reduction,
        "outer_diameter_mm": 2e3 * reducer.design.housing.outer_radius,
        "drive_length_mm": MILLIMETRES * rated.candidate.length,
        "mass_kg": rv_mass(reducer),
        "rated_torque_nm": rated.torque,
        "momentary_torque_nm": rated.momentary,
        "life_h": rated.rating.shortest_life,
        "temperature_c": thermal(reducer.design, requirement.duty_at(torque)).temperatures["housing"],
        "stiffness_nm_per_arcmin": motion["stiffness_ideal"],
        "backlash_arcmin": motion["backlash"],
    }
    return SizedDrive(title, why, reducer.design, figures, dict(_reasons_of_values(reducer.design, rated.weakest.name)))


def _reasons_of_values(design: Design, weakest: str) -> Iterator[tuple[str, str]]:
    """Yield pairs of a key of the design file and the reason for its value, such as ("drive.speed", "required").

    Only keys whose value was chosen are included. `weakest` is the name of the part that fails first.
    """
    assert design.planet is not None
    teeth = f"1 + {design.ring.teeth} x {design.planet.planet_teeth}/{design.planet.sun_teeth}"
    yield "ring.teeth", f"by the search: ratio {teeth}; an even number balances two discs"
    yield "ring.pin_circle_radius", "in proportion to the outer radius, as of rv80e"
    yield "ring.pin_radius", "dowel in stock nearest to a third of the distance of the pins"
    ratio = design.gear.eccentricity * design.ring.teeth / design.ring.pin_circle_radius
    yield "gear.eccentricity", f"by the search; K1 = c N / E = {ratio:.3g}"
    yield "gear.face_width", f"by the search; at the required torque {weakest} fails first"
    for key in ("sun_teeth", "planet_teeth"):
        yield f"planet.{key}", f"by the search: ratio {teeth}; the planets mesh with the sun"
    yield "planet.module", "the largest of ISO 54 for which the cranks fit next to the pins"
    yield "cranks.count", "by the search"
    bearing_text = RvReducer(design).crank_bearing_text
    yield "cranks.taper_radius", f"by the search, the crank bearings decide the life: {bearing_text}"
    yield "cranks.eccentric_radius", "bore of the tapered bearing, plus the eccentricity"
    for key in ("needle_radius", "needles"):
        yield f"cranks.{key}", "needle rollers in stock, nearest to the proportions of rv80e"
    for key in ("needle_stiffness", "taper_stiffness"):
        yield f"cranks.{key}", "that of rv80e, in proportion to number and length of the needles"
    for key in ("middle_hole_radius", "post_radius", "flange_thickness"):
        yield f"cranks.{key}", "by proportions of rv80e, the crank bearings, and walls between the holes"
    if bearing := RvReducer(design).main_bearing:
        yield "cranks.main_bearings", "required"
        yield "cranks.flange_thickness", f"by proportions of rv80e, or seat and shoulder of {bearing.designation}"
    for key in ("speed", "torque"):
        yield f"drive.{key}", "required"
    yield "drive.power", f"{POWER_RESERVE:g} times the power of torque and speed"
    yield "load.torque", "required"
