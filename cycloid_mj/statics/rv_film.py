"""Friction of an RV reducer with the law ``film``: teeth on pins, crank bearings, planet meshes, main bearings, seals.

A disc runs on the pins as on a central crank, so `FilmContacts` applies to the teeth. The flanks of sun and planets are
line contacts whose radii and speeds change along the path of contact. Rolling bearings have Palmgren's friction torques
M1, in proportion to the force of a disc on its crank, and M0, which does not depend on the load.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.base.names import PLANET_MESH
from cycloid_mj.geometry.ideal_loads import contact_modulus
from cycloid_mj.geometry.involute import ContactPath, contact_path
from cycloid_mj.geometry.surface_speeds import SurfaceSpeeds, involute_speeds
from cycloid_mj.lubrication.mixed import MixedFriction, line_friction
from cycloid_mj.reducer import RvReducer, once
from cycloid_mj.reducer.gaps import ideal_motion, mesh_gaps
from cycloid_mj.statics.film import (
    ASSUMED,
    DESIGN_INPUTS,
    FilmContacts,
    FilmInputs,
    FilmSurfaces,
    build_film_contacts,
    drag_power,
    film_law,
    idle_power,
    roller_bearings,
)
from cycloid_mj.statics.rv import (
    RunningFriction,
    RvCoefficients,
    RvFriction,
    RvLoads,
    RvSprings,
    compute_rv_friction,
)


@once
def planet_path(reducer: RvReducer) -> ContactPath:
    """Return the path of contact of sun and planet, with the teeth as they are drawn."""
    return contact_path(reducer.stage_gears, reducer.crank_radius)


def planet_speeds(reducer: RvReducer) -> SurfaceSpeeds:
    """Return the surface speeds of sun (``fixed``) and planet (``moving``) at the nodes of their path [m/s], (k,)."""
    path, planet = planet_path(reducer), reducer.planet
    sun_speed = reducer.crank_speed * planet.planet_teeth / planet.sun_teeth
    return involute_speeds(path.tangents, path.distance, (sun_speed, reducer.crank_speed))


def planet_friction(reducer: RvReducer, force: Array, inputs: FilmInputs = DESIGN_INPUTS) -> Array:
    """Compute the mean friction coefficients of planet meshes [1] under their forces [N], in the shape of `force`.

    The mean over the path of contact is weighted by the friction power, which is load share times sliding speed.
    `inputs` are factors on the inputs of the friction law ``film``, such as the viscosity.
    """
    path, speeds, material = planet_path(reducer), planet_speeds(reducer), reducer.design.material
    friction = line_friction(
        film_law(reducer, PLANET_MESH, inputs),
        np.asarray(force)[..., np.newaxis] * path.load_share,
        speeds.entrainment,
        speeds.sliding,
        path.radius,
        reducer.planet.face_width,
        contact_modulus(material.youngs_modulus, material.poisson),
    )
    return np.asarray(np.average(friction.coefficient, axis=-1, weights=_sliding_weights(path)))


def _sliding_weights(path: ContactPath) -> Array:
    """Return the share of each node of a path in the friction power at a constant coefficient, up to a factor."""
    return path.weight * path.load_share * np.abs(path.distance)


@dataclass(frozen=True, eq=False)
class RvFilm:
    """Friction of the running drive with the law ``film``, at m crank angles.

    Attributes
    ----------
    reducer
        The reducer.
    contacts
        Contacts with the ring.
    unit
        Generalised friction at coefficients of 1 of teeth and planets, and with the torques M1 of the bearings.
    factor
        Factor on all friction.
    """

    reducer: RvReducer
    contacts: FilmContacts
    unit: RvFriction
    factor: float = 1.0

    def surfaces(self, loads: RvLoads) -> FilmSurfaces:
        """Return the surfaces of the teeth with discs and pins displaced as in a solution."""
        departures = loads.displacements[:, : 3 * len(self.reducer.phases) + 1]
        return self.contacts.displaced(departures).surfaces

    def tooth_friction(self, loads: RvLoads) -> MixedFriction:
        """Return the friction of the teeth under the forces of a solution, shape (m, pins)."""
        return self.surfaces(loads).smaller_friction(loads.pins)[0]

    def load(self, loads: RvLoads) -> Array:
        """Return the generalised forces of friction under the forces of a solution [N], shape (m, u)."""
        tooth_coefficient = self.tooth_friction(loads).coefficient
        planets = planet_friction(self.reducer, loads.meshes, self.contacts.surfaces.inputs)
        return self.factor * self.unit.generalised(
            tooth_coefficient * loads.pins, loads.bearings, planets * loads.meshes
        )

    def on_discs(self, loads: RvLoads) -> tuple[Array, Array]:
        """Return the generalised friction per force of pins (m, pins, u) and of crank bearings (D, n, u) [1]."""
        unit_friction = self.tooth_friction(loads).coefficient[..., np.newaxis] * self.unit.teeth
        return self.factor * unit_friction, self.factor * self.unit.bearings


def bearing_friction(reducer: RvReducer) -> tuple[float, float]:
    """Return Palmgren's friction torques M1 over the force of a disc on its crank [m], of needles and tapers."""
    needles, tapers, _ = roller_bearings(reducer)
    return ASSUMED.roller_load_factor * needles.diameter, ASSUMED.roller_load_factor * tapers.diameter


def build_rv_film(reducer: RvReducer, crank: npt.ArrayLike, sense: float) -> RvFilm:
    """Return the friction model of an RV reducer with the law ``film`` at m crank angles against the ring [rad], (m,).

    Its method `load` computes the friction forces from the contact forces of an equilibrium. The cranks turn
    counter-clockwise against the ring if `sense` is 1, and clockwise if it is -1.
    """
    crank, reducer = np.ravel(np.asarray(crank, dtype=np.float64)), reducer.at_rated_load
    gaps = mesh_gaps(reducer, crank)
    contacts = build_film_contacts(reducer, crank, gaps, gaps.kind.size, sense * ideal_motion(reducer, crank))
    unit_coefficients = RvCoefficients(1.0, 1.0, *bearing_friction(reducer))
    return RvFilm(reducer, contacts, compute_rv_friction(reducer, crank, sense, unit_coefficients))


def running_friction(reducer: RvReducer, crank: npt.ArrayLike, sense: float) -> RunningFriction:
    """Return the friction by the law of the design at crank angles against the ring [rad], shape (m,).

    The cranks turn counter-clockwise against the ring if `sense` is 1, and clockwise if it is -1.
    """
    return (build_rv_film if reducer.design.has_film else compute_rv_friction)(reducer, crank, sense)


@dataclass(frozen=True, eq=False)
class RvFilmLosses:
    """Losses of an RV reducer with the law ``film`` under known forces, for any inputs of the law.

    Attributes
    ----------
    reducer
        The reducer.
    surfaces, teeth
        Surfaces of the k loaded contacts with the ring at all crank angles, and their forces [N], shape (k,).
    tooth_power
        Friction power of each of these contacts at a coefficient of 1, divided by the number of crank angles [W], shape
        (k,): its sum is the mean over the crank angles.
    planets
        Forces of the planet meshes [N], shape (m, n).
    bearing_force
        Sum of the forces of all cranks on all discs, mean over the crank angles [N].
    """

    reducer: RvReducer
    surfaces: FilmSurfaces
    teeth: Array
    tooth_power: Array
    planets: Array
    bearing_force: float

    def contact_powers(self, inputs: FilmInputs = DESIGN_INPUTS) -> dict[str, float]:
        """Compute the mean powers lost to load-dependent friction [W], by its source.

        The keys are "teeth", "crank bearings" and "planets". `inputs` are factors on the inputs of the film law, such
        as the viscosity.
        """
        reducer = self.reducer
        tooth_coefficients = replace(self.surfaces, inputs=inputs).smaller_friction(self.teeth)[0].coefficient
        planet_force = np.sum(planet_friction(reducer, self.planets, inputs) * self.planets, axis=1).mean()
        return {
            "teeth": float(np.sum(tooth_coefficients * self.tooth_power)),
            "crank bearings": inputs.load_friction
            * sum(bearing_friction(reducer))
            * self.bearing_force
            * reducer.crank_speed,
            "planets": float(planet_force * reducer.planet_mesh.arm * reducer.planet_mesh_speed),
        }

    def drag_powers(self, inputs: FilmInputs = DESIGN_INPUTS) -> dict[str, float]:
        """Compute the powers [W] without load, lost by "crank bearings" and "seals"; main bearings count as seals."""
        reducer = self.reducer
        crank_bearing_drag = sum(idle_power(reducer, bearings, inputs) for bearings in roller_bearings(reducer)[:2])
        return {"crank bearings": crank_bearing_drag, "seals": drag_power(reducer, inputs) - crank_bearing_drag}

    def powers(self, inputs: FilmInputs = DESIGN_INPUTS) -> dict[str, float]:
        """Compute all mean powers lost [W] by source: "teeth", "crank bearings", "planets" and "seals"."""
        contact, drag = self.contact_powers(inputs), self.drag_powers(inputs)
        return {source: contact.get(source, 0.0) + drag.get(source, 0.0) for source in (*contact, "seals")}


def build_rv_losses(film: RvFilm, springs: RvSprings, loads: RvLoads) -> RvFilmLosses:
    """Return the friction losses of an RV reducer with the law ``film`` under forces `loads`, at design speed.

    `springs` are the contact springs. The result computes the lost powers for any inputs of the law, such as another
    viscosity.
    """
    reducer, is_loaded = film.reducer, loads.pins > 0.0
    unit_power = loads.pins * np.abs(springs.slip) * abs(reducer.speed_against_ring) / len(springs.crank)
    return RvFilmLosses(
        reducer=reducer,
        surfaces=film.surfaces(loads).select(is_loaded),
        teeth=loads.pins[is_loaded],
        tooth_power=unit_power[is_loaded],
        planets=loads.meshes,
        bearing_force=float(loads.bearings.sum(axis=(1, 2)).mean()),
    )


def rv_film_assumption(reducer: RvReducer) -> str:
    """Return a sentence on the mixed friction of a running RV reducer: lubricant, film formula and roughness."""
    friction = reducer.design.friction
    return (
        f"mixed friction of a running drive with {friction.lubricant}: film thickness by {friction.film_formula}, "
        f"roughness Rq {1e6 * friction.roughness:g} um, boundary friction {friction.boundary:g}; all rolling bearings "
        f"by Palmgren (f0 {ASSUMED.roller_idle_factor:g}, f1 {ASSUMED.roller_load_factor:g}), a seal on the carrier; "
        "none in figures without friction by name, backlash, lost motion and stiffness"
    )
