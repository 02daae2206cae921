"""The parts of the reducer as exact extruded outlines, with sections for CAD, mass properties and watertight meshes.

Contours are the single source of each part and provide its curves and polygons. The parts follow from a ``Design``;
parts that do not fit together are refused here, with the keys of the design file.
"""

from cycloid_mj.parts.accuracy import VISUAL_CHORD_ERROR, mass_chord_error
from cycloid_mj.parts.body_inertia import (
    input_inertia,
    moving_masses,
    output_inertia,
    pin_mass_matrix,
    play_inertia,
    turning_inertia,
)
from cycloid_mj.parts.gear import gear_solid
from cycloid_mj.parts.housing import housing_solid, pin_solid, sleeve_core_radius
from cycloid_mj.parts.inertia import MassProperties, mass_properties
from cycloid_mj.parts.mesh import Mesh, mesh
from cycloid_mj.parts.output import output_centres, output_solid, pin_radius
from cycloid_mj.parts.part import Part, PartSection, Segment
from cycloid_mj.parts.parts import (
    attached_parts,
    body_solids,
    crank_segments,
    crank_solid,
    lay_out_parts,
    part_sections,
    parts,
    rv_solids,
)
from cycloid_mj.parts.polygon import circle
from cycloid_mj.parts.prism import Prism, Solid
from cycloid_mj.parts.shaft import shaft_segments, shaft_solid, spacer_radius

__all__ = [
    "VISUAL_CHORD_ERROR",
    "MassProperties",
    "Mesh",
    "Part",
    "PartSection",
    "Prism",
    "Segment",
    "Solid",
    "attached_parts",
    "body_solids",
    "circle",
    "crank_segments",
    "crank_solid",
    "gear_solid",
    "housing_solid",
    "input_inertia",
    "lay_out_parts",
    "mass_chord_error",
    "mass_properties",
    "mesh",
    "moving_masses",
    "output_centres",
    "output_inertia",
    "output_solid",
    "part_sections",
    "parts",
    "pin_mass_matrix",
    "pin_radius",
    "pin_solid",
    "play_inertia",
    "rv_solids",
    "shaft_segments",
    "shaft_solid",
    "sleeve_core_radius",
    "spacer_radius",
    "turning_inertia",
]
