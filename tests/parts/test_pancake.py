"""Main bearings around the output disc: a shorter drive whose parts run free and whose bill is complete."""

import math

import numpy as np
import pytest
from casings import check_casing

from cycloid_mj.base.errors import DesignError
from cycloid_mj.checks import check
from cycloid_mj.design import PRESETS, override
from cycloid_mj.parts import output_centres
from cycloid_mj.parts.contour import circle_of
from cycloid_mj.parts.export import casing
from cycloid_mj.parts.export.assembly import assembly_parts
from cycloid_mj.parts.export.casing import flange_centres
from cycloid_mj.parts.export.casing_rules import counterbore, thread_radius
from cycloid_mj.parts.export.drive import drive_length
from cycloid_mj.parts.export.output_flange import flange_screw_depth
from cycloid_mj.parts.export.rules import describe_violations
from cycloid_mj.reducer import Reducer

SHORT = {
    "pin": ("shaft.mounting=straddle",),
    "printed": ("output.main_bearings=crossed_roller",),
    "twodisc": ("output.main_bearings=crossed_roller", "output.pin_circle_radius_mm=33.5"),
}


def drive(name: str, seat: str = "disc", *more: str) -> Reducer:
    return Reducer(override(PRESETS[name], [*SHORT[name], f"output.main_bearing_seat={seat}", *more]))


@pytest.mark.parametrize(("name", "saved"), [("pin", 10.0), ("printed", 11.2), ("twodisc", 18.0)])
def test_the_drive_is_shorter_by_disc_and_hub(name: str, saved: float) -> None:
    """The bearings start a shoulder behind the face of the disc and not behind the disc."""
    short, usual = drive(name), drive(name, "hub")
    assert 1e3 * (drive_length(usual) - drive_length(short)) == pytest.approx(saved, abs=0.1)
    sizes = casing(short)
    disc_start = 0.5 * short.design.gear.stack_width + 1e-3
    assert sizes.bearings[0][0] >= disc_start + 2.0 * sizes.wall - 1e-12
    assert sizes.top >= disc_start + short.design.output.disc_thickness - 1e-12


@pytest.mark.parametrize("name", SHORT)
def test_parts_run_free_and_the_bill_has_their_mass(name: str) -> None:
    reducer = drive(name)
    check_casing(reducer, casing(reducer))


@pytest.mark.parametrize("name", SHORT)
def test_the_disc_carries_the_inner_rings_against_a_shoulder(name: str) -> None:
    reducer = drive(name)
    sizes = casing(reducer)
    output = assembly_parts(reducer, sizes)["output"]
    start, end = sizes.bearings[0][0], sizes.bearings[-1][1]
    radii = {
        (segment.z0 + 1e-9 >= start): circle.radius
        for segment in output.segments
        for circle in [circle_of(segment.outline)]
        if circle and math.hypot(*circle.centre) < 1e-9
    }
    assert radii == {True: pytest.approx(0.5 * sizes.hub.bore), False: pytest.approx(sizes.hub.shoulders[0])}
    assert max(segment.z1 for segment in output.segments) == pytest.approx(end)


@pytest.mark.parametrize("name", SHORT)
def test_the_screws_of_the_flange_are_between_the_pins(name: str) -> None:
    reducer = drive(name)
    sizes, output = casing(reducer), reducer.design.output
    screws = flange_centres(sizes)[::2]
    gaps = np.linalg.norm(screws[:, np.newaxis] - output_centres(reducer), axis=2)
    hole = thread_radius(reducer, sizes.flange_bolt.thread)
    assert gaps.min() - hole - output.root_radius >= sizes.wall * (1.0 - 1e-9)
    depth = flange_screw_depth(reducer, sizes.flange_bolt, sizes.flange_thickness)
    assert sizes.top - depth >= 0.5 * reducer.design.gear.stack_width + 1e-3 + sizes.wall - 1e-12, "blind threads"


@pytest.mark.parametrize("mounting", ["overhang", "straddle"])
def test_the_retainer_of_a_short_pin_drive_ends_at_the_heads_of_the_cover_screws(mounting: str) -> None:
    """RA 6008: bore 60 mm around pins that end at 59 mm; the retainer of 86.9 mm clears heads from 87.1 mm on."""
    sets = "output.main_bearings=crossed_roller", "output.main_bearing_seat=disc", f"shaft.mounting={mounting}"
    reducer = Reducer(override(PRESETS["pin"], [*sets]))
    sizes = casing(reducer)
    assert sizes.hub.designation == "RA 6008 UU CC0"
    assert sizes.retainer is not None
    heads = sizes.screws.circle - counterbore(sizes.screws.bolt)
    assert heads - sizes.wall < sizes.retainer.cover_radius <= heads
    assert list(describe_violations(reducer, sizes)) == []
    usual = Reducer(override(PRESETS["pin"], [f"shaft.mounting={mounting}"]))
    assert 1e3 * (drive_length(usual) - drive_length(reducer)) == pytest.approx(22.0, abs=0.05)


def test_designs_without_room_are_refused() -> None:
    checks = check(override(PRESETS["twodisc"], ["output.main_bearing_seat=disc"]))
    (warning,) = [one for one in checks if one.name == "joints"]
    assert not warning.passed
    assert "smaller circle of output pins" in warning.remedy
    with pytest.raises(DesignError, match=r"fits around the output disc.*smaller circle of output pins"):
        casing(drive("twodisc", "disc", "output.pin_circle_radius_mm=34"))
    with pytest.raises(DesignError, match=r"seat of .* mm in the output disc, but the pins leave"):
        casing(drive("pin", "disc", "shaft.radius_mm=16", "gear.bore_radius_mm=17.5"))
