"""The springs of a reducer: gaps, slopes, stiffness and friction of every contact at many crank angles."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cycloid_mj import assembly, kinematics, profile
from cycloid_mj.contact.law import curvature_law, pair_stiffness
from cycloid_mj.contact.working import at_rated_load
from cycloid_mj.design import Design
from cycloid_mj.loaded.rubbing import output_rubbing, ring_rubbing
from cycloid_mj.modification import gear_profile, profile_offset, tooth_profile

Array = npt.NDArray[np.float64]

POSES = 61
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
"""Share of a turn between crank angles: multiples of it fill the mesh period and the turn evenly, whatever N."""

FAR = 1.0
"""Gap [m] of a contact line that a crank angle does not have."""


@dataclass(frozen=True)
class Springs:
    """The springs of a reducer at m crank angles.

    The four unknowns [m] are the gear's x and y, and the output pins' circle times the gear's and the output's turn.

    Attributes
    ----------
    crank
        Angles [rad], shape (m,).
    teeth
        Contact lines with the ring; those after the first are output pins.
    gap, slope, stiffness
        Of the lines and then the output pins [m], [1], [N/m], shapes (m, n), (m, n, 4), (m, n).
    curvature
        Relative curvature of the contact lines with the ring [1/m], shape (m, teeth).
    cam_place, cam_play, cam_stiffness
        Middle of the cam [m], from the gear's ideal centre, shape (m, 2); its clearance [m] and stiffness [N/m].
    body_force
        Weight and centrifugal force of the gear [N], shape (m, 2).
    rubbing
        Generalised friction of each contact line and output pin per normal force [1], shape (m, n, 4).
    cam_rubbing
        Generalised friction of the cam on the gear's turn per normal force [1].
    """

    crank: Array
    teeth: int
    gap: Array
    slope: Array
    stiffness: Array
    curvature: Array
    cam_place: Array
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
    lines = [assembly.mesh_lines(design, float(angle)) for angle in crank]
    ring = [assembly.ring_gaps(design, part) for part in lines]
    holes = [assembly.output_gaps(design, float(angle)) for angle in crank]
    teeth = max(part.gap.size for part in ring)
    unit = np.array([1.0, 1.0, 1.0 / design.output.pin_circle_radius, 1.0 / design.output.pin_circle_radius])
    gap = _padded([part.gap + design.pin_play for part in ring], teeth, FAR)
    curvature = _padded([part.relative_curvature for part in lines], teeth, 1.0)
    slope = _padded([part.slope for part in ring], teeth, 0.0)
    springs = _tooth_stiffness(design, curvature)
    rubbing = [ring_rubbing(design, part, angle) for part, angle in zip(lines, crank, strict=True)]
    beside = [output_rubbing(design, part, angle) for part, angle in zip(holes, crank, strict=True)]
    output = np.full((crank.size, design.output.pins), pair_stiffness(design, "output"))
    gear = design.gear
    away = kinematics.gear_centre(tooth_profile(design), crank) / gear.eccentricity
    return Springs(
        crank=crank,
        teeth=teeth,
        gap=np.concatenate([gap, np.stack([part.gap for part in holes])], axis=1),
        slope=np.concatenate([slope, np.stack([part.slope for part in holes])], axis=1) * unit,
        stiffness=np.concatenate([springs, output], axis=1),
        curvature=curvature,
        cam_place=design.errors.eccentricity * away,
        cam_play=design.clearance.cam,
        cam_stiffness=pair_stiffness(design, "cam"),
        body_force=_body_force(design, away),
        rubbing=np.concatenate([_padded(rubbing, teeth, 0.0), np.stack(beside)], axis=1) * unit,
        cam_rubbing=math.copysign(design.friction_of("cam"), design.drive.speed) * gear.bore_radius * unit[2],
    )


def _tooth_stiffness(design: Design, curvature: Array) -> Array:
    """Stiffness of the contact lines with the ring [N/m], that of sockets or sleeves in series."""
    law = curvature_law(design)
    own = np.vectorize(lambda kappa: law.stiffness * law.factor(kappa))(curvature)
    kind = "pin_socket" if design.ring.has_sockets else "pin_sleeve" if design.ring.has_sleeves else ""
    return np.asarray(1.0 / (1.0 / own + 1.0 / pair_stiffness(design, kind)) if kind else own)


def _body_force(design: Design, away: Array) -> Array:
    """Weight and centrifugal force of the gear [N], (m, 2), its bore and holes left out of its mass."""
    gear, output = design.gear, design.output
    bored = math.pi * (gear.bore_radius**2 + output.pins * output.hole_radius**2)
    area = profile.area(gear_profile(design), profile_offset(design)) - bored
    mass = design.material.density * gear.face_width * area
    gravity = np.array([design.environment.gravity_x, design.environment.gravity_y])
    return np.asarray(mass * (gravity + gear.eccentricity * design.drive.speed**2 * away))


def _padded(rows: list[Array], length: int, fill: float) -> Array:
    """Stack arrays of different lengths, (n, ...), to one, (m, length, ...)."""
    whole = np.full((len(rows), length, *rows[0].shape[1:]), fill)
    for row, values in zip(whole, rows, strict=True):
        row[: len(values)] = values
    return whole
