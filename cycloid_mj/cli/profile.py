"""``cycloid-mj design profile``: the outline of the gear or of the internal gear, or the contact lines, as CSV."""

from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError
from cycloid_mj.cli.delivery import claim_page, deliver_columns
from cycloid_mj.cli.flags import COMMON, FLAT, CommonFlags, DesignOptions, integer_flag
from cycloid_mj.cli.outfile import Columns, CsvFlag, claim_csv
from cycloid_mj.cli.ranges import RANGES
from cycloid_mj.reducer import Reducer, reducer_of

if TYPE_CHECKING:
    from cycloid_mj.base.array import Array

EXAMPLES = """Examples:
  cycloid-mj design profile --design pin --csv gear.csv --points 7000
  cycloid-mj design profile --design pin --set ring.pin_radius_mm=2 --csv thin.csv
  cycloid-mj design profile --design nonpin --part ring --csv -
  cycloid-mj design profile --design nonpin --part curvature --csv lines.csv"""

POINTS_PER_TOOTH = 100
CRANK_ANGLES = 100
"""Default number of points of an outline per tooth, and of crank angles in a mesh period."""

Part = Literal["gear", "ring", "curvature"]
PointsFlag = Annotated[
    int | None,
    integer_flag(
        f"Number of points, from 3 to {RANGES.rows[1]}. Default: {POINTS_PER_TOOTH} for each lobe or ring tooth. "
        f"With --part curvature: crank angles in a mesh period. Default: {CRANK_ANGLES}.",
        RANGES.rows,
    ),
]
PartFlag = Annotated[
    Part,
    Parameter(
        help="gear: the cycloid gear; ring: the internal gear of a nonpin design; curvature: the contact lines of gear "
        "and pins or ring, with their relative curvature. Default: gear."
    ),
]


def profile(
    design_options: Annotated[DesignOptions, FLAT],
    *,
    csv: CsvFlag,
    points: PointsFlag = None,
    part: PartFlag = "gear",
    output_flags: Annotated[CommonFlags, FLAT] = COMMON,
) -> int:
    """Write the outline of the cycloid or internal gear, or all lines of contact, as CSV, for CAD or for a check.

    With --part gear: one closed outline, clockwise from the valley on +y in the disc's frame, equally spaced by arc
    length; the first point is not repeated at the end. Columns: x_mm, y_mm, nx, ny (outward unit normal) and
    curvature_per_mm (positive where convex). Numbers are written with all digits.

    The outline is the nominal profile, at the distance of the pin radius from the path of the pins. The clearance
    with which the parts are cut (clearance.pin_gear_um or clearance.tooth_um) is NOT included.

    With --part ring: the internal gear in the ring's frame, from the tip of the lobe on +y. Normals point into the
    bore, and curvature is positive on the lobes. A last column, part, names the curve: arc (of a lobe), or the flank
    between two lobes, sigma1 on the counter-clockwise and sigma2 on the clockwise side of a lobe.

    With --part curvature: one row for each line along which the ideal disc touches pins or ring, at crank angles that
    divide one mesh period, with the columns crank_deg (counter-clockwise), tooth (1 on +y, clockwise), part (pin, arc,
    sigma1 or sigma2), phase_deg (0 in a valley of the disc, 180 at the tip of a lobe), x_mm, y_mm (ring's frame),
    relative_curvature_per_mm (disc plus ring) and pressure_mpa (Hertz pressure under the working force of the teeth at
    the nominal torque). This force is working_force.*_n or contact.working_force_n if set, else that of ideal load
    sharing.
    """
    reducer = reducer_of(design_options.resolve())
    columns = {"gear": _gear, "ring": _ring_columns, "curvature": _curvature_columns}[part](reducer, points)
    claim_csv(csv, output_flags.force)
    page = claim_page(output_flags, f"{reducer.design.name}-{part}")
    return deliver_columns(f"{part} of {reducer.design.name}", columns, csv, page, output_flags)


def _gear(reducer: Reducer, points: int | None) -> Columns:
    from cycloid_mj.geometry.profile import sample

    outline = sample(reducer.tooth_profile, points or POINTS_PER_TOOTH * reducer.design.lobes)
    return _columns(outline.points, outline.normals, outline.curvature)


def _ring_columns(reducer: Reducer, points: int | None) -> Columns:
    """Return the outline of an internal gear as columns of n values: points, normals, curvature and part.

    Raises UsageError if the design has ring pins.
    """
    from cycloid_mj.geometry.envelope import sample_ring

    design = reducer.design
    if design.ring.kind == "pin":
        raise UsageError(
            f'--part ring needs an internal gear, but the design {design.name!r} has ring pins (ring.kind = "pin"): '
            'choose a design with ring.kind = "nonpin", e.g. --design nonpin'
        )
    outline = sample_ring(reducer.tooth_profile, points or POINTS_PER_TOOTH * design.ring.teeth)
    return {**_columns(outline.points, outline.normals, outline.curvature), "part": outline.part}


def _curvature_columns(reducer: Reducer, crank_angles: int | None) -> Columns:
    """Return relative curvature and Hertz pressure of all contact lines over a mesh period, as columns with units.

    `crank_angles` is the number of crank angles; None: `CRANK_ANGLES`. Raises UsageError if they result in too many
    rows.
    """
    import numpy as np

    from cycloid_mj.geometry.contact_lines import contact_lines, mesh_period, peak_pressure

    design, gear = reducer.design, reducer.tooth_profile
    crank_angles = crank_angles or CRANK_ANGLES
    if crank_angles * design.ring.teeth > RANGES.rows[1]:
        raise UsageError(
            f"--points {crank_angles} with {design.ring.teeth} ring teeth results in "
            f"{crank_angles * design.ring.teeth:,} rows, but at most {RANGES.rows[1]:,} are allowed: use --points "
            f"{RANGES.rows[1] // design.ring.teeth} or fewer"
        )
    all_lines = contact_lines(gear, design.ring.kind, mesh_period(gear, crank_angles))
    modulus = reducer.contacts[design.tooth_pair].modulus
    force = reducer.at_rated_load.contacts[design.tooth_pair].force
    x, y = 1e3 * all_lines.points.T
    return {
        "crank_deg": np.degrees(all_lines.crank_angle),
        "tooth": (all_lines.tooth + 1).astype(str),
        "part": all_lines.part,
        "phase_deg": np.degrees(all_lines.phase),
        "x_mm": x,
        "y_mm": y,
        "relative_curvature_per_mm": 1e-3 * all_lines.relative_curvature,
        "pressure_mpa": 1e-6 * peak_pressure(all_lines, force, design.gear.face_width, modulus),
    }


def _columns(points: "Array", normals: "Array", curvature: "Array") -> Columns:
    (x, y), (nx, ny) = points.T, normals.T
    return {"x_mm": 1e3 * x, "y_mm": 1e3 * y, "nx": nx, "ny": ny, "curvature_per_mm": 1e-3 * curvature}
