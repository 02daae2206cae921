"""Contact forces, displacements and transmission error over one crank turn, for the cross-section and the charts."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import numpy as np

from cycloid_mj.analysis.spectrum import periodic_orders
from cycloid_mj.app.rv_turn import rv_error, rv_forces, rv_orders
from cycloid_mj.base.array import Array
from cycloid_mj.base.units import ARCSECONDS, MILLIMETRES
from cycloid_mj.design.layouts import Layout
from cycloid_mj.measure.orders import output_order
from cycloid_mj.parts import output_centres
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.scene import ring_places, transform
from cycloid_mj.statics import loads, springs_of, transmission_error
from cycloid_mj.statics.sheet import load_of


@dataclass(frozen=True)
class TurnSettings:
    """Resolution of the charts over a turn."""

    crank_angles: int = 72
    """Crank angles per turn at which forces are solved."""
    angles_per_mesh: int = 12
    """Crank angles per mesh period of the transmission error over one turn."""
    spectrum_angles_per_mesh: int = 6
    """Crank angles per mesh period of the spectrum, which covers a full turn of the output."""
    max_order: float = 60.0
    """Highest order of the spectrum [cycles per crank turn]."""
    min_amplitude: float = 2e-3
    """Amplitude above which an order is drawn, relative to the largest."""


SETTINGS = TurnSettings()

CONTACTS = {"teeth": "tooth", "output": "output pin", "cam": "cam"}
RV_CONTACTS = {"teeth": "tooth", "output": "crank"}
"""Kinds of contacts of a disc, and a contact in words."""


def forces(reducer: Reducer, turn: int = 0) -> dict[str, Any]:
    """Compute the contact forces on every disc over one crank turn in static equilibrium, in the ring's frame, as JSON.

    Parameters
    ----------
    reducer
        The reducer, whose load is used.
    turn
        Number of the crank turn, from 0. The forces differ from turn to turn, because the crank does not pass the same
        number of output pins as of teeth.

    Returns
    -------
    dict
        Lists with a row for each of the crank angles, which include both ends of the turn:

        ``teeth`` and ``output`` : dict
            ``force`` [N], shape (angles, discs, contacts), ``position`` [mm] and unit ``direction`` of the contacts,
            shape (angles, discs, contacts, 2).
        ``cam``
            Force of the cam on each disc [N], shape (angles, discs, 2). An RV reducer has none, and ``output`` are its
            cranks.
        ``discs``
            Displacement of each disc from its ideal pose (x, y [mm], rotation [rad]), shape (angles, discs, 3).
        ``output_turn``
            Rotation of the output from its ideal angle [rad], shape (angles,).
        ``share``
            Share of each disc in the output torque, shape (angles, discs).
        ``turn``, ``load_nm``, ``words``
            The number of the turn, the magnitude of the torque on the output [N m], and the kinds of contacts in words.
    """
    reducer, load = _set_load(reducer)
    angles_in_ring = 2.0 * np.pi * (turn + np.arange(SETTINGS.crank_angles + 1) / SETTINGS.crank_angles)
    return TURNS[reducer.LAYOUT].forces(reducer, turn, angles_in_ring, load)


def _rv_forces(reducer: Reducer, turn: int, angles_in_ring: Array, load: float) -> dict[str, Any]:
    """Compute the result of `forces` for an RV reducer, at m crank angles against the ring [rad], shape (m,).

    `angles_in_ring` are these angles, `turn` is the number of the crank turn, and `load` the torque on the output
    [N m].
    """
    disc_count = reducer.design.gear.discs
    disc_forces = rv_forces(cast(RvReducer, reducer), angles_in_ring, load)
    contacts = {
        kind: _contact_lists(contact["force"], contact["position"], contact["direction"], disc_count)
        for kind, contact in ((kind, disc_forces[kind]) for kind in RV_CONTACTS)
    }
    other_lists = {
        "output_turn": disc_forces["output_turn"].tolist(),
        "share": np.round(disc_forces["share"], 4).tolist(),
    }
    poses = disc_forces["discs"] * [MILLIMETRES, MILLIMETRES, 1.0]
    frame = {"turn": turn, "load_nm": abs(load), "words": RV_CONTACTS}
    return {**frame, **contacts, **other_lists, "discs": np.round(poses, 7).tolist()}


def _central_forces(reducer: Reducer, turn: int, angles_in_ring: Array, load: float) -> dict[str, Any]:
    """Compute the result of `forces` for a drive with a central crank, at m crank angles against the ring [rad].

    `angles_in_ring` are these angles, `turn` is the number of the crank turn, and `load` the torque on the output [N
    m].
    """
    design = reducer.design
    crank_angles = angles_in_ring / float(reducer.member.against_ring(1.0))
    springs = springs_of(reducer, crank_angles)
    contact_loads = loads(reducer, springs, load, warm_start=True)
    slope, radius = springs.contacts.slope, springs.contacts.radius
    disc_count, lobe_count, departures = design.gear.discs, design.lobes, contact_loads.departures
    poses = departures[:, :-1].reshape(len(crank_angles), disc_count, 3) * [MILLIMETRES, MILLIMETRES, 1.0 / radius]
    # columns of x and y of the disc of each contact
    columns_of_disc = 3 * springs.contacts.disc[:, np.newaxis] + np.arange(2)
    direction = np.take_along_axis(
        slope, np.broadcast_to(columns_of_disc, (len(crank_angles), *columns_of_disc.shape)), axis=2
    )
    ring_pins, output_centres_at_0 = ring_places(reducer), output_centres(reducer)
    output_pins = np.stack(
        [transform(np.array([0.0, 0.0, -angle / lobe_count]), output_centres_at_0) for angle in angles_in_ring]
    )
    tooth_points = (
        np.tile(ring_pins, (len(crank_angles), disc_count, 1)) + design.ring.pin_radius * direction[:, : springs.teeth]
    )
    pin_points = np.tile(output_pins, (1, disc_count, 1)) + design.output.pin_radius * direction[:, springs.teeth :]
    return {
        "turn": turn,
        "load_nm": abs(load),
        "words": CONTACTS,
        "teeth": _contact_lists(contact_loads.teeth, tooth_points, direction[:, : springs.teeth], disc_count),
        "output": _contact_lists(contact_loads.output, pin_points, direction[:, springs.teeth :], disc_count),
        "cam": np.round(contact_loads.cam, 3).tolist(),
        "discs": np.round(poses, 7).tolist(),
        "output_turn": (departures[:, -1] / radius).tolist(),
        "share": np.round(contact_loads.share, 4).tolist(),
    }


def error(reducer: Reducer) -> dict[str, Any]:
    """Compute the transmission error at the load and at 1 % of it, and its orders at the load, as JSON values.

    The curves cover a crank turn relative to the ring. The orders are those of a full turn of the output, because
    output pins pass at a fractional order of the crank.

    Returns
    -------
    dict
        ``crank_deg`` [deg] and ``curves``, each with ``name``, ``arcsec`` (mean subtracted) and ``peak_to_peak``
        [arcsec]; ``orders`` [cycles per crank turn] with their ``amplitudes`` [arcsec], without those of insignificant
        amplitude; ``named``, pairs of order and name for the orders of the mesh and of the output pins.
    """
    reducer, load = _set_load(reducer)
    design = reducer.design
    crank_angles = np.linspace(0.0, reducer.mesh_turn, SETTINGS.angles_per_mesh * design.ring.teeth, endpoint=False)
    curves = []
    for name, share in (("at the load", 1.0), ("at 1 % of the load", 0.01)):
        arcsec = _output_error(reducer, crank_angles, share * load)
        curves.append({"name": name, "arcsec": np.round(arcsec, 4).tolist(), "peak_to_peak": float(np.ptp(arcsec))})
    angle_count = SETTINGS.spectrum_angles_per_mesh * design.lobes * design.ring.teeth
    full_turn = np.linspace(0.0, design.lobes * reducer.mesh_turn, angle_count, endpoint=False)
    deviation = _output_error(reducer, full_turn, load)
    spectrum = periodic_orders(full_turn, deviation, float(output_order(reducer)), SETTINGS.max_order)
    is_significant = spectrum.amplitude > SETTINGS.min_amplitude * spectrum.amplitude.max(initial=0.0)
    mesh_order = float(reducer.mesh_periods)
    named_orders = [(mesh_order, "mesh"), (2.0 * mesh_order, "2 x mesh"), *TURNS[reducer.LAYOUT].orders(reducer)]
    return {
        "crank_deg": np.round(np.degrees(crank_angles), 3).tolist(),
        "curves": curves,
        "orders": np.round(spectrum.order[is_significant], 4).tolist(),
        "amplitudes": np.round(spectrum.amplitude[is_significant], 5).tolist(),
        "named": [list(item) for item in named_orders],
    }


def _output_error(reducer: Reducer, crank: Array, load: float) -> Array:
    """Compute the transmission error of the output at crank angles [rad], mean subtracted [arcsec], shape (n,)."""
    return TURNS[reducer.LAYOUT].error(reducer, crank, load)


def _central_error(reducer: Reducer, crank: Array, load: float) -> Array:
    """Compute the result of `_output_error` for a drive with a central crank."""
    output_error = ARCSECONDS * reducer.member.sense * transmission_error(reducer, crank, load)[:, 1]
    return np.asarray(output_error - output_error.mean())


def _central_orders(reducer: Reducer) -> list[tuple[float, str]]:
    """Return order [cycles per crank turn] and name of the periodic error of the output pins."""
    design = reducer.design
    return [(round(design.output.pins * reducer.share * design.ring.teeth / design.lobes, 4), "output pins")]


class TurnOfLayout(NamedTuple):
    """Functions of a layout that compute forces, transmission error [arcsec], and named orders over a turn."""

    forces: Callable[[Reducer, int, Array, float], dict[str, Any]]
    error: Callable[[Any, Array, float], Array]
    orders: Callable[[Any], list[tuple[float, str]]]


TURNS: Mapping[Layout, TurnOfLayout] = {
    "central": TurnOfLayout(_central_forces, _central_error, _central_orders),
    "rv": TurnOfLayout(_rv_forces, rv_error, rv_orders),
}
"""Layout -> its functions for a turn."""


def _contact_lists(force: Array, position: Array, direction: Array, disc_count: int) -> dict[str, Any]:
    """Convert forces [N], positions [m] and unit directions of contacts to rounded lists by name, positions in mm.

    The keys are ``force``, ``position`` and ``direction``. `force` has shape (angles, discs * contacts), `position` and
    `direction` have (angles, discs * contacts, 2); the lists have shape (angles, discs, contacts) and (angles, discs,
    contacts, 2).
    """
    shape = (len(force), disc_count, -1)
    return {
        "force": np.round(force, 3).reshape(shape).tolist(),
        "position": np.round(MILLIMETRES * position, 4).reshape(*shape, 2).tolist(),
        "direction": np.round(direction, 5).reshape(*shape, 2).tolist(),
    }


def _set_load(reducer: Reducer) -> tuple[Reducer, float]:
    """Return a reducer under its load, and the torque [N m], positive in the direction of the crank speed."""
    design = reducer.design
    load, _ = load_of(reducer)
    sense = float(np.sign(design.drive.speed)) or 1.0
    return reducer.but(load={"torque": load}).working_at(load), sense * load
