"""Compliance of each part under a torque on the output with a locked crank, by plane finite elements.

In a balanced drive without friction whose forces are in proportion to the torque T, the output turns by C T, and the
work of the forces on all parts along their own displacements is C T^2 (Castigliano), so the compliances of the parts
add. They include that of their contacts, since each patch has Hertz's width in both of its parts.
"""

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.record import Run
from cycloid_mj.parts.parts import crank_segments
from cycloid_mj.parts.shaft import bearing_seats
from cycloid_mj.reducer import Reducer
from cycloid_mj.stress.loads import PartLoads, loads_in_turn, part_names, turn_of
from cycloid_mj.stress.mounts import Mounts, crank_compliance, studs_compliance
from cycloid_mj.stress.part import part_case, part_grid
from cycloid_mj.stress.study import QUICK


def compute_part_compliance(run: Run | None, reducer: Reducer, mounts: Mounts | None = None) -> dict[str, float]:
    """Compute the torsional compliance of each part at the output [rad/(N m)] by name, as the mean over a crank turn.

    It is the work of the forces on the part along their displacements, divided by the square of the output torque
    (Castigliano). In addition to the parts, the result contains ``bearing_seats``, the seats of the shaft's bearings in
    the housing. With mounts it contains ``studs`` and ``far_plate`` (`mounts.studs_compliance`), and ``crank``
    (`mounts.crank_compliance`) instead of the shaft and its seats.

    Parameters
    ----------
    run
        Run without friction under the torque ``load.torque`` on the output for one settled turn of the crank
        (`figures.for_one_turn`); None for an RV reducer. The compliance assumes that the forces are proportional to the
        torque.
    reducer
        The reducer of the run.
    mounts
        Seats of output pins and crank in elastic plates, from a drawing; None: without these seats.

    Raises
    ------
    CycloidError
        A part does not mesh or has no support, a package of the extra ``fem`` is missing, or the mounts do not fit the
        design.
    """
    mounts = mounts or Mounts()
    torque = reducer.design.load.torque
    crank_angles = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    turn = turn_of(run, reducer, crank_angles)
    compliance = {}
    for part in part_names(reducer):
        loads = loads_in_turn(turn, part)
        if part == "shaft" and mounts.crank:
            mean_square_force = np.mean(np.sum(np.sum(loads.force, axis=1) ** 2, axis=1))
            compliance["crank"] = crank_compliance(reducer, mounts.crank) * float(mean_square_force) / torque**2
            continue
        if part == "output" and mounts.studs:
            compliance |= studs_compliance(reducer, mounts.studs, loads)
        response = part_case(reducer, part_grid(reducer.design, part, QUICK.grid(part)), loads).response(
            np.arange(crank_angles.size)
        )
        work = np.sum(response.forces * response.displacements, axis=0)
        # the study has one pin of the ring: the others carry in turn
        equal_parts = reducer.design.ring.teeth if part == "pin_1" else 1
        compliance[part] = equal_parts * float(np.mean(work)) / torque**2
        if part == "shaft":
            compliance["bearing_seats"] = float(np.mean(_seats_work(reducer, loads))) / torque**2
    return compliance


def _seats_work(reducer: Reducer, loads: PartLoads) -> Array:
    """Compute the work of the shaft's bearing forces on their elastic seats in the housing at k angles [J], (k,).

    `loads` are those of the shaft. A seat of width w has the compliance 1/(E w) of a round part in the bore of a plate
    (Tate and Rosenfeld, NACA TN 1051, 1946), with Young's modulus E of the housing. The forces of both bearings follow
    from equilibrium.
    """
    seats = bearing_seats(reducer, crank_segments(reducer))
    far_seat, near_seat = (0.5 * sum(seat_ends) for seat_ends in seats)
    disc_planes = np.array(reducer.design.gear.disc_planes)
    near_share = (disc_planes - far_seat) / (near_seat - far_seat)
    compliances = [1.0 / (reducer.design.material_of("housing").youngs_modulus * (end - start)) for start, end in seats]
    seat_forces = [np.einsum("d,kdx->kx", share, loads.force) for share in (1.0 - near_share, near_share)]
    return np.asarray(
        sum(
            seat_compliance * np.sum(force**2, axis=1)
            for seat_compliance, force in zip(compliances, seat_forces, strict=True)
        )
    )
