"""Stress of cranks, sun and planets of an RV reducer in closed form: beam theory with notch factors, and ISO 6336-3."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array, cross, quarter_turned
from cycloid_mj.base.names import CRANK, PLANET, SUN
from cycloid_mj.base.units import MEGAPASCAL
from cycloid_mj.geometry.tooth_root import tooth_root
from cycloid_mj.parts.rv import axial_layout
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics.rv import RvLoads, RvSprings
from cycloid_mj.statics.shoulder import BENDING, TORSION, shoulder_factor
from cycloid_mj.stress.contacts import needle_contact
from cycloid_mj.stress.notch import Notch
from cycloid_mj.stress.static_turn import solve_over_turn


@dataclass(frozen=True)
class ToothRootStress:
    """Nominal stress at the root of a gear tooth by ISO 6336-3.

    Attributes
    ----------
    part
        "sun" or "planet".
    force
        Largest tangential force at the reference circle [N].
    nominal
        F_t/(b m) [Pa].
    form_factor, correction_factor
        Y_F and Y_S.
    """

    part: str
    force: float
    nominal: float
    form_factor: float
    correction_factor: float

    @property
    def stress(self) -> float:
        """F_t/(b m) Y_F Y_S [Pa]."""
        return self.nominal * self.form_factor * self.correction_factor

    def as_json(self, yield_strength: float) -> dict[str, Any]:
        """Convert the stress at a tooth root to JSON values; keys end in their units.

        ``safety_against_yield`` [1] is `yield_strength` [Pa] over the stress; None without stress.
        """
        return {
            "part": self.part,
            "force_n": self.force,
            "form_factor": self.form_factor,
            "correction_factor": self.correction_factor,
            "stress_mpa": self.stress / MEGAPASCAL,
            "safety_against_yield": yield_strength / self.stress if self.stress else None,
        }


@dataclass(frozen=True)
class RvStrength:
    """Stress of cranks and gears over a turn.

    Attributes
    ----------
    shoulders
        Sections of the most loaded crank at the ends of its eccentrics, from the planet on.
    needle_pressure
        Largest Hertz pressure of a needle on an eccentric [Pa].
    roots
        Stress at the roots of the teeth of sun and planet.
    yield_strength
        Yield strength of cranks and gears, which have the material of the shaft [Pa].
    """

    shoulders: tuple[Notch, ...]
    needle_pressure: float
    roots: tuple[ToothRootStress, ...]
    yield_strength: float

    @property
    def largest(self) -> dict[str, float]:
        """Largest stress by part: crank, sun and planet [Pa]."""
        crank_stress = max(notch.stress for notch in self.shoulders)
        return {CRANK: crank_stress} | {notch.part: notch.stress for notch in self.roots}

    def as_json(self) -> dict[str, Any]:
        """Convert the stresses to JSON values: ``crank`` (sections), ``needle_pressure_mpa`` and ``tooth_roots``."""
        return {
            "crank": [item.as_json(self.yield_strength) for item in self.shoulders],
            "needle_pressure_mpa": self.needle_pressure / MEGAPASCAL,
            "tooth_roots": [item.as_json(self.yield_strength) for item in self.roots],
        }


def compute_rv_strength(reducer: RvReducer, angles: Array) -> RvStrength:
    """Compute the largest stresses of the cranks and of sun and planets over a turn, under the load of the design.

    `angles` [rad], shape (k,), are k angles of the cranks relative to the carrier.

    Raises
    ------
    RunError
        No static equilibrium exists.
    """
    springs, loads = solve_over_turn(reducer, angles)
    needles = needle_contact(reducer, loads.bearings, 1.0 / reducer.cranks.eccentric_radius)
    return RvStrength(
        shoulders=tuple(_crank_shoulders(reducer, springs, loads, np.ravel(angles))),
        needle_pressure=float(needles.pressure.max()),
        roots=tuple(_tooth_roots(reducer, float(loads.flanks.max()))),
        yield_strength=reducer.design.material_of("shaft").yield_strength,
    )


def _crank_shoulders(reducer: RvReducer, springs: RvSprings, loads: RvLoads, angles: Array) -> Iterator[Notch]:
    """Yield the largest stress over all cranks and angles at each end of each eccentric, in the order of z.

    `angles` (k,) [rad] are the k crank angles of the contact `springs` and their `loads`.
    """
    gear, radius, fillet = reducer.design.gear, reducer.journal_radius, reducer.journal_fillet
    outer_radius = reducer.cranks.eccentric_radius + gear.eccentricity
    factors = [shoulder_factor(radius, fillet, outer_radius, terms) for terms in (BENDING, TORSION)]
    stations = np.sort([plane + sign * gear.face_width / 2.0 for plane in gear.disc_planes for sign in (-1.0, 1.0)])
    bending, torsion = crank_moments(reducer, springs, loads, stations)
    for station_index, station in enumerate(stations):
        stresses = 4.0 * bending[..., station_index], 2.0 * torsion[..., station_index]
        equivalent_stress = np.hypot(factors[0] * stresses[0], math.sqrt(3.0) * factors[1] * stresses[1])
        angle_index, crank_index = np.unravel_index(int(np.argmax(equivalent_stress)), equivalent_stress.shape)
        nominal_stresses = (
            float(component[angle_index, crank_index]) / (math.pi * radius**3) for component in stresses
        )
        name = f"crank {crank_index + 1} at z = {1e3 * station:.1f} mm"
        yield Notch(name, radius, fillet, float(angles[angle_index]), *nominal_stresses, *factors)


def crank_moments(reducer: RvReducer, springs: RvSprings, loads: RvLoads, stations: Array) -> tuple[Array, Array]:
    """Compute the magnitudes of bending and torsional moments [N m] in n cranks at k angles, shape (k, n, s) each.

    Contact `springs` and `loads` are the static equilibrium at the k angles, `stations` are s positions along z (s,)
    [m]. A crank is a beam on two supports (`RvReducer.crank_support`). Its torque acts at the planet, and decreases
    along each eccentric.
    """
    gear, layout = reducer.design.gear, axial_layout(reducer)
    planes = np.array(gear.disc_planes)
    first_support = layout.flanges[0][1] - reducer.crank_support
    second_support = layout.flanges[1][0] + reducer.crank_support
    on_discs = -np.moveaxis(loads.cranks, 1, 2)
    on_planets = planet_forces(reducer, springs, loads)[:, :, np.newaxis]
    forces, force_positions = np.concatenate([on_planets, on_discs], axis=2), np.append(layout.planet_middle, planes)
    widths = np.append(reducer.planet.face_width, np.full(planes.size, gear.face_width))
    far_support = np.einsum("kncj,c->knj", forces, (force_positions - first_support) / (first_support - second_support))
    near_support = -forces.sum(axis=2) - far_support
    loaded_widths = np.clip(stations[:, np.newaxis] - force_positions + widths / 2.0, 0.0, widths)
    arms = loaded_widths / widths * (stations[:, np.newaxis] - force_positions + (widths - loaded_widths) / 2.0)
    bending = np.einsum("kncj,sc->knsj", forces, arms)
    for support, support_position in ((near_support, first_support), (far_support, second_support)):
        bending += support[:, :, np.newaxis] * np.maximum(stations - support_position, 0.0)[:, np.newaxis]
    eccentrics = gear.eccentricity * reducer.stage.eccentrics(springs.crank)[:, np.newaxis]
    torques = cross(eccentrics, on_discs)
    torsion = np.einsum("knc,sc->kns", torques, 1.0 - loaded_widths[:, 1:] / widths[1:])
    return np.linalg.norm(bending, axis=-1), np.abs(torsion)


def planet_forces(reducer: RvReducer, springs: RvSprings, loads: RvLoads) -> Array:
    """Return the forces of the sun on the n planets, normal to the flanks [N], shape (k, n, 2), frame of the ring."""
    outward = reducer.stage.crank_positions(springs.crank) / reducer.lever
    forward, angle = quarter_turned(outward), reducer.planet.pressure_angle
    signed = loads.flanks[:, 1] - loads.flanks[:, 0]
    along = math.cos(angle) * signed[..., np.newaxis] * forward
    return np.asarray(along + math.sin(angle) * loads.meshes[..., np.newaxis] * outward)


def _tooth_roots(reducer: RvReducer, force: float) -> Iterator[ToothRootStress]:
    """Yield nominal bending stress [Pa] and its factors by ISO 6336-3 at the tooth root of the sun, then of a planet.

    The factors are those of tooth form and stress correction. A single pair of teeth carries the normal `force` [N].
    """
    planet, gears = reducer.planet, reducer.stage_gears
    tangential_force = force * math.cos(planet.pressure_angle)
    for part, gear, mating_gear in zip((SUN, PLANET), gears, reversed(gears), strict=True):
        section = tooth_root(gear, mating_gear, reducer.crank_radius)
        nominal_stress = tangential_force / (planet.face_width * planet.module)
        yield ToothRootStress(part, tangential_force, nominal_stress, section.form_factor, section.correction_factor)
