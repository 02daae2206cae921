"""Load limits and tilting stiffness of the main bearings of an RV reducer.

They are those of a pair of bearings of the output of a central crank (`life.bearing_pair`). The pair carries the
forces of the cranks on the flanges of the carrier. Screws of the output and strength of the flanges are not rated.
"""

from cycloid_mj.life.bearing_pair import OutputBearings, balls_of, equivalent_load_limit
from cycloid_mj.life.rolling import magnitudes
from cycloid_mj.life.rv import crank_forces, main_bearing_forces
from cycloid_mj.parts.rv import axial_layout
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.rv_main_bearings import main_bearing_load_centre, require_main_bearings


def rv_output_bearings(reducer: RvReducer) -> OutputBearings:
    """Compute dimensions, load ratings and load limits of the main bearings of an RV reducer.

    The bearing next to the planets is the inner one.

    Raises
    ------
    DesignError
        The design has no main bearings that fit.
    RunError
        No static equilibrium exists.
    """
    bearing = require_main_bearings(reducer)
    load_centre, (_, flange_face) = main_bearing_load_centre(reducer, bearing), axial_layout(reducer).ends
    forces = main_bearing_forces(reducer, bearing, crank_forces(reducer, reducer.design.rated_torque))
    inner, outer = (float(magnitudes(force).max()) for force in forces)
    return OutputBearings(
        bearing=bearing,
        row=balls_of(bearing),
        spacing=2.0 * load_centre,
        lever=flange_face - load_centre,
        dynamic=bearing.dynamic,
        static=bearing.static,
        capacity=equivalent_load_limit(reducer, bearing),
        own=(inner, outer),
    )
