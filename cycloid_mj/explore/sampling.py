"""Samples of a design within its tolerances, block by block: the same numbers wherever a block is drawn."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.units import MICROMETRES
from cycloid_mj.design import Design
from cycloid_mj.explore.zone import Zone, wave_zones, zone
from cycloid_mj.geometry import profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.samples import Samples, alike

BLOCK = 512
"""Samples that are drawn together. The draws are those of a block of this size."""

PIECE = 256
"""Samples of a piece of work at most: small enough that no worker is left alone with one for long."""

BEGINNING = 200
"""Samples that are balanced before all others, and tell whether there is any that does not jam."""

SOURCES = (
    "mesh",
    "seat",
    "cam",
    "output",
    "pin_position",
    "pin_radius",
    "pin_circle",
    "hole_position",
    "eccentricity",
    "disc_size",
    "cam_position",
)
"""Tolerances, as in the design file; the place of each is that of its stream of random numbers."""

WAVE = "profile_"
"""Start of the name of a wave of the profile; its order follows."""

BUDGET_STREAM = 1 << 32
"""Number of the random stream of the budget's first set, after those of all blocks; its second set has the next."""

_INSIDE = 2.0**-54
"""How near to 0 and 1 a share may be: a normal zone has no ends."""


def tolerances(reducer: Reducer) -> dict[str, Zone]:
    """Collect the zones of a design's tolerances by their keys, those of waves by `WAVE` and order; none that is 0.

    Raises
    ------
    DesignError
        A tolerance is not of a known form.
    """
    design = reducer.design
    tolerance, clearance, ring = design.tolerance, design.clearance, design.ring
    circle = 2.0 * ring.pin_circle_radius
    fits = {
        "mesh": (circle, getattr(clearance, design.tooth_pair)),
        "seat": (2.0 * ring.pin_radius, design.pin_play),
        "cam": (2.0 * design.gear.bore_radius, clearance.cam),
        "output": (2.0 * design.output.pin_radius, clearance.output),
    }
    sizes = {
        "pin_position": circle,
        "pin_radius": 2.0 * ring.pin_radius,
        "pin_circle": circle,
        "hole_position": 2.0 * design.output.pin_circle_radius,
        "eccentricity": 2.0 * design.gear.eccentricity,
        "disc_size": circle,
        "cam_position": 2.0 * design.gear.eccentricity,
    }
    zones = {key: zone(getattr(tolerance, key), key, size, own) for key, (size, own) in fits.items()}
    zones |= {key: zone(getattr(tolerance, key), key, size) for key, size in sizes.items()}
    if not design.pin_play:
        zones["seat"] = None
    waves = wave_zones(tolerance.profile, ring.teeth, circle)
    zones |= {f"{WAVE}{order}": wave for order, wave in waves.items()}
    return {key: zone for key, zone in zones.items() if zone is not None and (zone.width or zone.middle)}


@dataclass(frozen=True)
class Batch:
    """Samples that are drawn and balanced together: a piece of work.

    Attributes
    ----------
    number
        Which block of a set it is.
    count
        How many samples.
    first
        How many samples of the block come before these.
    compared
        Whether they are a set of the error budget; it is drawn from random streams of its own.
    second
        Tolerances that have the values of the budget's second set: all of them, one, or none.
    """

    number: int
    count: int
    first: int = 0
    compared: bool = False
    second: tuple[str, ...] = ()


def blocks(samples: int) -> list[Batch]:
    """List the pieces of work of so many samples: parts of blocks, the first of `BEGINNING` samples."""
    begin = min(BEGINNING, samples, BLOCK)
    pieces = [Batch(0, begin)]
    first = begin
    while first < samples:
        number, offset = divmod(first, BLOCK)
        count = min(PIECE, BLOCK - offset, samples - first)
        pieces.append(Batch(number, count, offset))
        first += count
    return pieces


def drawn(reducer: Reducer, zones: Mapping[str, Zone], seed: int, block: Batch) -> Samples:
    """Draw the samples of a block."""
    return put(reducer, alike(reducer, block.count), departures(reducer, zones, seed, block))


def departures(reducer: Reducer, zones: Mapping[str, Zone], seed: int, block: Batch) -> dict[str, Array]:
    """Draw by how much the samples of a block depart from the design [m], by tolerance, shape (samples, ...).

    A wave has the amplitudes of its cosine and sine, see `Samples.waves`.
    """
    shares = _shares(reducer, zones, seed, block)
    drawn = {key: zone.quantiles(shares[key]) for key, zone in zones.items()}
    for key in (key for key in zones if key.startswith(WAVE)):
        amplitude, begin = zones[key].quantiles(shares[key][:, 0]), 2.0 * np.pi * shares[key][:, 1]
        drawn[key] = np.stack([amplitude * np.cos(begin), -amplitude * np.sin(begin)], axis=1)
    return drawn


def _shares(reducer: Reducer, zones: Mapping[str, Zone], seed: int, block: Batch) -> dict[str, Array]:
    """Compute for each number that is drawn the share of parts that lie below it, by tolerance."""
    whole = block.first + block.count
    shares = {}
    for key in zones:
        number = block.number if not block.compared else BUDGET_STREAM + (key in block.second)
        generator = np.random.default_rng([seed, _stream(key), number])
        shares[key] = _inside(generator.random((whole, *_shape(reducer, key)))[block.first :])
    return shares


def _stream(key: str) -> int:
    return len(SOURCES) + int(key.removeprefix(WAVE)) if key.startswith(WAVE) else SOURCES.index(key)


def _inside(shares: Array) -> Array:
    return np.clip(shares, _INSIDE, 1.0 - _INSIDE)


def _shape(reducer: Reducer, key: str) -> tuple[int, ...]:
    """Compute the shape of the numbers that a tolerance takes for one sample."""
    design = reducer.design
    pins, discs = design.ring.teeth, design.gear.discs
    shapes = {
        "pin_position": (pins, 2),
        "pin_radius": (pins,),
        "hole_position": (discs, design.output.pins, 2),
        "disc_size": (discs,),
        "cam_position": (discs, 2),
    }
    return (2,) if key.startswith(WAVE) else shapes.get(key, ())


def put(reducer: Reducer, same: Samples, changed: Mapping[str, Array]) -> Samples:
    """Add departures to samples that are all alike."""
    fields = {
        "pin_position": "pin_place",
        "hole_position": "hole_place",
        "disc_size": "disc_radius",
        "cam_position": "cam_place",
    }
    parts = {
        fields.get(key, key): getattr(same, fields.get(key, key)) + changed[key]
        for key in SOURCES
        if key in changed and key != "pin_circle"
    }
    if "pin_circle" in changed:
        outwards = profile.unit(profile.pin_angles(reducer.tooth_profile))
        place = parts.get("pin_place", same.pin_place)
        parts["pin_place"] = place + changed["pin_circle"][:, np.newaxis, np.newaxis] * outwards
    if waves := [key for key in changed if key.startswith(WAVE)]:
        parts["waves"] = np.array(same.waves)
        for key in waves:
            parts["waves"][:, int(key.removeprefix(WAVE)) - 1] += changed[key]
    return replace(same, **parts)


def drawn_columns(departures: Mapping[str, Array]) -> dict[str, Array]:
    """Compute what `departures` draws as columns of numbers [um]: ``drawn_cam_um``, ``drawn_pin_position_1_x_um``.

    Pins, discs and holes of a disc (``drawn_hole_position_2_7_x_um``: the seventh of the second) are counted from 1.
    """
    columns = {}
    for key, values in departures.items():
        axes = {"pin_position": "xy", "hole_position": "xy", "cam_position": "xy"}.get(key, "")
        for place in np.ndindex(values.shape[1:]):
            if key.startswith(WAVE):
                parts = ["cos" if place[0] == 0 else "sin"]
            else:
                parts = [str(number + 1) for number in (place[:-1] if axes else place)]
                parts += [axes[place[-1]]] if axes else []
            columns["_".join(["drawn", key, *parts, "um"])] = MICROMETRES * values[(slice(None), *place)]
    return columns


def filed(reducer: Reducer, samples: Samples) -> Mask:
    """Tell of which samples there can be a design file, shape (samples,): clearances there are above 0."""
    listed = [samples.mesh, samples.cam, samples.output, *([samples.seat] if reducer.design.seat_pair else [])]
    return np.asarray(np.min(listed, axis=0) > 0.0)


def sample_design(reducer: Reducer, zones: Mapping[str, Zone], seed: int, number: int) -> Design:
    """Return a sample, counted from 0, as a design with its number in its name.

    Its errors are listed part by part, its clearances are as they came out.

    Raises
    ------
    DesignError
        A clearance came out at 0 or below, which no design file can have.
    """
    block, row = divmod(number, BLOCK)
    return as_design(
        reducer, drawn(reducer, zones, seed, Batch(block, 1, row)), 0, f"{reducer.design.name}-{number + 1}"
    )


def left_out(reducer: Reducer, zones: Mapping[str, Zone], unfiled: int) -> tuple[str, ...]:
    """Tell what the design files of the worst samples leave out: lobes of an internal gear, which are cut together.

    And samples: `unfiled` go together, though a clearance of theirs is at 0 or below.
    """
    lobes = [
        key
        for key in ("pin_position", "pin_radius", "pin_circle")
        if key in zones and reducer.design.ring.kind != "pin"
    ]
    lacking = (
        f"the design files of the worst samples lack {', '.join(lobes)}: an internal gear's file has no such errors"
    )
    others = (
        f"{unfiled} samples that go together are not looked at for the worst: a clearance of 0 or below has no file"
    )
    return (*([lacking] if lobes else []), *([others] if unfiled else []))


def as_design(reducer: Reducer, samples: Samples, row: int, name: str) -> Design:
    """Return one of some samples as a design of its own, with every error listed; DesignError where it can be none."""
    clearance, errors = _parts(reducer, samples, row)
    if reducer.design.ring.kind != "pin":
        errors = {key: values for key, values in errors.items() if not key.startswith("pin_")}
    return reducer.but(
        name=name[:64],
        clearance=clearance,
        errors=errors,
        tolerance=dict.fromkeys(type(reducer.design.tolerance).model_fields, ""),
    ).design


def unchecked_design(reducer: Reducer, samples: Samples, row: int) -> Design:
    """Return the same for geometry alone: its clearances may be negative, and an internal gear's lobes may be off."""
    design = reducer.design
    clearance, errors = _parts(reducer, samples, row)
    return design.model_copy(
        update={
            "clearance": design.clearance.model_copy(update=clearance),
            "errors": design.errors.model_copy(update=errors),
        }
    )


def _parts(reducer: Reducer, samples: Samples, row: int) -> tuple[dict[str, float], dict[str, Any]]:
    """Return the clearances of a sample, and its errors, listed, by their keys in the design's tables."""
    design = reducer.design
    place, holes = samples.pin_place[row], samples.hole_place[row].reshape(-1, 2)
    cams, waves = samples.cam_place[row], samples.waves[row]
    clearance = {design.tooth_pair: samples.mesh[row], "cam": samples.cam[row], "output": samples.output[row]}
    if design.seat_pair:
        clearance[design.seat_pair] = samples.seat[row]
    errors = {
        "pin_x": place[:, 0],
        "pin_y": place[:, 1],
        "pin_dr": samples.pin_radius[row],
        "hole_x": holes[:, 0],
        "hole_y": holes[:, 1],
        "disc_dr": samples.disc_radius[row],
        "cam_x": cams[:, 0],
        "cam_y": cams[:, 1],
        "profile_cos": waves[:, 0],
        "profile_sin": waves[:, 1],
    }
    listed: dict[str, Any] = {key: tuple(map(float, of)) if np.any(of) else () for key, of in errors.items()}
    return (
        {key: float(value) for key, value in clearance.items()},
        {**listed, "eccentricity": float(samples.eccentricity[row])},
    )
