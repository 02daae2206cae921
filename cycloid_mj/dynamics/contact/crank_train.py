"""Contacts that only an RV reducer has: eccentrics in their bores, and planets on the sun."""

import math
from typing import NamedTuple

from numba import njit

from cycloid_mj.base.array import Array
from cycloid_mj.dynamics.contact.gap import Pose
from cycloid_mj.dynamics.contact.memory import array_at
from cycloid_mj.reducer.rv_bodies import PlanetMesh


class Flanks(NamedTuple):
    """Gaps of both flanks of a planet on the sun, for the formulas of ``rv_bodies.PlanetMesh``.

    Attributes
    ----------
    gap, opposite
        Gap [m] of the flank that carries a counter-clockwise torque on the sun, and of the other.
    x, y
        Unit vector from sun to planet.
    cosine, sine
        Of the pressure angle; the normals from sun to planet are at it to the circle of planets.
    pitch_radius
        Distance of the pitch point from the centre of the sun [m].
    """

    gap: float
    opposite: float
    x: float
    y: float
    cosine: float
    sine: float
    pitch_radius: float


class MeshNumbers(NamedTuple):
    """A `PlanetMesh` as seen by one planet, in the format of ``geom user``."""

    sun_base: float
    planet_base: float
    involute: float
    half_backlash: float
    middle: float
    base_pitch: float
    error: float
    planet_teeth: float
    phase: float
    arm: float


def mesh_numbers(mesh: PlanetMesh, planet: int) -> MeshNumbers:
    """Return the geometry of the mesh of the sun with the planet number `planet`, as plain numbers for compiled code.

    These are base radii, backlash, base pitch, phase and number of teeth of the planet, as in `PlanetMesh`. Two fields
    differ from it: `involute` is the involute function of the nominal pressure angle, and `error` the amplitude of the
    transmission error along the line of action [m].
    """
    return MeshNumbers(
        mesh.sun_base,
        mesh.planet_base,
        math.tan(mesh.pressure_angle) - mesh.pressure_angle,
        mesh.half_backlash,
        float(mesh.middle[planet]),
        mesh.base_pitch,
        mesh.amplitude * math.cos(mesh.pressure_angle),
        float(mesh.planet_teeth),
        float(mesh.phase[planet]),
        mesh.arm,
    )


@njit(inline="always")
def read_mesh(address: int) -> MeshNumbers:
    """Read the numbers of a mesh at an address."""
    return unpack_mesh(array_at(address, 1, 10)[0])


@njit(inline="always")
def unpack_mesh(numbers: Array) -> MeshNumbers:
    """Return the numbers (10,) of a mesh by their names."""
    n = numbers
    return MeshNumbers(n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7], n[8], n[9])


@njit(inline="always")
def planet_flanks(mesh: MeshNumbers, sun: Pose, planet: Pose) -> Flanks:
    """Compute the gaps [m] between both flanks of a planet and the sun, and the data of their lines of action.

    These are the direction from sun to planet, the pressure angle and the pitch point (`Flanks`). `mesh` has the
    geometry of the gears, `sun` and `planet` are their poses in a common frame. Backlash, transmission error and the
    change of the centre distance are included.
    """
    dx, dy = planet.x - sun.x, planet.y - sun.y
    distance, direction = math.sqrt(dx * dx + dy * dy), math.atan2(dy, dx)
    base_radii_sum = mesh.sun_base + mesh.planet_base
    cosine = base_radii_sum / distance
    sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
    gap_by_distance = base_radii_sum * (sine / cosine - math.acos(min(cosine, 1.0)) - mesh.involute)
    planet_angle = math.atan2(planet.sine, planet.cosine) - direction
    flank_advance = mesh.sun_base * (math.atan2(sun.sine, sun.cosine) - direction) + mesh.planet_base * planet_angle
    flank_advance -= mesh.middle + mesh.error * math.sin(mesh.planet_teeth * planet_angle + mesh.phase)
    flank_advance -= mesh.base_pitch * round(flank_advance / mesh.base_pitch)
    gap = mesh.half_backlash + gap_by_distance
    return Flanks(
        gap - flank_advance, gap + flank_advance, dx / distance, dy / distance, cosine, sine, mesh.sun_base / cosine
    )


@njit(inline="always")
def flank_normal(flanks: Flanks, side: float) -> tuple[float, float]:
    """Return the normal from sun to planet of a flank: of that with `gap` if `side` is 1, with `opposite` if -1."""
    forward = side * flanks.cosine
    return flanks.sine * flanks.x - forward * flanks.y, flanks.sine * flanks.y + forward * flanks.x
