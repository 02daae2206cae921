"""The time step of a design: the one given, or the longest at which its figures hold.

Four things set it. A contact of stiffness K under the mass m swings at sqrt(K/m): the added mass of `law.contact_law`
keeps any step stable, and up to `RESOLVED` the figures are right. A moving pin of mass m under the force F rolls in its
play like a ball in a bowl, and so does the gear on its cam, with the stiffness F/(play + F/K) across the force: no
added mass acts there, so the step must follow it. And teeth must not pass, nor discs circle, too fast.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from cycloid_mj.base import names
from cycloid_mj.parts import moving_masses, output_inertia
from cycloid_mj.reducer import Reducer, once

RESOLVED = 6.4
"""K dt^2/m of a contact up to which the figures of a run hold, but for the seat of a moving pin, see `SEATED`.

Fixed pins, cam and output pins: at 8.7 the rms of the gear's speed is 6 % off, from 12 to 40 on they chatter.
"""

SEATED, SEATED_IDLE = 10.0, 8.3
"""The same for the contact of a moving pin with its seat, under a load and without one.

Only the pin's own ringing between both contacts feels it. Free pins at 0.98 to 1.02 of the rated load against half the
step: the rms of the gear's speed differs by -5 to 8 % at 9.9 and by -3 to 12 % at 6.4, as it does from one load to the
next; peak to peak of the transmission error by 0.7 %, all means by 0.02 %. Sleeves: the rms by 1.8 %. From 15 on, where
the rolling below is at 0.55, the run goes wrong. Without load the rms spreads over ten starts at 8.2 as at 6.4, 4.5 to
7.6 and 4.4 to 11.0 mrad/s; at 9.5 as well, but there pins come to ring, unless their contacts settle.
"""

SETTLING = 32.0
"""The same for both contacts of a moving pin that settle within the step, as without a load they may.

Mean over eight starts of 2.4 turns of free pins at 1640 rpm, and its standard error: rms of the gear's speed 11.8 (0.1)
mrad/s at 32 and at 0.7, peak to peak of the transmission error 19.6 (0.1) and 19.4 (0.1) arcsec, losses 37.6 (0.3) and
37.6 (0.2) mW, the cam's force 6.63 (0.05) and 6.62 (0.04) N; but of the pins that touch, which bounce, 8 do for 10.
"""

ROLLING = 0.5
"""Share of the longest step at which a pin rolling in its play stays bounded, 2 sqrt(m/k), k the bowl's stiffness.

At 0.50 the rms of the gear's speed is 1 % off, at 0.74 the efficiency 0.2 points (free pins with 0.2 um of play). A
stiff cam without play goes wrong between 0.94 and 1.02, and with other contacts on the gear between 0.55 and 0.66.
"""

FEWEST_STEPS = 25.0
"""Fewest steps from tooth to tooth.

Fixed pins at 20 N m and 20 000 rpm against 1 us: at 25 steps the cam's force is 0.09 % off and the rms of the gear's
speed 0.1 %, at 17 0.17 and 1 %, at 8 0.5 and 8 %; the efficiency is right within 0.1 points at all of them.
"""

MAX_SAGITTA = 0.2
"""Largest sagitta of a disc's path in a step, dt^2 c w^2/12, as a share of play and deflection of the mesh.

Two discs with 0.1 and 0.35 um of play at 5000 to 30 000 rpm, friction of the teeth 0.05 and 0.15, 5 to 100 % load,
against the planar solver at 0.5 us: efficiency and mean transmission error differ by at most 0.11 % up to a share of
0.05, by up to 0.17 % at 0.19 (0.4 % at 0.15 of friction and 5 % load, of which `regime` warns) and by 0.5 % at 0.75.
"""

LONGEST = 10e-6
"""Longest step [s] that is chosen: a fifth of the time constant of the servo that turns the crank."""


@dataclass(frozen=True)
class Step:
    """A time step [s], and why it is this one."""

    seconds: float
    reason: str

    def __str__(self) -> str:
        """Tell both."""
        return f"{1e6 * self.seconds:g} us ({self.reason})"


def timestep(reducer: Reducer) -> float:
    """Compute the time step [s] that a design is run at."""
    return chosen(reducer).seconds


@once
def chosen(reducer: Reducer) -> Step:
    """Return the time step of a design and its reason: ``settings.timestep``, or the longest that `limits` allow.

    A chosen step is at most `LONGEST`, and a whole number of them lies between two samples of the log.
    """
    timestep, rate = reducer.design.settings.timestep, reducer.design.settings.log_rate
    if timestep:
        return Step(timestep, "given")
    allowed = {"largest allowed step": LONGEST, "log rate": 1.0 / rate}
    return whole_in_samples(rate, allowed | limits(reducer))


def whole_in_samples(rate: float, allowed: Mapping[str, float]) -> Step:
    """Choose the longest step that is `allowed` by reason [s], and whole times between samples at a `rate` [Hz]."""
    reason, longest = min(allowed.items(), key=lambda item: item[1])
    return Step(1.0 / (rate * math.ceil(1.0 / (rate * longest) - 1e-9)), f"automatic: {reason}")


class StepAccuracy(NamedTuple):
    """How near figures under a load are, in words: with moving pins, without these pins' inertia, and of all others."""

    moving: str
    massless: str
    others: str


ACCURACY = StepAccuracy(
    "mean values within 0.1 %, peak-to-peak values within 3 %, rms speeds within 15 % (moving pins chatter)",
    "mean values within 0.2 %; peaks and rms speeds are not valid, because they depend on the inertia of the pins",
    "mean values within 0.3 %, peak-to-peak values and rms speeds within 2 %",
)
"""Against half the step, and a witness.

Moving pins chatter: the rms of the gear's speed of 20 lobes at 3000 rpm is 74, 84 and 78 mrad/s at 2.9, 1.4 and 1 us,
where means agree within 0.01 %; an integrator without constraints reads 73 and 81 at 1 and 0.5 us.
"""


def held_figures(reducer: Reducer, accuracy: StepAccuracy = ACCURACY) -> str:
    """Tell for which figures the step of a design was chosen, and how near they are."""
    design = reducer.design
    if design.settings.timestep:
        return "given by the design; compare the results with those at half the step"
    if not design.load.torque:
        return "ranges over independent starts only: without load, the motion within the clearances is chaotic"
    if design.ring.has_pin_bodies:
        return accuracy.moving
    return accuracy.massless if design.ring.has_massless_pins else accuracy.others


def limits(reducer: Reducer, followed: bool = False) -> dict[str, float]:
    """Map what limits the step of a design to the longest step [s] that it allows.

    Moving pins may settle on their contacts where `settles` says so, unless they are to be `followed`.
    """
    bounds = {
        f"stiffness of {kind}": math.sqrt(resolved(reducer, kind, followed) * mass / max(reducer.contacts[kind].series))
        for kind, mass in effective_masses(reducer).items()
    }
    bounds |= {f"rolling of {what}": limit for what, limit in rolling_limits(reducer).items()}
    if reducer.design.drive.speed:
        bounds["tooth passing"] = passing_limit(reducer)
        bounds["orbit of the discs"] = circling_limit(reducer)
    return bounds


def resolved(reducer: Reducer, kind: str, followed: bool = False) -> float:
    """Compute the K dt^2/m of a kind of pair [1] up to which the figures of a run hold; `followed` as of `limits`."""
    design = reducer.design
    if settles(reducer, kind) and not followed:
        return SETTLING
    if not design.ring.has_pin_bodies or kind != design.seat_pair:
        return RESOLVED
    return SEATED if design.load.torque else SEATED_IDLE


def settles(reducer: Reducer, kind: str) -> bool:
    """Tell whether a kind of pair may settle within a chosen step that does not follow its swing.

    The contacts of moving pins may where nothing presses them but their weight and their turning. Under a load the step
    must follow their rolling anyway; what has the stiffness of a load is made to be pressed, on a bench or by a course,
    and slices are lifted by their damping, of which settling takes more; and the law IMPACT has its own.
    """
    design, contact = reducer.design, reducer.design.contact
    pressed = design.load.torque or design.ring.preload or contact.working_load or contact.working_force
    of_pins = design.ring.has_pin_bodies and kind in ("pin_gear", design.seat_pair)
    return of_pins and not pressed and contact.law == "line" and not design.settings.timestep


def rolling_limits(reducer: Reducer) -> dict[str, float]:
    """Map what rolls in its play under its working force to the longest step [s] that follows it."""
    design = reducer.design
    gear, _, pin = _masses(reducer)
    bounds = {"the disc on its cam": _rolling_limit(reducer, "cam", gear, design.clearance.cam)}
    if design.ring.has_pin_bodies:
        bounds["pins in their clearance"] = _rolling_limit(reducer, design.seat_pair, pin, design.pin_play)
    return bounds


def _rolling_limit(reducer: Reducer, kind: str, mass: float, play: float) -> float:
    contact = reducer.contacts[kind]
    bowl = contact.force / (play + contact.force / contact.series[0])
    return ROLLING * 2.0 * math.sqrt(mass / bowl)


def passing_limit(reducer: Reducer, fewest: float = FEWEST_STEPS) -> float:
    """Compute the longest step [s] for the teeth that pass at the design's crank speed, so many steps each."""
    design = reducer.design
    return 2.0 * math.pi / (fewest * design.ring.teeth * abs(float(reducer.member.against_ring(design.drive.speed))))


def circling_limit(reducer: Reducer) -> float:
    """Compute the longest step [s] in which discs stay near their circle; see `MAX_SAGITTA`."""
    design = reducer.design
    contact, play = reducer.contacts[design.tooth_pair], getattr(design.clearance, design.tooth_pair) + design.pin_play
    room = play + contact.force / contact.series[0]
    return math.sqrt(12.0 * MAX_SAGITTA * room / (design.gear.eccentricity * design.drive.speed**2))


def effective_masses(reducer: Reducer) -> dict[str, float]:
    """Compute the mass [kg] that moves on a contact of each kind of pair.

    Half of the ring's and of the output's contacts carry at a time, on each disc; a free pin, or a sleeve, lies between
    two. What the load is on gives way by its turning: forces on the ring pass its axis at c N at most.
    """
    design = reducer.design
    gear, output, pin = _masses(reducer.shape)
    arms = {"carrier": design.output.pin_circle_radius, "ring": design.gear.eccentricity * design.ring.teeth}
    turning = {
        member: design.gear.discs * (member == design.output.member) * arms[member] ** 2 / output for member in arms
    }
    mobility = {"cam": 1.0 / gear, "output": (1.0 / gear + turning["carrier"]) * design.output.pins / 2.0}
    if design.ring.has_pin_bodies:
        mobility |= {"pin_gear": 2.0 * (1.0 / gear + 1.0 / pin), design.seat_pair: 2.0 / pin}
    else:
        mobility[design.tooth_pair] = (1.0 / gear + turning["ring"]) * design.ring.teeth / 2.0
    return {kind: 1.0 / mobile for kind, mobile in mobility.items()}


@once
def _masses(reducer: Reducer) -> tuple[float, float, float]:
    """Compute a gear's mass [kg], the output's inertia [kg m2] and a moving pin's mass [kg], 0 for none, of a shape."""
    masses = moving_masses(reducer)
    pin = masses[names.PIN].mass if reducer.design.ring.has_pin_bodies else 0.0
    return masses[reducer.gears[0]].mass, output_inertia(reducer), pin
