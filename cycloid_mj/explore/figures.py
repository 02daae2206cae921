"""The figures of a sample that has tolerances, by statics: play, transmission error, wind-up, forces."""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cycloid_mj.base.types import Array
from cycloid_mj.base.units import ARCMINUTE, ARCSECONDS
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.samples import SampleFigures, Samples, backlash, solve_samples

ANGLES = 360
"""Crank angles at which every sample is balanced."""

TOUCH = 1e-4
"""Torque that brings the parts to a stop, as a share of the rated one: it winds up 0.2 % of the backlash at most."""

STANDING = 1e-9
"""Speed of the crank as a share of its own: too slow for the gear's centrifugal force."""

State = Literal["ahead", "back", "loaded"]
STATES: dict[State, float] = {"ahead": TOUCH, "back": -TOUCH, "loaded": 1.0}
"""Torque on the output in each state, as a share of the rated one."""


@dataclass(frozen=True)
class Figure:
    """A figure: its `name` in words, its `unit`, the `states` that it takes, and its `value` of them [unit]."""

    name: str
    unit: str
    states: tuple[State, ...]
    value: Callable[..., Array]


FIGURES = {
    "backlash_arcmin": Figure(
        "backlash of the output, mean",
        "arcmin",
        ("ahead", "back"),
        lambda ahead, back: backlash(ahead, back) / ARCMINUTE,
    ),
    "te_loaded_arcsec": Figure(
        "transmission error of the output, peak to peak, loaded",
        "arcsec",
        ("loaded",),
        lambda loaded: ARCSECONDS * loaded.output_range,
    ),
    "te_unloaded_arcsec": Figure(
        "transmission error of the output, peak to peak, unloaded",
        "arcsec",
        ("ahead",),
        lambda ahead: ARCSECONDS * ahead.output_range,
    ),
    "wind_up_arcmin": Figure(
        "turn of the output, loaded less unloaded, mean",
        "arcmin",
        ("ahead", "loaded"),
        lambda ahead, loaded: (loaded.output_mean - ahead.output_mean) / ARCMINUTE,
    ),
    "tooth_force_n": Figure("largest force on a tooth", "N", ("loaded",), lambda loaded: loaded.tooth),
    "output_pin_force_n": Figure("largest force on an output pin", "N", ("loaded",), lambda loaded: loaded.output_pin),
    "cam_force_n": Figure("largest force of the cam", "N", ("loaded",), lambda loaded: loaded.cam),
    "loaded_teeth": Figure("teeth that carry, on average", "1", ("loaded",), lambda loaded: loaded.carrying),
    "preload_n": Figure(
        "largest force on a tooth, unloaded",
        "N",
        ("ahead", "back"),
        lambda ahead, back: np.maximum(ahead.tooth, back.tooth),
    ),
    "output_preload_n": Figure(
        "largest force on an output pin, unloaded",
        "N",
        ("ahead", "back"),
        lambda ahead, back: np.maximum(ahead.output_pin, back.output_pin),
    ),
    "cam_preload_n": Figure(
        "largest force of the cam, unloaded",
        "N",
        ("ahead", "back"),
        lambda ahead, back: np.maximum(ahead.cam, back.cam),
    ),
}
"""Every figure by its key; a unit that is not SI ends the key. A sample without a balance has none: NaN."""


def figures_of(
    reducer: Reducer, made: Samples, keys: Collection[str] = FIGURES, angles: int = ANGLES
) -> dict[str, Array]:
    """Compute figures of samples by their keys, shape (samples,) each: without friction, weight and inertia."""
    still = {"gravity_x": 0.0, "gravity_y": 0.0}
    bare = reducer.but(environment=still, drive={"speed": STANDING * reducer.design.drive.speed})
    needed = [state for state in STATES if any(state in FIGURES[key].states for key in keys)]
    torques = [STATES[state] * reducer.design.rated_torque for state in needed]
    solved: dict[State, SampleFigures] = dict(zip(needed, solve_samples(bare, made, torques, angles), strict=True))
    return {key: FIGURES[key].value(*(solved[state] for state in FIGURES[key].states)) for key in keys}


def condition(reducer: Reducer) -> str:
    """Tell under what the figures hold."""
    return (
        f"statics without friction and weight, parts rigid but for their contacts, over a turn of the crank; loaded: "
        f"{reducer.design.rated_torque:.4g} N m on the output, unloaded: {TOUCH:g} of that"
    )
