"""Rung 3 also: energy, forces, stiffness and balance of the springs, against exact gaps of any number of discs.

Without a simulation. Every clearance and manufacturing error is there, and unlike discs share pins that bend.
"""

from collections.abc import Callable, Iterator
from functools import partial
from itertools import product

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.validation import ValidationRow, absolute, deviation
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.gaps import arc_gaps
from cycloid_mj.reducer.member import share
from cycloid_mj.statics import loads, springs_of
from cycloid_mj.statics.kernel import FLOATING, KernelSprings, Rubbing, State, follow_path, gap, state, state_after
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

NEAR, AWAY, FAR = 2e-6, 2e-5, 1e-4
"""Displacements [m]: near, gaps are exact to a part in 10^5; away, contacts leave the part of their curves that is
known to third order, and far, all of them have."""

TURNED = 1e-4
"""Way of the output pins' circle [m] in a turn of the disc that counts to the second order."""

ACROSS, ALONG = (-2e-5, 2e-5), (-1.4e-5, -5e-6, 3e-6, 1.2e-5)
"""How far curves are apart, across and along their ideal contact [m]."""

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
    """Hold energy and forces of displaced parts against exact gaps, and the stiffness against differences of forces."""
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
        *(stiffness_row(springs, built, size) for size in (NEAR, FAR)),
    ]


def stiffness_row(springs: KernelSprings, built: str, size: float) -> ValidationRow:
    """Hold the stiffness of displaced parts against differences of the forces on them."""
    number = springs.slope.shape[2]
    z, load, step = way(number, size), np.zeros(number), 1e-9
    sides = [[state(springs, 0, load, z + sign * step * axis).residual for axis in np.eye(number)] for sign in (-1, 1)]
    softer = (np.array(sides[0]) - np.array(sides[1])) / (2.0 * step)
    stiffness = state(springs, 0, load, z).stiffness
    name, bound = ("near", 3e-5) if size == NEAR else ("far", 1.0)
    return deviation(
        f"stiffness of parts displaced {name}, {built}",
        1e-6 * stiffness.ravel(),
        1e-6 * softer.ravel(),
        "N/um",
        "differences of forces",
        bound,
    )


def gradient_rows() -> list[ValidationRow]:
    """Hold the gradient of gaps against their differences: after a large turn, and of curves far apart.

    A large turn counts to the second order; far from a valley the foot of a normal is hardest to find.
    """
    springs, _ = pressed(Reducer(design_with_errors(ONE)))
    rest, source = np.zeros(springs.slope.shape[2]), "differences of gaps"
    apart = [
        springs._replace(distance=np.full(springs.distance.shape, q), shift=np.full(springs.shift.shape, p))
        for q, p in product(ACROSS, ALONG)
    ]
    turned, of_turned = _gradients(springs, TURNED * np.eye(rest.size)[2], 1e-7)
    far, of_far = np.concatenate([_gradients(one, rest, 1e-9) for one in apart], axis=1)
    return [
        deviation("gradient of gaps, far turned", turned, of_turned, "1", source, 2e-5),
        deviation("gradient of gaps, far apart", far, of_far, "1", source, 1e-5),
    ]


def _gradients(springs: KernelSprings, z: Array, step: float) -> Array:
    """Compute the gradients of all gaps [1] and what differences of the gaps make of them, shape (2, n u)."""
    ways, gradients = step * np.eye(z.size), []
    for i in range(springs.disc.size):
        ahead, behind = (np.array([gap(springs, 0, i, z + side).width for side in sides]) for sides in (ways, -ways))
        gradients.append([gap(springs, 0, i, z).ahead, (ahead - behind) / (2.0 * step)])
    return np.concatenate(gradients, axis=1)


def normal_rows() -> list[ValidationRow]:
    """Hold how fast normals turn with the way along the surface against differences of normals.

    The most curved teeth decide: those in valleys, which are taken along the exact curve.
    """
    springs, _ = pressed(Reducer(design_with_errors(ONE)))
    z, step = way(springs.slope.shape[2], 2.5 * NEAR), 1e-9
    ways, rates, turns = step * np.eye(z.size)[:2], [], []
    for i in range(springs.disc.size):
        computed = gap(springs, 0, i, z)
        aside = np.array(computed.aside[:2])
        ahead, behind = (np.array([gap(springs, 0, i, z + side).ahead for side in sides]) for sides in (ways, -ways))
        rates.append(computed.rate * np.outer(aside, aside))
        turns.append((ahead - behind)[:, :2] / (2.0 * step))
    ours, exact, source = 1e-3 * np.ravel(rates), 1e-3 * np.ravel(turns), "differences of normals"
    return [deviation("rate at which normals turn", ours, exact, "1/mm", source, 1.5e-4)]


def closed_rows() -> list[ValidationRow]:
    """Hold the energy of gaps drawn at random, however wide, against the sum over all that are closed.

    And of gaps that are hardly open or closed, which must not pass for open.
    """
    springs, _ = pressed(Reducer(design_with_errors(ONE)))
    draw, shape = np.random.default_rng(6).uniform, springs.distance.shape
    drawn = [
        springs._replace(distance=draw(-size, size, shape), shift=draw(-size, size, shape))
        for size in np.outer(np.repeat((1e-6, 5e-6), 40), np.where(springs.turning, 1.0, 200.0))  # holes are circles
    ]
    touching = [
        springs._replace(distance=draw(-size, size, shape) - springs.room, shift=draw(-aside, aside, shape))
        for size, aside in ((1e-9, 0.0), (5e-11, 5e-7))
    ]
    load, differences, exact = np.zeros(springs.slope.shape[2]), [], []
    for apart in drawn + touching:
        widths = np.array([gap(apart, 0, i, load).width for i in range(springs.disc.size)])
        differences.append(state(apart, 0, load, load).energy - state(far_apart(apart), 0, load, load).energy)
        exact.append(0.5 * apart.stiffness[0] @ np.minimum(widths, 0.0) ** 2)
    ratio = np.array(differences) / np.array(exact)
    return [deviation("energy of gaps at random", ratio, np.ones(ratio.size), "1", "every gap that is closed", 1e-6)]


def far_apart(springs: KernelSprings) -> KernelSprings:
    """Compute springs whose contacts are all open: the cams are left."""
    return springs._replace(distance=np.full(springs.distance.shape, 1e-4), shift=np.zeros(springs.shift.shape))


def tight_rows() -> list[ValidationRow]:
    """Hold force and energy of a cam that is wider than its bore against those of two springs, one on either side."""
    tight, push = 1e-6, np.array([0.6, -0.8])
    springs = far_apart(pressed(Reducer(design_with_errors(ONE)))[0])._replace(cam_clearance=-tight)
    forces, energies, reaches = [], [], np.linspace(0.0, 3.0 * tight, 7)
    for reach in reaches:
        z = np.zeros(springs.slope.shape[2])
        z[:2] = springs.cam_place[0, 0] + reach * push
        computed = state(springs, 0, np.zeros(z.size), z)
        forces.append(-computed.residual[:2])
        energies.append(computed.energy)
    near, far = (np.maximum(tight + side * reaches, 0.0) for side in (1.0, -1.0))
    exact = springs.cam_stiffness * np.outer(near - far, push)
    stored = 0.5 * springs.cam_stiffness * (near**2 + far**2)
    source = "two springs, either side"
    return [
        deviation("force of a tight cam", np.array(forces), exact, "N", source, 1e-6),
        deviation("energy of a tight cam", 1e3 * np.array(energies), 1e3 * stored, "mJ", source, 1e-6),
    ]


def work_rows(built: str) -> list[ValidationRow]:
    """Hold the energy that is stored along a way against the work of the forces, with no step on it."""
    springs, _ = pressed(Reducer(design_with_errors(built)))
    number = springs.slope.shape[2]
    end, load = way(number, AWAY), np.zeros(number)
    shares = np.linspace(0.0, 1.0, 201)
    states = [state(springs, 0, load, share * end) for share in shares]
    pushed = np.array([-state.residual @ end for state in states])
    work = np.concatenate([[0.0], np.cumsum((pushed[1:] + pushed[:-1]) / 2.0 * np.diff(shares))])
    energy = np.array([state.energy for state in states]) - states[0].energy
    return [deviation(f"energy stored on a way, {built}", 1e3 * energy, 1e3 * work, "mJ", "work of the forces", 0.03)]


def balance_rows(
    built: str, *changes: str, torque: float = rig.RATED_LOAD, crank: float = CRANK
) -> list[ValidationRow]:
    """Hold the forces at the balance that is found against the load [N m], and each contact's, by exact gaps."""
    design = design_with_errors(built, *changes)
    reducer = Reducer(design)
    springs = springs_of(reducer, [crank], friction=False)
    _, exact = pressed(reducer, crank)
    contact_loads = loads(reducer, springs, torque)
    z, load = contact_loads.departures[0], springs.load(share(design) * torque)[0]
    ours = np.concatenate([contact_loads.teeth[0], contact_loads.output[0]])
    name = ", ".join((built, *changes, *([] if torque == rig.RATED_LOAD else [f"{torque:.5g} N m"])))
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
    """Hold a step between displaced poses, with friction that remembers, against its law; and its stiffness and energy.

    Some surfaces stick in it and some slip. Stiffness and energy are held against differences, the energy with the
    limits of friction given: with others it has none.
    """
    springs, exact, rubbing = rubbed(built)
    number = springs.slope.shape[2]
    before, load, step = way(number, NEAR), 100.0 * way(number, 1.0), 1e-10
    z = before + way(number, SLIP)[::-1]

    def after(z: Array, given: bool) -> State:
        return state_after(springs, rubbing, before, load, z, given)

    *_, push = _pushes(exact, rubbing, np.array([before, z]))
    rows = [deviation(f"forces after a step, {built}", after(z, False).residual, load + push, "N", SOURCE, 0.02)]
    for given in (False, True):
        here, sides = (
            after(z, given),
            [[after(z + way, given) for way in sign * step * np.eye(number)] for sign in (-1, 1)],
        )
        forces, energies = (
            np.array([[getattr(one, name) for one in side] for side in sides]) for name in ("residual", "energy")
        )
        softer, falls = ((behind - ahead) / (2.0 * step) for behind, ahead in (forces, energies))
        name = f"{built}, limits given" if given else built
        ours, source = 1e-6 * here.stiffness.ravel(), "differences of forces"
        rows.append(deviation(f"stiffness after a step, {name}", ours, 1e-6 * softer.T.ravel(), "N/um", source, 1e-5))
    on_the_way = [after(before + share * (z - before), True) for share in np.linspace(0.0, 1.0, 401)]
    work = np.trapezoid([one.residual @ (before - z) for one in on_the_way], dx=1.0 / 400.0)
    stored = np.array([on_the_way[-1].energy - on_the_way[0].energy])
    return [
        *rows,
        deviation(f"forces after a step, {name}", here.residual, falls, "N", "differences of energy", 1e-6),
        deviation(f"energy of a step, {name}", 1e3 * stored, 1e3 * np.array([work]), "mJ", "work of the forces", 0.01),
    ]


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


def floating_rows() -> list[ValidationRow]:
    """Hold the way of parts that nothing touches against the stiffness that keeps them where they were before."""
    design = design_with_errors(ONE)
    reducer = Reducer(design)
    springs = far_apart(pressed(reducer)[0])._replace(cam_clearance=1.0)
    rubbing = rubbing_of(reducer, springs, CRANK, Losses(), "crank")
    path = np.outer([0.0, 1.0, 0.5], way(springs.slope.shape[2], 1e-6))
    z = np.zeros_like(path)
    follow_path(springs, rubbing, path, np.inf, np.zeros(len(path)), z)
    exact = np.cumsum(path, axis=0) / (FLOATING * springs.cam_stiffness)
    ways, source = 1e6 * z.ravel(), "load over stiffness, step by step"
    return [deviation("way of floating parts", ways, 1e6 * exact.ravel(), "um", source, 1e-3)]


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
    gradient_rows,
    normal_rows,
    closed_rows,
    tight_rows,
    *(partial(work_rows, built) for built in (TWO, THREE)),
    sample_rows,
    partial(path_rows, ONE, REACH, 30),
    partial(path_rows, ONE, REACH, 3),
    partial(path_rows, TWO),
    floating_rows,
    partial(balance_rows, ONE, torque=39.657296727101006, crank=0.8),
)
"""Give the rows, the quick ones first. In the last a tooth rests where its foot point begins to be looked for."""


def rows(quick: bool) -> list[ValidationRow]:
    """List the rows of this part of the rung."""
    return [row for part in STATICS for row in part()]
