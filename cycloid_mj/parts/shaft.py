"""The crank: input journal, the cams of all discs, and the counterweight of a single one."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.parts.accuracy import checked_chord_error
from cycloid_mj.parts.contour import CircleContour, Contour, TurnedContour
from cycloid_mj.parts.curve import Arc, Curve, LineSegment
from cycloid_mj.parts.fit import require_above, require_below, too_small
from cycloid_mj.parts.gear import section_area
from cycloid_mj.parts.part import Part, Segment
from cycloid_mj.parts.polygon import arc, area_moments
from cycloid_mj.parts.prism import Solid
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.reducer.bending import AXIAL_GAP

JOURNAL, COUNTERWEIGHT, INNER, NECK, FAR = "journal", "counterweight", "inner_journal", "neck", "far_journal"
"""Segments of the crank, next to ``names.CAM`` and ``names.SPACER``; those between discs are numbered."""

MAX_ONE_PIECE_DISCS = 2
"""Largest number of discs on a crank in one piece: each bearing is put on its cam from its own end of the crank."""


def crank_part(reducer: Reducer, chord_error: float | None = None) -> Part:
    """Return the entire crank as exact outlines about the reducer axis, at crank angle 0 (cam 1 towards +y).

    For one disc it is a single part with a counterweight. Several discs, evenly spaced around the axis, balance each
    other; their crank is assembled from a plain shaft, a cam per disc and a spacer per gap, which guides the discs. A
    crank of two discs can also be one piece, with a collar in place of the spacer.

    Parameters
    ----------
    chord_error
        Chord error of the balanced polygons [m]; by default that for mass properties.

    Raises
    ------
    DesignError
        No counterweight of this radius balances the disc within the shaft length, or the shaft is too thick for cams.
    """
    density = reducer.design.material_of("shaft").density
    return Part(names.SHAFT, tuple(shaft_segments(reducer, chord_error).values()), density)


def shaft_solid(reducer: Reducer, chord_error: float | None = None) -> Solid:
    """Return `crank_part` as prisms with a chord error [m]; by default that for mass properties."""
    chord_error = checked_chord_error(reducer, chord_error)
    return crank_part(reducer, chord_error).solid(chord_error)


def shaft_segments(reducer: Reducer, chord_error: float | None = None) -> Mapping[str, Segment]:
    """Return the segments of the crank along the axis by name, from the motor on; see `crank_part`.

    With one disc they are journal, counterweight (which includes the shaft), journal across the gap, and cam. With
    several discs they are journal, cam 1, neck with the spacer around it, cam 2 and so on. A crank of two discs in one
    piece has a collar, with the name of the spacer, instead of neck and spacer. A straddled shaft also has a journal
    beyond the discs, for the bearing in the hub of the output. `chord_error` [m] is explained in `crank_part`. The
    result is cached.
    """
    return _build_segments(reducer.shape, checked_chord_error(reducer, chord_error))


@once
def _build_segments(reducer: Reducer, chord_error: float) -> Mapping[str, Segment]:
    """Build the segments of the crank for `shaft_segments`; `chord_error` [m] is explained in `crank_part`."""
    if reducer.design.gear.discs == 1:
        crank_segments = _single_disc_crank(reducer, chord_error)
    else:
        crank_segments = _multi_disc_crank(reducer)
    return {segment.name: segment for segment in crank_segments}


def crank_parts(reducer: Reducer) -> tuple[Part, ...]:
    """Return the separate parts of the crank of several discs: shaft, spacer (in its own frame) and cams.

    Raises
    ------
    DesignError
        The shaft is too thick for its cams.
    """
    design = reducer.design
    by_name, density = shaft_segments(reducer), design.material_of("shaft").density
    journal, cams = by_name[JOURNAL], [by_name[name] for name in names.all_numbered(names.CAM, design.gear.discs)]
    spacer, half_gap = by_name[names.numbered_name(names.SPACER, 1)], design.gear.disc_gap / 2
    shaft_end = by_name.get(FAR, cams[-1]).z1
    return (
        Part(names.SHAFT, (Segment(JOURNAL, journal.outline, journal.holes, journal.z0, shaft_end),), density),
        Part(names.SPACER, (Segment(names.SPACER, spacer.outline, spacer.holes, -half_gap, half_gap),), density),
        *(Part(cam.name, (Segment(names.CAM, cam.outline, spacer.holes, cam.z0, cam.z1),), density) for cam in cams),
    )


@dataclass(frozen=True)
class JournalContour(CircleContour):
    """The circle of the shaft as two half circles, the upper one first, which the counterweight shares."""

    def polygon(self, chord_error: float) -> Array:
        """Return the outline as a polygon (n, 2) [m], one half after the other."""
        halves = (arc(self.radius, start, start + math.pi, chord_error)[:-1] for start in (0.0, math.pi))
        return np.concatenate(list(halves))


@dataclass(frozen=True)
class CounterweightContour:
    """The outline of the counterweight: a half circle below the axis, and the upper half of the shaft (`journal`)."""

    radius: float
    journal: JournalContour

    def polygon(self, chord_error: float) -> Array:
        """Return the outline as a polygon (n, 2) [m] whose chords deviate by up to `chord_error` [m] from the arcs.

        The points of the half circle come first.
        """
        half_circle, journal_polygon = (
            arc(self.radius, math.pi, 2 * math.pi, chord_error),
            self.journal.polygon(chord_error),
        )
        return np.concatenate([half_circle, journal_polygon[: len(journal_polygon) // 2 + 1]])

    def curves(self, splines: int) -> tuple[Curve, ...]:
        """Return the outline of the counterweight: its half circle, an edge, the arc of the journal, the other edge.

        `splines` has no effect, because arcs and edges are exact without splines.
        """
        outer_radius, inner_radius = self.radius, self.journal.radius
        return (
            Arc((0.0, 0.0), outer_radius, math.pi, 2.0 * math.pi),
            LineSegment((outer_radius, 0.0), (inner_radius, 0.0)),
            Arc((0.0, 0.0), inner_radius, 0.0, math.pi),
            LineSegment((-inner_radius, 0.0), (-outer_radius, 0.0)),
        )


def _single_disc_crank(reducer: Reducer, chord_error: float) -> list[Segment]:
    """Return the segments of the crank of one disc, with the counterweight that balances the disc.

    The counterweight is sized by polygons, whose chords deviate from the outlines by at most `chord_error` [m].
    """
    design = reducer.design
    shaft, half_width = design.shaft, design.gear.face_width / 2
    journal, cam = JournalContour(shaft.radius), CircleContour(design.gear.bore_radius, (0.0, design.gear.eccentricity))
    require_above("shaft.counterweight_radius", shaft.counterweight_radius, shaft.radius, "it is within the shaft")
    counterweight = CounterweightContour(shaft.counterweight_radius, journal)
    weight_end = reducer.near_face
    weight_start = weight_end - _balancing_thickness(reducer, cam, counterweight, chord_error)
    bore = _through_bore(reducer)
    return [
        Segment(JOURNAL, journal, bore, weight_end - shaft.length, weight_start),
        Segment(COUNTERWEIGHT, counterweight, bore, weight_start, weight_end),
        Segment(INNER, journal, bore, weight_end, -half_width),
        Segment(names.CAM, cam, bore, -half_width, half_width),
        *_far_journal(reducer, journal, weight_start - (weight_end - shaft.length)),
    ]


def _multi_disc_crank(reducer: Reducer) -> list[Segment]:
    """Return the segments of the crank of several discs, which balance each other without a counterweight.

    A DesignError is raised if the cams leave no wall around the shaft, or if a crank in one piece has more than two
    discs.
    """
    design = reducer.design
    gear, shaft, half_width = design.gear, design.shaft, design.gear.face_width / 2
    free_radius, is_one_piece = gear.bore_radius - gear.eccentricity, design.has_one_piece_crank
    if is_one_piece and gear.discs > MAX_ONE_PIECE_DISCS:
        raise DesignError(
            f"a crank in one piece for {gear.discs} discs cannot be assembled: the bearing of an inner disc cannot "
            'pass the cams next to it. Set shaft.cam_joint = "key", or gear.discs = 2'
        )
    problem = "the cams leave no wall around the shaft"
    if is_one_piece:
        problem = "the journals are too thick for the cam bearings"
    require_below("shaft.radius", shaft.radius, free_radius, problem)
    journal, cam = CircleContour(shaft.radius), CircleContour(gear.bore_radius, (0.0, gear.eccentricity))
    spacer_contour = CircleContour(spacer_radius(reducer))
    planes, near_face, bore = gear.disc_planes, reducer.near_face, _through_bore(reducer)
    crank_segments = [Segment(JOURNAL, journal, bore, near_face - shaft.length, planes[0] - half_width)]
    for number, (plane, phase) in enumerate(zip(planes, reducer.phases, strict=True), start=1):
        if number > 1:
            gap_ends = planes[number - 2] + half_width, plane - half_width
            neck_name, spacer_name = (names.numbered_name(family, number - 1) for family in (NECK, names.SPACER))
            if is_one_piece:
                crank_segments.append(Segment(spacer_name, spacer_contour, bore, *gap_ends))
            else:
                crank_segments += [
                    Segment(neck_name, journal, bore, *gap_ends),
                    Segment(spacer_name, spacer_contour, (journal,), *gap_ends),
                ]
        cam_contour = TurnedContour(cam, phase)
        crank_segments.append(
            Segment(names.numbered_name(names.CAM, number), cam_contour, bore, plane - half_width, plane + half_width)
        )
    return crank_segments + _far_journal(reducer, journal, shaft.length)


def spacer_radius(reducer: Reducer) -> float:
    """Compute the outer radius [m] of the spacer between two discs.

    It is midway between the farthest points of the discs' bores and the output pins. Both discs are then guided over
    the full circumference at all crank angles.
    """
    design = reducer.design
    gear, output = design.gear, design.output
    cam_reach = gear.bore_radius + design.clearance.cam + gear.eccentricity
    return 0.5 * (cam_reach + output.pin_circle_radius - output.pin_radius)


def bearing_width(reducer: Reducer, journal: float) -> float:
    """Return the width [m] of each bearing on a journal of the length `journal` [m] before the counterweight.

    It is the width of the design if the design has one. Otherwise it is the radius of the shaft, but at most a third of
    the journal.
    """
    return reducer.design.shaft.bearing_width or min(reducer.design.shaft.radius, journal / 3.0)


def bearing_seats(
    reducer: Reducer, by_name: Mapping[str, Segment] | None = None
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the positions of the two bearings of the crank along its axis.

    The far bearing of a straddled shaft is beyond the discs. `by_name` are the `shaft_segments`; None: they are built.

    Returns
    -------
    tuple
        Start and end along z [m] of the bearing far from the discs, then of the near one.
    """
    shaft, by_name = reducer.design.shaft, by_name or shaft_segments(reducer)
    start, end = by_name[JOURNAL].z0, min(by_name[JOURNAL].z1, reducer.near_face)
    width = bearing_width(reducer, end - start)
    near_start = end - shaft.bearing_offset
    far_start = near_start - width - shaft.bearing_spacing if shaft.bearing_spacing else start
    far_start = by_name[FAR].z1 - width if FAR in by_name else far_start
    return (far_start, far_start + width), (near_start - width, near_start)


def _far_journal(reducer: Reducer, outline: Contour, journal_length: float) -> list[Segment]:
    """Return the journal of the shaft beyond the discs, for the bearing in the hub; empty for an overhung shaft.

    `outline` is its cross-section. `journal_length` [m] is the length of the journal before the discs, which limits the
    width of the bearing.
    """
    if reducer.design.shaft.mounting == "overhang":
        return []
    half_width = reducer.design.gear.stack_width / 2
    return [
        Segment(
            FAR,
            outline,
            _through_bore(reducer),
            half_width,
            half_width + AXIAL_GAP + bearing_width(reducer, journal_length),
        )
    ]


def _through_bore(reducer: Reducer) -> tuple[Contour, ...]:
    """Return the bore through the shaft as the holes of a segment: one, or none of a solid shaft."""
    radius = reducer.design.shaft.bore_radius
    return (CircleContour(radius),) if radius else ()


def _balancing_thickness(reducer: Reducer, cam: Contour, counterweight: Contour, chord_error: float) -> float:
    """Compute the thickness t [m] of the counterweight that balances cam and disc statically about the axis.

    It solves t S_counterweight + w S_cam + V c rho_disc/rho_shaft = 0 [m4], where S is the integral of y over a
    cross-section, w the width of the cam, V the volume of the disc, c the eccentricity and rho the density.
    Cross-sections are polygons with a `chord_error` [m].

    Raises
    ------
    DesignError
        The counterweight is as long as the shaft, or longer.
    """
    design = reducer.design
    density_ratio = design.material_of("gear").density / design.material_of("shaft").density
    volume = design.gear.face_width * section_area(reducer, chord_error)
    cam_moment = design.gear.face_width * area_moments(cam.polygon(chord_error)).y
    unbalance = cam_moment + volume * density_ratio * design.gear.eccentricity
    thickness = -unbalance / area_moments(counterweight.polygon(chord_error)).y
    shaft = design.shaft
    if thickness >= shaft.length:
        # a half disc has the static moment -2/3 R^3 per thickness, the shaft in it takes 2/3 r^3 away
        min_radius = (shaft.radius**3 + 1.5 * unbalance / shaft.length) ** (1 / 3)
        failure_text = "no counterweight within the shaft's length balances the gear"
        raise too_small("shaft.counterweight_radius", shaft.counterweight_radius, min_radius, failure_text)
    return thickness
