"""The animated mechanism of a report: outlines, and one crank turn of clearances and forces of the first disc."""

from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.record import Run
from cycloid_mj.geometry.envelope import sample_ring_by_sagitta
from cycloid_mj.parts import gear_solid, housing_solid
from cycloid_mj.parts.accuracy import SCREEN_CHORD_ERROR
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.member import view_columns_from_ring, view_from_ring
from cycloid_mj.report.encode import encode_array
from cycloid_mj.scene import (
    contact_forces,
    drawn_radii,
    fitting_magnification,
    ideal_forces,
    largest_magnification,
    measure_gaps,
    widest_gap,
)
from cycloid_mj.scene.drawing import tooth_clearance
from cycloid_mj.scene.pose import ring_places

MAGNIFICATIONS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
"""Factors by which clearances can be magnified, as far as the parts leave space."""


def mechanism(reducer: Reducer, samples: Run) -> dict[str, Any]:
    """Return the outlines of the mechanism [mm] and its motion over one crank turn as JSON values.

    `samples` has the samples of a run that are shown, with forces.
    """
    ring_reducer, ring_columns = (
        Reducer(view_from_ring(reducer.design)),
        view_columns_from_ring(reducer, samples.columns),
    )
    widest = widest_gap(ring_reducer, measure_gaps(ring_reducer, ring_columns))
    return _outlines_json(reducer) | {
        "usual": fitting_magnification(ring_reducer, widest, MAGNIFICATIONS),
        "widest": 1e3 * widest,
        "frames": _frames_json(ring_reducer, ring_columns, samples.time),
    }


def _outlines_json(reducer: Reducer) -> dict[str, Any]:
    """Return radii, angles and outlines [mm] of the parts as JSON values.

    The radii are those at each magnification of clearances.
    """
    design = reducer.design
    ring, output, gear = design.ring, design.output, design.gear
    hole = housing_solid(reducer, SCREEN_CHORD_ERROR).prisms[0].holes[0]
    largest = largest_magnification(reducer)
    shape = {
        "kind": ring.kind,
        "free": ring.has_sockets,
        "teeth": ring.teeth,
        "angles": np.arctan2(*ring_places(reducer).T).tolist(),
        "eccentricity": 1e3 * gear.eccentricity,
        "pinCircle": 1e3 * ring.pin_circle_radius,
        "pin": 1e3 * ring.pin_radius,
        "bore": 1e3 * (gear.bore_radius + design.clearance.cam),
        "outputPins": output.pins,
        "outputCircle": 1e3 * output.pin_circle_radius,
        "hole": 1e3 * (output.hole_radius + design.clearance.output),
        "shaft": 1e3 * design.shaft.radius,
        "housing": 1e3 * design.housing.outer_radius,
        "wall": 1e3 * float(np.linalg.norm(hole, axis=1).min()),
        "clearance": 1e3 * tooth_clearance(reducer),
        "gear": encode_array(1e3 * gear_solid(reducer, SCREEN_CHORD_ERROR).prisms[0].outline),
        "others": [
            {
                "phase": phase,
                "gear": encode_array(1e3 * gear_solid(reducer, SCREEN_CHORD_ERROR, disc).prisms[0].outline),
            }
            for disc, phase in list(enumerate(reducer.phases))[1:]
        ],
        "magnifications": [
            {"times": times, **{name: 1e3 * radius for name, radius in vars(drawn_radii(reducer, times)).items()}}
            for times in MAGNIFICATIONS
            if times <= largest
        ],
    }
    if ring.kind != "pin":
        outline = sample_ring_by_sagitta(reducer.tooth_profile, SCREEN_CHORD_ERROR)
        shape |= {"ring": encode_array(1e3 * outline.points), "ringNormals": encode_array(outline.normals)}
    return shape


def _frames_json(reducer: Reducer, columns: dict[str, Array], time: Array) -> dict[str, Any]:
    """Return the motion [mm, rad] and the forces [N] of each sample as JSON values.

    `columns` are those of a run in the frame of the ring, shape (n,) each.
    """
    gap_values, forces = measure_gaps(reducer, columns), contact_forces(reducer, columns).of_disc(0)
    deviation = gap_values.deviation * [1e3, 1e3, 1.0]
    frames = {
        "time": encode_array(time - time[0]),
        "start": float(time[0]),
        "crank": encode_array(np.mod(gap_values.crank_angle, 2 * np.pi * reducer.design.lobes)),
        "deviation": encode_array(deviation),
        "opening": encode_array(1e3 * gap_values.opening),
        "outputAway": encode_array(1e3 * gap_values.output_away),
        "force": {kind: encode_array(forces.of(*kinds).force) for kind, kinds in GROUPS.items()},
    }
    if (ideal := ideal_forces(reducer, columns)) is not None:
        frames |= {
            "away": encode_array(1e3 * gap_values.away),
            "pinAngle": encode_array(np.mod(gap_values.pin_angle, 2 * np.pi)),
            "ideal": encode_array(ideal),
        }
    return frames


GROUPS = {"ring": ("pin_gear", "tooth"), "cam": ("cam",), "output": ("output",)}
"""Groups of forces with a common colour and scale -> kinds of mating pairs."""
