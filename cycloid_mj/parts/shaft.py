"""The crank: input journal, the cams of all discs, and the counterweight of a single one."""

import math
from collections.abc import Mapping

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.parts.accuracy import drawing_error
from cycloid_mj.parts.fit import require_above, require_below, too_small
from cycloid_mj.parts.gear import section_area
from cycloid_mj.parts.polygon import arc, area_moments, circle, turned
from cycloid_mj.parts.prism import Prism, Solid
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP

JOURNAL, COUNTERWEIGHT, INNER, NECK, FAR = "journal", "counterweight", "inner_journal", "neck", "far_journal"
"""Stretches of the crank, with those of ``names.CAM`` and ``names.SPACER``; what lies between discs is numbered."""


def shaft_solid(reducer: Reducer, chord_error: float | None = None) -> Solid:
    """Build the whole crank, all that turns with the input, frame of the reducer axis, crank at 0 (cam 1 towards +y).

    Of one disc it is a single part with a counterweight. Several discs, evenly spaced around it, balance each other;
    their crank is built up of a plain shaft, a cam for each disc and a spacer in each gap, which guides the discs.

    Parameters
    ----------
    reducer
        The reducer.
    chord_error
        Largest distance of a chord from its arc [m]; right for mass properties when left out.

    Raises
    ------
    DesignError
        No counterweight of this radius balances the gear within the shaft's length, or the shaft is too thick for cams.
    """
    return Solid(
        names.SHAFT, tuple(stretches(reducer, chord_error).values()), reducer.design.material_of("shaft").density
    )


def stretches(reducer: Reducer, chord_error: float | None = None) -> Mapping[str, Prism]:
    """Build the stretches of the crank by name; see `shaft_solid`.

    Along z: journal, counterweight (with the shaft in its middle), journal across the gap, cam within the gear; or
    journal, cam 1, neck with the spacer around it, cam 2, ...; and where the shaft straddles the discs, a journal
    beyond them, for the bearing in the output's hub.
    """
    chord_error = drawing_error(reducer, chord_error)
    if reducer.design.gear.discs == 1:
        return _with_counterweight(reducer, chord_error)
    return _of_several(reducer, chord_error)


def crank_parts(reducer: Reducer, chord_error: float | None = None) -> tuple[Solid, ...]:
    """List the parts that the crank of several discs is built up of: shaft, spacer (in its own frame), and the cams.

    Raises
    ------
    DesignError
        The shaft is too thick for its cams.
    """
    design = reducer.design
    prisms = stretches(reducer, chord_error)
    density, hole = design.material_of("shaft").density, prisms[names.numbered(NECK, 1)].outline
    ends = prisms.get(FAR, prisms[names.numbered(names.CAM, design.gear.discs)]).z1
    shaft = Prism(prisms[JOURNAL].outline, (), prisms[JOURNAL].z0, ends)
    ring, half = prisms[names.numbered(names.SPACER, 1)], design.gear.disc_gap / 2
    spacer = Prism(ring.outline, ring.holes, -half, half)
    cams = {name: prisms[name] for name in names.all_numbered(names.CAM, design.gear.discs)}
    return (
        Solid(names.SHAFT, (shaft,), density),
        Solid(names.SPACER, (spacer,), density),
        *(Solid(name, (Prism(cam.outline, (hole,), cam.z0, cam.z1),), density) for name, cam in cams.items()),
    )


def _with_counterweight(reducer: Reducer, chord_error: float) -> dict[str, Prism]:
    """Build the crank of one disc."""
    design = reducer.design
    shaft, half = design.shaft, design.gear.face_width / 2
    journal = _journal(reducer, chord_error)
    cam = Prism(circle(design.gear.bore_radius, chord_error, (0.0, design.gear.eccentricity)), (), -half, half)
    counterweight = _counterweight(reducer, journal, chord_error)
    end = reducer.near_face
    start = end - _balancing_thickness(reducer, cam, counterweight, chord_error)
    prisms = {
        JOURNAL: Prism(journal, (), end - shaft.length, start),
        COUNTERWEIGHT: Prism(counterweight, (), start, end),
        INNER: Prism(journal, (), end, -half),
        names.CAM: cam,
    }
    return prisms | _far_journal(reducer, journal, start - (end - shaft.length))


def _of_several(reducer: Reducer, chord_error: float) -> dict[str, Prism]:
    """Build the crank of several discs, which needs no counterweight: their static moments add up to nothing."""
    design = reducer.design
    gear, shaft, half = design.gear, design.shaft, design.gear.face_width / 2
    room = gear.bore_radius - gear.eccentricity
    require_below("shaft.radius", shaft.radius, room, "the cams leave no wall around the shaft")
    journal, cam = circle(shaft.radius, chord_error), circle(gear.bore_radius, chord_error, (0.0, gear.eccentricity))
    ring = circle(spacer_radius(reducer), chord_error)
    planes, end = gear.disc_planes, reducer.near_face
    prisms = {JOURNAL: Prism(journal, (), end - shaft.length, planes[0] - half)}
    for number, (plane, phase) in enumerate(zip(planes, reducer.phases, strict=True), start=1):
        if number > 1:
            z0, z1 = planes[number - 2] + half, plane - half
            prisms[names.numbered(NECK, number - 1)] = Prism(journal, (), z0, z1)
            prisms[names.numbered(names.SPACER, number - 1)] = Prism(ring, (journal,), z0, z1)
        prisms[names.numbered(names.CAM, number)] = Prism(turned(cam, phase), (), plane - half, plane + half)
    return prisms | _far_journal(reducer, journal, shaft.length)


def spacer_radius(reducer: Reducer) -> float:
    """Find the outer radius of the spacer between two discs [m]: midway from what their bores reach to the output pins.

    Both discs then run on it all round, wherever the crank is.
    """
    design = reducer.design
    gear, output = design.gear, design.output
    reach = gear.bore_radius + design.clearance.cam + gear.eccentricity
    return 0.5 * (reach + output.pin_circle_radius - output.pin_radius)


def bearing_width(reducer: Reducer, journal: float) -> float:
    """Find the width [m] of each bearing on a journal [m] before the counterweight: as given, or its radius if it fits.

    Where that is longer than a third of the journal, it is the third.
    """
    return reducer.design.shaft.bearing_width or min(reducer.design.shaft.radius, journal / 3.0)


def bearing_seats(
    reducer: Reducer, prisms: Mapping[str, Prism] | None = None
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Compute where along z the two bearings of the crank sit [m]: the one far from the discs, then the one near them.

    `prisms` are its stretches, if they are drawn already. A shaft that straddles the discs has the far one beyond them.
    """
    shaft, prisms = reducer.design.shaft, prisms or stretches(reducer)
    start, end = prisms[JOURNAL].z0, min(prisms[JOURNAL].z1, reducer.near_face)
    width = bearing_width(reducer, end - start)
    near = end - shaft.bearing_offset
    far = near - width - shaft.bearing_spacing if shaft.bearing_spacing else start
    far = prisms[FAR].z1 - width if FAR in prisms else far
    return (far, far + width), (near - width, near)


def _far_journal(reducer: Reducer, outline: Array, journal: float) -> dict[str, Prism]:
    """Build the journal beyond the discs, as far as the bearing in the output's hub; none on an overhung shaft."""
    if reducer.design.shaft.mounting == "overhang":
        return {}
    half = reducer.design.gear.stack_width / 2
    return {FAR: Prism(outline, (), half, half + AXIAL_GAP + bearing_width(reducer, journal))}


def _counterweight(reducer: Reducer, journal: Array, chord_error: float) -> Array:
    """Compute the outline of the lower half disc, joined to the whole shaft, the `journal`, in its middle."""
    shaft = reducer.design.shaft
    require_above("shaft.counterweight_radius", shaft.counterweight_radius, shaft.radius, "it is within the shaft")
    lower = arc(shaft.counterweight_radius, math.pi, 2 * math.pi, chord_error)
    return np.concatenate([lower, journal[: len(journal) // 2 + 1]])


def _journal(reducer: Reducer, chord_error: float) -> Array:
    """Compute the outline of the shaft as two half circles, the upper one first: the counterweight shares that."""
    halves = (arc(reducer.design.shaft.radius, start, start + math.pi, chord_error)[:-1] for start in (0.0, math.pi))
    return np.concatenate(list(halves))


def _balancing_thickness(reducer: Reducer, cam: Prism, counterweight: Array, chord_error: float) -> float:
    """Solve the balance of static moments about the axis, over the shaft's density [m4], for its thickness t [m].

    t S_counterweight + w S_cam + V_gear c rho_gear/rho_shaft = 0, with S the integral of y over a cross-section.
    """
    design = reducer.design
    lighter = design.material_of("gear").density / design.material_of("shaft").density
    volume = design.gear.face_width * section_area(reducer, chord_error)
    unbalance = cam.height * area_moments(cam.outline).y + volume * lighter * design.gear.eccentricity
    thickness = -unbalance / area_moments(counterweight).y
    shaft = design.shaft
    if thickness >= shaft.length:
        # a half disc has the static moment -2/3 R^3 per thickness, the shaft in it takes 2/3 r^3 away
        radius = (shaft.radius**3 + 1.5 * unbalance / shaft.length) ** (1 / 3)
        otherwise = "no counterweight within the shaft's length balances the gear"
        raise too_small("shaft.counterweight_radius", shaft.counterweight_radius, radius, otherwise)
    return thickness
