"""Loads of all ring pins or teeth, output pins and the cam over a crank turn, Hertz pressures, and the capacity."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array, cross
from cycloid_mj.base.engine import Progress, each_in_threads, silent
from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.base.names import PLANET_MESH, SOLVERS
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Curve, Quantity, by_key
from cycloid_mj.base.units import RPM
from cycloid_mj.design import Design, Named, resolve
from cycloid_mj.design.layouts import Layout
from cycloid_mj.design.materials import SHAKEDOWN_PRESSURE, YIELD_PRESSURE
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.dynamics.settling import penetration_limit
from cycloid_mj.geometry import ideal_loads
from cycloid_mj.geometry.profile import unit
from cycloid_mj.measure.conditions import STEADY, halve_time_step
from cycloid_mj.measure.contact_pressure import ContactPressures, contact_pressures
from cycloid_mj.measure.measurement import Measurement
from cycloid_mj.measure.reaction import bearing_reactions
from cycloid_mj.measure.steady import run_steady, steady_design
from cycloid_mj.parts.gear import tooth_profile
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.reducer.contact import CONTACT, STRIBECK
from cycloid_mj.statics.ideal import ideal_peak, ideal_rv_at
from cycloid_mj.statics.kernel import CARRYING_SHARE
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


def _require_torque(design: Design, torque: float) -> float:
    """Return the output `torque` [N m] of a measurement; raise UsageError if it is not positive."""
    if not torque > 0.0:
        raise UsageError(
            f"the output torque of {design.name} is {torque:g} N m, which is out of range: choose a torque greater "
            "than 0 N m (--load-nm)"
        )
    return torque


@shows_progress
def loads(
    design: Named,
    load: float | None = None,
    quick: bool = False,
    progress: Progress = silent,
    solver: Solver = "planar",
) -> Measurement:
    """Measure contact forces, Hertz pressures and the capacity of a design over a crank turn.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file; the run has its crank speed.
    load, quick
        Torque on the output [N m], by default the rated torque; whether to run some mesh periods instead of a turn.
    progress, solver
        Called after each run with the numbers of finished and of all runs; solver of the runs.

    Returns
    -------
    Measurement
        For each kind of contact its forces [N], number of loaded contacts, Hertz pressure [MPa] and margin against
        first yield; the output torques [N m] at first yield and at the shakedown limit; with several discs load shares
        and bearing reactions; curves over the crank angle. Each quantity has an estimate of its numerical error, and
        each force its closed form for ideal load sharing.

    Raises
    ------
    UsageError
        The torque is not positive.
    DesignError
        The crank does not turn.
    RunError
        A run failed.
    """
    reducer = reducer_of(resolve(design))
    torque = _require_torque(reducer.design, reducer.design.rated_torque if load is None else load)
    drive = steady_design(reducer).but(load={"torque": torque})
    runs, periods = 3, LOADS.periods if quick else reducer.mesh_periods  # two runs and the capacities
    run, finer_run = _run_at_two_steps(drive, periods, solver, lambda finished, _: progress(finished, runs))
    contacts, checks = contact_pressures(run, drive), contact_pressures(finer_run, drive)
    first_periods = contact_pressures(run.select(slice(0, len(finer_run))), drive)
    missed_peaks = {kind: _missed_peak(drive, contact) for kind, contact in contacts.items()}
    capacities, capacity_details = _find_capacities(drive, contacts, first_periods, checks, missed_peaks, solver)
    progress(runs, runs)
    by_kind = (
        _kind_quantities(drive, contacts[key], first_periods[key], checks[key], missed_peaks[key]) for key in contacts
    )
    # output pins distribute the load to the discs; the cranks of an RV reducer carry the discs
    by_disc = _disc_quantities(run, finer_run, drive) if reducer.design.gear.discs > 1 and "output" in contacts else ()
    return Measurement(
        measure="loads",
        design=reducer.design,
        condition=(
            f"{torque:.4g} N m, {abs(reducer.design.drive.speed) / RPM:.0f} rpm, {reducer.design.condition_words}, "
            f"{SOLVERS[solver]}"
        ),
        quantities=by_key(*by_kind, by_disc, capacities),
        curves=_curves(contacts, drive),
        assumptions=_assumptions(drive),
        runs={"loaded": run},
        details={"load_torque_nm": torque, **capacity_details},
    )


def _run_at_two_steps(reducer: Reducer, periods: int, solver: Solver, progress: Progress) -> list[Run]:
    """Simulate a loaded drive twice: for `periods` mesh periods, and for `LOADS.periods` with half the time step."""
    tasks = [(reducer, periods), (halve_time_step(reducer, solver), LOADS.periods)]
    return each_in_threads(lambda task: run_steady(task[0], STEADY.settling_time, task[1], solver), tasks, progress)


def _find_capacities(
    reducer: Reducer,
    contacts: Kinds,
    first_periods: Kinds,
    half_step: Kinds,
    missed_peaks: Mapping[str, float],
    solver: Solver,
) -> tuple[list[Quantity], dict[str, Any]]:
    """Compute the torques at which the weakest kind of contact first yields and reaches shakedown.

    Parameters
    ----------
    reducer
        The loaded drive.
    contacts
        Forces and pressures of all samples, by kind of contact.
    first_periods, half_step
        The same for the first mesh periods, with the full and with half the time step, for the error.
    missed_peaks
        Relative excess of the largest ideal force in a full turn over that at the sampled angles [1], by kind.
    solver
        Solver of the runs.

    Returns
    -------
    tuple
        The torques as quantities [N m], NaN if no contact determines them, and the torques by kind as JSON values.
    """
    torque = reducer.design.load.torque
    yield_factors, shakedown_factors = (_torque_factors(contacts, reducer, limit) for _, limit in CAPACITIES.values())
    weakest = min(yield_factors, key=lambda kind: yield_factors[kind], default="")
    details = _capacity_details(reducer, torque, weakest, yield_factors, shakedown_factors)
    if not weakest:
        return [_no_capacity(key) for key in CAPACITIES], details
    error = missed_peaks[weakest] + _pressure_error(contacts[weakest], first_periods[weakest], half_step[weakest])
    factors = zip(CAPACITIES, (yield_factors, shakedown_factors), strict=True)
    quantities = [
        _find_capacity(key, reducer, weakest, torque * by_kind[weakest], error, solver) for key, by_kind in factors
    ]
    return quantities, details


def _capacity_details(
    reducer: Reducer,
    torque: float,
    weakest: str,
    yield_factors: Mapping[str, float],
    shakedown_factors: Mapping[str, float],
) -> dict[str, Any]:
    """Return the torques [N m] at which each kind of contact reaches first yield and shakedown as JSON values.

    The keys are ``capacity_by_kind_nm`` and ``shakedown_by_kind_nm``; further keys are the nominal torque and
    ``weakest``. `yield_factors` and `shakedown_factors` map kinds to factors on `torque` [N m]; `weakest` is the kind
    that yields first.
    """
    return {
        "nominal_torque_nm": reducer.design.rated_torque,
        "rated_torque_nm": reducer.design.rated_torque,  # the former key, for one release
        "weakest": weakest,
        "capacity_by_kind_nm": {kind: torque * factor for kind, factor in yield_factors.items()},
        "shakedown_by_kind_nm": {kind: torque * factor for kind, factor in shakedown_factors.items()},
    }


def _pressure_error(contacts: ContactPressures, first_periods: ContactPressures, half_step: ContactPressures) -> float:
    """Estimate the relative error of the force from the largest pressures, which are proportional to its square root.

    The pressures of all samples and of those with half the time step are compared with the first mesh periods.
    """
    ratios = (compared.peak_pressure / first_periods.peak_pressure for compared in (contacts, half_step))
    return sum(2.0 * abs(ratio - 1.0) for ratio in ratios)


def _missed_peak(reducer: Reducer, contacts: ContactPressures) -> float:
    """Compute the relative excess of a kind's largest ideal force in a full turn over that at the sampled angles [1].

    It is 0 where the samples cover the turn.
    """
    turn = np.linspace(0.0, 2.0 * math.pi, LOADS.per_period * reducer.design.ring.teeth + 1)
    return max(0.0, ideal_peak(reducer, contacts.kind, turn) / ideal_peak(reducer, contacts.kind, contacts.angle) - 1.0)


def _no_capacity(key: str, note: str = UNDECIDED) -> Quantity:
    """Return a capacity without a value; by default because no contact determines it."""
    return Quantity(key, CAPACITIES[key][0], math.nan, "N m", note=note)


def _find_capacity(
    key: str, reducer: Reducer, kind: str, torque: float, force_error: float, solver: Solver
) -> Quantity:
    """Compute the torque at which a kind of contact reaches first yield or shakedown, by fixed-point iteration.

    Each iteration is a run. The value is NaN if the contact becomes conformal or carries no load, or if a run fails:
    the crank bearings of an RV reducer may deflect too far before its teeth reach the pressure. `solver` is the solver
    of the runs, MuJoCo or the planar solver.

    Parameters
    ----------
    key
        Key of the capacity, one of `CAPACITIES`: first yield or shakedown.
    reducer, kind
        The loaded drive, and the kind of contact.
    torque
        Start value [N m].
    force_error
        Relative error of the contact forces [1], which is part of the error of the torque.
    """
    name, pressure_limit = CAPACITIES[key]
    allowed_depth = penetration_limit(reducer)
    for _ in range(LOADS.max_iterations):
        # penetration grows with the force: its limit is to detect failed runs, so it grows as well
        depth_limit = min(allowed_depth * max(1.0, torque / reducer.design.load.torque), LOADS.max_penetration)
        loaded_reducer = reducer.but(load={"torque": torque}, contact={"max_penetration": depth_limit})
        try:
            run = run_steady(loaded_reducer, STEADY.settling_time, LOADS.periods, solver)
        except RunError as error:
            return _no_capacity(key, f"none: the run at {torque:.4g} N m, where {kind} would reach it, failed: {error}")
        torque_factor = _torque_factors(contact_pressures(run, reducer), reducer, pressure_limit).get(kind)
        if torque_factor is None:
            return _no_capacity(key)
        previous_torque, torque = torque, torque * torque_factor
        if abs(torque - previous_torque) < LOADS.capacity_rtol * torque:
            break
    rated_torque = reducer.design.rated_torque
    note = (
        f"limited by {kind}, whose largest pressure reaches {pressure_limit:.3g} x the yield strength at "
        f"{torque / rated_torque:.2f} of the rated {rated_torque:.4g} N m; over {LOADS.periods} mesh periods"
    )
    return Quantity(key, name, torque, "N m", error=abs(torque - previous_torque) + force_error * torque, note=note)


def _kind_quantities(
    reducer: Reducer,
    contacts: ContactPressures,
    first_periods: ContactPressures,
    half_step: ContactPressures,
    missed_peak: float,
) -> Iterator[Quantity]:
    """Yield the quantities of one kind of contact: forces [N], number of loaded contacts, Hertz pressure [MPa], margin.

    The margin compares the pressure with the pressure at first yield. All quantities have numerical errors. Contacts
    that are modelled as springs, such as the crank bearings of an RV reducer, have neither pressure nor margin.

    Parameters
    ----------
    contacts
        Forces and pressures of all samples.
    first_periods, half_step
        The same for the first mesh periods, with the full and with half the time step; their difference is an error.
    missed_peak
        Relative excess of the largest ideal force in a full turn over that at the sampled angles [1], for the error of
        peak values. The error of mean values includes half of the change from the first to the second half of the
        samples instead.
    """
    kind = contacts.kind
    peak_error = abs(first_periods.peak_force - half_step.peak_force) + missed_peak * contacts.peak_force
    first_half, second_half = contacts.halves
    mean_error = abs(first_periods.mean_force - half_step.mean_force) + 0.5 * abs(
        first_half.mean_force - second_half.mean_force
    )
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
    error = abs(first_periods.carrying - half_step.carrying) + 0.5 * abs(first_half.carrying - second_half.carrying)
    yield Quantity(f"{kind}_carrying", name, contacts.carrying, "1", error)
    if not reducer.contacts[kind].HAS_PRESSURE:
        return
    pressure, yield_pressure = contacts.peak_pressure, YIELD_PRESSURE * reducer.contacts[kind].strength
    pressure_error = abs(first_periods.peak_pressure - half_step.peak_pressure) + 0.5 * missed_peak * pressure
    name = f"{kind}: largest Hertz pressure"
    note = "" if pressure > 0.0 else UNPRESSED if pressure == 0.0 else CONFORMAL
    yield Quantity(f"{kind}_pressure", name, 1e-6 * pressure, "MPa", 1e-6 * pressure_error, note=note)
    name, margin = f"{kind}: margin against first yield", yield_pressure / (pressure or math.nan)
    yield Quantity(f"{kind}_margin", name, margin, "1", margin * margin * pressure_error / yield_pressure, note=note)


def _disc_quantities(run: Run, half_step_run: Run, reducer: Reducer) -> Iterator[Quantity]:
    """Yield the load shares of several discs and the bearing reactions over a run.

    Errors are the differences from `half_step_run`, which has half the time step.
    """
    first_periods = run.select(slice(0, len(half_step_run)))
    all_samples, coarse_step, fine_step = (
        [*_disc_and_bearing_quantities(quantity, reducer)] for quantity in (run, first_periods, half_step_run)
    )
    for quantity, coarse_quantity, fine_quantity in zip(all_samples, coarse_step, fine_step, strict=True):
        yield replace(quantity, error=abs(coarse_quantity.value - fine_quantity.value))


def _disc_and_bearing_quantities(run: Run, reducer: Reducer) -> Iterator[Quantity]:
    """Yield the shares of the discs in the output torque, and the reactions of the bearings [N, N m], over a run.

    The shares omit samples without a torque on the output.
    """
    design = reducer.design
    output = design.output
    pin_forces = -run.forces("output").reshape(len(run), design.gear.discs, -1, 2)
    _, carrier_angle = reducer.member.ring_and_carrier(run["output_angle"])
    pin_angles = 2.0 * math.pi * np.arange(output.pins) / output.pins - carrier_angle[:, np.newaxis]
    lever_arms = output.pin_circle_radius * unit(pin_angles)[:, np.newaxis]
    moments = np.sum(cross(lever_arms, pin_forces), axis=-1)
    total_moment = moments.sum(axis=1, keepdims=True)
    # without a load, as parts cross their clearance, there are no shares
    yield from disc_shares(moments[total_moment[:, 0] != 0.0] / total_moment[total_moment != 0.0][:, np.newaxis])
    yield from reaction_quantities(bearing_reactions(run, reducer))


def _torque_factors(contacts_by_kind: Kinds, reducer: Reducer, pressure_limit: float) -> dict[str, float]:
    """Compute, by kind of contact, the factor on the torque at which its largest pressure reaches a limit.

    `pressure_limit` is the limit relative to the yield strength of the material [1]. The factor assumes that pressure
    grows with the square root of the force. Kinds whose largest pressure is 0, or occurs in a conformal contact, are
    omitted.
    """
    pressures = {
        kind: contacts.peak_pressure for kind, contacts in contacts_by_kind.items() if contacts.peak_pressure > 0.0
    }
    return {kind: (pressure_limit * reducer.contacts[kind].strength / peak) ** 2 for kind, peak in pressures.items()}


def _curves(kinds: Kinds, reducer: Reducer) -> tuple[Curve, ...]:
    """Return curves of contact forces by kind of contact, of each cam's force on its disc, and of tooth forces.

    `kinds` has the forces in all samples, by kind of contact.
    """
    contact_curves = [
        curve for contacts in kinds.values() if contacts.kind != "cam" for curve in _contact_curves(contacts, reducer)
    ]
    cam_curves = [
        curve
        for disc, phase in enumerate(reducer.phases if "cam" in kinds else ())
        for curve in _cam_curves(kinds["cam"], disc, phase)
    ]
    return (*contact_curves, *cam_curves, *_ring_curves(kinds[reducer.design.tooth_pair], reducer))


def _contact_curves(contacts: ContactPressures, reducer: Reducer) -> Iterator[Curve]:
    """Yield the force [N] over the crank angle on some loaded contacts of one kind, including the most loaded contact.

    For teeth, a curve with the ideal force on the most loaded contact is added.
    """
    peaks = contacts.force.max(axis=0)
    loaded_contacts = np.flatnonzero(peaks > CARRYING_SHARE * contacts.peak_force)
    most_loaded = int(np.argmax(peaks))
    even_contacts = loaded_contacts[
        np.linspace(0, len(loaded_contacts) - 1, min(LOADS.shown, len(loaded_contacts))).astype(int)
    ]
    drawn_contacts = sorted({*even_contacts[even_contacts != most_loaded][: LOADS.shown - 1].tolist(), most_loaded})
    panel = f"{contacts.kind}: force on {len(drawn_contacts)} of the {len(loaded_contacts)} that carry, of {len(peaks)}"
    angle_deg = np.degrees(contacts.angle)
    if contacts.kind == reducer.design.tooth_pair:
        ideal_force, contact_name = (
            _ideal_forces(reducer, contacts.angle)[:, most_loaded],
            _contact_name(reducer, contacts, most_loaded),
        )
        yield Curve(panel, "ideal sharing", angle_deg, ideal_force, _CRANK, _FORCE, "theory", contact_name)
    for index in drawn_contacts:
        name = _contact_name(reducer, contacts, index)
        yield Curve(panel, name, angle_deg, contacts.force[:, index], _CRANK, _FORCE)


def _contact_name(reducer: Reducer, contacts: ContactPressures, index: int) -> str:
    """Return the name of a contact by its index; contacts of a kind are ordered by disc, those of planets are not."""
    if contacts.kind == PLANET_MESH:
        return f"planet {index + 1}"
    disc, pair_index = divmod(index, contacts.vector.shape[1] // reducer.design.gear.discs)
    return f"number {pair_index + 1}" + (f", disc {disc + 1}" if reducer.design.gear.discs > 1 else "")


def _cam_curves(contacts: ContactPressures, disc: int, phase: float) -> Iterator[Curve]:
    """Yield magnitude [N] and direction [deg] of the cam's force on a `disc`, by its index, over the crank angle.

    `contacts` are the contacts of all cams. The direction is counter-clockwise from the eccentric; `phase` [rad] is the
    angle of the eccentric on the crank.
    """
    angle_deg, (force_x, force_y) = np.degrees(contacts.angle), contacts.vector[:, disc].T
    name = f"disc {disc + 1}" if contacts.vector.shape[1] > 1 else ""
    yield Curve("cam: force", name, angle_deg, np.hypot(force_x, force_y), _CRANK, _FORCE)
    direction = np.mod(np.degrees(np.arctan2(force_y, force_x) - phase) - angle_deg - 90.0, 360.0)
    panel = "cam: direction of the force on the disc from the eccentric, counter-clockwise"
    yield Curve(panel, name, angle_deg, direction, _CRANK, "direction [deg]")


def _ring_curves(tooth_contacts: ContactPressures, reducer: Reducer) -> Iterator[Curve]:
    """Yield polar curves of the tooth forces on one disc at the instant of the largest force, simulated and ideal.

    `tooth_contacts` are the contacts of disc and ring.
    """
    pin_count, sample = reducer.design.ring.teeth, int(np.argmax(tooth_contacts.force.max(axis=1)))
    # index of the disc or, with a ring in two halves, of disc and half
    ring_index = int(np.argmax(tooth_contacts.force[sample])) // pin_count
    columns, disc = (
        slice(ring_index * pin_count, (ring_index + 1) * pin_count),
        ring_index // reducer.design.ring.halves,
    )
    pin_angle_deg = np.degrees(2.0 * math.pi * np.arange(pin_count + 1) / pin_count)
    panel = f"{tooth_contacts.kind} at {math.degrees(tooth_contacts.peak_angle):.0f} deg of crank"
    panel += f", disc {disc + 1}" if reducer.design.gear.discs > 1 else ""
    ideal_force = _ideal_forces(reducer, tooth_contacts.angle)[sample, columns]
    for name, forces in (("simulated", tooth_contacts.force[sample, columns]), ("ideal", ideal_force)):
        yield Curve(panel, name, pin_angle_deg, np.append(forces, forces[0]), "", _FORCE, "polar")


def _ideal_forces(reducer: Reducer, crank_angle: Array) -> Array:
    """Compute the ideal forces [N] of all teeth under the load torque of the design at n crank angles, (n, contacts).

    `crank_angle` are the crank angles [rad], shape (n,). The columns are the ring pins or lobes on the first disc, then
    those on the next disc. With a ring in two halves, each disc has all columns of the first half, followed by the
    equal columns of the second half.
    """
    if isinstance(reducer, RvReducer):
        return ideal_rv_at(reducer, crank_angle).pins.reshape(len(crank_angle), -1)
    design, halves = reducer.design, reducer.design.ring.halves
    torque = reducer.share * math.copysign(design.load.torque, design.drive.speed) / (design.gear.discs * halves)
    gear, relative_angle = tooth_profile(design), reducer.member.against_ring(crank_angle)
    forces_by_disc = [
        ideal_loads.ideal_load_sharing(gear, torque, relative_angle + phase).forces for phase in reducer.phases
    ]
    return np.concatenate([forces for forces in forces_by_disc for _ in range(halves)], axis=1)


def _describe_cam_bearing(design: Design) -> str:
    """Return a phrase on how the pressure in the cam's bearing is computed: by its most loaded roller, or as a line."""
    if design.gear.bearing == "rolling":
        return (
            f"the cam turns in a full-complement roller bearing of {design.contact.cam_rollers} rollers "
            f"(contact.cam_rollers), of which the most loaded carries {STRIBECK}/Z of the force (Stribeck)"
        )
    return "the cam slides in the disc's bore: Hertz's line contact is only a guide there"


BEARING_SENTENCES: Mapping[Layout, Callable[[Design], str]] = {
    "central": _describe_cam_bearing,
    "rv": lambda design: (
        "crank bearings and planets are springs without pressure: `rate` and `stress` compute that of needles and "
        "planet teeth"
    ),
}
"""Function that describes the pressure in the bearings of each layout."""


def _assumptions(reducer: Reducer) -> tuple[str, ...]:
    """Return the assumptions of a measurement of contact forces by simulation, a sentence each.

    They are about contact stiffness, Hertz pressure, ideal sharing, yield limits and numerical errors.
    """
    return (
        "contacts have the secant stiffness of the load of each run, here "
        f"{reducer.contacts.working_forces_text(tuple(reducer.clearance_keys))}",
        "Hertz's line contact over the whole face width, with the local relative curvature of the ideal mesh; edge "
        "effects and misalignment are neglected; the force on a ring lobe acts on its arc",
        "ideal sharing assumes equally stiff contacts without clearance and rigid cams or cranks: their compliance "
        "and clearances move the disc sideways, so that other teeth carry, and more than ideally",
        f"a contact first yields below its surface at a peak pressure of {YIELD_PRESSURE} times the yield strength "
        f"(von Mises, plane strain), without visible damage; up to {SHAKEDOWN_PRESSURE:.3g} times residual "
        "stresses keep rolling elastic (shakedown: Johnson 1985, 9.2, without friction); neither includes fatigue",
        f"there is no pressure where Hertz's strip would be wider than {CONTACT.hertz_reach} of the thinner body's "
        "radius to each side (conformal, as pins in close sockets)",
        BEARING_SENTENCES[reducer.LAYOUT](reducer.design),
        f"a contact counts as loaded from {CARRYING_SHARE:.0%} of the largest force of its kind; numerical error: "
        f"change with half the time step over the first {LOADS.periods} mesh periods, for means plus half the change "
        "between the halves of the samples, for peaks plus their excess over a full turn by ideal sharing; for the "
        f"capacity also the change in its last iteration, and the excess of all samples above its {LOADS.periods} mesh "
        "periods",
    )
