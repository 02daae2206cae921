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
from cycloid_mj.base.validation import ValidationRow, deviation
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.geometry import envelope, ideal_loads, profile
from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.parts.gear import tooth_profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate import equilibrium, rig
from cycloid_mj.validate.gaps import GearPose, offset_root, trochoid_distance
from cycloid_mj.validate.rig import NONPIN, RATED_LOAD, reducer_of

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
    """Allowed errors [%]: three times the largest ones seen, 0.075, 0.013 and 0.016."""
    settled: float = 0.008
    """Time at which the load is applied and its transient has decayed [s]."""


SHARING = SharingBounds()


def ideal_rows(kind: str, quick: bool) -> list[ValidationRow]:
    """Compare the tooth forces of a kind of ring with F_i = T l_i / sum l^2."""
    separate = kind == NONPIN
    source = "T l/sum l^2 over arcs and Sigma" if separate else "T l/sum l^2"
    note = "each contact line is a separate spring, as in the formula" if separate else ""
    return [_ideal_row(kind, ideal_forces, separate, f"ideal forces of the teeth, {kind}", source, note, quick)]


def patch_rows(quick: bool) -> list[ValidationRow]:
    """Compare the nonpin ring, whose nearby contact lines share one patch, with ideal forces of shared springs."""
    note = "an arc and a root line with less than a deflection of gap between them share one spring"
    source = "T w l/sum w l^2, w = 1/2..1"
    return [_ideal_row(NONPIN, patch_forces, False, "ideal forces of the teeth, nonpin patches", source, note, quick)]


def _ideal_row(
    kind: str,
    reference: Callable[[Reducer, float], Array],
    separate: bool,
    quantity: str,
    source: str,
    note: str,
    quick: bool,
) -> ValidationRow:
    """Compare tooth forces of an ideal reducer with a reference, sample by sample."""
    design = _slow(Reducer(reducer_of(kind, *IDEAL)), 100.0 if quick else 40.0)
    run = settled_run(design, SHARING.stiff_cam, separate)
    ideal = np.stack([reference(design, crank) for crank in run["crank_angle"]])
    return deviation(quantity, run.forces(design.design.tooth_pair), ideal, "N", source, SHARING.ideal, note)


def ideal_forces(reducer: Reducer, crank: float) -> Array:
    """Compute the ideal forces of ring pins or ring lobes on the disc [N], shape (N, 2)."""
    design = reducer.design
    gear, torque = tooth_profile(design), design.load.torque
    lobes, normals, _ = _ideal_contacts(reducer, crank)
    share = (
        ideal_loads.ideal_internal_gear_load_sharing if design.ring.kind == "nonpin" else ideal_loads.ideal_load_sharing
    )
    return _by_lobe(gear, lobes, share(gear, torque, crank).forces, normals)


def patch_forces(reducer: Reducer, crank: float) -> Array:
    """Compute the forces [N], shape (N, 2), of an ideal nonpin mesh whose nearby contact lines share springs."""
    gear = reducer.tooth_profile
    lobes, normals, B = _ideal_contacts(reducer, crank)
    root = np.sqrt(_patch_weights(reducer, crank))
    # w l / sum w l^2 is root(w) times the share of an arm root(w) l.
    magnitudes = root * ideal_loads.share_load(root * profile.moment_arm(gear, B), reducer.design.load.torque)
    return _by_lobe(gear, lobes, magnitudes, normals)


def clearance_rows(kind: str, quick: bool) -> list[ValidationRow]:
    """Compare the design with its clearances with the independent static solution."""
    free = [*rig.without_friction(), *rig.without_gravity(), f"load.torque_nm={RATED_LOAD}", "settings.timestep_us=2.0"]
    rows = _solved_rows(Reducer(reducer_of(kind, *free)), kind, None, quick)
    if kind == NONPIN:
        close = reducer_of(kind, *free, *rig.clearances(SHARING.small_clearance))
        rows += _solved_rows(
            Reducer(close), f"{kind}, {SHARING.small_clearance:g} um, stiff cam", SHARING.stiff_cam / 2, quick
        )
    return rows


def _solved_rows(reducer: Reducer, name: str, cam: float | None, quick: bool) -> list[ValidationRow]:
    """Compare forces, rotation and cam load of a settled run with the independent static solution."""
    slow = _slow(reducer, 200.0 if quick else 100.0)
    run = settled_run(slow, cam, False)
    stiffness = {kind: law.stiffness for kind, law in build(slow.design).laws.items()}
    stiffness["cam"] = cam or stiffness["cam"]
    samples = np.linspace(0, len(run) - 1, 2 if quick else 5).astype(int)
    solved: list[equilibrium.Equilibrium] = []
    for crank in run["crank_angle"][samples]:
        solved.append(equilibrium.solve(slow, stiffness, float(crank), solved[-1] if solved else None))
    ring, ideal_ring = (
        run.forces(slow.design.tooth_pair)[samples],
        np.stack([solution.ring_forces for solution in solved]),
    )
    cam_load, ideal_cam = run.forces("cam")[samples, 0], np.stack([solution.cam_force for solution in solved])
    turn = (run["gear_angle"] + run["crank_angle"] / slow.design.lobes)[samples]
    ideal_turn = np.array([solution.gear_turn for solution in solved])
    source = "static solution by scipy"
    return [
        deviation(f"forces of the teeth, {name}", ring, ideal_ring, "N", source, SHARING.force),
        deviation(f"turn of the gear, {name}", 1e6 * turn, 1e6 * ideal_turn, "urad", source, SHARING.turn),
        deviation(f"load of the cam, {name}", cam_load, ideal_cam, "N", source, SHARING.cam),
    ]


def settled_run(reducer: Reducer, cam: float | None, separate: bool) -> Run:
    """Simulate a design; return its samples under full load. `cam` [N/m] replaces the stiffness of the cam."""
    compiled = build(reducer.design)
    if cam is not None:
        rig.stiffen_cam(compiled, cam)
    if separate:
        rig.separate_patches(compiled)
    run = simulate(reducer.design, compiled)
    return run.select(run.time > SHARING.settled)


def _slow(reducer: Reducer, rpm: float) -> Reducer:
    """Return the design at a crank speed [rpm], running for one mesh period after it has settled."""
    hold = SHARING.settled + 60.0 / (rpm * reducer.design.ring.teeth)
    changes = [f"drive.speed_rpm={rpm!r}", f"drive.hold_s={hold!r}", "load.rise_s=0.004", "settings.log_rate_hz=2500.0"]
    return rig.with_changes(reducer, *changes)


def _ideal_contacts(reducer: Reducer, crank: float) -> tuple[Integers, Array, Array]:
    """Compute the contacts of the ideal mesh: index of the ring lobe, normal of the ring, and phase B."""
    gear = reducer.tooth_profile
    arcs = envelope.arc_contacts(gear, crank)
    if reducer.design.ring.kind == "pin":
        return arcs.lobe, arcs.normals, arcs.B
    roots = envelope.sigma_contacts(gear, crank)
    lobes = np.concatenate([arcs.lobe, _owner(gear, roots)])
    return lobes, np.concatenate([arcs.normals, roots.normals]), np.concatenate([arcs.B, roots.B])


def _owner(gear: CycloidGear, roots: envelope.RingContacts) -> Integers:
    """Return the ring lobe of each root contact; the half beyond B = pi belongs to the next, counter-clockwise."""
    return (roots.lobe - np.greater(roots.B, np.pi)) % gear.ring_teeth


def _patch_weights(reducer: Reducer, crank: float) -> Array:
    """Compute the share of a full spring of each contact of the ideal nonpin mesh, arcs first.

    The separation of a root line and the arc of its lobe is the gap half-way between them, in working deflections.
    """
    design = reducer.design
    gear = tooth_profile(design)
    roots, low = envelope.sigma_contacts(gear, crank), gear.best_phase
    pose = GearPose(gear.eccentricity * profile.unit(-crank), -crank / gear.lobes)
    deflection = design.contact.working_force / design.contact.stiffness
    middle = (roots.B + np.where(np.greater(roots.B, np.pi), 2 * np.pi - low, low)) / 2
    arcs, owners = np.ones(gear.ring_teeth), np.empty(roots.B.size)
    for index, (root, owner) in enumerate(zip(roots.lobe, _owner(gear, roots), strict=True)):
        half_way = offset_root(gear, int(root), middle[index : index + 1])
        rise = trochoid_distance(gear, pose.to_gear(half_way))[0][0]
        owners[index] = (1.0 + min(1.0, rise / deflection)) / 2.0
        arcs[owner] *= owners[index]
    return np.concatenate([arcs, owners])


def _by_lobe(gear: CycloidGear, lobes: Integers, magnitudes: Array, normals: Array) -> Array:
    forces = np.zeros((gear.ring_teeth, 2))
    np.add.at(forces, lobes, magnitudes[:, np.newaxis] * normals)
    return forces
