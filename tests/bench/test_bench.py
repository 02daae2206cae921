"""Loops of torque and turn with friction that remembers, and designs calibrated by them."""

import html
import json
import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest
from designs import UNLIKE, design_file, unlike
from scipy.stats import t

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.base.units import DEGREE
from cycloid_mj.bench import (
    MeasuredLoop,
    calibrate,
    compare_bench,
    compare_losses,
    measured_loop,
    predict_loops,
    read_loop,
    read_te,
)
from cycloid_mj.bench.calibration import STOPPED, CalibrationStopped
from cycloid_mj.bench.fit import Fitted, evaluate_fit, fit_loops, widen_intervals
from cycloid_mj.bench.loop_figures import loop_figures
from cycloid_mj.bench.model_selection import compare_fits
from cycloid_mj.bench.overlay import LoopCondition, apply_values, model_branches
from cycloid_mj.bench.parameters import DEFAULT, Model, fit_parameters
from cycloid_mj.bench.search import MODEL_ERROR, SETTINGS, FitProblem, Trials
from cycloid_mj.bench.uncertainty import INTERVAL, FitUncertainty, autocorrelation_time, estimate_uncertainty
from cycloid_mj.checks import require_sound
from cycloid_mj.cli.app import main
from cycloid_mj.design import Design, load, resolve
from cycloid_mj.design.model import NO_FRICTION
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.limits import stops
from cycloid_mj.report.results import calibration_page
from cycloid_mj.robot import ReducedJoint, reduce
from cycloid_mj.robot.trial import create_trial_scene as bench_scene
from cycloid_mj.statics import loads, springs_of
from cycloid_mj.statics.friction_path import Held, Losses, follow_torque_path
from cycloid_mj.statics.locked import follow_locked_path, slip_elements, solve_locked_curve
from cycloid_mj.statics.sheet import sheet

DATA = Path(__file__).parents[1] / "data" / "bench"
BENCH = [DATA / "play_loop.csv", DATA / "stiffness_loop.csv"]
NEAR = (70.0, 0.01, 0.23, 3.1, 0.14)
"""About the values of `FIVE` that the printed drive's loops ask for."""
FIVE = ("play", "tooth_stiffness", "friction", "drag", "drag_travel")
APART = ("mesh_play", "output_play", "cam_play", "tooth_stiffness", "friction", "drag", "drag_travel")


def course(*ends: float, count: int = 40) -> Array:
    parts = [np.linspace(a, b, count, endpoint=False) for a, b in pairwise(ends)]
    return np.concatenate([*parts, [ends[-1]]])


def soft() -> Design:
    """A printed drive with rather soft teeth and rough ones."""
    return resolve("printed").but(stiffness={"pin_gear": 2e6}, friction={"law": "coulomb", "pin_gear": 0.2})


def turn_along(reducer: Reducer, torque: Array, crank: float, losses: Losses, held: Held = "crank") -> Array:
    return follow_torque_path(reducer, torque, crank, losses, held)[1]


@pytest.mark.parametrize("name", ["pin", "nonpin", "printed", *UNLIKE])
def test_without_friction_it_is_the_balance(name: str) -> None:
    """Every design, up and down again: an independent iteration from nothing finds the same turn."""
    design = unlike(name) if name in UNLIKE else resolve(name)
    design = design.but(friction=NO_FRICTION, drive={"speed": 0.0})
    ends = [0.0, design.rated_torque, -design.rated_torque, 0.2 * design.rated_torque]
    torque = course(*ends, count=12)
    found = turn_along(Reducer(design), torque, 0.3, Losses())
    springs = springs_of(Reducer(design), [0.3], friction=False)
    for place in (12, 20, 24, 36):
        expected = loads(Reducer(design), springs, float(torque[place])).output_turn[0]
        assert found[place] == pytest.approx(expected, rel=1e-4)


def test_constant_friction_builds_up_over_its_travel() -> None:
    """From rest a seal's friction grows as 1 - exp(-turn/travel), but for the few elements that share it."""
    drag, travel = 3.0, 2e-3
    design = resolve("printed").but(clearance={"pin_gear": 500e-6, "output": 500e-6}, friction=NO_FRICTION)
    design = design.but(environment={"gravity_y": 0.0})
    torque = np.linspace(0.0, 0.9 * drag, 20)
    turn = turn_along(Reducer(design), torque, 0.0, Losses(drag, travel))
    assert torque[1:] == pytest.approx(drag * (1.0 - np.exp(-turn[1:] / travel)), abs=0.04 * drag)


@pytest.mark.parametrize("held", ["crank", "output"])
def test_a_partial_reversal_is_forgotten_once_it_closes(held: str) -> None:
    """Return-point memory: after a small loop inside, the course goes on as if there had been none."""
    losses = Losses(1.0, 1e-3)
    plain = turn_along(Reducer(soft()), course(0, 20, -20, 20), 0.0, losses, held)
    nested = turn_along(Reducer(soft()), course(0, 20, -20, 10, 4, 10, 20), 0.0, losses, held)
    assert nested[-1] == pytest.approx(plain[-1], rel=1e-3)
    entered, left = nested[120], nested[200]
    assert left == pytest.approx(entered, rel=2e-3)
    assert nested[160] > entered - 0.7 * (entered - stops(Reducer(soft()), 0.0)[1])  # it stuck on the way back


@pytest.mark.parametrize("stiffness", [2e6, 2e7])
def test_a_driven_crank_crosses_the_play(stiffness: float) -> None:
    """Parts that lie loose are carried by nothing: at a held output seals alone resist till the play is crossed."""
    drag, torque = 2.5, course(0.0, 4.0, -4.0, 4.0)
    reducer = Reducer(soft().but(stiffness={"pin_gear": stiffness}))
    low, high = stops(reducer, 0.0)
    reach = 0.02 * (high - low)
    when, turn = follow_torque_path(reducer, torque, 0.0, Losses(drag, 1e-3), "output", reach)
    along = np.interp(when, np.arange(len(torque)), torque)
    for way in (1.0, -1.0):
        across = along[(turn > low) & (turn < high) & (way * along > 0.0)]
        assert np.max(way * across) == pytest.approx(drag, rel=0.02)
    assert np.ptp(turn) > high - low


def test_parts_stick_before_they_slide_back() -> None:
    """Load-dependent friction: just after the reversal the loop is several times as stiff as before it.

    Needles would yield elastically then, so the rollers of the output pins are plain.
    """
    torque = course(0, 20, 0, count=80)
    turn = turn_along(Reducer(soft().but(output={"roller_bearing": "plain"})), torque, 0.0, Losses())
    before, after = turn[80] - turn[76], turn[80] - turn[84]
    assert 0.0 < after < 0.25 * before


def test_a_loop_dissipates_the_work_of_its_constant_friction() -> None:
    """Friction that acts at once takes twice its torque times the turn from one end to the other."""
    drag = 2.0
    torque = course(0, 20, -20, 20, count=400)
    turn = turn_along(Reducer(soft().but(friction=NO_FRICTION)), torque, 0.0, Losses(drag))
    work = abs(float(np.trapezoid(turn[400:], torque[400:])))
    assert work == pytest.approx(2.0 * drag * float(np.ptp(turn[400:])), rel=0.02)


def test_a_loop_dissipates_work_that_grows_with_friction() -> None:
    areas = []
    for friction in (0.05, 0.1, 0.2):
        design = soft().but(friction={"pin_gear": friction})
        torque = course(0, 20, -20, 20)
        areas.append(abs(float(np.trapezoid(turn_along(Reducer(design), torque, 0.0, Losses())[40:], torque[40:]))))
    assert 0.0 < areas[0] < areas[1] < areas[2]


COUNT, FINER = 60, 4
"""Points of a branch of a made loop, and how much finer the model goes there: not the steps of the fit."""


def made_loop(model: Model, most: float, seed: int, name: str = "made", begin: float = 0.3) -> MeasuredLoop:
    """Make a loop by the model, with an offset, and noise of 1 % of its height and of 0.3 % of its range of torque."""
    generator = np.random.default_rng(seed)
    torque, turn = clean_loop(model, most, begin)
    noisy = turn + 0.01 * np.ptp(turn) * generator.standard_normal(len(turn))
    return measured_loop(name, torque + 0.006 * most * generator.standard_normal(len(torque)), noisy / DEGREE + 0.2)


@cache
def clean_loop(model: Model, most: float, begin: float) -> tuple[Array, Array]:
    lead = course(0.0, -most, begin * most)[:-1] if begin else np.zeros(0)
    loop = course(begin * most, most, -most, begin * most, count=FINER * COUNT)
    turn = turn_along(model.reducer, np.concatenate([lead, loop]), 0.0, model.losses)[len(lead) :]
    return loop[::FINER], turn[::FINER]


@dataclass(frozen=True)
class Known:
    """A design with known values, the torque of its loop [N m]."""

    design: Design
    values: dict[str, float]
    most: float

    @cached_property
    def model(self) -> Model:
        ends = measured_loop("ends", *[course(0.0, 1.0, -1.0, 0.0)] * 2)
        return apply_values(
            Model(Reducer(self.design), Losses()),
            fit_parameters(Reducer(self.design), tuple(self.values), [ends]),
            np.array(list(self.values.values())),
        )

    def hits(self, keys: tuple[str, ...], seed: int) -> dict[str, bool]:
        """Fit some of the values to one loop, all others known.

        Give which of them are in their intervals, or named as what the loop does not determine.
        """
        rest = {key: value for key, value in self.values.items() if key not in keys}
        given = Known(self.design, rest, self.most).model.reducer.design if rest else self.design
        found = calibrate(given, [made_loop(self.model, self.most, seed)], keys)
        inside = {key: one.ci95[0] <= self.values[key] <= one.ci95[1] for key, one in found.estimates.items()}
        return {key: hit or not found.estimates[key].identified for key, hit in inside.items()}


KNOWN = {
    "printed": Known(
        resolve("printed", ["friction.law=coulomb"]),
        {"play": 80.0, "tooth_stiffness": 0.02, "friction": 0.22, "drag": 2.0, "drag_travel": 0.1},
        20.0,
    ),
    "few": Known(
        unlike("few"),
        {"play": 60.0, "tooth_stiffness": 0.3, "friction": 0.12, "drag": 0.25, "drag_travel": 0.02},
        3.0,
    ),
}
"""A printed drive of 13:1, and a steel one of 6:1 with free pins."""


@pytest.mark.slow
def test_calibration_recovers_known_values_for_most_seeds() -> None:
    """All five at once from one loop: what it determines of each is in its interval for 3 seeds of 4 at least.

    Intervals of 95 % hold a value for fewer in 1 % of such fours, those of 60 % in 52 %.
    """
    counts = Counter[str]()
    for seed in range(4):
        counts.update(KNOWN["printed"].hits(FIVE, 100 * seed))
    assert all(counts[key] >= 3 for key in FIVE), counts


LOCKED = {
    "play": 80.0,
    "structure_stiffness": 320.0,
    "drag": 2.5,
    "drag_travel": 0.1,
    "hysteresis": 4.0,
    "hysteresis_travel": 1.5,
}
"""Values of the default fit, near those of the printed drives' loops."""


def locked_model(contacts: float) -> Model:
    """Put `LOCKED` into the printed drive, with contacts as many times as stiff."""
    design = resolve("printed").but(stiffness={"pin_gear": contacts * 1.5e7})
    ends = measured_loop("ends", *[course(0.0, 25.0, -25.0, 0.0)] * 2)
    chosen = fit_parameters(Reducer(design), tuple(LOCKED), [ends])
    return apply_values(
        Model(Reducer(design), Losses(), contact_friction=False), chosen, np.array(list(LOCKED.values()))
    )


def locked_loops(contacts: float, off: float, seed: int) -> list[MeasuredLoop]:
    """Make a small and a large loop of a `locked_model`, with noise and by a model that is off.

    The error is a wave along the loop of so large an rms, over its height.
    """
    draw, model, loops = np.random.default_rng(seed), locked_model(contacts), []
    for most in (4.0, 25.0):
        torque = course(0.0, most, -most, most, -most, 0.3 * most, count=80)
        turn = follow_locked_path(solve_locked_curve(model.reducer, most, 0.0), slip_elements(model.reducer), torque)[
            80:
        ]
        wave = np.sin(np.linspace(0.0, 2.0 * math.pi * draw.uniform(0.5, 3.0), len(turn)) + draw.uniform(0.0, 6.3))
        turn = turn + np.ptp(turn) * (0.005 * draw.standard_normal(len(turn)) + off * math.sqrt(2.0) * wave)
        loops.append(measured_loop(f"loop-{most:g}", torque[80:], turn / DEGREE))
    return loops


@pytest.mark.slow
def test_a_design_predicts_its_own_loops() -> None:
    """With the values that made them the loops are missed by their noise; with another structure by more."""
    model = locked_model(1.0)
    found = predict_loops(model.reducer, locked_loops(1.0, 0.0, 0))
    assert max(found.shares) < 0.02
    assert found.modelled.coulomb.value == pytest.approx(found.measured.coulomb.value, rel=0.05)
    assert found.modelled.stiffness.value == pytest.approx(found.measured.stiffness.value, rel=0.05)
    stiffer = model.reducer.design.but(springs={"housing": 2.0 * model.reducer.design.springs.housing})
    assert predict_loops(Reducer(stiffer), locked_loops(1.0, 0.0, 0)).shares[1] > 0.1


def missed(contacts: float, off: float, seeds: int) -> tuple[Counter[str], Counter[str]]:
    """Count of so many seeds how often the default fit calls each value identified, and how often it then misses it."""
    design = resolve("printed").but(stiffness={"pin_gear": contacts * 1.5e7})
    identified, outside = Counter[str](), Counter[str]()
    for seed in range(seeds):
        found = calibrate(design, locked_loops(contacts, off, seed)).estimates
        told = {key: one.ci95 for key, one in found.items() if one.identified}
        identified.update(list(told))
        outside.update(key for key, (low, high) in told.items() if not low <= LOCKED[key] <= high)
    return identified, outside


@pytest.mark.slow
def test_two_loops_state_play_and_stiffness_within_their_intervals() -> None:
    identified, outside = missed(1.0, 0.0, 1)
    assert identified["structure_stiffness"] == 1
    assert not outside


@pytest.mark.slow
@pytest.mark.parametrize(
    ("contacts", "off"), [(1.0, 0.03), (0.02, 0.0)], ids=["hard_contacts_model_off", "soft_contacts"]
)
def test_identified_values_are_within_their_intervals(contacts: float, off: float) -> None:
    """Of 14 seeds each value that is called identified is in its interval for 12, by hard contacts and by soft ones.

    Intervals of 95 % hold a value for fewer in 3 % of such fourteens, those of 60 % in 96 %.
    With 3 % off, the loops have a wave in them that no model has. Hard contacts without it: one seed, above.
    """
    identified, outside = missed(contacts, off, 14)
    assert all(count <= 2 for count in outside.values()), (identified, outside)
    assert off or identified["drag"] >= 5


@pytest.mark.slow
def test_a_tolerance_of_the_drawing_narrows_a_play() -> None:
    """The loops leave the play open by more than the drawing does: then it is called the drawing's, not the loops'."""
    design = resolve("printed").but(clearance={"pin_gear": 80e-6}, tolerance={"mesh": "normal 4", "output": "normal 3"})
    found = calibrate(design, locked_loops(1.0, 0.0, 0))
    play = found.estimates["play"]
    assert play.deviation == pytest.approx(5.0)
    assert play.source == "tolerance: mesh, output"
    assert play.ci95[1] - play.ci95[0] < 40.0
    assert not play.identified
    assert found.as_json()["parameters"]["play"]["prior"] == {"value": 80.0, "deviation": 5.0, "source": play.source}
    assert found.as_json()["parameters"]["drag"]["prior"] is None


def measured(kind: str, *names: str) -> list[MeasuredLoop]:
    return [read_loop(DATA / f"{'' if kind == 'pin' else 'nonpin_'}{name}_loop.csv") for name in names]


def thinned(loop: MeasuredLoop, count: int) -> MeasuredLoop:
    chosen = np.linspace(0.0, len(loop.torque) - 1.0, count).round().astype(int)
    return measured_loop(loop.name, loop.torque[chosen], loop.deflection[chosen] / DEGREE)


def noisy(loop: MeasuredLoop) -> MeasuredLoop:
    """Add noise of 2 % of the height, and of 0.6 % of the range of torque."""
    draw = np.random.default_rng(0).standard_normal
    torque = loop.torque + 0.006 * np.ptp(loop.torque) * draw(len(loop.torque))
    return measured_loop(loop.name, torque, (loop.deflection + 0.02 * loop.height * draw(len(torque))) / DEGREE)


AUTHORS = {"pin": (1.56, 2.76, 337.0), "nonpin": (1.56, 2.97, 310.0), "preloaded": (0.22, 4.42, 200.0)}
"""Play [deg], Coulomb friction [N m] and stiffness [N m/rad] that the loops' authors state after run-in, and of a ring
in halves that is preloaded by three quarters of its range."""


def dead_band_loop(
    most: float, play: float, friction: float, stiffness: float, first: int = -1, count: int = 120, seed: int = 0
) -> MeasuredLoop:
    """Make a loop by a model that shares nothing with the fit's: play [deg], friction [N m], stiffness [N m/rad].

    A spring of power 1.15 beyond a dead band that holds back a little in itself, friction by Dahl (1968) that grows by
    12 % of what the spring carries, a zero of torque off by 0.2 N m, and noise of 0.4 % of the height.
    """
    draw, band, half = np.random.default_rng(seed).standard_normal, 0.8 / play, 0.5 * play
    step, travel, loaded = 0.002, 0.08, 20.0 / (stiffness * DEGREE)

    def spring(turn: float) -> float:
        beyond = max(abs(turn) - half, 0.0)
        return math.copysign(20.0 * (beyond / loaded) ** 1.15, turn) + band * turn

    turn = held = 0.0
    course_of: list[tuple[float, float]] = []
    for place, end in enumerate(first * most * np.array([1.0, -1.0, 1.0, -1.0, 0.2])):
        way = math.copysign(1.0, end - spring(turn) - held)
        reached = spring(turn) + held
        while way * (reached - end) < 0.0:
            turn += way * step
            limit = friction + 0.12 * abs(spring(turn))
            held = min(max(held + way * step / travel * (limit - way * held), -limit), limit)
            reached = way * max(way * reached, way * (spring(turn) + held))
            if place > 1:
                course_of.append((reached, turn))
    torque, deflection = np.array(course_of).T
    gone = np.cumsum(np.hypot(np.diff(torque, prepend=torque[0]) / most, np.diff(deflection, prepend=0.0) / play))
    at = np.linspace(gone[0], gone[-1], count)
    torque, deflection = np.interp(at, gone, torque), np.interp(at, gone, deflection)
    noise = 0.004 * np.ptp(deflection) * draw(count)
    return measured_loop(f"made-{most:g}", torque + 0.2 + 0.003 * most * draw(count), deflection + 0.05 + noise)


def worn(loop: MeasuredLoop) -> MeasuredLoop:
    """Give a measured loop of before run-in 0.32 deg more play, and 0.7 of its friction."""
    middle = 0.5 * (loop.deflection.max() + loop.deflection.min())
    wider = 0.16 * DEGREE * np.tanh((loop.deflection - middle) / (0.175 * loop.height))
    eased = 0.3 * loop_figures([loop]).coulomb.value * (1.0 - np.abs(loop.torque) / np.abs(loop.torque).max())
    way = np.where(loop.moving(1), 1.0, -1.0)
    return measured_loop(loop.name, loop.torque - way * eased, (loop.deflection + wider) / DEGREE)


def made(kind: str, *mosts: float, **more: int) -> list[MeasuredLoop]:
    return [dead_band_loop(most, *AUTHORS[kind], **more) for most in mosts]


CLOSING: dict[str, Callable[[str], list[MeasuredLoop]]] = {
    "both": lambda kind: measured(kind, "play", "stiffness"),
    "play": lambda kind: measured(kind, "play"),
    "stiffness": lambda kind: measured(kind, "stiffness"),
    "30 points": lambda kind: [thinned(loop, 30) for loop in measured(kind, "play", "stiffness")],
    "noise": lambda kind: [noisy(loop) for loop in measured(kind, "play")],
    "half the torque": lambda kind: [
        measured_loop(loop.name, 0.5 * loop.torque, loop.deflection / DEGREE) for loop in measured(kind, "play")
    ],
    "worn, stiffness": lambda kind: [worn(loop) for loop in measured(kind, "stiffness")],
    "run-in": lambda kind: made(kind, 4.0, 25.0),
    "run-in, few points, other way": lambda kind: made(kind, 25.0, first=1, count=50),
    "preloaded": lambda kind: made("preloaded", 6.0, 25.0),
}
"""Loops by their names, from a kind of ring: measured ones, changed ones, and such as another model makes."""


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["pin", "nonpin"])
@pytest.mark.parametrize("made_from", CLOSING)
def test_a_measured_loop_closes_in_stock_mujoco(kind: str, made_from: str) -> None:
    """Bench, design, joint, scene: the design passes check, statics and reduce, the scene repeats it within 8 %.

    That is the rms difference of the deflections at the same torque, over the loop's height, with the bench's zeros of
    torque and deflection as they were fitted. With no offset of torque it is as near but for what the loop is off from
    having two like sides, which no drive of like sides can follow. With the output held, the crank turns against the
    no-load drag of film friction, which a loop with a held crank does not show: that scene has Coulomb friction.
    """
    loops = CLOSING[made_from](kind)
    found = calibrate(resolve("printed").but(ring={"kind": kind}), loops)
    reducer = Reducer(found.design)
    require_sound(reducer)
    sheet(reducer, max(loop.most for loop in loops))
    joints = {"crank": reduce(found.design, "backlash")}
    if made_from == "both":
        joints["output"] = reduce(found.design.but(friction={"law": "coulomb"}), "backlash")
    for held, reduced in joints.items():
        for number, (loop, offset) in enumerate(zip(loops, found.fitted.offsets[:, 0], strict=True)):
            left = scene_loop(reduced, loop, float(offset), held) - loop.deflection
            assert np.std(left[loop.points_left_out :]) < 0.08 * loop.height, (held, loop.name)
            if not found.fitted.torque_offset:
                assert found.fitted.rms_without_offset(number) < 0.08 * loop.height, loop.name


def unlike_sides(loop: MeasuredLoop) -> float:
    """Compute the least rms by which a loop of two like sides misses a loop [rad]: half of what its sides differ by."""
    differs = np.empty(len(loop.torque))
    for way in (1, -1):
        here, other = loop.moving(way), loop.moving(-way)
        order = np.argsort(loop.torque[other])
        turn = np.interp(-loop.torque[here], loop.torque[other][order], loop.deflection[other][order])
        differs[here] = 0.5 * (loop.deflection[here] + turn)
    return float(np.std(differs[loop.points_left_out :]))


@pytest.mark.slow
def test_the_loop_is_repeated_best_within_the_intervals() -> None:
    """By a model that is off, the likeliest values miss the turns by more; none leaves its interval."""
    loops = locked_loops(1.0, 0.03, 0)
    chosen = fit_parameters(Reducer(resolve("printed")), DEFAULT, loops)
    search = FitProblem(locked_model(1.0), chosen, tuple(loops), LoopCondition("crank", 0.0, 25.0), Trials())
    known = [one.to_scale(LOCKED[one.key]) for one in chosen]
    start = np.concatenate([known, np.zeros(4)])
    low, high = np.clip([start - 3.0, start + 3.0], *search.bounds)
    low[0] = high[0] = start[0]
    found = search.fit_deflections(start, low, high)
    assert np.all((found >= low) & (found <= high))
    assert found[0] == start[0]
    missed = [float(np.sum(search.deflection_errors(places) ** 2)) for places in (found, start)]
    assert missed[0] < 0.95 * missed[1]


def with_zero_offset(loops: list[MeasuredLoop], share: float) -> list[MeasuredLoop]:
    """Shift the torques of loops by a share of their largest, as a sensor whose zero is off."""
    return [measured_loop(loop.name, loop.torque + share * loop.most, loop.deflection / DEGREE) for loop in loops]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("share", [0.0, 0.04])
def test_a_zero_offset_is_chosen_by_the_information_criterion(seed: int, share: float) -> None:
    """Loops of known values whose zero of torque is off by 4 % have an offset, and those without have none.

    Neither moves the stiffness: 320 N m/rad was put in.
    """
    found = calibrate(resolve("printed"), with_zero_offset(locked_loops(1.0, 0.0, seed), share))
    assert found.fitted.torque_offset == (share > 0.0)
    assert (found.fitted.offset_gain > 0.0) == (share > 0.0)
    for loop, offset in zip(found.fitted.loops, found.fitted.offsets[:, 0], strict=True):
        assert offset == pytest.approx(share * loop.most / (1.0 + share), rel=0.15, abs=1e-9)
    assert found.estimates["structure_stiffness"].value == pytest.approx(LOCKED["structure_stiffness"], rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["pin", "nonpin"])
def test_measured_loops_support_friction_that_grows_with_the_load(kind: str) -> None:
    """The default model misses the loops where they are unloaded; friction in proportion to the torque follows them.

    The loops are those before run-in: the held-out ones of after it are not in this repository.
    """
    loops = measured(kind, "play", "stiffness")
    found = calibrate(resolve("printed").but(ring={"kind": kind}), loops)
    assert found.preferred is not None
    assert found.preferred.key == "load"
    shares = {one.key: one.shares[1] for one in found.candidates}
    residuals = {key: math.degrees(share * loops[1].height) for key, share in shares.items()}
    assert residuals["load"] < 0.25 < 0.6 < residuals["hysteresis"]
    missed = {one.stretch for one in found.stretches if one.loop == loops[1].name and not one.is_within_model_error}
    assert {"torque rising, unloading", "torque falling, unloading"} <= missed
    assert any("load_friction" in sentence and "--fit" in sentence for sentence in found.misfits)
    content = found.as_json()
    assert content["preferred_model"] == "load"
    assert [one["key"] for one in content["models"]] == ["hysteresis", "constant", "load"]
    assert found.fitted.torque_offset


@pytest.mark.slow
def test_loops_simulated_with_hysteresis_prefer_the_hysteresis_model() -> None:
    """Loops with hysteresis of constant size are not explained by friction that grows, and the design follows them."""
    found = calibrate(resolve("printed"), locked_loops(1.0, 0.0, 0))
    assert found.preferred is not None
    assert found.preferred.key == "hysteresis"
    assert found.misfits == ()


@pytest.mark.slow
def test_friction_that_grows_in_an_independent_model_is_recognised() -> None:
    """Loops of the authors' figures after run-in, by a model that shares nothing with the fit's (`dead_band_loop`)."""
    found = calibrate(resolve("printed"), made("pin", 4.0, 25.0))
    assert found.preferred is not None
    assert found.preferred.key == "load"
    assert found.preferred.values["load_friction"] == pytest.approx(0.12, abs=0.06)


def test_intervals_state_the_model_error_that_they_assume() -> None:
    """Next to the values: without noise the intervals are as wide; those of noise alone stand beside them."""
    found = calibrate(resolve("printed"), locked_loops(1.0, 0.0, 0), ("play", "structure_stiffness", "drag"))
    table = found.tables()[0]
    assert "95 %, with a model error of 3%" in table.header
    assert "95 %, noise alone" in table.header
    assert any("model error of 3%" in note for note in found.notes)
    content = found.as_json()
    assert content["model_error_share"] == 0.03
    for one in content["parameters"].values():
        assert one["noise95"][1] - one["noise95"][0] < one["ci95"][1] - one["ci95"][0]
    assert all(key in found.line for key in found.unidentified)


SLOWLY = 0.005
"""Torque by which a scene is taken round a loop in 30 steps of a millisecond, as a share of the loop's largest."""


def scene_loop(reduced: ReducedJoint, loop: MeasuredLoop, offset: float, held: str) -> Array:
    """Take the stock scene of a joint slowly round a loop, less an offset of torque [N m]: L at its points [rad]."""
    on = bench_scene(reduced, 1e-3, 1e-3, "implicitfast")
    output, crank = on.addresses.output_speed, on.addresses.crank_speed
    free, still, gain = (output, crank, 1.0) if held == "crank" else (crank, output, reduced.coefficient)
    on.model.dof_armature[still] = 1e9
    on.model.dof_armature[free], on.model.dof_damping[free] = 1e-3 * gain**2, 0.05 * gain**2
    mujoco.mj_setConst(on.model, on.data)

    turns, (first, second, *_) = [], loop.turns
    before, branch = 0.0, 0
    for torque, way in [(second, 0), (first, 0), *zip(loop.torque.tolist(), loop.branch.tolist(), strict=True)]:
        stretches = [torque] if way == branch else [loop.turns[way], torque]
        branch = way
        for end in stretches:
            parts = max(2, math.ceil(abs(end - before) / (SLOWLY * loop.most)))
            for pull in np.linspace(before, end, parts):
                on.data.qfrc_applied[free] = gain * (pull - offset)
                for _ in range(30):
                    on.step()
            before = end
        turns.append(on.length)
    return np.array(turns[2:])


@pytest.mark.slow
def test_values_of_another_drive_come_back() -> None:
    """A steel one of 6:1 with free pins: play, stiffness and friction, all else known."""
    hits = KNOWN["few"].hits(("play", "tooth_stiffness", "friction"), 0)
    assert all(hits.values()), hits


def test_the_points_before_the_loop_are_left_out() -> None:
    """A bench that starts from rest begins inside the loop; one that goes round has no such points."""
    model = KNOWN["printed"].model
    assert made_loop(model, 20.0, 0, begin=0.0).points_left_out == pytest.approx(COUNT, abs=3)
    assert made_loop(model, 20.0, 0).points_left_out == 0
    assert [read_loop(path).points_left_out for path in BENCH] == [0, 0]


def test_a_loop_reverses_at_the_reversals_of_its_torque() -> None:
    """Neither noise nor few points cut off the tips, at which parts stick and from which on they remember."""
    for seed in range(3):
        loop = made_loop(KNOWN["printed"].model, 20.0, seed)
        assert loop.ends == pytest.approx((-20.0, 20.0), rel=0.02)


def test_a_leap_across_the_play_needs_the_drag_torque() -> None:
    """Under a torque that grows the output leaps across its play: at constant friction, however coarse the course."""
    model = KNOWN["printed"].model
    for most in (19.0, 20.0, 21.0):
        ends = measured_loop("ends", *[most * course(0.0, 1.0, -1.0, 0.0)] * 2)
        for torque, turn in model_branches(model, LoopCondition("crank", 0.0, 25.0), ends):
            leap = int(np.argmax(np.abs(np.diff(turn))))
            assert abs(torque[leap]) == pytest.approx(KNOWN["printed"].values["drag"], rel=0.01)


def ideal_loop(most: float, play: float, stiffness: float, coulomb: float, noise: float) -> MeasuredLoop:
    """Make the loop of a spring [N m/rad] behind a play [rad] that constant friction [N m] holds where it is."""
    torque, turn, turns = most * course(0.0, -1.0, 1.0, -1.0, 0.3, count=200), 0.0, []
    for pulled in torque.tolist():
        low, high = (
            math.copysign(abs(one) / stiffness + 0.5 * play, one) for one in (pulled - coulomb, pulled + coulomb)
        )
        turn = min(max(turn, low), high)
        turns.append(turn)
    loop = np.array(turns[200:])
    noisy = loop + noise * np.ptp(loop) * np.random.default_rng(0).standard_normal(len(loop))
    return measured_loop("ideal", torque[200:], noisy / DEGREE)


@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_figures_of_a_loop_are_those_of_its_making(noise: float) -> None:
    """A play of 1 deg, 300 N m/rad, 3 N m of friction: read off the points, each within its interval."""
    read = loop_figures([ideal_loop(25.0, DEGREE, 300.0, 3.0, noise)])
    for figure, value in ((read.play, DEGREE), (read.stiffness, 300.0), (read.coulomb, 3.0)):
        assert figure.value == pytest.approx(value, rel=0.03 + 20.0 * noise)
        assert figure.low - 0.03 * value < value < figure.high + 0.03 * value


def test_a_preloaded_ring_has_no_rigid_stops() -> None:
    """Halves that press the gear are no error of its making: the message names the preload."""
    preloaded = resolve("printed").but(ring={"kind": "nonpin", "halves": 2, "preload": math.radians(0.5)})
    with pytest.raises(RunError, match=r"reduce ring\.preload_arcmin"):
        stops(Reducer(preloaded), 0.0)


def test_the_measured_loops_show_their_figures() -> None:
    """Slopes read by hand off the loading branches from 12.5 to 24.5 N m are 374 and 384 N m/rad."""
    read = loop_figures([read_loop(path) for path in BENCH])
    assert read.stiffness.low < 374.0 < read.stiffness.high
    assert read.stiffness.low < 384.0 < read.stiffness.high
    assert math.degrees(read.play.low) < 1.24 < math.degrees(read.play.high)
    assert 2.0 < read.coulomb.low < read.coulomb.high < 4.0


def test_a_loop_with_too_few_points_has_no_stiffness_or_play() -> None:
    """Six points to a branch: two of them where it is loaded, which lie on a line whatever the loop is."""
    torque = course(-1.0, 1.0, -1.0, 1.0, -1.0, count=6)
    turn = 0.1 * torque - 0.02 * np.gradient(torque)
    read = loop_figures([measured_loop("sparse", torque, turn)])
    assert math.isnan(read.stiffness.value)
    assert math.isnan(read.play.value)


def test_an_interval_covers_a_model_error() -> None:
    """Any course of an error of 3 % rms moves a value by no more than the interval reaches, however little noise."""
    generator = np.random.default_rng(3)
    slopes = generator.standard_normal((200, 2)) / 200**0.5
    worst = np.linalg.pinv(slopes)[0]
    error = MODEL_ERROR * worst / np.linalg.norm(worst)
    moved = np.linalg.lstsq(slopes, error, rcond=None)[0][0]
    inverse = np.linalg.inv(slopes.T @ slopes)
    assert moved == pytest.approx(MODEL_ERROR * inverse[0, 0] ** 0.5)


def test_a_loop_without_an_equilibrium_is_reported_by_name() -> None:
    """Before anything is searched further: one loop that no model follows, beside one that it does."""
    loops = locked_loops(1.0, 0.0, 0)

    class Locked(FitProblem):
        def residuals_by_loop(self, places: Array) -> list[Array]:
            _, other = super().residuals_by_loop(places)
            return [np.full(len(loops[0].torque) - loops[0].points_left_out, SETTINGS.failed_residual), other]

    chosen = fit_parameters(Reducer(resolve("printed")), ("drag",), loops)
    problem = Locked(locked_model(1.0), chosen, tuple(loops), LoopCondition("crank", 0.0, 25.0), Trials())
    with pytest.raises(
        RunError, match="loop-4: the model has no static equilibrium for any parameters near those of the design"
    ):
        evaluate_fit(problem, problem.starts()[0])


@pytest.fixture(scope="module")
def bench() -> Fitted:
    """Compute the fit to the printed drive's loops, from near where the search of many starts ends."""
    loops, design = [read_loop(path) for path in BENCH], resolve("printed")
    chosen = fit_parameters(Reducer(design), FIVE, loops)
    near = [one.to_scale(value) for one, value in zip(chosen, NEAR, strict=True)]
    return fit_loops(
        Model(Reducer(design), Losses()),
        chosen,
        loops,
        LoopCondition("crank", 0.0, 25.0),
        start=np.concatenate([near, np.zeros(2 * len(loops))]),
        intervals=False,
    )


@pytest.mark.slow
def test_the_printed_drive_is_explained(bench: Fitted) -> None:
    shares = [bench.rms(place) / loop.height for place, loop in enumerate(bench.loops)]
    assert shares[0] < 0.08
    assert shares[1] < 0.04
    friction = FIVE.index("friction")
    assert bench.values[friction] > 0.1
    low, high = stops(bench.calibrated_model.reducer, 0.0)
    assert math.degrees(high - low) < 1.24


@pytest.mark.slow
def test_friction_of_contacts_explains_what_constant_friction_does_not() -> None:
    so_far: list[int] = []
    loops = [read_loop(path) for path in BENCH]
    found = compare_losses(
        calibrate(resolve("printed"), loops, FIVE), on_fit=lambda one: so_far.append(len(one.variants))
    )
    assert so_far == [1, 2, 3, 4]
    shares = {one.key: one.shares[1] for one in found.variants}
    assert shares["friction"] < min(0.6 * shares["constant"], 0.8 * shares["material"])
    assert shares["both"] < 1.05 * shares["friction"]


@pytest.mark.slow
def test_criteria_of_variants_compare(bench: Fitted) -> None:
    """All count what is independent in the fullest: a value that gains nothing costs just ln n, whatever else does."""
    draw = np.random.default_rng(0).standard_normal
    noise = tuple(1e-2 * draw(len(one)) for one in bench.residuals)
    wave = tuple(3.0 * np.sqrt(np.mean(one**2)) * np.sqrt(2.0) * np.sin(np.arange(len(one)) / 9.0) for one in noise)
    full = replace(bench, residuals=noise)
    idle = replace(full, parameters=full.parameters[:-1], scaled=full.scaled[:-1])
    poor = replace(idle, residuals=wave)
    found = compare_fits({("poor", ""): poor, ("idle", ""): idle, ("full", ""): full})
    points = sum(full.independent)
    assert sum(poor.independent) < 0.2 * points
    of_poor, of_idle, of_full = (one.bayesian for one in found)
    assert of_full - of_idle == pytest.approx(np.log(points))
    ratios = [np.mean(a**2) / np.mean(b**2) for a, b in zip(wave, noise, strict=True)]
    assert of_poor - of_idle == pytest.approx(np.dot(full.independent, np.log(ratios)))


def pressed_at(trials: int) -> Callable[[int, int], None]:
    """Return a progress that presses Ctrl-C at a trial."""

    def progress(done: int, whole: int) -> None:
        if done == trials:
            raise KeyboardInterrupt

    return progress


def test_a_stopped_fit_keeps_the_best_values_so_far() -> None:
    """Before a search has ended there is nothing; after it values that explain the loops, by and by as well as all."""
    loops, told, keys = locked_loops(1.0, 0.0, 0), [], ("structure_stiffness", "drag")
    whole = calibrate(resolve("printed"), loops, keys, progress=lambda *counts: told.append(counts))
    assert whole.complete
    last = len(told)
    assert [done for done, _ in told] == list(range(1, last + 1))
    assert all(done < expected for done, expected in told)
    assert all(0.7 * last < expected < 2.5 * last for _, expected in told)
    with pytest.raises(KeyboardInterrupt) as nothing:
        calibrate(resolve("printed"), loops, keys, progress=pressed_at(10))
    assert not isinstance(nothing.value, CalibrationStopped)
    for trials in (last // 2, 3 * last // 4, last - 5):
        with pytest.raises(CalibrationStopped) as stop:
            calibrate(resolve("printed"), loops, keys, progress=pressed_at(trials))
        found = stop.value.calibration
        assert not found.complete
        assert STOPPED in found.notes
        assert found.rms < 1.5 * whole.rms
        assert found.estimates.keys() == whole.estimates.keys()


def test_the_page_of_a_calibration_lists_correlated_and_undetermined_parameters() -> None:
    keys = ("structure_stiffness", "drag")
    pair = (*keys, 0.987)
    calibration = replace(
        calibrate(resolve("printed"), locked_loops(1.0, 0.0, 0), keys), indistinguishable=(pair,), notes=("A note.",)
    )
    page = html.unescape(calibration_page(calibration, "<svg></svg>", ["A remark."]))
    assert "structure_stiffness and drag: correlation 0.987" in page
    assert all(f"{key} is not determined by these loops" in page for key in calibration.unidentified)
    assert all(sentence in page for sentence in (*calibration.measure_next, "A note.", "A remark."))


@pytest.mark.slow
def test_a_stopped_calibration_is_saved_in_its_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("cycloid_mj.cli.progress.count_progress", lambda what, quiet: pressed_at(100))
    words = ["calibrate", "--design", "printed", "--loop", str(BENCH[0]), "--fit", "drag"]
    assert main([*words, "--out", str(tmp_path), "--quiet"]) == 130
    assert f"stopped by Ctrl-C; the values fitted so far are in {tmp_path}" in capsys.readouterr().err
    found = json.loads((tmp_path / "printed-calibrated.json").read_text())
    assert found["complete"] is False
    assert found["unusable"] is None
    assert STOPPED in (tmp_path / "printed-calibrated.html").read_text(encoding="utf-8")
    assert load(tmp_path / "printed-calibrated.toml").springs.friction > 0.0


@pytest.mark.slow
def test_a_calibration_whose_design_was_not_tried_is_in_its_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def pressed(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("cycloid_mj.statics.sheet.sheet", pressed)
    words = ["calibrate", "--design", "printed", "--loop", str(BENCH[0]), "--fit", "drag"]
    assert main([*words, "--out", str(tmp_path), "--quiet"]) == 130
    assert "the calibrated design was not tested" in capsys.readouterr().err
    found = json.loads((tmp_path / "printed-calibrated.json").read_text())
    assert found["complete"] is True
    assert found["unusable"] is None


@pytest.mark.slow
def test_results_before_ctrl_c_are_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def pressed(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("cycloid_mj.bench.compare_losses", pressed)
    words = ["calibrate", "--design", "printed", "--loop", str(BENCH[0]), "--fit", "drag", "--losses"]
    assert main([*words, "--out", str(tmp_path), "--quiet"]) == 130
    told = f"stopped by Ctrl-C; the calibration and the loss models fitted so far are in {tmp_path}"
    assert told in capsys.readouterr().err
    assert load(tmp_path / "printed-calibrated.toml").springs.friction > 0.0


@pytest.mark.slow
def test_play_in_teeth_and_holes_is_not_distinguished() -> None:
    """With a clearance each they are open, and the loop to measure next is named."""
    found = calibrate(resolve("printed"), [read_loop(path) for path in BENCH], APART)
    assert {"mesh_play", "output_play", "cam_play"} & set(found.unidentified)
    assert any("second crank angle" in sentence for sentence in found.measure_next)
    shares = [found.fitted.rms(place) / loop.height for place, loop in enumerate(found.fitted.loops)]
    assert shares[0] < 0.08
    assert shares[1] < 0.04


def test_noise_counts_point_by_point_and_a_wave_does_not() -> None:
    noise = np.random.default_rng(0).standard_normal(400)
    assert autocorrelation_time(noise) < 1.5
    assert autocorrelation_time(np.sin(np.linspace(0.0, 20.0, 400)) + 0.1 * noise) > 10.0


def test_a_value_without_effect_on_residuals_is_unknown() -> None:
    """As the travel of a constant friction of 0: neither a fit's own noise nor its straight line tells of it."""
    generator = np.random.default_rng(0)
    rows, residuals = np.array([[1.0, 0.0]]) * generator.uniform(0.5, 1.0, (50, 1)), generator.standard_normal(50)
    errors = estimate_uncertainty([rows], [residuals], np.array([True, True])).errors
    assert 0.05 < errors[0] < 0.5
    assert errors[1] == pytest.approx(INTERVAL.unknown_error)


def test_a_nearly_dependent_value_has_a_positive_error() -> None:
    """Of three values of which the third is the sum of the others but for 1e-6: no variance is rounded below 0."""
    draw = np.random.default_rng(17)
    slopes = draw.standard_normal((50, 3))
    slopes[:, 2] = slopes[:, 0] + 0.7 * slopes[:, 1] + 10.0 ** draw.uniform(-9.0, -5.0) * slopes[:, 2]
    assert np.all(estimate_uncertainty([slopes], [0.01 * draw.standard_normal(50)], np.ones(3, bool)).errors > 0.0)


def test_an_interval_covers_what_few_points_decide() -> None:
    """181 points, of which six answer to the value: in 95 of 100 fits it is inside; by all 181 it was in some 91."""
    generator = np.random.default_rng(1)
    slopes = np.zeros((181, 2))
    slopes[:, 0], slopes[::31, 1] = 1.0, 1.0
    inside, narrow = 0, 0
    for _ in range(2000):
        noise = generator.standard_normal(181)
        found = np.linalg.lstsq(slopes, noise, rcond=None)[0]
        sure = estimate_uncertainty([slopes], [noise - slopes @ found], np.array([True, True]))
        away = abs(found[1]) / sure.errors[1]
        inside += away <= sure.quantiles(INTERVAL.confidence)[1]
        narrow += away <= t.ppf(0.975, 179.0)
    assert inside / 2000 == pytest.approx(INTERVAL.confidence, abs=0.015)
    assert narrow / 2000 < INTERVAL.confidence - 0.02


def test_an_interval_reaches_into_every_valley() -> None:
    """Two values of friction explain a loop alike: a search from either finds its own, and the interval holds both."""

    class Valleys:
        parameters = (None,)
        bounds = (np.array([-10.0]), np.array([10.0]))
        trials = Trials()

        def expected_trials(self, **_: int) -> float:
            return 1.0

        def minimise(self, start: Array, *_: Any, fixed: int | None = None) -> tuple[float, Array]:
            assert fixed == 0
            near = 0.0 if start[0] < 1.5 else 3.0
            return 1.0 + (0.05 if near else 0.0) + 0.5 * float(start[0] - near) ** 2, start

    sure = FitUncertainty(np.eye(1) * 0.25, np.eye(1), np.ones((50, 1)), np.ones(50))
    ends = np.array([[-1.0, 1.0]])
    found = SimpleNamespace(uncertainty=sure, likeliest=np.array([0.0]), ends=ends, at_bound=np.array([False]))
    assert (
        widen_intervals(Valleys(), found, [(1.0, np.array([0.0])), (1.05, np.array([3.0])), (9.0, np.array([-5.0]))])
        is None
    )
    assert found.ends[0] == pytest.approx([-1.0, 3.0 + 0.9**0.5])


def test_either_sign_convention_is_read() -> None:
    ours = read_loop(BENCH[0])
    other = measured_loop("other", ours.torque, -ours.deflection / DEGREE)
    assert not ours.flipped
    assert other.flipped
    assert other.deflection == pytest.approx(ours.deflection)


def rows(path: Path) -> list[str]:
    return path.read_text(encoding="utf-8").splitlines()


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda lines: [], "the file is empty"),
        (lambda lines: lines[:1], "there are no rows"),
        (lambda lines: ["# a,b", *lines[1:]], "torque_output_Nm"),
        (lambda lines: ["torque_output_Nm,angle", *lines[1:]], "deflection_deg is missing"),
        (lambda lines: [*lines[:9], "nan,0.1", *lines[9:]], "line 10: torque_output_Nm is 'nan'"),
        (lambda lines: [*lines[:9], "1.0", *lines[9:]], "line 10: deflection_deg is ''"),
        (lambda lines: [*lines[:9], "1e300,0.1", *lines[9:]], "torque_output_Nm is 1e+300 in row 9 below the header"),
        (lambda lines: [*lines[:9], "1.0,80", *lines[9:]], "deflection_deg is 80 in row 9 below the header"),
        (
            lambda lines: [lines[0], *np.random.default_rng(0).permutation(lines[1:])],
            "Check that the rows are in chronological order",
        ),
        (lambda lines: [lines[0], *(",".join(row.split(",")[::-1]) for row in lines[1:])], "Swap the two columns"),
        (lambda lines: [lines[0], *lines[:0:-1]], "reverse the order of the rows"),
        (
            lambda lines: [lines[0], *(f"{float(t) / 1000},{d}" for t, d in (row.split(",") for row in lines[1:]))],
            "If the column torque_output_Nm is in kN m, multiply it by 1000",
        ),
        (lambda lines: lines[:10], "but this one has 9"),
        (lambda lines: [lines[0], *lines[65:130]], "only one branch"),
        (lambda lines: [lines[0], *(f"{row.split(',')[0]},1.0" for row in lines[1:])], "the same in all rows"),
        (
            lambda lines: [lines[0], *(f"{t},{float(d) * 3600}" for t, d in (row.split(",") for row in lines[1:]))],
            "a drive with a locked crank has 0.0001 to 90 deg",
        ),
        (
            lambda lines: [lines[0], *(f"{t},{float(d) * DEGREE}" for t, d in (row.split(",") for row in lines[1:]))],
            "in radians",
        ),
        (
            lambda lines: [lines[0], *(f"{t},{float(d) * 60}" for t, d in (row.split(",") for row in lines[1:]))],
            "If the column deflection_deg is in arcminutes, divide it by 60",
        ),
        (
            lambda lines: [lines[0], *(f"{float(t) * 1000},{d}" for t, d in (row.split(",") for row in lines[1:]))],
            "times the rated torque of the design, 10.4 N m; at most 30 times is allowed. If the column "
            "torque_output_Nm is in N mm, divide it by 1000",
        ),
    ],
)
def test_a_bad_loop_is_refused(change, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "loop.csv"
    path.write_text("\n".join(change(rows(BENCH[0]))) + "\n", encoding="utf-8")
    code = main(["calibrate", "--design", "printed", "--loop", str(path), "--out", str(tmp_path / "out")])
    captured = capsys.readouterr()
    assert code == 2
    assert told in captured.err
    assert captured.err.count("\n") == 1
    assert not captured.out


@pytest.mark.parametrize(
    ("fit", "told"),
    [
        ("mesh_plai", "unknown parameter 'mesh_plai'"),
        ("ring.teeth", "only keys with a single real"),
        ("play,play", "listed twice"),
        ("drive.power_kw", "none of these parameters affects"),
        ("friction,hysteresis", "hysteresis and friction describe the same friction"),
        ("clearance.output_mm", "unknown parameter"),
    ],
)
def test_unsuitable_fit_parameters_are_refused(
    fit: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["calibrate", "--design", "printed", "--loop", str(BENCH[0]), "--fit", fit, "--out", str(tmp_path)]
    assert main([*words, "--quiet"]) == 2
    assert told in capsys.readouterr().err


@pytest.mark.slow
def test_the_command_writes_the_design_and_the_rest(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["calibrate", "--design", "printed", "--loop", str(BENCH[0]), "--fit", "drag"]
    assert main([*words, "--out", str(tmp_path), "--json", "--quiet"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found["parameters"]) == {"drag"}
    for one in found["parameters"].values():
        assert one["ci95"][0] <= one["value"] <= one["ci95"][1]
    for key in ("play_deg", "stiffness_nm_per_rad", "coulomb_nm"):
        assert found[key] == found["measured"][key]["value"] > 0.0
        assert found["measured"][key]["ci95"][0] <= found[key] <= found["measured"][key]["ci95"][1]
        assert found["model"][key]["value"] > 0.0
    assert found["unusable"] == []
    calibrated = load(tmp_path / "printed-calibrated.toml")
    assert calibrated.name == found["design"]
    assert calibrated.springs.friction == pytest.approx(found["parameters"]["drag"]["value"])
    page = (tmp_path / "printed-calibrated.html").read_text(encoding="utf-8")
    assert "<svg" in page
    assert ">drag<" in page
    lines = rows(tmp_path / "printed-calibrated-residuals.csv")
    left = np.array([float(line.split(",")[-1]) for line in lines[1:]])
    assert len(left) == 167
    assert found["residual_rms_deg"] == pytest.approx(math.sqrt(np.mean(left**2)))


@pytest.mark.slow
def test_a_fit_with_teeth_too_soft_to_run_names_other_parameters(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_balance(reducer: Reducer, torque: float) -> None:
        if reducer.design.stiffness != resolve("printed").stiffness:
            raise RunError("no static balance")

    monkeypatch.setattr("cycloid_mj.statics.sheet.sheet", no_balance)
    monkeypatch.setattr("cycloid_mj.robot.reduce", lambda design: None)
    words = ["calibrate", "--design", "printed", "--loop", str(BENCH[0]), "--fit", "tooth_stiffness"]
    assert main([*words, "--out", str(tmp_path), "--json", "--quiet"]) == 1
    unusable = json.loads(capsys.readouterr().out)["unusable"][0]
    assert unusable.endswith("it can be used: omit that parameter from --fit, or fit structure_stiffness instead")
    assert " 1 it can be used" not in unusable


@pytest.mark.slow
def test_a_design_of_no_use_is_reported_with_the_value_to_blame(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Statics stops where it finds no balance: here as soon as there is the constant friction that was not drawn."""

    def no_balance(reducer: Reducer, torque: float) -> None:
        if reducer.design.springs.friction > 0.0:
            raise RunError("no static balance")

    monkeypatch.setattr("cycloid_mj.statics.sheet.sheet", no_balance)
    monkeypatch.setattr("cycloid_mj.robot.reduce", lambda design: None)
    words = ["calibrate", "--design", "printed", "--loop", str(BENCH[0]), "--fit", "drag"]
    assert main([*words, "--out", str(tmp_path), "--json", "--quiet"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert "statics at 4.047 N m" in found["unusable"][0]
    drag = found["parameters"]["drag"]["value"]
    assert f"with the drawn drag instead of {drag:.4g} N m it can be used" in found["unusable"][0]


def measured_te(design: Design, torque: float, shift_deg: float, noise: float, turns: int = 1) -> tuple[Array, Array]:
    """Compute crank angles [deg] and errors [arcsec] as a bench with a crank zero of its own would have them."""
    from cycloid_mj.base.units import ARCSECOND
    from cycloid_mj.statics import transmission_error

    crank = np.linspace(0.0, 360.0 * turns, 720 * turns, endpoint=False)
    level = design.but(environment={"gravity_x": 0.0, "gravity_y": 0.0})
    reducer = Reducer(level)
    error = transmission_error(reducer, np.radians(crank + shift_deg), torque)[:, 1]
    error *= reducer.member.sense / ARCSECOND
    return crank, error + 7.0 + noise * np.random.default_rng(0).standard_normal(len(error))


def written_te(path: Path, crank: Array, error: Array) -> Path:
    lines = ["crank_deg,te_arcsec", *(f"{a!r},{b!r}" for a, b in zip(crank.tolist(), error.tolist(), strict=True))]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("member", ["carrier", "ring"])
def test_a_measured_error_is_matched_with_its_zero_angle(tmp_path: Path, member: str) -> None:
    design = unlike("few").but(errors={"pin_position": 20e-6, "seed": 3}, output={"member": member})
    path = written_te(tmp_path / "te.csv", *measured_te(design, design.rated_torque, 77.0, 0.0))
    found = compare_bench(design, read_te(path), design.rated_torque)
    assert math.degrees(found.zero) == pytest.approx(77.0, abs=0.5)
    assert found.explained_share > 0.99
    strong = found.strongest_first[:3]
    assert np.all(found.explained_shares[strong] > 0.98)
    other = compare_bench(unlike("few").but(output={"member": member}), read_te(path), design.rated_torque)
    assert other.explained_share < 0.9 * found.explained_share


def test_compare_bench_writes_files_and_prints_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    design = unlike("few")
    path = written_te(tmp_path / "te.csv", *measured_te(design, 1.0, 10.0, 0.1))
    words = ["compare-bench", "--design", str(design_file("few")), "--te", str(path), "--load-nm", "1"]
    assert main([*words, "--out", str(tmp_path), "--json", "--quiet"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["load_nm"] == 1.0
    assert {"order", "measured_arcsec", "model_arcsec", "phase_deg", "explained", "cause"} == set(found["orders"][0])
    assert (tmp_path / "few-te.png").stat().st_size > 5000


@pytest.mark.parametrize(
    ("crank", "error", "told"),
    [
        (np.linspace(0.0, 90.0, 100), np.ones(100), "at least one full turn"),
        (np.linspace(0.0, 6.28, 100), np.ones(100), "in radians"),
        (np.linspace(0.0, 360.0, 100), np.ones(100), "a transmission error must be greater than 0"),
        (np.linspace(0.0, 360.0, 100), 1e5 * np.sin(np.arange(100)), "a transmission error must be greater than 0"),
    ],
)
def test_a_bad_error_curve_is_refused(crank: Array, error: Array, told: str, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=told):
        read_te(written_te(tmp_path / "te.csv", crank, error))


def test_an_error_curve_without_its_columns_names_them(tmp_path: Path) -> None:
    path = tmp_path / "te.csv"
    path.write_text("angle,error\n1,2\n", encoding="utf-8")
    with pytest.raises(UsageError, match="crank_deg,te_arcsec"):
        read_te(path)
