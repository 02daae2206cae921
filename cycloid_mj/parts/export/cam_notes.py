"""Notes on the drawings of shaft, cams and spacer about the joint between them: keyways, splines, slots and screws."""

from collections.abc import Iterator

from cycloid_mj.base import names
from cycloid_mj.base.units import MILLIMETRES, in_mm
from cycloid_mj.parts.cam_bearing import cam_radius
from cycloid_mj.parts.export.cam_clamp import CLAMP, cam_clamp
from cycloid_mj.parts.export.cam_splines import cam_spline, spline_fit
from cycloid_mj.parts.export.casing import Casing
from cycloid_mj.parts.export.casing_rules import counterbore
from cycloid_mj.parts.export.crank_joints import cam_key
from cycloid_mj.reducer import Reducer


def describe_cam_joint(reducer: Reducer, casing: Casing, name: str) -> Iterator[str]:
    """Yield the notes on the joint of cams and shaft for the drawing of the part `name`; none for other parts."""
    family = names.family(name)
    if family not in (names.SHAFT, names.CAM, names.SPACER):
        return
    if key := cam_key(reducer, casing):
        stock_key = key.bought
        depth, length = stock_key.in_hub, ""
        if family == names.SHAFT:
            depth, length = stock_key.in_shaft, f" x {in_mm(stock_key.length)} long"
        yield f"keyway {in_mm(stock_key.width)} P9 x {in_mm(depth)} deep{length} (DIN 6885), symmetry 0.02 to A"
    if spline := cam_spline(reducer):
        yield (
            f"{spline.count} splines, minor ⌀{in_mm(spline.minor)}, major ⌀{in_mm(spline.major)}, width "
            f"{in_mm(spline.width)}: {spline_fit(spline)}, symmetry 0.015 to A"
        )
        if family == names.CAM:
            yield "the splines of all cams at the same angle to the eccentricity within 0.05°"
    if family == names.CAM and (clamp := cam_clamp(reducer)):
        eccentricity = MILLIMETRES * reducer.design.gear.eccentricity
        yield (
            f"outside ⌀{in_mm(2.0 * cam_radius(reducer))} h5, eccentric by {eccentricity:.4f} ± 0.005, ground when "
            f"clamped on a mandrel; bore ⌀{in_mm(2.0 * reducer.design.shaft.radius)} H7; slot {in_mm(CLAMP.slot)} "
            "wide through the thick side"
        )
        yield (
            f"{clamp.count} x {clamp.bolt.designation.partition(' - ')[2]} across the slot, {in_mm(clamp.distance)} "
            f"from the axis: counterbore ⌀{in_mm(2.0 * counterbore(clamp.bolt))} down to {in_mm(clamp.head_face)} from "
            f"the slot's middle, thread {in_mm(clamp.engaged_length)} deep"
        )
