"""The animated mechanism of a report: outlines, and one crank turn of clearances and forces of the first disc."""

from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.record import Run
from cycloid_mj.base.units import MILLIMETRES
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
    """Return the outlines of a mechanism [mm] and its motion over one crank turn, for an animation, as JSON values.

    `samples` are the samples of a run that are shown, with forces. ``usual`` is the largest of `MAGNIFICATIONS` at
    which the pins are drawn inside their holes, and ``widest`` is the widest gap [mm]. ``frames`` has the keys of
    `_frames_json`; the other keys are those of `_outlines_json`.
    """
    ring_reducer, ring_columns = (
        Reducer(view_from_ring(reducer.design)),
        view_columns_from_ring(reducer, samples.columns),
    )
    max_gap = widest_gap(ring_reducer, measure_gaps(ring_reducer, ring_columns))
    return _outlines_json(reducer) | {
        "usual": fitting_magnification(ring_reducer, max_gap, MAGNIFICATIONS),
        "widest": MILLIMETRES * max_gap,
        "frames": _frames_json(ring_reducer, ring_columns, samples.time),
    }


def _outlines_json(reducer: Reducer) -> dict[str, Any]:
    """Return the outlines of all parts of a mechanism for its animation as JSON values [mm].

    Outlines are in the frame of the reducer axis, or of the part itself. ``angles`` are the angles of the ring's pins
    or lobes [rad], clockwise from +y. ``others`` has the outline of each disc but the first, and its ``phase`` on the
    crank [rad], counter-clockwise. ``magnifications`` has for each possible magnification of the clearances its
    factor ``times`` and the radii of the parts. ``wall`` is the inner radius of the housing.
    """
    design = reducer.design
    ring, output, gear = design.ring, design.output, design.gear
    housing_hole = housing_solid(reducer, SCREEN_CHORD_ERROR).prisms[0].holes[0]
    max_magnification = largest_magnification(reducer)
    outlines = {
        "kind": ring.kind,
        "free": ring.has_sockets,
        "teeth": ring.teeth,
        "angles": np.arctan2(*ring_places(reducer).T).tolist(),
        "eccentricity": MILLIMETRES * gear.eccentricity,
        "pinCircle": MILLIMETRES * ring.pin_circle_radius,
        "pin": MILLIMETRES * ring.pin_radius,
        "bore": MILLIMETRES * (gear.bore_radius + design.clearance.cam),
        "outputPins": output.pins,
        "outputCircle": MILLIMETRES * output.pin_circle_radius,
        "hole": MILLIMETRES * (output.hole_radius + design.clearance.output),
        "shaft": MILLIMETRES * design.shaft.radius,
        "housing": MILLIMETRES * design.housing.outer_radius,
        "wall": MILLIMETRES * float(np.linalg.norm(housing_hole, axis=1).min()),
        "clearance": MILLIMETRES * tooth_clearance(reducer),
        "gear": encode_array(MILLIMETRES * gear_solid(reducer, SCREEN_CHORD_ERROR).prisms[0].outline),
        "others": [
            {
                "phase": phase,
                "gear": encode_array(MILLIMETRES * gear_solid(reducer, SCREEN_CHORD_ERROR, disc).prisms[0].outline),
            }
            for disc, phase in list(enumerate(reducer.phases))[1:]
        ],
        "magnifications": [
            {
                "times": magnification,
                **{name: MILLIMETRES * radius for name, radius in vars(drawn_radii(reducer, magnification)).items()},
            }
            for magnification in MAGNIFICATIONS
            if magnification <= max_magnification
        ],
    }
    if ring.kind != "pin":
        outline = sample_ring_by_sagitta(reducer.tooth_profile, SCREEN_CHORD_ERROR)
        outlines |= {"ring": encode_array(MILLIMETRES * outline.points), "ringNormals": encode_array(outline.normals)}
    return outlines


def _frames_json(reducer: Reducer, columns: dict[str, Array], time: Array) -> dict[str, Any]:
    """Return the motion and the forces on the first disc at n samples as JSON values, arrays of shape (n, ...).

    `columns` are the columns of a run in the frame of the ring, and `time` is in seconds, shape (n,) each. Keys of the
    result:

    - ``time``: time from the first sample [s]; ``start``: time of the first sample [s]
    - ``crank``: crank angle [rad]
    - ``deviation``: pose of the disc minus its ideal pose, x, y [mm] and angle [rad]
    - ``opening``: gap between the disc and each pin or arc of the ring, minus the clearance [mm]
    - ``outputDistance``: distance between the centres of each output pin and its hole, minus the eccentricity [mm]
    - ``force``: forces x, y [N], by the groups of contacts in `GROUPS`
    - ``away``, with ring pins only: position of each pin in its socket, x, y [mm]
    - ``pinAngle``, with ring pins only: rotation of each pin [rad]
    - ``ideal``, with ring pins only: force on each pin by ideal load sharing [N]
    """
    gap_values, forces = measure_gaps(reducer, columns), contact_forces(reducer, columns).of_disc(0)
    deviation = gap_values.deviation * [MILLIMETRES, MILLIMETRES, 1.0]
    frames = {
        "time": encode_array(time - time[0]),
        "start": float(time[0]),
        "crank": encode_array(np.mod(gap_values.crank_angle, 2 * np.pi * reducer.design.lobes)),
        "deviation": encode_array(deviation),
        "opening": encode_array(MILLIMETRES * gap_values.opening),
        "outputDistance": encode_array(MILLIMETRES * gap_values.output_away),
        "force": {kind: encode_array(forces.of(*kinds).force) for kind, kinds in GROUPS.items()},
    }
    if (ideal_force := ideal_forces(reducer, columns)) is not None:
        frames |= {
            "away": encode_array(MILLIMETRES * gap_values.away),
            "pinAngle": encode_array(np.mod(gap_values.pin_angle, 2 * np.pi)),
            "ideal": encode_array(ideal_force),
        }
    return frames


GROUPS = {"ring": ("pin_gear", "tooth"), "cam": ("cam",), "output": ("output",)}
"""Groups of forces with a common colour and scale -> kinds of mating pairs."""
