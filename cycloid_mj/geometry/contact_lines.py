"""Contact lines of the ideal mesh and their relative curvature, for a pin ring or a double-enveloping ring.

The relative normal curvature of a line is the gear's curvature plus the ring's (Johnson 1985, section 4.1): the
smaller it is, the wider the strip of contact and the lower Hertz's pressure. Pins and arcs have the same lines with
the same curvature; the flanks Sigma of the double-enveloping ring add lines of their own, of nearly equal curvatures.
"""

from dataclasses import dataclass, fields
from typing import Literal

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.geometry import envelope, profile
from cycloid_mj.geometry.envelope import RingContacts
from cycloid_mj.geometry.ideal_loads import hertz_line_contact
from cycloid_mj.geometry.profile import CycloidGear

RingKind = Literal["pin", "nonpin"]


@dataclass(frozen=True)
class ContactLines:
    """Contact lines at several crank angles; each array has one row per line, in the order of the crank angles.

    `crank_angle` [rad], counter-clockwise; `tooth` index of the pin, or of the lobe whose arc or flank it is (0 on
    +y, clockwise); `part` ("pin", "arc", "sigma1", "sigma2"); `phase` B in [0, 2 pi) [rad], where a
    counter-clockwise crank under load presses the lines of B > pi; `points` (n, 2) [m] in the ring frame;
    `relative_curvature` [1/m].
    """

    crank_angle: Array
    tooth: Integers
    part: npt.NDArray[np.str_]
    phase: Array
    points: Array
    relative_curvature: Array


def contact_lines(gear: CycloidGear, kind: RingKind, crank_angles: npt.ArrayLike) -> ContactLines:
    """Compute every contact line of disc and ring at several crank angles [rad], for parts without clearance.

    The result has a row for each line, with its crank angle (counter-clockwise), tooth, position in the ring frame, and
    relative curvature of disc and ring. `gear` is the profile of the disc. `kind` is "pin" for a ring of pins, or
    "nonpin" for an internal gear.

    Raises
    ------
    DesignError
        The gear is undercut.
    """
    profile.require_no_undercut(gear)
    groups = [group for angle in np.ravel(crank_angles) for group in _contact_lines_at(gear, kind, float(angle))]
    columns = {field.name: [getattr(group, field.name) for group in groups] for field in fields(ContactLines)}
    return ContactLines(**{name: np.concatenate(arrays) for name, arrays in columns.items()})


def mesh_period(gear: CycloidGear, count: int) -> Array:
    """Compute `count` crank angles [rad] that divide one mesh period 2 pi/N equally, from 0, its end left out."""
    return 2 * np.pi / gear.ring_teeth * np.arange(count) / count


def peak_pressure(lines: ContactLines, force: float, length: float, modulus: float) -> Array:
    """Compute Hertz's peak pressure [Pa] of each of n contact lines under a force [N], shape (n,).

    `length` [m] is the face width. `lines` are the contact lines, `modulus` E* [Pa] is the plane-strain modulus of both
    bodies together. Where an arc of an internal gear joins the flank Sigma next to it, the relative curvature vanishes
    and the pressure tends to 0: Hertz's assumption of a strip that is narrow against both bodies is not valid there.
    """
    curvature = np.maximum(lines.relative_curvature, np.finfo(float).tiny)
    return hertz_line_contact(force, length, curvature, modulus).peak_pressure


def _contact_lines_at(gear: CycloidGear, kind: RingKind, crank_angle: float) -> list[ContactLines]:
    """Return the contact lines of a gear and its ring at one crank angle [rad], counter-clockwise.

    `kind` is the kind of the ring. For ring pins the list has a single entry; for an internal gear it has the lines on
    arcs, then the lines on the flanks Sigma between them.
    """
    arc_contacts = envelope.arc_contacts(gear, crank_angle)
    if kind == "pin":
        return [_collect_lines(crank_angle, arc_contacts, arc_contacts.lobe, np.full(arc_contacts.lobe.shape, "pin"))]
    flank_contacts = envelope.sigma_contacts(gear, crank_angle)
    phase = flank_contacts.B
    is_past_lobe = phase > np.pi
    # that half of the root counter-clockwise of a lobe is the flank Sigma(2) of the lobe on its other side
    tooth = np.mod(flank_contacts.lobe - is_past_lobe, gear.ring_teeth)
    return [
        _collect_lines(crank_angle, arc_contacts, arc_contacts.lobe, np.full(arc_contacts.lobe.shape, "arc")),
        _collect_lines(crank_angle, flank_contacts, tooth, np.where(is_past_lobe, "sigma2", "sigma1")),
    ]


def _collect_lines(
    crank_angle: float, contacts: RingContacts, tooth: Integers, part: npt.NDArray[np.str_]
) -> ContactLines:
    """Convert the n contacts of the disc with one part of the ring, at a crank angle [rad], to contact lines.

    `tooth` are the indices of the ring's teeth and `part` the names of their parts: pin, arc, sigma1 or sigma2. Arrays
    have shape (n,).
    """
    return ContactLines(
        crank_angle=np.full(tooth.shape, crank_angle),
        tooth=tooth,
        part=part,
        phase=np.mod(contacts.B, 2 * np.pi),
        points=contacts.points,
        relative_curvature=contacts.relative_curvature,
    )
