"""All parts of a reducer by name."""

from functools import lru_cache

from cycloid_mj.design import Design
from cycloid_mj.solid.gear import gear_solid
from cycloid_mj.solid.housing import housing_solid, pin_solid
from cycloid_mj.solid.output import output_solid
from cycloid_mj.solid.prism import Solid
from cycloid_mj.solid.shaft import balanced_shaft

SHAPING_NOTHING = (
    *("name", "errors", "friction", "drag", "contact", "stiffness", "damping", "working_force"),
    *("drive", "load", "environment", "settings"),
)
"""What of a design no part depends on: runs at other loads and speeds have the same parts, which are drawn once."""


def parts(design: Design, chord_error: float | None = None) -> dict[str, Solid]:
    """Give housing, shaft, gear, pin (one of N; only where the ring has pins) and output, each in its own frame.

    The pin of a sleeved ring is the sleeve; the pressed-in pins are the housing's.

    Parameters
    ----------
    design
        The design.
    chord_error
        Largest distance of a chord from its curve [m]; right for mass properties when left out.

    Raises
    ------
    DesignError
        A part cannot be made, or the parts do not fit into each other.
    """
    unshaped = {name: Design.model_fields[name].default for name in SHAPING_NOTHING}
    return dict(_parts(design.model_copy(update=unshaped), chord_error))


@lru_cache(maxsize=32)
def _parts(design: Design, chord_error: float | None) -> dict[str, Solid]:
    gear = gear_solid(design, chord_error)
    solids = [housing_solid(design, chord_error), balanced_shaft(design, gear, chord_error), gear]
    if design.ring.kind == "pin":
        solids.append(pin_solid(design, chord_error))
    solids.append(output_solid(design, chord_error))
    return {solid.name: solid for solid in solids}
