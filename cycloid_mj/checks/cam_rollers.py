"""Pressure limits of bare rollers between cam and disc, and which cams have a bought bearing instead."""

import math
from collections.abc import Iterator

from cycloid_mj.geometry import ideal_loads
from cycloid_mj.parts.cam_bearing import cam_bearing
from cycloid_mj.reducer import Reducer


def has_bare_rollers(reducer: Reducer) -> bool:
    """Return whether rollers run on the cam and in the disc's bore, without the rings of a bought bearing."""
    return reducer.design.gear.bearing == "rolling" and cam_bearing(reducer) is None


def roller_contacts(reducer: Reducer) -> Iterator[tuple[str, float]]:
    """Yield the two parts that a cam roller presses on, each with its true pressure over the pressure of the model.

    The model's contact ``cam`` has the curvature of a roller on the cam, but the modulus of shaft on disc. True
    pressures differ: roller and cam are of the same material, and in the bore of the disc the curvature is smaller.
    Hertz's pressure is proportional to sqrt(curvature x modulus).

    Yields
    ------
    tuple
        Name of the part, "shaft" or "gear", and its peak pressure over the pressure of the contact ``cam`` [1].
    """
    design, contact = reducer.design, reducer.contacts["cam"]
    shaft, roller, bore = design.material_of("shaft"), reducer.contacts.roller_radius, design.gear.bore_radius
    shaft_modulus = ideal_loads.contact_modulus(shaft.youngs_modulus, shaft.poisson)
    yield "shaft", math.sqrt(shaft_modulus / contact.modulus)
    yield "gear", math.sqrt((1.0 / roller - 1.0 / bore) / contact.relative_curvature)


def cam_pressure_limit(reducer: Reducer, factor: float, strength: str) -> float:
    """Compute the pressure [Pa] of the contact ``cam`` at which a bare roller reaches the limit of cam or bore.

    The limit of each part is `factor` times its `strength`, an attribute of its material.
    """
    limits = (
        factor * getattr(reducer.design.material_of(part), strength) / ratio for part, ratio in roller_contacts(reducer)
    )
    return min(limits)
