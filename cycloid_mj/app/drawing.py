"""The mechanism as SVG, quick enough to be redrawn while a slider moves."""

from collections.abc import Iterator

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.names import HOUSING, gears
from cycloid_mj.design import Design
from cycloid_mj.geometry import kinematics
from cycloid_mj.geometry.modification import tooth_profile
from cycloid_mj.parts import Prism, output_centres, parts
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bodies import phases
from cycloid_mj.scene import moved, ring_places

LOOKS = {
    "ring": "#D9DFE4;#54606B",
    "pin": "#F3C969;#7A5A00",
    "gear": "#8DBFE3;#134A73",
    "behind": "#5C93BC;#134A73",
    "output": "#3FAF8B;#00543C",
    "cam": "#EDA77C;#8A3B00",
    "shaft": "#8B9199;#3B4046",
}
"""Fill and edge of each part."""

MARGIN = 1.03

FINENESS = 4000.0
"""What is drawn is as fine as half of the picture's width by this: finer than a screen shows."""


def mechanism_svg(design: Design, crank: float) -> str:
    """Draw the ideal mechanism at a crank angle [rad] as an SVG element, one unit a millimetre, +y up.

    Raises
    ------
    DesignError
        A part cannot be made.
    """
    solids = parts(Reducer(design), design.housing.outer_radius / FINENESS)
    reach = MARGIN * 1e3 * design.housing.outer_radius
    body = "".join(
        _shapes(design, solids[HOUSING].prisms[0], [solids[name].prisms[0] for name in gears(design.gear.discs)], crank)
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{-reach:.3f} {-reach:.3f} {2 * reach:.3f} {2 * reach:.3f}" '
        f'role="img" aria-label="the mechanism" stroke-width="{reach / 300:.3f}">'
        f'<g transform="scale(1,-1)">{body}</g></svg>'
    )


def _shapes(design: Design, ring: Prism, discs: list[Prism], crank: float) -> Iterator[str]:
    reducer = Reducer(design)
    gear, axis = tooth_profile(design), np.zeros(3)
    turn = float(kinematics.gear_rotation(gear, crank))
    yield _region(ring, axis, "ring")
    if design.ring.kind == "pin":
        yield from (_circle(place, design.ring.pin_radius, "pin") for place in ring_places(reducer))
    for disc, phase in reversed(list(enumerate(phases(design)))):
        pose = np.array([*kinematics.gear_centre(gear, crank + phase), turn])
        yield _region(discs[disc], pose, "behind" if disc else "gear")
    for place in moved(np.array([0.0, 0.0, turn]), output_centres(reducer)):
        yield _circle(place, design.output.pin_radius, "output")
    yield _circle(kinematics.gear_centre(gear, crank), design.gear.bore_radius, "cam")
    yield _circle(np.zeros(2), design.shaft.radius, "shaft")


def _region(prism: Prism, pose: Array, look: str) -> str:
    loops = (1e3 * moved(pose, loop) for loop in (prism.outline, *prism.holes))
    path = "".join(f"M{' '.join(f'{x:.5g},{y:.5g}' for x, y in loop.tolist())}Z" for loop in loops)
    return f'<path fill-rule="evenodd" d="{path}" {_look(look)}/>'


def _circle(place: Array, radius: float, look: str) -> str:
    x, y = (1e3 * place).tolist()
    return f'<circle cx="{x:.3f}" cy="{y:.3f}" r="{1e3 * radius:.3f}" {_look(look)}/>'


def _look(look: str) -> str:
    fill, edge = LOOKS[look].split(";")
    return f'fill="{fill}" stroke="{edge}"'
