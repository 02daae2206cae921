"""Random samples of a design within its tolerances; equal seeds draw equal samples, however the work is shared."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.units import MICROMETRES
from cycloid_mj.design import Design
from cycloid_mj.design.zone import Zone, parse_zone, wave_zones
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.measured import measured_deviations
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.samples import Samples, identical_samples


@dataclass(frozen=True)
class SamplingSettings:
    """Random streams and batches of a tolerance study; changing the first three changes all draws."""

    block: int = 512
    """Samples drawn from one stream of random numbers per tolerance."""
    budget_stream: int = 1 << 32
    """Number of the random stream of the budget's first set, after those of all blocks; its second set has the next."""
    min_probability: float = 2.0**-54
    """Smallest distance of a uniform random number from 0 and 1, where a normal quantile is infinite."""
    first_batch: int = 200
    """Samples that are balanced before all others, to see whether they jam."""
    max_batch: int = 256
    """Samples that one worker balances at a time at most, so that no worker waits long for the last one."""


SAMPLING = SamplingSettings()


SOURCES = (
    *("mesh", "seat", "cam", "output", "pin_position", "pin_radius", "pin_circle"),
    *("hole_position", "eccentricity", "disc_size", "cam_position"),
)
"""Tolerances, as in the design file; the index of each is the number of its random stream."""

WAVE = "profile_"
"""Prefix of the name of a wave of the profile, before its order."""


def tolerance_zones(reducer: Reducer) -> dict[str, Zone]:
    """Parse the nonzero tolerances of a design to probability distributions by key.

    Waves of the profile have a key for each order. The key of a wave is `WAVE` and its order. The width of an ISO grade
    follows from the diameter of the feature. A tolerance is left out if it is exactly zero. That of ``seat`` is also
    left out if the pins have no play in their seats (`Design.pin_play`).

    Raises
    ------
    DesignError
        A tolerance is not written in one of the `FORMS`.
    """
    design = reducer.design
    tolerance, clearance, ring = design.tolerance, design.clearance, design.ring
    circle_diameter = 2.0 * ring.pin_circle_radius
    fitted_pairs = {
        "mesh": (circle_diameter, getattr(clearance, design.tooth_pair)),
        "seat": (2.0 * ring.pin_radius, design.pin_play),
        "cam": (2.0 * design.gear.bore_radius, clearance.cam),
        "output": (2.0 * design.output.pin_radius, clearance.output),
    }
    sizes = {
        "pin_position": circle_diameter,
        "pin_radius": 2.0 * ring.pin_radius,
        "pin_circle": circle_diameter,
        "hole_position": 2.0 * design.output.pin_circle_radius,
        "eccentricity": 2.0 * design.gear.eccentricity,
        "disc_size": circle_diameter,
        "cam_position": 2.0 * design.gear.eccentricity,
    }
    zones = {
        key: parse_zone(getattr(tolerance, key), key, size, clearance_of_pair)
        for key, (size, clearance_of_pair) in fitted_pairs.items()
    }
    zones |= {key: parse_zone(getattr(tolerance, key), key, size) for key, size in sizes.items()}
    if not design.pin_play:
        zones["seat"] = None
    waves = wave_zones(tolerance.profile, ring.teeth, circle_diameter)
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
    """Split samples into batches that are computed together, of at most `SAMPLING.max_batch` samples of one block.

    A block contains the `SAMPLING.block` samples that are drawn from the same streams of random numbers. The first
    batch has `SAMPLING.first_batch` samples, or all if there are fewer.
    """
    first_count = min(SAMPLING.first_batch, samples, SAMPLING.block)
    batches = [Batch(0, first_count)]
    drawn_count = first_count
    while drawn_count < samples:
        block, offset = divmod(drawn_count, SAMPLING.block)
        count = min(SAMPLING.max_batch, SAMPLING.block - offset, samples - drawn_count)
        batches.append(Batch(block, count, offset))
        drawn_count += count
    return batches


def draw_samples(reducer: Reducer, zones: Mapping[str, Zone], seed: int, batch: Batch) -> Samples:
    """Draw the samples of a batch; `seed` is the random seed of the study, `zones` the tolerances by key."""
    return apply_deviations(
        reducer, identical_samples(reducer, batch.count), draw_deviations(reducer, zones, seed, batch)
    )


def draw_deviations(reducer: Reducer, zones: Mapping[str, Zone], seed: int, batch: Batch) -> dict[str, Array]:
    """Draw the deviations of the samples of a batch from the nominal design [m], by tolerance, shape (samples, ...).

    `zones` are the tolerances by key, `seed` is the random seed. A wave of the profile has the amplitudes of its cosine
    and sine, shape (samples, 2).
    """
    uniform_numbers = _draw_uniform_numbers(reducer, zones, seed, batch)
    deviations = {key: zone.quantiles(uniform_numbers[key]) for key, zone in zones.items()}
    for key in (key for key in zones if key.startswith(WAVE)):
        amplitude, phase = zones[key].quantiles(uniform_numbers[key][:, 0]), 2.0 * np.pi * uniform_numbers[key][:, 1]
        deviations[key] = np.stack([amplitude * np.cos(phase), -amplitude * np.sin(phase)], axis=1)
    return deviations


def _draw_uniform_numbers(reducer: Reducer, zones: Mapping[str, Zone], seed: int, batch: Batch) -> dict[str, Array]:
    """Draw uniform random numbers between 0 and 1 for the samples of a batch, by tolerance, shape (samples, ...).

    `zones` are the tolerances by key. The random stream depends on seed, tolerance and block of samples
    (`list_batches`) only. To start within a block, the numbers of its earlier samples are drawn as well and dropped.
    """
    drawn_count = batch.first + batch.count
    numbers_by_key = {}
    for key in zones:
        block = batch.number if not batch.compared else SAMPLING.budget_stream + (key in batch.second)
        generator = np.random.default_rng([seed, _stream_of(key), block])
        numbers = generator.random((drawn_count, *_shape_of_draws(reducer, key)))[batch.first :]
        numbers_by_key[key] = np.clip(numbers, SAMPLING.min_probability, 1.0 - SAMPLING.min_probability)
    return numbers_by_key


def _stream_of(key: str) -> int:
    return len(SOURCES) + int(key.removeprefix(WAVE)) if key.startswith(WAVE) else SOURCES.index(key)


def _shape_of_draws(reducer: Reducer, key: str) -> tuple[int, ...]:
    """Return the shape of the random numbers of a tolerance for one sample; () for the tolerance of a single dimension.

    `key` is that of the tolerance. The last axis of a position has x and y, that of a profile wave amplitude and phase.
    """
    design = reducer.design
    pin_count, disc_count = design.ring.teeth, design.gear.discs
    shape_by_key = {
        "pin_position": (pin_count, 2),
        "pin_radius": (pin_count,),
        "hole_position": (disc_count, design.output.pins, 2),
    }
    shape_by_key |= {"disc_size": (disc_count,), "cam_position": (disc_count, 2)}
    return (2,) if key.startswith(WAVE) else shape_by_key.get(key, ())


def apply_deviations(reducer: Reducer, nominal: Samples, deviations: Mapping[str, Array]) -> Samples:
    """Return the `nominal` samples with random deviations [m] added; these have shape (samples, ...), by tolerance.

    A deviation of the pin circle moves all pins radially by the same distance, in addition to their position errors.
    Waves of the profile are added to those of the same order.
    """
    renamed_fields = {f"{key}_position": f"{key}_displacement" for key in ("pin", "hole", "cam")} | {
        "disc_size": "disc_radius"
    }
    field_by_key = {key: renamed_fields.get(key, key) for key in SOURCES if key in deviations and key != "pin_circle"}
    changes = {name: getattr(nominal, name) + deviations[key] for key, name in field_by_key.items()}
    if "pin_circle" in deviations:
        radial_directions = profile.unit(profile.pin_angles(reducer.tooth_profile))
        position = changes.get("pin_displacement", nominal.pin_displacement)
        changes["pin_displacement"] = position + deviations["pin_circle"][:, np.newaxis, np.newaxis] * radial_directions
    if waves := [key for key in deviations if key.startswith(WAVE)]:
        changes["waves"] = np.array(nominal.waves)
        for key in waves:
            changes["waves"][:, int(key.removeprefix(WAVE)) - 1] += deviations[key]
    return replace(nominal, **changes)


def deviation_columns(deviations: Mapping[str, Array]) -> dict[str, Array]:
    """Convert the deviations of samples [m] to columns of a table [um], shape (samples,) each, by name.

    `deviations` are arrays by tolerance, shape (samples, ...). Names are ``drawn_cam_um``, or
    ``drawn_hole_position_2_7_x_um`` for hole 7 of disc 2; pins, discs and holes are counted from 1.
    """
    columns = {}
    for key, values in deviations.items():
        coordinates = "xy" if key in ("pin_position", "hole_position", "cam_position") else ""
        for index in np.ndindex(values.shape[1:]):
            if key.startswith(WAVE):
                name_parts = ["cos" if index[0] == 0 else "sin"]
            else:
                name_parts = [str(number + 1) for number in (index[:-1] if coordinates else index)]
                name_parts += [coordinates[index[-1]]] if coordinates else []
            columns["_".join(["drawn", key, *name_parts, "um"])] = MICROMETRES * values[(slice(None), *index)]
    return columns


def has_design_file(reducer: Reducer, samples: Samples) -> Mask:
    """Return which samples can be written as a design file, shape (samples,): those with clearances above 0."""
    clearances = [samples.mesh, samples.cam, samples.output, *([samples.seat] if reducer.design.seat_pair else [])]
    return np.asarray(np.min(clearances, axis=0) > 0.0)


def sample_design(reducer: Reducer, zones: Mapping[str, Zone], seed: int, number: int) -> Design:
    """Draw a sample of a tolerance study again, and return it as a design with its number in its name.

    The design lists the errors of each part, and has the clearances of the sample.

    Parameters
    ----------
    reducer, zones
        Nominal reducer, and its tolerances by key.
    seed, number
        Random seed of the study, and number of the sample from 0.

    Raises
    ------
    DesignError
        A clearance is 0 or less, which a design file cannot have.
    """
    block, row = divmod(number, SAMPLING.block)
    return design_of_sample(
        reducer, draw_samples(reducer, zones, seed, Batch(block, 1, row)), 0, f"{reducer.design.name}-{number + 1}"
    )


def list_omissions(reducer: Reducer, zones: Mapping[str, Zone], excluded: int) -> tuple[str, ...]:
    """Return sentences about what the design files of the worst samples omit.

    `zones` are the tolerances by key. The lobes of an internal gear are cut together, so its file has no errors of
    single lobes. `excluded` is the number of samples that do not jam but have a clearance of 0 or less.
    """
    pin_errors = ("pin_position", "pin_radius", "pin_circle") if reducer.design.ring.kind != "pin" else ()
    omitted = [key for key in pin_errors if key in zones]
    error_text = (
        f"the design files of the worst samples lack {', '.join(omitted)}: an internal gear's file has no such errors"
    )
    sample_text = (
        f"{excluded} samples that do not jam are excluded from the worst: a design file cannot have their clearances "
        "of 0 or less"
    )
    return (*([error_text] if omitted else []), *([sample_text] if excluded else []))


def design_of_sample(reducer: Reducer, samples: Samples, row: int, name: str) -> Design:
    """Return the sample with the index `row` as a design with all its errors and clearances, and without tolerances.

    `samples` are the deviations of all samples. If the ring is an internal gear instead of single pins, the errors of
    single pins are dropped, because its design file has no such errors. `name` becomes the name of the design,
    shortened to 64 characters.

    Raises
    ------
    DesignError
        A design cannot have the values of the sample, such as a clearance of 0.
    """
    clearance, errors = _clearances_and_errors(reducer, samples, row)
    if reducer.design.ring.kind != "pin":
        errors = {key: values for key, values in errors.items() if not key.startswith("pin_")}
    no_tolerances = dict.fromkeys(type(reducer.design.tolerance).model_fields, "")
    return reducer.but(name=name[:64], clearance=clearance, errors=errors, tolerance=no_tolerances).design


def unchecked_design_of_sample(reducer: Reducer, samples: Samples, row: int) -> Design:
    """Return the sample with the index `row` of `samples` as an unvalidated design: clearances may be negative."""
    design = reducer.design
    clearance, errors = _clearances_and_errors(reducer, samples, row)
    return design.model_copy(
        update={
            "clearance": design.clearance.model_copy(update=clearance),
            "errors": design.errors.model_copy(update=errors),
        }
    )


def _clearances_and_errors(reducer: Reducer, samples: Samples, row: int) -> tuple[dict[str, float], dict[str, Any]]:
    """Return the clearances and the manufacturing errors of the sample with the index `row` in `samples`.

    Errors that are all zero are empty tuples. Measured deviations of parts, which the nominal design already has, are
    subtracted from the errors.

    Returns
    -------
    tuple of dict
        Clearances and errors [m], by their keys in the design file.
    """
    design, deviations = reducer.design, measured_deviations(reducer.design)
    pin_errors, hole_errors = (
        samples.pin_displacement[row] - deviations.pin_displacement,
        samples.hole_displacement[row].reshape(-1, 2),
    )
    cam_errors, waves = samples.cam_displacement[row], np.array(samples.waves[row])
    waves[: len(deviations.waves)] -= deviations.waves
    waves = waves[: design.ring.teeth]
    clearance = {design.tooth_pair: samples.mesh[row], "cam": samples.cam[row], "output": samples.output[row]}
    if design.seat_pair:
        clearance[design.seat_pair] = samples.seat[row]
    errors = {
        "pin_x": pin_errors[:, 0],
        "pin_y": pin_errors[:, 1],
        "pin_dr": samples.pin_radius[row] - deviations.pin_radius,
        "hole_x": hole_errors[:, 0],
        "hole_y": hole_errors[:, 1],
        "disc_dr": samples.disc_radius[row] - deviations.disc_radius,
        "cam_x": cam_errors[:, 0],
        "cam_y": cam_errors[:, 1],
        "profile_cos": waves[:, 0],
        "profile_sin": waves[:, 1],
    }
    error_lists: dict[str, Any] = {
        key: tuple(map(float, values)) if np.any(values) else () for key, values in errors.items()
    }
    return (
        {key: float(value) for key, value in clearance.items()},
        {**error_lists, "eccentricity": float(samples.eccentricity[row])},
    )
