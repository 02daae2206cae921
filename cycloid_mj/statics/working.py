"""The force at which a pair of parts has its secant stiffness: given, or what the load of the run asks of it.

A line contact stiffens with its force; the model keeps one stiffness for a run, the secant at the working force. By
default that is what ideal sharing puts on the most loaded contact of the kind under the load torque.
"""

import math
from collections.abc import Iterable
from functools import lru_cache
from typing import Literal

import numpy as np

from cycloid_mj.design import override
from cycloid_mj.geometry import ideal_loads
from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.reducer import Reducer

STRIBECK = 4.08
"""Load of the most loaded roller of a bearing without play as a share of the mean load per roller F/Z."""

SLICES_CREEP = 0.02
"""Creep speed of slices [m/s]: stock MuJoCo lifts what slides by mu^2 v/(v0 impratio), a slow creep v0 by more."""

_ANGLES = 97
"""Crank angles in a turn over which the cam's force is averaged: a prime, so that they miss no phase of the mesh."""

Source = Literal["given", "working load", "load", "preload", "weight and inertia"]
"""Where a working force comes from: given itself, or from a torque; without a load, from the gear's own forces."""


def working_force(reducer: Reducer, kind: str) -> float:
    """Compute the force [N] at which a kind of pair has its secant stiffness; of the cam, its whole force.

    The pair's own in ``working_force``, or ``contact.working_force`` for all: then a rolling cam's most loaded roller
    bears that, and a plain cam N/4 times that, which ideal sharing asks of it when the ring's most loaded contact bears
    its working force. Where neither is given, it follows from `working_load` T by ideal sharing: 4 T/(N c (N-1)) on the
    most loaded tooth, 4 T/(n R) on the most loaded of n output pins on the radius R, and the cam's mean force over a
    turn, which holds both; of several discs, each has its share of T.
    """
    design = reducer.design
    stated: float = getattr(design.working_force, kind)
    force = design.contact.working_force
    if stated:
        return stated
    if not force:
        return _shared(reducer, kind, working_load(reducer) / design.gear.discs)
    if kind != "cam":
        return force
    rolling = design.gear.bearing == "rolling"
    return force * (design.contact.cam_rollers / STRIBECK if rolling else design.ring.teeth / 4.0)


def working_load(reducer: Reducer) -> float:
    """Compute the torque on the output [N m] that the working forces follow from.

    ``contact.working_load`` if it is given, else the size of the run's own load, but no less than `own_load`, and in a
    drive whose ring is preloaded, which presses its contacts without any load, no less than the rated torque.
    """
    design = reducer.design
    pressed = design.rated_torque if design.ring.preload else 0.0
    return design.contact.working_load or max(abs(design.load.torque), own_load(reducer), pressed)


def own_load(reducer: Reducer) -> float:
    """Compute the torque on the output [N m] that presses an idle reducer's contacts as its own forces do.

    A disc's weight and its inertia force on the eccentric, W = m (g + c w^2), act on the cam; a load torque T presses
    the teeth sideways against the cam by T/(c (N-1)): that of W has the torque W c (N-1), or W c N on a ring, for each
    disc. Its mass is that of a plain disc of its mean radius E - rho.
    """
    design = reducer.design
    gear, ring, output = design.gear, design.ring, design.output
    squares = (ring.pin_circle_radius - ring.pin_radius) ** 2 - gear.bore_radius**2
    area = math.pi * (squares - output.pins * output.hole_radius**2)
    weight = math.hypot(design.environment.gravity_x, design.environment.gravity_y)
    flung = gear.eccentricity * design.drive.speed**2
    force = design.material_of("gear").density * gear.face_width * area * (weight + flung)
    return gear.discs * force * gear.eccentricity * design.reduction


def working_source(reducer: Reducer, kind: str) -> Source:
    """Tell where the working force of a kind of pair comes from."""
    design = reducer.design
    if getattr(design.working_force, kind) or design.contact.working_force:
        return "given"
    if design.contact.working_load:
        return "working load"
    if abs(design.load.torque) >= working_load(reducer):
        return "load"
    return "preload" if design.ring.preload else "weight and inertia"


def working_at(reducer: Reducer, torque: float) -> Reducer:
    """Return a design whose contacts have the stiffness of one torque on the output [N m], whatever load a run has.

    A design that gives a working load, or one working force for all pairs, keeps it.
    """
    design = reducer.design
    if design.contact.working_load or design.contact.working_force:
        return reducer
    return Reducer(override(design, [f"contact.working_load_nm={abs(torque)!r}"]))


def at_rated_load(reducer: Reducer) -> Reducer:
    """Return `working_at` the design's own load, or the rated torque where it has none.

    For what is made for no load in particular: a folder with a model, springs for any torque, a figure.
    """
    load, rated = abs(reducer.design.load.torque), reducer.design.rated_torque
    return working_at(reducer, max(load, rated) if reducer.design.ring.preload else load or rated)


def for_slices(reducer: Reducer) -> Reducer:
    """Return `working_at` the rated torque, or the design's own load where that is larger.

    A bed of slices softens by itself where it is pressed less deep: the stiffness at a small load is not set again.
    Its creep speed, unless given, is `SLICES_CREEP`.
    """
    stiffened = working_at(reducer, max(abs(reducer.design.load.torque), reducer.design.rated_torque))
    return stiffened.but(contact={"creep_speed": reducer.design.contact.creep_speed or SLICES_CREEP})


def working_forces_text(reducer: Reducer, kinds: Iterable[str]) -> str:
    """Describe the working forces of kinds of pairs and the source of each."""
    forces = [f"{kind} {working_force(reducer, kind):.3g} N ({_source_text(reducer, kind)})" for kind in kinds]
    return ", ".join(forces)


def _source_text(reducer: Reducer, kind: str) -> str:
    source = working_source(reducer, kind)
    return {
        "given": "given",
        "working load": f"ideal sharing of {working_load(reducer):.4g} N m",
        "load": f"ideal sharing of the load, {working_load(reducer):.4g} N m",
        "preload": f"ideal sharing of the rated torque, {working_load(reducer):.4g} N m, as the ring is preloaded",
        "weight and inertia": "the gear's own weight and inertia, as there is no larger load",
    }[source]


def _shared(reducer: Reducer, kind: str, torque: float) -> float:
    design = reducer.design
    gear, output, torque = design.gear, design.output, reducer.share * torque
    if kind == "output":
        return 4.0 * torque / (output.pins * output.pin_circle_radius)
    if kind == "cam":
        return torque * _cam_share(reducer.tooth_profile, output.pins, output.pin_circle_radius)
    return 4.0 * torque / (design.ring.teeth * gear.eccentricity * design.lobes)


@lru_cache(maxsize=64)
def _cam_share(gear: CycloidGear, pins: int, radius: float) -> float:
    """Compute the mean size of the cam's force under ideal sharing, over the load torque [1/m]."""
    crank = np.linspace(0.0, 2.0 * np.pi, _ANGLES, endpoint=False)
    ring = ideal_loads.ideal_load_sharing(gear, 1.0, crank)
    output = ideal_loads.ideal_output_forces(gear, pins, radius, 1.0, crank)
    return float(np.mean(np.linalg.norm(ideal_loads.cam_force(ring, output, crank), axis=1)))
