"""What holds output pins and crank in plates that give, as a drawing tells it and a design does not.

A round part in the bore of a plate gives 1/(E w), w its width (Tate and Rosenfeld, NACA TN 1051, 1946). So a pin in its
plates is a beam on a foundation of E per length (Winkler), and a crank a beam on two bearings, each of which sits in a
bore and on the shaft. E is that of the housing: plates and shaft are taken to be of its material.
"""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError, UsageError, reason
from cycloid_mj.base.replacing import as_input
from cycloid_mj.base.units import MEGAPASCAL, MILLIMETRE
from cycloid_mj.design import PARTS
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP, round_beam
from cycloid_mj.stress.loads import PartLoads

SLICES = 40
"""Elements of each stretch of a pin: twice as many change its give by less than 0.1 %."""


@dataclass(frozen=True)
class StudSeats:
    """Seats of the output pins.

    Attributes
    ----------
    near_seat, far_seat
        Length of a pin in the output's plate, and in the second one beyond the disc [m].
    far_plate_free
        Whether nothing but the pins keeps the second plate from turning against the output's.
    """

    near_seat: float
    far_seat: float
    far_plate_free: bool = False


@dataclass(frozen=True)
class CrankSeats:
    """Seats of a crank on two bearings, with the ring of a needle bearing on its cam.

    Attributes
    ----------
    to_hub, to_housing
        From the middle of the cam to the middle of the bearing in the output's hub, and of that in the housing [m].
    hub_seat, housing_seat, cam_seat
        Widths of the two bearings, and of the ring on the cam [m].
    post, post_diameter
        The thin stretch beside that ring, on the housing's side: length and diameter [m].
    """

    to_hub: float
    to_housing: float
    hub_seat: float
    housing_seat: float
    cam_seat: float
    post: float
    post_diameter: float


@dataclass(frozen=True)
class Mounts:
    """What a drawing tells beside the design.

    Attributes
    ----------
    studs, crank
        Seats of the output pins, and of the crank; None: not told.
    modulus
        Least and largest Young's modulus that what is printed may have [Pa]; None: that of the design.
    """

    studs: StudSeats | None = None
    crank: CrankSeats | None = None
    modulus: tuple[float, float] | None = None


def read_mounts(path: Path) -> Mounts:
    """Read a file of mounts: tables [studs] and [crank] with lengths in mm, [material] with modulus_mpa = [a, b].

    Raises
    ------
    UsageError
        There is no such file.
    DesignError
        It is not TOML, or a key is unknown, missing or out of range.
    """
    try:
        tables = tomllib.loads(as_input(path).read_text(encoding="utf-8-sig"))
    except FileNotFoundError as error:
        raise UsageError(f"there is no file of mounts {path}; docs/bench.md shows one") from error
    except (OSError, ValueError) as error:
        raise DesignError(f"cannot read the mounts {path}: {reason(error)}; give a TOML text file") from error
    kinds: Mapping[str, Any] = {"studs": StudSeats, "crank": CrankSeats}
    for name, table in tables.items():
        if name not in (*kinds, "material") or not isinstance(table, dict):
            raise DesignError(f"{path}: {name!r} is no table of mounts; it has [studs], [crank] and [material]")
    told = {name: _section(kinds[name], tables[name], f"{path}: {name}") for name in kinds if name in tables}
    return Mounts(**told, modulus=_modulus(tables["material"], str(path)) if "material" in tables else None)


def printed_of(reducer: Reducer, modulus: float) -> Reducer:
    """Return a reducer whose parts of the housing's material have another Young's modulus [Pa]."""
    design = reducer.design
    alike = [part for part in PARTS if design.material_of(part) == design.material_of("housing")]
    return reducer.but(**{design.material_table(part): {"youngs_modulus": modulus} for part in alike})


def studs_given(reducer: Reducer, studs: StudSeats, loads: PartLoads) -> dict[str, float]:
    """Compute what the output pins give in their plates, and the second plate on them [rad/(N m)].

    The work of the loads of a disc, shape (k, m, 2), on pins whose far plate does not turn, and beside it, where that
    is free, what the plate's turn adds: it carries the share s of the torque, which n pins hand back by their stiffness
    K across, s^2/(n K r^2). Means over the k crank angles.

    Raises
    ------
    UsageError
        The pins are not held at both ends, or pass several discs.
    """
    design, output = reducer.design, reducer.design.output
    if output.support != "both_ends" or design.gear.discs > 1:
        raise UsageError(
            f"the mounts tell studs in two plates, beside one disc; {design.name} has {design.gear.discs} disc(s) and "
            f'output.support = "{output.support}": leave [studs] out, or set output.support=both_ends'
        )
    give, share, across = stud_stiffness(reducer, studs)
    work = give * np.mean(np.sum(loads.force**2, axis=(1, 2))) / design.load.torque**2
    swing = share**2 / (output.pins * across * output.pin_circle_radius**2) if studs.far_plate_free else 0.0
    return {"studs": float(work), "far_plate": swing}


def stud_stiffness(reducer: Reducer, studs: StudSeats) -> tuple[float, float, float]:
    """Compute of an output pin in its plates: give, share of the far plate, stiffness across.

    A Timoshenko beam of the pin's root on the foundations of both plates, under a load that is even over the disc's
    width: its displacement there per force [m/N] at plates that stay, the share of the force that goes to the far
    plate, and the force on that plate per displacement of it, without a load [N/m].
    """
    design, width = reducer.design, reducer.design.gear.face_width
    # along the pin: seat, gap, disc, gap, seat; what is held, what is loaded
    steps = np.repeat(np.array([studs.far_seat, AXIAL_GAP, width, AXIAL_GAP, studs.near_seat]) / SLICES, SLICES)
    held, loaded = (np.repeat(where, SLICES) * steps for where in ((1, 0, 0, 0, 1), (0, 0, 1, 0, 0)))
    nodes = steps.size + 1
    stiffness = np.zeros((2 * nodes, 2 * nodes))
    for place, step in enumerate(steps):
        rows = slice(2 * place, 2 * place + 4)
        stiffness[rows, rows] += _beam_element(reducer, step)
    modulus = design.material_of("housing").youngs_modulus
    spring, load = (_to_nodes(one) for one in (modulus * held, loaded / width))
    stiffness[np.arange(0, 2 * nodes, 2), np.arange(0, 2 * nodes, 2)] += spring
    far = np.where(np.arange(nodes) <= SLICES, spring, 0.0)
    moved, pushed = np.linalg.solve(stiffness, np.stack([_on_places(load), _on_places(far)], axis=1))[::2].T
    return float(load @ moved), float(far @ moved), float(np.sum(far) - far @ pushed)


def crank_give(reducer: Reducer, crank: CrankSeats) -> float:
    """Compute by how much the cam moves aside per force on it [m/N]: seats, and the post as a Timoshenko beam.

    Each bearing gives twice 1/(E w), in its bore and on the shaft, the cam's ring once; both bearings let the crank
    tilt.
    """
    material, span = reducer.design.material_of("housing"), crank.to_hub + crank.to_housing
    on_hub, on_housing = crank.to_housing / span, crank.to_hub / span
    seats = 2.0 * on_hub**2 / crank.hub_seat + 2.0 * on_housing**2 / crank.housing_seat + 1.0 / crank.cam_seat
    near = crank.to_housing - crank.cam_seat / 2.0
    bending, shearing = round_beam(material, crank.post_diameter / 2.0)
    post = (near**3 - (near - crank.post) ** 3) / (3.0 * bending) + crank.post / shearing
    return seats / material.youngs_modulus + on_housing**2 * post


def _beam_element(reducer: Reducer, length: float) -> Array:
    """Compute the stiffness of a Timoshenko element of an output pin, (4, 4): displacement and slope of both ends."""
    design = reducer.design
    bending, shearing = round_beam(design.material_of("output"), design.output.root_radius)
    soft = 12.0 * bending / (shearing * length**2)
    six, four, two = 6.0 * length, (4.0 + soft) * length**2, (2.0 - soft) * length**2
    rows = [[12.0, six, -12.0, six], [six, four, -six, two], [-12.0, -six, 12.0, -six], [six, two, -six, four]]
    return np.array(rows) * bending / ((1.0 + soft) * length**3)


def _to_nodes(of_elements: Array) -> Array:
    """Share what elements hold evenly between their two nodes, shape (n,) -> (n + 1,)."""
    return np.asarray(0.5 * (np.append(of_elements, 0.0) + np.append(0.0, of_elements)))


def _on_places(of_nodes: Array) -> Array:
    """Put forces on displacements, none on slopes, shape (n,) -> (2 n,)."""
    return np.stack([of_nodes, np.zeros_like(of_nodes)], axis=1).ravel()


def _section(kind: type, table: Mapping[str, Any], where: str) -> Any:
    """Read a table by the names of a record: lengths as ``name_mm``, switches as they are."""
    switches = {one.name for one in fields(kind) if one.type is bool}
    keys = {one.name if one.name in switches else f"{one.name}_mm": one.name for one in fields(kind)}
    needed = {key for key, name in keys.items() if name not in switches}
    if wrong := sorted(set(table) - set(keys)) or sorted(needed - set(table)):
        what = "unknown" if wrong[0] not in keys else "missing"
        raise DesignError(f"{where}: {wrong[0]} is {what}; it has {', '.join(keys)}")
    values = {}
    for key, value in table.items():
        right = isinstance(value, bool) if keys[key] in switches else _positive(value)
        if not right:
            asked = "true or false" if keys[key] in switches else "a length above 0 [mm]"
            raise DesignError(f"{where}: {key} is {value!r}; give {asked}")
        values[keys[key]] = value if keys[key] in switches else value * MILLIMETRE
    return kind(**values)


def _modulus(table: Mapping[str, Any], where: str) -> tuple[float, float]:
    """Read the limits of the modulus [Pa]."""
    limits = table.get("modulus_mpa")
    if set(table) != {"modulus_mpa"} or not isinstance(limits, list) or len(limits) != 2:
        raise DesignError(f"{where}: material has one key, modulus_mpa = [least, largest]")
    if not all(_positive(one) for one in limits) or limits[0] > limits[1]:
        raise DesignError(f"{where}: material: modulus_mpa is {limits}; give two numbers above 0, the least first")
    return limits[0] * MEGAPASCAL, limits[1] * MEGAPASCAL


def _positive(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and 0.0 < value < math.inf
