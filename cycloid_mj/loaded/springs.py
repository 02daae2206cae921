"""The springs of a reducer: gaps, slopes, stiffness and friction of every contact at many crank angles."""

import math
from dataclasses import dataclass, fields

import numpy as np

from cycloid_mj import kinematics, profile
from cycloid_mj.contact.law import curvature_law, pair_stiffness
from cycloid_mj.contact.working import at_rated_load
from cycloid_mj.design import Design
from cycloid_mj.loaded.rubbing import rubbing
from cycloid_mj.mechanism import kernel
from cycloid_mj.mechanism.gaps import Gaps, arc_gaps, cam_places, flank_gaps, ideal_motion
from cycloid_mj.modification import gear_profile, profile_offset, tooth_profile
from cycloid_mj.types import Array

POSES = 61
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
"""Share of a turn between crank angles: multiples of it fill the mesh period and the turn evenly, whatever N."""

FAR = 1.0
"""Gap [m] of a contact line that a crank angle does not have."""


@dataclass(frozen=True)
class Springs:
    """The springs of a reducer at m crank angles, on the unknowns of ``mechanism.gaps``.

    Attributes
    ----------
    crank
        Angles [rad], shape (m,).
    teeth
        Contact lines with the ring; those after the first are output pins.
    contacts
        The springs of the lines and then the output pins, n at each angle.
    curvature
        Relative curvature of the contact lines with the ring [1/m], shape (m, teeth).
    cam_play, cam_stiffness
        Clearance [m] and stiffness [N/m] of the cam.
    body_force
        Weight and centrifugal force of the gear [N], shape (m, 2).
    rubbing
        Generalised friction of each contact line and output pin per normal force [1], shape (m, n, 4).
    cam_rubbing
        Generalised friction of the cam on the gear's turn per normal force [1].
    """

    crank: Array
    teeth: int
    contacts: kernel.Springs
    curvature: Array
    cam_play: float
    cam_stiffness: float
    body_force: Array
    rubbing: Array
    cam_rubbing: float


def turn_evenly(poses: int = POSES) -> Array:
    """Give crank angles [rad], shape (poses,), that lie evenly in the turn and, taken modulo it, in the mesh period."""
    return np.asarray(2.0 * math.pi * np.mod(GOLDEN * np.arange(poses), 1.0))


def springs_of(design: Design, crank: Array | None = None) -> Springs:
    """Give the springs of a design, which must be sound, at crank angles [rad], shape (m,); by default all round.

    Their stiffness is that `at_rated_load`.

    Raises
    ------
    ContactError
        The working force flattens a pin beyond a line contact.
    """
    design = at_rated_load(design)
    crank = turn_evenly() if crank is None else crank
    found = _lines_and_pins(design, crank)
    teeth = int(np.sum(found.kind == design.tooth_pair))
    curvature = found.relative_curvature[:, :teeth]
    output = np.full((crank.size, design.output.pins), pair_stiffness(design, "output"))
    turning = ideal_motion(design, crank) * np.sign(design.drive.speed)
    drag = math.copysign(design.friction_of("cam"), design.drive.speed) * design.gear.bore_radius
    return Springs(
        crank=crank,
        teeth=teeth,
        contacts=kernel.Springs(
            room=found.room + np.where(found.kind == design.tooth_pair, design.pin_play, 0.0),
            distance=found.distance,
            slope=found.slope,
            shift=found.shift,
            shift_slope=found.shift_slope,
            bend=found.bend,
            stiffness=np.concatenate([tooth_stiffness(design, curvature), output], axis=1),
            cam_place=cam_places(design, crank),
        ),
        curvature=curvature,
        cam_play=design.clearance.cam,
        cam_stiffness=pair_stiffness(design, "cam"),
        body_force=_body_force(design, kinematics.gear_centre(tooth_profile(design), crank)),
        rubbing=rubbing(design, found, turning),
        cam_rubbing=drag / design.output.pin_circle_radius,
    )


def _lines_and_pins(design: Design, crank: Array) -> Gaps:
    """Give the contact lines with the ring, those of an internal gear's flanks after its arcs, and the output pins.

    Angles with fewer flanks than others have some that are far away.
    """
    found = arc_gaps(design, crank)
    if design.ring.kind == "pin":
        return found
    at = [flank_gaps(design, float(angle)) for angle in crank]
    most, parts = max(one.owner.size for one in at), {}
    for field in fields(Gaps):
        whole, before = getattr(found, field.name), design.ring.teeth
        if field.name in ("kind", "owner", "disc"):
            flank = np.full(most, {"kind": design.tooth_pair}.get(field.name, 0))
            parts[field.name] = np.concatenate([whole[:before], flank, whole[before:]])
        else:
            fill = {"room": FAR, "bend": 1.0, "relative_curvature": 1.0}.get(field.name, 0.0)
            flanks = _padded([getattr(one, field.name) for one in at], most, fill)
            parts[field.name] = np.concatenate([whole[:, :before], flanks, whole[:, before:]], axis=1)
    return Gaps(**parts)


def tooth_stiffness(design: Design, curvature: Array) -> Array:
    """Give the stiffness of contact lines with the ring by relative curvature [N/m], sockets or sleeves in series."""
    law = curvature_law(design)
    own = np.vectorize(lambda kappa: law.stiffness * law.factor(kappa))(curvature)
    kind = design.seat_pair
    return np.asarray(1.0 / (1.0 / own + 1.0 / pair_stiffness(design, kind)) if kind else own)


def _body_force(design: Design, centre: Array) -> Array:
    """Weight and centrifugal force of the gear [N], (m, 2), its bore and holes left out of its mass."""
    gear, output = design.gear, design.output
    bored = math.pi * (gear.bore_radius**2 + output.pins * output.hole_radius**2)
    area = profile.area(gear_profile(design), profile_offset(design)) - bored
    mass = design.material.density * gear.face_width * area
    gravity = np.array([design.environment.gravity_x, design.environment.gravity_y])
    return np.asarray(mass * (gravity + design.drive.speed**2 * centre))


def _padded(rows: list[Array], length: int, fill: float) -> Array:
    """Stack arrays of different lengths, (n, ...), to one, (m, length, ...)."""
    whole = np.full((len(rows), length, *rows[0].shape[1:]), fill)
    for row, values in zip(whole, rows, strict=True):
        row[: len(values)] = values
    return whole
