"""The clearances of the exported outlines, measured on the points that are written."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.geometry import profile
from cycloid_mj.parts import output_centres
from cycloid_mj.parts.accuracy import RELATIVE_ROUNDING
from cycloid_mj.parts.polygon import rotate_clockwise
from cycloid_mj.reducer import Reducer

TOLERANCE = 2e-8
"""Allowed deviation of a clearance from the design [m]."""


@dataclass(frozen=True)
class DistanceSearch:
    """Settings of the search for the nearest point of a flank by Newton's method."""

    starts_per_lobe: int = 200  # start points on each lobe
    newton_steps: int = 20  # number of steps: convergence is quadratic


SEARCH = DistanceSearch()


@dataclass(frozen=True)
class OutlineClearance:
    """The clearance of a mating pair: that of the design (`asked`), and the smallest and largest of the outline [m]."""

    pair: str
    asked: float
    least: float
    most: float


def flank_distance(gear: profile.CycloidGear, points: Array) -> Array:
    """Compute the distance [m] of n points from the path of pin centres around a disc (trochoid), positive inside.

    The flank of the disc is the pin radius further inside. `points` has the shape (n, 2) [m], the result (n,). `gear`
    is the profile of the disc.
    """
    from scipy.spatial import cKDTree

    starts = 2.0 * np.pi * np.arange(SEARCH.starts_per_lobe * gear.lobes) / (SEARCH.starts_per_lobe * gear.lobes)
    # the outline, not the trochoid: points in a lobe's tip are nearer to other segments of the trochoid
    _, nearest_indices = cKDTree(profile.outline(gear, starts)).query(points)
    parameters = starts[nearest_indices]
    for _ in range(SEARCH.newton_steps):
        offset_vectors = profile.trochoid(gear, parameters) - points
        first_derivative, second_derivative = profile.trochoid_derivatives(gear, parameters)
        increment = np.sum(offset_vectors * first_derivative, axis=1) / (
            np.sum(first_derivative**2, axis=1) + np.sum(offset_vectors * second_derivative, axis=1)
        )
        parameters = parameters - increment
        if np.abs(increment).max() < 1e-14:
            break
    return np.asarray(np.sum((profile.trochoid(gear, parameters) - points) * profile.normals(gear, parameters), axis=1))


def measure_all(reducer: Reducer, discs: Sequence[Sequence[Array]], ring_loop: Array) -> tuple[OutlineClearance, ...]:
    """Measure the clearances of all discs in the ring; return the smallest and largest of each mating pair.

    `discs` has the `gear_loops` of each disc, `ring_loop` is the inner outline of the housing, both as for
    `measure_disc`. Raises the errors of `measure_disc`.
    """
    return _merge_discs([measure_disc(reducer, loops, ring_loop, disc) for disc, loops in enumerate(discs)])


def measure_disc(
    reducer: Reducer, gear_loops: Sequence[Array], ring_loop: Array, disc: int = 0
) -> tuple[OutlineClearance, ...]:
    """Measure the smallest and largest clearance of teeth, bore and holes of an exported disc, and of sockets.

    Parameters
    ----------
    reducer
        The reducer with the clearances of the design.
    gear_loops
        For outline, bore and each hole of the disc n points (n, 2) [m]; holes in the order of ``output_centres``.
    ring_loop
        The n points (n, 2) [m] of the inner outline of the housing.
    disc
        Index of the disc.

    Raises
    ------
    DesignError
        A clearance deviates from that of the design.
    """
    design = reducer.design
    outline, bore, *holes = gear_loops
    hole_points = [hole - centre for hole, centre in zip(holes, output_centres(reducer), strict=True)]
    clearances_by_kind = {
        "cam": np.linalg.norm(bore, axis=1) - design.gear.bore_radius,
        "output": np.linalg.norm(np.concatenate(hole_points), axis=1) - design.output.hole_radius,
    }
    flank, *socket = _measure_ring(reducer, outline, ring_loop, disc)
    return (
        flank,
        *(_checked_clearance(reducer, kind, clearances) for kind, clearances in clearances_by_kind.items()),
        *socket,
    )


def measure_rings(reducer: Reducer, discs: Sequence[Array], ring_loop: Array) -> tuple[OutlineClearance, ...]:
    """Measure the clearances between the outlines of all discs (n, 2) [m] and the ring, and of its sockets.

    Raises the errors of `measure_disc`.
    """
    return _merge_discs([_measure_ring(reducer, outline, ring_loop, disc) for disc, outline in enumerate(discs)])


def _measure_ring(reducer: Reducer, outline: Array, ring_loop: Array, disc: int) -> tuple[OutlineClearance, ...]:
    """Measure the clearance of an exported disc in the ring, and of pins in sockets if there are any.

    `outline` and `ring_loop` are the points (n, 2) [m] of the disc's outline and of the inner outline of the housing,
    `disc` is the index of the disc. DesignError is raised if a clearance deviates from that of the design.
    """
    design = reducer.design
    tooth_pair = "pin_gear" if design.ring.kind == "pin" else "tooth"
    rotated_outline = rotate_clockwise(outline, -reducer.phases[disc] / design.lobes)
    clearances_by_kind: dict[str, Array] = {tooth_pair: _flank_clearance(reducer, rotated_outline)}
    if design.ring.has_sockets:
        clearances_by_kind["pin_socket"] = _socket_distances(reducer, ring_loop) - design.ring.pin_radius
    return tuple(_checked_clearance(reducer, kind, clearances) for kind, clearances in clearances_by_kind.items())


def _checked_clearance(reducer: Reducer, pair_kind: str, clearances: Array) -> OutlineClearance:
    """Return the smallest and largest clearance on exported outlines; raise if they are not the design's.

    `pair_kind` is the kind of pair, such as "pin_gear", `clearances` (n,) [m] are measured at n points. DesignError is
    raised if a value differs from the clearance of the design by more than `TOLERANCE`.
    """
    measured = OutlineClearance(
        pair_kind, getattr(reducer.design.clearance, pair_kind), float(clearances.min()), float(clearances.max())
    )
    if max(measured.asked - measured.least, measured.most - measured.asked) > TOLERANCE:
        raise DesignError(
            f"the clearance {pair_kind} of the exported outline is {1e6 * measured.least:.4g} to "
            f"{1e6 * measured.most:.4g} um instead of {1e6 * measured.asked:.4g} um, so the file is "
            "not written: please report this design"
        )
    return measured


def _merge_discs(clearances: Sequence[tuple[OutlineClearance, ...]]) -> tuple[OutlineClearance, ...]:
    """Return the smallest and largest clearance of each pair over all discs."""
    return tuple(
        OutlineClearance(pair[0].pair, pair[0].asked, min(item.least for item in pair), max(item.most for item in pair))
        for pair in zip(*clearances, strict=True)
    )


def _flank_clearance(reducer: Reducer, outline: Array) -> Array:
    """Compute the clearance [m] between the teeth and an ideal pin at n points `outline` (n, 2) [m] of a disc, (n,).

    The equidistant modification of the profile is subtracted, so that the design's clearance remains. With rotated
    flanks the disc is the intersection of two rotated profiles.
    """
    gear, modification = reducer.gear_profile, reducer.design.modification
    rotations = (modification.rotation, -modification.rotation) if modification.rotation else (0.0,)
    distances = [flank_distance(gear, rotate_clockwise(outline, rotation)) for rotation in rotations]
    return np.asarray(np.min(distances, axis=0) - reducer.design.ring.pin_radius - modification.equidistant)


def _socket_distances(reducer: Reducer, ring_loop: Array) -> Array:
    """Compute the distances (k,) [m] of the k points of all sockets from the nearest pin centre.

    `ring_loop` (n, 2) [m], n points, is the inner outline of the housing; points of the wall between sockets are left
    out.
    """
    from scipy.spatial import cKDTree

    ring = reducer.design.ring
    centres = ring.pin_circle_radius * profile.unit(2.0 * np.pi * np.arange(ring.teeth) / ring.teeth)
    distances, _ = cKDTree(centres).query(ring_loop)
    radii = np.linalg.norm(ring_loop, axis=1)
    return np.asarray(distances, dtype=np.float64)[radii > radii.min() * (1.0 + RELATIVE_ROUNDING)]
