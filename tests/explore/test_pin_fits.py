"""Free ring pins: needle rollers turn in their sockets, and dowels of tolerance m6 jam in them."""

import numpy as np
import pytest

from cycloid_mj.design import PRESETS, Design, fits, override
from cycloid_mj.explore.tolerances import TooManyJams, tolerance
from cycloid_mj.parts.export import bill
from cycloid_mj.reducer import Reducer

CLEARANCE = {f"clearance.{pair}_um": 5.0 for pair in ("pin_gear", "pin_socket", "cam", "output")}
SAMPLES = 64


def with_pins(low: float, high: float) -> Design:
    """Return a drive with pins of 5 mm, clearances of 5 um, and a zone of the radius of its pins [um]."""
    zone = {"tolerance.pin_radius": f"between {low:g} {high:g}"}
    return override(PRESETS["pin"], {"ring.pin_radius_mm": 2.5, **CLEARANCE, **zone})


def test_dowels_of_m6_jam_in_sockets_with_5_um_of_clearance() -> None:
    """ISO 286: m6 at 5 mm is +4 to +12 um on the diameter, +2 to +6 um on the radius."""
    assert np.allclose(fits.limits("m6", 5e-3), (4e-6, 12e-6))
    with pytest.raises(TooManyJams, match="pin_gear interferes"):
        tolerance(with_pins(2.0, 6.0), samples=16)


def test_needle_rollers_of_iso_3096_turn_and_are_those_of_the_bill() -> None:
    """A group of 0/-2 um on the diameter is 0 to -1 um on the radius."""
    design = with_pins(-1.0, 0.0)
    assert not tolerance(design, samples=SAMPLES).jams.any()
    (pins,) = (line for line in bill(Reducer(design)) if line.item == "pin")
    assert pins.designation.startswith("ISO 3096 - 5 x ")
    assert pins.fit.startswith("0/-2 um")
