"""Stock: what is in the tables is what standards and makers print, and a part is found by its size."""

import numpy as np
import pytest

from cycloid_mj.design import stock


@pytest.mark.parametrize(
    ("designation", "sizes"),
    [("HK0306", (3, 6.5, 6)), ("HK1512", (15, 21, 12)), ("HK6020", (60, 68, 20)), ("RNA4928", (160, 190, 50))],
)
def test_needle_bearings_have_the_sizes_of_their_standard(designation: str, sizes: tuple[float, ...]) -> None:
    found = next(one for one in stock.needle_bearings() if one.designation == designation)
    assert (found.bore, found.outside, found.width) == pytest.approx([1e-3 * size for size in sizes])
    assert found in stock.bearings_outside(found.outside)
    assert found in stock.bearings_on(found.bore, found.width)


def test_a_drawn_cup_is_called_by_its_bore_and_width() -> None:
    cups = [one for one in stock.needle_bearings() if one.designation.startswith("HK")]
    assert len({one.designation for one in cups}) == len(cups)
    for one in cups:
        assert one.designation == f"HK{1e3 * one.bore:02.0f}{1e3 * one.width:02.0f}"
        assert 3.4e-3 < one.outside - one.bore < 8.1e-3


@pytest.mark.parametrize(
    ("designation", "sizes", "ratings"),
    [("608", (8, 22, 7), (3450, 1370)), ("6204", (20, 47, 14), (13500, 6550)), ("61905", (25, 42, 9), (7020, 4300))],
)
def test_ball_bearings_have_their_sizes_and_ratings(
    designation: str, sizes: tuple[float, ...], ratings: tuple[float, ...]
) -> None:
    found = next(one for one in stock.ball_bearings() if one.designation == designation)
    assert (found.bore, found.outside, found.width) == pytest.approx([1e-3 * size for size in sizes])
    assert (found.dynamic, found.static) == ratings


def test_in_a_series_a_larger_ball_bearing_carries_more() -> None:
    for series in ("600", "620", "6190"):
        alike = [one for one in stock.ball_bearings() if one.designation.startswith(series) and one.bore >= 10e-3]
        assert len(alike) >= 4
        ratings = [(one.dynamic, one.static) for one in alike]
        assert ratings == sorted(ratings)


@pytest.mark.parametrize(
    ("diameter", "reach", "designation", "in_line"),
    [
        (3e-3, 17e-3, "ISO 8734 - 3 x 18 - A", 1),
        (3e-3, 1e-3, "ISO 8734 - 3 x 8 - A", 1),
        (1.5e-3, 40e-3, "ISO 8734 - 1.5 x 14 - A", 3),
        (20e-3, 100e-3, "ISO 8734 - 20 x 100 - A", 1),
        (0.72e-3, 20e-3, "DIN 2269 - 0.72 x 40", 1),
    ],
)
def test_the_shortest_dowel_that_reaches_is_found(
    diameter: float, reach: float, designation: str, in_line: int
) -> None:
    found = stock.pins(diameter, reach)
    assert found is not None
    assert found[0].designation == designation
    assert found[1] == in_line
    assert found[0].length * found[1] >= reach


@pytest.mark.parametrize(
    ("diameter", "reach", "filled"),
    [(5e-3, 39e-3, 40e-3), (5e-3, 11e-3, 12e-3), (5e-3, 61e-3, 60e-3), (5e-3, 8e-3, 8e-3), (0.5e-3, 9.3e-3, 9.3e-3)],
)
def test_pins_fill_a_reach_as_they_are_sold(diameter: float, reach: float, filled: float) -> None:
    """Those of 5 mm have 12 to 50 mm; where none is near, and of gauges, they are cut."""
    (found,) = stock.stock_pin_lengths(diameter, np.array([reach]))
    assert found == pytest.approx(filled)
    if filled != reach:
        pin, count = stock.pins(diameter, found) or (None, 0)
        assert pin
        assert pin.length * count == pytest.approx(filled)


def test_a_size_between_those_in_stock_is_none() -> None:
    assert stock.pins(3.2625e-3, 20e-3) is None
    assert stock.bearings_outside(8.2e-3) == ()
    assert stock.bolt_under(2.9e-3) is None


def test_every_pin_in_the_list_can_be_bought() -> None:
    sizes = stock.pin_diameters()
    assert sizes == tuple(sorted(set(sizes)))
    assert all(stock.pins(size, 5e-3) for size in sizes)


def test_bearings_side_by_side_fill_the_width() -> None:
    found = stock.side_by_side(stock.bearings_outside(26e-3), 33e-3)
    assert found is not None
    assert (found[0].designation, found[1]) == ("HK2016", 2)
    assert stock.side_by_side(stock.bearings_outside(26e-3), 9e-3) is None


def test_the_thickest_screw_under_a_head_is_found() -> None:
    found = stock.bolt_under(6e-3)
    assert found is not None
    assert found.designation == "ISO 4762 - M3"


def test_screws_are_no_longer_or_shorter_than_their_thread_is_made() -> None:
    """ISO 4762:2004, table 1: M2.5 to 25 mm, M4 to 40 mm, M8 from 12 mm."""
    assert stock.bolt_length(8e-3, 5e-3) == 12e-3
    assert stock.bolt_length(2.5e-3, 21e-3) == 25e-3
    assert stock.bolt_length(2.5e-3, 26e-3) is None
    assert stock.bolt_lengths(2.5e-3)[-1] == 25e-3
    assert stock.bolt_length(4e-3, 36e-3) == 40e-3


def test_a_ball_bearing_is_found_where_no_needle_bearing_has_the_size() -> None:
    assert [one.designation for one in stock.bearings_on(8e-3, 7e-3)] == ["608"]
    assert [one.designation for one in stock.bearings_outside(30e-3)] == ["6200", "61903"]
    assert [one.designation for one in stock.bearings_outside(72e-3)] == ["RNA4910"]


def test_an_insert_is_chosen_by_its_thread() -> None:
    found = stock.insert_of(3e-3)
    assert found is not None
    assert found.designation == "M3 x 5.7"
    assert stock.insert_of(3.3e-3) is None


def test_inserts_have_a_hole_larger_than_their_thread() -> None:
    assert all(one.hole > one.thread for one in stock.inserts())


def test_catalogued_angular_contact_bearings_have_the_sizes_of_their_series() -> None:
    catalogued = {one.designation.removesuffix(".E"): one for one in stock.catalogued_angular_contact_bearings()}
    assert [*catalogued] == sorted(catalogued)
    same = [one for one in stock.angular_contact_bearings() if one.designation.split()[0] in catalogued]
    assert len(same) == 17
    for estimated in same:
        one = catalogued[estimated.designation.split()[0]]
        assert (one.bore, one.outside, one.width) == (estimated.bore, estimated.outside, estimated.width)
        assert one.contact_angle == estimated.contact_angle
        assert 0.8 < one.dynamic / estimated.dynamic < 1.3, "the estimate by balls and contact angle"
    assert (catalogued["71826"].dynamic, catalogued["71826"].static) == (37000.0, 64500.0)
