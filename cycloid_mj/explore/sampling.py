"""Random samples of a design within its tolerances; equal seeds draw equal samples, however the work is shared."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.units import MICROMETRES
from cycloid_mj.design import Design
from cycloid_mj.explore.zone import Zone, wave_zones, zone
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.measured import measured_deviations
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.samples import Samples, identical_samples

BLOCK_SAMPLES = 512
"""Samples drawn from one stream of random numbers per tolerance; changing this changes all draws."""


FIRST_BATCH = 200
"""Samples that are balanced before all others, to see whether they jam."""

SOURCES = (
    *("mesh", "seat", "cam", "output", "pin_position", "pin_radius", "pin_circle"),
    *("hole_position", "eccentricity", "disc_size", "cam_position"),
)
"""Tolerances, as in the design file; the index of each is the number of its random stream."""

WAVE = "profile_"
"""Prefix of the name of a wave of the profile, before its order."""

BUDGET_STREAM = 1 << 32
"""Number of the random stream of the budget's first set, after those of all blocks; its second set has the next."""

_INSIDE = 2.0**-54
"""Smallest distance of a share from 0 and 1, where a normal quantile is infinite."""


def tolerance_zones(reducer: Reducer) -> dict[str, Zone]:
    """Collect the nonzero zones of a design's tolerances by their keys, those of waves by `WAVE` and order.

    Raises
    ------
    DesignError
        A tolerance does not have a known form.
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
    """Samples that are drawn and balanced together."""

    number: int
    """Number of their block."""
    count: int
    """Number of samples."""
    first: int = 0
    """Number of samples of the block before these."""
    compared: bool = False
    """Whether they are a set of the error budget; it is drawn from random streams of its own."""
    second: tuple[str, ...] = ()
    """Tolerances that have the values of the budget's second set: all of them, one, or none."""


def list_batches(samples: int) -> list[Batch]:
    """List the batches of so many samples, the first of `FIRST_BATCH` samples; no batch spans two blocks."""
    begin = min(FIRST_BATCH, samples, BLOCK_SAMPLES)
    pieces = [Batch(0, begin)]
    first = begin
    while first < samples:
        number, offset = divmod(first, BLOCK_SAMPLES)
        # so that no worker waits long for the last one
        count = min(256, BLOCK_SAMPLES - offset, samples - first)
        pieces.append(Batch(number, count, offset))
        first += count
    return pieces


def draw_samples(reducer: Reducer, zones: Mapping[str, Zone], seed: int, batch: Batch) -> Samples:
    """Draw the samples of a batch."""
    return apply_departures(
        reducer, identical_samples(reducer, batch.count), draw_departures(reducer, zones, seed, batch)
    )


def draw_departures(reducer: Reducer, zones: Mapping[str, Zone], seed: int, batch: Batch) -> dict[str, Array]:
    """Draw the departures of the samples of a batch from the design [m], by tolerance, shape (samples, ...).

    Those of a wave are the amplitudes of its cosine and sine, see `Samples.waves`.
    """
    shares = _draw_shares(reducer, zones, seed, batch)
    departures = {key: zone.quantiles(shares[key]) for key, zone in zones.items()}
    for key in (key for key in zones if key.startswith(WAVE)):
        amplitude, phase = zones[key].quantiles(shares[key][:, 0]), 2.0 * np.pi * shares[key][:, 1]
        departures[key] = np.stack([amplitude * np.cos(phase), -amplitude * np.sin(phase)], axis=1)
    return departures


def _draw_shares(reducer: Reducer, zones: Mapping[str, Zone], seed: int, batch: Batch) -> dict[str, Array]:
    """Draw uniform numbers from 0 to 1, by tolerance, shape (samples, ...)."""
    end = batch.first + batch.count
    shares = {}
    for key in zones:
        number = batch.number if not batch.compared else BUDGET_STREAM + (key in batch.second)
        generator = np.random.default_rng([seed, _stream(key), number])
        shares[key] = _inside(generator.random((end, *_shape(reducer, key)))[batch.first :])
    return shares


def _stream(key: str) -> int:
    return len(SOURCES) + int(key.removeprefix(WAVE)) if key.startswith(WAVE) else SOURCES.index(key)


def _inside(shares: Array) -> Array:
    return np.clip(shares, _INSIDE, 1.0 - _INSIDE)


def _shape(reducer: Reducer, key: str) -> tuple[int, ...]:
    """Return the shape of the random numbers of a tolerance for one sample."""
    design = reducer.design
    pins, discs = design.ring.teeth, design.gear.discs
    shapes = {"pin_position": (pins, 2), "pin_radius": (pins,), "hole_position": (discs, design.output.pins, 2)}
    shapes |= {"disc_size": (discs,), "cam_position": (discs, 2)}
    return (2,) if key.startswith(WAVE) else shapes.get(key, ())


def apply_departures(reducer: Reducer, nominal: Samples, changed: Mapping[str, Array]) -> Samples:
    """Return samples of the nominal design with departures [m] added, by tolerance, shape (samples, ...)."""
    fields = {f"{key}_position": f"{key}_place" for key in ("pin", "hole", "cam")} | {"disc_size": "disc_radius"}
    names = {key: fields.get(key, key) for key in SOURCES if key in changed and key != "pin_circle"}
    parts = {name: getattr(nominal, name) + changed[key] for key, name in names.items()}
    if "pin_circle" in changed:
        outwards = profile.unit(profile.pin_angles(reducer.tooth_profile))
        position = parts.get("pin_place", nominal.pin_place)
        parts["pin_place"] = position + changed["pin_circle"][:, np.newaxis, np.newaxis] * outwards
    if waves := [key for key in changed if key.startswith(WAVE)]:
        parts["waves"] = np.array(nominal.waves)
        for key in waves:
            parts["waves"][:, int(key.removeprefix(WAVE)) - 1] += changed[key]
    return replace(nominal, **parts)


def departure_columns(departures: Mapping[str, Array]) -> dict[str, Array]:
    """Convert `departures` [m] to columns of numbers [um]: ``drawn_cam_um``, ``drawn_pin_position_1_x_um``.

    Pins, discs and holes of a disc (``drawn_hole_position_2_7_x_um``: the seventh of the second) are counted from 1.
    """
    columns = {}
    for key, values in departures.items():
        axes = {"pin_position": "xy", "hole_position": "xy", "cam_position": "xy"}.get(key, "")
        for index in np.ndindex(values.shape[1:]):
            if key.startswith(WAVE):
                parts = ["cos" if index[0] == 0 else "sin"]
            else:
                parts = [str(number + 1) for number in (index[:-1] if axes else index)]
                parts += [axes[index[-1]]] if axes else []
            columns["_".join(["drawn", key, *parts, "um"])] = MICROMETRES * values[(slice(None), *index)]
    return columns


def has_design_file(reducer: Reducer, samples: Samples) -> Mask:
    """Return which samples can be written as a design file, shape (samples,): those with clearances above 0."""
    clearances = [samples.mesh, samples.cam, samples.output, *([samples.seat] if reducer.design.seat_pair else [])]
    return np.asarray(np.min(clearances, axis=0) > 0.0)


def sample_design(reducer: Reducer, zones: Mapping[str, Zone], seed: int, number: int) -> Design:
    """Return a sample, counted from 0, as a design with its number in its name.

    The design lists the errors of each part, and has the clearances of the sample.

    Raises
    ------
    DesignError
        A clearance is 0 or less, which a design file cannot have.
    """
    block, row = divmod(number, BLOCK_SAMPLES)
    return design_of_sample(
        reducer, draw_samples(reducer, zones, seed, Batch(block, 1, row)), 0, f"{reducer.design.name}-{number + 1}"
    )


def list_omissions(reducer: Reducer, zones: Mapping[str, Zone], unfiled: int) -> tuple[str, ...]:
    """List in sentences what the design files of the worst samples omit.

    An internal gear's lobes are cut together, so its file has no errors of single lobes. `unfiled` samples do not jam,
    but have a clearance of 0 or less.
    """
    of_pins = ("pin_position", "pin_radius", "pin_circle") if reducer.design.ring.kind != "pin" else ()
    lobes = [key for key in of_pins if key in zones]
    errors = (
        f"the design files of the worst samples lack {', '.join(lobes)}: an internal gear's file has no such errors"
    )
    samples = (
        f"{unfiled} samples that do not jam are excluded from the worst: a design file cannot have their clearances of "
        "0 or less"
    )
    return (*([errors] if lobes else []), *([samples] if unfiled else []))


def design_of_sample(reducer: Reducer, samples: Samples, row: int, name: str) -> Design:
    """Return a sample as a design with all its errors; raise DesignError where a design cannot have its values."""
    clearance, errors = _parts(reducer, samples, row)
    if reducer.design.ring.kind != "pin":
        errors = {key: values for key, values in errors.items() if not key.startswith("pin_")}
    none = dict.fromkeys(type(reducer.design.tolerance).model_fields, "")
    return reducer.but(name=name[:64], clearance=clearance, errors=errors, tolerance=none).design


def unchecked_design_of_sample(reducer: Reducer, samples: Samples, row: int) -> Design:
    """Return a sample as a design for geometry only: clearances may be negative, and lobes of an internal gear off."""
    design = reducer.design
    clearance, errors = _parts(reducer, samples, row)
    return design.model_copy(
        update={
            "clearance": design.clearance.model_copy(update=clearance),
            "errors": design.errors.model_copy(update=errors),
        }
    )


def _parts(reducer: Reducer, samples: Samples, row: int) -> tuple[dict[str, float], dict[str, Any]]:
    """Return the clearances and the errors of a sample, by their keys in the design; measured parts stay apart."""
    design, measured = reducer.design, measured_deviations(reducer.design)
    pins, holes = samples.pin_place[row] - measured.pin_place, samples.hole_place[row].reshape(-1, 2)
    cams, waves = samples.cam_place[row], np.array(samples.waves[row])
    waves[: len(measured.waves)] -= measured.waves
    waves = waves[: design.ring.teeth]
    clearance = {design.tooth_pair: samples.mesh[row], "cam": samples.cam[row], "output": samples.output[row]}
    if design.seat_pair:
        clearance[design.seat_pair] = samples.seat[row]
    errors = {
        "pin_x": pins[:, 0],
        "pin_y": pins[:, 1],
        "pin_dr": samples.pin_radius[row] - measured.pin_radius,
        "hole_x": holes[:, 0],
        "hole_y": holes[:, 1],
        "disc_dr": samples.disc_radius[row] - measured.disc_radius,
        "cam_x": cams[:, 0],
        "cam_y": cams[:, 1],
        "profile_cos": waves[:, 0],
        "profile_sin": waves[:, 1],
    }
    listed: dict[str, Any] = {
        key: tuple(map(float, values)) if np.any(values) else () for key, values in errors.items()
    }
    return (
        {key: float(value) for key, value in clearance.items()},
        {**listed, "eccentricity": float(samples.eccentricity[row])},
    )
