"""Figures computed for many samples of a reducer at a time: backlash, transmission error, wind-up, forces.

Parts are rigid with elastic contacts, without friction and weight. The figure of a reducer is that of a single sample
without random deviations.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.units import ARCMINUTE, ARCSECONDS
from cycloid_mj.figures.figure import Figure, Need
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.statics.samples import SampleFigures, Samples, backlash, identical_samples, solve_samples

ANGLES = 360
"""Crank angles at which every sample is solved (heuristic)."""

TOUCH = 1e-4
"""Torque that moves the parts to a stop, over the nominal torque: its wind-up is at most 0.2 % of the backlash."""

CREEP_SHARE = 1e-9
"""Crank speed at which samples are solved, over that of the design: inertia vanishes."""

State = Literal["ahead", "back", "loaded"]
STATES: dict[State, float] = {"ahead": TOUCH, "back": -TOUCH, "loaded": 1.0}
"""Torque on the output in each state, over the nominal torque."""


@dataclass(frozen=True)
class Sampled:
    """The `states` of samples that a figure needs, and its `value` in its unit, shape (samples,)."""

    states: tuple[State, ...]
    value: Callable[..., Array]


BACKLASH = Sampled(("ahead", "back"), lambda ahead, back: backlash(ahead, back) / ARCMINUTE)
"""Backlash of samples: under the torque `TOUCH` it is within 0.2 % of that at zero torque."""


def solve_states(
    reducer: Reducer, samples: Samples, states: Collection[State], angles: int = ANGLES
) -> dict[State, SampleFigures]:
    """Solve for static equilibrium of many samples of a reducer, loaded and unloaded, without friction and weight.

    A sample is a drive with its own manufacturing errors. `states` are keys of `STATES`, each a torque on the output:
    "loaded" is the nominal torque, "ahead" and "back" are small torques in either direction. `angles` is the number of
    crank angles over a turn. Inertia is negligible because the crank turns at `CREEP_SHARE` of its speed.

    Returns
    -------
    dict
        Means, ranges and largest forces of the samples by state, in the order of `STATES`.
    """
    no_gravity = {"gravity_x": 0.0, "gravity_y": 0.0}
    slow_reducer = reducer.but(environment=no_gravity, drive={"speed": CREEP_SHARE * reducer.design.drive.speed})
    ordered_states = [state for state in STATES if state in states]
    torques = [STATES[state] * reducer.design.rated_torque for state in ordered_states]
    return dict(zip(ordered_states, solve_samples(slow_reducer, samples, torques, angles), strict=True))


def condition(reducer: Reducer) -> str:
    """Describe the conditions of the quantities of samples."""
    return (
        f"statics without friction and weight, rigid parts with elastic contacts, over a turn of the crank; loaded: "
        f"{reducer.design.rated_torque:.4g} N m on the output, unloaded: {TOUCH:g} of that"
    )


@once
def _solve_design(reducer: Reducer, state: State) -> SampleFigures:
    """Solve for the equilibrium of a single sample, the design with its own errors, in a state of `STATES`."""
    return solve_states(reducer, identical_samples(reducer, 1), [state])[state]


def _make_entry(key: str, name: str, unit: str, definition: str, sampled: Sampled) -> Figure:
    """Return the catalogue entry (`Figure`) of a quantity that can be computed for many random samples at once.

    For the design itself, it is computed from a single sample without random deviations.
    Key, name, unit and definition are attributes of `Figure`. `sampled` names the states (torques) to solve for, and
    computes the value from their equilibria.
    """

    def compute(reducer: Reducer) -> float:
        return float(sampled.value(*(_solve_design(reducer, state) for state in sampled.states))[0])

    return Figure(
        key=key, name=name, unit=unit, definition=definition, need=Need.STATICS, function=compute, sampled=sampled
    )


_RATED = "under the nominal torque, without friction, over a turn of the crank"
_UNLOADED = f"under {TOUCH:g} of the nominal torque, without friction, over a turn of the crank"

# fmt: off
OF_SAMPLES = (
    _make_entry("te_loaded_arcsec", "transmission error of the output, peak to peak, loaded", "arcsec",
            f"Range of the output's angle minus its ideal angle {_RATED}.",
            Sampled(("loaded",), lambda loaded: ARCSECONDS * loaded.output_range)),
    _make_entry("te_unloaded_arcsec", "transmission error of the output, peak to peak, unloaded", "arcsec",
            f"Range of the output's angle minus its ideal angle {_UNLOADED}.",
            Sampled(("ahead",), lambda ahead: ARCSECONDS * ahead.output_range)),
    _make_entry("wind_up_arcmin", "turn of the output, loaded minus unloaded, mean", "arcmin",
            "Rotation of the output under the nominal torque at a locked crank, starting from contact without load: "
            "mean over a turn, without friction.",
            Sampled(("ahead", "loaded"), lambda ahead, loaded: (loaded.output_mean - ahead.output_mean) / ARCMINUTE)),
    _make_entry("tooth_force_n", "largest force on a tooth", "N",
            f"Largest normal force of one contact between disc and ring {_RATED}.",
            Sampled(("loaded",), lambda loaded: loaded.tooth)),
    _make_entry("output_pin_force_n", "largest force on an output pin", "N",
            f"Largest normal force of one disc on one output pin {_RATED}.",
            Sampled(("loaded",), lambda loaded: loaded.output_pin)),
    _make_entry("cam_force_n", "largest force of the cam", "N",
            f"Largest force of one cam on its disc {_RATED}.",
            Sampled(("loaded",), lambda loaded: loaded.cam)),
    _make_entry("loaded_teeth", "loaded teeth, mean number", "1",
            f"Contacts of all discs with the ring with at least 1 % of the largest force {_RATED}: mean number.",
            Sampled(("loaded",), lambda loaded: loaded.carrying)),
    _make_entry("preload_n", "largest force on a tooth, unloaded", "N",
            f"Largest normal force of one contact between disc and ring, in both directions, {_UNLOADED}.",
            Sampled(("ahead", "back"), lambda ahead, back: np.maximum(ahead.tooth, back.tooth))),
    _make_entry("output_preload_n", "largest force on an output pin, unloaded", "N",
            f"Largest normal force of one disc on one output pin, in both directions, {_UNLOADED}.",
            Sampled(("ahead", "back"), lambda ahead, back: np.maximum(ahead.output_pin, back.output_pin))),
    _make_entry("cam_preload_n", "largest force of the cam, unloaded", "N",
            f"Largest force of one cam on its disc, in both directions, {_UNLOADED}.",
            Sampled(("ahead", "back"), lambda ahead, back: np.maximum(ahead.cam, back.cam))),
)
# fmt: on
