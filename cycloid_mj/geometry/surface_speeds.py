"""Speeds of the surfaces of ideal contacts past their contact lines, in closed form.

Lubrication depends on the speeds at which both surfaces pass the contact line: half their sum entrains the lubricant,
their difference is the sliding (Hamrock, Schmid and Jacobson 2004, Fundamentals of Fluid Film Lubrication, section 18).
Symbols as in `profile`: the phase B of a pin, its distance l from the pitch point, and w, the speed of the crank
against the ring. The disc turns at w/(N - 1) about the pitch point, so it slides past a pin by v = w (l - rho)/(N - 1);
the contact line travels over the pin at V = rho c N w (E cos B - c N)/l^2.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.profile import CycloidGear


@dataclass(frozen=True)
class SurfaceSpeeds:
    """Speeds of two surfaces past their contact line [m/s], in one direction along the surface; any equal shapes.

    Attributes
    ----------
    moving
        Speed of the disc's surface, of a rolling pin or roller in its seat, or of a planet's flank.
    fixed
        Speed of the mate's surface.
    """

    moving: Array
    fixed: Array

    @property
    def sliding(self) -> Array:
        """Sliding speed [m/s]: the difference of both speeds."""
        return self.moving - self.fixed

    @property
    def entrainment(self) -> Array:
        """Entrainment speed [m/s]: the mean of both speeds; where it passes through 0, no film forms."""
        return 0.5 * (self.moving + self.fixed)

    def scaled(self, factor: float) -> "SurfaceSpeeds":
        """Return both speeds times a factor, as at another radius of the same part."""
        return SurfaceSpeeds(moving=factor * self.moving, fixed=factor * self.fixed)


def tooth_speeds(gear: CycloidGear, B: npt.ArrayLike, crank_speed: float) -> SurfaceSpeeds:
    """Compute the surface speeds [m/s] of disc and ring at the teeth, for pins that do not rotate or an internal gear.

    They are speeds past the contact line, from which sliding and entrainment speed follow (`SurfaceSpeeds`).

    Parameters
    ----------
    gear
        The mesh.
    B
        Phases of the pins [rad], angles of the pins from the eccentricity, clockwise. They have any shape, and the
        result has the same shape.
    crank_speed
        Speed of the crank relative to the ring [rad/s].
    """
    N, c, E, rho = gear.symbols
    distance = profile.pitch_distance(gear, B)
    sliding = crank_speed / gear.lobes * (distance - rho)
    contact_line_speed = rho * c * N * crank_speed * (E * np.cos(B) - c * N) / distance**2
    return SurfaceSpeeds(moving=contact_line_speed + sliding, fixed=contact_line_speed)


def hole_speeds(gear: CycloidGear, pin_radius: float, hole_radius: float, crank_speed: float) -> SurfaceSpeeds:
    """Compute the surface speeds [m/s] of a hole of the disc on an output pin without roller, past the contact line.

    `pin_radius` and `hole_radius` are in [m]. The contact line moves around pin and hole at the speed of the crank
    relative to the disc, which is N/(N - 1) times `crank_speed` [rad/s], with N ring teeth. `gear` is the profile of
    the disc.
    """
    relative_speed = crank_speed * gear.ring_teeth / gear.lobes
    return SurfaceSpeeds(moving=np.asarray(hole_radius * relative_speed), fixed=np.asarray(pin_radius * relative_speed))


def involute_speeds(
    tangents: tuple[float, float], distance: npt.ArrayLike, speeds: tuple[float, float]
) -> SurfaceSpeeds:
    """Compute the surface speeds [m/s] of two external involute gears that turn in opposite directions.

    Both flanks pass the contact at the speed of their gear times their radius of curvature. These radii are r + y of
    the first and r' - y of the second gear at a distance y from the pitch point along the line of action.

    Parameters
    ----------
    tangents
        Distances r and r' of the pitch point from the base circles along the line of action [m].
    distance
        y [m] of any shape, positive towards the base circle of the second gear.
    speeds
        Magnitudes of the speeds of the first (``fixed``) and the second gear (``moving``) relative to the frame of
        their axes [rad/s].
    """
    y = np.asarray(distance, dtype=np.float64)
    return SurfaceSpeeds(moving=speeds[1] * (tangents[1] - y), fixed=speeds[0] * (tangents[0] + y))


def entrainment_zeros(gear: CycloidGear) -> Array:
    """Compute the phases B in (0, pi) [rad], in order, at which a pin that does not rotate has no entrainment.

    There may be none.

    Notes
    -----
    The entrainment is v/2 + V, with the sliding speed v of the disc and the speed V of the contact line (see the
    module). It vanishes where the distance l of the pin from the pitch point is a root of l^3 - N rho l^2 + (N - 1) rho
    (E^2 - c^2 N^2); roots in (E - c N, E + c N) have a phase. Symbols as in `CycloidGear`.
    """
    N, c, E, rho = gear.symbols
    constant = gear.lobes * rho * (E**2 - (c * N) ** 2)
    roots = np.roots([1.0, -N * rho, 0.0, constant])
    real_roots = roots[np.abs(roots.imag) < 1e-9 * E].real
    cosine = (E**2 + (c * N) ** 2 - real_roots**2) / (2.0 * E * c * N)
    return np.sort(np.arccos(cosine[(np.abs(cosine) < 1.0) & (real_roots > 0.0)]))
