"""Interval of the efficiency with the law ``film``: the spread of what a design leaves open, and its main causes.

The inputs vary independently over `RANGES`; a scrambled Sobol sequence with a fixed seed samples them, and the interval
contains 90 % of the outcomes. Causes are ranked by their share of the variance in a linear regression.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.design.lubricants import greased_friction
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.statics.balance import Loads, friction_losses, loads, solve_at_friction
from cycloid_mj.statics.film import DESIGN_INPUTS, FilmInputs, FilmSurfaces, drag_power, drag_torques
from cycloid_mj.statics.springs import Springs, springs_of

SAMPLES, SEED = 128, 58
"""Number of samples, a power of 2 for the Sobol sequence, and their seed."""

PERCENTILES = (5.0, 95.0)
"""Ends of the interval of a spread [%]."""


@dataclass(frozen=True)
class InputRange:
    """Range of an input relative to the design's value, even in its logarithm or in itself, with its reason."""

    name: str
    low: float
    high: float
    reason: str
    logarithmic: bool = True


RANGES: Mapping[str, InputRange] = {
    "boundary": InputRange("boundary friction", 0.73, 1.27, "0.08 to 0.14 for 0.11: greased steel", logarithmic=False),
    "roughness": InputRange("roughness", 0.5, 2.0, "Rq 0.2 to 0.8 um for 0.4: ground, before and after running in"),
    "viscosity": InputRange("viscosity", 0.7, 1.4, "grade +-10 %, +-10 % at 100 °C, ageing, temperature of the film"),
    "play": InputRange("play of the pins' seats", 1.0, 3.0, "pins h3 or 0/-2 um, sockets and sleeves widen by wear"),
    "film": InputRange("film thickness", 0.5, 1.2, "formulas +-20 %; grease starves contacts to half the film"),
    "share": InputRange("load share of the film", 0.75, 1.2, "laws of the asperities' share"),
    "shear": InputRange("shear of the film", 0.67, 1.5, "limiting shear 0.04 to 0.09, Eyring stress 3 to 8 MPa"),
    "load_friction": InputRange("load friction of rollers", 0.6, 1.6, "f1 0.0003 to 0.0008"),
    "idle_friction": InputRange("idle friction of rollers", 0.33, 2.67, "f0 1 to 8"),
    "seals": InputRange("seals", 0.0, 1.5, "from contactless to heavily preloaded seals", logarithmic=False),
}
"""Range of each input of `FilmInputs`: assumed, from the scatter of handbooks and measurements."""


def boundary_range(reducer: Reducer) -> InputRange:
    """Return the range of the boundary friction of greased steel or plastic flanks, as factors on the coefficient.

    For a plastic, it is the range of its greased friction relative to the mean (`lubricants.greased_friction`).
    """
    materials = reducer.design.partners(reducer.design.tooth_pair)
    softer_material = min(materials, key=lambda material: material.youngs_modulus)
    if not softer_material.is_plastic:
        return RANGES["boundary"]
    min_friction, max_friction = greased_friction(softer_material.name)
    mean_friction = 0.5 * (min_friction + max_friction)
    return replace(
        RANGES["boundary"],
        low=min_friction / mean_friction,
        high=max_friction / mean_friction,
        reason=f"{min_friction:g} to {max_friction:g}: greased {softer_material.name}",
    )


@dataclass(frozen=True)
class Spread:
    """A value with its interval.

    Attributes
    ----------
    value, low, high
        Value of the design's own inputs, and 5 and 95 % of the samples.
    causes
        Name of each input and its share of the variance [1], the largest first.
    """

    value: float
    low: float
    high: float
    causes: tuple[tuple[str, float], ...]


@cache
def sample_inputs(
    count: int = SAMPLES, boundary: InputRange = RANGES["boundary"]
) -> tuple[tuple[FilmInputs, ...], Array]:
    """Return samples of the uncertain inputs of the friction law ``film``: a scrambled Sobol sequence, fixed seed.

    There are `count` samples. The inputs are factors such as those on viscosity and roughness. `boundary` is the range
    of the boundary friction coefficient.

    Returns
    -------
    tuple
        The samples, and the position of each input in its range, from 0 to 1, shape (count, inputs). The positions do
        not depend on the ranges.
    """
    from scipy.stats import qmc

    ranges = {**RANGES, "boundary": boundary}
    positions = qmc.Sobol(len(RANGES), seed=SEED).random(count)
    factors = [
        np.exp(np.log(bounds.low) + share * np.log(bounds.high / bounds.low))
        if bounds.logarithmic
        else bounds.low + share * (bounds.high - bounds.low)
        for bounds, share in zip(ranges.values(), positions.T, strict=True)
    ]
    samples = np.stack(factors, axis=1).tolist()
    return tuple(FilmInputs(**dict(zip(RANGES, sample, strict=True))) for sample in samples), positions


def compute_spread(value: float, outcomes: Sequence[float] | Array, positions: Array) -> Spread:
    """Compute the 5 to 95 % interval of a result, and the share of each input in the variance of this result.

    The interval is from the 5th to the 95th percentile of `outcomes`. The shares follow from a linear regression of
    `outcomes` on `positions`.

    Parameters
    ----------
    value
        Result for the nominal inputs, in any unit.
    outcomes
        Results of n samples of the inputs, in the same unit.
    positions
        Position of each input in its range, from 0 to 1, shape (n, inputs), in the order of `RANGES`.
    """
    outcomes = np.asarray(outcomes, float)
    low_outcome, high_outcome = np.percentile(outcomes, PERCENTILES)
    standardised = (positions - positions.mean(axis=0)) / positions.std(axis=0)
    slopes, *_ = np.linalg.lstsq(standardised, outcomes - outcomes.mean(), rcond=None)
    variance_shares = slopes**2 / max(float(outcomes.var()), np.finfo(float).tiny)
    by_share = np.argsort(-variance_shares)
    input_names = [bounds.name for bounds in RANGES.values()]
    return Spread(
        value,
        float(low_outcome),
        float(high_outcome),
        tuple((input_names[index], float(variance_shares[index])) for index in by_share),
    )


@once
def lost_powers(reducer: Reducer, torque: float, samples: int = SAMPLES) -> tuple[float, Array]:
    """Compute the power lost to friction and drag with the friction law ``film``, for the design and for samples.

    A sample has other inputs of the friction law, such as roughness and viscosity (`sample_inputs`). Contact forces are
    solved for the inputs of the design. Their change with the friction of a sample is added to first order.

    Parameters
    ----------
    reducer
        The reducer, with the friction law ``film``.
    torque
        Torque on the output [N m]; if it is negative, the output drives the crank.
    samples
        Number of samples.

    Returns
    -------
    tuple
        Power lost with the inputs of the design [W], and with each sample [W], shape (samples,). Both include the drag
        of crank and output (`film.drag_torques`).

    Raises
    ------
    RunError
        There is no equilibrium, for example because friction jams the reducer.
    """
    springs, sign = springs_of(reducer), float(np.sign(reducer.design.drive.speed))
    contact_torque = sign * (torque + drag_torques(reducer)[1])
    contact_loads = loads(reducer, springs, contact_torque, warm_start=True)
    contacts = _select_loaded_contacts(reducer, springs, contact_loads)
    growth = _compute_loss_growth(reducer, springs, contact_torque, contact_loads)
    return extrapolate_losses(reducer, contacts.lost_power, growth, samples)


def extrapolate_losses(
    reducer: Reducer, contact_power: Callable[[FilmInputs], float], growth: float, samples: int
) -> tuple[float, Array]:
    """Compute the power lost with the friction law ``film`` for samples of its inputs, without new equilibria.

    With the contact powers P of a sample and P0 of the design's own inputs, under the same forces, the sample loses P
    (1 + `growth` (P/P0 - 1)), because the forces change with the friction.

    Parameters
    ----------
    reducer
        The reducer, for the power of its load-independent drag.
    contact_power
        Function from inputs of the law to the friction power of all contacts under the same forces [W].
    growth
        Relative change of the contact forces per relative change of the friction coefficients [1].
    samples
        Number of samples.

    Returns
    -------
    tuple
        Power lost with the inputs of the design [W], and with each sample [W], shape (samples,), both with drag.
    """
    design_loss, powers = contact_power(DESIGN_INPUTS), []
    for inputs in sample_inputs(samples, boundary_range(reducer))[0]:
        sample_loss = contact_power(inputs)
        powers.append(sample_loss * (1.0 + growth * (sample_loss / design_loss - 1.0)) + drag_power(reducer, inputs))
    return design_loss + drag_power(reducer), np.array(powers)


RAISED_FRICTION = 1.1
"""Factor on all friction coefficients that determines how the losses grow with them (heuristic)."""


def _compute_loss_growth(reducer: Reducer, springs: Springs, torque: float, contact_loads: Loads) -> float:
    """Compute how fast the contact forces grow with friction: their relative growth over that of the coefficients [1].

    A second equilibrium is solved with all friction coefficients times k = `RAISED_FRICTION`. With the friction losses
    P and P_k of both, the growth is (P_k/(k P) - 1)/(k - 1), which is 0 if the forces do not change. It is therefore a
    mean over the contacts, weighted by their losses.

    Parameters
    ----------
    reducer, springs
        The reducer with the friction law ``film``, and its contact springs.
    torque
        Torque on the output by the contacts [N m], the sum of load and drag of seals.
    contact_loads
        Equilibrium of the springs under this torque, with its friction coefficients.
    """
    assert contact_loads.friction is not None
    raised_springs = springs.with_friction(contact_loads.friction.scaled(RAISED_FRICTION))
    raised_loads = solve_at_friction(reducer, raised_springs, torque, True, contact_loads)
    design_loss, raised_loss = (
        sum(float(np.mean(power)) for power in friction_losses(reducer, springs, solution).values())
        for solution in (contact_loads, raised_loads)
    )
    return loss_growth(design_loss, raised_loss)


def loss_growth(own_loss: float, raised_loss: float) -> float:
    """Return the relative growth of the contact forces over that of the friction coefficients [1].

    `own_loss` and `raised_loss` are the friction powers [W] with all coefficients times 1 and `RAISED_FRICTION`.
    """
    return (raised_loss / (RAISED_FRICTION * own_loss) - 1.0) / (RAISED_FRICTION - 1.0)


@dataclass(frozen=True, eq=False)
class _LoadedContacts:
    """Contacts that carry load, at all crank angles together, whose friction depends on the inputs of the film law.

    Attributes
    ----------
    surfaces
        Surfaces of the k loaded contact lines with the ring.
    teeth, output, cam
        Normal forces of contact lines, shape (k,), output pins, shape (p,), and cams [N].
    tooth_power, output_power, cam_power
        Friction power at a coefficient of 1 of each contact line, of each output pin, and of all cams, divided by the
        number of crank angles [W].
    """

    surfaces: FilmSurfaces
    teeth: Array
    output: Array
    cam: Array
    tooth_power: Array
    output_power: Array
    cam_power: float

    def lost_power(self, inputs: FilmInputs = DESIGN_INPUTS) -> float:
        """Compute the mean friction power of the loaded contacts [W], for `inputs` of the friction law ``film``."""
        surfaces = replace(self.surfaces, inputs=inputs)
        output_friction = surfaces.output_friction(self.output)
        pin_coefficient = (
            surfaces.reducer.design.friction_of("output") if output_friction is None else output_friction.coefficient
        )
        return float(
            np.sum(surfaces.smaller_friction(self.teeth)[0].coefficient * self.tooth_power)
            + np.sum(pin_coefficient * self.output_power)
            + surfaces.mean_cam_friction(self.cam) * self.cam_power
        )


def _select_loaded_contacts(reducer: Reducer, springs: Springs, contact_loads: Loads) -> _LoadedContacts:
    """Return the contacts that carry load in a solved equilibrium with film friction, with their forces.

    `springs` are the contact springs with the friction coefficients of the film, and `contact_loads` the forces on them
    in equilibrium.
    """
    assert springs.film is not None
    assert contact_loads.friction is not None
    tooth_count = springs.teeth
    loaded_teeth, loaded_pins = contact_loads.teeth > 0.0, contact_loads.output > 0.0
    slip = np.abs(springs.slip) / len(springs.crank)
    unit_friction = replace(contact_loads.friction, contacts=np.ones_like(springs.slip), cam=1.0)
    unit_loads = replace(contact_loads, friction=unit_friction)
    solved_springs = springs.with_friction(contact_loads.friction)
    return _LoadedContacts(
        surfaces=springs.film.displaced(contact_loads.departures).surfaces.select(loaded_teeth),
        teeth=contact_loads.teeth[loaded_teeth],
        output=contact_loads.output[loaded_pins],
        cam=np.linalg.norm(contact_loads.cam, axis=-1),
        tooth_power=(contact_loads.teeth * slip[:, :tooth_count])[loaded_teeth],
        output_power=(contact_loads.output * slip[:, tooth_count:])[loaded_pins],
        cam_power=float(np.mean(friction_losses(reducer, solved_springs, unit_loads)["cam"])),
    )


def back_driving_efficiency_spread(reducer: Reducer, torque: float) -> Spread:
    """Compute the efficiency [%] and its 5 to 95 % interval when the output drives with a positive `torque` [N m].

    The interval follows from samples of the uncertain inputs of the friction law ``film``.

    Raises
    ------
    RunError
        There is no equilibrium, for example because friction jams the reducer.
    """
    input_power = torque * abs(reducer.design.drive.speed) / reducer.design.reduction
    own_loss, sample_losses = lost_powers(reducer, -torque)
    efficiencies = 100.0 * np.maximum(1.0 - sample_losses / input_power, 0.0)
    return compute_spread(100.0 * max(1.0 - own_loss / input_power, 0.0), efficiencies, sample_inputs()[1])
