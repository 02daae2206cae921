"""Compliance of the seats of output pins and crank in elastic plates, from a drawing.

A round part in the bore of a plate of width w has the compliance 1/(E w) (Tate and Rosenfeld, NACA TN 1051, 1946). So a
pin in its plates is a beam on a foundation of E per length (Winkler), and a crank a beam on two bearings, each with a
seat in its bore and on the shaft. E is that of the housing: plates and shaft are assumed to have its material.
"""

from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, model_validator

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError, UsageError, reason
from cycloid_mj.base.overwrite_guard import note_input
from cycloid_mj.design import PARTS
from cycloid_mj.design import units as u
from cycloid_mj.design.file import parse_toml, record
from cycloid_mj.design.section import Section
from cycloid_mj.design.units import quantity, switch
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP, round_beam
from cycloid_mj.stress.loads import PartLoads

SLICES = 40
"""Elements of each section of a pin: twice as many change its compliance by less than 0.1 %."""


Limits = tuple[
    Annotated[float, Field(gt=0.0, allow_inf_nan=False)], Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
]


def _length(description: str) -> Any:
    return quantity(..., description, u.MILLIMETRE, gt=0.0, le=1e4)


class StudSeats(Section):
    """Seats of the output pins [m]."""

    near_seat: float = _length("length of a pin in the output's plate")
    far_seat: float = _length("length of a pin in the second plate, beyond the disc")
    far_plate_free: bool = switch(
        False, "true: nothing but the pins keeps the second plate from turning against the output's"
    )


class CrankSeats(Section):
    """Seats of a crank on two bearings, with the ring of a needle bearing on its cam [m]."""

    to_hub: float = _length("from the middle of the cam to that of the bearing in the output's hub")
    to_housing: float = _length("from the middle of the cam to that of the bearing in the housing")
    hub_seat: float = _length("width of the bearing in the output's hub")
    housing_seat: float = _length("width of the bearing in the housing")
    cam_seat: float = _length("width of the ring on the cam")
    post: float = _length("length of the thin stretch next to that ring, on the housing's side")
    post_diameter: float = _length("its diameter")


class Printed(Section):
    """Smallest and largest Young's modulus of the printed material [Pa]."""

    modulus: Limits = quantity(..., "the least and the largest Young's modulus", u.MEGAPASCAL)

    @model_validator(mode="after")
    def _require_order(self) -> Self:
        """Raise ValueError for limits in the wrong order."""
        if self.modulus[0] > self.modulus[1]:
            raise ValueError("modulus_mpa must be the smallest, then the largest modulus")
        return self


class Mounts(Section):
    """Seats from a drawing; each table is optional."""

    studs: StudSeats | None = Field(default=None, description="seats of the output pins")
    crank: CrankSeats | None = Field(default=None, description="seats of the crank")
    material: Printed | None = Field(default=None, description="what is printed; by default that of the design")


def read_mounts(path: Path) -> Mounts:
    """Read the seats of output pins and crank from a TOML file; the tables [studs], [crank], [material] are optional.

    Lengths in the file are in mm; ``modulus_mpa`` of [material] is a list of the smallest and the largest Young's
    modulus in MPa.

    Raises
    ------
    UsageError
        There is no such file.
    DesignError
        It is not TOML, or a key is unknown, missing or out of range.
    """
    try:
        tables = parse_toml(
            note_input(path).read_text(encoding="utf-8-sig"), str(path), "docs/printed-drive.md describes an example"
        )
    except FileNotFoundError as error:
        raise UsageError(
            f"the mounts file {path} does not exist: give the name of a TOML file (docs/printed-drive.md shows an "
            "example)"
        ) from error
    except (OSError, ValueError) as error:
        raise DesignError(
            f"cannot read the mounts file {path}: {reason(error)}. Choose a readable TOML file with UTF-8 text"
        ) from error
    return record(Mounts, tables, str(path))


def with_modulus(reducer: Reducer, modulus: float) -> Reducer:
    """Return a reducer whose parts of the housing's material have another Young's modulus [Pa]."""
    design = reducer.design
    housing_parts = [part for part in PARTS if design.material_of(part) == design.material_of("housing")]
    return reducer.but(**{design.material_table(part): {"youngs_modulus": modulus} for part in housing_parts})


def studs_compliance(reducer: Reducer, studs: StudSeats, loads: PartLoads) -> dict[str, float]:
    """Compute the torsional compliance of output pins that are seated in two plates around the disc [rad/(N m)].

    A pin between fixed plates has the lateral compliance c. Under the torque T, with the forces F of the disc on the
    pins, the compliance of the pins is sum(c F^2)/T^2, averaged over the crank angles. A second plate that can turn
    carries the share s of the torque; its n pins with the lateral stiffness K on the radius r add s^2/(n K r^2).

    Parameters
    ----------
    reducer
        The reducer; its ``load.torque`` T must not be 0.
    studs
        Lengths of the seats in both plates.
    loads
        Loads on the output under that torque.

    Returns
    -------
    dict
        "studs": compliance of the pins between fixed plates; "far_plate": compliance due to the rotation of the second
        plate, 0 if it cannot turn.

    Raises
    ------
    UsageError
        The pins are not supported at both ends, or the drive has several discs.
    """
    design, output = reducer.design, reducer.design.output
    if output.support != "both_ends" or design.gear.discs > 1:
        raise UsageError(
            "[studs] in the mounts file is only possible for a drive with one disc between two output plates, but "
            f'{design.name} has gear.discs = {design.gear.discs} and output.support = "{output.support}". Remove '
            '[studs], or set gear.discs = 1 and output.support = "both_ends"'
        )
    compliance, far_share, lateral_stiffness = solve_stud_beam(reducer, studs)
    pin_compliance = compliance * np.mean(np.sum(loads.force**2, axis=(1, 2))) / design.load.torque**2
    plate_compliance = (
        far_share**2 / (output.pins * lateral_stiffness * output.pin_circle_radius**2) if studs.far_plate_free else 0.0
    )
    return {"studs": float(pin_compliance), "far_plate": plate_compliance}


def solve_stud_beam(reducer: Reducer, studs: StudSeats) -> tuple[float, float, float]:
    """Compute the deflection of an output pin under the force of a disc, as a Timoshenko beam in two elastic plates.

    The force is uniform over the disc's width. `studs` are the lengths of the seats in both plates.

    Returns
    -------
    tuple
        Displacement at the load per force with fixed plates [m/N], share of the force that the far plate carries [1],
        and force on the far plate per displacement of this plate [N/m].
    """
    design, width = reducer.design, reducer.design.gear.face_width
    # along the pin: seat, gap, disc, gap, seat; supported, and loaded
    lengths = np.repeat(np.array([studs.far_seat, AXIAL_GAP, width, AXIAL_GAP, studs.near_seat]) / SLICES, SLICES)
    support_lengths, load_lengths = (np.repeat(mask, SLICES) * lengths for mask in ((1, 0, 0, 0, 1), (0, 0, 1, 0, 0)))
    nodes = lengths.size + 1
    stiffness = np.zeros((2 * nodes, 2 * nodes))
    for element, length in enumerate(lengths):
        unknowns = slice(2 * element, 2 * element + 4)
        stiffness[unknowns, unknowns] += _beam_element(reducer, length)
    modulus = design.material_of("housing").youngs_modulus
    support_springs, load = (_to_nodes(line_load) for line_load in (modulus * support_lengths, load_lengths / width))
    stiffness[np.arange(0, 2 * nodes, 2), np.arange(0, 2 * nodes, 2)] += support_springs
    far_spring = np.where(np.arange(nodes) <= SLICES, support_springs, 0.0)
    loads = np.stack([_displacement_loads(load), _displacement_loads(far_spring)], axis=1)
    load_deflection, plate_deflection = np.linalg.solve(stiffness, loads)[::2].T
    return (
        float(load @ load_deflection),
        float(far_spring @ load_deflection),
        float(np.sum(far_spring) - far_spring @ plate_deflection),
    )


def crank_compliance(reducer: Reducer, crank: CrankSeats) -> float:
    """Compute the lateral compliance of a crank at the middle of its cam [m/N], with elastic seats of its bearings.

    `crank` has the dimensions of the crank and its seats. The thin section next to the cam (post) is a Timoshenko beam.
    Each bearing of width w has the compliance 2/(E w), of which 1/(E w) is in its bore and 1/(E w) on the shaft. The
    ring on the cam has 1/(E w). E is Young's modulus of the housing. Both bearings allow the crank to tilt.
    """
    material, span = reducer.design.material_of("housing"), crank.to_hub + crank.to_housing
    hub_share, housing_share = crank.to_housing / span, crank.to_hub / span
    seat_term = 2.0 * hub_share**2 / crank.hub_seat + 2.0 * housing_share**2 / crank.housing_seat + 1.0 / crank.cam_seat
    lever = crank.to_housing - crank.cam_seat / 2.0
    bending, shearing = round_beam(material, crank.post_diameter / 2.0)
    post_term = (lever**3 - (lever - crank.post) ** 3) / (3.0 * bending) + crank.post / shearing
    return seat_term / material.youngs_modulus + housing_share**2 * post_term


def _beam_element(reducer: Reducer, length: float) -> Array:
    """Compute the stiffness matrix (4, 4) of a Timoshenko beam element of an output pin with `length` [m].

    Unknowns are displacement [m] and slope [rad] of the first end, then of the second end; forces are [N] and [N m].
    """
    design = reducer.design
    bending, shearing = round_beam(design.material_of("output"), design.output.root_radius)
    shear_factor = 12.0 * bending / (shearing * length**2)
    coupling, near_term, far_term = 6.0 * length, (4.0 + shear_factor) * length**2, (2.0 - shear_factor) * length**2
    matrix = [
        [12.0, coupling, -12.0, coupling],
        [coupling, near_term, -coupling, far_term],
        [-12.0, -coupling, 12.0, -coupling],
        [coupling, far_term, -coupling, near_term],
    ]
    return np.array(matrix) * bending / ((1.0 + shear_factor) * length**3)


def _to_nodes(of_elements: Array) -> Array:
    """Distribute values of elements equally to their two nodes, shape (n,) -> (n + 1,)."""
    return np.asarray(0.5 * (np.append(of_elements, 0.0) + np.append(0.0, of_elements)))


def _displacement_loads(of_nodes: Array) -> Array:
    """Return the load vector (2 n,) of a beam with n nodal forces (n,) and without nodal moments."""
    return np.stack([of_nodes, np.zeros_like(of_nodes)], axis=1).ravel()
