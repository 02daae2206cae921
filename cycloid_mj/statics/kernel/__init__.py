"""Static equilibrium of unilateral springs, compiled: a small Newton iteration for each crank angle.

Every spring is a gap from ``reducer.gaps`` with its curvature; the cams are circles in circles. `contacts` computes the
gaps, `system` assembles residual and tangent, and `newton` is the semismooth Newton method. `search` adds
natural-parameter continuation, and `continuation` pseudo-arclength continuation as the last resort. `samples` solves
many similar reducers, and `hysteresis` follows load paths with elastoplastic friction. docs/physics.md explains why a
solution is an equilibrium or a jam.
"""

from cycloid_mj.statics.kernel.contacts import Gap, KernelSprings, gap, is_open
from cycloid_mj.statics.kernel.hysteresis import MAX_SUBSTEPS, FrictionElements, assemble_after, follow_path
from cycloid_mj.statics.kernel.newton import PATH_RESIDUAL_RTOL, RESIDUAL_RTOL, RIGID_BODY_STIFFNESS, Residual
from cycloid_mj.statics.kernel.rollers import linearise_rollers
from cycloid_mj.statics.kernel.samples import (
    CARRYING_SHARE,
    FIGURES,
    Effects,
    SampleDeviations,
    allocate_workspace,
    solve_few_samples,
    solve_many_samples,
)
from cycloid_mj.statics.kernel.search import solve_equilibria
from cycloid_mj.statics.kernel.system import State, state

__all__ = [
    "CARRYING_SHARE",
    "FIGURES",
    "MAX_SUBSTEPS",
    "PATH_RESIDUAL_RTOL",
    "RESIDUAL_RTOL",
    "RIGID_BODY_STIFFNESS",
    "Effects",
    "FrictionElements",
    "Gap",
    "KernelSprings",
    "Residual",
    "SampleDeviations",
    "State",
    "allocate_workspace",
    "assemble_after",
    "follow_path",
    "gap",
    "is_open",
    "linearise_rollers",
    "solve_equilibria",
    "solve_few_samples",
    "solve_many_samples",
    "state",
]
