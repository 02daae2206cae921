"""Candidate drives: points of the unit cube, decoded to sizes in stock, and the complete designs of them."""

import math
from collections.abc import Sequence
from functools import cache, lru_cache, partial
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.checks import WALLS, sound_checks
from cycloid_mj.checks.body import bearing_room_rule
from cycloid_mj.checks.teeth import TEETH
from cycloid_mj.design import PRESETS, Design, Material, override, stock
from cycloid_mj.design.lubricants import greased_friction
from cycloid_mj.design.model import Gear
from cycloid_mj.design.processes import PROCESSES, TOLERANCE_SHARE, usual_tolerances
from cycloid_mj.design.units import bounds_of
from cycloid_mj.explore.sampling import tolerance_zones
from cycloid_mj.life import rolling
from cycloid_mj.life.estimate import SIZES, SIZES_DTYPE, Sizes
from cycloid_mj.parts.export.bearings import output_pin
from cycloid_mj.parts.export.casing import casing, cover_radius
from cycloid_mj.parts.export.casing_rules import RULES
from cycloid_mj.parts.export.motors import MOTORS
from cycloid_mj.parts.export.rules import describe_missing_dowels
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP
from cycloid_mj.sizing.requirement import Requirement

PIN_ROOM = 0.3, 0.86
"""Radius of a ring pin over half the distance of its neighbours: thinner pins dent, thicker leave no wall (assumed)."""

SHORT_WIDTHS = 0.3, 0.9
"""K1 = c N / E: below, the flanks push outwards more than around; above, they are undercut (assumed)."""

WIDTHS = 0.1, 1.2
"""Face width of all discs relative to the pin circle: a narrower disc warps, a wider one tilts (assumed)."""

MAX_WIDTH = bounds_of(Gear.model_fields["face_width"])["le"]
"""Largest face width that a design may have [m]."""

OUTPUT_PINS = np.array([4, 5, 6, 8, 10, 12])
WALL_SHARES = (0.06, 0.09, 0.12, 0.16, 0.2, 0.25)
"""Numbers of output pins (heuristic); walls outside the pins relative to the outer radius of the ring."""

GAP_SHARE, DISC_SHARE = 0.04, 0.15
"""Gap between discs, and thickness of an output disc, relative to the outer radius (assumed)."""

CORE_SHARE, ROLLER_SHARE = 0.8, 1.15
"""Largest core of an output pin over its sleeve, and smallest roller over the needle bearing in it (assumed walls)."""

DIMENSIONS = 9
"""Variables of the cube: wall, pin, eccentricity, width, bore, shaft, number, size and bearing of the output pins."""

POWER_RESERVE = 1.1
"""Power of the motor relative to that of torque and speed (heuristic)."""

JAMMING_DEVIATIONS = 2.33
"""Standard deviations of a clearance that it must exceed: 1 % of a normal distribution is beyond them."""

ROUNDING = 2.5e-6
"""Step of free dimensions [m]."""


def decode(requirement: Requirement, points: Array) -> tuple[Array, Sizes]:
    """Convert points of the unit cube to candidate drives, as far as stock parts and walls permit.

    Parameters
    ----------
    requirement
        Ratio, diameter, process and other limits of the drive.
    points
        The n points (n, `DIMENSIONS`). Each coordinate, 0 to 1, selects one of the sizes that are compatible with those
        of the previous coordinates.

    Returns
    -------
    tuple
        The points whose drives have parts in stock and thick enough walls, shape (m, `DIMENSIONS`), and a record array
        of their m drives with the fields `SIZES`, in SI units.
    """
    teeth, discs, is_custom, coords = requirement.ratio + 1, requirement.discs or 1, requirement.custom, points.T
    rings = _list_rings(requirement.ratio, requirement.diameter / 2.0, is_custom, requirement.made_of)
    if not (rings and len(points)):
        return points[:0], np.rec.fromarrays([np.empty(0)] * len(SIZES), dtype=SIZES_DTYPE)
    pin, outer, wall, max_width = np.array(rings)[_choose(coords[1], len(rings))].T
    max_circle = outer - wall - pin
    steps = np.floor(np.maximum(coords[0] - 0.5, 0.0) * 10.0)  # of preferred numbers (R40, ISO 3) below the largest
    preferred = 10.0 ** ((np.floor(40.0 * np.log10(max_circle)) - steps + 1.0) / 40.0)
    circle = _round_down(np.where(steps > 0.0, np.minimum(preferred, max_circle), max_circle))
    eccentricity = _round_down(np.interp(coords[2], (0.0, 1.0), SHORT_WIDTHS) * circle / teeth)
    gap = _gap(requirement)
    width = np.minimum(np.exp(np.interp(coords[3], (0.0, 1.0), np.log(WIDTHS))) * circle, MAX_WIDTH)
    stack = width if is_custom else _round_to_pin_lengths(pin, width)
    face = (_round_down(stack) - (discs - 1) * gap) / discs
    root = circle - eccentricity - pin - requirement.usual_clearance
    bore, cam, cam_dynamic, cam_static, has_cam = _cam_bearings(coords[4], root, face, is_custom)
    max_shaft = np.minimum(0.85 * bore, cam) - eccentricity
    shaft, bearing, shaft_dynamic, shaft_static, has_shaft = _shaft_bearings(
        coords[5], _least_shaft(requirement), max_shaft, discs > 1, is_custom
    )
    count = OUTPUT_PINS[_choose(coords[6], len(OUTPUT_PINS))]
    middle, band = 0.5 * (bore + root), root - bore - 0.03 * circle
    max_hole = np.minimum(0.5 * band, middle * np.sin(np.pi / count) - 0.01 * circle)
    stud = _round_down(np.interp(coords[7], (0.0, 1.0), (0.4, 1.0)) * max_hole - eccentricity)
    is_bare = has_plastic_discs(requirement) & (coords[8] >= 0.75)
    if has_plastic_discs(requirement):
        tube, dowel = (_round_to_stock(stud, sizes) for sizes in (stock.tube_outsides(), stock.dowel_diameters()))
        stud = np.where(is_bare, dowel, np.where(tube > 0.0, tube, stud))  # thinner sleeves are turned
    thickness = DISC_SHARE * requirement.diameter / 2.0
    core, needle_dynamic, disc_thickness, has_core = _choose_core_pins(
        coords[8], stud, is_bare, face, discs * face + (discs - 1) * gap, thickness, is_custom
    )
    valid = (
        has_cam & has_shaft & has_core & (face > 0.1 * gap) & (root - bore > 0.0) & (pin < root) & (pin > eccentricity)
    )
    columns = [outer, circle, pin, eccentricity, face, bore, cam_dynamic, cam_static, shaft, bearing, shaft_dynamic]
    columns += [shaft_static, count.astype(float), _round_down(middle), stud, core, needle_dynamic, disc_thickness]
    sizes = np.rec.fromarrays(columns, dtype=SIZES_DTYPE)
    valid &= (stud > 0.0) & (shaft > 0.0) & (stack <= max_width)
    # the wall between sockets, as the check "neighbouring_pins"
    valid &= pin + requirement.usual_clearance < (math.sin(math.pi / teeth) - 0.5 * TEETH.min_wall_share) * circle
    valid &= is_bare | _turns_in_holes(requirement, stud)
    return points[valid], sizes[valid]


def has_plastic_discs(requirement: Requirement) -> bool:
    """Return whether discs are of plastic, whose output pins are dowels alone or have sleeves cut from tubes in stock.

    Pins and sleeves of any size (`Requirement.custom`) are excluded.
    """
    return Material(name=requirement.made_of).is_plastic and not requirement.custom


def _tube_deviation(requirement: Requirement, radius: float) -> float:
    """Return the standard deviation of the radius of an output sleeve [m]: that of a tube in stock, or 0 if turned."""
    is_tube = has_plastic_discs(requirement) and stock.is_tube(2.0 * radius)
    return 0.5 * stock.tube_tolerance(2.0 * radius) / math.sqrt(3.0) if is_tube else 0.0


def _turns_in_holes(requirement: Requirement, radius: Array) -> Mask:
    """Return whether output sleeves of n radii [m] have clearance in 99 % of drives, in spite of a tube's tolerance."""
    is_free = np.ones(len(radius), bool)
    for outside in stock.tube_outsides() if has_plastic_discs(requirement) and not requirement.fit else ():
        clearance = requirement.clearance_at(outside)
        deviation = math.hypot(TOLERANCE_SHARE * clearance, _tube_deviation(requirement, 0.5 * outside))
        if JAMMING_DEVIATIONS * deviation >= clearance:
            is_free &= radius != 0.5 * outside
    return is_free


def _round_to_stock(radius: Array, diameters: Sequence[float]) -> Array:
    """Round n radii [m], shape (n,), down to those of parts with ascending `diameters` [m]; 0 for thinner parts."""
    sizes = 0.5 * np.array((0.0, *diameters))
    return np.asarray(sizes[np.searchsorted(sizes, radius + ROUNDING, side="right") - 1])


def _choose(share: Array, count: int | Integers) -> Integers:
    return np.asarray(np.minimum(np.floor(share * count), np.asarray(count) - 1).astype(np.int64))


def _round_down(length: Array) -> Array:
    """Round free lengths [m] down."""
    return np.round(np.floor(length / ROUNDING + 1e-6) * ROUNDING, 9)


def _gap(requirement: Requirement) -> float:
    return float(_round_down(np.array(GAP_SHARE * requirement.diameter / 2.0)))


@lru_cache(maxsize=64)
def _list_rings(
    ratio: int, outer: float, is_custom: bool, material: str
) -> tuple[tuple[float, float, float, float], ...]:
    """List rings of fixed pins whose covers stay within the outer radius of the drive.

    Parameters
    ----------
    ratio
        Ratio, one less than the number of pins.
    outer
        Outer radius of the drive [m].
    is_custom
        Whether pins of any radius are allowed, not only those in stock.
    material
        Name of the material of the ring.

    Returns
    -------
    tuple
        For each ring four lengths [m]: radius of its pins, its outer radius, thickness of the wall outside the pins,
        and its largest width. A ring with the outer radius of the drive has its screws in the wall, and the screws in
        stock limit its width. A smaller ring has its screws outside, and its width is not limited (inf); a ring of
        plastic then has room for the dowels that keep it from turning.
    """
    half_pitch_sine = math.sin(math.pi / (ratio + 1))
    low, high = (share * half_pitch_sine / (1.0 + share * half_pitch_sine) * outer for share in PIN_ROOM)
    sizes = np.geomspace(low, high, 24) if is_custom else (0.5 * size for size in stock.pin_diameters())
    fitting = [float(round(size, 9)) for size in sizes if 0.8 * low <= size <= high]

    def covers(ring_outer: float, pin: float, wall: float, width: float) -> float:
        """Return the outer radius of the covers of a ring [m]: larger than its own if the screws are outside of it."""
        circle = {"teeth": ratio + 1, "pin_radius": pin, "pin_circle_radius": ring_outer - wall - pin}
        housing = {"outer_radius": ring_outer, **({} if is_custom else clamping(wall))}
        tables = {"ring": circle, "gear": {"face_width": width}, "housing": housing, "material": {"name": material}}
        return cover_radius(Reducer(PRESETS["pin"].but(**tables)))

    min_wall = _dowelled_wall(outer) if Material(name=material).is_plastic else 0.0
    rings = []
    for pin in fitting[:: max(len(fitting) // 24, 1)]:
        # at the smallest outer radius, the pin circle has no radius
        ring_outer, thin_wall = outer, max(WALL_SHARES[0] * outer, min_wall)
        for _ in range(3):  # a fixed point: the screws depend on the radius
            if ring_outer > pin + thin_wall:
                ring_outer -= max(covers(ring_outer, pin, thin_wall, 1.0) - outer, 0.0)
                thin_wall = max(WALL_SHARES[0] * ring_outer, min_wall)
        if ring_outer > pin + thin_wall:
            rings.append((pin, float(_round_down(np.array(ring_outer))), thin_wall, math.inf))
        max_width = 0.0
        for wall in (share * outer for share in WALL_SHARES):
            widths = (min(share * (outer - wall - pin), MAX_WIDTH) for share in (WIDTHS[1], 0.6, 0.3, WIDTHS[0]))
            larger = (width for width in widths if width > max_width and covers(outer, pin, wall, width) == outer)
            if width := next(larger, 0.0):
                max_width = width
                rings.append((pin, outer, wall, width))
    return tuple(rings)


def _dowelled_wall(outer: float) -> float:
    """Return the wall of a plastic ring outside its pins [m] with room for the thinnest dowel between two walls.

    `outer` is the outer radius of the drive [m], which determines the minimum thickness of both walls.
    """
    wall = max(RULES.min_printed_wall, RULES.wall_share * outer)
    return 2.0 * wall + stock.dowel_diameters()[0] + ROUNDING


def clamping(wall: float) -> dict[str, object]:
    """Return the values of the table ``housing`` that fasten a ring with a wall behind its teeth [m].

    These are the largest screws in stock that fit into the wall; a seat all round if none does.
    """
    screw = stock.bolt_under(CORE_SHARE * wall)
    return {"support": "bolts", "bolt_radius": round(0.5 * screw.head, 9)} if screw else {"support": "rim"}


def _round_to_pin_lengths(pin: Array, width: Array) -> Array:
    """Round n widths [m] to the nearest lengths of pins in stock, shape (n,), where there is a length nearby.

    `pin` (n,) [m] are the radii of the pins, and `width` (n,) the widths. Other widths are unchanged.
    """
    lengths = _round_down(width)
    for size in np.unique(pin).tolist():
        rows = np.flatnonzero(pin == size)
        lengths[rows] = stock.stock_pin_lengths(2.0 * size, lengths[rows])
    return lengths


@cache
def _needle_bearings(bores: tuple[float, ...] = ()) -> Sizes:
    """Return the needle bearings in stock: bore, outside diameter and width [m], and load ratings [N].

    If `bores` [m] are passed, only bearings with one of them are included.
    """
    keys = "bore", "outside", "width", "dynamic", "static"
    fitting = [item for item in stock.needle_bearings() if not bores or item.bore in bores]
    columns = [np.array([getattr(item, key) for item in fitting]) for key in keys]
    return np.rec.fromarrays(columns, dtype=np.dtype([(key, float) for key in keys]))


def _rate_rollers(count: float, size: Array, length: Array, pitch: Array) -> tuple[Array, Array]:
    """Return the dynamic and static ratings of n rows of rollers [N] by diameter, length and pitch diameter [m]."""
    dynamic, static = np.vectorize(rolling.dynamic_capacity), np.vectorize(rolling.static_capacity)
    return dynamic(count, size, length, pitch), static(count, size, length, pitch)


def _choose_bearing(share: Array, table: Sizes, fitting: Mask) -> tuple[Sizes, Mask]:
    """Return bearings of a table by a share of those that fit, (n, bearings) -> (n,), and whether there is one."""
    order: Integers = np.cumsum(fitting, axis=1, dtype=np.int64)
    wanted = _choose(share, order[:, -1]) + 1
    has_bearing = order[:, -1] > 0
    return table[np.where(has_bearing, (order >= wanted[:, None]).argmax(axis=1), -1)].view(np.recarray), has_bearing


def _cam_bearings(choice: Array, root: Array, face: Array, is_custom: bool) -> tuple[Array, Array, Array, Array, Mask]:
    """Choose the bearing of the cam for each of n candidates.

    Its outer radius is 0.25 to 0.7 of the root radius of the disc, and it is no wider than the disc.

    Parameters
    ----------
    choice
        Position of the choice in the list of suitable bearings, from 0 (first) to 1 (last), shape (n,).
    root, face
        Root radius and width of the disc [m], shape (n,) each.
    is_custom
        Whether bearings of any size are allowed, not only those in stock.

    Returns
    -------
    tuple
        Outer and inner radius of a bearing [m]; dynamic and static rating [N] of the bearings that fit side by side in
        a disc; and whether there is a suitable bearing; shape (n,) each.
    """
    if is_custom:
        bore = _round_down(np.interp(choice, (0.0, 1.0), (0.25, 0.65)) * root)
        positive = np.maximum(bore, ROUNDING)  # a disc without room for a bore is not valid
        size = positive * math.sin(math.pi / 20.0) / (1.0 - math.sin(math.pi / 20.0)) * 0.85
        return bore, bore, *_rate_rollers(20.0, 2.0 * size, np.maximum(face, ROUNDING), 2.0 * positive), bore > 0.0
    table = _needle_bearings()
    fits_radius = (table.outside >= 0.5 * root[:, None]) & (table.outside <= 1.4 * root[:, None])
    fitting = fits_radius & (table.width <= face[:, None] * (1.0 + 1e-9))
    chosen, has_bearing = _choose_bearing(choice, table, fitting)
    count = np.maximum(np.floor(face / chosen.width + 1e-6), 1.0)
    ratings = count ** (7.0 / 9.0) * chosen.dynamic, count * chosen.static
    return np.round(0.5 * chosen.outside, 9), 0.5 * chosen.bore, *ratings, has_bearing


def _least_shaft(requirement: Requirement) -> float:
    """Return the smallest radius of a crank with a bore for the shaft of the required motor [m]; 0 without a shaft."""
    shaft = MOTORS[requirement.motor].shaft if requirement.motor in MOTORS else 0.0
    least = RULES.min_printed_wall if Material(name=requirement.made_of).is_plastic else RULES.min_wall
    return shaft + 2.0 * max(least, RULES.wall_share * requirement.diameter / 2.0) if shaft else 0.0


def _shaft_bearings(
    choice: Array, min_radius: float, max_radius: Array, needs_bar: bool, is_custom: bool
) -> tuple[Array, Array, Array, Array, Mask]:
    """Choose a bearing of the shaft for each of n candidates; a small `choice` selects a thick shaft.

    Parameters
    ----------
    choice
        Position of the choice in the list of suitable bearings, from 0 (first) to 1 (last), shape (n,).
    min_radius
        Smallest radius of the shaft [m].
    max_radius
        Largest radius of the shaft [m], shape (n,).
    needs_bar
        Whether the shaft must be a ground bar in stock.
    is_custom
        Whether bearings of any size are allowed, not only those in stock.

    Returns
    -------
    tuple
        Radius of the shaft [m]; width of the bearing [m], 0 if `is_custom`; its dynamic and static rating [N]; and
        whether there is a suitable bearing; shape (n,) each.
    """
    if is_custom:
        thickest = np.maximum(max_radius, ROUNDING)
        radius = _round_down(np.interp(choice, (0.0, 1.0), (1.0, 0.6)) * thickest)
        positive = np.maximum(radius, ROUNDING)
        size = np.maximum(0.4 * radius, ROUNDING)
        ratings = _rate_rollers(14.0, size, positive, 2.0 * positive + size)
        return radius, np.zeros_like(radius), *ratings, radius > min_radius
    table = _needle_bearings(stock.bar_diameters() if needs_bar else ())
    table = table[np.lexsort((-np.arange(len(table)), table.width, -table.bore))].view(np.recarray)
    min_bores = np.maximum(1.2 * max_radius[:, None], 2.0 * min_radius)
    fitting = (table.bore <= 2.0 * max_radius[:, None] * (1.0 + 1e-9)) & (table.bore >= min_bores)
    chosen, has_bearing = _choose_bearing(choice, table, fitting)
    return np.round(0.5 * chosen.bore, 9), chosen.width, chosen.dynamic, chosen.static, has_bearing


def _choose_core_pins(
    choice: Array,
    roller_radius: Array,
    is_bare: Mask,
    face: Array,
    stack: Array,
    usual_thickness: float,
    is_custom: bool,
) -> tuple[Array, Array, Array, Mask]:
    """Choose the core pins of output rollers for each of n candidates: dowels in needle bearings, in sleeves, or alone.

    Parameters
    ----------
    choice
        Choice from 0 to 1, shape (n,): one of the suitable needle bearings below 0.5, a plain sleeve from 0.5.
    is_bare
        Whether a pin is a dowel alone, with the radius in `roller_radius`, shape (n,).
    roller_radius, face, stack
        Outer radius of the rollers, width of a disc, and width of all discs together [m], shape (n,) each.
    usual_thickness
        Usual thickness of the output discs [m]. To suit the length of a dowel in stock, they may be up to 1.5 times
        thicker or thinner.
    is_custom
        Whether dowels of any size are allowed, not only those in stock.

    Returns
    -------
    tuple
        Radius of the core [m], dynamic rating of the needles [N] (0 without), thickness of the output discs [m],
        and whether there is a dowel of suitable radius and length; shape (n,) each.
    """
    dowels = np.array(stock.dowel_diameters()) / 2.0
    fitting = dowels <= CORE_SHARE * roller_radius[:, None]
    plain_core = np.where(fitting.any(axis=1), dowels[fitting.shape[1] - 1 - fitting[:, ::-1].argmax(axis=1)], 0.0)
    plain_core = _round_down(CORE_SHARE * np.maximum(roller_radius, 0.0)) if is_custom else plain_core
    plain_core = np.where(is_bare, roller_radius, plain_core)
    cups = _needle_bearings(stock.dowel_diameters())
    fitting = (ROLLER_SHARE * cups.outside <= 2.0 * roller_radius[:, None]) & (
        1.6 * cups.outside >= 2.0 * roller_radius[:, None]
    )
    fitting &= cups.width <= face[:, None] * (1.0 + 1e-9)
    chosen, has_cup = _choose_bearing(np.minimum(2.0 * choice, 1.0), cups, fitting)
    has_needles = has_cup & (choice < 0.5)
    count = np.maximum(np.floor(face / chosen.width + 1e-6), 1.0)
    core = np.round(np.where(has_needles, 0.5 * chosen.bore, plain_core), 9)
    inner_length, disc = stack + 2.0 * AXIAL_GAP, np.full_like(stack, _round_down(np.array(usual_thickness)))
    has_dowel = core > 0.0
    for size in () if is_custom else np.unique(core[core > 0.0]).tolist():
        rows = np.flatnonzero(core == size)
        lengths = stock.stock_pin_lengths(2.0 * size, inner_length[rows] + 2.0 * usual_thickness, max_count=1)
        thickness = np.round(0.5 * (lengths - inner_length[rows]), 9)
        is_usual = (usual_thickness / 1.5 <= thickness) & (thickness <= 1.5 * usual_thickness)
        is_dowel = cache(partial(stock.is_dowel, 2.0 * size))  # most candidates share a few lengths
        in_stock = [is_dowel(length) for length in lengths.tolist()]
        disc[rows], has_dowel[rows] = thickness, is_usual & in_stock
    return np.asarray(core, float), np.where(has_needles, count ** (7.0 / 9.0) * chosen.dynamic, 0.0), disc, has_dowel


def build_drive(requirement: Requirement, sizes: Sizes, torque: float) -> Reducer | None:
    """Build the drive of a candidate as `assemble_drive`; return None if it cannot be built or assembled."""
    try:
        return assemble_drive(requirement, sizes, torque)
    except CycloidError:
        return None


def assemble_drive(requirement: Requirement, sizes: Sizes, torque: float) -> Reducer:
    """Build the drive of a candidate for an output torque [N m].

    `requirement` is that for the drive. `sizes` are the dimensions of the candidate. A metal drive gets preloaded
    output bearings if they fit.

    Raises
    ------
    CycloidError
        The drive cannot be built or assembled, for the reason in the message.
    """
    reducer = _with_shaft_length(Reducer(design_of(requirement, sizes, torque)))
    if preloaded := with_preloaded_bearings(requirement, reducer):
        return preloaded
    _require_buildable(requirement, reducer)
    return reducer


def with_preloaded_bearings(requirement: Requirement, reducer: Reducer) -> Reducer | None:
    """Return a drive with a preloaded pair of angular contact bearings at its output.

    None if it cannot be built, if its parts are of plastic, or if the requirement sets the bearings by ``--set``.
    """
    key = "output.main_bearings"
    if Material(name=requirement.made_of).is_plastic or any(item.startswith(key) for item in requirement.changes):
        return None
    changed = reducer.but(output={"main_bearings": "angular_contact"})
    try:
        _require_buildable(requirement, changed)
    except CycloidError:
        return None
    return changed


def _require_buildable(requirement: Requirement, reducer: Reducer) -> None:
    """Raise CycloidError unless a drive passes its checks, fits into the diameter, and has pins and dowels in stock.

    `requirement` is that for the drive.
    """
    if requirement.fit:
        tolerance_zones(reducer)  # raises an error if the fit is not tabulated at the diameter of a pair
    drive_casing = casing(reducer, requirement.motor)
    if 2.0 * drive_casing.outer > requirement.diameter + ROUNDING:
        raise CycloidError("the covers with their screws need a larger diameter")
    reasons = [*describe_missing_dowels(reducer, drive_casing)]
    reasons += [
        f"{item.key} is {item.got} and must be {item.limit}"
        for item in sound_checks(reducer)
        if not item.passed and (item.severity == "error" or item.name in WALLS)
    ]
    if not reasons and not requirement.custom and output_pin(reducer) is None:
        reasons = ["no dowel in stock has the diameter and length of the output pins"]
    if reasons:
        raise CycloidError(reasons[0])


def design_of(requirement: Requirement, sizes: Sizes, torque: float = 1.0) -> Design:
    """Return the design of a candidate for a torque [N m], which may not fit together."""
    return override(PRESETS["pin"].but(**_design_tables(requirement, sizes, torque)), requirement.changes)


def _design_tables(requirement: Requirement, sizes: Sizes, torque: float) -> dict[str, Any]:
    """Return the design file of a candidate drive as tables by name, each with values in SI units by key.

    `requirement` is that for the drive. `sizes` are the dimensions of the candidate with the fields `SIZES`, and
    `torque` is its output torque [N m].
    """
    size = dict(zip(SIZES, map(float, sizes), strict=True))
    limits, discs = PROCESSES[requirement.process], requirement.discs or 1
    pin_clearance, file = requirement.clearance_at(2.0 * size["pin"]), _round_to_file
    cam_clearance = requirement.cam_clearance_at(2.0 * size["bore"])
    needles, is_bare = size["needle_dynamic"] > 0.0, size["core"] == size["stud"]
    tube_deviation = 0.0 if is_bare else _tube_deviation(requirement, size["stud"])
    wall, friction = size["outer"] - size["circle"] - size["pin"], {}
    if Material(name=requirement.made_of).is_plastic:
        friction = {"boundary": round(sum(greased_friction(requirement.made_of)) / 2.0, 4)}
    return {
        "name": "new",
        "structure": "springs",
        "ring": {
            "teeth": requirement.ratio + 1,
            "pin_circle_radius": file(size["circle"]),
            "pin_radius": size["pin"],
            **limits.changes.get("ring", {}),
        },
        "gear": {
            "discs": discs,
            "disc_gap": _gap(requirement),
            "eccentricity": file(size["eccentricity"]),
            "face_width": file(size["face"]),
            "bore_radius": size["bore"],
        },
        "output": {
            "rollers": not is_bare,
            "roller_bearing": "needles" if needles else "plain",
            "pins": int(size["count"]),
            "pin_radius": file(size["stud"]),
            "core_radius": 0.0 if is_bare else size["core"],
            "pin_circle_radius": file(size["circle_out"]),
            "hole_radius": file(size["stud"] + size["eccentricity"]),
            "disc_thickness": file(size["disc"]),
            "support": "both_ends",
        },
        "bearing": {"output_dynamic_capacity": size["needle_dynamic"]},
        "shaft": {
            "radius": size["shaft"],
            "bearing_width": size["bearing"],
            "counterweight_radius": file(0.75 * (size["circle"] - size["pin"])),
            "length": file(0.3 * size["circle"]),
            "mounting": "straddle",
        },
        "housing": {"outer_radius": file(size["outer"]), **({} if requirement.custom else clamping(wall))},
        "clearance": dict.fromkeys(("pin_gear", "pin_socket", "pin_sleeve", "tooth"), pin_clearance)
        | {"cam": cam_clearance, "output": requirement.clearance_at(2.0 * size["stud"])},
        "tolerance": usual_tolerances(pin_clearance, discs, requirement.fit, tube_deviation)
        | {"cam": usual_tolerances(cam_clearance, discs, requirement.fit)["cam"]},
        **conditions(requirement, torque),
        "material": {"name": requirement.made_of},
        **{table: dict(values) for table, values in limits.changes.items() if table not in ("ring", "friction")},
        "friction": {**limits.changes["friction"], **friction},
    }


def conditions(requirement: Requirement, torque: float = 0.0) -> dict[str, dict[str, Any]]:
    """Return the tables ``drive`` and ``service`` of a design: the operating conditions of a requirement, by key.

    `torque` is the output torque [N m]; if it is 0, ``drive`` has neither torque nor power.
    """
    motor_torque = {"torque": torque / requirement.ratio} if torque else {}
    power = {"power": POWER_RESERVE * requirement.speed * torque / requirement.ratio} if torque else {}
    return {
        "drive": {**motor_torque, **power, "speed": requirement.speed},
        "service": {
            "life": requirement.life,
            "duty_share": requirement.duty_share,
            "film_coefficient": requirement.film,
            "ambient_temperature": requirement.ambient,
        },
    }


def _with_shaft_length(reducer: Reducer) -> Reducer:
    """Return the drive with the shaft length that its bearing and the counterweight need."""
    shaft = reducer.design.shaft
    needed = max(2.0 * shaft.radius, 1.1 * shaft.bearing_width)
    if reducer.design.gear.discs == 1:
        needed = bearing_room_rule(reducer).limit.bound + (0.5 if shaft.bearing_width else 1.5) * shaft.radius
    return reducer.but(shaft={"length": _round_to_file(math.ceil(needed / ROUNDING) * ROUNDING)})


def _round_to_file(length: float) -> float:
    """Return a length [m] rounded to the digits of the design file."""
    return round(MILLIMETRES * length, 6) / MILLIMETRES
