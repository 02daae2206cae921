"""Checks of shaft, play, material, drive and load."""

import math
from collections.abc import Iterator

from cycloid_mj.checks.limit import STRICT_MARGIN, Check, Demand, Limit, joint_change, millimetres, value_and_limit
from cycloid_mj.checks.teeth import pitches
from cycloid_mj.design import PARTS, Material
from cycloid_mj.design.units import DEGREE, MICROMETRE
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.limits import widest_play

PLAY_SHARE = 0.1
"""Assumed: most play of the whole gear, as a share of the smaller of c and rho, that is small against the teeth."""

JUMP_MARGIN = 1e-3
"""Relative; how far a remedy stays inside the limit on the play."""

JUMP_POSES, JUMP_SIDES = 4, 32
"""Crank angles at which a wide play is measured, and sides of the polygon around the cam's."""

OVERLOAD = 1.2
"""Assumed: most power that drive torque times speed may ask for, as a share of the rated power."""

PLAUSIBLE = {"youngs_modulus": (0.5e9, 700e9), "density": (800.0, 20000.0), "poisson": (0.1, 0.49)}
"""Assumed [SI]: from polymers to tungsten carbide. Beyond, it is mostly a slip of units."""


def mechanical_rules(reducer: Reducer, whole: bool) -> Iterator[Demand | Check]:
    """State the rules of what is not the shape of gear and ring; what stands on that only where it is `whole`."""
    design = reducer.design
    yield Demand(
        "output_pins",
        Limit("output.pins", "at least", 3),
        "two output pins carry no torque when they stand in line with the eccentricity",
    )
    yield from _output_root_rules(reducer)
    yield from _shaft_rules(reducer)
    if design.housing.support == "bolts" and design.ring_root_radius < design.housing.outer_radius:
        yield from _bolt_rules(reducer)
    yield from _play_checks(reducer, whole)
    tables = ("material", *(f"{part}_material" for part in PARTS))
    for table in tables:
        if material := getattr(design, table):
            yield from _material_rules(table, material)
    yield from _drive_rules(reducer)


def _material_rules(table: str, material: Material) -> Iterator[Demand]:
    """State the rules of one table of material; the names of a part's own begin with the part's."""
    part = table.removesuffix("material")
    yield Demand(
        f"{part}yield_strength",
        Limit(f"{table}.yield_strength", "at most", material.tensile_strength),
        "no material yields above its tensile strength",
        (Limit(f"{table}.tensile_strength", "at least", material.yield_strength),),
    )
    for name, (low, high) in PLAUSIBLE.items():
        side, bound = ("at most", high) if getattr(material, name) >= low else ("at least", low)
        limit = Limit(f"{table}.{name}", side, bound)
        why = "no material between polymers and tungsten carbide lies beyond (a slip of units?)"
        yield Demand(f"{part}{name}", limit, why, severity="warning")


def _output_root_rules(reducer: Reducer) -> Iterator[Demand]:
    output = reducer.design.output
    if output.rollers:
        yield Demand(
            "output_core",
            Limit("output.core_radius", "less than", output.pin_radius),
            "the core pin carries the roller round it",
            (Limit("output.pin_radius", "more than", output.core_radius),),
        )
    yield Demand(
        "output_fillet",
        Limit("output.fillet_radius", "less than", output.root_radius),
        "a fillet is to be smaller than the radius of the pin it rounds off",
    )


def _bolt_rules(reducer: Reducer) -> Iterator[Demand]:
    """State that the bolts' clamped circles lie within the wall behind the teeth, and apart from each other."""
    design = reducer.design
    outer, root, circle = design.housing.outer_radius, design.ring_root_radius, design.bolt_circle_radius
    above = Limit("housing.bolt_circle_radius", "more than", root)
    limit = Limit(above.key, "less than", outer) if circle > root else above
    why = f"the bolts stand in the wall between the teeth (out to {millimetres(root)}) and the rim"
    yield Demand("bolt_circle", limit, why)
    room = min(outer - circle, circle - max(root, 0.0))
    if not room > 0.0:
        return
    yield Demand("bolt_radius", Limit("housing.bolt_radius", "less than", room), why)
    if design.bolt_radius < room:
        yield Demand(
            "bolts",
            Limit("housing.bolts", "less than", pitches(design.bolt_radius / circle)),
            "neighbouring bolts would clamp the same place",
            (Limit("housing.bolt_radius", "less than", circle * math.sin(math.pi / design.housing.bolts)),),
        )


def _shaft_rules(reducer: Reducer) -> Iterator[Demand]:
    design = reducer.design
    shaft, c = design.shaft, design.gear.eccentricity
    yield Demand(
        "shaft",
        Limit("shaft.radius", "less than", design.gear.bore_radius - c),
        "the cam must enclose the shaft, or the gear cannot be slid on",
        (Limit("gear.bore_radius", "more than", shaft.radius + c),),
    )
    yield Demand(
        "shaft_fillet",
        Limit("shaft.fillet_radius", "at most", max(design.gear.bore_radius - c - shaft.radius, 0.0)),
        "the cam's shoulder, which is lowest opposite the eccentricity, leaves no more room for a fillet",
        (Limit("gear.bore_radius", "more than", shaft.radius + c + shaft.fillet_radius),),
    )
    if design.gear.discs > 1:  # they balance each other
        return
    yield Demand(
        "counterweight",
        Limit("shaft.counterweight_radius", "more than", shaft.radius),
        "the counterweight must stand out from the shaft",
        (Limit("shaft.radius", "less than", shaft.counterweight_radius),),
    )
    yield Demand(
        "counterweight_room",
        Limit("shaft.counterweight_radius", "less than", design.ring.pin_circle_radius - design.ring.pin_radius),
        "the counterweight turns inside the ring's teeth, which reach in to E - rho",
        (Limit("ring.pin_circle_radius", "more than", shaft.counterweight_radius + design.ring.pin_radius),),
    )


def _play_checks(reducer: Reducer, whole: bool) -> Iterator[Check]:
    """Check the clearances on the way from crank to ring and output: their sum, and what the output turns by them."""
    design = reducer.design
    names = design.pair_kinds
    total, allowed = _total_clearance(reducer)
    got, limit = value_and_limit(total, "at most", allowed, MICROMETRE)
    shares = [Limit(f"clearance.{name}", "at most", allowed / len(names)) for name in names]
    tighter = [] if total <= allowed else [share for share in shares if not share.holds(reducer)]
    yield Check(
        name="play",
        passed=total <= allowed,
        got=f"{got} ({' + '.join(names)})",
        limit=f"{limit} ({PLAY_SHARE:.0%} of the smaller of c and rho, assumed)",
        why="with more play the teeth leave their conjugate contact: statics and closed forms are estimates",
        remedy=" and ".join(share.remedy(reducer) for share in tighter),
        severity="warning",
        key="clearance",
        changes=joint_change(reducer, tighter),
    )
    if total > allowed and whole:
        yield _jump(reducer)


def _total_clearance(reducer: Reducer) -> tuple[float, float]:
    """Add the clearances on the way from crank to ring and output [m]; and what is usual at most."""
    design = reducer.design
    total = sum(getattr(design.clearance, name) for name in design.pair_kinds)
    return total, PLAY_SHARE * min(design.gear.eccentricity, design.ring.pin_radius)


def jumps(reducer: Reducer) -> bool:
    """Tell whether the gear jumps a tooth within its clearances, as `soundness` does: by the first angle that shows it.

    Gear and ring are to be sound.
    """
    total, usual = _total_clearance(reducer)
    return total > usual and any(play > _half_lobe(reducer) for play in _widest_plays(reducer))


def _half_lobe(reducer: Reducer) -> float:
    """Compute by how much the output turns as the gear does by half a lobe [rad]."""
    return reducer.share * math.pi / reducer.design.lobes


def _widest_plays(reducer: Reducer) -> Iterator[float]:
    """Yield the play of the output from stop to stop [rad] at a few crank angles."""
    poses = (2.0 * math.pi * pose / JUMP_POSES for pose in range(JUMP_POSES))
    return (widest_play(reducer, pose, JUMP_SIDES) for pose in poses)


def _jump(reducer: Reducer) -> Check:
    """Check that the teeth hold the gear: a run ends where it is a quarter of a lobe from where the crank puts it."""
    design = reducer.design
    play, allowed = max(_widest_plays(reducer)), _half_lobe(reducer)
    got, limit = value_and_limit(play, "at most", allowed, DEGREE)
    spared = (1.0 - JUMP_MARGIN) * allowed / play
    lower = [
        Limit(f"clearance.{name}", "at most", spared * getattr(design.clearance, name)) for name in design.pair_kinds
    ]
    return Check(
        name="jump",
        passed=play <= allowed,
        got=f"{got} from stop to stop",
        limit=f"{limit} (half a lobe)",
        why="with more play the gear jumps a tooth",
        remedy="" if play <= allowed else " and ".join(limit.remedy(reducer) for limit in lower),
        key="the output's play",
        value=DEGREE.from_si(play),
        bound=DEGREE.from_si(allowed),
        unit=DEGREE.suffix,
        changes=() if play <= allowed else joint_change(reducer, lower),
    )


def _drive_rules(reducer: Reducer) -> Iterator[Demand]:
    design = reducer.design
    drive, load = design.drive, design.load.torque
    speed = abs(drive.speed)
    yield Demand(
        "power",
        Limit("drive.power", "at least", drive.torque * speed / OVERLOAD),
        f"drive torque times speed is to be at most {OVERLOAD:g} times the rated power (assumed)",
        (Limit("drive.torque", "at most", OVERLOAD * drive.power / speed if speed else math.inf),),
        severity="warning",
    )
    capacity = design.rated_torque * (1.0 + STRICT_MARGIN)  # a load may be that torque, as it is rounded
    yield Demand(
        "load",
        Limit("load.torque", "at most", capacity) if load >= 0 else Limit("load.torque", "at least", -capacity),
        f"the rated drive torque times the ratio, {design.reduction}, is all that a drive without losses can move",
        (Limit("drive.torque", "at least", abs(load) / design.reduction),),
        severity="warning",
    )
