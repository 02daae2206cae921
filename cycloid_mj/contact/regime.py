"""Bad regimes: settings with which a run goes through, and its numbers are not the design's.

Each is told in one line: what, where, and what to change. What cannot run at all is an error elsewhere.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Protocol

from cycloid_mj.contact.law import LEAST_IMPEDANCE, ContactLaw
from cycloid_mj.design import Design, Friction

LARGEST_SHIFT = 1 / 3
"""Most that the added mass may lower a contact's own frequency, as a share of it.

Figures at rated load are right at 0.32 (fixed pins and nonpin at 10 us) and 5 % off at 0.50 (free pins at 2 us).
"""

CHATTER = 4.0
"""K dt^2/m from which a contact may chatter.

Measured at 36 N m on fixed pins with an ever stiffer cam: none up to 4.6, 15 and 7.7 at 2, 5 and 10 us; from 6.1, 19
and 12 on the gear's speed error is three to ten times as large. The explicit step without added mass bears 4 at most.
"""

LONGEST_STEP = {True: 1e-6, False: 10e-6}
"""Longest time step with right figures at rated load [s], with and without moving pins, on the paper's designs."""

RESOLVED = 1.0
"""K dt^2/m up to which a longer step is right as well: heavier or softer parts than the paper's."""

NOISE = 1e4 * 2.0**-52
"""Least clearance as a share of E. Gaps are right to some ten roundings of E: to a thousandth of it."""

FEWEST_STEPS = 25.0
"""Fewest steps from tooth to tooth.

Fixed pins at 20 N m, 5000 to 20 000 rpm, against a tenth of the step: at 33 steps the efficiency is right within 0.05
points and the transmission error within 1 %, at 17 within 0.7 points and 2 %, at 8 the efficiency is 102 %.
"""

FEWEST_SAMPLES = 8.0
"""Fewest samples from tooth to tooth.

A sine sampled at as many per period keeps 92 % of its peak to peak at least; the transmission error of fixed pins keeps
99 %, at 3 samples 87 to 98 %, at one 50 to 97 %.
"""

RAISED = 0.01
"""Share of the effective mass by which MuJoCo may raise an added mass without a word."""


class Reducer(Protocol):
    """What is judged of a built model: see ``mjcf.ReducerModel``."""

    @property
    def model(self) -> Any:
        """The compiled model."""

    @property
    def pairs(self) -> Sequence[Any]:
        """Every mating pair."""

    @property
    def laws(self) -> Mapping[str, ContactLaw]:
        """The contact law of each kind of pair."""


def warnings(design: Design, reducer: Reducer) -> tuple[str, ...]:
    """Tell every bad regime of a built design: what, where, and what to change; nothing where there is none."""
    resolved = [text for kind, law in reducer.laws.items() for text in _resolution(design, kind, law)]
    return (*_step(design, reducer.laws), *resolved, *_clamped(reducer), *at_rest(design, reducer.laws))


def at_rest(design: Design, kinds: Iterable[str]) -> tuple[str, ...]:
    """Tell those that count even where all motion is so slow that neither step nor mass has an effect."""
    return (*(text for kind in kinds for text in _noise(design, kind)), *_unused(design))


def pace(design: Design) -> tuple[str, ...]:
    """Tell where a run at the design's crank speed has too few steps or samples from tooth to tooth."""
    passing = design.ring.teeth * abs(design.drive.speed) / (2.0 * math.pi)
    return (*_few_steps(design, passing), *_few_samples(design, passing)) if passing else ()


def _few_steps(design: Design, passing: float) -> Iterator[str]:
    """Tell of a crank that turns too far in a step; teeth pass ``passing`` times a second."""
    step, longest = design.settings.timestep, 1.0 / (FEWEST_STEPS * passing)
    if step > longest * (1.0 + 1e-9):
        yield (
            f"settings.timestep_us = {1e6 * step:g}: the crank turns by "
            f"{math.degrees(abs(design.drive.speed)) * step:.3g} deg in a step, and a tooth passes in "
            f"{1.0 / (passing * step):.3g} steps: powers and efficiency are wrong, peaks are cut; shorten it to "
            f"{_below(1e6 * longest)} or lower drive.speed_rpm"
        )


def _few_samples(design: Design, passing: float) -> Iterator[str]:
    """Tell of a log too coarse for a tooth's passing; it holds a sample a step at most."""
    rate, least = min(design.settings.log_rate, 1.0 / design.settings.timestep), FEWEST_SAMPLES * passing
    if rate < least * (1.0 - 1e-9):
        yield (
            f"settings.log_rate_hz = {design.settings.log_rate:g} gives {rate / passing:.2g} samples of each passing "
            f"tooth ({passing:.4g} a second): transmission error, peaks and rms may read too low; raise it to "
            f"{_above(least)} or more, or lower drive.speed_rpm"
        )


def frequency_shift(law: ContactLaw) -> float:
    """Give how much the added mass 1/R lowers a contact's own frequency: 1 - sqrt(m / (m + 1/R))."""
    return 1.0 - math.sqrt(law.effective_mass / (law.effective_mass + law.added_mass))


def steps_ratio(law: ContactLaw, timestep: float) -> float:
    """Give K dt^2/m [1]: the square of the time step over the contact's own time sqrt(m/K)."""
    return law.stiffness * timestep**2 / law.effective_mass


def _step(design: Design, laws: Mapping[str, ContactLaw]) -> Iterator[str]:
    """Tell of a step that the figures are known not to bear, unless the parts are heavier or softer."""
    moving, step = design.ring.has_pin_bodies, design.settings.timestep
    longest = LONGEST_STEP[moving]
    ring = [law for kind, law in laws.items() if kind not in ("cam", "output")]
    if step > longest * (1.0 + 1e-9) and max(steps_ratio(law, step) for law in ring) > RESOLVED:
        what = {True: "moving pins are light: at 2 us their figures are off by 5 %", False: "the teeth chatter beyond"}
        yield (
            f"settings.timestep_us = {1e6 * step:g} is longer than {1e6 * longest:g} us ({what[moving]}); "
            f"shorten it to {1e6 * longest:g} us"
        )


def _resolution(design: Design, kind: str, law: ContactLaw) -> Iterator[str]:
    """Tell of a contact that the step does not resolve, by its stiffness or by its damping."""
    step, shift = design.settings.timestep, frequency_shift(law)
    if shift <= LARGEST_SHIFT:
        return
    ratio = steps_ratio(law, step)
    bearable = law.effective_mass / (1.0 - LARGEST_SHIFT) ** 2
    damped = law.damping * step > law.stiffness * step**2
    longest = bearable / law.damping if damped else math.sqrt(bearable / law.stiffness)
    worse = ", so it may chatter" if ratio > CHATTER else ""
    cause = f"a damping of {_ratio(law):.3g}" if damped else f"a stiffness of {law.stiffness:.3g} N/m"
    yield (
        f"{kind}: {cause} is too large for a step of {1e6 * step:g} us: K dt^2/m = {ratio:.3g}, and the added mass "
        f"that it needs lowers the contact's own frequency by {shift:.0%}{worse}; shorten settings.timestep_us to "
        f"{_below(1e6 * longest)} or lower {'damping' if damped else 'stiffness'}.{kind}"
        f"{'' if damped else '_n_m'}"
    )


def _noise(design: Design, kind: str) -> Iterator[str]:
    clearance, least = getattr(design.clearance, kind), NOISE * design.ring.pin_circle_radius
    if clearance < least:
        yield (
            f"clearance.{kind}_um = {1e6 * clearance:g} is below the numerical noise of the gaps; "
            f"raise it to {_above(1e6 * least)} or more"
        )


def _clamped(reducer: Reducer) -> Iterator[str]:
    """Tell of an added mass that MuJoCo's least impedance raises."""
    model = reducer.model
    first = {pair.kind: pair for pair in reversed(reducer.pairs)} if model.nuser_geom else {}
    for kind, pair in first.items():
        law = reducer.laws[kind]
        weight = sum(model.body_invweight0[model.geom(name).bodyid[0], 0] for name in (pair.on, pair.by))
        least = LEAST_IMPEDANCE / (1.0 - LEAST_IMPEDANCE) / float(weight)
        if least - law.added_mass > RAISED * law.effective_mass:
            yield (
                f"{kind}: MuJoCo's least impedance, {LEAST_IMPEDANCE:g}, raises the added mass from "
                f"{law.added_mass:.3g} to {least:.3g} kg, {least / law.effective_mass:.1%} of what moves on it; "
                f"heavier parts or fewer contacts (ring.teeth, output.pins) avoid it"
            )


def _unused(design: Design) -> Iterator[str]:
    """Tell of a sliding friction that was given where rollers run."""
    rolling = {"cam": ('gear.bearing = "plain"', design.gear.bearing == "rolling")}
    rolling |= {"output": ("output.rollers = false", design.output.rollers)}
    for kind, (change, rolls) in rolling.items():
        given = getattr(design.friction, kind)
        if rolls and given not in (0.0, getattr(Friction(), kind)):
            yield (
                f"friction.{kind} = {given:g} has no effect where rollers run: set friction.{kind}_rolling, or {change}"
            )


def _ratio(law: ContactLaw) -> float:
    return law.damping / (2.0 * math.sqrt(law.stiffness * law.effective_mass))


def _below(number: float) -> str:
    """Give the next lower of 1, 2 and 5 times a power of ten: a remedy should not lie on the limit."""
    ten = 10.0 ** math.floor(math.log10(number))
    return f"{max(digit for digit in (0.5, 1.0, 2.0, 5.0) if digit < number / ten) * ten:g}"


def _above(number: float) -> str:
    """Give the next higher one."""
    ten = 10.0 ** math.floor(math.log10(number))
    return f"{min(digit for digit in (2.0, 5.0, 10.0) if digit > number / ten) * ten:g}"
