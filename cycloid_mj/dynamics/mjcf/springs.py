"""Crank bearings and planet meshes of an RV reducer as springs of stock MuJoCo.

A crank bearing is a spatial tendon between the middles of eccentric and bore: within the clearance it is slack, beyond
it pulls towards the middle. Under a preload both sides carry, and it is twice as stiff. A planet mesh is a fixed tendon
whose length is the advance of the sun along the line of action, slack within the backlash. Neither has friction. Their
forces are explicit in the time step, which has to follow their oscillation.
"""

from collections.abc import Mapping
from typing import Any

from cycloid_mj.base import names
from cycloid_mj.base.array import significant
from cycloid_mj.base.errors import ContactError
from cycloid_mj.dynamics.law import ContactParameters
from cycloid_mj.dynamics.mjcf.bodies import mujoco_position
from cycloid_mj.dynamics.regime import stiffness_ratio
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.rv_bodies import SUN_ANGLE, crank_joint, crank_names

MAX_STIFFNESS_RATIO = 2.0
"""Largest K dt^2/m of a spring: the explicit step diverges at 4 (Hairer and others, Geometric Numerical Integration,
I.1.4), and the damping, explicit too, takes a part of this."""


def add_springs(spec: Any, reducer: RvReducer, laws: Mapping[str, ContactParameters]) -> None:
    """Add springs for all crank bearings and planet meshes of an RV reducer to the editable MuJoCo model `spec`.

    `laws` are the contact laws by kind of pair. Springs are slack within the clearance or backlash; a preloaded
    bearing, whose needles carry on both sides, is twice as stiff.

    Raises
    ------
    ContactError
        The time step is too long for their stiffness.
    """
    for kind in (names.CRANK_BEARING, names.PLANET_MESH):
        ratio = stiffness_ratio(laws[kind], spec.option.timestep)
        if ratio > MAX_STIFFNESS_RATIO:
            max_step = spec.option.timestep * (MAX_STIFFNESS_RATIO / ratio) ** 0.5
            raise ContactError(
                f"{kind}: with MuJoCo's own springs ({laws[kind].stiffness:.3g} N/m), the simulation diverges at a "
                f"time step of {1e6 * spec.option.timestep:g} us: reduce settings.timestep_us to {1e6 * max_step:.3g} "
                "or less, or increase drive.rotor_inertia_kg_m2"
            )
    for disc, plane in enumerate(reducer.design.gear.disc_planes):
        mating = reducer.mechanism.mating(names.CRANK_BEARING, disc)
        for i, name in enumerate(mating.names):
            for surfaces in (mating.on, mating.by):
                position = mujoco_position(
                    surfaces.position[i], plane - reducer.mechanism.body(surfaces.bodies[i]).plane
                )
                spec.body(surfaces.bodies[i]).add_site(name=surfaces.names[i], pos=position, group=4)
            clearance, law = reducer.bearing_clearance, laws[names.CRANK_BEARING]
            tendon = _add_spring(spec, name, law, 0.0, clearance, 1.0 if clearance >= 0.0 else 2.0)
            tendon.wrap_site(mating.on.names[i])
            tendon.wrap_site(mating.by.names[i])
    planet_mesh = reducer.planet_mesh
    for crank, name in zip(crank_names(reducer), reducer.mechanism.mating(names.PLANET_MESH).names, strict=True):
        tendon = _add_spring(spec, name, laws[names.PLANET_MESH], -planet_mesh.half_backlash, planet_mesh.half_backlash)
        tendon.wrap_joint(SUN_ANGLE, significant(planet_mesh.sun_base))
        tendon.wrap_joint(crank_joint(crank), significant(planet_mesh.planet_base))
        if not reducer.design.output.turns_ring:
            tendon.wrap_joint(names.OUTPUT_JOINT, -significant(planet_mesh.sun_base))


def _add_spring(
    spec: Any, name: str, law: ContactParameters, min_length: float, max_length: float, spring_count: float = 1.0
) -> Any:
    """Add a tendon that is slack between two lengths [m], with `spring_count` springs of a law; return it."""
    tendon = spec.add_tendon(name=name, group=4)
    tendon.stiffness = [significant(spring_count * law.stiffness), 0.0, 0.0]
    tendon.damping = [significant(spring_count * law.damping), 0.0, 0.0]
    tendon.springlength = [min_length, max(min_length, max_length)]
    return tendon
