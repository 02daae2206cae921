"""Automatic choice of the time step of MuJoCo runs.

The step is the longest at which results stay accurate, or ``settings.timestep``. Four limits apply:

- A contact of stiffness K under the mass m oscillates at sqrt(K/m). The added mass of `law.contact_law` makes any step
  stable; results are accurate up to a limit of K dt^2/m.
- A moving pin of mass m under the force F rolls in its clearance like a ball in a bowl of stiffness
  F/(clearance + F/K), and so does the disc on its cam. No added mass acts across the force, so the step must follow.
- Teeth must not pass too fast.
- Discs must stay close to their circular orbit within a step.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from cycloid_mj.base import names
from cycloid_mj.parts import moving_masses, output_inertia, pin_mass_matrix, turning_inertia
from cycloid_mj.reducer import Reducer, RvReducer, once


@dataclass(frozen=True)
class MujocoStepSettings:
    """Limits of the time step of MuJoCo runs; the stiffness ratio is K dt^2/m."""

    max_stiffness_ratio: float = 6.4
    """Largest ratio, except for seats of moving pins; from 8.7 on, rms speeds of the disc are over 6 % off."""
    max_seat_ratio: float = 10.0
    """Largest ratio for seats of moving pins under a load: only the pin's own oscillation depends on it. At 9.9
    mean values are 0.02 % off, peak-to-peak transmission errors 0.7 %. From 15 on the run diverges."""
    max_idle_seat_ratio: float = 8.3
    """Largest ratio for these seats without a load: at 9.5 pins start to oscillate unless their contacts settle."""
    max_settling_ratio: float = 32.0
    """Largest ratio for contacts of moving pins that settle within a step (`may_settle`): rms speeds, losses and forces
    of eight starts are those at 0.7 within their standard error."""
    max_rolling_share: float = 0.5
    """Share of the longest step at which a pin that rolls in its clearance stays bounded, 2 sqrt(m/k): at 0.50 the rms
    of the disc's speed is 1 % off. A stiff cam without clearance diverges at 0.55."""
    min_steps_per_tooth: float = 25.0
    """Time steps from tooth to tooth: at 25 the cam force at 20 000 rpm is 0.09 % off, at 8 it is 0.5 %."""
    max_sagitta: float = 0.2
    """Sagitta of a disc's path in a step, dt^2 c w^2/12, as a share of clearance and deflection of the mesh: at 0.19
    efficiency and mean transmission error of two discs are 0.17 % off, at 0.75 they are 0.5 %."""
    max_step: float = 10e-6
    """[s]: a fifth of the time constant of the servo on the crank."""


SETTINGS = MujocoStepSettings()


@dataclass(frozen=True)
class TimeStep:
    """A time step [s], and the reason for it."""

    seconds: float
    reason: str

    def __str__(self) -> str:
        return f"{1e6 * self.seconds:g} us ({self.reason})"


def timestep(reducer: Reducer) -> float:
    """Return the time step [s] at which a design is run."""
    return choose_step(reducer).seconds


@once
def choose_step(reducer: Reducer) -> TimeStep:
    """Return the time step of a design and the reason for it: ``settings.timestep``, or an automatic choice if it is 0.

    The automatic step is the longest within `step_limits` that divides the time between two log samples.
    """
    fixed_step, log_rate = reducer.design.settings.timestep, reducer.design.settings.log_rate
    if fixed_step:
        return TimeStep(fixed_step, "given")
    max_step_by_reason = {"largest allowed step": SETTINGS.max_step, "log rate": 1.0 / log_rate}
    return divide_sample_time(log_rate, max_step_by_reason | step_limits(reducer))


def divide_sample_time(rate: float, allowed: Mapping[str, float]) -> TimeStep:
    """Return the longest step that divides 1/`rate` [1/Hz] and does not exceed the `allowed` steps [s], by reason."""
    reason, max_step = min(allowed.items(), key=lambda item: item[1])
    return TimeStep(1.0 / (rate * math.ceil(1.0 / (rate * max_step) - 1e-9)), f"automatic: {reason}")


class StepAccuracy(NamedTuple):
    """Accuracy of loaded results, in words: with moving pins, with massless pins, and of all other designs."""

    moving: str
    massless: str
    others: str


ACCURACY = StepAccuracy(
    "mean values within 0.1 %, peak-to-peak values within 3 %, rms speeds within 15 % (moving pins chatter)",
    "mean values within 0.2 %; peaks and rms speeds are not valid, because they depend on the inertia of the pins",
    "mean values within 0.3 %, peak-to-peak values and rms speeds within 2 %",
)
"""Accuracy of MuJoCo runs, against half the step and against the planar solver."""


@dataclass(frozen=True)
class StepRule:
    """Choice of the time step for one solver.

    Attributes
    ----------
    choose
        Returns the time step of a design.
    min_steps_per_tooth
        Smallest number of time steps from tooth to tooth.
    accuracy
        Accuracy of results at the automatic time step.
    """

    choose: Callable[[Reducer], TimeStep]
    min_steps_per_tooth: float
    accuracy: StepAccuracy


def describe_accuracy(reducer: Reducer, accuracy: StepAccuracy = ACCURACY) -> str:
    """Describe in words which results of a run are accurate at the time step of a design, and how accurate.

    `accuracy` has these words for the solver of the run.
    """
    design = reducer.design
    if design.settings.timestep:
        return "not known, as the design sets the step: compare the results with those at half the step"
    if not design.load.torque:
        return (
            "only ranges over independent starts are valid: without load, the motion within the clearances is chaotic"
        )
    if design.ring.has_pin_bodies:
        return accuracy.moving
    return accuracy.massless if design.ring.has_massless_pins else accuracy.others


def step_limits(reducer: Reducer, must_follow: bool = False) -> dict[str, float]:
    """Return the longest step [s] that each criterion allows: stiffness of contacts, rolling, tooth passing, orbit.

    Keys describe the criteria, such as "stiffness of cam"; `TimeStep.reason` states the one that is decisive. The
    oscillation of moving pins on their contacts need not be resolved where `may_settle` is true, unless `must_follow`
    is set.
    """
    limits = {
        f"stiffness of {kind}": math.sqrt(
            max_stiffness_ratio(reducer, kind, must_follow) * mass / max(reducer.contacts[kind].stiffness_by_disc)
        )
        for kind, mass in effective_masses(reducer).items()
    }
    limits |= {f"rolling of {part}": limit for part, limit in rolling_limits(reducer).items()}
    if reducer.design.drive.speed:
        limits["tooth passing"] = passing_limit(reducer)
        limits["orbit of the discs"] = circling_limit(reducer)
    return limits


def max_stiffness_ratio(reducer: Reducer, kind: str, must_follow: bool = False) -> float:
    """Return the upper limit of K dt^2/m [1] at which results are valid: one of four values in `SETTINGS`.

    K is the stiffness and m the effective mass of a contact, and dt the time step. `kind` is a kind of pair in the
    design, such as ``pin_gear`` or ``cam``. The limit is larger where `may_settle` is true, unless `must_follow` is
    set. It also differs for seats of moving pins, with and without a load.
    """
    design = reducer.design
    if may_settle(reducer, kind) and not must_follow:
        return SETTINGS.max_settling_ratio
    if not design.ring.has_pin_bodies or kind != design.seat_pair:
        return SETTINGS.max_stiffness_ratio
    return SETTINGS.max_seat_ratio if design.load.torque else SETTINGS.max_idle_seat_ratio


def may_settle(reducer: Reducer, kind: str) -> bool:
    """Return whether the time step may be too long to resolve the oscillation of contacts of a kind of pair.

    This is true for contacts of moving pins that are pressed by weight and rotation alone; they then settle within a
    step. It is false for

    - designs with a load or a preloaded ring, whose step must resolve the rolling of the pins anyway;
    - designs that set a working load or force, because they will be loaded;
    - the contact law IMPACT, which has a time step of its own;
    - designs that set the time step.
    """
    design, contact = reducer.design, reducer.design.contact
    is_loaded = design.load.torque or design.ring.preload or contact.working_load or contact.working_force
    is_pin_contact = design.ring.has_pin_bodies and kind in ("pin_gear", design.seat_pair)
    return is_pin_contact and not is_loaded and contact.law == "line" and not design.settings.timestep


def rolling_limits(reducer: Reducer) -> dict[str, float]:
    """Return the longest step [s] that resolves the rolling of each part in its clearance, by the name of the motion.

    Names are, for example, "the disc on its cam" and "pins in their clearance". The limit is
    `SETTINGS.max_rolling_share` times the longest stable step 2 sqrt(m/k), with the mass m of the part and its rolling
    stiffness k = F/(clearance + F/K) under the working force F, for the contact stiffness K.
    """
    design = reducer.design
    disc_mass, _, pin_mass = _part_masses(reducer)
    if isinstance(reducer, RvReducer):
        mass_share, clearance = disc_mass / reducer.cranks.count, reducer.bearing_clearance
        limits = {"the disc on its cranks": _rolling_limit(reducer, names.CRANK_BEARING, mass_share, clearance)}
    else:
        limits = {"the disc on its cam": _rolling_limit(reducer, "cam", disc_mass, design.clearance.cam)}
    if design.ring.has_pin_bodies:
        limits["pins in their clearance"] = _rolling_limit(reducer, design.seat_pair, pin_mass, design.pin_play)
    return limits


def _rolling_limit(reducer: Reducer, kind: str, mass: float, clearance: float) -> float:
    contact = reducer.contacts[kind]
    stiffness = contact.force / (max(clearance, 0.0) + contact.force / contact.stiffness_by_disc[0])
    return SETTINGS.max_rolling_share * 2.0 * math.sqrt(mass / stiffness)


def passing_limit(reducer: Reducer, steps: float = SETTINGS.min_steps_per_tooth) -> float:
    """Return the longest step [s] with so many `steps` from tooth to tooth at the design's crank speed."""
    return 2.0 * math.pi / (steps * reducer.design.ring.teeth * abs(reducer.speed_against_ring))


def circling_limit(reducer: Reducer) -> float:
    """Return the longest step [s] in which discs stay close to their orbit (`MujocoStepSettings.max_sagitta`)."""
    design = reducer.design
    contact, play = reducer.contacts[design.tooth_pair], getattr(design.clearance, design.tooth_pair) + design.pin_play
    play_and_deflection = play + contact.force / contact.stiffness_by_disc[0]
    return math.sqrt(
        12.0 * SETTINGS.max_sagitta * play_and_deflection / (design.gear.eccentricity * reducer.orbit_speed**2)
    )


def effective_masses(reducer: Reducer) -> dict[str, float]:
    """Compute the effective mass [kg] that oscillates on a contact of each kind of mating pair, by kind (``cam``).

    Half of the ring contacts and of the output contacts of each disc carry load at a time. A free pin, or a sleeve,
    lies between two contacts. The loaded member moves by its rotation: the lever arm of ring forces is at most c N,
    with the eccentricity c and the number N of ring teeth.
    """
    design = reducer.design
    disc_mass, inertia_of_output, pin_mass = _part_masses(reducer.shape)
    ring_inertia, carrier_inertia = (
        (inertia_of_output, math.inf) if design.output.turns_ring else (math.inf, inertia_of_output)
    )
    if isinstance(reducer, RvReducer):
        mobility_by_kind = _rv_mobility(reducer, 0.0 if math.isinf(carrier_inertia) else 1.0 / turning_inertia(reducer))
    else:
        carrier_mobility = design.gear.discs * design.output.pin_circle_radius**2 / carrier_inertia
        mobility_by_kind = {
            "cam": 1.0 / disc_mass,
            "output": (1.0 / disc_mass + carrier_mobility) * design.output.pins / 2.0,
        }
    if design.ring.has_pin_bodies:
        mobility_by_kind |= {"pin_gear": 2.0 * (1.0 / disc_mass + 1.0 / pin_mass), design.seat_pair: 2.0 / pin_mass}
    else:
        moment_arm = design.gear.eccentricity * design.ring.teeth
        ring_mobility = design.gear.discs * moment_arm**2 / ring_inertia
        mobility_by_kind[design.tooth_pair] = (1.0 / disc_mass + ring_mobility) * design.ring.teeth / 2.0
    return {kind: 1.0 / mobility_of_kind for kind, mobility_of_kind in mobility_by_kind.items()}


def _rv_mobility(reducer: RvReducer, carrier_mobility: float) -> dict[str, float]:
    """Return the inverse effective mass [1/kg] at crank bearings and planet meshes of an RV reducer, by kind of pair.

    The n bearings of a disc share its effective mass: n times the larger of the disc's mobilities, in the plane or by
    its rotation relative to the carrier. At a planet mesh, the mobility of the planet's rotation is added to n times
    the larger of the sun's: by its rotation, or 1/(2 m) of a floating sun of mass m sideways. `carrier_mobility` is the
    inverse inertia of the carrier with its cranks [1/(kg m2)]; it is 0 if the carrier is fixed.
    """
    crank_count, planet_mesh, masses = reducer.cranks.count, reducer.planet_mesh, moving_masses(reducer)
    disc_masses, crank_masses, sun_masses = masses[reducer.gears[0]], masses[names.CRANK], masses[names.SUN]
    rotation_mobility = reducer.crank_radius**2 * (
        1.0 / disc_masses.inertia[2, 2] + reducer.design.gear.discs * carrier_mobility
    )
    sun_inertia = float(sun_masses.inertia[2, 2]) + reducer.design.drive.rotor_inertia
    sideways_mobility = 0.5 / sun_masses.mass if reducer.planet.sun_support == "floating" else 0.0
    sun_mobility = crank_count * max(planet_mesh.sun_base**2 / sun_inertia, sideways_mobility)
    return {
        names.CRANK_BEARING: crank_count * max(1.0 / disc_masses.mass, float(rotation_mobility)),
        names.PLANET_MESH: sun_mobility + planet_mesh.planet_base**2 / float(crank_masses.inertia[2, 2]),
    }


@once
def _part_masses(reducer: Reducer) -> tuple[float, float, float]:
    """Return the mass of a disc [kg], the inertia of the output [kg m2] and the mass of a moving pin [kg], or 0.

    That of a tilting pin is its effective mass at the plane of a disc.
    """
    pin_mass = 0.0
    if reducer.design.ring.has_pin_bodies:
        mass_matrix = pin_mass_matrix(reducer)
        pin_mass = (
            float(mass_matrix[0, 0] - mass_matrix[0, 1] ** 2 / mass_matrix[1, 1])
            if len(mass_matrix) > 1
            else float(mass_matrix[0, 0])
        )
    return moving_masses(reducer)[reducer.gears[0]].mass, output_inertia(reducer), pin_mass


MUJOCO_RULE = StepRule(choose_step, SETTINGS.min_steps_per_tooth, ACCURACY)
"""The time step of MuJoCo runs."""
