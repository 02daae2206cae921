"""What moves how heavily: the masses of the bodies of a simulation, and the inertia of what the load is on."""

from dataclasses import replace

import numpy as np

from cycloid_mj.base.digits import significant, significant_tensor
from cycloid_mj.parts.inertia import MassProperties, mass_properties
from cycloid_mj.parts.parts import body_solids
from cycloid_mj.reducer import Reducer


def moving_masses(reducer: Reducer) -> dict[str, MassProperties]:
    """Map part to its mass properties; a ring that turns has those of its pins too, where they are no bodies.

    Raises
    ------
    DesignError
        A part cannot be made.
    """
    design = reducer.design
    masses = {name: mass_properties(solid) for name, solid in body_solids(reducer).items()}
    if design.output.turns_ring and design.ring.kind == "pin" and not design.ring.has_pin_bodies:
        masses["housing"] = _with_pins(masses["housing"], masses["pin"], reducer)
    return masses


def output_inertia(reducer: Reducer) -> float:
    """Compute the inertia of what the load is on about the reducer's axis [kg m2]: of the carrier, or of the ring."""
    return float(moving_masses(reducer)["housing" if reducer.design.output.turns_ring else "output"].inertia[2, 2])


def _with_pins(housing: MassProperties, pin: MassProperties, reducer: Reducer) -> MassProperties:
    """Add all pins, which stand evenly around the axis: each adds its own inertia, and its mass on the pin circle."""
    count, orbit = reducer.design.ring.teeth, pin.mass * reducer.design.ring.pin_circle_radius**2
    around = np.diag([0.5 * orbit, 0.5 * orbit, orbit])
    return replace(
        housing,
        mass=significant(housing.mass + count * pin.mass),
        volume=significant(housing.volume + count * pin.volume),
        inertia=significant_tensor(housing.inertia + count * (pin.inertia + around)),
    )
