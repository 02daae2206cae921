"""Chord errors of the parts: the largest distance of a chord from its curve."""

from cycloid_mj.base.errors import DesignError
from cycloid_mj.reducer import Reducer

VISUAL_CHORD_ERROR = 5e-6
"""Chord error of meshes for viewing [m]: a few thousand triangles per part."""

EXPORT_CHORD_ERROR = 1e-6
"""Chord error of exported meshes and polylines, and of the mass of a drive [m]: volumes are accurate to 1e-4."""

SAME_LENGTH = 1e-9
"""Tolerance of equal lengths [m], such as the radii of two circles or the heights of two faces: above rounding."""

RELATIVE_ROUNDING = 1e-9
"""Relative rounding allowance of a limit: a part of exactly the limit passes."""

MASS_CHORD_ERROR = 5e-7
"""Chord error for mass properties, relative to the thinnest radius of the design."""


def mass_chord_error(reducer: Reducer) -> float:
    """Return the chord error [m] of polygons for mass properties: `MASS_CHORD_ERROR` times the smallest radius.

    The smallest radius is that of a ring pin, of an output pin or of the shaft. A polygon with the chord error s has an
    area that is smaller than that of its circle of radius r by the fraction 4/3 s/r. Volumes are therefore accurate to
    1e-6.
    """
    design = reducer.design
    return MASS_CHORD_ERROR * min(design.ring.pin_radius, design.output.pin_radius, design.shaft.radius)


def checked_chord_error(reducer: Reducer, chord_error: float | None) -> float:
    """Check a chord error [m] and return it; None selects `mass_chord_error`.

    Raises
    ------
    DesignError
        `chord_error` is not positive.
    """
    if chord_error is None:
        return mass_chord_error(reducer)
    if not chord_error > 0.0:
        raise DesignError(
            f"chord_error = {chord_error} m is out of range: give a length greater than 0 m, e.g. {VISUAL_CHORD_ERROR} "
            "m"
        )
    return chord_error


SCREEN_CHORD_ERROR = 1e-5
"""Chord error of outlines and meshes on a screen [m]: a tenth of a pixel."""
