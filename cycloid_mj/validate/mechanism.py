"""Validation step "mechanism": gaps, stops and equilibrium of ``reducer`` against exact curves and a search.

No simulation. The designs have every clearance, manufacturing error and modification, so that every sign matters.
"""

from collections.abc import Callable, Sequence
from functools import partial
from operator import itemgetter

import mujoco
import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.validation import ValidationRow, deviation_row
from cycloid_mj.design import Design
from cycloid_mj.dynamics.contact.collider import install
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.geometry import kinematics
from cycloid_mj.geometry.deviations import deviations
from cycloid_mj.geometry.modification import tooth_profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bodies import build_mechanism, phases
from cycloid_mj.reducer.limits import best_fit, stops
from cycloid_mj.statics import loads, springs_of
from cycloid_mj.statics.kernel import gap
from cycloid_mj.validate import equilibrium, rig
from cycloid_mj.validate.balance import BALANCE, random_pose
from cycloid_mj.validate.displaced import cam_offsets, exact_gaps, in_ring_frame, pose_of
from cycloid_mj.validate.gaps import rotate
from cycloid_mj.validate.rig import FIXED, FREE, NONPIN, SLEEVED, design_of_kind

TURN = (1.9, 3.1, 5.2)
"""Crank angles of the equilibria [rad]."""

ERRORS = (
    "errors.hole_position_um=1.0",
    "errors.eccentricity_um=1.5",
    "errors.seed=4",
    "modification.equidistant_um=0.4",
    "modification.pin_circle_um=-0.7",
    "modification.rotation_arcsec=4.0",
    "drive.speed_rpm=1.0",
)
PIN_ERRORS = ("errors.pin_position_um=1.0", "errors.pin_radius_um=0.5")
WIDE_CLEARANCES = (
    "clearance.pin_gear_um=4.0",
    "clearance.tooth_um=4.0",
    "clearance.cam_um=3.0",
    "clearance.output_um=5.0",
)
UNIFORM = 'contact.stiffness_law="uniform"'

THREE_DISCS = ("gear.discs=3",)
"""Unlike two discs they distinguish a phase ahead on the crank from one behind."""

POSE = np.array([0.7e-6, -0.4e-6, 0.5e-6, -0.6e-6])
"""A displaced pose: the unknowns of ``reducer.gaps`` [m]."""

FAR_POSE = np.array([20e-6, -12e-6, 100e-6, -80e-6])
"""A pose with rotations large enough for second-order effects [m]."""

PIN_SHIFT = np.array([2e-6, 1e-6])
"""Displacement of the pins [m]."""

SCIPY_SOURCE = "static solution by scipy"


def design_with_errors(kind: str, *changes: str) -> Design:
    """Return a design with errors and modification, without friction and gravity."""
    condition_changes = (*rig.without_friction(), *rig.without_gravity(), f"load.torque_nm={rig.RATED_LOAD}")
    return design_of_kind(kind, *ERRORS, *(() if kind == NONPIN else PIN_ERRORS), *condition_changes, *changes)


def gap_rows(kind: str) -> list[ValidationRow]:
    """Compare the gaps that the static model computes for parts displaced by `POSE` with those of exact curves.

    `kind` is the kind of ring, such as `rig.FIXED`.
    """
    design = design_with_errors(
        kind, *WIDE_CLEARANCES, "modification.rotation_arcsec=0.0"
    )  # corners have no second derivative
    reducer = Reducer(design)
    springs = springs_of(reducer, BALANCE.crank, friction=False).contacts
    gap_widths = np.array([gap(springs, 0, contact, POSE).width for contact in range(springs.disc.size)])
    exact_widths = exact_gaps(reducer, BALANCE.crank, POSE)
    return [
        deviation_row(
            f"gaps of displaced parts, {kind}", 1e6 * gap_widths, 1e6 * exact_widths, "um", "exact curves", 0.08
        )
    ]


def hole_rows() -> list[ValidationRow]:
    """Compare the static model's gaps of output pins at large displacements with exact circles.

    Such displacements have effects of second order on the gaps.
    """
    reducer = Reducer(design_with_errors(FIXED))
    springs, tooth_count = springs_of(reducer, BALANCE.crank, friction=False).contacts, reducer.design.ring.teeth
    gap_widths = np.array(
        [gap(springs, 0, contact, FAR_POSE).width for contact in range(tooth_count, springs.disc.size)]
    )
    exact_widths, source = exact_gaps(reducer, BALANCE.crank, FAR_POSE)[tooth_count:], "exact circles"
    return [
        deviation_row("gaps of far displaced output pins", 1e6 * gap_widths, 1e6 * exact_widths, "um", source, 1e-3)
    ]


def model_rows(pins: str) -> list[ValidationRow]:
    """Compare the penetrations that the package's contact functions compute in MuJoCo with gaps of the exact curves.

    `pins` is the support of the ring pins, a value of ``ring.pins``. Three discs and the output have random
    displacements, pins and sleeves are shifted by ``PIN_SHIFT``. Open contacts count as 0.
    """
    clearances = [f"clearance.{pair}_um=0.01" for pair in ("pin_gear", "pin_socket", "pin_sleeve", "cam", "output")]
    error_changes = ("errors.cam_position_um=0.8", "errors.disc_size_um=0.7")
    design = design_with_errors(FIXED, UNIFORM, *clearances, *error_changes, *THREE_DISCS, f"ring.pins={pins}")
    reducer = Reducer(design)
    model, has_moving_pins, pin_oversize = build(design), design.ring.has_pin_bodies, deviations(design).pin_radius
    data, pose = mujoco.MjData(model.model), random_pose(3 * design.gear.discs + 1, BALANCE.near)
    for joint, value in _joint_positions(reducer, pose).items():
        data.joint(joint).qpos[0] = value
    for pin in build_mechanism(design).pins:
        data.joint(pin.joints[0]).qpos[0], data.joint(pin.joints[1]).qpos[0] = PIN_SHIFT
    with install():
        mujoco.mj_forward(model.model, data)
    pair_by_geoms = {frozenset(model.model.geom(geom).id for geom in (pair.on, pair.by)): pair for pair in model.pairs}
    pair_names = [pair_by_geoms[frozenset(geoms)].name for geoms in data.contact.geom.tolist()]
    # a pin may touch both edges of its socket: the deeper contact is its distance
    distance_by_pair = dict(sorted(zip(pair_names, data.contact.dist, strict=True), key=itemgetter(1), reverse=True))
    collider_depths = np.array([distance_by_pair.get(pair.name, 0.0) for pair in model.pairs])
    exact_gap, tooth_count = (
        exact_gaps(reducer, BALANCE.crank, pose, PIN_SHIFT if has_moving_pins else 0.0),
        design.gear.discs * pin_oversize.size,
    )
    if design.ring.has_massless_pins:
        exact_gap[:tooth_count] += np.tile(design.clearance.pin_socket - pin_oversize, design.gear.discs)
    seat_gap = equilibrium.seat_gaps(reducer, np.tile(PIN_SHIFT, (pin_oversize.size, 1)))[0]
    seat_gap -= pin_oversize if design.ring.has_sockets else 0.0
    cam_gaps = design.clearance.cam - np.linalg.norm(cam_offsets(reducer, BALANCE.crank, pose), axis=1)
    exact_depths = np.minimum(
        np.concatenate(
            [exact_gap[:tooth_count], *([seat_gap] if has_moving_pins else []), cam_gaps, exact_gap[tooth_count:]]
        ),
        0.0,
    )
    return [
        deviation_row(
            f"depths in the model, {pins} pins", 1e6 * collider_depths, 1e6 * exact_depths, "um", "exact curves", 1e-3
        )
    ]


def _joint_positions(reducer: Reducer, unknowns: Array) -> dict[str, float]:
    """Return the positions of the joints of crank, discs and output by name, [rad] or [m], at `BALANCE.crank`.

    `unknowns` is the pose [m]: x, y and rotation of each disc, then the rotation of the output. Rotations are
    multiplied by the radius of the circle of output pins.
    """
    angles = (
        float(kinematics.gear_rotation(reducer.tooth_profile, BALANCE.crank))
        + unknowns / reducer.design.output.pin_circle_radius
    )
    positions = {names.CRANK_JOINT: BALANCE.crank, names.OUTPUT_JOINT: float(angles[-1])}
    for disc, part in enumerate(reducer.gears):
        x, y = pose_of(reducer, BALANCE.crank, unknowns, disc).centre
        positions |= dict(zip(names.planar_joints(part), (x, y, angles[3 * disc + 2]), strict=True))
    return positions


def equilibrium_rows(kind: str, crank_angles: Sequence[float]) -> list[ValidationRow]:
    """Compare the static equilibrium of contact springs at crank angles [rad] with an independent solution.

    The independent solution computes the gaps from the exact curves. `kind` is the kind of ring, such as `rig.FREE`.
    The rows are tooth forces, cam force and rotation of the output; an internal gear (`rig.NONPIN`) has no row of tooth
    forces.
    """
    design = design_with_errors(kind, UNIFORM)
    reducer = Reducer(design)
    rated_reducer = reducer.at_rated_load
    stiffness = {pair: rated_reducer.contacts[pair].stiffness for pair in rated_reducer.design.pair_kinds}
    contact_loads = loads(reducer, springs_of(reducer, crank_angles, friction=False), rig.RATED_LOAD)
    equilibria = [equilibrium.solve(reducer, stiffness, crank_angle) for crank_angle in crank_angles]
    cam_forces, output_turns = (
        np.array([getattr(solution, name) for solution in equilibria]) for name in ("cam_force", "output_turn")
    )
    # An arc and a flank in one contact patch are one spring here, and up to two in the search.
    bounds = (3.0, 0.05) if kind == NONPIN else (0.01, 0.01)
    tooth_rows = []
    if kind != NONPIN:
        exact_forces = np.array([rig.vector_lengths(solution.ring_forces) for solution in equilibria]).ravel()
        tooth_rows = [
            deviation_row(
                f"teeth in statics, {kind}", contact_loads.teeth.ravel(), exact_forces, "N", SCIPY_SOURCE, 0.08
            )
        ]
    return [
        *tooth_rows,
        deviation_row(f"cam in statics, {kind}", contact_loads.cam[:, 0], cam_forces, "N", SCIPY_SOURCE, bounds[0]),
        deviation_row(
            f"turn of the output, {kind}",
            1e6 * contact_loads.output_turn,
            1e6 * output_turns,
            "urad",
            SCIPY_SOURCE,
            bounds[1],
        ),
    ]


def friction_rows(name: str, *changes: str) -> list[ValidationRow]:
    """Compare the power of the cams on the discs with the power of the load plus friction at teeth and output pins.

    The design has fixed pins, friction and no gravity. `changes` are further settings of the form ``key=value``, and
    `name` names the changed design in the row.
    """
    frictions = [f"friction.{kind}={BALANCE.friction}" for kind in (*rig.PAIR_KINDS, "cam_rolling", "output_rolling")]
    load = f"load.torque_nm={rig.RATED_LOAD}"
    design = design_of_kind(FIXED, *frictions, *rig.without_gravity(), load, "drive.speed_rpm=1.0", *changes)
    reducer = Reducer(design)
    gear, springs = tooth_profile(design), springs_of(reducer, TURN)
    contact_loads, speed = loads(reducer, springs, rig.RATED_LOAD), design.drive.speed
    disc_angles = np.add.outer(TURN, phases(design))
    velocity = speed * rotate(kinematics.gear_centre(gear, disc_angles), np.pi / 2)
    disc_speed, cam_force = speed / gear.lobes, np.linalg.norm(contact_loads.cam, axis=2)
    cam_power = (
        np.sum(contact_loads.cam * velocity, axis=(1, 2))
        - BALANCE.friction * design.gear.bore_radius * cam_force.sum(axis=1) * disc_speed
    )
    friction_power = BALANCE.friction * np.sum(
        np.concatenate([contact_loads.teeth, contact_loads.output], axis=1) * np.abs(springs.slip), axis=1
    )
    expected_power = 1e3 * (rig.RATED_LOAD * disc_speed + friction_power)
    return [
        deviation_row(f"power through friction, {name}", 1e3 * cam_power, expected_power, "mW", "load and sliding", 0.1)
    ]


def fit_rows(bound: float, *changes: str) -> list[ValidationRow]:
    """Compare the smallest gap that `best_fit` reports with the smallest gap between the exact curves in its pose.

    `best_fit` moves discs and output to the pose in which the smallest of all gaps is largest. The list has one row,
    for fixed pins and wide clearances at one crank angle. `bound` is the allowed difference [%], `changes` are settings
    of the form ``key=value``.
    """
    design = design_with_errors(FIXED, *WIDE_CLEARANCES, *changes)
    reducer = Reducer(design)
    fit = best_fit(reducer, BALANCE.crank)
    relative_angle, pose = in_ring_frame(reducer, BALANCE.crank, fit.shift, fit.gear_turn, fit.output_turn)
    cam_gaps = design.clearance.cam - np.linalg.norm(cam_offsets(reducer, relative_angle, pose), axis=1)
    min_gap = np.array([min(*cam_gaps, *exact_gaps(reducer, relative_angle, pose))])
    name = ", ".join(("least gap of the best fit", FIXED, *changes))
    return [deviation_row(name, 1e6 * np.array([fit.min_gap]), 1e6 * min_gap, "um", "exact curves", bound)]


def shifted_pin_rows(bound: float, *changes: str) -> list[ValidationRow]:
    """Compare two gaps of each free pin in the pose of `best_fit`: to the nearest disc, and to its socket.

    They are computed from the exact curves. The best fit shifts a pin so that both gaps are equal; pins that it does
    not shift are left out. `bound` is the allowed difference [%], `changes` are settings of the form ``key=value``.
    """
    design = design_with_errors(FREE, "clearance.pin_gear_um=0.5", "clearance.pin_socket_um=4.0", *changes)
    reducer = Reducer(design)
    fit, tooth_count = best_fit(reducer, BALANCE.crank), design.ring.teeth
    relative_angle, pose = in_ring_frame(reducer, BALANCE.crank, fit.shift, fit.gear_turn, fit.output_turn)
    is_shifted = np.any(fit.pin_shift, axis=1)
    disc_gaps = exact_gaps(reducer, relative_angle, pose, fit.pin_shift)[: design.gear.discs * tooth_count].reshape(
        -1, tooth_count
    )
    nearest_disc_gaps = disc_gaps.min(axis=0)[is_shifted]
    seat_gaps = (design.pin_play - deviations(design).pin_radius - np.linalg.norm(fit.pin_shift, axis=1))[is_shifted]
    name = ", ".join(("free pins between disc and socket", *changes))
    return [deviation_row(name, 1e6 * nearest_disc_gaps, 1e6 * seat_gaps, "um", "exact curves", bound)]


def stop_rows(kind: str) -> list[ValidationRow]:
    """Compare the angles of the output at its stops for rigid parts with those of very stiff parts under small torques.

    The former are solved by linear programming. `kind` is `rig.FIXED` or `rig.FREE`. Free pins are replaced by fixed
    pins with the clearances added, which is equivalent for rigid parts.
    """
    design = design_with_errors(kind, *WIDE_CLEARANCES)
    loaded_design = design
    if kind == FREE:
        design = rig.with_changes(Reducer(design), "errors.pin_radius_um=0.0").design
        total_clearance = design.clearance.pin_gear + design.clearance.pin_socket
        loaded_design = rig.with_changes(
            Reducer(design), 'ring.pins="fixed"', f"clearance.pin_gear_um={1e6 * total_clearance!r}"
        ).design
    stop_angles = 1e6 * np.array(stops(Reducer(design), BALANCE.crank))
    stiffness = dict.fromkeys(design.pair_kinds, 1e11)
    loaded_reducers = [rig.with_changes(Reducer(loaded_design), f"load.torque_nm={torque}") for torque in (-1.0, 1.0)]
    loaded_angles = 1e6 * np.array(
        [equilibrium.solve(loaded_reducer, stiffness, BALANCE.crank).output_turn for loaded_reducer in loaded_reducers]
    )
    return [deviation_row(f"stops of the output, {kind}", stop_angles, loaded_angles, "urad", SCIPY_SOURCE, 0.35)]


WITH_FRICTION: tuple[Callable[[], list[ValidationRow]], ...] = (
    partial(friction_rows, FIXED),
    partial(friction_rows, "two discs", "gear.discs=2"),
)
"""Functions that return the rows with friction."""

STATICS: tuple[Callable[[], list[ValidationRow]], ...] = (
    *(partial(gap_rows, kind) for kind in (FIXED, NONPIN)),
    hole_rows,
    *(partial(equilibrium_rows, kind, turn) for kind, turn in ((FREE, TURN), (SLEEVED, TURN), (NONPIN, TURN[:1]))),
    *WITH_FRICTION,
    partial(fit_rows, 0.1),
    partial(fit_rows, 1.0, *THREE_DISCS, "output.member=ring"),
    partial(shifted_pin_rows, 1.0),
    partial(shifted_pin_rows, 5.0, "gear.discs=2"),
    *(partial(stop_rows, kind) for kind in (FIXED, FREE)),
)
"""Functions that return the rows that need no compiled model, the fastest first."""

MODELS: tuple[Callable[[], list[ValidationRow]], ...] = tuple(
    partial(model_rows, pins) for pins in ("fixed", "free", "sleeved", "massless")
)
"""Functions that return the rows of the compiled model."""


def rows(quick: bool) -> list[ValidationRow]:
    """Return the comparisons of this validation step, the rows of its table; `quick` has no effect."""
    return [row for part in (*STATICS, *MODELS) for row in part()]
