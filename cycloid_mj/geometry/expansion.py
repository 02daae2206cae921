"""Thermal expansion: the design whose clearances are those of warm parts.

Each part expands uniformly by 1 + alpha (T - 20 °C). Angles and clearances depend on the ratios of these factors only,
so all lengths are divided by the factor of the ring: its pin circle and every nominal size stay as drawn, and the
differences appear as clearances, as a modification of the flanks and as errors of eccentricity and holes. The common
factor, about 1e-3 at 100 K of steel, is neglected. Printed parts expand differently along their axis, which changes
no clearance of the planar mechanism. Moduli and strengths are those of the temperature of each part.
"""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import Design, Material
from cycloid_mj.design.materials import warm_curve
from cycloid_mj.design.model import PARTNERS, PARTS, REFERENCE_TEMPERATURE

if TYPE_CHECKING:
    from cycloid_mj.base.array import Array

BODY_OF = {"gear": "disc", "pin": "ring", "housing": "ring", "output": "output", "shaft": "crank"}
"""Part of a material -> key of its temperature in ``[thermal]``."""


def at_temperatures(design: Design, temperatures: Mapping[str, float]) -> Design:
    """Return the design with other temperatures of its parts [°C], not expanded; they may exceed those of a file."""
    return design.model_copy(update={"thermal": design.thermal.model_copy(update=dict(temperatures))})


def strain(design: Design, part: str) -> float:
    """Compute the expansion of a part of `design.PARTS` relative to that of the ring's circle [1]."""
    return (1.0 + _expansion(design, part)) / (1.0 + _expansion(design, "housing")) - 1.0


def _expansion(design: Design, part: str) -> float:
    """Compute the thermal strain of a part relative to 20 °C [1]."""
    temperature: float = getattr(design.thermal, BODY_OF[part])
    return design.material_of(part).expansion * (temperature - REFERENCE_TEMPERATURE)


def warm_clearances(design: Design) -> dict[str, float]:
    """Compute the clearance [m] of each kind of mating pair at the temperatures of ``[thermal]``; negative if lost.

    Keys are ``pin_gear`` or ``tooth`` (teeth of the disc on the ring), ``pin_socket`` if the ring has sockets, and
    ``cam`` and ``output`` except for an RV reducer.

    Notes
    -----
    Symbols: thermal strain s of a part relative to the ring, pin radius rho, offset q of the flanks beyond rho, radius
    b of the disc's bore, radii r of the holes and p of the output pins, eccentricity c, and cold clearances c_s of the
    socket, c_c of the cam and c_o of the output.

    - teeth: q + (rho + q) s_disc - rho s_pin
    - socket: c_s - rho s_pin
    - cam: c_c + (b + c_c) s_disc - b s_shaft
    - output: c_o + (r + c_o - c) s_disc - p s_output
    """
    ring, gear, output, clearance = design.ring, design.gear, design.output, design.clearance
    pin_strain = strain(design, "pin") if ring.kind == "pin" else 0.0
    disc_strain, crank_strain, carrier_strain = (strain(design, part) for part in ("gear", "shaft", "output"))
    mesh_clearance = getattr(clearance, design.tooth_pair)
    flank_radius = ring.pin_radius + mesh_clearance + design.modification.equidistant
    clearance_by_pair = {design.tooth_pair: mesh_clearance + flank_radius * disc_strain - ring.pin_radius * pin_strain}
    if ring.has_sockets:
        clearance_by_pair["pin_socket"] = clearance.pin_socket - ring.pin_radius * pin_strain
    if design.cranks is not None:
        return clearance_by_pair
    return clearance_by_pair | {
        "cam": clearance.cam + (gear.bore_radius + clearance.cam) * disc_strain - gear.bore_radius * crank_strain,
        "output": clearance.output
        + (output.hole_radius + clearance.output - gear.eccentricity) * disc_strain
        - output.pin_radius * carrier_strain,
    }


def expand(design: Design) -> Design:
    """Return the design as it is at the temperatures of ``[thermal]``: with changed clearances and materials.

    A design at the reference temperature, 20 °C, is returned unchanged.

    Raises
    ------
    DesignError
        A clearance is lost, so that the parts jam; or the design has a measured profile, but its nominal profile is
        undercut.
    """
    if design.thermal.is_reference:
        return design
    if design.cranks is not None:
        return _expand_rv(design)
    warm_clearance = warm_clearances(design)
    tightest_pair = min(warm_clearance, key=warm_clearance.__getitem__)
    if warm_clearance[tightest_pair] <= 0.0:
        raise DesignError(_describe_jam(design, tightest_pair, warm_clearance[tightest_pair]))
    ring, gear, output = design.ring, design.gear, design.output
    disc_strain, crank_strain = strain(design, "gear"), strain(design, "shaft")
    generating_radius = (ring.pin_circle_radius + design.modification.pin_circle) * (1.0 + disc_strain)
    return design.but(
        clearance=warm_clearance,
        modification={"pin_circle": generating_radius - ring.pin_circle_radius},
        gear={"eccentricity": gear.eccentricity * (1.0 + disc_strain)},
        output={"hole_radius": output.hole_radius + gear.eccentricity * disc_strain},
        errors={
            "eccentricity": design.errors.eccentricity + gear.eccentricity * (crank_strain - disc_strain),
            **_shifted_hole_errors(design, output.pin_circle_radius * (disc_strain - strain(design, "output"))),
        },
        thermal={"applied": True},
        **{f"{part}_material": warm_material(design, part).model_dump() for part in PARTS},
    )


def _expand_rv(design: Design) -> Design:
    """Return an RV reducer as it is at the temperatures of ``[thermal]``; clearances that are lost become preloads.

    The change of the clearances of teeth and sockets becomes a modification of the flanks, which may press the discs
    against the pins. The clearance of the crank bearings changes with bores and eccentrics. The different expansion of
    discs and carrier is added to the position errors of the bores, that of discs and cranks to the radial errors of the
    eccentrics.
    """
    import numpy as np

    from cycloid_mj.geometry.profile import unit

    assert design.cranks is not None
    assert design.planet is not None
    assert design.crank_errors is not None
    ring, cranks, errors = design.ring, design.cranks, design.crank_errors
    disc_strain, crank_strain = strain(design, "gear"), strain(design, "shaft")
    eccentricity, shape = design.gear.eccentricity, (design.gear.discs, cranks.count)
    warm_clearance, cold_clearance = warm_clearances(design), design.clearance
    lost_clearance = sum(getattr(cold_clearance, pair) - clearance for pair, clearance in warm_clearance.items())
    generating_radius = (ring.pin_circle_radius + design.modification.pin_circle) * (1.0 + disc_strain)
    inner_radius = cranks.eccentric_radius + 2.0 * cranks.needle_radius
    bore_radius = inner_radius + cranks.needle_clearance
    crank_circle_radius = cranks.radius or 0.5 * design.planet.module * (
        design.planet.sun_teeth + design.planet.planet_teeth
    )
    crank_axes = crank_circle_radius * unit(2.0 * np.pi * np.arange(cranks.count) / cranks.count)
    bore_shift = np.broadcast_to((disc_strain - strain(design, "output")) * crank_axes, (*shape, 2)).reshape(-1, 2)

    def add_to_errors(errors_of_parts: tuple[float, ...], change: "Array | float") -> tuple[float, ...]:
        """Add a change [m] to a list of errors [m] of all eccentrics; an empty list counts as zeros."""
        eccentrics = shape[0] * shape[1]
        return tuple((np.array(errors_of_parts or (0.0,) * eccentrics) + change).tolist())

    return design.but(
        modification={
            "pin_circle": generating_radius - ring.pin_circle_radius,
            "equidistant": design.modification.equidistant - lost_clearance,
        },
        gear={"eccentricity": eccentricity * (1.0 + disc_strain)},
        cranks={
            "radius": crank_circle_radius,
            "needle_clearance": cranks.needle_clearance + bore_radius * disc_strain - inner_radius * crank_strain,
        },
        crank_errors={
            "eccentric_radial": add_to_errors(errors.eccentric_radial, eccentricity * (crank_strain - disc_strain)),
            "bore_x": add_to_errors(errors.bore_x, bore_shift[:, 0]),
            "bore_y": add_to_errors(errors.bore_y, bore_shift[:, 1]),
        },
        thermal={"applied": True},
        **{f"{part}_material": warm_material(design, part).model_dump() for part in PARTS},
    )


def warm_material(design: Design, part: str) -> Material:
    """Return the material of a `part`, such as "gear" (`PARTS`), with modulus and strengths at the part's temperature.

    Modulus and strengths are interpolated linearly between the temperatures of the material's table. Expansion, density
    and Poisson's ratio remain those at 20 °C, as do all values of a material without a table, such as an unnamed
    plastic.
    """
    import numpy as np

    material, temperature = design.material_of(part), getattr(design.thermal, BODY_OF[part])
    curve = warm_curve(material.name, material.youngs_modulus)
    if curve is None or temperature == REFERENCE_TEMPERATURE:
        return material
    modulus, strength = (
        float(np.interp(temperature, curve.temperatures, factors)) for factors in (curve.modulus, curve.strength)
    )
    warm_values = {"youngs_modulus": modulus * material.youngs_modulus}
    for name in ("tensile_strength", "yield_strength", "surface_yield", "endurance_pressure"):
        warm_values[name] = strength * getattr(material, name)
    return material.model_copy(update=warm_values)


def _shifted_hole_errors(design: Design, expansion: float) -> Mapping[str, tuple[float, ...]]:
    """Return the position errors [m] of all holes, disc by disc, with the holes moved outwards: "hole_x" and "hole_y".

    The result has these keys of the design's table ``errors``. `expansion` [m] is the growth of the radius of the
    circle of holes relative to the circle of output pins; if it is 0, the result is empty.
    """
    if expansion == 0.0:
        return {}
    import numpy as np

    from cycloid_mj.geometry.deviations import deviations
    from cycloid_mj.geometry.profile import unit

    angles = 2.0 * math.pi * np.arange(design.output.pins) / design.output.pins
    displacements = deviations(design).hole_displacement + expansion * unit(angles)
    return {f"hole_{axis}": tuple(displacements[..., index].ravel().tolist()) for index, axis in enumerate("xy")}


def _describe_jam(design: Design, pair: str, warm_clearance: float) -> str:
    """Return the error message for a mating pair whose parts jam because of thermal expansion.

    `pair` is a key of `PARTNERS`, such as "cam". `warm_clearance` [m] is its clearance at the temperatures of the
    parts, zero or negative.
    """
    inner_part, outer_part = (BODY_OF[part] for part in PARTNERS[pair])
    cold_clearance = getattr(design.clearance, pair)
    temperatures = f"{inner_part} at {getattr(design.thermal, inner_part):g} °C"
    if outer_part != inner_part:
        temperatures += f", {outer_part} at {getattr(design.thermal, outer_part):g} °C"
    return (
        f"the parts jam: thermal expansion reduces clearance.{pair}_um from {1e6 * cold_clearance:.4g} to "
        f"{1e6 * warm_clearance:.4g} um ({temperatures}). Increase the clearance or reduce the difference of "
        "temperatures"
    )


def jam_difference(design: Design) -> float:
    """Compute by how much a disc may be warmer than its ring until the teeth lose their clearance [K]; inf if never.

    It is play/(alpha (E - rho)). `play` is the clearance of the teeth plus that of the pins in their sockets, alpha
    [1/K] the thermal expansion of the disc, E the pin-circle radius and rho the pin radius. The flanks at the valleys
    expand towards the pins, which recede by their clearance in the sockets. Errors of the parts are not included.
    """
    ring, alpha = design.ring, design.material_of("gear").expansion
    play = getattr(design.clearance, design.tooth_pair) + design.modification.equidistant + design.pin_play
    closing_rate = alpha * (ring.pin_circle_radius - ring.pin_radius)
    return play / closing_rate if closing_rate else math.inf


def tooth_play(design: Design) -> float:
    """Compute the radial clearance [m] of disc and ring at the temperatures of ``[thermal]``; negative if they jam.

    It includes the clearance of pins in their sockets. At equal temperatures and materials it is the clearance of
    `jam_difference`.
    """
    ring, clearance = design.ring, warm_clearances(design)
    play = clearance[design.tooth_pair] + design.modification.equidistant
    play += clearance.get("pin_socket", design.pin_play)
    # warm_clearances counts the growth of the flanks' offset; the pin circle of the disc grows in addition
    return play - ring.pin_circle_radius * strain(design, "gear")
