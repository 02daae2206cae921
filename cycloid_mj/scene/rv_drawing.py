"""Plane drawing of an RV reducer with magnified gaps: a disc in its ideal pose, its pins, cranks, posts and the sun.

As in `drawing`, the disc is drawn in its ideal pose and its mates are placed by their gaps. An eccentric is displaced
in its bore by its magnified displacement; posts and sun, which do not touch the disc, are at their measured positions.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array, rotate
from cycloid_mj.base.names import CRANK_BEARING, OUTPUT, SUN
from cycloid_mj.parts.rv import crank_centres, post_centres
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.rv_bodies import crank_names
from cycloid_mj.scene.drawing import (
    DRAWING,
    MeshDrawing,
    check_magnification,
    magnify_mesh,
    measure_mesh,
    tooth_clearance,
)
from cycloid_mj.scene.pose import poses, transform


@dataclass(frozen=True, eq=False)
class RvDrawing(MeshDrawing):
    """Drawn poses of an RV reducer at n times, in the frame of the ring; x right, y up, [m] and [rad].

    Attributes
    ----------
    eccentric_radius
        Radius that the eccentrics are drawn with, over their needles [m].
    eccentrics
        Centres of the eccentrics in the disc, shape (n, cranks, 2).
    cranks
        Poses of the cranks, whose planets turn with them, shape (n, cranks, 3).
    posts
        Centres of the posts of the carrier, shape (n, posts, 2).
    sun
        Pose of the sun, shape (n, 3).
    """

    eccentric_radius: float
    eccentrics: Array
    cranks: Array
    posts: Array
    sun: Array


def largest_rv_magnification(reducer: RvReducer) -> float:
    """Compute the largest factor [1] by which the clearances of an RV reducer can be magnified in a drawing.

    Each part keeps at least `DRAWING.min_radius_share` of its radius.
    """
    radii_and_clearances = [(reducer.design.ring.pin_radius, tooth_clearance(reducer))]
    radii_and_clearances += [
        (reducer.bore_radius, clearance) for clearance in (reducer.bearing_clearance,) if clearance > 0.0
    ]
    return 1.0 + (1.0 - DRAWING.min_radius_share) * min(
        radius / clearance for radius, clearance in radii_and_clearances
    )


def draw_rv_poses(
    reducer: RvReducer, columns: Mapping[str, Array], disc: int = 0, magnification: float = 1.0
) -> RvDrawing:
    """Compute the poses of all parts of an RV reducer at n samples of a log, for a drawing with magnified gaps.

    Parameters
    ----------
    reducer
        The reducer, with a fixed ring (`view_from_ring`).
    columns
        Log columns by name in the frame of the ring, shape (n,), in SI units.
    disc
        Index of the disc.
    magnification
        Factor by which gaps and clearances are magnified.

    Raises
    ------
    UsageError
        The magnification is below 1 or beyond `largest_rv_magnification`.
    """
    check_magnification(reducer, magnification, largest_rv_magnification(reducer))
    poses_by_part, crank_mating = poses(reducer, columns), reducer.mechanism.mating(CRANK_BEARING, disc)
    crank_poses = np.stack([poses_by_part[name] for name in crank_names(reducer)], axis=1)
    mesh = magnify_mesh(
        reducer, measure_mesh(reducer, poses_by_part, crank_poses[..., 2].mean(axis=1), disc), magnification
    )
    disc_poses = poses_by_part[reducer.gears[disc]][:, np.newaxis]
    displacement = transform(crank_poses, crank_mating.by.position) - transform(disc_poses, crank_mating.on.position)
    eccentrics = transform(mesh.gear[:, np.newaxis], crank_centres(reducer)) + magnification * displacement
    axis_centres = eccentrics - rotate(crank_mating.by.position, crank_poses[..., 2])
    return RvDrawing(
        **vars(mesh),
        eccentric_radius=reducer.bore_radius - magnification * max(reducer.bearing_clearance, 0.0),
        eccentrics=eccentrics,
        cranks=np.concatenate([axis_centres, crank_poses[..., 2:]], axis=-1),
        posts=transform(poses_by_part[OUTPUT][:, np.newaxis], post_centres(reducer)),
        sun=poses_by_part[SUN],
    )
