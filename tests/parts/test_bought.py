"""What a drive buys: each size in its bill of materials is one of the standard that its designation names."""

import math
import random
import re
from collections import Counter
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from designs import cases

from cycloid_mj.design import PRESETS, stock
from cycloid_mj.design.processes import Process
from cycloid_mj.parts.cam_bearing import cam_bearing, cam_radius
from cycloid_mj.parts.contour import circle_of
from cycloid_mj.parts.export import BillLine, assembly_order, bill, casing, place_parts
from cycloid_mj.parts.export.assembly import assembly_parts
from cycloid_mj.parts.export.bearings import output_pin, roller_bearing
from cycloid_mj.parts.export.drive import assembly_mass
from cycloid_mj.parts.export.rules import describe_violations
from cycloid_mj.reducer import Reducer
from cycloid_mj.sizing.candidates import DIMENSIONS, build_drive, decode
from cycloid_mj.sizing.requirement import Requirement
from cycloid_mj.sizing.search import first_drive

THREE = {
    "steel": Requirement(20, 0.06, 10.0),
    "printed": Requirement(15, 0.075, 1.0, process="printed"),
    "milled": Requirement(35, 0.12, 20.0, process="milled", discs=2),
}


@cache
def drawn_drives(count: int) -> tuple[Reducer, ...]:
    """Draw a number of drives at random, the same ones each time."""
    found: list[Reducer] = []
    draw = random.Random(34)
    while len(found) < count:
        asked = Requirement(
            ratio=draw.randint(5, 119),
            diameter=round(draw.uniform(0.03, 0.3), 4),
            torque=1.0,
            process=draw.choice(("steel", "printed", "milled")),
            discs=draw.choice((1, 1, 2, 3)),
        )
        _, sizes = decode(asked, np.array([[draw.random() for _ in range(DIMENSIONS)]]))
        if len(sizes) and (reducer := build_drive(asked, sizes[0], asked.torque)):
            found.append(reducer)
    return tuple(found)


def measures(line: BillLine) -> dict[str, float]:
    """Read the sizes of a line, as "outside diameter 22 x bore 16 x length 12 mm", in mm."""
    read = {
        what: float(value) for what, value in re.findall(r"([a-z][a-z ]*) ([\d.]+)", line.size.replace(" x ", "; "))
    }
    assert read, line
    return read


def sizes_in_stock(designation: str) -> dict[str, float]:
    """Look up the sizes of a designation in the tables of stock, in mm."""
    balls = (*stock.ball_bearings(), *stock.thin_ball_bearings(), *stock.angular_contact_bearings())
    for one in (*stock.needle_bearings(), *balls, *stock.tapered_bearings(), *stock.crossed_roller_bearings()):
        if one.designation == designation.removesuffix("-2RS1"):
            return {"outside diameter": 1e3 * one.outside, "bore": 1e3 * one.bore, "length": 1e3 * one.width}
    for insert in stock.inserts():
        if insert.designation == designation:
            return {"hole": 1e3 * insert.hole, "length": 1e3 * insert.length}
    if gauge := re.fullmatch(r"DIN 2269 - ([\d.]+) x ([\d.]+)", designation):
        diameter, length = map(float, gauge.groups())
        bent = stock.single_pin(1e-3 * diameter, 1e-3 * length)
        free = stock.free_pin(1e-3 * diameter, 1e-3 * length, 1e-4)
        assert designation in {pin.designation for pin in (bent, free) if pin}
        return {"diameter": diameter, "length": length}
    if roller := re.fullmatch(r"ISO 3096 - ([\d.]+) x ([\d.]+) - G2", designation):
        diameter, length = map(float, roller.groups())
        in_stock = stock.free_pin(1e-3 * diameter, 1e-3 * length + 0.4e-3, 1e-4)
        assert in_stock
        assert in_stock.designation == designation
        return {"diameter": diameter, "length": length}
    if dowel := re.fullmatch(r"ISO 8734 - ([\d.]+) x ([\d.]+) - A", designation):
        diameter, length = map(float, dowel.groups())
        assert 1e-3 * diameter in [pytest.approx(size) for size in stock.pin_diameters()]
        in_stock = stock.pins(1e-3 * diameter, 1e-3 * length)
        assert in_stock
        assert in_stock[0].designation == designation
        return {"diameter": diameter, "length": length}
    if tube := re.fullmatch(r"EN 10305-1 - ([\d.]+) x ([\d.]+)", designation):
        outside, wall = map(float, tube.groups())
        assert 1e-3 * outside in [pytest.approx(size) for size in stock.tube_outsides()]
        assert wall < 0.5 * outside
        return {"outside diameter": outside}
    if washer := re.fullmatch(r"ISO 7089 - ([\d.]+)", designation):
        one = stock.washer_of(1e-3 * float(washer[1]))
        return {"outside diameter": 1e3 * one.outside, "bore": 1e3 * one.bore, "length": 1e3 * one.thickness}
    if key := re.fullmatch(r"DIN 6885 - B ([\d.]+) x ([\d.]+) x ([\d.]+)", designation):
        width, height, length = map(float, key.groups())
        return {"width": width, "height": height, "length": length}
    if screw := re.fullmatch(r"(ISO 4762 - M([\d.]+)) x ([\d.]+)", designation):
        bolt = next(one for one in stock.bolts() if one.designation == screw[1])
        length = stock.bolt_length(bolt.thread, 1e-3 * float(screw[3]))
        return {"thread": 1e3 * bolt.thread, "length": 1e3 * (length or 0.0)}
    bar = re.fullmatch(r"ground bar ([\d.]+) h6", designation)
    assert bar, f"{designation!r} is in no table"
    assert 1e-3 * float(bar[1]) in [pytest.approx(size) for size in stock.bar_diameters()]
    return {"diameter": float(bar[1])}


@pytest.mark.slow
@pytest.mark.parametrize("name", THREE)
def test_every_size_in_the_bill_of_a_new_drive_is_in_the_tables_of_stock(name: str) -> None:
    reducer = first_drive(THREE[name])
    assert reducer
    require_sizes_in_stock(reducer)


@pytest.mark.parametrize("number", cases(range(10), 0))
def test_every_size_in_the_bill_is_in_the_tables_of_stock(number: int) -> None:
    require_sizes_in_stock(drawn_drives(10 if number else 1)[number])


def require_sizes_in_stock(reducer: Reducer) -> None:
    """Fail unless each bought part of a drive has the sizes that stock has under its designation."""
    lines = [line for line in bill(reducer, 0.0, casing(reducer)) if line.made_or_bought == "bought"]
    assert {"output_bearing", "screw", "flange_screw", "shaft_bearing", "cam_bearing", "pin"} <= {
        line.item for line in lines
    }
    for line in lines:
        if line.item == "output_pin" and not line.designation:  # no pin in stock is as long: ordered to measure
            diameter, length = (1e-3 * value for value in measures(line).values())
            assert stock.single_pin(diameter, length) is None
            continue
        looked_up = sizes_in_stock(line.designation)
        for what, value in measures(line).items():
            if what in looked_up:  # a bar is cut to length
                assert value == pytest.approx(looked_up[what], rel=1e-4), line
        own = {"length", "bored", "depth"} | ({"bore"} if line.item == "output_roller" else set())  # tubes are bored
        assert measures(line).keys() - looked_up.keys() <= own, line
        assert line.fit or "ISO 4762" in line.designation or "insert" in line.item or "bar" in line.designation, line
        assert line.count > 0


@pytest.mark.parametrize("process", ["steel", "milled", "printed"])
def test_cams_of_new_drives_fill_their_bearings(process: Process) -> None:
    """A cam of 11.8 mm has 0.2 mm of play in an HK1210; its fit F8/h5 has 0.05 mm at most."""
    asked = Requirement(20, 0.1, 1.0, process=process)
    _, sizes = decode(asked, np.random.default_rng(3).random((40, DIMENSIONS)))
    drive = next(drive for size in sizes if (drive := build_drive(asked, size, 1.0)) and cam_bearing(drive))
    bearing, _ = cam_bearing(drive) or (None, 0)
    assert bearing
    assert 0.0 <= bearing.bore - 2.0 * cam_radius(drive) <= 10.1e-6
    loose = drive.but(clearance={"cam": 100e-6})
    (violation,) = (item for item in describe_violations(loose, casing(loose)) if "loose" in item)
    assert f"loose in {bearing.designation}, which needs {1e3 * bearing.bore:g} mm" in violation
    tight = drive.but(clearance={"cam": 1e-6 * float(violation.rpartition(" ")[2])})
    assert not [item for item in describe_violations(tight, casing(tight)) if "loose" in item]


def test_free_pins_are_rollers_and_cut_if_too_long() -> None:
    """A dowel, m6, jams in a socket: it is 4 to 12 um thicker than its nominal size of 5 mm."""
    design = PRESETS["pin"].but(ring={"pin_radius": 2.5e-3}, gear={"face_width": 19e-3})
    line = next(line for line in bill(Reducer(design)) if line.item == "pin")
    expected = ("ISO 3096 - 5 x 19.8 - G2", "0/-2 um, free in its socket, cut to 19 mm")
    assert (line.designation, line.fit) == expected
    short = next(line for line in bill(Reducer(design.but(gear={"face_width": 20e-3}))) if line.item == "pin")
    assert (short.size, short.fit) == ("diameter 5 x length 19.8 mm", "0/-2 um, free in its socket")
    fixed = next(line for line in bill(Reducer(design.but(ring={"pins": "fixed"}))) if line.item == "pin")
    assert fixed.designation.startswith("ISO 3096")
    assert fixed.fit.startswith("0/-2 um, glued")


@pytest.mark.parametrize(
    ("pins", "size", "middle"), [("free", 5.0, -0.5e-6), ("fixed", 5.0, -0.5e-6), ("free", 4.08, 0)]
)
def test_ring_pins_are_drawn_at_the_middle_of_their_tolerance_zone(pins: str, size: float, middle: float) -> None:
    """Needle rollers are 0/-2 um on the diameter (ISO 3096, first group of G2); pin gauges +-1 um."""
    design = PRESETS["pin"].but(ring={"pins": pins, "pin_radius": 0.5e-3 * size})
    (outline,) = (item.outline for item in assembly_parts(Reducer(design), casing(Reducer(design)))["pin"].segments)
    circle = circle_of(outline)
    assert circle
    assert circle.radius - 0.5e-3 * size == pytest.approx(middle, abs=1e-10)


def test_pins_on_which_a_disc_slides_are_not_dowels() -> None:
    """A dowel of 12 mm is 7 to 18 um too thick (m6) for a clearance of 2 um; the core of a roller may be a dowel."""
    sliding = next(line for line in bill(Reducer(PRESETS["twodisc"])) if line.item == "output_pin")
    assert (sliding.designation, sliding.fit) == ("DIN 2269 - 12.00 x 70", "js5 in R7, cut to 52 mm")
    core = next(line for line in bill(Reducer(PRESETS["pin"])) if line.item == "output_pin")
    assert core.designation.startswith("ISO 8734")
    odd = {"pin_radius": 6.0025e-3, "hole_radius": 6.0025e-3 + PRESETS["twodisc"].gear.eccentricity}
    assert output_pin(Reducer(PRESETS["twodisc"].but(output=odd))) is None, "no gauge of 12.005 mm"


@pytest.mark.parametrize("size", [0.72, 2.0, 4.08, 5.0, 8.0])
@pytest.mark.parametrize("width", [4.2, 10.2, 30.2, 130.2])
def test_free_pins_fill_the_ring_with_axial_play(size: float, width: float) -> None:
    roller = stock.free_pin(1e-3 * size, 1e-3 * width, 1e-4)
    assert roller is not None
    slack = width - 1e3 * roller.count * roller.used_length
    assert 0.2 - 1e-9 <= slack <= 0.5 * roller.count + 1e-9
    assert roller.used_length <= roller.length


@pytest.mark.parametrize("width", [20e-3, 60e-3])
def test_each_bought_pin_of_a_wide_drive_is_listed_and_drawn_once(width: float) -> None:
    """The longest roller of 5 mm has 49.8 mm: a ring pin of 60 mm is two in line; an output pin bends: one gauge."""
    design = PRESETS["pin"].but(ring={"pins": "fixed", "pin_radius": 2.5e-3}, gear={"face_width": width})
    reducer = Reducer(design)
    sizes = casing(reducer)
    lines = {line.item: line for line in bill(reducer, 0.0, sizes)}
    placed = [place for place in place_parts(reducer, 0.0, sizes) if place.part in ("pin", "output_pin")]
    counts = Counter(place.part for place in placed)
    assert {item: lines[item].count for item in counts} == counts
    assert counts["output_pin"] == design.output.pins
    assert lines["output_pin"].fit.startswith("m6 in N7" if width < 50e-3 else "js5 in R7, cut to ")
    drawn = assembly_parts(reducer, sizes)["pin"].segments[0]
    heights = {place.origin[2] for place in placed if place.part == "pin"}
    ends = sorted((round(height + drawn.z0, 9), round(height + drawn.z1, 9)) for height in heights)
    in_line = counts["pin"] // design.ring.teeth
    assert in_line == -(-width // 50e-3)
    assert len(ends) == in_line
    assert ends[0][0] == -ends[-1][1]
    assert width - 2.0 * ends[-1][1] < 0.5e-3, "a needle roller is shorter by its axial play"
    assert all(low[1] == high[0] for low, high in pairwise(ends))


def candidate(requirement: Requirement, has_needles: bool) -> Reducer:
    """Return the first drive of a fixed random sequence with needle bearings in the rollers of its pins, or without."""
    draw = np.random.default_rng(3)
    _, sizes = decode(requirement, draw.random((400, DIMENSIONS)))
    rows = (row for row in sizes if (row.needle_dynamic > 0.0) == has_needles)
    return next(reducer for row in rows if (reducer := build_drive(requirement, row, requirement.torque)))


def test_tubes_have_an_allowance_to_be_bored() -> None:
    tube = stock.tube_for(8e-3, 5e-3)
    assert tube
    assert tube.designation == "EN 10305-1 - 8 x 2"
    assert 5e-3 - tube.bore >= stock.BORING_ALLOWANCE
    assert stock.tube_for(8.2e-3, 5e-3) is None, "no such outside diameter"
    assert stock.tube_for(10e-3, 3e-3) is None, "its wall is too thin for the bore"


@pytest.mark.parametrize(("has_needles", "deviation"), [(False, 50.0), (True, 40.0)])
def test_sleeves_of_a_printed_drive_are_cut_from_tube(has_needles: bool, deviation: float) -> None:
    """The tolerance of their clearance adds that of the tube in radius to the 10 um of the printer."""
    reducer = candidate(Requirement(15, 0.12, 3.0, process="printed"), has_needles)
    output = reducer.design.output
    assert any(math.isclose(2.0 * output.pin_radius, size) for size in stock.tube_outsides())
    line = next(line for line in bill(reducer, 0.0, casing(reducer)) if line.item == "output_roller")
    assert line.designation.startswith(f"EN 10305-1 - {2e3 * output.pin_radius:g} x ")
    assert "bored" in line.fit
    assert "cut to" in line.fit
    assert line.material == "steel E235+C"
    clearance = 1e6 * reducer.design.clearance.output
    assert reducer.design.tolerance.output == f"normal {math.hypot(0.1 * clearance, deviation / math.sqrt(3.0)):.3g}"


def test_needle_bearings_of_rollers_are_listed_and_drawn() -> None:
    """Each roller has a bore for its drawn cup, whose needles run on the pin; the bill has as many as are placed."""
    reducer = candidate(Requirement(35, 0.12, 20.0, process="milled", discs=2), has_needles=True)
    sizes = casing(reducer)
    bearing, count = roller_bearing(reducer)
    output = reducer.design.output
    assert bearing.bore == pytest.approx(2.0 * output.core_radius)
    assert count ** (7.0 / 9.0) * bearing.dynamic == pytest.approx(reducer.design.bearing.output_dynamic_capacity)
    lines = {line.item: line for line in bill(reducer, 0.0, sizes)}
    assert lines["roller_bearing"].designation == bearing.designation
    assert lines["roller_bearing"].count == count * output.pins * reducer.design.gear.discs
    placed = Counter(place.part for place in place_parts(reducer, 0.0, sizes))
    assert {item: lines[item].count for item in ("output_roller", "roller_bearing")} == {
        item: placed[item] for item in ("output_roller", "roller_bearing")
    }
    (roller,) = assembly_parts(reducer, sizes)["output_roller"].segments
    assert circle_of(roller.holes[0]).radius == pytest.approx(0.5 * bearing.outside)
    assert lines["output_roller"].made_or_bought == "made"
    assert list(describe_violations(reducer, sizes)) == []
    assert sum(line.mass_kg for line in lines.values()) == pytest.approx(assembly_mass(reducer, sizes), rel=5e-3)
    assert "roller_bearing" in assembly_order(reducer, sizes)[2]


def test_outside_diameters_of_tubes_deviate_as_in_din_2391() -> None:
    """DIN 2391-1:1981, table 2: 0.10 mm up to 10 mm, then 0.08 mm, and 0.15 mm above 28 mm."""
    deviations = {round(1e3 * size): round(1e3 * stock.tube_tolerance(size), 3) for size in stock.tube_outsides()}
    assert {size: deviations[size] for size in (4, 10, 12, 28, 30)} == {4: 0.1, 10: 0.1, 12: 0.08, 28: 0.08, 30: 0.15}
