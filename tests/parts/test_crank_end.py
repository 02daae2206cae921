"""Retaining rings that locate the crank along its axis, and the seal ring of a crank in needle bearings."""

import pytest
from casings import check_casing

from cycloid_mj.base import names
from cycloid_mj.base.errors import DesignError
from cycloid_mj.checks import check
from cycloid_mj.design import PRESETS, Design, override, stock
from cycloid_mj.parts.contour import circle_of
from cycloid_mj.parts.export import casing, place_parts
from cycloid_mj.parts.export.assembly import assembly_parts
from cycloid_mj.parts.export.drawing import part_drawings
from cycloid_mj.parts.export.drive import drive_length
from cycloid_mj.parts.export.insertion import assembly_moves, blockages
from cycloid_mj.parts.export.order import assembly_order
from cycloid_mj.parts.part import Part
from cycloid_mj.reducer import Reducer

RINGS = {
    "pin": ("shaft.radius_mm=6", "shaft.bearing_width_mm=6", "shaft.bearing_offset_mm=4.1"),
    "printed": ("shaft.bearing_offset_mm=4.1",),
    "twodisc": ("shaft.radius_mm=10", "shaft.bearing_width_mm=9", "shaft.bearing_offset_mm=4.6"),
}
"""Designs in ball bearings that leave room for both rings: 61901 and 61904."""

SEALED = "shaft.radius_mm=7", "shaft.bearing_width_mm=12"
"""A crank in HK1412."""


def design(name: str, *changes: str) -> Design:
    return override(PRESETS[name], [*changes])


def radii(part: Part, z: float, *, holes: bool = False) -> set[float]:
    """Return the radii [m] of the outlines of a part at a height [m], or of its holes."""
    segments = [one for one in part.segments if one.z0 < z < one.z1]
    contours = [contour for one in segments for contour in (one.holes if holes else (one.outline,))]
    return {round(circle.radius, 9) for contour in contours if (circle := circle_of(contour))}


@pytest.mark.parametrize("name", RINGS)
def test_rings_lie_in_grooves_at_both_ends_of_the_bearings(name: str) -> None:
    """DIN 471 and 472 of the bearings: 61901 is 12 x 24 mm, 61904 20 x 37 mm."""
    reducer = Reducer(design(name, *RINGS[name], "shaft.retaining_rings=true"))
    sizes = casing(reducer)
    on_shaft, in_bore = sizes.crank_end.shaft_ring, sizes.crank_end.bore_ring
    assert on_shaft is not None
    assert in_bore is not None
    expected = ("DIN 471 - 20 x 1.2", "DIN 472 - 37 x 1.5") if name == "twodisc" else None
    assert (on_shaft.designation, in_bore.designation) == (expected or ("DIN 471 - 12 x 1", "DIN 472 - 24 x 1.2"))
    parts, (start, end) = assembly_parts(reducer, sizes), sizes.near
    assert radii(parts["shaft"], start - 0.5 * on_shaft.thickness) == {0.5 * on_shaft.groove}
    assert radii(parts["motor_cover"], end + 0.5 * in_bore.thickness, holes=True) >= {0.5 * in_bore.groove}
    assert sizes.journal <= start - on_shaft.room + 1e-12, "land beyond the groove of the crank"
    assert sizes.floor >= end + in_bore.room - 1e-12, "land beyond the groove of the cover"
    heights = {place.name: place.origin[2] for place in place_parts(reducer, 0.0, sizes)}
    assert heights[f"{names.SHAFT_RING}_1"] == pytest.approx(start - 0.5 * on_shaft.thickness)
    assert heights[f"{names.BORE_RING}_1"] == pytest.approx(end + 0.5 * in_bore.thickness)


@pytest.mark.parametrize("name", RINGS)
def test_a_drive_with_rings_can_be_assembled_and_turns(name: str) -> None:
    reducer = Reducer(design(name, *RINGS[name], "shaft.retaining_rings=true"))
    sizes = casing(reducer)
    assert not sizes.motor.tapped, "screws from within would hide the ring of the crank"
    steps = " ".join(assembly_order(reducer, sizes))
    assert "snap the bore_ring in" in steps
    assert steps.index("snap the shaft_ring on the shaft") > steps.index("crosswise"), "after the cover"
    lines = {line.item: line for line in check_casing(reducer, sizes)}
    assert [lines[item].count for item in (names.SHAFT_RING, names.BORE_RING)] == [1, 1]


def test_drawings_state_the_zones_of_the_grooves() -> None:
    """DIN 471 has h11 up to 22 mm, DIN 472 H12 above."""
    reducer = Reducer(design("printed", *RINGS["printed"], "shaft.retaining_rings=true"))
    drawings = {one.name: one for one in part_drawings(reducer, casing(reducer))}
    texts = {name: [one.text for one in drawings[name].diameters] for name in ("shaft", "motor_cover")}
    assert "\u230011.5 h11 (+0/-110 \u00b5m)" in texts["shaft"]
    assert "\u230025.2 H12 (+210/+0 \u00b5m)" in texts["motor_cover"]


def test_a_ring_wider_than_its_cover_could_not_be_mounted(monkeypatch: pytest.MonkeyPatch) -> None:
    reducer = Reducer(design("pin", *RINGS["pin"], "shaft.retaining_rings=true"))
    sizes = casing(reducer)
    assert blockages(reducer, sizes) == ()
    monkeypatch.setattr("cycloid_mj.parts.export.insertion._flex_ring", lambda *parts: parts[-1])
    assert {"bore_ring_1", "shaft_ring_1"} <= {one.part for one in blockages(reducer, sizes)}, "rings must flex"
    other_moves = tuple(move for move in assembly_moves(reducer, sizes) if "bore_ring_1" not in move.parts)
    monkeypatch.setattr("cycloid_mj.parts.export.insertion.assembly_moves", lambda *_: other_moves)
    assert "bore_ring_1" not in {one.part for one in blockages(reducer, sizes)}, "no move, no blockage"


@pytest.mark.parametrize(
    ("name", "changes", "message"),
    [
        ("pin", (), "needs standard ball bearings"),
        ("printed", (), r"needs shaft.bearing_offset_mm = 4\.10 or more"),
        ("printed", ("shaft_material.name=PETG",), "groove of a plastic crank is too weak"),
    ],
)
def test_rings_without_room_are_refused_with_the_remedy(name: str, changes: tuple[str, ...], message: str) -> None:
    requested = design(name, *changes, "shaft.retaining_rings=true")
    with pytest.raises(DesignError, match=message):
        casing(Reducer(requested))
    (warning,) = [one for one in check(requested) if one.name == "joints"]
    assert not warning.passed
    with pytest.raises(DesignError, match="hides the retaining ring"):
        casing(Reducer(design("printed", *RINGS["printed"], "shaft.retaining_rings=true")), "nema17")


def test_the_seal_ring_is_next_to_the_needles_on_the_motor_side() -> None:
    """HK1412 is 14 x 20 mm, so is the seal; the drive is longer by its 3 mm."""
    plain, reducer = (Reducer(design("pin", *SEALED, f"shaft.seal_ring={word}")) for word in ("false", "true"))
    sizes = casing(reducer)
    seal = stock.seal_ring(14e-3, 20e-3)
    assert sizes.crank_end.seal == seal
    assert seal is not None
    (place,) = (one for one in place_parts(reducer, 0.0, sizes) if one.part == names.SHAFT_SEAL)
    assert place.body == "housing"
    assert place.origin[2] == pytest.approx(sizes.near[0] - 0.5 * seal.width)
    assert radii(assembly_parts(reducer, sizes)["motor_cover"], place.origin[2], holes=True) >= {sizes.seat}
    assert sizes.journal <= sizes.near[0] - seal.width + 1e-12, "the lip is on the journal"
    assert drive_length(reducer) - drive_length(plain) == pytest.approx(seal.width, abs=1e-9)
    assert "press the shaft_seal, its lip towards the discs" in " ".join(assembly_order(reducer, sizes)).lower()
    (line,) = (one for one in check_casing(reducer, sizes) if one.item == names.SHAFT_SEAL)
    assert (line.designation, line.count) == ("G 14 x 20 x 3", 1)


@pytest.mark.parametrize(
    ("name", "changes", "message"),
    [
        ("printed", (), "ball bearings, which are sealed themselves"),
        ("pin", (), "no standard seal ring"),
        ("pin", (*SEALED, "shaft.bore_radius_mm=3", "shaft.mounting=straddle"), "a seal at both ends"),
    ],
)
def test_seals_that_do_not_fit_are_refused(name: str, changes: tuple[str, ...], message: str) -> None:
    with pytest.raises(DesignError, match=message):
        casing(Reducer(design(name, *changes, "shaft.seal_ring=true")))


@pytest.mark.parametrize(
    ("changes", "message"),
    [(SEALED, "retaining_rings = true is not possible"), (RINGS["pin"], "seal_ring = true is not possible")],
)
def test_rings_and_a_seal_exclude_each_other(changes: tuple[str, ...], message: str) -> None:
    """Retaining rings need ball bearings, a seal ring needs needle bearings: neither request is ignored."""
    both = ("shaft.retaining_rings=true", "shaft.seal_ring=true")
    with pytest.raises(DesignError, match=message):
        casing(Reducer(design("pin", *changes, *both)))


def test_sizes_in_stock_match_the_standards() -> None:
    """DIN 471 for 20 mm: 1.2 mm, groove 19 x 1.3 mm, land 1.5 mm; DIN 472 for 47 mm: 1.75 mm, groove 49.5 x 1.85 mm."""
    shaft, bore = stock.shaft_ring(20e-3), stock.bore_ring(47e-3)
    assert shaft is not None
    assert bore is not None
    assert (shaft.thickness, shaft.groove, shaft.groove_width) == pytest.approx((1.2e-3, 19e-3, 1.3e-3))
    assert shaft.room - shaft.groove_width == pytest.approx(1.5e-3)
    assert (bore.thickness, bore.groove, bore.groove_width) == pytest.approx((1.75e-3, 49.5e-3, 1.85e-3))
    assert (shaft.radii, shaft.eye_radius) == (pytest.approx((9.5e-3, 12.1e-3)), pytest.approx(14e-3))
    assert (bore.radii, bore.eye_radius) == (pytest.approx((20.35e-3, 24.75e-3)), pytest.approx(17.1e-3))
    assert stock.shaft_ring(20.5e-3) is stock.bore_ring(22.4e-3) is stock.seal_ring(10e-3, 16e-3) is None
