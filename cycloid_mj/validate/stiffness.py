"""Stiffness of tooth contacts by their curvature, from `ideal_loads` and `profile` only."""

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.geometry import ideal_loads, profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate.gaps import Flanks, GearPose, NearestPoints, flank_distance, offset_root


def tooth_stiffness(reducer: Reducer, flat: float, mesh: NearestPoints, pose: GearPose, flanks: Flanks) -> Array:
    """Compute the stiffness [N/m] of each contact of the mesh, (n,); `flat` is that of a pin on a flat [N/m].

    It is that of a line contact at the local relative curvature, at most twice `flat`. Lines of an arc and a root with
    less than one deflection of gap between them form one patch and share its stiffness.
    """
    stiffness = np.full(mesh.distance.size, flat)
    if reducer.design.contact.stiffness_law == "local":
        relative = profile.curvature(flanks.gear, mesh.t, flanks.offset) + mesh.ring_curvature
        stiffness = flat * _factor(reducer, relative)
    return _share_patches(reducer, flat, mesh, pose, flanks, stiffness)


def _factor(reducer: Reducer, curvature: Array) -> Array:
    """Compute the stiffness at a relative curvature [1/m] relative to that of a pin on a flat."""
    design = reducer.design
    depth = design.ring.pin_radius
    modulus = ideal_loads.contact_modulus(design.material.youngs_modulus, design.material.poisson)
    working = (reducer.contacts[design.tooth_pair].force, design.gear.face_width, modulus, depth)
    flat = ideal_loads.line_contact_stiffness(*working, 1 / depth)
    # The stiffness is twice that on a flat where a + ln kappa has half of its value there.
    least = np.exp(-(ideal_loads.line_contact_constant(*working) + np.log(depth)) / 2)
    return ideal_loads.line_contact_stiffness(*working, np.maximum(curvature, least)) / flat


def _share_patches(
    reducer: Reducer, flat: float, mesh: NearestPoints, pose: GearPose, flanks: Flanks, stiffness: Array
) -> Array:
    """Return the stiffness with contact lines of one patch sharing that of a single line [N/m], (n,)."""
    gear, deflection = reducer.tooth_profile, reducer.contacts[reducer.design.tooth_pair].force / flat
    low, stiffness = gear.best_phase, stiffness.copy()
    arcs = {int(lobe): row for row, lobe in enumerate(mesh.owner) if np.isnan(mesh.B[row])}
    for row in np.flatnonzero(~np.isnan(mesh.B) & (mesh.distance < gear.pin_radius - flanks.offset)):
        arc = arcs.get(int(mesh.owner[row]))
        if arc is None:
            continue
        same_lobe = mesh.B[row] <= np.pi
        number = mesh.owner[row] if same_lobe else (mesh.owner[row] + 1) % gear.ring_teeth
        middle = np.array([(mesh.B[row] + (low if same_lobe else 2 * np.pi - low)) / 2])
        between = flank_distance(flanks, pose.to_gear(offset_root(gear, int(number), middle)))[0][0]
        rise = between - max(mesh.distance[row], mesh.distance[arc])
        separation = float(np.clip(rise / deflection, 0.0, 1.0))
        share = (1 + separation) / 2
        stiffness[row] = share * (stiffness[arc] + separation * (stiffness[row] - stiffness[arc]))
        stiffness[arc] *= share
    return stiffness
