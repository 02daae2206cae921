"""Test bench of the static measures: locked crank, slow torque on the output, angle of the output.

The motion is so slow that inertia does not matter, so time steps may be longer than in a run at speed. A free pin or
sleeve is the exception: pressed between disc and socket by a force F, it rolls in its clearance delta like a ball in a
bowl, with the stiffness F/(delta + F/K) across the force and its own mass m. The step must resolve this oscillation, or
be stable where friction keeps the pin in place. A run that fails is repeated with half the step.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import ContactError, RunError
from cycloid_mj.base.record import Run
from cycloid_mj.design import Drive, Friction, Load, Settings
from cycloid_mj.design.layouts import applies
from cycloid_mj.design.model import NO_FRICTION
from cycloid_mj.dynamics.drive_cycle import Signal, locked_crank
from cycloid_mj.dynamics.law import FRICTION
from cycloid_mj.dynamics.mjcf import ReducerModel, build
from cycloid_mj.dynamics.planar import timestep as planar_steps
from cycloid_mj.dynamics.planar.model import PlanarModel, planar_model
from cycloid_mj.dynamics.regime import static_warnings
from cycloid_mj.dynamics.run import Solver, simulate
from cycloid_mj.dynamics.settling import output_period
from cycloid_mj.geometry import ideal_loads
from cycloid_mj.parts.gear import tooth_profile
from cycloid_mj.reducer import Reducer, RvReducer, once


@dataclass(frozen=True)
class BenchSettings:
    """Settings of the time step and the contacts of runs with a locked crank and a slow torque."""

    max_step: float = 10e-6
    """Longest time step [s]: bodies as heavy as the disc follow a slow torque as with any shorter one."""
    max_planar_step: float = 0.5 * planar_steps.SETTINGS.max_step
    """Longest time step of the planar solver without a turning crank [s]: with longer ones a free pin without friction
    chatters.

    Clearance of a free pin on the disc alone, pressed for 1 to 3 times the usual time: at 17.5 us equal within 0.003 %,
    at 23 us within 1 %, at 35 us within 14 %.
    """
    steps_per_swing: float = 16.0
    """Time steps in an oscillation of the output on all contacts where no pins and planets move; used if that step is
    longer.

    With a longer step friction is fully developed from a lower speed on (`prepare_bench`), so the loops of soft drives
    come nearer to those of statics. Plastic drives with 60 to 250 um at the nominal torque and oscillations of 1.9 to
    3.1 ms differ from statics with friction and weight by 1 to 5 % of lost motion at 17.5 us and by 0.1 to 5 % at this
    step, and by 3 to 14 % and 3 to 11 % of stiffness; without friction both steps differ by less than 0.2 %.
    """
    pin_step: float = 0.5
    """Time step relative to the stability limit 2 sqrt(m/k) of a pressed pin that rolls in its clearance."""
    held_pin_step: float = 1.5
    """The same if friction keeps the pin in place, which works up to about twice that limit (36 and 21 free pins)."""
    max_halvings: int = 3
    """Number of times that the time step of a failed run is halved."""
    contact_step: float = 2.0
    """Time step for which contacts are designed, over that of the run. The added mass of a run is the smallest that is
    stable, and light pins with a long step would oscillate on it. Four times as much stops this, and does not affect a
    slow motion."""
    friction_step: float = 3.0
    """Further factor on that step for contacts with friction: their added mass, which does not affect a slow motion, is
    larger by its square, and their creep speed may be lower by as much."""
    damping_ratio: float = 1.0
    """Damping of contacts as a share of critical: parts that cross their play settle soon; at rest it has no effect."""


BENCH = BenchSettings()


def crank_angles(reducer: Reducer, count: int) -> Array:
    """Return crank angles [rad], shape (count,), spread over the turn and, at equal distances, over the mesh period."""
    period = np.round(reducer.mesh_periods * np.arange(count) / count)
    return np.asarray(2.0 * np.pi / reducer.mesh_periods * (period + np.arange(count) / count))


def without_friction(reducer: Reducer) -> Reducer:
    """Return a copy of a design without friction and weight, as closed forms of backlash and stiffness assume."""
    design = reducer.design
    friction_values = {key: value for key, value in NO_FRICTION.items() if applies(design.layout, "friction", key)}
    friction = Friction().model_copy(update=friction_values)
    no_gravity = design.environment.model_copy(update={"gravity_x": 0.0, "gravity_y": 0.0})
    changes: dict[str, Any] = {"friction": friction, "environment": no_gravity}
    if design.planet is not None:
        changes["planet"] = design.planet.model_copy(update={"friction": 0.0})
    return type(reducer)(design.model_copy(update=changes))


def bench_timestep(reducer: Reducer, torque: float, solver: Solver = "planar") -> float:
    """Return the time step [s] of a run with locked crank, from the design file or else the longest stable time step.

    With MuJoCo and moving pins, the longest time step is proportional to the stability limit 2 sqrt(m/k) of the pin
    with the largest ideal force F under the output `torque` [N m]. The pin has the mass m. Its seat has the secant
    stiffness k = F/d, where d is the clearance of the pin plus the deflection of the contact under F. `solver` is the
    solver of the runs, MuJoCo or the planar solver.
    """
    design = reducer.design
    if design.settings.timestep:
        return design.settings.timestep
    if solver == "planar":
        # the planets of an RV reducer oscillate on the sun much faster than its output
        if design.ring.has_pin_bodies or isinstance(reducer, RvReducer):
            return BENCH.max_planar_step
        return max(BENCH.max_planar_step, output_period(reducer) / BENCH.steps_per_swing)
    ring, seat_pair = design.ring, "pin_sleeve" if design.ring.has_sleeves else "pin_socket"
    if not ring.has_pin_bodies or torque == 0.0:
        return BENCH.max_step
    pins_stick = min(design.friction_of("pin_gear"), design.friction_of(seat_pair)) > 0.0
    bore_radius = ring.sleeve_bore_radius if ring.has_sleeves else 0.0
    mass = math.pi * (ring.pin_radius**2 - bore_radius**2) * design.gear.face_width * design.material_of("pin").density
    force = float(ideal_loads.ideal_load_sharing(tooth_profile(design), abs(torque), 0.0).forces.max())
    rolling_stiffness = force / (design.pin_play + force / reducer.contacts[seat_pair].stiffness)
    return min(
        BENCH.max_step,
        (BENCH.held_pin_step if pins_stick else BENCH.pin_step) * 2.0 * math.sqrt(mass / rolling_stiffness),
    )


def prepare_bench(
    reducer: Reducer,
    torque: float,
    duration: float,
    samples: int,
    step_divisor: float = 1.0,
    solver: Solver = "planar",
    damping_ratio: float = BENCH.damping_ratio,
) -> Reducer:
    """Return the design with time step, contact damping, duration and log rate for a slow run with locked crank.

    Below the creep speed, the friction of the model is viscous and would nearly vanish in a slow motion. The creep
    speed is therefore as low as the time step allows.

    Parameters
    ----------
    reducer
        The drive.
    torque
        Largest torque on the output [N m].
    duration, samples
        Duration of the run [s], and number of its samples.
    step_divisor
        Divisor of the time step.
    solver
        Solver of the run.
    damping_ratio
        Damping of the contacts as a share of critical.
    """
    design = reducer.design
    timestep = bench_timestep(reducer, torque, solver) / step_divisor
    min_creep_speed = _max_friction_force(reducer) / (
        FRICTION.impratio * BENCH.friction_step**2 * reducer.contacts[design.tooth_pair].stiffness * timestep
    )
    creep_speed = min(design.contact.creep_speed or math.inf, min_creep_speed or reducer.contacts.creep_speed)
    contact_changes = {"damping_ratio": damping_ratio, "creep_speed": creep_speed}
    return type(reducer)(
        design.model_copy(
            update={
                "contact": design.contact.model_copy(update=contact_changes),
                "drive": design.drive.model_copy(update={"ramp": 0.0, "hold": duration}),
                "settings": design.settings.model_copy(update={"timestep": timestep, "log_rate": samples / duration}),
            }
        )
    )


def locked_run(reducer: Reducer, crank_angle: float, torque: Signal, solver: Solver = "planar") -> Run:
    """Simulate a design at a locked crank angle [rad] with an output `torque` [N m] over time.

    The design is from `prepare_bench`, which sets time step and duration. `solver` is the solver of the runs, MuJoCo or
    the planar solver.
    """
    timestep, driven_angle = reducer.design.settings.timestep, float(reducer.member.driven_angle(crank_angle))
    if solver == "planar":
        model = _build_planar_model(
            reducer.but(drive={"ramp": 0.0, "hold": 1.0}, settings={"log_rate": 1.0 / timestep}), timestep
        )
        return simulate(reducer.design, model, locked_crank(model, driven_angle, torque))
    contact_timestep = timestep * BENCH.contact_step * (BENCH.friction_step if _max_friction_force(reducer) else 1.0)
    drive = Drive(rotor_inertia=reducer.design.drive.rotor_inertia)
    bench_tables = {"drive": drive, "load": Load(), "settings": Settings(timestep=contact_timestep)}
    compiled_model = _build_mujoco_model(type(reducer)(reducer.design.model_copy(update=bench_tables)), timestep)
    return simulate(reducer.design, compiled_model, locked_crank(compiled_model, driven_angle, torque))


def run_with_step_retries(
    reducer: Reducer,
    crank_angle: float,
    torque: Signal,
    max_torque: float,
    duration: float,
    samples: int,
    step_divisor: float = 1.0,
    solver: Solver = "planar",
    damping_ratio: float = BENCH.damping_ratio,
) -> Run:
    """Simulate a design with a locked crank; repeat a failed run with half the time step.

    `prepare_bench` determines the first time step, with a low creep speed for the slow motion.

    Parameters
    ----------
    reducer
        The drive.
    crank_angle
        Angle at which the crank is locked [rad].
    torque
        Function from times [s] to torques on the output [N m].
    max_torque
        Largest torque [N m].
    duration, samples
        Duration of the run [s], and number of its samples.
    step_divisor
        Divisor of the first time step.
    solver
        Solver of the run.
    damping_ratio
        Damping of the contacts as a share of critical.

    Returns
    -------
    Run
        The run; `timestep_of` returns its time step.

    Raises
    ------
    RunError
        The run failed at the shortest time step, too.
    """
    last_timestep, problem = 0.0, None
    for halvings in range(BENCH.max_halvings + 1):
        divisor = step_divisor * 2.0**halvings
        prepared_reducer = prepare_bench(reducer, max_torque, duration, samples, divisor, solver, damping_ratio)
        last_timestep = prepared_reducer.design.settings.timestep
        try:
            return locked_run(prepared_reducer, crank_angle, torque, solver)
        except (RunError, ContactError) as error:
            problem = error
    raise RunError(
        f"{reducer.design.name}: the simulation with the {reducer.INPUT} locked at a crank angle of "
        f"{math.degrees(crank_angle):.1f} deg and up to {max_torque:.4g} N m on the output failed, even after halving "
        f"the time step {BENCH.max_halvings} times to {1e6 * last_timestep:.3g} us: {problem}. Reduce the torque"
    ) from problem


def timestep_of(run: Run) -> float:
    """Return the time step of a run [s]."""
    return float(run.provenance["timestep_s"])


def timesteps_text(runs: Iterable[Run]) -> str:
    """Format the time steps of runs in microseconds, the longest first."""
    return " and ".join(f"{1e6 * step:.3g} us" for step in sorted({timestep_of(run) for run in runs}, reverse=True))


@once
def _build_mujoco_model(reducer: Reducer, timestep: float) -> ReducerModel:
    """Build the MuJoCo model once for all crank angles, with a time step [s]; a run does not change it."""
    compiled = build(reducer.design)
    compiled = replace(compiled, warnings=static_warnings(reducer, compiled.laws))
    compiled.spec.option.timestep = compiled.model.opt.timestep = timestep
    return compiled


@once
def _build_planar_model(reducer: Reducer, timestep: float) -> PlanarModel:
    """Build a planar model once for all crank angles."""
    return planar_model(reducer, timestep=timestep)


def _max_friction_force(reducer: Reducer) -> float:
    """Return the largest friction force of all contacts at their working forces [N]."""
    return max(reducer.design.friction_of(kind) * reducer.contacts[kind].force for kind in reducer.clearance_keys)


def centre_lead(run: Run, reducer: Reducer) -> Array:
    """Compute how far the disc's centre leads its ideal position on the eccentric's circle [m] in n samples, (n,).

    Positive is counter-clockwise; with several discs it is their mean.
    """
    leads, crank_angle = [], reducer.member.crank_angle(run[f"{run.driven_shaft}_angle"])
    for disc_name, phase in zip(reducer.gears, reducer.phases, strict=True):
        (x, y, _), eccentric_angle = names.planar_joints(disc_name), crank_angle + phase
        leads.append(-run[x] * np.cos(eccentric_angle) - run[y] * np.sin(eccentric_angle))
    return np.asarray(np.mean(leads, axis=0))
