"""Main bearings of an RV reducer: a preloaded pair in stock, back to back, one on each flange of the carrier.

The outer rings are in the housing, against its shoulders next to the ring pins, which they retain along the axis. If
they are too large for this, a stop ring is between shoulder and outer ring. The inner rings are on the flanges, which
clamp them by a shoulder at their outer faces.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.units import in_mm
from cycloid_mj.design import stock
from cycloid_mj.reducer.bending import AXIAL_GAP

if TYPE_CHECKING:
    from cycloid_mj.reducer.rv import RvReducer


@dataclass(frozen=True)
class MainBearingSpace:
    """Space for a main bearing between a flange of the carrier and the housing [m].

    Attributes
    ----------
    min_bore
        Diameter of the flange, with walls around tapered bearings and posts.
    min_outside, max_outside
        Diameter out to which the sockets of the ring pins reach, and largest diameter that leaves a wall of the
        housing.
    max_shoulder
        Largest radius of the shoulder of an outer ring that retains the ring pins.
    """

    min_bore: float
    min_outside: float
    max_outside: float
    max_shoulder: float

    def __str__(self) -> str:
        """Describe the bearings that fit."""
        return (
            f"a bore of at least {in_mm(self.min_bore)} mm and an outside diameter of {in_mm(self.min_outside)} to "
            f"{in_mm(self.max_outside)} mm"
        )

    def fits_inside(self, bearing: stock.StockBearing) -> bool:
        """Return whether the flange fits into a bearing that is larger than the sockets, whatever the housing."""
        return bearing.bore > self.min_bore - stock.ROUNDING and bearing.outside > self.min_outside - stock.ROUNDING

    def fits(self, bearing: stock.StockBearing) -> bool:
        """Return whether a bearing fits between flange and housing."""
        return self.fits_inside(bearing) and bearing.outside < self.max_outside + stock.ROUNDING

    def retains_pins(self, bearing: stock.StockBearing) -> bool:
        """Return whether the outer ring of a bearing retains the ring pins without a stop ring."""
        return bearing.shoulders[1] < self.max_shoulder + stock.ROUNDING


def main_bearing_space(reducer: "RvReducer") -> MainBearingSpace:
    """Return the limits of bore, outside diameter and shoulder [m] of main bearings between flanges and housing.

    They do not depend on the main bearings that the design has (`cranks.main_bearings`).
    """
    design = reducer.design
    return MainBearingSpace(
        min_bore=2.0 * reducer.min_flange_radius,
        min_outside=2.0 * design.ring_root_radius,
        max_outside=2.0 * (design.housing.outer_radius - reducer.flange_wall),
        max_shoulder=design.pin_retaining_radius,
    )


def choose_main_bearing(reducer: "RvReducer") -> stock.StockBearing | None:
    """Return the largest stock bearing that fits between flange and housing; None if none fits.

    Bearings that need no stop ring have priority.
    """
    space = main_bearing_space(reducer)
    fitting = [bearing for bearing in stock.catalogued_angular_contact_bearings() if space.fits(bearing)]
    return max(fitting, key=lambda bearing: (space.retains_pins(bearing), bearing.bore), default=None)


def stop_ring_thickness(reducer: "RvReducer", bearing: stock.StockBearing) -> float:
    """Return the thickness of the stop ring between ring pins and outer ring [m]; 0 if a `bearing` needs none."""
    return 0.0 if main_bearing_space(reducer).retains_pins(bearing) else reducer.flange_wall


def flange_face(reducer: "RvReducer") -> float:
    """Return the distance of the inner faces of the flanges, and of the housing's shoulders, from the middle [m]."""
    return 0.5 * reducer.design.gear.stack_width + AXIAL_GAP


def main_bearing_ends(reducer: "RvReducer", bearing: stock.StockBearing) -> tuple[float, float]:
    """Return the ends along z [m] of the main bearing `bearing` away from the planets; the other is its mirror image.

    It begins at the face of its flange next to the discs, or at the stop ring.
    """
    start = flange_face(reducer) + stop_ring_thickness(reducer, bearing)
    return start, start + bearing.width


def main_bearing_load_centre(reducer: "RvReducer", bearing: stock.StockBearing) -> float:
    """Return the position along z [m] of the load centre of the main bearing `bearing` away from the planets.

    The lines of contact meet the axis there. The load centre of the other bearing is its mirror image.
    """
    return 0.5 * sum(main_bearing_ends(reducer, bearing)) + bearing.load_centre_offset


def min_flange_thickness(reducer: "RvReducer", bearing: stock.StockBearing) -> float:
    """Return the smallest thickness [m] of a flange that has the seat of a `bearing` and the shoulder next to it.

    It is rounded to 1 nm, so that the printed value is sufficient.
    """
    return round(stop_ring_thickness(reducer, bearing) + bearing.width + reducer.flange_wall, 9)


def require_main_bearings(reducer: "RvReducer") -> stock.StockBearing:
    """Return the main bearing on each flange; raise DesignError if the design has none, or none that fits."""
    if reducer.cranks.main_bearings == "none":
        raise DesignError(f'{reducer.design.name} has no main bearings: set cranks.main_bearings to "angular_contact"')
    bearing, thickness = reducer.main_bearing, reducer.cranks.flange_thickness
    if bearing is None:
        raise DesignError(
            f'no stock bearing fits cranks.main_bearings = "{reducer.cranks.main_bearings}": it needs '
            f"{main_bearing_space(reducer)}"
        )
    if reducer.design.ring.has_sleeves:
        raise DesignError(
            "the pins inside of sleeves require end plates, which leave no space for main bearings: set "
            'cranks.main_bearings = "none", or ring.pins = "free" or "fixed"'
        )
    if thickness < min_flange_thickness(reducer, bearing) - stock.ROUNDING:
        raise DesignError(
            f"cranks.flange_thickness_mm = {in_mm(thickness)} is too small for the main bearing {bearing.designation} "
            f"and its shoulder: set it to at least {in_mm(min_flange_thickness(reducer, bearing))}"
        )
    return bearing
