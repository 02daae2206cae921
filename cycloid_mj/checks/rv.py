"""Checks of an RV reducer: planets that mesh, dead points, and room for crank bearings, planets, posts and windows."""

import math
from collections.abc import Iterator
from itertools import chain

from cycloid_mj.base.units import MILLIMETRES, in_mm
from cycloid_mj.checks.check import Check
from cycloid_mj.checks.limit import Limit, millimetres
from cycloid_mj.checks.mechanics import material_rules
from cycloid_mj.checks.rule import Rule, evaluate, wall_rule
from cycloid_mj.checks.teeth import TEETH, tooth_rules
from cycloid_mj.design import PARTS, stock
from cycloid_mj.geometry.rv import dead_points, meshing_planet_teeth, planet_misfit
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.rv_main_bearings import (
    main_bearing_space,
    min_flange_thickness,
    stop_ring_thickness,
)


def rv_checks(reducer: RvReducer) -> Iterator[Check]:
    """Yield the checks that an RV reducer can be assembled and turned.

    They are about the teeth of disc and ring, the mesh of the planets, dead points, walls, flanges, posts and
    materials.
    """
    return evaluate(
        reducer,
        chain(
            tooth_rules(reducer),
            (_check_planet_mesh(reducer), _check_dead_points(reducer), _check_crank_circle(reducer)),
            _check_stage_teeth(reducer),
            _wall_rules(reducer),
            _flange_rules(reducer),
            (_post_rule(reducer),),
            _main_bearing_rules(reducer),
            _all_material_rules(reducer),
        ),
    )


def _all_material_rules(reducer: RvReducer) -> Iterator[Rule | Check]:
    """Yield the rules for the values of all material tables that the design has."""
    for table in ("material", *(f"{part}_material" for part in PARTS)):
        if material := getattr(reducer.design, table):
            yield from material_rules(table, material)


def _check_planet_mesh(reducer: RvReducer) -> Check:
    """Return the check that identical planets at equal angles mesh with the sun: their number divides z_s + z_p.

    z_s and z_p are the numbers of teeth of the sun and of a planet.
    """
    planet, planet_count = reducer.planet, reducer.cranks.count
    misfit = planet_misfit(planet.sun_teeth, planet.planet_teeth, planet_count)
    meshing_teeth = meshing_planet_teeth(planet.sun_teeth, planet.planet_teeth, planet_count)
    tooth_sum = planet.sun_teeth + planet.planet_teeth
    return Check(
        name="planets_mesh",
        passed=misfit == 0,
        got=f"{planet.sun_teeth} + {planet.planet_teeth} = {tooth_sum} teeth of sun and planet",
        limit=f"a multiple of {planet_count}, the number of planets",
        why="otherwise the teeth of equal planets on equal angles miss the sun's by "
        + (f"{misfit} of a pitch" if misfit else "a part of a pitch"),
        remedy="" if misfit == 0 else "set planet.planet_teeth to " + " or ".join(map(str, meshing_teeth)),
        key="planet.planet_teeth",
        changes=() if misfit == 0 else tuple({"planet.planet_teeth": teeth} for teeth in meshing_teeth),
    )


def _check_dead_points(reducer: RvReducer) -> Check:
    """Return the check that the cranks do not all pass a dead point at once, as two cranks and a single disc do.

    At a dead point the eccentrics line up, and the disc cannot keep the cranks in phase. A failure is a warning.
    """
    is_passed = not dead_points(reducer.cranks.count, reducer.design.gear.discs)
    return Check(
        name="dead_points",
        passed=is_passed,
        got=f"{reducer.cranks.count} cranks and {reducer.design.gear.discs} disc"
        + "s" * (reducer.design.gear.discs > 1),
        limit="three cranks, or two discs",
        why="where the eccentrics of two cranks are in line with both cranks, a single disc does not keep them in "
        "phase, and the planets carry all of the difference",
        remedy="" if is_passed else "set gear.discs to 2, or cranks.count to 3",
        severity="warning",
        key="cranks.count",
        changes=() if is_passed else ({"gear.discs": 2}, {"cranks.count": 3}),
    )


def _check_crank_circle(reducer: RvReducer) -> Check:
    """Return the check that the crank axes are at the centre distance of sun and planet, within half a module."""
    planet, radius = reducer.planet, reducer.crank_radius
    centre_distance = planet.module * (planet.sun_teeth + planet.planet_teeth) / 2.0
    is_passed = abs(radius - centre_distance) <= 0.5 * planet.module
    return Check(
        name="crank_circle",
        passed=is_passed,
        got=millimetres(radius),
        limit=f"{millimetres(centre_distance)} = module (sun + planet teeth)/2, within half a module",
        why="sun and planets mesh at this distance of their axes; profile shift can bridge half a module at most",
        remedy="" if is_passed else "set cranks.radius_mm to 0, which follows module and teeth",
        key="cranks.radius_mm",
        changes=() if is_passed else ({"cranks.radius_mm": 0.0},),
    )


def _check_stage_teeth(reducer: RvReducer) -> Iterator[Check]:
    """Yield the checks that the teeth of sun and planets are neither undercut by the cutting rack nor pointed."""
    for name, gear in zip(("sun", "planet"), reducer.stage_gears, strict=True):
        yield Check(
            name=f"{name}_teeth",
            passed=not gear.fault,
            got=str(gear.teeth),
            limit="a number of full-depth teeth that the rack of ISO 53, profile A, can cut",
            why=f"with the profile shift {gear.shift:.2f} the teeth are {gear.fault or 'neither undercut nor pointed'}",
            remedy=f"raise planet.{name}_teeth or planet.pressure_angle_deg, and set cranks.radius_mm to 0"
            if gear.fault
            else "",
            key=f"planet.{name}_teeth",
        )


def _wall_rules(reducer: RvReducer) -> Iterator[Rule]:
    """Yield the rules (`wall_rule`) for a disc's walls between lobe roots, crank bores, middle hole and windows."""
    design, cranks = reducer.design, reducer.cranks
    E, crank_circle_radius, bore_radius = design.ring.pin_circle_radius, reducer.crank_radius, reducer.bore_radius
    root_radius = E - design.gear.eccentricity - reducer.profile_offset + design.modification.pin_circle
    window_radius, post_circle_radius = reducer.window_radius, reducer.post_circle_radius
    window_bore_distance = math.sqrt(
        crank_circle_radius**2
        + post_circle_radius**2
        - 2.0 * crank_circle_radius * post_circle_radius * math.cos(math.pi / cranks.count)
    )
    bore_margin = bore_radius - cranks.eccentric_radius

    def wall(name: str, location: str, key: str, radius_without_wall: float) -> Rule:
        """Return the rule that a wall is at least `TEETH.min_wall_share` of the pin-circle radius thick.

        `radius_without_wall` is the value of the design at `key` at which no wall is left [m]. `name` is that of the
        check, and `location` names the place of the wall in messages, such as "between post and crank".
        """

        def wall_limits(relative_wall: float) -> tuple[Limit, ...]:
            return (Limit(key, "less than", radius_without_wall - relative_wall * E),)

        return wall_rule(name, wall_limits, TEETH.min_wall_share, E, location)

    eccentric_key, post_key = "cranks.eccentric_radius", "cranks.post_radius"
    window_margin = window_radius - cranks.post_radius
    yield wall(
        "crank_bores",
        "between the crank bores and the roots of the lobes",
        eccentric_key,
        root_radius - crank_circle_radius - bore_margin,
    )
    yield wall(
        "middle_hole",
        "between the middle hole and the crank bores",
        "cranks.middle_hole_radius",
        crank_circle_radius - bore_radius,
    )
    yield wall(
        "windows_to_bores",
        "between the windows and the crank bores",
        post_key,
        window_bore_distance - bore_radius - window_margin,
    )
    yield wall(
        "windows_to_root",
        "between the windows and the roots of the lobes",
        post_key,
        root_radius - post_circle_radius - window_margin,
    )
    yield wall(
        "windows_to_hole",
        "between the windows and the middle hole",
        post_key,
        post_circle_radius - cranks.middle_hole_radius - window_margin,
    )


def _flange_rules(reducer: RvReducer) -> Iterator[Rule | Check]:
    """Yield the rules on the space for the parts in and next to the flanges.

    The tapered bearings stay clear of the posts and enclose the journals, the eccentrics enclose their axes, bearings
    and posts stay inside of the ring pins, journals inside of the planets' roots, and the planets clear of each other.
    """
    cranks, crank_circle_radius, post_circle_radius = reducer.cranks, reducer.crank_radius, reducer.post_circle_radius
    crank_post_distance = math.sqrt(
        crank_circle_radius**2
        + post_circle_radius**2
        - 2.0 * crank_circle_radius * post_circle_radius * math.cos(math.pi / cranks.count)
    )
    yield Rule(
        "bearing_space",
        Limit("cranks.taper_radius", "less than", crank_post_distance - cranks.post_radius),
        "the tapered bearings of the cranks and the roots of the posts share the flanges",
        (Limit("cranks.post_radius", "less than", crank_post_distance - cranks.taper_radius),),
    )
    yield Rule(
        "eccentric_in_bearing",
        Limit("cranks.eccentric_radius", "more than", reducer.design.gear.eccentricity),
        "the eccentric encloses the axis of its crank",
    )
    yield Rule(
        "tapered_bearings",
        Limit("cranks.taper_radius", "more than", reducer.journal_radius),
        f"the tapered bearings ({reducer.crank_bearing_text}) enclose the journals of the cranks, of radius "
        "cranks.eccentric_radius less eccentricity",
    )
    ring = reducer.design.ring
    max_radius = ring.pin_circle_radius - ring.pin_radius - reducer.flange_wall
    yield Rule(
        "flange_in_ring",
        Limit("cranks.taper_radius", "less than", max_radius - crank_circle_radius),
        "the flanges, with a wall around the tapered bearings, stay inside the ring pins",
    )
    yield Rule(
        "posts_in_ring",
        Limit("cranks.post_radius", "less than", max_radius - post_circle_radius),
        "the flanges, with a wall around the posts, stay inside the ring pins",
    )
    yield Rule(
        "journal_in_planet",
        Limit(
            "cranks.eccentric_radius",
            "less than",
            reducer.stage_gears[1].root_radius + reducer.design.gear.eccentricity,
        ),
        "the journals of the cranks, in the bores of the planets, stay inside the roots of their teeth",
    )
    tip_radius, half_spacing = reducer.stage_gears[1].tip_radius, crank_circle_radius * math.sin(math.pi / cranks.count)
    yield Check(
        name="planets_apart",
        passed=bool(tip_radius < half_spacing),
        got=f"{reducer.planet.planet_teeth}, with a tip radius of {millimetres(tip_radius)}",
        limit=f"fewer: the tip radius below half of the distance of two crank axes, {millimetres(half_spacing)}",
        why="the tips of neighbouring planets must not meet",
        remedy="" if tip_radius < half_spacing else "raise planet.sun_teeth, or lower planet.planet_teeth",
        key="planet.planet_teeth",
    )


def _main_bearing_rules(reducer: RvReducer) -> Iterator[Rule | Check]:
    """Yield the rules that main bearings, if the design has any, fit between flanges and housing, and on the flanges.

    If none fits, the remedy is the smallest outer radius of the housing for which one does, if there is any.
    """
    if reducer.cranks.main_bearings == "none":
        return
    space, bearing = main_bearing_space(reducer), reducer.main_bearing
    outside_diameters = (
        item.outside for item in stock.catalogued_angular_contact_bearings() if space.fits_inside(item)
    )
    min_radius = min(outside_diameters, default=math.inf) / 2.0 + reducer.flange_wall
    has_remedy = bearing is None and math.isfinite(min_radius)
    remedies = ['set cranks.main_bearings to "none"']
    if has_remedy:
        remedies.insert(0, f"set housing.outer_radius_mm to at least {in_mm(min_radius)}")
    yield Check(
        name="main_bearings",
        passed=bearing is not None,
        got=f"{reducer.cranks.main_bearings}, {bearing.designation if bearing else 'no bearing in stock'}",
        limit=f"a bearing with {space}",
        why="a main bearing is between a flange and the housing, beyond the sockets of the ring pins",
        remedy="" if bearing else ", or ".join(remedies),
        key="cranks.main_bearings",
        changes=({"housing.outer_radius_mm": round(MILLIMETRES * min_radius, 6)},) if has_remedy else (),
    )
    if bearing:
        yield Rule(
            "main_bearing_width",
            Limit("cranks.flange_thickness", "at least", min_flange_thickness(reducer, bearing)),
            f"a flange has the seat of the main bearing {bearing.designation} and a shoulder next to it"
            + (", and passes a stop ring" if stop_ring_thickness(reducer, bearing) else ""),
        )
    has_sleeves = reducer.design.ring.has_sleeves
    yield Check(
        name="main_bearings_and_sleeves",
        passed=not has_sleeves,
        got=reducer.design.ring.pins if reducer.design.ring.kind == "pin" else "none",
        limit="pins without sleeves",
        why="end plates support the pins inside of sleeves, and leave no space for main bearings",
        remedy='set ring.pins to "free" or "fixed", or cranks.main_bearings to "none"' if has_sleeves else "",
        key="ring.pins",
    )


def _post_rule(reducer: RvReducer) -> Rule:
    """Return the rule that the posts stay clear of the windows of the discs, which orbit with the eccentricity."""
    min_window_radius = reducer.cranks.post_radius + reducer.design.gear.eccentricity
    is_window_set = reducer.cranks.window_radius > 0.0
    window_limit = Limit("cranks.window_radius", "more than", min_window_radius)
    post_limit = Limit("cranks.post_radius", "less than", reducer.window_radius - reducer.design.gear.eccentricity)
    return Rule(
        "posts_in_windows",
        window_limit if is_window_set else post_limit,
        "the windows of the discs orbit about the posts at the eccentricity, and must not touch them",
        (post_limit,) if is_window_set else (),
    )
