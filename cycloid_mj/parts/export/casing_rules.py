"""Rules for the parts of a casing: walls, threads, screw heads, shoulders and axial play, by the materials."""

from dataclasses import dataclass

from cycloid_mj.base import names
from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import stock
from cycloid_mj.parts.cam_bearing import needs_rings
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP


@dataclass(frozen=True)
class CasingRules:
    """Proportions of the casing that no standard prescribes; lengths in metres, all assumed unless a source is stated.

    Attributes
    ----------
    wall_share, min_wall, min_printed_wall
        Minimum wall around holes: share of the outer radius, and limits in metal and plastic (two lines of 0.4 mm).
    bearing_ratio
        Outside diameter of a shaft bearing relative to its bore, if none in stock fits (as its rollers are rated).
    pilot_depth
        Depth of the recess for the pilot of a motor.
    thread_share, max_screws
        Largest thread of the cover screws relative to the outer radius, and their number.
    engagement
        Engaged length of a thread, and least length of a motor shaft in the crank, in diameters.
    head_play
        Radial play of a screw head in its counterbore (DIN 974-1 has 0.5 mm, for which walls are too thin).
    flange_screws, flange_circle, flange_thread
        Numbers of screws of the output flange, of which the first that fits is taken; their circle radius and thread
        relative to the radius of the hub.
    axial_play, printed_axial_play
        Least distance of parts that move against each other, in metal and in plastic: above the flatness of a cover
        and the unevenness of a layer.
    blind_room
        Depth of the bore of the crank beyond the motor shaft: those of NEMA 17 are up to 24 instead of 22 mm long.
    collar
        Length of the collar of the crank between counterweight and bearing, and depth of recesses next to bearings.
    boss_share
        Wall around a bearing of the crank relative to the radius of its seat.
    """

    wall_share: float = 0.02
    min_wall: float = 0.5e-3
    min_printed_wall: float = 0.8e-3
    bearing_ratio: float = 1.4
    pilot_depth: float = 2.5e-3
    thread_share: float = 0.09
    max_screws: int = 8
    engagement: float = 1.5
    head_play: float = 0.2e-3
    flange_screws: tuple[int, ...] = (8, 6, 4)
    flange_circle: float = 0.8
    flange_thread: float = 0.16
    axial_play: float = 0.1e-3
    printed_axial_play: float = 0.2e-3
    blind_room: float = 3e-3
    collar: float = 0.5 * AXIAL_GAP
    boss_share: float = 0.3


RULES = CasingRules()


def ring_end(reducer: Reducer) -> float:
    """Compute half the width of the ring between the covers [m]."""
    return reducer.design.gear.stack_width / 2.0 + axial_play(reducer)


def axial_play(reducer: Reducer) -> float:
    """Return the least distance of parts that move against each other [m]."""
    return RULES.printed_axial_play if is_plastic(reducer) else RULES.axial_play


def least_wall(reducer: Reducer) -> float:
    """Compute the minimum wall around holes of a drive [m]."""
    min_wall = RULES.min_printed_wall if is_plastic(reducer) else RULES.min_wall
    return max(min_wall, RULES.wall_share * reducer.design.housing.outer_radius)


def thickest_bolt(thread: float, *, inserted: bool = False) -> stock.Bolt:
    """Return the thickest screw up to a thread [m], or the thinnest; `inserted`: of those with inserts in stock."""
    bolts = [bolt for bolt in stock.bolts() if not inserted or stock.insert_of(bolt.thread)]
    return max((bolt for bolt in bolts if bolt.thread <= thread), key=lambda bolt: bolt.thread, default=bolts[0])


def counterbore(bolt: stock.Bolt) -> float:
    """Compute the radius of the counterbore of a screw head [m]."""
    return 0.5 * bolt.head + RULES.head_play


def insert_in(reducer: Reducer, thread: float) -> stock.Insert | None:
    """Return the heat-set insert of a thread [m] in covers and hub; None in a metal, or if none is in stock."""
    return stock.insert_of(thread) if is_plastic(reducer) else None


def is_plastic(reducer: Reducer) -> bool:
    """Return whether covers and hub are of a plastic, as the housing."""
    return reducer.design.material_of(names.HOUSING).is_plastic


def is_printed(reducer: Reducer, part: str) -> bool:
    """Return whether plain round parts of the material of a part are printed (plastic) rather than bought (metal)."""
    return reducer.design.material_of(part).is_plastic


def is_crank_manufactured(reducer: Reducer) -> bool:
    """Return whether the shaft is manufactured, rather than a ground bar: one piece with cams, splined, or printed."""
    return reducer.design.cam_joint in ("one_piece", "spline") or is_printed(reducer, names.SHAFT)


def in_one_piece(reducer: Reducer) -> bool:
    """Return whether the output pins are printed with their disc: plastic, without rollers, supported at one end."""
    output = reducer.design.output
    return is_printed(reducer, names.OUTPUT) and not output.rollers and output.support == "cantilever"


def core_radius(reducer: Reducer, thread: float) -> float:
    """Compute the radius of the drilled hole of a thread, d - P, or of its insert [m]."""
    insert = insert_in(reducer, thread)
    return 0.5 * (insert.hole if insert else stock.thread_core(thread))


def thread_radius(reducer: Reducer, thread: float) -> float:
    """Compute the outer radius of a thread, or of its insert [m], around which a wall stays."""
    insert = insert_in(reducer, thread)
    return 0.5 * (insert.hole if insert else thread)


def hole_depth(reducer: Reducer, thread: float, reach: float) -> float:
    """Compute the depth of the hole of a thread or its insert, for a screw of some reach [m]."""
    insert = insert_in(reducer, thread)
    return max(reach, insert.length) if insert else reach


def stock_screw_length(bolt: stock.Bolt, min_length: float) -> float:
    """Return the shortest length in stock [m] of a screw that is at least `min_length` [m] long.

    `bolt` is the size of the screw in stock.

    Raises
    ------
    DesignError
        All screws in stock are shorter.
    """
    length = stock.bolt_length(bolt.thread, min_length)
    if length is None:
        raise DesignError(
            f"the casing needs {bolt.designation} screws at least {1e3 * min_length:.4g} mm long, but the longest "
            f"standard screw is {1e3 * stock.bolt_lengths(bolt.thread)[-1]:.4g} mm: reduce housing.outer_radius_mm; "
            "thinner walls take smaller, shorter screws"
        )
    return length


def stock_shaft_bearing(reducer: Reducer, width: float) -> stock.StockBearing | None:
    """Return the bearing in stock for seats of the shaft that are `width` [m] wide; None if none has this size."""
    diameter = 2.0 * reducer.design.shaft.radius
    return next(iter(stock.bearings_on(diameter, width, ringed=needs_rings(reducer))), None)


def shoulder_radius(ring: float, other: float) -> float:
    """Compute the radius of a shoulder [m] that touches the ring of a bearing with the first radius only."""
    return ring + stock.SHOULDERS.ball * (other - ring)


def flange_washer(reducer: Reducer, bolt: stock.Bolt) -> tuple[float, float]:
    """Return the radius of a flange screw's counterbore [m] and the thickness of the washer in it [m]; 0 in a metal."""
    if not is_plastic(reducer):
        return counterbore(bolt), 0.0
    washer = stock.washer_of(bolt.thread)
    return max(counterbore(bolt), 0.5 * washer.outside + RULES.head_play), washer.thickness


def min_grip(bolt: stock.Bolt, wall: float) -> float:
    """Return the least thickness of a part under the heads of its screws [m]."""
    return max(bolt.thread, 2.0 * wall)
