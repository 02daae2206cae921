"""Gaps of all mating pairs at a crank angle, as functions of small displacements of discs and output.

The unknowns z [m], shape (3 D + 1,), are departures from the ideal pose: x, y and R phi of each of the D discs, and
R psi of the output; R is the radius of the circle of output pins, phi and psi are counter-clockwise. A gap is the
normal distance of two surfaces, positive if they are separate. At the ideal pose it follows from clearances,
manufacturing errors, profile modification and wear; its gradient is the direction of the contact force on the parts.

A contact also moves along the surface: statics (`kernel.gap`) represents each curve by its circle of curvature
and the rate of change of the curvature, and rotations to second order. Neglected terms are of fourth order in
displacements, of third in rotations; where this is not enough, as in the valleys of the paper's gear with their radius
of 18 um, it searches the foot point.

Angles as in ``kinematics``, tooth geometry as in ``envelope``. A disc at the phase beta on the crank meshes as the gear
of a crank at theta + beta (Hsieh 2014, Eqs 7 and 11, for one disc); its holes turn with the output.
"""

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array, Integers, Mask, dot, quarter_turned, rotate
from cycloid_mj.base.deprecated import deprecated_attribute
from cycloid_mj.geometry import envelope, profile
from cycloid_mj.geometry.deviations import profile_error
from cycloid_mj.geometry.kinematics import gear_centre

if TYPE_CHECKING:
    from cycloid_mj.reducer import Reducer

_STEP = 1e-6
"""Step of finite differences along the trochoid [rad]."""


@dataclass(frozen=True)
class Gaps:
    """Gaps at one crank angle, shape (n,), or at k crank angles, with an additional first axis.

    Attributes
    ----------
    kind
        Kind of the mating pair: ``pin_gear``, ``tooth`` or ``output``, shape (n,).
    owner
        Index of the pin, lobe or output pin, 0 on +y, clockwise, shape (n,); those of a ring's second half count on.
    disc
        Index of the disc, shape (n,).
    clearance
        Part of the gap that does not depend on the pose [m], shape (n,): clearances, errors of radii.
    play
        Clearance of the ring's pin in its socket, or of its sleeve [m], shape (n,); 0 for fixed pins. It is not part of
        `clearance`: a loaded pin moves by it first.
    distance
        Normal distance of the two curves at z = 0 [m], shape (n,): 0 for ideal parts.
    slope
        Its gradient [1], shape (n, 3 D + 1).
    shift, shift_slope
        Displacement of the parts along the surface at z = 0 [m], shape (n,), and its gradient.
    curvature
        Relative curvature [1/m] of the two curves, shape (n,): of the gear's trochoid, on which ideal pins have their
        centres; of the circle about the middle of a hole on which those of output pins are. Convex positive.
    curvature_rate
        Rate of `curvature` along the surface [1/m2], shape (n,), towards the force turned counter-clockwise; 0 of
        circles.
    phase
        N - 1 times the parameter of the gear's trochoid at the contact [rad], shape (n,); of round holes 0.
    relative_curvature
        Relative curvature of the line contact [1/m]: disc plus mate, shape (n,).
    slip_slope
        Gradient of the sliding of the disc's surface over its mate [1], shape (n, 3 D + 1), in the direction of the
        normal force rotated counter-clockwise by a right angle; the mate does not rotate about itself.
    """

    kind: npt.NDArray[np.str_]
    owner: Integers
    disc: Integers
    clearance: Array
    play: Array
    distance: Array
    slope: Array
    shift: Array
    shift_slope: Array
    curvature: Array
    curvature_rate: Array
    phase: Array
    relative_curvature: Array
    slip_slope: Array
    room = deprecated_attribute("Gaps", "room", "clearance")
    bend = deprecated_attribute("Gaps", "bend", "curvature")
    twist = deprecated_attribute("Gaps", "twist", "curvature_rate")

    def select(self, rows: Mask) -> "Gaps":
        """Return the gaps of the rows that a mask (n,) marks; only for gaps at one crank angle."""
        return Gaps(**{field.name: getattr(self, field.name)[rows] for field in fields(self)})

    @property
    def width(self) -> Array:
        """Gaps at z = 0, to first order [m], shape (n,)."""
        return np.asarray(self.clearance + self.distance)


def unknowns(reducer: "Reducer") -> int:
    """Return the number of unknowns: three for each disc, one for the output."""
    return 3 * len(reducer.phases) + 1


def gaps(reducer: "Reducer", crank_angle: float) -> Gaps:
    """Compute the gaps of teeth and output pins of all discs at one crank angle in the frame of the ring [rad].

    Each gap is a linear function of the pose of discs and output: a value at the ideal pose, and a gradient.
    The teeth come first, then the output pins. With an internal gear, the gaps of its flanks follow, 4 or 5 per disc.
    The cams are not included, because their gaps are not linear in the pose: see `cam_displacements`.
    """
    discs = range(len(reducer.phases))
    flanks = [flank_gaps(reducer, crank_angle, disc) for disc in discs] if reducer.design.ring.kind == "nonpin" else []
    return _concatenate([arc_gaps(reducer, crank_angle), *flanks])


def arc_gaps(reducer: "Reducer", crank_angle: npt.ArrayLike) -> Gaps:
    """Compute the gaps of all round contacts (pins or arcs of the ring, and output pins) at k crank angles [rad].

    `crank_angle` is in the frame of the ring, shape (k,) or (). At each angle, the contacts of all discs with the ring
    come first, disc by disc, then those with the output pins. In a ring of two halves, each disc has the contacts with
    the first half, then with the second. The flanks of an internal gear between its arcs are not included; see
    `flank_gaps`.
    """
    angles = np.asarray(crank_angle, dtype=np.float64)
    discs = range(len(reducer.phases))
    parts = [part(reducer, angles, disc) for part in (_arc_gaps, _output_gaps) for disc in discs]
    return _concatenate(parts)


def mesh_gaps(reducer: "Reducer", crank_angle: Array) -> Gaps:
    """Compute the gaps between all discs and the ring at crank angles (k,) [rad], as `arc_gaps` without output pins."""
    return _concatenate([_arc_gaps(reducer, crank_angle, disc) for disc in range(len(reducer.phases))])


def _arc_gaps(reducer: "Reducer", crank_angle: Array, disc: int) -> Gaps:
    gear, turned = reducer.tooth_profile, crank_angle[..., np.newaxis] + reducer.phases[disc]
    lines, middle = envelope.arc_contacts(gear, turned), gear_centre(gear, turned)
    return _gaps_with_each_half(reducer, disc, lines, middle)


def flank_gaps(reducer: "Reducer", crank_angle: float, disc: int = 0) -> Gaps:
    """Compute the gaps between a disc and the flanks of an internal gear at a crank angle [rad]: 4 or 5 gaps.

    They are exact to first order in the displacements. The crank angle is in the frame of the ring; `disc` is the index
    of the disc.
    """
    gear, disc_crank_angle = reducer.tooth_profile, crank_angle + reducer.phases[disc]
    lines, disc_centre = envelope.sigma_contacts(gear, disc_crank_angle), gear_centre(gear, disc_crank_angle)
    return _gaps_with_each_half(reducer, disc, lines, disc_centre)


def _gaps_with_each_half(reducer: "Reducer", disc: int, lines: envelope.RingContacts, middle: Array) -> Gaps:
    ahead = reducer.design.ring.ahead
    return _concatenate([_tooth_gaps(reducer, disc, lines, middle, half_index) for half_index in range(len(ahead))])


def _tooth_gaps(reducer: "Reducer", disc: int, lines: envelope.RingContacts, centre: Array, half_index: int) -> Gaps:
    """Compute the gaps between a disc and the ring, or an axial half of it, at the contact lines of the ideal mesh.

    Errors and modifications of the profile change the gap of a line as follows:

    - a displacement of the pin opens it by its component along the outward normal of the disc;
    - a pin radius larger by r closes it by r, and reduces the clearance of the pin in its socket by r;
    - a disc profile larger by r closes it by r;
    - a disc generated with a pin circle larger by x has the same gaps as ring pins closer to the axis by x;
    - a rotation of the flanks by an angle a opens it by a times the lever arm of the normal.

    The curvature in the result is the relative curvature of the disc's trochoid and the path of the pin's centre.

    Parameters
    ----------
    disc, half_index
        Indices of the disc and of the axial half of the ring; 0 for a ring in one piece.
    lines
        Contact lines of the ideal disc, for pins in their nominal positions.
    centre
        Centre of the ideal disc [m].
    """
    design = reducer.design
    gear, errors, modification = reducer.tooth_profile, reducer.deviations, design.modification
    inward_normal, arm = lines.normals, profile.moment_arm(gear, lines.B)
    outward_direction = profile.unit(profile.pin_angles(gear)[lines.lobe])
    preload_offset = design.ring.ahead[half_index] * gear.pin_circle_radius * quarter_turned(outward_direction)
    displacement = errors.pin_displacement[lines.lobe] + preload_offset - modification.pin_circle * outward_direction
    nominal_gap = reducer.profile_offset - errors.disc_radius[disc] - gear.pin_radius - errors.pin_radius[lines.lobe]
    play = design.pin_play - (errors.pin_radius[lines.lobe] if design.ring.has_sockets else 0.0)
    flank_rotation = modification.rotation * np.sign(arm)
    tangent = quarter_turned(inward_normal)
    sliding_arm = dot(tangent, quarter_turned(lines.points - centre))
    centre_arm = sliding_arm - gear.pin_radius
    curvature_before, middle_curvature, curvature_after = (
        profile.curvature(gear, lines.t + t_increment, 0.0) for t_increment in (-_STEP, 0.0, _STEP)
    )
    arc_rate = profile.pitch_distance(gear, profile.phase(gear, lines.t))  # of the trochoid, by its parameter
    curvature_rate = (curvature_after - curvature_before) / (2.0 * _STEP * arc_rate)
    wear_depth = reducer.worn.of_teeth(lines.B) if reducer.worn else 0.0
    return Gaps(
        kind=np.full(lines.lobe.size, design.tooth_pair),
        owner=lines.lobe + half_index * design.ring.teeth,
        disc=np.full(lines.lobe.size, disc),
        clearance=np.broadcast_to(nominal_gap, arm.shape),
        play=np.broadcast_to(play, arm.shape),
        distance=flank_rotation * arm
        - dot(displacement, inward_normal)
        + profile_error(errors.waves, lines.t)
        + wear_depth,
        slope=_gradient_by_pose(reducer, disc, inward_normal, arm, np.zeros(arm.shape)),
        shift=dot(displacement, tangent) - flank_rotation * centre_arm,
        shift_slope=_gradient_by_pose(reducer, disc, -tangent, -centre_arm, np.zeros(arm.shape)),
        curvature=middle_curvature,
        curvature_rate=np.asarray(curvature_rate),
        phase=gear.lobes * lines.t,
        relative_curvature=lines.relative_curvature,
        slip_slope=_gradient_by_pose(reducer, disc, tangent, sliding_arm, np.zeros(arm.shape)),
    )


def _output_gaps(reducer: "Reducer", crank_angle: Array, disc: int) -> Gaps:
    """Compute the gaps between the holes of a disc and the n output pins at crank angles (...) [rad], shape (..., n).

    Every pin touches the inner side of its hole, and pushes the disc in the direction opposite to its eccentricity. A
    displacement of a hole in the disc opens its gap by the component in this direction. The lever arm of a contact is
    the same about the centre of the disc and about the axis of the output, because holes and pins are on equal circles.
    """
    gear, errors, output = reducer.tooth_profile, reducer.deviations, reducer.design.output
    output_angle = crank_angle[..., np.newaxis] / gear.lobes
    disc_centre = gear_centre(gear, crank_angle[..., np.newaxis] + reducer.phases[disc])
    push_direction = -disc_centre / gear.eccentricity
    arm_vector = (
        profile.unit(2.0 * np.pi * np.arange(output.pins) / output.pins + output_angle) * output.pin_circle_radius
    )
    tangent, hole_displacement = quarter_turned(push_direction), rotate(errors.hole_displacement[disc], -output_angle)
    normal_arm, tangent_arm = dot(arm_vector, -tangent), dot(arm_vector, push_direction)
    wear_depth = reducer.worn.of_output(np.arctan2(normal_arm, tangent_arm)) if reducer.worn else 0.0
    return Gaps(
        kind=np.full(output.pins, "output"),
        owner=np.arange(output.pins),
        disc=np.full(output.pins, disc),
        clearance=np.full(normal_arm.shape, reducer.output_clearance),
        play=np.zeros(normal_arm.shape),
        distance=dot(hole_displacement, push_direction) + wear_depth,
        slope=_gradient_by_pose(reducer, disc, push_direction, normal_arm, -normal_arm),
        shift=-dot(hole_displacement, tangent),
        shift_slope=_gradient_by_pose(reducer, disc, -tangent, -tangent_arm, tangent_arm),
        curvature=np.full(normal_arm.shape, -1.0 / gear.eccentricity),
        curvature_rate=np.zeros(normal_arm.shape),
        phase=np.zeros(normal_arm.shape),
        relative_curvature=np.full(normal_arm.shape, 1.0 / output.pin_radius - 1.0 / output.hole_radius),
        slip_slope=_gradient_by_pose(
            reducer, disc, tangent, tangent_arm + output.hole_radius, -(tangent_arm + output.pin_radius)
        ),
    )


def ideal_motion(reducer: "Reducer", crank_angle: npt.ArrayLike) -> Array:
    """Compute the derivatives of the pose of discs and output by the crank angle in the ideal motion [m/rad].

    The pose of D discs is x, y and rotation of each, and the rotation of the output; rotations are multiplied by the
    radius of the circle of output pins. The result has the shape (..., 3 D + 1) for crank angles (...) [rad]. Disc
    centres move on circles; discs and output rotate by -1/(N-1) of the crank's rotation (Hsieh 2014, Eqs 12 and 13,
    corrected). The product with `Gaps.slip_slope` is the sliding distance of each contact per crank rotation [m/rad];
    the product with `Gaps.slope` is 0.
    """
    gear, angles = reducer.tooth_profile, np.asarray(crank_angle, dtype=np.float64)
    motion = np.full((*angles.shape, unknowns(reducer)), -reducer.lever / gear.lobes)
    for disc, phase in enumerate(reducer.phases):
        motion[..., 3 * disc : 3 * disc + 2] = quarter_turned(gear_centre(gear, angles + phase))
    return motion


def cam_displacements(reducer: "Reducer", crank_angle: npt.ArrayLike) -> Array:
    """Compute the displacement of each cam by manufacturing errors of the crank [m], shape (..., D, 2), in x and y.

    Displacements and crank angles (...) [rad] are in the frame of the ring. The clearance of the cam limits the
    distance between a disc's centre and the displaced cam.
    """
    gear, errors = reducer.tooth_profile, reducer.deviations
    crank_column = np.asarray(crank_angle, dtype=np.float64)[..., np.newaxis]
    angles = crank_column + np.array(reducer.phases)
    return np.asarray(
        errors.eccentricity * gear_centre(gear, angles) / gear.eccentricity
        + rotate(errors.cam_displacement, crank_column)
    )


def _gradient_by_pose(reducer: "Reducer", disc: int, by_position: Array, by_rotation: Array, by_output: Array) -> Array:
    """Return the gradient [1] of n gaps of one disc by the pose of all D discs and the output, shape (..., n, 3 D + 1).

    The pose is x, y and rotation of each disc, and the rotation of the output; rotations are multiplied by the radius
    of the circle of output pins. `by_position` (..., n, 2) [1] are the derivatives by x and y of the disc;
    `by_rotation` and `by_output` (..., n) [m/rad] are those by the rotations of disc and output.
    """
    slope = np.zeros((*by_rotation.shape, unknowns(reducer)))
    slope[..., 3 * disc : 3 * disc + 2] = by_position
    slope[..., 3 * disc + 2] = by_rotation / reducer.lever
    slope[..., -1] = by_output / reducer.lever
    return slope


def _concatenate(parts: list[Gaps]) -> Gaps:
    """Concatenate gaps along the axis of the n contacts, in the order of the list."""
    if len(parts) == 1:
        return parts[0]
    along = {field.name: -2 if field.name.endswith("slope") else -1 for field in fields(Gaps)}
    joined = {name: [getattr(part, name) for part in parts] for name in along}
    return Gaps(**{name: np.concatenate(arrays, axis=along[name]) for name, arrays in joined.items()})
