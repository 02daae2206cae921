"""Validation step "sharing": load sharing at very low speed against the closed form, and against `equilibrium`.

Ideal: almost no clearance, no friction, equally soft teeth, a cam so stiff that the disc only rotates, and a load so
small that the contact points stay those of the ideal mesh. The second comparison uses the real design with clearances,
cam and stiffness by curvature, without friction and gravity.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.record import Run
from cycloid_mj.base.validation import ValidationRow, deviation_row
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.geometry import envelope, ideal_loads, profile
from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.parts.gear import tooth_profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate import equilibrium, rig
from cycloid_mj.validate.gaps import GearPose, offset_root, trochoid_distance
from cycloid_mj.validate.rig import NONPIN, RATED_LOAD, design_of_kind

IDEAL = [
    *rig.without_friction(),
    *rig.without_gravity(),
    *rig.clearances(1e-5),
    'contact.stiffness_law="uniform"',
    "contact.stiffness_n_m=1e7",
    "contact.working_force_n=3.2",
    "load.torque_nm=0.1",
    "settings.timestep_us=2.0",
]


@dataclass(frozen=True)
class SharingBounds:
    """Conditions of the load sharing, and allowed errors."""

    stiff_cam: float = 2e11
    """Stiffness of an ideal cam [N/m], 20 000 times that of a tooth; a stiffer one would need a shorter step."""
    small_clearance: float = 0.2
    """Clearance [um] at which a nonpin disc on a stiff cam carries load on its roots, too."""
    ideal: float = 1.0
    """Allowed error [%]: inertia at this speed causes 0.12 to 0.54 (quick), 0.14 to 0.37 (full, slower)."""
    force: float = 0.23
    turn: float = 0.04
    cam: float = 0.05
    """Allowed errors [%]: three times the largest observed errors, 0.075, 0.013 and 0.016."""
    settled: float = 0.008
    """Time at which the load is applied and its transient has decayed [s]."""


SHARING = SharingBounds()


def ideal_rows(kind: str, quick: bool) -> list[ValidationRow]:
    """Compare the simulated tooth forces of an ideal reducer with ideal load sharing, F_i = T l_i / sum l^2.

    T is the load torque, l_i the lever arm of tooth i. `kind` is the kind of ring; `quick` shortens the run.
    """
    separate_lines = kind == NONPIN
    source = "T l/sum l^2 over arcs and Sigma" if separate_lines else "T l/sum l^2"
    note = "each contact line is a separate spring, as in the formula" if separate_lines else ""
    return [
        _compare_ideal_forces(
            kind, ideal_forces, separate_lines, f"ideal forces of the teeth, {kind}", source, note, quick
        )
    ]


def patch_rows(quick: bool) -> list[ValidationRow]:
    """Compare the simulated tooth forces of an ideal internal gear (nonpin) with the forces of `patch_forces`.

    Neighbouring contact lines form one contact area (patch) and share a spring. `quick` shortens the run.
    """
    note = "an arc and a flank line with less than a deflection of gap between them share one spring"
    source = "T w l/sum w l^2, w = 1/2..1"
    return [
        _compare_ideal_forces(
            NONPIN, patch_forces, False, "ideal forces of the teeth, nonpin patches", source, note, quick
        )
    ]


def _compare_ideal_forces(
    kind: str,
    reference: Callable[[Reducer, float], Array],
    separate_lines: bool,
    quantity: str,
    source: str,
    note: str,
    quick: bool,
) -> ValidationRow:
    """Compare the simulated tooth forces of an ideal reducer with a reference, sample by sample.

    Parameters
    ----------
    kind
        Kind of ring, such as `rig.FIXED`.
    reference
        Function from reducer and crank angle [rad] to the forces on the disc [N], shape (pins or lobes, 2).
    separate_lines
        Whether each contact line is a spring of its own.
    quantity, source, note
        Compared quantity, source of the reference and note, as texts of the result.
    quick
        Whether the crank turns faster, for a shorter run.
    """
    design = _at_slow_speed(Reducer(design_of_kind(kind, *IDEAL)), 100.0 if quick else 40.0)
    run = settled_run(design, SHARING.stiff_cam, separate_lines)
    expected_forces = np.stack([reference(design, crank_angle) for crank_angle in run["crank_angle"]])
    return deviation_row(
        quantity, run.forces(design.design.tooth_pair), expected_forces, "N", source, SHARING.ideal, note
    )


def ideal_forces(reducer: Reducer, crank: float) -> Array:
    """Compute the forces of ring pins or lobes on the disc [N] by ideal load sharing, shape (pins or lobes, 2).

    `crank` is the crank angle [rad]; the torque is the load of the design.
    """
    design = reducer.design
    gear, torque = tooth_profile(design), design.load.torque
    indices, normals, _ = _ideal_contacts(reducer, crank)
    sharing_law = (
        ideal_loads.ideal_internal_gear_load_sharing if design.ring.kind == "nonpin" else ideal_loads.ideal_load_sharing
    )
    return _sum_by_lobe(gear, indices, sharing_law(gear, torque, crank).forces, normals)


def patch_forces(reducer: Reducer, crank: float) -> Array:
    """Compute the forces of the lobes of an ideal internal gear on the disc [N], shape (lobes, 2).

    `crank` is the crank angle [rad]. A contact line on the arc of a lobe and a line at the root next to it share one
    spring if they are so close that they form a single contact area (patch). A line with the weight w
    (`_patch_weights`) and the lever arm l has the force T w l/sum(w l^2) under the load torque T.
    """
    gear = reducer.tooth_profile
    indices, normals, B = _ideal_contacts(reducer, crank)
    weight_roots = np.sqrt(_patch_weights(reducer, crank))
    # w l / sum w l^2 is sqrt(w) times the share of a line with the arm sqrt(w) l
    magnitudes = weight_roots * ideal_loads.share_load(
        weight_roots * profile.moment_arm(gear, B), reducer.design.load.torque
    )
    return _sum_by_lobe(gear, indices, magnitudes, normals)


def clearance_rows(kind: str, quick: bool) -> list[ValidationRow]:
    """Compare tooth forces, disc rotation and cam force of a design with clearance with an independent static solution.

    The forces are those of a slow run at the rated load. `kind` is the kind of ring. With `quick` there are fewer
    samples, and the run is shorter.
    """
    changes = [
        *rig.without_friction(),
        *rig.without_gravity(),
        f"load.torque_nm={RATED_LOAD}",
        "settings.timestep_us=2.0",
    ]
    rows = _solved_rows(Reducer(design_of_kind(kind, *changes)), kind, None, quick)
    if kind == NONPIN:
        small_clearance_design = design_of_kind(kind, *changes, *rig.clearances(SHARING.small_clearance))
        rows += _solved_rows(
            Reducer(small_clearance_design),
            f"{kind}, {SHARING.small_clearance:g} um, stiff cam",
            SHARING.stiff_cam / 2,
            quick,
        )
    return rows


def _solved_rows(reducer: Reducer, name: str, cam_stiffness: float | None, quick: bool) -> list[ValidationRow]:
    """Compare tooth forces, disc rotation and cam force of a settled run with the independent static solution.

    `name` is the name of the case. `cam_stiffness` [N/m] replaces the stiffness of the cam unless it is None. With
    `quick` there are fewer samples, and the run is shorter.
    """
    slow_reducer = _at_slow_speed(reducer, 200.0 if quick else 100.0)
    run = settled_run(slow_reducer, cam_stiffness, False)
    stiffness = {kind: contact_law.stiffness for kind, contact_law in build(slow_reducer.design).laws.items()}
    stiffness["cam"] = cam_stiffness or stiffness["cam"]
    sample_indices = np.linspace(0, len(run) - 1, 2 if quick else 5).astype(int)
    equilibria: list[equilibrium.Equilibrium] = []
    for crank_angle in run["crank_angle"][sample_indices]:
        equilibria.append(
            equilibrium.solve(slow_reducer, stiffness, float(crank_angle), equilibria[-1] if equilibria else None)
        )
    tooth_forces, expected_forces = (
        run.forces(slow_reducer.design.tooth_pair)[sample_indices],
        np.stack([solution.ring_forces for solution in equilibria]),
    )
    cam_force, expected_cam = (
        run.forces("cam")[sample_indices, 0],
        np.stack([solution.cam_force for solution in equilibria]),
    )
    rotation = (run["gear_angle"] + run["crank_angle"] / slow_reducer.design.lobes)[sample_indices]
    expected_rotation = np.array([solution.gear_turn for solution in equilibria])
    source = "static solution by scipy"
    return [
        deviation_row(f"forces of the teeth, {name}", tooth_forces, expected_forces, "N", source, SHARING.force),
        deviation_row(
            f"turn of the gear, {name}", 1e6 * rotation, 1e6 * expected_rotation, "urad", source, SHARING.turn
        ),
        deviation_row(f"load of the cam, {name}", cam_force, expected_cam, "N", source, SHARING.cam),
    ]


def settled_run(reducer: Reducer, cam_stiffness: float | None, separate_lines: bool) -> Run:
    """Simulate a design; return its samples under full load.

    `cam_stiffness` [N/m] replaces the stiffness of the cam unless it is None; with `separate_lines` each contact line
    is a spring of its own.
    """
    model = build(reducer.design)
    if cam_stiffness is not None:
        rig.stiffen_cam(model, cam_stiffness)
    if separate_lines:
        rig.separate_patches(model)
    run = simulate(reducer.design, model)
    return run.select(run.time > SHARING.settled)


def _at_slow_speed(reducer: Reducer, rpm: float) -> Reducer:
    """Return the design at a crank speed [rpm], running for one mesh period after it has settled."""
    hold = SHARING.settled + 60.0 / (rpm * reducer.design.ring.teeth)
    changes = [f"drive.speed_rpm={rpm!r}", f"drive.hold_s={hold!r}", "load.rise_s=0.004", "settings.log_rate_hz=2500.0"]
    return rig.with_changes(reducer, *changes)


def _ideal_contacts(reducer: Reducer, crank_angle: float) -> tuple[Integers, Array, Array]:
    """Compute the contacts of the ideal mesh at a crank angle [rad]: with the ring pins, or with an internal gear.

    Those with an internal gear are first the contacts with the arcs of its lobes, then those with the flanks Sigma
    between the arcs (`envelope`).

    Returns
    -------
    tuple of Array
        For each of n contacts: the index of the pin, or of the lobe to which the arc or flank belongs, shape (n,); the
        unit normal of the ring, which points into its bore, towards the disc, (n, 2); and the phase B [rad] of the
        contact on pin, arc or flank, (n,).
    """
    gear = reducer.tooth_profile
    arc_contacts = envelope.arc_contacts(gear, crank_angle)
    if reducer.design.ring.kind == "pin":
        return arc_contacts.lobe, arc_contacts.normals, arc_contacts.B
    flank_contacts = envelope.sigma_contacts(gear, crank_angle)
    lobes = np.concatenate([arc_contacts.lobe, _lobes_of_flanks(gear, flank_contacts)])
    return (
        lobes,
        np.concatenate([arc_contacts.normals, flank_contacts.normals]),
        np.concatenate([arc_contacts.B, flank_contacts.B]),
    )


def _lobes_of_flanks(gear: CycloidGear, contacts: envelope.RingContacts) -> Integers:
    """Return the index of the ring lobe to which the flank Sigma of each contact belongs, shape (n,).

    Flanks beyond B = pi belong to the lobe counter-clockwise of that in `contacts`.
    """
    return (contacts.lobe - np.greater(contacts.B, np.pi)) % gear.ring_teeth


def _patch_weights(reducer: Reducer, crank_angle: float) -> Array:
    """Compute the weight [1] of each of n contact lines of the ideal internal gear at a crank angle [rad], shape (n,).

    The weight is the stiffness of the line divided by that of a line with a spring of its own. Arcs come first, then
    lines on the flanks between them. A line on a flank and the arc of its lobe have the weight (1 + s)/2 each. s is the
    gap half-way between both lines divided by the deflection under ``contact.working_force``, at most 1. If an arc is
    next to two lines on flanks, its weight is the product of both values.
    """
    design = reducer.design
    gear = tooth_profile(design)
    roots, min_phase = envelope.sigma_contacts(gear, crank_angle), gear.best_phase
    pose = GearPose(gear.eccentricity * profile.unit(-crank_angle), -crank_angle / gear.lobes)
    deflection = design.contact.working_force / design.contact.stiffness
    mid_phases = (roots.B + np.where(np.greater(roots.B, np.pi), 2 * np.pi - min_phase, min_phase)) / 2
    arc_weights, root_weights = np.ones(gear.ring_teeth), np.empty(roots.B.size)
    for index, (root, lobe) in enumerate(zip(roots.lobe, _lobes_of_flanks(gear, roots), strict=True)):
        mid_point = offset_root(gear, int(root), mid_phases[index : index + 1])
        mid_gap = trochoid_distance(gear, pose.to_gear(mid_point))[0][0]
        root_weights[index] = (1.0 + min(1.0, mid_gap / deflection)) / 2.0
        arc_weights[lobe] *= root_weights[index]
    return np.concatenate([arc_weights, root_weights])


def _sum_by_lobe(gear: CycloidGear, lobes: Integers, magnitudes: Array, normals: Array) -> Array:
    forces = np.zeros((gear.ring_teeth, 2))
    np.add.at(forces, lobes, magnitudes[:, np.newaxis] * normals)
    return forces
