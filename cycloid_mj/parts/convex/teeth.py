"""The flanks of the cycloid disc and of the internal gear, sliced by curvature into convex bodies.

On a concave flank (as seen from the material) each chord is the face of a quadrilateral, whose vertices are below the
profile by as much as its middle is above. A convex flank is a few polygons of many vertices. Half a pitch is sliced,
then mirrored and rotated.
"""

import itertools
import math

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.geometry import envelope, profile
from cycloid_mj.geometry.profile import CycloidGear, SmoothArc
from cycloid_mj.parts.convex.settings import METHOD, ConvexSettings
from cycloid_mj.parts.convex.surface import ConvexSurface, Slice, SlicePlacement, convex_slice
from cycloid_mj.parts.convex.walls import gear_depth, housing_depth
from cycloid_mj.parts.polygon import area_moments, rotate_clockwise
from cycloid_mj.reducer import Reducer


def gear_teeth(reducer: Reducer, settings: ConvexSettings, disc: int = 0) -> ConvexSurface:
    """Slice the flanks of a disc, with its clearances, into convex pieces, in the frame of the disc, valley 1 on +y.

    `SlicePlacement.member` is the number of the pitch to which a slice belongs. Pitch i extends from one lobe tip to
    the next, with valley i in the middle. `settings` set the accuracy and the number of the slices, and `disc` is the
    index of the disc.

    Raises
    ------
    DesignError
        The disc is undercut, its flanks are rotated or have waves, or a slice is not convex.
    """
    if reducer.design.modification.rotation:
        raise DesignError(
            "convex meshes cannot represent rotated flanks (modification.rotation_arcsec): set "
            "modification.rotation_arcsec = 0, or use --contact profile"
        )
    errors = reducer.deviations
    if errors.waves.any():
        raise DesignError(
            "convex meshes cannot represent waves of the profile (errors.profile_cos_um, errors.profile_sin_um or "
            "measured.gear), because all lobes share one mesh: remove the waves, or use --contact profile"
        )
    gear, depth = reducer.gear_profile, gear_depth(reducer, settings)
    offset = reducer.profile_offset - float(errors.disc_radius[disc])
    half_lobe_nodes = _gear_nodes(gear, offset, 2.0 * settings.chord_error)
    face, base_points = (
        profile.outline(gear, half_lobe_nodes, offset + inset) for inset in (settings.chord_error, depth)
    )
    curvatures = profile.curvature(gear, (half_lobe_nodes[:-1] + half_lobe_nodes[1:]) / 2.0, offset)
    quads = _quadrilateral_slices("teeth", face, base_points, curvatures + 1.0 / gear.pin_radius, settings)
    slices = [*quads, *_gear_tip(gear, offset, settings, depth)]
    samples = profile.sample(gear, METHOD.samples, offset)
    base_area = -area_moments(_repeat_pitch(_mirror_and_join(base_points), gear.lobes)).area
    return ConvexSurface(
        name="teeth",
        slices=tuple(slices),
        places=_all_places(len(slices), gear.lobes),
        half_width=0.5 * reducer.design.gear.face_width,
        points=samples.points,
        normals=samples.normals,
        strip_area=profile.area(gear, offset) - base_area,
        depth=depth,
        overfill_bound=METHOD.tolerance * max(settings.chord_error, settings.hull_chord_error),
        underfill_bound=METHOD.tolerance * max(settings.chord_error, settings.hull_chord_error),
        disc=disc,
    )


def ring_lobes(reducer: Reducer, settings: ConvexSettings) -> ConvexSurface:
    """Slice the flanks of the internal gear into convex pieces, in the frame of the gear, lobe 1 on +y.

    The `member` of each place of the result is the number of its lobe. `settings` set the accuracy and the number of
    the slices.
    """
    gear, depth = reducer.tooth_profile, housing_depth(reducer, settings)
    B = envelope.sigma_nodes(gear, 2.0 * settings.chord_error)
    face, base_points = (_envelope_points(gear, B, inset) for inset in (settings.chord_error, depth))
    mid_phases = (B[:-1] + B[1:]) / 2.0
    gear_curvatures = profile.curvature(gear, -mid_phases / gear.lobes, reducer.profile_offset)
    curvatures = gear_curvatures - 1.0 / envelope.Sigma(gear, mid_phases).radius
    slices = [*_quadrilateral_slices("lobe", face, base_points, curvatures, settings), _ring_tip(gear, settings, depth)]
    samples = envelope.sample_ring(gear, METHOD.samples)
    base_area = -area_moments(_repeat_pitch(ring_base(reducer, depth, B), gear.ring_teeth)).area
    return ConvexSurface(
        name="lobe",
        slices=tuple(slices),
        places=_all_places(len(slices), gear.ring_teeth),
        half_width=0.5 * reducer.design.gear.stack_width,
        points=samples.points,
        normals=samples.normals,
        strip_area=base_area - envelope.area(gear),
        depth=depth,
        overfill_bound=METHOD.tolerance * max(settings.chord_error, settings.hull_chord_error),
        underfill_bound=METHOD.tolerance * max(settings.chord_error, settings.hull_chord_error),
    )


def gear_base(reducer: Reducer, depth: float, chord_error: float) -> Array:
    """Compute the inner ends of the convex slices behind the flanks of a disc, over one pitch: n points (n, 2) [m].

    Valley 1 is in the middle, and the order is clockwise. The ends are `depth` [m] below the flank. Chords of the flank
    between them deviate by at most `chord_error` [m].
    """
    gear, offset = reducer.gear_profile, reducer.profile_offset
    return _mirror_and_join(profile.outline(gear, _gear_nodes(gear, offset, chord_error), offset + depth))


def ring_base(reducer: Reducer, depth: float, nodes: Array | None = None, chord_error: float = 1e-5) -> Array:
    """Compute the outer ends of the convex slices behind the flanks of an internal gear, over one pitch: n points [m].

    The shape is (n, 2). Lobe 1 is in the middle, and the order is clockwise. The ends are `depth` [m] below the flank.
    `nodes` are their phases [rad] on the second envelope (`envelope.Sigma`), from its junction with the arc of the lobe
    to pi, the middle of the root. By default these are phases at which chords deviate by at most `chord_error` [m] from
    the flank.
    """
    gear = reducer.tooth_profile
    left_points = _envelope_points(gear, envelope.sigma_nodes(gear, chord_error) if nodes is None else nodes, depth)
    return np.concatenate([left_points[::-1], left_points * [-1.0, 1.0]])


def _gear_nodes(gear: CycloidGear, offset: float, chord_error: float) -> Array:
    """Compute parameters t from the middle of valley 1 to the inflection, with chords of an error `chord_error`."""
    inflection = profile.inflection_phase(gear) / gear.lobes
    return _flank_nodes(gear, offset, 0.0, inflection, chord_error) if inflection > 0.0 else np.zeros(1)


def _flank_nodes(
    gear: CycloidGear, offset: float, first_parameter: float, last_parameter: float, chord_error: float
) -> Array:
    """Compute n flank parameters [rad], (n,), between which chords deviate by at most `chord_error` [m] from the flank.

    They extend from `first_parameter` to `last_parameter`. The flank is offset by `offset` [m]; see
    `profile.sagitta_nodes`. `gear` is the profile of the disc.
    """
    profile.require_no_undercut(gear, offset)
    flank = SmoothArc(
        points=lambda t: profile.outline(gear, t, offset),
        normal_angle=lambda t: profile.normal_angle(gear, t),
        turning_rate=lambda t: profile.turning_rate(gear, t),
        arc_rate=lambda t: profile.arc_rate(gear, t, offset),
    )
    return profile.sagitta_nodes(flank, first_parameter, last_parameter, chord_error)


def _envelope_points(gear: CycloidGear, B: Array, depth: float) -> Array:
    """Compute points (n, 2) [m] at a `depth` [m] below the second envelope (`envelope.Sigma`) at n phases `B` [rad]."""
    flank = envelope.Sigma(gear, B)
    return flank.points + depth * profile.unit(flank.normal_angle)


def _quadrilateral_slices(
    name: str, face: Array, base_points: Array, curvature: Array, settings: ConvexSettings
) -> list[Slice]:
    """Return quadrilateral slices of a concave flank, one for each chord between neighbouring points.

    `face` and `base_points` (n, 2) [m] are the n points of the flank and the back ends of the slices, `curvature` (n -
    1,) [1/m] is the relative curvature of the contacts on each slice, `name` that of the surface, for errors.
    """
    width = np.linalg.norm(np.diff(face, axis=0), axis=1)
    overlap = METHOD.overlap * settings.chord_error
    outlines = [
        np.concatenate([_extend_ends(face[i : i + 2], overlap), _extend_ends(base_points[i : i + 2], overlap)[::-1]])
        for i in range(len(width))
    ]
    return [convex_slice(name, outline, float(width[i]), float(curvature[i])) for i, outline in enumerate(outlines)]


def _extend_ends(points: Array, overlap: float) -> Array:
    """Move the ends of an open polygon outwards along its first and last edge, by half the overlap [m]."""
    extended = points.copy()
    for end, neighbour in ((0, 1), (-1, -2)):
        edge = points[end] - points[neighbour]
        extended[end] += 0.5 * overlap * edge / np.linalg.norm(edge)
    return extended


def _gear_tip(gear: CycloidGear, offset: float, settings: ConvexSettings, depth: float) -> list[Slice]:
    """Slice the convex half of the lobe after valley 1, from inflection point to tip, into `settings.hulls` polygons.

    `offset` [m] is the distance of the flank from the trochoid, `depth` [m] the thickness of the slices. `gear` is the
    profile of the disc.
    """
    error = settings.hull_chord_error
    inflection_angle, tip_angle = profile.inflection_phase(gear) / gear.lobes, math.pi / gear.lobes
    flank_parameters = _flank_nodes(gear, offset, inflection_angle, tip_angle, 2.0 * error)
    face = profile.outline(gear, flank_parameters, offset - error)
    edge = profile.outline(gear, inflection_angle, offset + depth)
    edge_projection = float(edge @ profile.unit(tip_angle)) * profile.unit(tip_angle)
    cuts = np.linspace(0, len(flank_parameters) - 1, settings.hulls + 1).round().astype(int)
    overlap = METHOD.overlap * settings.chord_error
    slices = []
    for first_node, last_node in itertools.pairwise(cuts):
        base_edge = _extend_ends(
            edge + np.array([[last_node], [first_node]]) / (len(flank_parameters) - 1) * (edge_projection - edge),
            overlap,
        )
        curvature = _hull_curvature(gear, offset, gear.lobes * flank_parameters[[first_node, last_node]])
        outline = np.concatenate([_extend_ends(face[first_node : last_node + 1], overlap), base_edge])
        slices.append(convex_slice("teeth", outline, math.inf, curvature))
    return slices


def _hull_curvature(gear: CycloidGear, offset: float, phases: Array) -> float:
    """Compute the mean relative curvature [1/m] of pin and lobe on the piece of a flank that a convex hull represents.

    `phases` (start, end) [rad] are the crank phases between which the pin touches this piece, and `offset` [m] is that
    of the flank along its outward normal. The mean is geometric, because the compliance of a contact depends on the
    logarithm of its curvature. It is weighted by the square of the moment arm, because the stiffness of the mesh is.
    `gear` is the profile of the disc.
    """
    B = np.linspace(phases[0], phases[1], METHOD.flank_samples)
    kappa = profile.curvature(gear, -B / gear.lobes, offset) + 1.0 / gear.pin_radius
    weight = profile.moment_arm(gear, B) ** 2
    return float(np.exp(np.sum(weight * np.log(kappa)) / np.sum(weight)))


def _ring_tip(gear: CycloidGear, settings: ConvexSettings, depth: float) -> Slice:
    """Return half of the arc of lobe 1 of the internal gear as one convex slice, `depth` [m] thick.

    It only represents the shape of the lobe: contacts use a cylinder instead. `settings` set the accuracy
    and the number of the slices.
    """
    rho, alpha, error = gear.pin_radius, envelope.largest_alpha(gear), settings.chord_error
    angle = -np.linspace(0.0, alpha, math.ceil(0.5 * alpha / math.acos(1.0 - 2.0 * error / rho)) + 1)
    centre = gear.pin_circle_radius * profile.unit(0.0)
    face = centre - (rho + error) * profile.unit(angle)
    edge = centre - (rho - depth) * profile.unit(angle[-1])
    overlap = METHOD.overlap * settings.chord_error
    base_edge = _extend_ends(np.array([edge, edge * [0.0, 1.0]]), overlap)
    return convex_slice("lobe", np.concatenate([_extend_ends(face, overlap), base_edge]), math.inf, 1.0 / rho)


def _all_places(slice_count: int, pitch_count: int) -> tuple[SlicePlacement, ...]:
    """Return the positions of the slices of half a pitch, and of their mirror images, in all pitches."""
    pitch = 2.0 * math.pi / pitch_count
    return tuple(
        SlicePlacement(number, lobe + 1, lobe * pitch, mirrored=mirrored)
        for lobe, mirrored, number in itertools.product(range(pitch_count), (False, True), range(slice_count))
    )


def _mirror_and_join(right_half: Array) -> Array:
    """Return the reversed mirror image of points that start at x = 0, followed by the points."""
    return np.concatenate([right_half[:0:-1] * [-1.0, 1.0], right_half])


def _repeat_pitch(pitch_points: Array, count: int) -> Array:
    """Return the points of one pitch repeated over a full turn, clockwise."""
    return np.concatenate([rotate_clockwise(pitch_points, 2.0 * math.pi * i / count) for i in range(count)])
