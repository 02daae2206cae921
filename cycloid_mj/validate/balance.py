"""Rung 3 also: energy, forces, stiffness and balance of the springs, against exact gaps of any number of discs.

Without a simulation. Every clearance and manufacturing error is there, and unlike discs share pins that bend.
"""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.validation import ValidationRow, absolute, deviation
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.gaps import arc_gaps
from cycloid_mj.statics import loads, springs_of
from cycloid_mj.statics.kernel import KernelSprings, Rubbing, follow_path, state, state_after
from cycloid_mj.statics.samples import alike, solve_samples
from cycloid_mj.statics.sliding import Losses, rubbing_of
from cycloid_mj.validate import rig
from cycloid_mj.validate.displaced import DisplacedSprings, cam_ways, held_back

CRANK = 1.9
"""A crank angle with no symmetry [rad]."""

ONE, TWO, THREE = "one disc", "two discs", "three discs on pins that bend"

MADE = (
    *("errors.seed=4", "errors.eccentricity_um=1.5", "errors.pin_position_um=1.0", "errors.pin_radius_um=0.5"),
    *("errors.hole_position_um=1.0", "errors.disc_size_um=0.7", "errors.cam_position_um=0.8"),
    *("errors.profile_cos_um={1=0.5,5=0.3}", "errors.profile_sin_um={2=0.4}"),
    *("modification.equidistant_um=0.4", "modification.pin_circle_um=-0.7", "modification.rotation_arcsec=4.0"),
)
BUILT = {
    ONE: (),
    TWO: ("gear.discs=2", "structure=rigid"),
    THREE: ("gear.discs=3", "structure=springs"),
}

NEAR = 2e-6
"""Displacements [m] at which gaps are exact to a part in 10^5."""

SLIP = 1e-7
"""Displacements of a step [m] in which some surfaces stick and some slip."""

TURN = tuple(2.0 * np.pi * np.arange(3) / 3)
"""Crank angles of a sample [rad]."""

LOOP = np.array([0.0, 0.5, 1.0, 0.2, -0.2, -1.0, 0.5])
"""Course of torque, as shares of the rated one: there, back to the other side, and part of the way again."""

REACH = 4e-6
"""Longest way of the output [m] in a step of the course, where its steps are parted: some are longer as a whole."""

FRICTION = 0.1
"""Coefficient of friction where there is any: of all pairs."""

ROLLING = 0.02
"""That of the cam's rollers."""

SOURCE = "exact curves"


def design_with_errors(built: str, *changes: str) -> Design:
    """Return the paper's gear on fixed pins with all errors, some discs, without friction and gravity."""
    still = (*rig.without_friction(), *rig.without_gravity(), "drive.speed_rpm=1.0", f"load.torque_nm={rig.RATED_LOAD}")
    uniform = 'contact.stiffness_law="uniform"'
    return override(PRESETS["pin"], ["ring.pins=fixed", *BUILT[built], *MADE, *still, uniform, *changes])


def pressed(reducer: Reducer, crank: float = CRANK) -> tuple[KernelSprings, DisplacedSprings]:
    """Return the springs of a design at a crank angle [rad], and the same on exact gaps."""
    springs = springs_of(reducer, [crank], friction=False)
    contacts, angle = springs.contacts, float(springs.crank[0])
    play = arc_gaps(reducer, angle).play
    return contacts, DisplacedSprings(
        reducer.design, angle, contacts.stiffness[0], contacts.cam_stiffness, play, contacts.bending
    )


def way(unknowns: int, size: float) -> Array:
    """Compute a pose in which many contacts press [m], shape (u,): turns three times as far as places."""
    drawn = np.random.default_rng(2).uniform(-size, size, unknowns)
    drawn[2::3] *= 3.0
    drawn[-1] *= 3.0
    return drawn


def state_rows(built: str) -> list[ValidationRow]:
    """Hold energy and forces of displaced parts against exact gaps."""
    springs, exact = pressed(Reducer(design_with_errors(built)))
    number = springs.slope.shape[2]
    z, load = way(number, NEAR), 100.0 * way(number, 1.0)
    computed = state(springs, 0, load, z)
    energy, force = exact.energy(z) - load @ z, load + exact.push(z)
    return [
        deviation(
            f"energy of displaced parts, {built}",
            np.array([1e3 * computed.energy]),
            np.array([1e3 * energy]),
            "mJ",
            SOURCE,
            0.02,
        ),
        deviation(f"forces on displaced parts, {built}", computed.residual, force, "N", SOURCE, 0.02),
    ]


def balance_rows(built: str, *changes: str) -> list[ValidationRow]:
    """Hold the forces at the balance under the rated load against that load, and each contact's, by exact gaps."""
    design = design_with_errors(built, *changes)
    reducer = Reducer(design)
    springs = springs_of(reducer, [CRANK], friction=False)
    _, exact = pressed(reducer)
    contact_loads = loads(reducer, springs, rig.RATED_LOAD)
    z, load = contact_loads.departures[0], springs.load(Reducer(design).share * rig.RATED_LOAD)[0]
    ours = np.concatenate([contact_loads.teeth[0], contact_loads.output[0]])
    name = ", ".join((built, *changes))
    return [
        deviation(f"forces in balance, {name}", exact.push(z), -load, "N", SOURCE, 0.1),
        deviation(f"forces of contacts, {name}", ours, exact.forces(z)[: ours.size], "N", SOURCE, 0.3),
    ]


def sample_rows() -> list[ValidationRow]:
    """Hold the figures of a sample of two discs over some crank angles against the balances of exact gaps."""
    design, count = design_with_errors(TWO), len(TURN)
    stiffness = dict.fromkeys(design.pair_kinds, 3e8)  # a sample's springs are those of the design without its errors
    design = design.but(stiffness=stiffness)
    figures = solve_samples(Reducer(design), alike(Reducer(design), 1), [rig.RATED_LOAD], count)[0]
    springs = springs_of(Reducer(design), TURN, friction=False)
    contact_loads, load = loads(Reducer(design), springs, rig.RATED_LOAD), springs.load(rig.RATED_LOAD)
    z, force = [], []
    for number, crank in enumerate(TURN):
        _, exact = pressed(Reducer(design), crank)
        z.append(exact.balance(load[number], contact_loads.departures[number]))
        force.append(exact.forces(z[-1]))
    places, pushes = np.array(z), np.array(force)
    gear, output = places[:, [2, 5]].mean(axis=1), places[:, -1]
    turns = [value for one in (gear, output) for value in (one.mean(), np.ptp(one))]
    teeth = 2 * design.ring.teeth
    peaks = [pushes[:, part].max() for part in (slice(teeth), slice(teeth, -2), slice(-2, None))]
    carrying = np.sum(pushes[:, :teeth] > 0.01 * peaks[0]) / count
    lever = 1e6 / design.output.pin_circle_radius
    of_turns = ("gear_mean", "gear_range", "output_mean", "output_range")
    ours = {name: getattr(figures, name) for name in (*of_turns, "tooth", "output_pin", "cam", "carrying")}
    return [
        *(
            deviation(
                f"{name.replace('_', ', ')} of a sample",
                1e6 * ours[name],
                np.array([lever * turn]),
                "urad",
                SOURCE,
                0.1,
            )
            for name, turn in zip(of_turns, turns, strict=True)
        ),
        *(
            deviation(f"{name} force of a sample", ours[name], np.array([peak]), "N", SOURCE, 0.1)
            for name, peak in zip(("tooth", "output_pin", "cam"), peaks, strict=True)
        ),
        deviation("teeth that carry in a sample", ours["carrying"], np.array([carrying]), "", SOURCE, 1e-3),
    ]


def rubbed(built: str) -> tuple[KernelSprings, DisplacedSprings, Rubbing]:
    """Return what `pressed` does of a design with friction, and that friction, all that remembers, at a held crank."""
    rubs = (f"friction.{kind}={FRICTION}" for kind in rig.MATING)
    design = design_with_errors(built, *rubs, f"friction.cam_rolling={ROLLING}")
    reducer = Reducer(design)
    springs, exact = pressed(reducer)
    return springs, exact, rubbing_of(reducer, springs, CRANK, Losses(drag=1.0, travel=1e-4, material=0.1), "crank")


def step_rows(built: str) -> list[ValidationRow]:
    """Hold the forces after a step between displaced poses, with friction that remembers, against its law.

    Some surfaces stick in it and some slip.
    """
    springs, exact, rubbing = rubbed(built)
    number = springs.slope.shape[2]
    before, load = way(number, NEAR), 100.0 * way(number, 1.0)
    z = before + way(number, SLIP)[::-1]
    *_, push = _pushes(exact, rubbing, np.array([before, z]))
    ours = state_after(springs, rubbing, before, load, z, False).residual
    return [deviation(f"forces after a step, {built}", ours, load + push, "N", SOURCE, 0.02)]


def path_rows(built: str, reach: float = np.inf, spare: int = 0) -> list[ValidationRow]:
    """Hold a loop of torque at a held crank, with friction that remembers, against its law: what is left over.

    Of each step: springs on exact gaps push; the surfaces stick on springs that slip at their limit, and so does what
    the material holds back. Where the output moves by more than `reach` [m] at once a step is parted, as long as there
    are `spare` rows.
    """
    springs, exact, rubbing = rubbed(built)
    path = np.zeros((len(LOOP), springs.slope.shape[2]))
    path[:, -1] = rig.RATED_LOAD / springs.radius * LOOP
    when = np.zeros(len(path) + spare)
    z = np.zeros((when.size, path.shape[1]))
    rows = follow_path(springs, rubbing, path, reach, when, z)[1]
    when, z = when[:rows], z[:rows]
    load = np.stack([np.interp(when, range(len(path)), course) for course in path.T], axis=1)
    left = load + np.array(list(_pushes(exact, rubbing, z)))
    most, name = np.abs(load).max(), f"{built}, {rows} steps"
    deviations = [deviation(f"a loop with friction, {name}", load + most, load + most - left, "N", SOURCE, 0.1)]
    if spare > len(path):
        beyond = 1e6 * max(np.abs(np.diff(z[:, -1])).max() - reach, 0.0)
        deviations.append(absolute(f"way beyond reach in a step, {name}", beyond, 0.0, "um", "no step is longer", 0.0))
    return deviations


def _pushes(exact: DisplacedSprings, rubbing: Rubbing, path: Array) -> Iterator[Array]:
    """Yield the generalised force of springs and friction [N], (u,), at each pose of a path that begins at rest."""
    count, discs = rubbing.stick.size, exact.design.gear.discs
    bearing = exact.stiffness.size + discs
    before, side, material, depth = np.zeros(path.shape[1]), np.zeros(count), np.zeros(bearing), np.zeros(bearing)
    for z in path:
        slip = rubbing.slip.copy()
        for disc, (x, y) in enumerate(cam_ways(Reducer(exact.design), exact.crank, before)):
            # a disc that slides across its cam does so at right angles to the way from the cam's centre
            slip[bearing - discs + disc, 3 * disc : 3 * disc + 2] += np.array([-y, x]) / (np.hypot(x, y) or 1.0)
        (gaps, slopes), spring = exact.contacts(z), exact.forces(z)
        deeper = np.maximum(-gaps, 0.0)
        material = held_back(material, deeper - depth, rubbing.loss[:bearing] * spring, rubbing.backing[:bearing])
        pressed_by = spring + material
        limit = np.concatenate([rubbing.coefficient[:bearing] * pressed_by, rubbing.drag])
        side = held_back(side, slip @ (z - before), limit, rubbing.stick)
        yield slopes.T @ pressed_by - slip.T @ side
        before, depth = z, deeper


STATICS: tuple[Callable[[], list[ValidationRow]], ...] = (
    *(partial(state_rows, built) for built in BUILT),
    *(partial(step_rows, built) for built in (ONE, TWO)),
    *(partial(balance_rows, built) for built in BUILT),
    partial(balance_rows, TWO, "output.member=ring"),
    sample_rows,
    partial(path_rows, ONE, REACH, 30),
    partial(path_rows, TWO),
)
"""Give the rows, the quick ones first.

That forces are the descent of the energy and the stiffness that of the forces, and what each sign of a gap, a cam or a
step does alone, is no row: tests hold it, on more designs.
"""


def rows(quick: bool) -> list[ValidationRow]:
    """List the rows of this part of the rung."""
    return [row for part in STATICS for row in part()]
