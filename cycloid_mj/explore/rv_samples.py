"""Samples of an RV reducer within its tolerances: transmission error by cranks, bores, planets, output and ring pins.

The closed form of cranks, bores, planets and output is linear in the errors: a sample is a sum of the responses to unit
errors. Errors of the pins add a rotation by statics. The variance of the transmission error at each crank angle is the
sum of those of the tolerances, as these are independent: this is the error budget.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.units import ARCSECOND, MICROMETRES
from cycloid_mj.design import Design
from cycloid_mj.design.rv import CrankErrors
from cycloid_mj.design.zone import Zone, parse_zone
from cycloid_mj.explore.budget import Share
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics.rv_sheet import (
    closed_form_angles,
    closed_rotation,
    largest_mean_force,
    pin_equilibrium,
    solve_rv_equilibrium,
)

FIGURE = "te_errors_arcsec"
"""The figure of the samples."""

RATED_FORCES: Mapping[str, str] = {
    "tooth_force_n": "tooth",
    "crank_bearing_mean_force_n": "crank bearing (10/3-power mean)",
    "planet_mesh_force_n": "planet",
}
"""Figures that rank the samples of a rating, in words."""

ERRORS: Mapping[str, tuple[str, ...]] = {
    "eccentricity": ("eccentric_radial",),
    "phase": ("eccentric_tangential",),
    "bore_position": ("bore_x", "bore_y"),
    "carrier_position": ("carrier_x", "carrier_y"),
    "planet_runout": ("planet_x", "planet_y"),
    "axis_position": ("axis_x", "axis_y"),
    "output_runout": ("output_x", "output_y"),
    "pin_position": ("pin_x", "pin_y"),
}
"""Key of the table [crank_tolerance] -> the errors that it varies, in [errors] for pins, else in [crank_errors]."""

PIN_FIELDS = ERRORS["pin_position"]
"""Errors of the pins' positions along x and y, in the table [errors]."""

BLOCK = 2_000
"""Samples that are evaluated at a time, which bounds the memory."""


@dataclass(frozen=True)
class RvSamples:
    """Samples: values of `FIGURE` [arcsec], drawn deviations [um] by column, error budget, and the worst designs."""

    values: Array
    drawn: Mapping[str, Array]
    budget: tuple[Share, ...]
    worst: tuple[Design, ...]


def crank_zones(reducer: RvReducer) -> dict[str, Zone]:
    """Parse the nonzero tolerances of an RV reducer to distributions by their keys in [crank_tolerance].

    Raises
    ------
    DesignError
        A tolerance is not written in one of the `FORMS`.
    """
    cranks = reducer.cranks
    sizes = {
        "eccentricity": 2.0 * cranks.eccentric_radius,
        "phase": 2.0 * cranks.eccentric_radius,
        "bore_position": 2.0 * reducer.bore_radius,
        "carrier_position": 2.0 * cranks.taper_radius,
        "planet_runout": reducer.planet.module * reducer.planet.planet_teeth,
        "axis_position": 2.0 * reducer.design.ring.pin_circle_radius,
        "output_runout": 2.0 * reducer.output_radius,
        "pin_position": 2.0 * reducer.design.ring.pin_circle_radius,
    }
    texts = {key: getattr(reducer.crank_tolerance, key) for key in ERRORS}
    zones_by_key = {key: parse_zone(text, key, sizes[key], table="crank_tolerance") for key, text in texts.items()}
    return {key: parsed_zone for key, parsed_zone in zones_by_key.items() if parsed_zone}


def draw_rv_drive(reducer: RvReducer, seed: int, number: int) -> tuple[Design, dict[str, float]]:
    """Draw one random drive within the tolerances: its design with the errors of its parts, and these errors [um].

    The errors have keys such as ``drawn_bore_x_1_um``. Equal seeds and numbers draw equal drives.

    Raises
    ------
    DesignError
        A tolerance has a wrong form.
    """
    rng, deviations = np.random.default_rng([seed, number]), dict[str, Array]()
    for key, zone in crank_zones(reducer).items():
        columns = (column for field in ERRORS[key] for column in _columns_of_field(reducer, field))
        deviations |= {column: zone.quantiles(rng.random(1)) for column in columns}
    errors = {f"drawn_{column}_um": MICROMETRES * float(values[0]) for column, values in deviations.items()}
    return reducer.design.but(**_errors_of_sample(reducer, deviations, 0)), errors


def compute_rv_forces(reducer: RvReducer, samples: int, seed: int, angles: int) -> dict[str, Array]:
    """Compute the largest forces [N] of drives within the tolerances at the rated torque, without friction.

    Sample number k is the drive of `draw_rv_drive` with the number k, from 0.

    Parameters
    ----------
    reducer
        Nominal reducer.
    samples, seed
        Number of samples, and random seed.
    angles
        Number of crank angles over a turn of the carrier.

    Returns
    -------
    dict
        Forces, shape (samples,) each: the largest force of a pin (``tooth_force_n``), the largest 10/3-power mean of a
        crank bearing (``crank_bearing_mean_force_n``), and the largest force of a planet (``planet_mesh_force_n``).

    Raises
    ------
    DesignError
        The text of a tolerance is not valid.
    RunError
        A sample has no static equilibrium.
    """
    torque, force_rows = reducer.design.rated_torque, []
    for number in range(samples):
        sample = RvReducer(draw_rv_drive(reducer, seed, number)[0])
        loads = solve_rv_equilibrium(sample, torque, angles)
        force_rows.append([float(loads.pins.max()), largest_mean_force(loads.bearings), float(loads.flanks.max())])
    return dict(zip(RATED_FORCES, np.array(force_rows).T, strict=True))


def draw_rv_samples(reducer: RvReducer, samples: int, seed: int, worst: int) -> RvSamples:
    """Draw random samples of an RV reducer within its tolerances, with their transmission errors and error budget.

    The budget has the share of each tolerance in the variance of the transmission error over the turn. Shares of linear
    responses are exact; that of the pins is a mean over the samples. First-order and total index are equal, as
    tolerances add up, and the intervals have no width.

    Parameters
    ----------
    reducer, samples, seed, worst
        Nominal reducer, number of samples, random seed, and number of designs to return, those of the largest error.

    Raises
    ------
    UsageError
        The design has no tolerances.
    DesignError
        The text of a tolerance is not valid.
    """
    zones, rng = crank_zones(reducer), np.random.default_rng(seed)
    if not zones:
        raise UsageError(
            f"the design {reducer.design.name!r} has no tolerances: set at least one in the table [crank_tolerance], "
            "e.g. --set 'crank_tolerance.bore_position=\"uniform 4\"'"
        )
    nominal_rotation, responses = closed_rotation(reducer), dict[str, Array]()
    deviations, variances = dict[str, Array](), dict[str, float]()
    for key, zone_of_key in zones.items():
        fields = [field for field in ERRORS[key] if field not in PIN_FIELDS]
        responses_of_key = {
            column: response
            for field in fields
            for column, response in _compute_responses(reducer, field, nominal_rotation).items()
        }
        columns = [column for field in ERRORS[key] for column in _columns_of_field(reducer, field)]
        deviations |= {column: zone_of_key.quantiles(rng.random(samples)) for column in columns}
        variances[key] = zone_of_key.standard_deviation**2 * sum(
            float(np.var(response)) for response in responses_of_key.values()
        )
        responses |= responses_of_key
    pin_rotations = _rotations_by_pins(reducer, deviations, samples)
    if "pin_position" in zones:
        variances["pin_position"] = float(np.mean(np.var(pin_rotations, axis=1)))
    linear_deviations = np.array([deviations[column] for column in responses]).reshape(len(responses), samples)
    linear_responses = np.array(list(responses.values())).reshape(len(responses), nominal_rotation.size)
    peak_to_peak_errors = (
        _transmission_errors(reducer, nominal_rotation, linear_responses, linear_deviations, pin_rotations) / ARCSECOND
    )
    total_variance = sum(variances.values())
    share_of_key = {key: variance / total_variance if total_variance else 0.0 for key, variance in variances.items()}
    worst_rows = np.argsort(-peak_to_peak_errors)[:worst]
    return RvSamples(
        values=peak_to_peak_errors,
        drawn={column: MICROMETRES * deviation for column, deviation in deviations.items()},
        budget=tuple(
            Share(key, share_of_key[key], share_of_key[key], (share_of_key[key], share_of_key[key]))
            for key in sorted(share_of_key, key=lambda key: -share_of_key[key])
        ),
        worst=tuple(_design_of_sample(reducer, deviations, int(row), rank) for rank, row in enumerate(worst_rows, 1)),
    )


def _rotations_by_pins(reducer: RvReducer, deviations: Mapping[str, Array], samples: int) -> Array:
    """Compute the rotation of the output by position errors of the pins of each sample [rad], shape (samples, m).

    `deviations` are the errors of all samples [m], shape (samples,), by column; the errors of the nominal reducer are
    added to them. m is the number of angles of a `PinErrorEquilibrium`; it is 0 without errors of pins.
    """
    nominal_displacements = reducer.deviations.pin_displacement
    columns = [_columns_of_field(reducer, field) for field in PIN_FIELDS]
    if columns[0][0] not in deviations:
        if not nominal_displacements.any():
            return np.zeros((samples, 0))
        return np.repeat(pin_equilibrium(reducer).rotation(nominal_displacements)[np.newaxis], samples, axis=0)
    drawn_displacements = np.stack(
        [np.stack([deviations[name] for name in names], axis=1) for names in columns], axis=2
    )
    equilibrium = pin_equilibrium(reducer)
    return np.stack(
        [equilibrium.rotation(nominal_displacements + displacements) for displacements in drawn_displacements]
    )


def _transmission_errors(
    reducer: RvReducer, nominal: Array, responses: Array, deviations: Array, pin_rotations: Array
) -> Array:
    """Compute the peak-to-peak transmission error of each sample [rad], shape (samples,).

    Parameters
    ----------
    reducer
        Nominal reducer.
    nominal
        Deviation of the nominal reducer's output angle from the ideal angle at m angles of a turn [rad], shape (m,),
        without errors of pins.
    responses
        Change of this deviation by each of n errors of parts [rad/m], shape (n, m).
    deviations
        Errors of parts of each sample [m], shape (n, samples).
    pin_rotations
        Rotation by errors of the pins of each sample, as `_rotations_by_pins` returns it.
    """
    crank_angles, values = closed_form_angles(reducer), []
    for start in range(0, deviations.shape[1], BLOCK):
        errors = deviations[:, start : start + BLOCK].T @ responses + nominal
        if pin_rotations.size:
            equilibrium = pin_equilibrium(reducer)
            errors += [
                equilibrium.interpolate(rotation, crank_angles) for rotation in pin_rotations[start : start + BLOCK]
            ]
        values.append(np.ptp(errors, axis=1))
    return np.concatenate(values)


def _compute_responses(reducer: RvReducer, field: str, nominal: Array) -> dict[str, Array]:
    """Compute the change of the output angle per unit of each error in a list of errors [rad/m], shape (m,) each.

    `field` is the list, a field of `CrankErrors` such as ``bore_x``. `nominal` is the output angle without additional
    errors [rad] at m angles of a turn, shape (m,). Keys are the name of the field, or for several errors ``bore_x_1``,
    ``bore_x_2`` and so on.
    """
    list_length, increment = _list_length(reducer, field), 1.0 / MICROMETRES
    responses = {}
    for position, name in enumerate(_columns_of_field(reducer, field)):
        values = np.array(_errors_of_field(reducer, field))
        values[position] += increment
        perturbed_reducer = reducer.but(
            crank_errors={field: tuple(values.tolist()) if list_length else float(values[0])}
        )
        responses[name] = (closed_rotation(perturbed_reducer) - nominal) / increment
    return responses


def _columns_of_field(reducer: RvReducer, field: str) -> list[str]:
    """Return the names of a field's columns: the field, with a number from 1 for the entries of a list."""
    length = _list_length(reducer, field)
    return [f"{field}_{number}" for number in range(1, length + 1)] if length else [field]


def _list_length(reducer: RvReducer, field: str) -> int:
    """Return how many values the list `field` of manufacturing errors, such as ``bore_x``, needs in the design.

    There is a value for each ring pin, for each crank, or for each crank and disc. The result is 0 if `field` is a
    single number instead of a list.
    """
    if field in PIN_FIELDS:
        return reducer.design.ring.teeth
    if isinstance(CrankErrors.model_fields[field].default, float):
        return 0
    is_per_disc = field.startswith(("eccentric", "bore"))
    return reducer.cranks.count * (len(reducer.phases) if is_per_disc else 1)


def _errors_of_field(reducer: RvReducer, field: str) -> list[float]:
    """Return the manufacturing errors that the nominal design has in the list `field` [m], zeros for an empty list.

    `field` is a name such as ``bore_x``; if it is a single number, the result has one item.
    For positions of pins they include the errors that the design itself draws at random.
    """
    if field in PIN_FIELDS:
        return list(reducer.deviations.pin_displacement[:, PIN_FIELDS.index(field)].tolist())
    values = getattr(reducer.crank_errors, field)
    if isinstance(values, float):
        return [values]
    return list(values) or [0.0] * _list_length(reducer, field)


def _design_of_sample(reducer: RvReducer, deviations: Mapping[str, Array], row: int, rank: int) -> Design:
    """Return the sample with the index `row` as a design, whose name ends in ``-worst-`` and the number `rank`."""
    errors = _errors_of_sample(reducer, deviations, row)
    return reducer.design.but(name=f"{reducer.design.name}-worst-{rank}", **errors)


def _errors_of_sample(
    reducer: RvReducer, deviations: Mapping[str, Array], row: int
) -> dict[str, dict[str, float | tuple[float, ...]]]:
    """Return the errors of one sample [m] as changes of the design file: by name of the table, then by key.

    An error of a part is that of the nominal reducer plus the random deviation of the sample. A key with a value for
    each bore, eccentric or pin has a tuple. `deviations` are the random deviations of all samples [m] by names such as
    ``bore_x_1``, shape (samples,) each. `row` is the index of the sample.
    """
    changes: dict[str, dict[str, float | tuple[float, ...]]] = {"crank_errors": {}, "errors": {}}
    for field in (field for fields in ERRORS.values() for field in fields):
        names = _columns_of_field(reducer, field)
        if names[0] in deviations:
            values = [
                nominal + float(deviations[name][row])
                for nominal, name in zip(_errors_of_field(reducer, field), names, strict=True)
            ]
            table = changes["errors" if field in PIN_FIELDS else "crank_errors"]
            table[field] = tuple(values) if _list_length(reducer, field) else values[0]
    return changes
