"""Figures that are balanced for many samples of a reducer at a time: play, transmission error, wind-up, forces.

They are those of rigid parts on elastic contacts, without friction and weight; of a reducer itself they are those of
one sample that is made as its design says.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.units import ARCMINUTE, ARCSECONDS
from cycloid_mj.figures.figure import Figure, Need
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.statics.samples import SampleFigures, Samples, alike, backlash, solve_samples

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
class Sampled:
    """The `states` that a figure takes of samples, and its `value` of them in its unit, shape (samples,)."""

    states: tuple[State, ...]
    value: Callable[..., Array]


BACKLASH = Sampled(("ahead", "back"), lambda ahead, back: backlash(ahead, back) / ARCMINUTE)
"""The backlash of samples: their balance under `TOUCH` is within 0.2 % of the one that torque leads to at zero."""


def solved(
    reducer: Reducer, samples: Samples, states: Collection[State], angles: int = ANGLES
) -> dict[State, SampleFigures]:
    """Balance samples in some of `STATES`: without friction, weight and inertia."""
    still = {"gravity_x": 0.0, "gravity_y": 0.0}
    bare = reducer.but(environment=still, drive={"speed": STANDING * reducer.design.drive.speed})
    ordered = [state for state in STATES if state in states]
    torques = [STATES[state] * reducer.design.rated_torque for state in ordered]
    return dict(zip(ordered, solve_samples(bare, samples, torques, angles), strict=True))


def condition(reducer: Reducer) -> str:
    """State under what the figures of samples hold."""
    return (
        f"statics without friction and weight, parts rigid but for their contacts, over a turn of the crank; loaded: "
        f"{reducer.design.rated_torque:.4g} N m on the output, unloaded: {TOUCH:g} of that"
    )


@once
def _as_designed(reducer: Reducer, state: State) -> SampleFigures:
    return solved(reducer, alike(reducer, 1), [state])[state]


def _figure(key: str, name: str, unit: str, definition: str, sampled: Sampled) -> Figure:
    """Make the row of a figure whose value is that of one sample."""

    def compute(reducer: Reducer) -> float:
        return float(sampled.value(*(_as_designed(reducer, state) for state in sampled.states))[0])

    return Figure(
        key=key, name=name, unit=unit, definition=definition, need=Need.STATICS, function=compute, sampled=sampled
    )


_RATED = "under the nominal torque, without friction, over a turn of the crank"
_UNLOADED = f"under {TOUCH:g} of the nominal torque, without friction, over a turn of the crank"

OF_SAMPLES = (
    _figure(
        "te_loaded_arcsec",
        "transmission error of the output, peak to peak, loaded",
        "arcsec",
        f"Range of the output's angle about the ideal one {_RATED}.",
        Sampled(("loaded",), lambda loaded: ARCSECONDS * loaded.output_range),
    ),
    _figure(
        "te_unloaded_arcsec",
        "transmission error of the output, peak to peak, unloaded",
        "arcsec",
        f"Range of the output's angle about the ideal one {_UNLOADED}.",
        Sampled(("ahead",), lambda ahead: ARCSECONDS * ahead.output_range),
    ),
    _figure(
        "wind_up_arcmin",
        "turn of the output, loaded less unloaded, mean",
        "arcmin",
        "How far the nominal torque turns the output at a locked crank, from contact without load: mean of a turn, "
        "without friction.",
        Sampled(("ahead", "loaded"), lambda ahead, loaded: (loaded.output_mean - ahead.output_mean) / ARCMINUTE),
    ),
    _figure(
        "tooth_force_n",
        "largest force on a tooth",
        "N",
        f"Largest normal force of one contact between gear and ring {_RATED}.",
        Sampled(("loaded",), lambda loaded: loaded.tooth),
    ),
    _figure(
        "output_pin_force_n",
        "largest force on an output pin",
        "N",
        f"Largest normal force of one disc on one output pin {_RATED}.",
        Sampled(("loaded",), lambda loaded: loaded.output_pin),
    ),
    _figure(
        "cam_force_n",
        "largest force of the cam",
        "N",
        f"Largest force of one cam on its disc {_RATED}.",
        Sampled(("loaded",), lambda loaded: loaded.cam),
    ),
    _figure(
        "loaded_teeth",
        "teeth that carry, on average",
        "1",
        f"Contacts of all discs with the ring that carry 1 % of the largest force or more {_RATED}: their mean.",
        Sampled(("loaded",), lambda loaded: loaded.carrying),
    ),
    _figure(
        "preload_n",
        "largest force on a tooth, unloaded",
        "N",
        f"Largest normal force of one contact between gear and ring, to either side, {_UNLOADED}.",
        Sampled(("ahead", "back"), lambda ahead, back: np.maximum(ahead.tooth, back.tooth)),
    ),
    _figure(
        "output_preload_n",
        "largest force on an output pin, unloaded",
        "N",
        f"Largest normal force of one disc on one output pin, to either side, {_UNLOADED}.",
        Sampled(("ahead", "back"), lambda ahead, back: np.maximum(ahead.output_pin, back.output_pin)),
    ),
    _figure(
        "cam_preload_n",
        "largest force of the cam, unloaded",
        "N",
        f"Largest force of one cam on its disc, to either side, {_UNLOADED}.",
        Sampled(("ahead", "back"), lambda ahead, back: np.maximum(ahead.cam, back.cam)),
    ),
)
