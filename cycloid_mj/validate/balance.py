"""Validation step "mechanism", second part: energy, forces and equilibrium of the springs against exact gaps.

No simulation. The designs have every clearance and manufacturing error, up to three discs, and pins that bend.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.validation import ValidationRow, absolute, deviation_row
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.gaps import arc_gaps
from cycloid_mj.statics import loads, springs_of
from cycloid_mj.statics.friction_path import Losses, build_friction_elements
from cycloid_mj.statics.kernel import FrictionElements, KernelSprings, assemble_after, follow_path, state
from cycloid_mj.statics.samples import identical_samples, solve_samples
from cycloid_mj.validate import rig
from cycloid_mj.validate.displaced import DisplacedSprings, cam_offsets, slip_force


@dataclass(frozen=True)
class BalanceConditions:
    """Conditions of the static balances."""

    crank: float = 1.9
    """A crank angle with no symmetry [rad]."""
    near: float = 2e-6
    """Size of displacements [m] up to which gaps are exact to 1e-5."""
    slip: float = 1e-7
    """Displacements of a step [m] in which some surfaces stick and some slip."""
    max_travel: float = 4e-6
    """Longest travel of the output [m] in one step of the loop; longer steps are divided."""
    friction: float = 0.1
    """Coefficient of friction of all pairs in the cases with friction."""
    rolling: float = 0.02
    """Coefficient of friction of the rollers of the cam."""


BALANCE = BalanceConditions()


ONE, TWO, THREE = "one disc", "two discs", "three discs on pins that bend"

ERRORS = (
    *("errors.seed=4", "errors.eccentricity_um=1.5", "errors.pin_position_um=1.0", "errors.pin_radius_um=0.5"),
    *("errors.hole_position_um=1.0", "errors.disc_size_um=0.7", "errors.cam_position_um=0.8"),
    *("errors.profile_cos_um={1=0.5,5=0.3}", "errors.profile_sin_um={2=0.4}"),
    *("modification.equidistant_um=0.4", "modification.pin_circle_um=-0.7", "modification.rotation_arcsec=4.0"),
)
LAYOUTS = {
    ONE: (),
    TWO: ("gear.discs=2", "structure=rigid"),
    THREE: ("gear.discs=3", "structure=springs"),
}


TURN = tuple(2.0 * np.pi * np.arange(3) / 3)
"""Crank angles of a sample [rad]."""

LOOP = np.array([0.0, 0.5, 1.0, 0.2, -0.2, -1.0, 0.5])
"""Torques of a loop as shares of the rated torque: forward, to the other side, and part of the way back."""


SOURCE = "exact curves"


def design_with_errors(layout: str, *changes: str) -> Design:
    """Return the design of Hsieh 2014 on fixed pins with all manufacturing errors, without friction and gravity.

    `layout` is a key of `LAYOUTS` (one, two or three discs), `changes` are further settings of the form ``key=value``.
    The load is the rated load.
    """
    static_changes = (
        *rig.without_friction(),
        *rig.without_gravity(),
        "drive.speed_rpm=1.0",
        f"load.torque_nm={rig.RATED_LOAD}",
    )
    law_change = 'contact.stiffness_law="uniform"'
    return override(
        PRESETS["pin"], ["ring.pins=fixed", *LAYOUTS[layout], *ERRORS, *static_changes, law_change, *changes]
    )


def springs_and_reference(
    reducer: Reducer, crank_angle: float = BALANCE.crank
) -> tuple[KernelSprings, DisplacedSprings]:
    """Return the contact springs of a design without friction at a crank angle [rad], in two implementations.

    The first are the springs of the static model (`statics.springs_of`), with approximated gaps. The second are
    reference springs, whose gaps are computed from the exact curves without approximation. Both have the same
    stiffness.
    """
    design_springs = springs_of(reducer, [crank_angle], friction=False)
    contacts, angle = design_springs.contacts, float(design_springs.crank[0])
    play = arc_gaps(reducer, angle).play
    return contacts, DisplacedSprings(
        reducer.design, angle, contacts.stiffness[0], contacts.cam_stiffness, play, contacts.bending
    )


def random_pose(unknowns: int, size: float) -> Array:
    """Draw a pose in which many contacts press [m], shape (u,); rotations are three times as large as translations."""
    pose = np.random.default_rng(2).uniform(-size, size, unknowns)
    pose[2::3] *= 3.0
    pose[-1] *= 3.0
    return pose


def state_rows(layout: str) -> list[ValidationRow]:
    """Compare elastic energy and contact forces of the static model at a random pose with a reference.

    The reference computes the gaps from the exact curves, while the static model approximates the curves. Returns a row
    of `cycloid-mj validate` for the energy and one for the forces. `layout` is that of the reducer, a key of `LAYOUTS`.
    Displacements of the parts are at most `BALANCE.near`. The loads on their displacements are random, too, and at most
    100 N. For rotations, both limits are multiplied by three.
    """
    springs, reference = springs_and_reference(Reducer(design_with_errors(layout)))
    unknowns = springs.slope.shape[2]
    pose, load = random_pose(unknowns, BALANCE.near), 100.0 * random_pose(unknowns, 1.0)
    springs_state = state(springs, 0, load, pose)
    reference_energy, reference_force = (reference.energy(pose) - load @ pose, load + reference.generalised_force(pose))
    energies = np.array([1e3 * springs_state.energy]), np.array([1e3 * reference_energy])
    return [
        deviation_row(f"energy of displaced parts, {layout}", *energies, "mJ", SOURCE, 0.02),
        deviation_row(
            f"forces on displaced parts, {layout}", springs_state.residual, reference_force, "N", SOURCE, 0.02
        ),
    ]


def equilibrium_rows(layout: str, *changes: str) -> list[ValidationRow]:
    """Compare the forces in static equilibrium at the rated load with those of a reference.

    The reference are contact springs with gaps from the exact curves, while the static model approximates the curves.
    The equilibrium is that of the statics at one crank angle, without friction. The first row compares the generalised
    forces of the reference springs in this pose [N] with minus the load. The second row compares the forces of all
    contacts [N] with those of the reference springs. `layout` is a key of `LAYOUTS`, `changes` are settings of the form
    ``key=value``.
    """
    design = design_with_errors(layout, *changes)
    reducer = Reducer(design)
    springs = springs_of(reducer, [BALANCE.crank], friction=False)
    _, reference = springs_and_reference(reducer)
    contact_loads = loads(reducer, springs, rig.RATED_LOAD)
    pose, load = contact_loads.departures[0], springs.load(Reducer(design).share * rig.RATED_LOAD)[0]
    contact_forces = np.concatenate([contact_loads.teeth[0], contact_loads.output[0]])
    name = ", ".join((layout, *changes))
    return [
        deviation_row(f"forces in balance, {name}", reference.generalised_force(pose), -load, "N", SOURCE, 0.1),
        deviation_row(
            f"forces of contacts, {name}",
            contact_forces,
            reference.forces(pose)[: contact_forces.size],
            "N",
            SOURCE,
            0.3,
        ),
    ]


def sample_rows() -> list[ValidationRow]:
    """Compare the static results for a drive with manufacturing errors with a reference.

    The reference are contact springs with gaps from the exact curves, while the static model approximates the curves.
    The static results are those of the solver for random samples (`solve_samples`): rotations, largest forces and the
    number of loaded teeth, as means, ranges and maxima over the three crank angles `TURN`. The drive has two discs.
    """
    design, angle_count = design_with_errors(TWO), len(TURN)
    stiffness = dict.fromkeys(design.pair_kinds, 3e8)  # a sample's springs are those of the design without its errors
    design = design.but(stiffness=stiffness)
    figures = solve_samples(Reducer(design), identical_samples(Reducer(design), 1), [rig.RATED_LOAD], angle_count)[0]
    springs = springs_of(Reducer(design), TURN, friction=False)
    contact_loads, load = loads(Reducer(design), springs, rig.RATED_LOAD), springs.load(rig.RATED_LOAD)
    poses, forces = [], []
    for angle_index, crank_angle in enumerate(TURN):
        _, reference = springs_and_reference(Reducer(design), crank_angle)
        poses.append(reference.solve_equilibrium(load[angle_index], contact_loads.departures[angle_index]))
        forces.append(reference.forces(poses[-1]))
    pose_array, force_array = np.array(poses), np.array(forces)
    disc_arcs, output_arcs = pose_array[:, [2, 5]].mean(axis=1), pose_array[:, -1]
    rotations = [value for arcs in (disc_arcs, output_arcs) for value in (arcs.mean(), np.ptp(arcs))]
    tooth_count = 2 * design.ring.teeth
    peak_forces = [force_array[:, rows].max() for rows in (slice(tooth_count), slice(tooth_count, -2), slice(-2, None))]
    loaded_share = np.sum(force_array[:, :tooth_count] > 0.01 * peak_forces[0]) / angle_count
    urad_per_metre = 1e6 / design.output.pin_circle_radius
    rotation_names = ("gear_mean", "gear_range", "output_mean", "output_range")
    sample = {name: getattr(figures, name) for name in (*rotation_names, "tooth", "output_pin", "cam", "carrying")}
    return [
        *(
            deviation_row(f"{name.replace('_', ', ')} of a sample", 1e6 * sample[name], rotation, "urad", SOURCE, 0.1)
            for name, rotation in zip(
                rotation_names, np.reshape(urad_per_metre * np.array(rotations), (-1, 1)), strict=True
            )
        ),
        *(
            deviation_row(f"{name} force of a sample", sample[name], np.array([peak_force]), "N", SOURCE, 0.1)
            for name, peak_force in zip(("tooth", "output_pin", "cam"), peak_forces, strict=True)
        ),
        deviation_row("teeth that carry in a sample", sample["carrying"], np.array([loaded_share]), "", SOURCE, 1e-3),
    ]


def springs_with_friction(layout: str) -> tuple[KernelSprings, DisplacedSprings, FrictionElements]:
    """Return the contact springs, reference springs and friction elements of a design at a locked crank.

    `layout` is a key of `LAYOUTS`. Seals have a drag of 1 N m that builds up over 0.1 mrad, and the material loses 10 %
    of the contact forces during unloading.

    Returns
    -------
    tuple
        The contact springs of the static model, reference springs with gaps from the exact curves, and the friction
        elements.
    """
    friction_changes = (f"friction.{kind}={BALANCE.friction}" for kind in rig.PAIR_KINDS)
    design = design_with_errors(layout, *friction_changes, f"friction.cam_rolling={BALANCE.rolling}")
    reducer = Reducer(design)
    springs, reference = springs_and_reference(reducer)
    losses = Losses(drag=1.0, travel=1e-4, material=0.1)
    return springs, reference, build_friction_elements(reducer, springs, BALANCE.crank, losses, "crank")


def step_rows(layout: str) -> list[ValidationRow]:
    """Compare the forces of the static model after a displacement with friction with those of a reference.

    The displacement leads from one random pose to another; some surfaces stick during it while others slip. Compared
    are the residual forces [N], the sum of load, contact and friction forces. The reference are contact springs with
    gaps from the exact curves, while the static model approximates the curves. `layout` is that of the reducer, a key
    of `LAYOUTS`.
    """
    springs, reference, friction_elements = springs_with_friction(layout)
    unknowns = springs.slope.shape[2]
    pose_before, load = random_pose(unknowns, BALANCE.near), 100.0 * random_pose(unknowns, 1.0)
    pose_after = pose_before + random_pose(unknowns, BALANCE.slip)[::-1]
    *_, spring_force = _reference_forces(reference, friction_elements, np.array([pose_before, pose_after]))
    residual = assemble_after(springs, friction_elements, pose_before, load, pose_after, False).residual
    return [deviation_row(f"forces after a step, {layout}", residual, load + spring_force, "N", SOURCE, 0.02)]


def path_rows(layout: str, max_travel: float = np.inf, spare_rows: int = 0) -> list[ValidationRow]:
    """Check the static solution along a load path, a torque loop at a locked crank, by reference contact springs.

    The returned row is the largest imbalance between the loads of the path (`LOOP`) and the reference springs. These
    have gaps from the exact curves; friction and material hysteresis are springs that slip at a limit. `layout` is a
    key of `LAYOUTS`. A step in which the output rotates by more than `max_travel`, as an arc length on the circle of
    the output pins [m], is divided, into at most `spare_rows` additional steps in total. If `spare_rows` exceeds the
    number of loads, a second validation row checks that no step exceeds `max_travel`.
    """
    springs, reference, friction_elements = springs_with_friction(layout)
    load_path = np.zeros((len(LOOP), springs.slope.shape[2]))
    load_path[:, -1] = rig.RATED_LOAD / springs.radius * LOOP
    path_positions = np.zeros(len(load_path) + spare_rows)
    poses = np.zeros((path_positions.size, load_path.shape[1]))
    step_count = follow_path(springs, friction_elements, load_path, max_travel, path_positions, poses)[1]
    path_positions, poses = path_positions[:step_count], poses[:step_count]
    load = np.stack([np.interp(path_positions, range(len(load_path)), column) for column in load_path.T], axis=1)
    residual = load + np.array(list(_reference_forces(reference, friction_elements, poses)))
    largest_load, label = np.abs(load).max(), f"{layout}, {step_count} steps"
    deviations = [
        deviation_row(
            f"a loop with friction, {label}", load + largest_load, load + largest_load - residual, "N", SOURCE, 0.1
        )
    ]
    if spare_rows > len(load_path):
        excess_travel = 1e6 * max(np.abs(np.diff(poses[:, -1])).max() - max_travel, 0.0)
        deviations.append(
            absolute(f"travel beyond the limit, {label}", excess_travel, 0.0, "um", "no step is longer", 0.0)
        )
    return deviations


def _reference_forces(springs: DisplacedSprings, friction_elements: FrictionElements, path: Array) -> Iterator[Array]:
    """Yield the forces of contact springs and friction on the u unknowns [N], (u,), at each pose of a path from rest.

    Contacts and cams are `springs`, whose gaps follow from the exact curves. Their material adds
    hysteresis along the normal, and their surfaces add friction along the tangent. Seals have constant friction.
    Hysteresis and friction are springs that slip at the limits of `friction_elements`. `path` (m, u) are poses z [m] as
    in ``reducer.gaps``, in which rotations are arc lengths; a generalised force on a rotation is therefore a torque
    divided by the radius of the circle of output pins.
    """
    element_count, discs = friction_elements.stiffness.size, springs.design.gear.discs
    normal_count = springs.stiffness.size + discs
    previous_pose, friction_force, hysteresis_force, previous_depth = (
        np.zeros(path.shape[1]),
        np.zeros(element_count),
        np.zeros(normal_count),
        np.zeros(normal_count),
    )
    for pose in path:
        slip = friction_elements.slip.copy()
        for disc, (x, y) in enumerate(cam_offsets(Reducer(springs.design), springs.crank, previous_pose)):
            # a disc slides across its cam at right angles to its offset from the centre of the cam
            slip[normal_count - discs + disc, 3 * disc : 3 * disc + 2] += np.array([-y, x]) / (np.hypot(x, y) or 1.0)
        (gaps, slopes), spring_force = springs.contacts(pose), springs.forces(pose)
        depth = np.maximum(-gaps, 0.0)
        hysteresis_force = slip_force(
            hysteresis_force,
            depth - previous_depth,
            friction_elements.retained_share[:normal_count] * spring_force,
            friction_elements.retained_stiffness[:normal_count],
        )
        normal_force = spring_force + hysteresis_force
        friction_limit = np.concatenate(
            [friction_elements.coefficient[:normal_count] * normal_force, friction_elements.drag]
        )
        friction_force = slip_force(
            friction_force, slip @ (pose - previous_pose), friction_limit, friction_elements.stiffness
        )
        yield slopes.T @ normal_force - slip.T @ friction_force
        previous_pose, previous_depth = pose, depth


STATICS: tuple[Callable[[], list[ValidationRow]], ...] = (
    *(partial(state_rows, layout) for layout in LAYOUTS),
    *(partial(step_rows, layout) for layout in (ONE, TWO)),
    *(partial(equilibrium_rows, layout) for layout in LAYOUTS),
    partial(equilibrium_rows, TWO, "output.member=ring"),
    sample_rows,
    partial(path_rows, ONE, BALANCE.max_travel, 30),
    partial(path_rows, TWO),
)
"""Functions that return the rows, the fastest first.

Tests on further designs check that forces are the gradient of the energy, and the effect of each single sign.
"""


def rows(quick: bool) -> list[ValidationRow]:
    """Return the comparisons of this part of a validation step, rows of its table; `quick` has no effect."""
    return [row for part in STATICS for row in part()]
