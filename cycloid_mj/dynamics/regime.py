"""Warnings about settings that run but produce inaccurate results.

Each warning is one sentence: what is wrong, where, and what to change. Settings that cannot run raise an error
elsewhere.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from cycloid_mj.design import Friction
from cycloid_mj.dynamics.law import MIN_IMPEDANCE, ContactParameters, friction_leads
from cycloid_mj.dynamics.timestep import (
    SETTINGS,
    circling_limit,
    max_stiffness_ratio,
    passing_limit,
    rolling_limits,
    timestep,
)
from cycloid_mj.geometry.expansion import tooth_play
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.statics.friction import missing_friction


@dataclass(frozen=True)
class RegimeLimits:
    """Limits from which on a setting runs but produces inaccurate results."""

    min_clearance_share: float = 1e4 * 2.0**-52
    """Smallest clearance over the pin-circle radius E: gaps are accurate to 0.1 % of it, ten rounding errors of E."""
    min_samples_per_tooth: float = 8.0
    """Samples per tooth at which the transmission error of fixed pins keeps 99 % of its peak-to-peak value."""
    max_friction_lead: float = 0.15
    """Tangent of the angle by which friction leads the sliding; at 0.15 losses are correct within 1 %, at 0.3 at high
    speed a third too low."""
    max_missing_loss: float = 1e-3
    """Largest loss that is missing because parts creep, as a share of the output power."""
    max_friction_lag: float = 1e-3
    """Error of the force of sliding teeth as a share of their working force (`friction_lag`); efficiency and mean
    transmission error differ from the planar solver's by up to four times this number."""
    max_raised_mass: float = 0.01
    """Largest increase of an added mass by MuJoCo's minimum impedance, as a share of the effective mass."""


LIMITS = RegimeLimits()


ROUNDING = 1e-9
"""Relative amount by which a setting may miss a limit: messages and design files round it."""

_CREEP_REMEDY = "lower it, or set it to 0 to derive it from the sliding speed"
"""Remedy for friction that is not fully developed."""


class Compiled(Protocol):
    """The part of a built model that is checked: see ``mjcf.ReducerModel``."""

    @property
    def model(self) -> Any:
        """The compiled model."""

    @property
    def pairs(self) -> Sequence[Any]:
        """Every mating pair."""

    @property
    def laws(self) -> Mapping[str, ContactParameters]:
        """The contact law of each kind of pair."""


def model_warnings(reducer: Reducer, model: Compiled) -> tuple[str, ...]:
    """Return all warnings about the accuracy of a compiled MuJoCo model: time step, friction, clearances, bent pins.

    Each is a sentence on a condition in which results are less accurate.
    """
    timestep_s = model.model.opt.timestep  # by mesh contact it may be shorter than the design's
    stiffness_texts = [
        text for kind, law in model.laws.items() for text in _stiffness_warning(reducer, kind, law, timestep_s)
    ]
    return (
        *_rolling_warnings(reducer, timestep_s),
        *stiffness_texts,
        *_lead_warning(reducer, model),
        *_orbit_warning(reducer, model),
        *_raised_mass_warnings(model),
        *static_warnings(reducer, model.laws),
    )


def static_warnings(reducer: Reducer, kinds: Iterable[str]) -> tuple[str, ...]:
    """Return the warnings that apply even if motion is so slow that neither time step nor mass matters.

    They are about bent output pins, pins that two discs press, clearances of the `kinds` of pairs, such as ``cam``, and
    friction coefficients without effect.
    """
    has_output_pins = not isinstance(reducer, RvReducer)
    return (
        *(bent_pin_warning(reducer) if has_output_pins else ()),
        *_shared_pin_warnings(reducer),
        *(text for kind in kinds for text in _clearance_warning(reducer, kind)),
        *_unused_friction_warnings(reducer),
    )


def _shared_pin_warnings(reducer: Reducer) -> Iterator[str]:
    """Yield a warning if warm discs preload the teeth, so that several discs press the same moving pin at a time.

    With two discs, a pin tilts, and has a contact with its seat in the plane of each disc. With more discs, it does not
    tilt, and has a single contact with its seat. Massless pins have a seat for each disc, as in statics.
    """
    design = reducer.design
    if design.gear.discs > 1 and not design.has_tilting_pins and design.ring.has_pin_bodies and tooth_play(design) < 0:
        massless = "massless_sleeved" if design.ring.has_sleeves else "massless"
        yield (
            f"ring.pins = {design.ring.pins}: warm discs preload the teeth, and a pin that several discs press moves "
            "as a rigid body without tilt, so that the efficiency is up to 2.5 percentage points too high; set "
            f"ring.pins to {massless}, which has a seat for each disc"
        )


def tooth_passing_rate(reducer: Reducer) -> float:
    """Compute how many teeth pass a contact per second at the design's crank speed [1/s]."""
    return reducer.design.ring.teeth * abs(reducer.speed_against_ring) / (2.0 * math.pi)


def lowest_log_rate(reducer: Reducer) -> float:
    """Compute the log rate [Hz] with `LIMITS.min_samples_per_tooth` at the design's crank speed."""
    return LIMITS.min_samples_per_tooth * tooth_passing_rate(reducer)


def pace_warnings(reducer: Reducer, min_steps: float = SETTINGS.min_steps_per_tooth) -> tuple[str, ...]:
    """Return the warnings about accuracy that depend on the design's speed; empty for a crank at rest.

    They are those of time steps and log samples per tooth, and `creep_warning`. `min_steps` is the number of time steps
    from tooth to tooth that the solver of the run needs.
    """
    if not (tooth_rate := tooth_passing_rate(reducer)):
        return ()
    return (
        *_step_warning(reducer, tooth_rate, min_steps),
        *_sample_warning(reducer, tooth_rate),
        *creep_warning(reducer),
    )


def _step_warning(reducer: Reducer, tooth_rate: float, min_steps: float) -> Iterator[str]:
    """Yield a warning if fewer than `min_steps` time steps pass from tooth to tooth.

    `tooth_rate` is the tooth passing frequency [Hz].
    """
    timestep_s, max_step = timestep(reducer), passing_limit(reducer, min_steps)
    if timestep_s > max_step * (1.0 + ROUNDING):
        yield (
            f"settings.timestep_us = {1e6 * timestep_s:g}: a tooth passes in only "
            f"{1.0 / (tooth_rate * timestep_s):.3g} time steps "
            f"({math.degrees(abs(reducer.design.drive.speed)) * timestep_s:.3g} deg of crank rotation per step), so "
            f"forces and ripple are wrong and peaks are cut; reduce it to {_below(1e6 * max_step)}, or reduce "
            "drive.speed_rpm"
        )


def _sample_warning(reducer: Reducer, tooth_rate: float) -> Iterator[str]:
    """Yield a warning if a tooth passes in fewer than `LIMITS.min_samples_per_tooth` log samples.

    A log has at most one sample per step. `tooth_rate` is the tooth passing frequency [Hz].
    """
    design = reducer.design
    rate, min_rate = min(design.settings.log_rate, 1.0 / timestep(reducer)), LIMITS.min_samples_per_tooth * tooth_rate
    if rate < min_rate * (1.0 - ROUNDING):
        yield (
            f"settings.log_rate_hz = {design.settings.log_rate:g}: only {rate / tooth_rate:.2g} samples per passing "
            f"tooth ({tooth_rate:.4g} teeth per second), so transmission error, peaks and rms values may be too low; "
            f"raise it to {_above(min_rate)} or more, or reduce drive.speed_rpm"
        )


def creep_warning(reducer: Reducer) -> Iterator[str]:
    """Yield a warning if parts slide so slowly that friction below its Coulomb limit makes the losses too low.

    The condition is that the missing loss exceeds the fraction `LIMITS.max_missing_loss` of the output power.
    """
    missing_share, missing_loss = missing_friction(reducer)
    if missing_loss > LIMITS.max_missing_loss:
        yield (
            f"contact.creep_speed_mm_s = {1e3 * reducer.contacts.creep_speed:g}: parts slide too slowly for full "
            f"friction at this crank speed and load; the losses of teeth and output are about {missing_share:.0%} too "
            f"low and the efficiency is {100.0 * missing_loss:.2g} percentage points too high; {_CREEP_REMEDY}"
        )


def joint_creep_warning(runs: Mapping[str, Reducer]) -> Iterator[str]:
    """Yield one common `creep_warning` for all runs to which it applies, with their names; nothing if there are none.

    `runs` maps the name of each run to its reducer.
    """
    names_by_error: dict[str, list[str]] = {}
    for name, reducer in runs.items():
        missing_share, missing_loss = missing_friction(reducer)
        if missing_loss > LIMITS.max_missing_loss:
            names_by_error.setdefault(
                f"{missing_share:.0%} and {100.0 * missing_loss:.2g} percentage points", []
            ).append(name)
    if names_by_error:
        count = sum(len(names) for names in names_by_error.values())
        error_texts = "; ".join(f"{error_text} ({', '.join(names)})" for error_text, names in names_by_error.items())
        yield (
            f"contact.creep_speed_mm_s: parts slide too slowly for full friction in {count} of {len(runs)} runs; "
            f"losses of teeth and output are too low and the efficiency is too high, by about {error_texts}; "
            f"{_CREEP_REMEDY}"
        )


def stiffness_ratio(law: ContactParameters, seconds: float) -> float:
    """Compute K dt^2/m [1]: the square of the time step over the contact's own time sqrt(m/K)."""
    return law.stiffness * seconds**2 / law.effective_mass


def _rolling_warnings(reducer: Reducer, timestep_s: float) -> Iterator[str]:
    """Yield a warning for each part whose rolling in its clearance the time step `timestep_s` [s] does not resolve.

    Such parts are the discs on their cams and moving pins in their seats (`rolling_limits`).
    """
    for part, max_step in rolling_limits(reducer).items():
        if timestep_s > max_step * (1.0 + ROUNDING):
            yield (
                f"settings.timestep_us = {1e6 * timestep_s:g} is too long for the rolling of {part}: speeds and losses "
                f"are wrong; reduce it to {_below(1e6 * max_step)}, or set it to 0 for the automatic choice"
            )


def _stiffness_warning(reducer: Reducer, kind: str, law: ContactParameters, timestep_s: float) -> Iterator[str]:
    """Yield a warning if K dt^2/m of a kind of pair exceeds its limit (`max_stiffness_ratio`).

    `kind` is the kind of pair and `law` its contact law, with the stiffness K and the effective mass m; `timestep_s` is
    the time step dt [s].
    """
    max_ratio, ratio = max_stiffness_ratio(reducer, kind), stiffness_ratio(law, timestep_s)
    if ratio > max_ratio * (1.0 + ROUNDING):
        max_step = timestep_s * math.sqrt(max_ratio / ratio)
        yield (
            f"{kind}: a stiffness of {law.stiffness:.3g} N/m is too high for a time step of {1e6 * timestep_s:g} us: "
            f"results are valid up to K dt^2/m = {max_ratio:g}, and it is {ratio:.3g}; reduce settings.timestep_us to "
            f"{_below(1e6 * max_step)}, or reduce stiffness.{kind}_n_m"
        )


def _lead_warning(reducer: Reducer, model: Compiled) -> Iterator[str]:
    """Yield a warning if MuJoCo's friction leads the sliding velocity by more than `LIMITS.max_friction_lead`.

    `model` is the compiled model. On an orbiting disc, the direction of friction leads that of the sliding velocity by
    an angle, whose tangent is limited (`friction_leads`). The warning names the kind of pair with the largest angle.
    """
    lead_by_kind = friction_leads(reducer, model.laws, float(model.model.opt.impratio))
    kind = max(lead_by_kind, key=lambda pair_kind: lead_by_kind[pair_kind], default="")
    if kind and lead_by_kind[kind] > LIMITS.max_friction_lead:
        yield (
            f"{kind}: friction leads the sliding by {math.degrees(math.atan(lead_by_kind[kind])):.3g} deg of crank "
            f"rotation at this speed and working force, so losses are too low; reduce settings.timestep_us to "
            f"{_below(1e6 * model.model.opt.timestep * LIMITS.max_friction_lead / lead_by_kind[kind])}"
        )


def friction_lag(reducer: Reducer, law: ContactParameters, seconds: float) -> float:
    """Estimate the error of the friction of sliding teeth in a time step of `seconds`, over their working force [1].

    The reference acceleration of a contact is corrected by its acceleration in the previous step
    (`reference_correction`), which has rotated by w dt since then. The estimate is (mu D c w^2/F) w dt, with the time
    step dt, the friction coefficient mu and the added mass D of the tooth contact's `law`, its working force F, the
    eccentricity c and the crank speed w.
    """
    design = reducer.design
    speed, kind = abs(reducer.orbit_speed), design.tooth_pair
    force = reducer.contacts[kind].force / design.lines(kind)
    return law.friction * law.added_mass * design.gear.eccentricity * speed**3 * seconds / force


def _orbit_warning(reducer: Reducer, model: Compiled) -> Iterator[str]:
    """Yield a warning if the time step is too long for the circular orbit of the discs.

    The limits are `circling_limit`, and a `friction_lag` of `LIMITS.max_friction_lag`. They apply to models with exact
    profiles and a moving crank.
    """
    kind, timestep_s = reducer.design.tooth_pair, float(model.model.opt.timestep)
    if kind not in model.laws or not model.model.nuser_geom or not reducer.design.drive.speed:
        return
    lag, max_step = friction_lag(reducer, model.laws[kind], timestep_s), circling_limit(reducer)
    if lag > LIMITS.max_friction_lag:
        max_step = min(max_step, timestep_s * math.sqrt(LIMITS.max_friction_lag / lag))
    if timestep_s > max_step * (1.0 + ROUNDING):
        yield (
            f"settings.timestep_us = {1e6 * timestep_s:g} is too long for discs that orbit at this crank speed: mean "
            "transmission error and efficiency may be wrong by more than 0.3 %; reduce it to "
            f"{_below(1e6 * max_step)}, or reduce drive.speed_rpm"
        )


def _clearance_warning(reducer: Reducer, kind: str) -> Iterator[str]:
    """Yield a warning if the clearance of a `kind` of pair, such as ``cam``, is at the rounding error of computed gaps.

    The limit is the pin-circle radius times `LIMITS.min_clearance_share`. Kinds without a clearance in the design have
    no warning.
    """
    min_clearance = LIMITS.min_clearance_share * reducer.design.ring.pin_circle_radius
    clearance = getattr(reducer.design.clearance, kind, min_clearance)  # that of springs may be any
    if clearance < min_clearance:
        yield (
            f"clearance.{kind}_um = {1e6 * clearance:g} is below the numerical noise of the gap computation; "
            f"raise it to {_above(1e6 * min_clearance)} or more"
        )


def _raised_mass_warnings(compiled: Compiled) -> Iterator[str]:
    """Yield a warning for each kind of contact whose added mass MuJoCo's minimum impedance raises by over 1 %.

    The added mass is the inverse 1/R [kg] of MuJoCo's regularisation R of a contact: the contact acts as if it had this
    mass. Its impedance is at least `MIN_IMPEDANCE`, and so the added mass at least a share of the mass of both bodies.
    The increase counts relative to the effective mass (`LIMITS.max_raised_mass`). The first pair of mating surfaces of
    each kind is evaluated. `compiled` is the compiled model. Only models with contacts of exact profiles are evaluated,
    not those with contacts of meshes.
    """
    model = compiled.model
    # only geoms of exact profiles have user data; `pair.on` and `pair.by` are the geoms of a pair
    pair_by_kind = {pair.kind: pair for pair in reversed(compiled.pairs)} if model.nuser_geom else {}
    for kind, pair in pair_by_kind.items():
        law = compiled.laws[kind]
        inverse_weight = sum(model.body_invweight0[model.geom(name).bodyid[0], 0] for name in (pair.on, pair.by))
        min_added_mass = MIN_IMPEDANCE / (1.0 - MIN_IMPEDANCE) / float(inverse_weight)
        if min_added_mass - law.added_mass > LIMITS.max_raised_mass * law.effective_mass:
            yield (
                f"{kind}: MuJoCo's minimum impedance, {MIN_IMPEDANCE:g}, raises the added mass of this contact from "
                f"{law.added_mass:.3g} to {min_added_mass:.3g} kg, {min_added_mass / law.effective_mass:.1%} of the "
                f"mass that moves on it; use heavier parts or fewer contacts (ring.teeth, output.pins)"
            )


def bent_pin_warning(reducer: Reducer) -> Iterator[str]:
    """Yield a warning if output pins bend so far under one disc that they press on the back of another disc's holes.

    Runs neglect this contact (docs/decisions.md). C(d', d) is the deflection of the pin at disc d' per force in disc d
    [m/N], k the stiffness of the pin's contact and needles [N/m], and g = C(d, d) + 1/k the compliance at disc d, g'
    that at d'. A force F in disc d moves the pin into the back of disc d' by s = F (C(d', d) - g) minus twice the
    clearance. The contact force f there also acts on disc d, which increases the bending: f g' = s + f (C(d', d) - g).
    The share f/F is an upper limit, because disc d seldom carries the full load.
    """
    flexibility, output = reducer.contacts.pin_flexibility, reducer.contacts["output"]
    force, compliances = reducer.design.gear.discs * output.force, 1.0 / np.array(output.stiffness_by_disc)
    relative_flexibility = flexibility - compliances
    overlaps_rigid = force * relative_flexibility - 2.0 * reducer.design.clearance.output
    if overlaps_rigid.max() > 0.0:
        other_disc, disc = np.unravel_index(int(overlaps_rigid.argmax()), overlaps_rigid.shape)
        overlap, compliance = (
            float(overlaps_rigid[other_disc, disc]),
            float(compliances[other_disc] - relative_flexibility[other_disc, disc]),
        )
        share = min(overlap / (compliance * force), 1.0) if compliance > 0.0 else 1.0
        yield (
            f"output pins bend: when disc {disc + 1} carries {force:.3g} N, they press on the back of the holes of "
            f"disc {other_disc + 1}, by {1e6 * overlap:.3g} um. Runs neglect this contact, which moves up to "
            f"{share:.1%} of the load from disc to disc, so their load shares and wind-up differ from those of statics "
            '(`measure loads`); stiffen the pins: output.support = "both_ends", output.rollers = false or a larger '
            "output.core_radius_mm"
        )


def _unused_friction_warnings(reducer: Reducer) -> Iterator[str]:
    """Yield a warning for each coefficient of sliding friction that has no effect because its pair has rollers."""
    design = reducer.design
    remedy_by_kind = {"cam": ('gear.bearing = "plain"', design.gear.bearing == "rolling")}
    remedy_by_kind |= {"output": ("output.rollers = false", design.output.has_needles)}
    for kind, (remedy, has_rollers) in remedy_by_kind.items():
        coefficient = getattr(design.friction, kind)
        if has_rollers and coefficient not in (0.0, getattr(Friction(), kind)):
            yield (
                f"friction.{kind} = {coefficient:g} has no effect with rollers: set friction.{kind}_rolling, or "
                f"{remedy}"
            )


def _below(limit: float) -> str:
    """Return the next lower 1, 2 or 5 times a power of ten, so that a remedy is clear of the limit."""
    power_of_ten = 10.0 ** math.floor(math.log10(limit))
    return f"{max(digit for digit in (0.5, 1.0, 2.0, 5.0) if digit < limit / power_of_ten) * power_of_ten:g}"


def _above(limit: float) -> str:
    """Return the next higher 1, 2 or 5 times a power of ten."""
    power_of_ten = 10.0 ** math.floor(math.log10(limit))
    return f"{min(digit for digit in (2.0, 5.0, 10.0) if digit > limit / power_of_ten) * power_of_ten:g}"
