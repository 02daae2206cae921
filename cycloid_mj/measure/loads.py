"""Loads of all ring pins or teeth, output pins and the cam over a crank turn, Hertz pressures, and the capacity."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array, cross
from cycloid_mj.base.engine import Progress, each_in_threads, silent
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Curve, Quantity, by_key
from cycloid_mj.base.units import RPM
from cycloid_mj.design import Named, resolve
from cycloid_mj.design.materials import SHAKEDOWN_PRESSURE, YIELD_PRESSURE
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.dynamics.settling import penetration_limit
from cycloid_mj.geometry import ideal_loads
from cycloid_mj.geometry.profile import unit
from cycloid_mj.measure.conditions import halve_time_step
from cycloid_mj.measure.contact_pressure import CARRYING_SHARE, ContactPressures, contact_pressures
from cycloid_mj.measure.measurement import Measurement
from cycloid_mj.measure.reaction import of_discs
from cycloid_mj.measure.steady import SETTLING_TIME, run_steady, steady_design
from cycloid_mj.parts.gear import tooth_profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.contact import CONTACT, STRIBECK
from cycloid_mj.statics.ideal import ideal_peak
from cycloid_mj.statics.sheet import disc_shares, reaction_quantities


@dataclass(frozen=True)
class LoadSettings:
    """Settings of the loads, and of the fixed-point iteration for the capacity."""

    periods: int = 2
    """Mesh periods of the runs with half the time step, and of those for the capacity."""
    max_iterations: int = 4
    capacity_rtol: float = 0.01
    """Iterations of the capacity at most, and its relative tolerance."""
    max_penetration: float = 1e-3
    """Largest penetration of a contact that a design may allow [m]."""
    per_period: int = 24
    """Crank angles of ideal load sharing in a mesh period."""
    shown: int = 4
    """Number of contacts of a kind whose forces are drawn."""


LOADS = LoadSettings()


CAPACITIES = {
    "capacity": ("capacity: torque at which a contact first yields, below its surface", YIELD_PRESSURE),
    "capacity_shakedown": ("shakedown limit: largest torque with elastic repeated rolling", SHAKEDOWN_PRESSURE),
}
"""Names of the capacities, and the largest pressure at each, relative to the yield strength."""
CONFORMAL = "none: the surfaces are conformal, so the contact is not a narrow strip"
UNPRESSED = "none: nothing presses on these contacts"
UNDECIDED = "none: no contact is both pressed and narrow enough for Hertz"

IDEAL = {"cam": "ideal sharing, rigid cam without play", "tooth": "ideal sharing, arcs alone"}
RIGID_CAM = (
    "; the reference is for a rigid cam without clearance and is nearly reached with --set stiffness.cam_n_m=1e11: "
    "with the compliance of the cam's bearing, assumed where no stiffness is set, the disc moves sideways, and other "
    "teeth carry"
)
_CRANK, _FORCE = "crank angle [deg]", "force [N]"

Kinds = Mapping[str, ContactPressures]


@shows_progress
def loads(
    design: Named,
    load: float | None = None,
    quick: bool = False,
    progress: Progress = silent,
    solver: Solver = "planar",
) -> Measurement:
    """Measure the loads of a design over a crank turn.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file; its crank speed is that of the run.
    load
        Torque on the output [N m], more than 0; by default the rated one.
    quick
        Whether to run some mesh periods instead of a full turn.
    progress, solver
        Called after each run with the numbers of finished and of all runs; solver of the runs.

    Returns
    -------
    Measurement
        Figures with their numerical errors and closed forms, curves and tables.

    Raises
    ------
    UsageError
        The torque is not positive.
    DesignError
        The crank does not turn.
    RunError
        A run failed.
    """
    reducer = Reducer(resolve(design))
    torque = reducer.design.rated_torque if load is None else load
    if not torque > 0.0:
        raise UsageError(f"the torque is {torque:g} N m, which is out of range: give more than 0 N m")
    loaded = steady_design(reducer).but(load={"torque": torque})
    last = 3  # two runs and the capacities
    periods = LOADS.periods if quick else reducer.mesh_periods
    run, finer = _run_at_two_steps(loaded, periods, solver, lambda done, _: progress(done, last))
    contacts, fine = contact_pressures(run, loaded), contact_pressures(finer, loaded)
    coarse = contact_pressures(run.select(slice(0, len(finer))), loaded)
    limits, lasting = (_limits(contacts, loaded, allowed) for _, allowed in CAPACITIES.values())
    missed = {kind: _peak_excess(loaded, contact) for kind, contact in contacts.items()}
    weakest = min(limits, key=lambda kind: limits[kind], default="")
    unsure = missed[weakest] + _pressure_error(contacts[weakest], coarse[weakest], fine[weakest]) if weakest else 0.0
    capacity, shakedown = (
        _capacity(key, loaded, weakest, torque * factors[weakest], unsure, solver) if weakest else _no_capacity(key)
        for key, factors in (("capacity", limits), ("capacity_shakedown", lasting))
    )
    progress(last, last)
    by_kind = (_of_kind(loaded, contacts[kind], coarse[kind], fine[kind], missed[kind]) for kind in contacts)
    discs = _of_discs(run, finer, loaded) if reducer.design.gear.discs > 1 else ()
    return Measurement(
        measure="loads",
        design=reducer.design,
        condition=f"{torque:.4g} N m, {abs(reducer.design.drive.speed) / RPM:.0f} rpm, {SOLVERS[solver]}",
        quantities=by_key(*by_kind, discs, [capacity, shakedown]),
        curves=_curves(contacts, loaded),
        assumptions=_assumptions(loaded),
        runs={"loaded": run},
        details={"load_torque_nm": torque, **_capacity_details(reducer, torque, weakest, limits, lasting)},
    )


def _run_at_two_steps(reducer: Reducer, periods: int, solver: Solver, progress: Progress) -> list[Run]:
    """Run a loaded drive for some mesh periods, and for `LOADS.periods` at half of the time step."""
    tasks = [(reducer, periods), (halve_time_step(reducer, solver), LOADS.periods)]
    return each_in_threads(lambda task: run_steady(task[0], SETTLING_TIME, task[1], solver), tasks, progress)


def _capacity_details(
    reducer: Reducer, torque: float, weakest: str, limits: Mapping[str, float], lasting: Mapping[str, float]
) -> dict[str, Any]:
    """Convert the torques at which each kind reaches its limits to JSON values, by factors on a torque [N m]."""
    return {
        "nominal_torque_nm": reducer.design.rated_torque,
        "rated_torque_nm": reducer.design.rated_torque,  # the former key, for one release
        "weakest": weakest,
        "capacity_by_kind_nm": {kind: torque * factor for kind, factor in limits.items()},
        "shakedown_by_kind_nm": {kind: torque * factor for kind, factor in lasting.items()},
    }


def _pressure_error(contacts: ContactPressures, coarse: ContactPressures, fine: ContactPressures) -> float:
    """Compute the relative error of the force by that of the largest pressure, which is proportional to its root.

    The pressures of all samples and of those with half the time step are compared with the first mesh periods.
    """
    ratios = (each.peak_pressure / coarse.peak_pressure for each in (contacts, fine))
    return sum(2.0 * abs(ratio - 1.0) for ratio in ratios)


def _peak_excess(reducer: Reducer, contacts: ContactPressures) -> float:
    """Compute the relative excess of a kind's largest force over the turn above that of the samples, by ideal sharing.

    It is 0 where the samples cover the turn.
    """
    turn = np.linspace(0.0, 2.0 * math.pi, LOADS.per_period * reducer.design.ring.teeth + 1)
    return max(0.0, ideal_peak(reducer, contacts.kind, turn) / ideal_peak(reducer, contacts.kind, contacts.angle) - 1.0)


def _no_capacity(key: str) -> Quantity:
    """Return a capacity without a value: no contact determines it."""
    return Quantity(key, CAPACITIES[key][0], math.nan, "N m", note=UNDECIDED)


def _capacity(key: str, reducer: Reducer, weakest: str, torque: float, unsure: float, solver: Solver) -> Quantity:
    """Compute the torque at which the weakest kind reaches the pressure of a capacity, by fixed-point iteration.

    `torque` is the start, `unsure` the relative error of the forces of the runs.
    """
    name, allowed = CAPACITIES[key]
    allowed_depth = penetration_limit(reducer)
    for _ in range(LOADS.max_iterations):
        # penetration grows with the force: its limit is to detect failed runs, so it grows as well
        deeper = min(allowed_depth * max(1.0, torque / reducer.design.load.torque), LOADS.max_penetration)
        guess = reducer.but(load={"torque": torque}, contact={"max_penetration": deeper})
        run = run_steady(guess, SETTLING_TIME, LOADS.periods, solver)
        factor = _limits(contact_pressures(run, reducer), reducer, allowed).get(weakest)
        if factor is None:
            return _no_capacity(key)
        before, torque = torque, torque * factor
        if abs(torque - before) < LOADS.capacity_rtol * torque:
            break
    rated = reducer.design.rated_torque
    note = (
        f"limited by {weakest}, whose largest pressure reaches {allowed:.3g} x the yield strength at "
        f"{torque / rated:.2f} of the rated {rated:.4g} N m; over {LOADS.periods} mesh periods"
    )
    return Quantity(key, name, torque, "N m", error=abs(torque - before) + unsure * torque, note=note)


def _of_kind(
    reducer: Reducer, contacts: ContactPressures, coarse: ContactPressures, fine: ContactPressures, missed: float
) -> Iterator[Quantity]:
    """Yield the quantities of one kind.

    Errors: change with half the time step over the first mesh periods, plus the error by the samples' part of the turn:
    of a peak `missed`, relative to the force; of a mean half its change between the halves of the samples.
    """
    kind = contacts.kind
    allowed = YIELD_PRESSURE * reducer.contacts[kind].strength
    peak_error = abs(coarse.peak_force - fine.peak_force) + missed * contacts.peak_force
    one, other = contacts.halves
    mean_error = abs(coarse.mean_force - fine.mean_force) + 0.5 * abs(one.mean_force - other.mean_force)
    pressure = contacts.peak_pressure
    pressure_error = abs(coarse.peak_pressure - fine.peak_pressure) + 0.5 * missed * pressure
    yield Quantity(
        f"{kind}_peak_force",
        f"{kind}: largest force",
        contacts.peak_force,
        "N",
        peak_error,
        ideal_peak(reducer, kind, contacts.angle),
        IDEAL.get(kind, "ideal sharing"),
        f"at {math.degrees(contacts.peak_angle):.0f} deg of crank{RIGID_CAM if kind == 'cam' else ''}",
    )
    name = f"{kind}: mean force of the loaded contacts"
    yield Quantity(f"{kind}_mean_force", name, contacts.mean_force, "N", mean_error)
    name = f"{kind}: loaded contacts, mean number"
    error = abs(coarse.carrying - fine.carrying) + 0.5 * abs(one.carrying - other.carrying)
    yield Quantity(f"{kind}_carrying", name, contacts.carrying, "1", error)
    name = f"{kind}: largest Hertz pressure"
    note = "" if pressure > 0.0 else UNPRESSED if pressure == 0.0 else CONFORMAL
    yield Quantity(f"{kind}_pressure", name, 1e-6 * pressure, "MPa", 1e-6 * pressure_error, note=note)
    name, margin = f"{kind}: margin against first yield", allowed / (pressure or math.nan)
    yield Quantity(f"{kind}_margin", name, margin, "1", margin * margin * pressure_error / allowed, note=note)


def _of_discs(run: Run, finer: Run, reducer: Reducer) -> Iterator[Quantity]:
    """Yield the shares of several discs and the reactions of the bearings; errors are changes with half the step."""
    coarse = run.select(slice(0, len(finer)))
    whole, first, fine = ([*_spatial(one, reducer)] for one in (run, coarse, finer))
    for one, other, again in zip(whole, first, fine, strict=True):
        yield replace(one, error=abs(other.value - again.value))


def _spatial(run: Run, reducer: Reducer) -> Iterator[Quantity]:
    """Yield the shares of the discs in the torque on the output, and the reactions of the bearings, over a run."""
    design = reducer.design
    output = design.output
    pins = -run.forces("output").reshape(len(run), design.gear.discs, -1, 2)
    _, carrier = reducer.member.ring_and_carrier(run["output_angle"])
    around = 2.0 * math.pi * np.arange(output.pins) / output.pins - carrier[:, np.newaxis]
    position = output.pin_circle_radius * unit(around)[:, np.newaxis]
    moments = np.sum(cross(position, pins), axis=-1)
    total = moments.sum(axis=1, keepdims=True)
    # without a load, as parts cross their clearance, there are no shares
    yield from disc_shares(moments[total[:, 0] != 0.0] / total[total != 0.0][:, np.newaxis])
    yield from reaction_quantities(of_discs(run, reducer))


def _limits(kinds: Kinds, reducer: Reducer, allowed: float) -> dict[str, float]:
    """Compute the factor on the torque at which the pressure of each kind reaches a limit.

    Kinds that are conformal or without pressure are omitted; `allowed` is the limit relative to the yield strength.
    """
    pressures = {kind: each.peak_pressure for kind, each in kinds.items() if each.peak_pressure > 0.0}
    return {kind: (allowed * reducer.contacts[kind].strength / most) ** 2 for kind, most in pressures.items()}


def _curves(kinds: Kinds, reducer: Reducer) -> tuple[Curve, ...]:
    single = [curve for kind in kinds.values() if kind.kind != "cam" for curve in _contacts(kind, reducer)]
    cams = [curve for disc, phase in enumerate(reducer.phases) for curve in _cam(kinds["cam"], disc, phase)]
    return (*single, *cams, *_ring_curves(kinds[reducer.design.tooth_pair], reducer))


def _contacts(contacts: ContactPressures, reducer: Reducer) -> Iterator[Curve]:
    """Yield the force on some of the loaded contacts of a kind, including the most loaded.

    That of teeth is shown with ideal sharing.
    """
    peaks = contacts.force.max(axis=0)
    loaded = np.flatnonzero(peaks > CARRYING_SHARE * contacts.peak_force)
    most = int(np.argmax(peaks))
    spread = loaded[np.linspace(0, len(loaded) - 1, min(LOADS.shown, len(loaded))).astype(int)]
    places = sorted({*spread[spread != most][: LOADS.shown - 1].tolist(), most})
    panel = f"{contacts.kind}: force on {len(places)} of the {len(loaded)} that carry, of {len(peaks)}"
    degrees = np.degrees(contacts.angle)
    if contacts.kind == reducer.design.tooth_pair:
        ideal, of = _ideal_forces(reducer, contacts.angle)[:, most], _contact_name(reducer, len(peaks), most)
        yield Curve(panel, "ideal sharing", degrees, ideal, _CRANK, _FORCE, "theory", of)
    for index in places:
        yield Curve(panel, _contact_name(reducer, len(peaks), index), degrees, contacts.force[:, index], _CRANK, _FORCE)


def _contact_name(reducer: Reducer, contacts: int, index: int) -> str:
    """Return the name of a contact; contacts of a kind are ordered by disc."""
    disc, number = divmod(index, contacts // reducer.design.gear.discs)
    return f"number {number + 1}" + (f", disc {disc + 1}" if reducer.design.gear.discs > 1 else "")


def _cam(contacts: ContactPressures, disc: int, phase: float) -> Iterator[Curve]:
    """Yield size and direction of the force of the cam at a phase on the crank [rad] on its disc."""
    degrees, (x, y) = np.degrees(contacts.angle), contacts.vector[:, disc].T
    name = f"disc {disc + 1}" if contacts.vector.shape[1] > 1 else ""
    yield Curve("cam: force", name, degrees, np.hypot(x, y), _CRANK, _FORCE)
    towards = np.mod(np.degrees(np.arctan2(y, x) - phase) - degrees - 90.0, 360.0)
    panel = "cam: direction of the force on the disc from the eccentric, counter-clockwise"
    yield Curve(panel, name, degrees, towards, _CRANK, "direction [deg]")


def _ring_curves(teeth: ContactPressures, reducer: Reducer) -> Iterator[Curve]:
    """Yield the forces of a disc around the ring at the largest force, with ideal sharing."""
    count, row = reducer.design.ring.teeth, int(np.argmax(teeth.force.max(axis=1)))
    ring = int(np.argmax(teeth.force[row])) // count  # of a disc or, of a ring in two halves, of one of them
    of_ring, disc = slice(ring * count, (ring + 1) * count), ring // reducer.design.ring.halves
    about = np.degrees(2.0 * math.pi * np.arange(count + 1) / count)
    panel = f"{teeth.kind} at {math.degrees(teeth.peak_angle):.0f} deg of crank"
    panel += f", disc {disc + 1}" if reducer.design.gear.discs > 1 else ""
    ideal = _ideal_forces(reducer, teeth.angle)[row, of_ring]
    for name, forces in (("simulated", teeth.force[row, of_ring]), ("ideal", ideal)):
        yield Curve(panel, name, about, np.append(forces, forces[0]), "", _FORCE, "polar")


def _ideal_forces(reducer: Reducer, crank: Array) -> Array:
    """Compute the forces of ideal sharing on the teeth [N], shape (n, D mates), at crank angles [rad], shape (n,)."""
    design, halves = reducer.design, reducer.design.ring.halves
    torque = reducer.share * math.copysign(design.load.torque, design.drive.speed) / (design.gear.discs * halves)
    gear, turned = tooth_profile(design), reducer.member.against_ring(crank)
    each = [ideal_loads.ideal_load_sharing(gear, torque, turned + phase).forces for phase in reducer.phases]
    return np.concatenate([forces for forces in each for _ in range(halves)], axis=1)


def _assumptions(reducer: Reducer) -> tuple[str, ...]:
    """List the assumptions of the runs."""
    design = reducer.design
    bearing = (
        f"the cam turns in a full-complement roller bearing of {design.contact.cam_rollers} rollers "
        f"(contact.cam_rollers), of which the most loaded carries {STRIBECK}/Z of the force (Stribeck)"
        if design.gear.bearing == "rolling"
        else "the cam slides in the disc's bore: Hertz's line contact is only a guide there"
    )
    return (
        "contacts have the secant stiffness of the load of each run, here "
        f"{reducer.contacts.working_forces_text(design.pair_kinds)}",
        "Hertz's line contact over the whole face width, with the local relative curvature of the ideal mesh; edge "
        "effects and misalignment are neglected; the force on a ring lobe acts on its arc",
        "ideal sharing assumes equally stiff contacts without clearance and a rigid cam: compliance of the cam and "
        "clearances move the disc sideways, so that other teeth carry, and more than ideally",
        f"a contact first yields below its surface at a peak pressure of {YIELD_PRESSURE} times the yield strength "
        f"(von Mises, plane strain), without visible damage; up to {SHAKEDOWN_PRESSURE:.3g} times residual "
        "stresses keep rolling elastic (shakedown: Johnson 1985, 9.2, without friction); neither includes fatigue",
        f"there is no pressure where Hertz's strip would be wider than {CONTACT.hertz_reach} of the thinner body's "
        "radius to each side (conformal, as pins in close sockets)",
        bearing,
        f"a contact counts as loaded from {CARRYING_SHARE:.0%} of the largest force of its kind; numerical error: "
        f"change with half the time step over the first {LOADS.periods} mesh periods, for means plus half the change "
        "between the halves of the samples, for peaks plus their excess over a full turn by ideal sharing; for the "
        f"capacity also the change in its last iteration, and the excess of all samples above its {LOADS.periods} mesh "
        "periods",
    )
