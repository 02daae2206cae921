"""Stiffness of tooth contacts by their curvature, from `ideal_loads` and `profile` only."""

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.geometry import ideal_loads, profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate.gaps import Flanks, GearPose, NearestPoints, flank_distance, offset_root


def tooth_stiffness(
    reducer: Reducer, flat_stiffness: float, nearest: NearestPoints, pose: GearPose, flanks: Flanks
) -> Array:
    """Compute the stiffness of each of n contacts of the mesh [N/m], shape (n,).

    It is that of a line contact at the local relative curvature, at most twice `flat_stiffness`. If the lines of an arc
    and a root are so close that they form one contact patch, they share the stiffness of a single line
    (`_share_patches`).

    Parameters
    ----------
    reducer
        The reducer, for the law of the stiffness and for materials.
    flat_stiffness
        Stiffness of a pin on a flat [N/m].
    nearest, pose, flanks
        Nearest points of disc and ring at the n contacts, pose of the disc, and its flanks.
    """
    stiffness = np.full(nearest.distance.size, flat_stiffness)
    if reducer.design.contact.stiffness_law == "local":
        relative_curvature = profile.curvature(flanks.gear, nearest.t, flanks.offset) + nearest.ring_curvature
        stiffness = flat_stiffness * _stiffness_factor(reducer, relative_curvature)
    return _share_patches(reducer, flat_stiffness, nearest, pose, flanks, stiffness)


def _stiffness_factor(reducer: Reducer, curvature: Array) -> Array:
    """Compute the stiffness of line contacts divided by that of a pin on a flat [1].

    `curvature` is the relative curvature of each [1/m], of any shape; the result has the same shape.
    """
    design = reducer.design
    pin_radius = design.ring.pin_radius
    modulus = ideal_loads.contact_modulus(design.material.youngs_modulus, design.material.poisson)
    arguments = (reducer.contacts[design.tooth_pair].force, design.gear.face_width, modulus, pin_radius)
    reference_stiffness = ideal_loads.line_contact_stiffness(*arguments, 1 / pin_radius)
    # The stiffness is twice that on a flat where a + ln kappa has half of its value there.
    min_curvature = np.exp(-(ideal_loads.line_contact_constant(*arguments) + np.log(pin_radius)) / 2)
    return ideal_loads.line_contact_stiffness(*arguments, np.maximum(curvature, min_curvature)) / reference_stiffness


def _share_patches(
    reducer: Reducer,
    flat_stiffness: float,
    nearest_points: NearestPoints,
    pose: GearPose,
    flanks: Flanks,
    stiffness: Array,
) -> Array:
    """Return the stiffness of n contact lines [N/m], (n,), reduced for lines that form one contact area (patch).

    A line on a flank Sigma and that on the arc of its lobe form a patch if the gap half-way between them exceeds the
    larger of their own gaps by less than the deflection of the teeth under their working force (`Contact.force`). The
    smaller this excess, the closer is the sum of their stiffnesses to that of a single line.

    Parameters
    ----------
    flat_stiffness
        Stiffness of a pin on a flat [N/m].
    nearest_points, pose, flanks
        Nearest points of disc and ring, pose of the disc, and its flanks.
    stiffness
        Stiffness of each line on its own [N/m], shape (n,).
    """
    gear, deflection = reducer.tooth_profile, reducer.contacts[reducer.design.tooth_pair].force / flat_stiffness
    min_phase, stiffness = gear.best_phase, stiffness.copy()
    arc_indices = {int(lobe): row for row, lobe in enumerate(nearest_points.owner) if np.isnan(nearest_points.B[row])}
    for row in np.flatnonzero(
        ~np.isnan(nearest_points.B) & (nearest_points.distance < gear.pin_radius - flanks.offset)
    ):
        arc_index = arc_indices.get(int(nearest_points.owner[row]))
        if arc_index is None:
            continue
        is_same_lobe = nearest_points.B[row] <= np.pi
        root_index = nearest_points.owner[row] if is_same_lobe else (nearest_points.owner[row] + 1) % gear.ring_teeth
        mid_phase = np.array([(nearest_points.B[row] + (min_phase if is_same_lobe else 2 * np.pi - min_phase)) / 2])
        mid_gap = flank_distance(flanks, pose.to_gear(offset_root(gear, int(root_index), mid_phase)))[0][0]
        gap_rise = mid_gap - max(nearest_points.distance[row], nearest_points.distance[arc_index])
        separation = float(np.clip(gap_rise / deflection, 0.0, 1.0))
        share = (1 + separation) / 2
        stiffness[row] = share * (stiffness[arc_index] + separation * (stiffness[row] - stiffness[arc_index]))
        stiffness[arc_index] *= share
    return stiffness
