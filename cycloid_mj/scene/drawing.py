"""Plane drawing of the mechanism with magnified gaps.

A clearance of 1 um is invisible on a part of 100 mm, and parts that were simply moved a thousand times as far would
slide along each other's curved flanks. Therefore the disc is drawn in its ideal pose, and its mates are placed by their
gaps, magnified along the ideal normals. Parts inside the disc are drawn thinner so as to fit. Gaps, and overlaps by
elastic deflection, are then drawn to the same scale; at magnification 1 the drawing is true.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array, rotate
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.names import OUTPUT, gears, pin
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.kinematics import gear_centre, gear_rotation
from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.parts import output_centres
from cycloid_mj.reducer import Reducer
from cycloid_mj.scene.pose import poses, ring_places, transform


@dataclass(frozen=True)
class DrawingSettings:
    """Settings of drawings with magnified gaps."""

    min_radius_share: float = 0.4
    """Smallest radius that a part may be drawn with, as a share of its radius."""
    max_gap_share: float = 0.25
    """Largest width of a drawn gap, as a share of the smallest radius next to it."""
    newton_steps: int = 8
    """Newton steps to a foot point; four suffice except in a valley whose curvature is close to the pin's."""
    min_curvature: float = 0.2
    """Smallest second derivative of the squared distance in a Newton step, over that of a line.

    Beyond a centre of curvature the full step diverges."""


DRAWING = DrawingSettings()


@dataclass(frozen=True)
class RingRadii:
    """Radii that ring pins, sockets and sleeves are drawn with [m]; the disc keeps its profile."""

    pin: float
    socket: float
    sleeve_bore: float


@dataclass(frozen=True)
class Radii(RingRadii):
    """Radii that the parts are drawn with [m]; disc and holes keep theirs."""

    cam: float
    output_pin: float


@dataclass(frozen=True, eq=False)
class MeshGaps:
    """Gaps between a disc and the ring at n times, relative to the ideal mesh at the same crank angle.

    Attributes
    ----------
    disc
        Index of the disc.
    gear
        Ideal pose of the disc: x, y [m], angle [rad], shape (n, 3).
    deviation
        Measured pose of the disc minus the ideal pose, shape (n, 3).
    crank_angle
        Shape (n,), [rad].
    opening
        Gap in excess of the clearance between the disc and each pin, or arc of an internal gear [m], shape (n, mates).
    away
        Position of each pin in its socket, or of a sleeve on its pin [m], shape (n, mates, 2); zeros for fixed pins.
    pin_angle
        Rotation of each pin [rad], shape (n, mates).
    """

    disc: int
    gear: Array
    deviation: Array
    crank_angle: Array
    opening: Array
    away: Array
    pin_angle: Array


@dataclass(frozen=True, eq=False)
class Separations(MeshGaps):
    """Gaps between a disc and all its mates at n times.

    Attributes
    ----------
    output_away
        Distance between the centres of each output pin and its hole minus the eccentricity [m], shape (n, k).
    """

    output_away: Array


@dataclass(frozen=True, eq=False)
class MeshDrawing:
    """Drawn poses of disc and ring at n times, in the frame of the reducer axis; x right, y up, [m] and [rad].

    Attributes
    ----------
    magnification
        Scale of the gaps.
    radii
        Radii that pins, sockets and sleeves are drawn with.
    gaps
        Gaps between disc and ring.
    gear
        Pose of the disc, shape (n, 3).
    ring
        Centres of the pins, or of the lobes of an internal gear, shape (n, mates, 2).
    sockets
        Centres of the pins' sockets, shape (n, mates, 2).
    """

    magnification: float
    radii: RingRadii
    gaps: MeshGaps
    gear: Array
    ring: Array
    sockets: Array


@dataclass(frozen=True, eq=False)
class Drawing(MeshDrawing):
    """Drawn poses of all parts at n times.

    Attributes
    ----------
    shaft
        Pose of the crank, shape (n, 3).
    output_pins
        Centres of the output pins, shape (n, k, 2).
    """

    radii: Radii
    gaps: Separations
    shaft: Array
    output_pins: Array


def largest_magnification(reducer: Reducer) -> float:
    """Compute the largest factor [1] by which the clearances of a reducer can be magnified in a drawing.

    Magnified clearances make the drawn parts smaller. Each part keeps at least `DRAWING.min_radius_share` of its
    radius.
    """
    design = reducer.design
    max_reduction = 1.0 - DRAWING.min_radius_share
    return 1.0 + max_reduction * min(
        design.ring.pin_radius / tooth_clearance(reducer),
        design.gear.bore_radius / design.clearance.cam,
        design.output.pin_radius / design.clearance.output,
    )


def widest_gap(reducer: Reducer, gaps: Separations) -> float:
    """Return an upper bound of the gaps between mating parts over all samples of a log [m].

    `gaps` are those of a disc and its mates at n samples, from `measure_gaps`. For each kind of pair, the bound is the
    clearance plus the largest deviation from the ideal position; the result is the largest of these sums.
    """
    design = reducer.design
    return max(
        tooth_clearance(reducer) + float(np.abs(gaps.opening).max(initial=0.0)),
        design.pin_play + float(np.linalg.norm(gaps.away, axis=-1).max(initial=0.0)),
        design.clearance.output + float(np.linalg.norm(gaps.output_away, axis=-1).max(initial=0.0)),
        design.clearance.cam + float(np.linalg.norm(gaps.deviation[:, :2], axis=-1).max(initial=0.0)),
    )


def fitting_magnification(reducer: Reducer, max_gap: float, choices: Sequence[float]) -> float:
    """Return the largest of several magnifications of clearances at which all gaps can be drawn, else the smallest.

    `choices` are the magnifications. The widest gap, `max_gap` [m], is drawn at most `DRAWING.max_gap_share` of any
    radius wide, because pins would appear outside their holes otherwise.
    """
    design = reducer.design
    min_radius = min(design.ring.pin_radius, design.output.pin_radius, design.gear.bore_radius)
    max_magnification = min(largest_magnification(reducer), DRAWING.max_gap_share * min_radius / max_gap)
    return max((magnification for magnification in choices if magnification <= max_magnification), default=min(choices))


def tooth_clearance(reducer: Reducer) -> float:
    """Return the normal clearance between disc and ring [m]."""
    design = reducer.design
    return design.clearance.pin_gear if design.ring.kind == "pin" else design.clearance.tooth


def drawn_radii(reducer: Reducer, magnification: float = 1.0) -> Radii:
    """Return the radii [m] of pins, sockets, sleeves and cam that make each clearance `magnification` times as wide.

    Raises
    ------
    UsageError
        `magnification` is below 1 or beyond `largest_magnification`.
    """
    design = reducer.design
    check_magnification(reducer, magnification, largest_magnification(reducer))
    excess, clearance = magnification - 1.0, design.clearance
    return Radii(
        **vars(_ring_radii(reducer, magnification)),
        cam=design.gear.bore_radius - excess * clearance.cam,
        output_pin=design.output.pin_radius - excess * clearance.output,
    )


def check_magnification(reducer: Reducer, magnification: float, largest: float) -> None:
    """Raise UsageError if the magnification of a drawing is below 1 or above the `largest`."""
    if not 1.0 <= magnification <= largest:
        raise UsageError(
            f"the factor by which the drawing magnifies clearances is {magnification:g}, which is out of range for "
            f"{reducer.design.name}: choose a value from 1 to {np.floor(largest):g}"
        )


def _ring_radii(reducer: Reducer, magnification: float) -> RingRadii:
    """Return the radii of pins, sockets and sleeves [m] in a drawing with a magnification."""
    design = reducer.design
    pin_radius = design.ring.pin_radius - (magnification - 1.0) * tooth_clearance(reducer)
    return RingRadii(
        pin=pin_radius,
        socket=pin_radius + magnification * design.pin_play,
        sleeve_bore=pin_radius - design.ring.sleeve_thickness,
    )


def measure_gaps(reducer: Reducer, columns: Mapping[str, Array], disc: int = 0) -> Separations:
    """Compute the gaps between a disc and its mates (ring pins or lobes, and output pins) at n samples of a log.

    `columns` are the log columns by name, shape (n,), in SI units. `disc` is the index of the disc. The result also has
    the pose of the disc. `opening` (n, mates) is the gap of each tooth minus the clearance: 0 if both are equal,
    positive if the gap is wider. `output_away` (n, pins) is the distance of each output pin from the centre of its hole
    minus the eccentricity: 0 if the gap is equal to the clearance, positive if it is narrower.
    """
    poses_by_part = poses(reducer, columns)
    disc_poses = poses_by_part[gears(reducer.design.gear.discs)[disc]]
    return Separations(
        **vars(measure_mesh(reducer, poses_by_part, columns["crank_angle"], disc)),
        output_away=_output_gaps(reducer, disc_poses, poses_by_part[OUTPUT]),
    )


def measure_mesh(reducer: Reducer, poses_by_part: Mapping[str, Array], crank: Array, disc: int) -> MeshGaps:
    """Compute the gaps between a disc and the ring at n samples.

    Parameters
    ----------
    poses_by_part
        x [m], y [m] and angle [rad] of each part by name in the frame of the ring, shape (n, 3), as of `poses`.
    crank
        Crank angles relative to the ring [rad], shape (n,).
    disc
        Index of the disc.

    Returns
    -------
    MeshGaps
        Ideal pose of the disc and its deviation, gap of each tooth in excess of the clearance [m], and displacement [m]
        and rotation [rad] of each pin.
    """
    tooth_profile, phase = reducer.tooth_profile, reducer.phases[disc]
    measured_pose = poses_by_part[gears(reducer.design.gear.discs)[disc]]
    ideal_pose = np.column_stack([gear_centre(tooth_profile, crank + phase), gear_rotation(tooth_profile, crank)])
    nominal_centres = ring_places(reducer)
    pin_displacements = np.zeros((crank.size, len(nominal_centres), 3))
    if pin(1) in poses_by_part:
        pin_displacements = np.stack(
            [poses_by_part[pin(number)] for number in range(1, len(nominal_centres) + 1)], axis=1
        )
        pin_displacements[..., :2] -= nominal_centres
    return MeshGaps(
        disc=disc,
        gear=ideal_pose,
        deviation=measured_pose - ideal_pose,
        crank_angle=crank,
        opening=_trochoid_distance(
            tooth_profile,
            measured_pose - [0.0, 0.0, phase / tooth_profile.lobes],
            nominal_centres + pin_displacements[..., :2],
        ),
        away=pin_displacements[..., :2],
        pin_angle=pin_displacements[..., 2],
    )


def ring_normals(reducer: Reducer, gear: Array) -> Array:
    """Compute unit vectors along the ideal common normals, from the disc to each pin or lobe, shape (n, mates, 2).

    They pass through the pitch point, whose distance from the axis is the eccentricity times the number of ring teeth.
    `gear` is the ideal pose of the disc: x [m], y [m] and angle [rad], shape (n, 3).
    """
    normal = ring_places(reducer) - reducer.design.ring.teeth * gear[:, np.newaxis, :2]
    return normal / np.linalg.norm(normal, axis=2, keepdims=True)


def magnify_gaps(reducer: Reducer, gaps: Separations, magnification: float = 1.0) -> Drawing:
    """Compute the poses of all parts at n times for a drawing with `gaps` magnified along the ideal normals.

    `gaps` are those of `measure_gaps`, `magnification` is their factor.

    Raises
    ------
    UsageError
        `magnification` is below 1 or beyond `largest_magnification`.
    """
    mesh, ideal_pose = magnify_mesh(reducer, gaps, magnification), gaps.gear
    hole_centres = transform(ideal_pose[:, np.newaxis], output_centres(reducer))
    eccentric_direction = ideal_pose[:, np.newaxis, :2] / reducer.design.gear.eccentricity
    pin_distance = reducer.design.gear.eccentricity + magnification * gaps.output_away[..., np.newaxis]
    return Drawing(
        magnification=magnification,
        radii=drawn_radii(reducer, magnification),
        gaps=gaps,
        gear=ideal_pose,
        ring=mesh.ring,
        sockets=mesh.sockets,
        shaft=np.column_stack([-magnification * gaps.deviation[:, :2], gaps.crank_angle]),
        output_pins=hole_centres - pin_distance * eccentric_direction,
    )


def magnify_mesh(reducer: Reducer, gaps: MeshGaps, magnification: float = 1.0) -> MeshDrawing:
    """Compute the poses of disc and ring at n times for a drawing with `gaps` magnified along the ideal normals.

    `gaps` are those of `measure_mesh`, `magnification` is their factor.

    Raises
    ------
    UsageError
        `magnification` is below 1 or beyond `largest_magnification`.
    """
    drawn_opening = magnification * gaps.opening[..., np.newaxis] * ring_normals(reducer, gaps.gear)
    pin_centres = ring_places(reducer) + drawn_opening
    return MeshDrawing(
        magnification=magnification,
        radii=_ring_radii(reducer, magnification),
        gaps=gaps,
        gear=gaps.gear,
        ring=pin_centres,
        sockets=pin_centres - magnification * gaps.away,
    )


def ring_outline(reducer: Reducer, outline: Array, normals: Array, drawing: MeshDrawing, frame: int) -> Array:
    """Compute the outline of an internal gear [m], displaced by magnified gaps, in a frame of an animation, (m, 2).

    Parameters
    ----------
    outline, normals
        The m points of the outline as designed [m], and its unit normals, which point into the bore, shape (m, 2) each.
    drawing
        The drawing of all frames.
    frame
        Index of the frame.
    """
    disc_pose, deviation = drawing.gear[frame], drawing.gaps.deviation[frame]
    opening = np.einsum("mk,mk->m", normals, _disc_displacement(outline - disc_pose[:2], deviation))
    excess = drawing.magnification - 1.0
    return outline - normals * (excess * tooth_clearance(reducer) + drawing.magnification * opening)[:, np.newaxis]


def _trochoid_distance(disc_profile: CycloidGear, disc_poses: Array, centres: Array) -> Array:
    """Compute the signed distance of pin centres from the trochoid of a disc [m], shape (n, mates), positive outside.

    Newton's method finds the nearest point of the trochoid, starting from its ideal position; the steps are limited, so
    that the point stays on its lobe.

    Parameters
    ----------
    disc_profile
        Profile of the disc.
    disc_poses
        Poses of the disc: x, y [m] and angle [rad], shape (n, 3).
    centres
        Pin centres [m], shape (n, mates, 2).
    """
    max_increment = 0.5 / centres.shape[1]
    points = rotate(centres - disc_poses[:, np.newaxis, :2], -disc_poses[:, 2:])
    phases = np.resize(profile.pin_angles(disc_profile), centres.shape[1]) + disc_poses[:, 2:]
    for _ in range(DRAWING.newton_steps):
        tangent, second_derivative = profile.trochoid_derivatives(disc_profile, phases)
        offset_to_foot = profile.trochoid(disc_profile, phases) - points
        speed_squared = np.einsum("nik,nik->ni", tangent, tangent)
        curvature = speed_squared + np.einsum("nik,nik->ni", offset_to_foot, second_derivative)
        parameter_step = np.einsum("nik,nik->ni", offset_to_foot, tangent) / np.maximum(
            curvature, DRAWING.min_curvature * speed_squared
        )
        phases = phases - np.clip(parameter_step, -max_increment, max_increment)
    return np.einsum(
        "nik,nik->ni", points - profile.trochoid(disc_profile, phases), profile.normals(disc_profile, phases)
    )


def _output_gaps(reducer: Reducer, disc_poses: Array, output_poses: Array) -> Array:
    """Compute the distance of output pins from the centres of their holes minus the eccentricity [m], shape (n, pins).

    `disc_poses` and `output_poses` are those of the disc and of the output, shape (n, 3).
    """
    pin_centres, hole_centres = (
        transform(pose[:, np.newaxis], output_centres(reducer)) for pose in (output_poses, disc_poses)
    )
    return np.linalg.norm(pin_centres - hole_centres, axis=2) - reducer.design.gear.eccentricity


def _disc_displacement(arm: Array, deviation: Array) -> Array:
    """Compute the displacement of points of the disc to first order [m], shape (..., 2).

    `arm` (..., 2) [m] are the vectors from the centre of the disc to the points. `deviation` (..., 3) is the
    displacement of the disc: x [m], y [m] and rotation [rad].
    """
    rotation = deviation[..., 2]
    return deviation[..., :2] + np.stack([-rotation * arm[..., 1], rotation * arm[..., 0]], axis=-1)
