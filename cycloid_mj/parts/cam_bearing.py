"""Choice of the rolling bearing in stock for the cams; outside `parts.export`, which takes 50 ms to import."""

from cycloid_mj.design import stock
from cycloid_mj.reducer import Reducer


def cam_bearing(reducer: Reducer) -> tuple[stock.StockBearing, int] | None:
    """Choose the bearing in stock for each cam, and how many are side by side in a disc; None if none fits."""
    design = reducer.design
    gear = design.gear
    flush = round(2.0 * (gear.eccentricity + design.shaft.radius), 9)
    wide_enough = [
        bearing
        for bearing in stock.bearings_outside(2.0 * gear.bore_radius)
        if bearing.bore > flush or (gear.discs == 1 and bearing.bore == flush)
    ]
    return stock.side_by_side(wide_enough, gear.face_width) if gear.bearing == "rolling" else None
