"""Compliance of each part under a torque on the output at a held crank, by plane finite elements.

The forces on a part do work along its own displacements; half of it is stored in the part. In a drive that is in
balance and whose forces are in proportion to the torque T, the output turns by C T, and the work of all parts is C T^2
(Castigliano): each adds its own. That holds without friction. So the give of discs, ring, carrier and shaft, which
statics leaves out or takes as rings and beams, adds up with that of their contacts: each patch is as wide as Hertz has
it, in both of its parts.
"""

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.record import Run
from cycloid_mj.parts.parts import crank_stretches
from cycloid_mj.parts.shaft import bearing_seats
from cycloid_mj.reducer import Reducer
from cycloid_mj.stress.loads import PartLoads, part_loads, part_names
from cycloid_mj.stress.mounts import Mounts, crank_give, studs_given
from cycloid_mj.stress.part import part_case, part_grid
from cycloid_mj.stress.study import QUICK, StudySettings

ANGLES = 12
"""Crank angles that the mean is of."""


def given(
    run: Run, reducer: Reducer, settings: StudySettings = QUICK, mounts: Mounts | None = None
) -> dict[str, float]:
    """Compute by how much each part turns the output per torque on it [rad/(N m)], the mean over a turn of the crank.

    Beside the parts stand the seats of the shaft's bearings in the housing, ``bearing_seats``, and what mounts tell:
    ``studs`` and ``far_plate`` (`mounts.studs_given`), and ``crank`` in place of shaft and seats (`mounts.crank_give`).

    Parameters
    ----------
    run
        Without friction, under a torque on the output, ``load.torque`` of the reducer's design, for one settled turn of
        the crank (`figures.for_one_turn`): its forces are in proportion to that torque where all contacts that close
        have closed.
    reducer
        The reducer of the run.
    settings
        How fine the grids are.
    mounts
        What a drawing tells beside the design.

    Raises
    ------
    CycloidError
        A part cannot be meshed or is not held, a package of the extra ``fem`` is missing, or mounts are told of another
        kind of drive.
    """
    mounts = mounts or Mounts()
    torque = reducer.design.load.torque
    crank = np.linspace(0.0, 2.0 * np.pi, ANGLES, endpoint=False)
    shares = {}
    for part in part_names(reducer):
        loads = part_loads(run, reducer, part, crank)
        if part == "shaft" and mounts.crank:
            squared = np.mean(np.sum(np.sum(loads.force, axis=1) ** 2, axis=1))
            shares["crank"] = crank_give(reducer, mounts.crank) * float(squared) / torque**2
            continue
        if part == "output" and mounts.studs:
            shares |= studs_given(reducer, mounts.studs, loads)
        answer = part_case(reducer, part_grid(reducer.design, part, settings.grid(part)), loads).response(
            np.arange(ANGLES)
        )
        work = np.sum(answer.forces * answer.moved, axis=0)
        # the study has one pin of the ring: the others carry in turn
        alike = reducer.design.ring.teeth if part == "pin_1" else 1
        shares[part] = alike * float(np.mean(work)) / torque**2
        if part == "shaft":
            shares["bearing_seats"] = float(np.mean(_seats_work(reducer, loads))) / torque**2
    return shares


def _seats_work(reducer: Reducer, loads: PartLoads) -> Array:
    """Compute the work of the bearings' forces on their seats [J], shape (k,): a seat of width w gives 1/(E w).

    That is what a round part gives that presses on its bore in a plate (Tate and Rosenfeld, NACA TN 1051, 1946), with E
    of the housing; what each of the two bearings carries is by statics.
    """
    seats = bearing_seats(reducer, crank_stretches(reducer))
    far, near = (0.5 * sum(seat) for seat in seats)
    planes = np.array(reducer.design.gear.disc_planes)
    on_near = (planes - far) / (near - far)
    give = [1.0 / (reducer.design.material_of("housing").youngs_modulus * (end - begin)) for begin, end in seats]
    carried = [np.einsum("d,kdx->kx", share, loads.force) for share in (1.0 - on_near, on_near)]
    return np.asarray(sum(one * np.sum(force**2, axis=1) for one, force in zip(give, carried, strict=True)))
