"""Contact of the disc's flank with the ring: where the force of a lobe acts, and the relative curvature there."""

import math

import numpy as np

from cycloid_mj.base.array import Array, cross
from cycloid_mj.geometry import envelope, profile
from cycloid_mj.geometry.profile import CycloidGear


def lobe_lines(gear: CycloidGear, crank_angle: Array) -> tuple[Array, Array]:
    """Compute the ideal contact lines between the disc and each of n lobes of an internal gear, at k crank angles.

    `crank_angle` (k,) [rad] are the crank angles. A lobe has three parts: the arc at its tip, and the flank on either
    side.

    Returns
    -------
    t, curvature
        Parameter of the disc's outline [rad] and relative curvature [1/m] of each line, shape (k, n, 3) each. The last
        axis is the part of the lobe, the arc first; NaN where that part does not touch the disc.
    """
    lobes = gear.ring_teeth
    t, curvature = np.full((2, crank_angle.size, lobes, 3), np.nan)
    for k, theta in enumerate(crank_angle):
        arcs, roots = envelope.arc_contacts(gear, float(theta)), envelope.sigma_contacts(gear, float(theta))
        t[k, arcs.lobe, 0], curvature[k, arcs.lobe, 0] = arcs.t, arcs.relative_curvature
        phase = roots.B
        is_past_lobe = phase > np.pi
        lobe = np.mod(roots.lobe - is_past_lobe, lobes)
        t[k, lobe, 1 + is_past_lobe], curvature[k, lobe, 1 + is_past_lobe] = roots.t, roots.relative_curvature
    return t, curvature


def lobe_contact_point(
    gear: CycloidGear,
    action_point: Array,
    direction: Array,
    lines: Array,
    curvature: Array,
    rotation_error: Array,
    offset: float,
) -> tuple[Array, Array]:
    """Compute where the force of a lobe acts on the disc's flank at k crank angles [m], and the relative curvature.

    The force of a lobe is the sum of up to three line contacts. It acts where the line of action of the sum intersects
    the flank, which Newton's method determines from the nearest ideal contact line.

    Parameters
    ----------
    gear
        Profile of the disc.
    action_point, direction
        A point of the force's line of action [m], and the unit vector along the force, in the frame of the gear, (k,
        2).
    lines, curvature
        Parameter on the outline [rad] and relative curvature [1/m] of the ideal contact lines of this lobe, from
        `lobe_lines`, (k, 3).
    rotation_error
        Small angle [rad] (k,) by which the disc is rotated beyond its ideal angle, counter-clockwise.
    offset
        Offset of the flank from the trochoid [m].

    Returns
    -------
    tuple
        Position of the force in the frame of the gear [m], (k, 2), and relative curvature at the nearest ideal contact
        line [1/m], (k,). The position is NaN if no contact line faces the force.
    """
    start_values = lines + rotation_error[:, np.newaxis]
    distances = np.abs(_miss(gear, start_values, action_point[:, np.newaxis], direction[:, np.newaxis], offset))
    faces_force = np.sum(profile.normals(gear, start_values) * direction[:, np.newaxis], axis=-1) < 0.0
    distances = np.where(faces_force & np.isfinite(distances), distances, np.inf)
    angle_indices, nearest = np.arange(len(start_values)), np.argmin(distances, axis=1)
    start_t = np.where(np.isfinite(distances[angle_indices, nearest]), start_values[angle_indices, nearest], np.nan)
    t = start_t
    half_lobe = math.pi / gear.lobes
    for _ in range(30):
        tangent = profile.arc_rate(gear, t, offset)[:, np.newaxis] * _ahead(gear, t)
        slope = cross(tangent, direction)
        t_step = np.divide(
            _miss(gear, t, action_point, direction, offset), slope, out=np.zeros_like(t), where=slope != 0.0
        )
        t = np.clip(t - t_step, start_t - half_lobe, start_t + half_lobe)
    return profile.outline(gear, t, offset), curvature[angle_indices, nearest]


def _miss(gear: CycloidGear, t: Array, action_point: Array, direction: Array, offset: float) -> Array:
    """Compute the distance of the outline at the parameter t [rad] from the line of action [m]."""
    return cross(profile.outline(gear, t, offset) - action_point, direction)


def _ahead(gear: CycloidGear, t: Array) -> Array:
    """Compute the unit tangents of the outline at the parameters t [rad], in clockwise direction, shape (..., 2)."""
    return profile.unit(profile.normal_angle(gear, t) + math.pi / 2)
