"""RV reducers without friction, and statics at the crank angles of their runs."""

import numpy as np

from cycloid_mj.base.record import Run
from cycloid_mj.design import PRESETS
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics.rv import RvLoads, compute_rv_friction, compute_rv_springs, solve_rv_loads
from cycloid_mj.statics.rv_sheet import torque_on_carrier

COULOMB_RV80E = PRESETS["rv80e"].but(friction={"law": "coulomb"})
"""The RV-80E with fixed friction coefficients, for figures that were computed with them."""

FRICTIONLESS = {
    "friction": {"law": "coulomb", "pin_gear": 0.0, "pin_socket": 0.0, "cam_rolling": 0.0},
    "planet": {"friction": 0.0},
}


def static_loads(reducer: RvReducer, run: Run) -> RvLoads:
    """Balance of springs with friction at the crank angles of a run."""
    ring, _ = reducer.member.ring_and_carrier(run["output_angle"])
    springs = compute_rv_springs(reducer, reducer.member.mesh_angle(run["sun_angle"], ring))
    torque = torque_on_carrier(reducer, reducer.design.load.torque)
    return solve_rv_loads(springs, torque, compute_rv_friction(reducer, springs.crank, np.sign(torque)))
