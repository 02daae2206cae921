"""Manufacturing errors of the parts: measured, listed in the design, or drawn at random with a seed.

The one place where manufacturing errors are drawn. Each kind has a random stream of its own, so that one kind switched
on leaves the others as they were. Pins, lobes and holes are counted from 0 on +y, clockwise; lengths in metres.
"""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.deprecated import deprecated_attribute
from cycloid_mj.design import Design
from cycloid_mj.geometry.measured import measured_deviations

_STREAMS = {"pin_x": 0, "pin_y": 1, "pin_dr": 2, "hole_x": 3, "hole_y": 4, "disc_dr": 5, "cam_x": 6, "cam_y": 7}
"""Random stream of each list of errors; numbers must not change, or the same seed would produce other parts."""


@dataclass(frozen=True)
class Deviations:
    """Manufacturing errors of a reducer.

    Attributes
    ----------
    pin_displacement
        Displacement of each ring pin and its socket from the pin circle [m], ring frame, shape (N, 2).
    pin_radius
        Error of the radius of each ring pin, or of its sleeve [m], shape (N,).
    hole_displacement
        Displacement of each hole in its disc [m], disc's frame, shape (D, output pins, 2).
    disc_radius
        Offset of the flanks of each disc from the drawing, outwards [m], shape (D,).
    cam_displacement
        Displacement of each cam on a crank of that eccentricity [m], at crank angle 0, shape (D, 2).
    eccentricity
        Difference of the cams' eccentricity from that of the teeth [m].
    waves
        Inward offset of the flanks of all discs: amplitudes of cosine and sine of each order from 1 on [m], shape
        (N, 2), or of more orders if the profile is measured; see `profile_error`.
    """

    pin_displacement: Array
    pin_radius: Array
    hole_displacement: Array
    disc_radius: Array
    cam_displacement: Array
    eccentricity: float
    waves: Array
    pin_place = deprecated_attribute("Deviations", "pin_place", "pin_displacement")
    hole_place = deprecated_attribute("Deviations", "hole_place", "hole_displacement")
    cam_place = deprecated_attribute("Deviations", "cam_place", "cam_displacement")

    @property
    def largest(self) -> float:
        """The largest magnitude of all errors [m]."""
        displacements = np.concatenate([self.pin_displacement, *self.hole_displacement, self.cam_displacement])
        radii = np.concatenate([self.pin_radius, self.disc_radius, self.waves.ravel()])
        return float(max(np.linalg.norm(displacements, axis=1).max(), np.abs(radii).max(), abs(self.eccentricity)))

    @property
    def waves_in_use(self) -> Array:
        """The waves up to the last order that is not 0 [m], shape (orders, 2)."""
        there = np.flatnonzero(np.any(self.waves != 0.0, axis=1))
        return self.waves[: there[-1] + 1 if there.size else 0]


def deviations(design: Design) -> Deviations:
    """Compute the manufacturing errors of a design's parts.

    Errors of a kind that the design lists are used; others are drawn from a normal distribution with the design's
    standard deviation and seed, so that equal designs have equal errors. Measured errors are added to both.

    Raises
    ------
    DesignError
        The design has a measured profile, but its nominal profile is undercut.
    """
    errors, pin_count, hole_count = design.errors, design.ring.teeth, design.output.pins
    # standard deviations [m]
    pin_deviation, radius_deviation, hole_deviation, cam_deviation = (
        errors.pin_position,
        errors.pin_radius,
        errors.hole_position,
        errors.cam_position,
    )
    measured_parts = measured_deviations(design)
    listed_waves = np.stack(
        [_errors_of_parts(design, name, 0.0, pin_count) for name in ("profile_cos", "profile_sin")], axis=1
    )
    waves = np.pad(listed_waves, ((0, max(0, len(measured_parts.waves) - pin_count)), (0, 0)))
    waves[: len(measured_parts.waves)] += measured_parts.waves
    return Deviations(
        pin_displacement=np.stack(
            [_errors_of_parts(design, key, pin_deviation, pin_count) for key in ("pin_x", "pin_y")], axis=1
        )
        + measured_parts.pin_displacement,
        pin_radius=_errors_of_parts(design, "pin_dr", radius_deviation, pin_count) + measured_parts.pin_radius,
        hole_displacement=np.stack(
            [_errors_by_disc(design, key, hole_deviation, hole_count) for key in ("hole_x", "hole_y")], axis=2
        ),
        disc_radius=_errors_by_disc(design, "disc_dr", errors.disc_size, 1)[:, 0] + measured_parts.disc_radius,
        cam_displacement=np.stack(
            [_errors_by_disc(design, key, cam_deviation, 1)[:, 0] for key in ("cam_x", "cam_y")], axis=1
        ),
        eccentricity=errors.eccentricity,
        waves=waves,
    )


def profile_error(waves: Array, t: Array) -> Array:
    """Compute by how much the flanks are set back inwards [m], at parameters t [rad] of the gear's trochoid, any shape.

    It is the sum of a_k cos(k t) + b_k sin(k t) over the orders k = 1, 2, ..., with the rows (a_k, b_k) [m] of `waves`
    (orders, 2). k is in cycles per turn of the gear, as measuring machines report profile errors. The trochoid is set
    back along its normals, and the flanks are its parallel, as ground by a wheel of the pin's radius. Statics evaluates
    the error at the foot point of the ideal profile, to first order.
    """
    error = np.zeros(np.shape(t))
    for index in np.flatnonzero(np.any(waves != 0.0, axis=1)):
        cosine, sine = waves[index]
        error += cosine * np.cos((index + 1) * t) + sine * np.sin((index + 1) * t)
    return error


def _errors_by_disc(design: Design, name: str, standard_deviation: float, count: int) -> Array:
    """Return the manufacturing errors of a kind [m] of `count` equal parts on each of D discs, (D, count).

    They are listed in the design or drawn at random. `name` is the list in ``design.errors``; `standard_deviation` [m]
    applies to drawn errors.
    """
    listed_errors = getattr(design.errors, name)
    if listed_errors:
        return np.reshape(listed_errors, (design.gear.discs, count))
    return np.stack([_draw_errors(design, name, standard_deviation, count, disc) for disc in range(design.gear.discs)])


def _errors_of_parts(design: Design, name: str, standard_deviation: float, count: int) -> Array:
    """Return the errors of a kind [m] of `count` equal parts, shape (count,): listed in ``design.errors``, or drawn.

    `name` is the list; `standard_deviation` [m] applies to drawn errors.
    """
    values = getattr(design.errors, name)
    return np.array(values) if values else _draw_errors(design, name, standard_deviation, count)


def _draw_errors(design: Design, name: str, standard_deviation: float, count: int, disc: int = 0) -> Array:
    """Draw normally distributed manufacturing errors [m], shape (count,), from the random stream of a list and a disc.

    `disc` is the index of the disc. `name` is the list of the design file, such as ``pin_dr``. The errors are 0 if the
    `standard_deviation` [m] is.
    """
    if not standard_deviation:
        return np.zeros(count)
    key = [design.errors.seed, _STREAMS[name], *([disc] if disc else [])]
    return standard_deviation * np.random.default_rng(key).standard_normal(count)
