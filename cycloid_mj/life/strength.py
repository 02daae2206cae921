"""Fatigue of parts: roots of output pins, shoulders and cam seats of the shaft, walls of disc and ring."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.names import family
from cycloid_mj.checks.strength import Wall, list_walls
from cycloid_mj.life.fatigue import Fatigue, Stress, endurance_limit, notch_factor
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.loading import Loading, bending_moment
from cycloid_mj.life.ranges import StressRange
from cycloid_mj.life.surfaces import SOFTEST_STEEL
from cycloid_mj.parts.crank import Shoulder, shaft_dimensions
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.shoulder import (
    BENDING,
    SEATS,
    TORSION,
    has_cam_shoulders,
    root_arms,
    seat_factors,
    shoulder_factor,
)

FIBRE_ANGLES = np.linspace(0.0, math.pi, 36, endpoint=False)
"""Angles around the shaft of the fibres whose stress is computed [rad]."""

SHOULDER_STRESSES: tuple[tuple[Any, Stress], ...] = ((BENDING, "bending"), (TORSION, "torsion"))
"""Terms of the shape factor of a shoulder, and the stress that they are for."""

STUDIED = {"gear": "disc web", "ring": "ring and its ligaments"}
"""Parts whose stress range comes from a finite-element study if there is one: name in the study -> words."""

HOLED = {"gear": "gear", "housing": "ring"}
PART_OF = {studied: part for part, studied in HOLED.items()}
"""Part of a wall -> its name in that study, and the inverse."""


def rate_strength(
    reducer: Reducer, worst: Loading, ranges: dict[str, StressRange] | None = None
) -> Iterator[RatedItem]:
    """Yield safety factors against fatigue of parts, for unlimited repetition of the largest load of a duty cycle.

    Rated are the root of an output pin, the weakest shoulder or cam seat of the shaft, and the walls of disc and ring.
    `worst` has the solved forces of that load. `ranges` are stress ranges of a finite-element study by name of the
    part; they replace the estimate of that part's walls.
    """
    yield rate_output_pin(reducer, worst.output)
    yield _rate_shaft_shoulders(reducer, worst)
    torque = abs(worst.point.torque)
    ranges_by_part = {part: part_ranges for part, part_ranges in (ranges or {}).items() if family(part) in STUDIED}
    for part, stress_range in ranges_by_part.items():
        yield _rate_by_study(reducer, part, stress_range, torque)
    for wall in list_walls(reducer):
        if HOLED[wall.part] not in map(family, ranges_by_part):
            yield _rate_wall(reducer, wall, worst)


def rate_output_pin(reducer: Reducer, pin_forces: Array) -> RatedItem:
    """Rate the root of an output pin by its safety factor against fatigue, under pulsating forces of the discs.

    `pin_forces` [N] have the shape (..., discs, pins). The pin is a cantilever of the output disc, or a beam that is
    clamped at both ends; under a roller it is the core that bends.
    """
    design = reducer.design
    material, radius, fillet = design.material_of("output"), design.output.root_radius, design.output.root_fillet
    moment = float(pin_moment(reducer, pin_forces).max())
    nominal_stress = 4.0 * moment / (math.pi * radius**3)
    shape_factor = shoulder_factor(radius, fillet, math.inf, BENDING)
    pin_notch_factor = design.service.notch_factor or notch_factor(shape_factor, fillet, material.tensile_strength)
    amplitude = 0.5 * pin_notch_factor * nominal_stress
    fatigue = Fatigue(
        amplitude,
        amplitude,
        _endurance_limit(reducer, material.tensile_strength, 2.0 * radius),
        material.tensile_strength,
    )
    support_text = "a cantilever" if design.output.support == "cantilever" else "a beam clamped at both ends"
    notch_source = "of the design file" if design.service.notch_factor else f"from its fillet of {1e3 * fillet:.3g} mm"
    return RatedItem(
        "output_pin_fatigue",
        "output pin at its root, fatigue",
        1e-6 * nominal_stress,
        1e-6 * fatigue.endurance,
        "MPa",
        fatigue.safety,
        None,
        f"Goodman, pulsating bending of {support_text}, 4 M/(pi r^3)",
        f"core of {1e3 * radius:.3g} mm radius, notch factor {pin_notch_factor:.3g} {notch_source}; "
        f"{_limit_source(reducer, 'output')}",
    )


def pin_moment(reducer: Reducer, force: Array) -> Array:
    """Compute the bending moment at the root of each output pin [N m], shape (..., pins).

    `force` [N] are those of the discs on the pins, shape (..., discs, pins). Of two roots the larger moment counts.
    """
    return np.asarray(np.einsum("rd,...dp->...rp", root_arms(reducer), force).max(axis=-2))


def _rate_shaft_shoulders(reducer: Reducer, worst: Loading) -> RatedItem:
    """Rate the weakest shoulder or cam seat of the shaft by its safety factor against fatigue.

    `worst` has the solved forces of the largest load. In the frame of the shaft they vary little over a turn; this
    variation causes the stress amplitude.
    """
    design = reducer.design
    shaft, material = shaft_dimensions(reducer), design.material_of("shaft")
    directions = np.stack([np.cos(FIBRE_ANGLES), np.sin(FIBRE_ANGLES)], axis=1)
    stress_per_moment = shaft.nominal_bending
    endurance = _endurance_limit(reducer, material.tensile_strength, 2.0 * shaft.radius)
    rated_shoulders: list[tuple[float, RatedItem]] = []
    for shoulder in shaft.shoulders:
        factors, notch_text = _shoulder_factors(reducer, shoulder)
        bending_stress = factors[0] * stress_per_moment * bending_moment(worst, shoulder.z) @ directions.T
        shear_stress = factors[1] * 0.5 * stress_per_moment * worst.crank_torque
        max_stress, min_stress = bending_stress.max(axis=0), bending_stress.min(axis=0)
        amplitude = 0.5 * (max_stress - min_stress)
        mean_stress = np.hypot(0.5 * (max_stress + min_stress), math.sqrt(3.0) * shear_stress)
        critical_fibre = int(np.argmax(amplitude / endurance + mean_stress / material.tensile_strength))
        fatigue = Fatigue(
            float(amplitude[critical_fibre]), float(mean_stress[critical_fibre]), endurance, material.tensile_strength
        )
        item = RatedItem(
            "shaft_fatigue",
            f"shaft, {shoulder.name}, fatigue",
            1e-6 * float(mean_stress[critical_fibre] + amplitude[critical_fibre]),
            1e-6 * endurance,
            "MPa",
            fatigue.safety,
            None,
            "Goodman, notch factors of DIN 743-2, ripple of a load that turns with the shaft",
            f"{notch_text}, notch factors {factors[0]:.3g} in bending, {factors[1]:.3g} in torsion; "
            f"{'nominal stress of the hollow section; ' if shaft.bore_radius else ''}"
            f"{_limit_source(reducer, 'shaft')}",
        )
        rated_shoulders.append((fatigue.safety, item))
    return min(rated_shoulders, key=lambda pair: pair[0])[1]


def _shoulder_factors(reducer: Reducer, shoulder: Shoulder) -> tuple[tuple[float, float], str]:
    """Return the fatigue notch factors [1] of a shaft's shoulder in bending and torsion, and a text on the notch.

    At cams that are joined to the shaft, they are the factors of that joint. If the splines of such cams are larger
    than the journals, the larger factors of joint and shoulder count.
    """
    design, tensile = reducer.design, reducer.design.material_of("shaft").tensile_strength
    fillet, joint_factors = design.shaft.shoulder_fillet, seat_factors(design, tensile)
    if joint_factors and not has_cam_shoulders(design):
        return joint_factors, f"seat of a {SEATS[design.cam_joint].description}"
    bending, torsion = (
        notch_factor(shoulder_factor(design.shaft.radius, fillet, shoulder.outer, shape_terms), fillet, tensile, stress)
        for shape_terms, stress in SHOULDER_STRESSES
    )
    notch_text = f"fillet of {1e3 * fillet:.3g} mm"
    if joint_factors:
        largest_factors = max(bending, joint_factors[0]), max(torsion, joint_factors[1])
        return largest_factors, f"{notch_text} at splines larger than the journals"
    return (bending, torsion), notch_text


def _rate_by_study(reducer: Reducer, part: str, stress_range: StressRange, torque: float) -> RatedItem:
    """Rate a part by its safety factor against fatigue, from the stress range at the worst node of a stress study.

    `part` is the name of the part in the study; stresses are scaled from the study's load to a torque [N m].
    """
    material = reducer.design.material_of(PART_OF[family(part)])
    load_ratio = torque / stress_range.load
    endurance = _endurance_limit(reducer, material.tensile_strength, 0.0)
    fatigue = Fatigue(
        load_ratio * stress_range.amplitude, load_ratio * stress_range.mean, endurance, material.tensile_strength
    )
    scale_note = "" if math.isclose(load_ratio, 1.0, rel_tol=1e-3) else f", times {load_ratio:.3g} for this torque"
    return RatedItem(
        f"{part}_fatigue",
        f"{STUDIED[family(part)]}, fatigue",
        1e-6 * load_ratio * (stress_range.amplitude + max(stress_range.mean, 0.0)),
        1e-6 * endurance,
        "MPa",
        fatigue.safety,
        None,
        "Goodman, stress range at the worst node over a turn, by finite elements",
        f"stress study at {stress_range.load:.4g} N m{scale_note}; {_limit_source(reducer, PART_OF[family(part)])}",
    )


def _rate_wall(reducer: Reducer, wall: Wall, worst: Loading) -> RatedItem:
    """Rate the wall next to a hole by its safety factor against fatigue, as a clamped beam with a force in its middle.

    The force is the largest of a tooth or output pin in the loading `worst`. The pulsating stress is the larger of
    bending and shear (von Mises).
    """
    design = reducer.design
    material = design.material_of(wall.part)
    is_tooth_force = wall.kind == design.tooth_pair
    force = worst.teeth if is_tooth_force else float(worst.output.max())
    span = 2.0 * (design.ring.pin_radius if is_tooth_force else design.output.hole_radius)
    width = design.line_length(wall.kind)
    bending_stress = 0.75 * force * span / (width * wall.thickness**2)
    shear_stress = math.sqrt(3.0) * 0.75 * force / (width * wall.thickness)
    amplitude = 0.5 * max(bending_stress, shear_stress)
    fatigue = Fatigue(
        amplitude,
        amplitude,
        _endurance_limit(reducer, material.tensile_strength, wall.thickness),
        material.tensile_strength,
    )
    return RatedItem(
        f"{wall.name}_fatigue",
        f"wall {wall.where}, fatigue",
        2e-6 * amplitude,
        1e-6 * fatigue.endurance,
        "MPa",
        fatigue.safety,
        None,
        "Goodman, pulsating; clamped beam, 6 (F l/8)/(w t^2), or its shear, sqrt(3) 1.5 F/(2 w t)",
        f"assumed: l {1e3 * span:.3g} mm (hole), t {1e3 * wall.thickness:.3g} mm; finite elements: --stress; "
        f"{_limit_source(reducer, wall.part)}",
    )


def _endurance_limit(reducer: Reducer, tensile: float, thickness: float) -> float:
    """Return the endurance limit [Pa]: that of the design file, else by tensile strength [Pa] and thickness [m]."""
    service, bearing = reducer.design.service, reducer.design.bearing
    return service.endurance_limit or endurance_limit(tensile, thickness, service.surface, bearing.reliability)


def _limit_source(reducer: Reducer, part: str) -> str:
    """Return a phrase on the source of a part's endurance limit: the design file, or an estimate from strength."""
    design = reducer.design
    service, material = design.service, design.material_of(part)
    if service.endurance_limit:
        return "endurance limit from the design file"
    if material.youngs_modulus < SOFTEST_STEEL:
        return f"endurance limit estimated as for steel: uncertain for {material.name or 'this material'}"
    return f"endurance limit by strength, {service.surface}, size, {design.bearing.reliability:.0%} (Shigley 6-7)"
