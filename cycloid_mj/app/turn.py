"""Forces and motions of a reducer over one turn of its crank, as the section and the charts show them."""

from typing import Any

import numpy as np

from cycloid_mj.analysis.spectrum import periodic_orders
from cycloid_mj.base.array import Array
from cycloid_mj.base.units import ARCSECONDS, MILLIMETRES
from cycloid_mj.parts import output_centres
from cycloid_mj.reducer import Reducer
from cycloid_mj.scene import moved, ring_places
from cycloid_mj.statics import loads, springs_of, transmission_error
from cycloid_mj.statics.sheet import load_of

POSES = 72
"""Crank angles in a turn at which forces are solved."""

PER_PERIOD = 12
"""Crank angles in a mesh period at which the transmission error is solved."""

MOST_ORDER = 60.0
"""Cycles in a turn of the crank."""

FEWER = 6
"""Crank angles in a mesh period for the orders, which take all turns of the crank in one of the output."""

DRAWN = 2e-3
"""Share of the strongest order from which on an order is drawn."""


def forces(reducer: Reducer, turn: int = 0) -> dict[str, Any]:
    """Compute the forces on every disc over one turn of the crank, the first or a later one, seen from the ring.

    Each contact has a place [mm], a direction and a force [N] at each angle; of each disc and of the output there are
    the departures from their ideal places, by which plays are drawn: x, y [mm] and turn [rad].
    """
    reducer, load = _loaded(reducer)
    design = reducer.design
    shown = 2.0 * np.pi * (turn + np.arange(POSES + 1) / POSES)
    crank = shown / float(reducer.member.against_ring(1.0))
    springs = springs_of(reducer, crank)
    solved = loads(reducer, springs, load, follow=True)
    slope, radius = springs.contacts.slope, springs.contacts.radius
    discs, lobes, departures = design.gear.discs, design.lobes, solved.departures
    poses = departures[:, :-1].reshape(len(crank), discs, 3) * [MILLIMETRES, MILLIMETRES, 1.0 / radius]
    of_disc = 3 * springs.contacts.disc[:, np.newaxis] + np.arange(2)  # where the disc of each contact has its x and y
    way = np.take_along_axis(slope, np.broadcast_to(of_disc, (len(crank), *of_disc.shape)), axis=2)
    rings, pins = ring_places(reducer), output_centres(reducer)
    turned = np.stack([moved(np.array([0.0, 0.0, -angle / lobes]), pins) for angle in shown])
    teeth = np.tile(rings, (len(crank), discs, 1)) + design.ring.pin_radius * way[:, : springs.teeth]
    output = np.tile(turned, (1, discs, 1)) + design.output.pin_radius * way[:, springs.teeth :]
    return {
        "turn": turn,
        "load_nm": abs(load),
        "teeth": _acting(solved.teeth, teeth, way[:, : springs.teeth], discs),
        "output": _acting(solved.output, output, way[:, springs.teeth :], discs),
        "cam": np.round(solved.cam, 3).tolist(),
        "discs": np.round(poses, 7).tolist(),
        "output_turn": (departures[:, -1] / radius).tolist(),
        "share": np.round(solved.share, 4).tolist(),
    }


def error(reducer: Reducer) -> dict[str, Any]:
    """Compute the transmission error over a turn, at the load and without it, and its orders at the load, by statics.

    Output pins pass at no whole order, so that nothing repeats before the output has turned once.
    """
    reducer, load = _loaded(reducer)
    design = reducer.design
    crank = np.linspace(0.0, reducer.mesh_turn, PER_PERIOD * design.ring.teeth, endpoint=False)
    curves = []
    for name, share in (("at the load", 1.0), ("at 1 % of it", 0.01)):
        angle = _output_error(reducer, crank, share * load)
        curves.append({"name": name, "arcsec": np.round(angle, 4).tolist(), "peak_to_peak": float(np.ptp(angle))})
    whole = np.linspace(0.0, design.lobes * reducer.mesh_turn, FEWER * design.lobes * design.ring.teeth, endpoint=False)
    found = periodic_orders(whole, _output_error(reducer, whole, load), reducer.share / design.lobes, MOST_ORDER)
    drawn = found.amplitude > DRAWN * found.amplitude.max(initial=0.0)
    mesh = float(reducer.mesh_periods)
    pins = design.output.pins * reducer.share * design.ring.teeth / design.lobes
    return {
        "crank_deg": np.round(np.degrees(crank), 3).tolist(),
        "curves": curves,
        "orders": np.round(found.order[drawn], 4).tolist(),
        "amplitudes": np.round(found.amplitude[drawn], 5).tolist(),
        "named": [[mesh, "mesh"], [2.0 * mesh, "2 x mesh"], [round(pins, 4), "output pins"]],
    }


def _output_error(reducer: Reducer, crank: Array, load: float) -> Array:
    """Compute the transmission error of the output about its mean [arcsec], shape (n,)."""
    angle = ARCSECONDS * reducer.member.sense * transmission_error(reducer, crank, load)[:, 1]
    return np.asarray(angle - angle.mean())


def _acting(force: Array, place: Array, way: Array, discs: int) -> dict[str, Any]:
    """Round forces [N], places [mm] and directions, shape (poses, discs, contacts, ...)."""
    shape = (len(force), discs, -1)
    return {
        "force": np.round(force, 3).reshape(shape).tolist(),
        "place": np.round(MILLIMETRES * place, 4).reshape(*shape, 2).tolist(),
        "way": np.round(way, 5).reshape(*shape, 2).tolist(),
    }


def _loaded(reducer: Reducer) -> tuple[Reducer, float]:
    design = reducer.design
    load, _ = load_of(reducer)
    way = float(np.sign(design.drive.speed)) or 1.0
    return reducer.but(load={"torque": load}).working_at(load), way * load
