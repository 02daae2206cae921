"""What a reducer's parts carry over a turn at one point of its duty: statics with friction and the gear's inertia."""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.design import Design
from cycloid_mj.loaded import loads, peak_pressure, powers, springs_of
from cycloid_mj.loaded.springs import turn_evenly
from cycloid_mj.rating.duty import DutyPoint
from cycloid_mj.rating.rolling import magnitudes
from cycloid_mj.solid import mass_properties, parts
from cycloid_mj.stress.shaftgrid import Shaft, shaft_measures
from cycloid_mj.types import Array

POSES = 181
"""Crank angles of a loading."""


@dataclass(frozen=True, eq=False)
class Loading:
    """Loads at m crank angles that cover N - 1 turns of the crank evenly: one of the output, after which all repeats.

    Attributes
    ----------
    point
        Torque, speed and share of the time.
    crank
        Angles [rad], shape (m,).
    cam
        Size of the cam's force on the gear [N], shape (m,).
    shaft
        Forces on the shaft in its own frame [N], shape (m, places, 2), at `places` along z [m]: cam and counterweight,
        then what the two bearings answer with.
    output
        Force of each output pin [N], shape (m, pins).
    teeth
        Largest force on a tooth [N].
    pressures
        Largest Hertz pressure by kind of pair [Pa].
    losses
        Friction of teeth, cam, output pins and seals [W].
    crank_torque
        On the crank [N m].
    """

    point: DutyPoint
    crank: Array
    cam: Array
    shaft: Array
    places: Array
    output: Array
    teeth: float
    pressures: dict[str, float]
    losses: dict[str, float]
    crank_torque: float


def loading(design: Design, point: DutyPoint) -> Loading:
    """Solve one point of a duty; the signs of torque and speed do not matter: the load brakes.

    Raises
    ------
    RunError
        There is no balance: the drive cannot hold that torque.
    """
    speed = math.copysign(point.speed, design.drive.speed)
    at = design.but(drive={"speed": speed})
    springs, torque = springs_of(at, design.lobes * turn_evenly(POSES)), math.copysign(abs(point.torque), speed)
    found, power = loads(at, springs, torque), powers(at, abs(point.torque))
    shaft = shaft_measures(design)
    places, forces = _shaft_forces(at, shaft, springs.crank, found.cam)
    return Loading(
        point=point,
        crank=springs.crank,
        cam=magnitudes(found.cam),
        shaft=forces,
        places=places,
        output=found.output,
        teeth=float(found.teeth.max()),
        pressures={kind: peak_pressure(at, springs, found, kind) for kind in design.pair_kinds if kind != "pin_sleeve"},
        losses=power.losses,
        crank_torque=power.crank / abs(speed),
    )


def _shaft_forces(design: Design, shaft: Shaft, crank: Array, cam: Array) -> tuple[Array, Array]:
    """Give places along the shaft (4,) [m] and the forces there in its frame, shape (m, 4, 2) [N].

    Two loads, the gear on the cam and the unbalance of the shaft itself, and two bearings that hold it as a beam.
    """
    cosine, sine = np.cos(crank), np.sin(crank)
    turned = np.stack([-(cosine * cam[:, 0] + sine * cam[:, 1]), -(cosine * cam[:, 1] - sine * cam[:, 0])], axis=1)
    own = mass_properties(parts(design)["shaft"])
    flung = np.broadcast_to(own.mass * own.centroid[:2] * design.drive.speed**2, turned.shape)
    far, near = (0.5 * sum(ends) for ends in shaft.bearings)
    acting = np.array([0.5 * sum(shaft.cam), 0.5 * sum(shaft.counterweight)])
    applied = np.stack([turned, flung], axis=1)
    at_near = -np.einsum("p,mpx->mx", (acting - far) / (near - far), applied)
    at_far = -applied.sum(axis=1) - at_near
    return np.array([*acting, far, near]), np.concatenate([applied, at_far[:, None], at_near[:, None]], axis=1)


def bending(found: Loading, place: float) -> Array:
    """Give the bending moment [N m] at a place along the shaft [m], in its frame, shape (m, 2)."""
    arm = np.maximum(found.places - place, 0.0)
    return np.asarray(np.einsum("p,mpx->mx", arm, found.shaft))
