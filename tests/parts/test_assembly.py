"""A reducer put together: nothing intersects at 36 crank angles, and a CAD kernel reads named, coloured parts."""

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from itertools import combinations
from pathlib import Path

import gmsh
import numpy as np
import pytest
from designs import cases
from matplotlib.path import Path as Loop

from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.names import family
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, Design, dump, override, stock
from cycloid_mj.figures import figure
from cycloid_mj.parts import Prism
from cycloid_mj.parts.curve import Curve
from cycloid_mj.parts.export import (
    Arc,
    Casing,
    LineSegment,
    Motor,
    PlacedPart,
    Spline,
    assembly_order,
    assembly_step,
    bill,
    casing,
    drive,
    place_parts,
)
from cycloid_mj.parts.export.assembly import COLOURS, assembly_sections
from cycloid_mj.parts.export.casing_parts import casing_parts
from cycloid_mj.parts.export.motors import MOTORS
from cycloid_mj.parts.export.printing import STEEL, manufactured_parts, separate_parts
from cycloid_mj.parts.export.round_part import RoundPart
from cycloid_mj.parts.parts import tint
from cycloid_mj.parts.polygon import area_moments, rotate_points
from cycloid_mj.plots.exploded import exploded_groups
from cycloid_mj.reducer import Reducer
from cycloid_mj.sizing.requirement import Requirement
from cycloid_mj.sizing.search import first_drive

SCREWS = ("flange_screw", "motor_screw")
INSERTS = ("screw_insert", "flange_screw_insert", "load_screw_insert", "motor_screw_insert")
ANGLES = 2.0 * np.pi * np.arange(36) / 36.0
BODIES = {
    **dict.fromkeys(("pressed_pin", "motor_cover", "output_cover", "screw", "dowel"), "housing"),
    **dict.fromkeys(("screw_insert", "motor_screw_insert", "motor_screw"), "housing"),
    **dict.fromkeys(("cam", "spacer", "crank_ring", "key"), "shaft"),
    **dict.fromkeys(("output", "output_roller", "output_pin", "output_flange", "flange_screw"), "output"),
    **dict.fromkeys(("flange_screw_insert", "load_screw_insert", "flange_dowel"), "output"),
}
"""Family of a part -> the body that it is fixed to, or turns on without a gap."""


NEW = {
    "new": Requirement(19, 0.06, 4.0),
    "new_of_two": Requirement(19, 0.06, 4.0, discs=2),
    "new_printed": Requirement(15, 0.1, 1.0, process="printed"),
    "new_milled": Requirement(24, 0.09, 4.0, process="milled"),
}


def new_drive(name: str) -> Design:
    reducer = first_drive(NEW[name])
    assert reducer is not None
    return reducer.design


NAMES = ("pin", "nonpin", "twodisc", "printed", "sleeved", *NEW)


@cache
def design_of(name: str) -> Design:
    if name in NEW:
        return new_drive(name)
    return override(PRESETS["pin"], ["ring.pins=sleeved"]) if name == "sleeved" else PRESETS[name]


def points_of(loop: tuple[Curve, ...], sagitta: float) -> np.ndarray:
    """Walk along a closed loop of curves, so that no arc is further from its chords than a sagitta, (n, 2) [m]."""
    found: list[np.ndarray] = []
    for curve in loop:
        if isinstance(curve, Spline):
            points = curve.points(12 if sagitta > 3e-7 else 36)
        elif isinstance(curve, LineSegment):
            points = np.array([curve.start, curve.end])
        else:
            start, end = (curve.start, curve.end) if isinstance(curve, Arc) else (0.0, 2.0 * np.pi)
            count = int(abs(end - start) * np.sqrt(curve.radius / (8.0 * sagitta))) + 2
            angle = np.linspace(start, end, count)
            points = np.array(curve.centre) + curve.radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        if found and np.linalg.norm(points[-1] - found[-1][-1]) < np.linalg.norm(points[0] - found[-1][-1]):
            points = points[::-1]  # all but the first may run backwards
        found.append(points)
    return np.concatenate(found)


def drawn_of(reducer: Reducer, sizes: Casing | None = None) -> dict[str, list[Prism]]:
    """Draw the sections of every part, as finely as the tightest clearance asks for."""
    design = reducer.design
    sagitta = 0.2 * min(getattr(design.clearance, pair) for pair in design.pair_kinds)
    found = {}
    for part, sections in assembly_sections(reducer, sizes).items():
        loops = [[points_of(loop, sagitta) for loop in section.loops] for section in sections]
        found[part] = [Prism(one[0], tuple(one[1:]), at.z0, at.z1) for one, at in zip(loops, sections, strict=True)]
    return found


def placed(place: PlacedPart, prism: Prism) -> Prism:
    """Move a prism to its place."""
    x, y, z = place.origin
    move = np.array([x, y])
    loops = [rotate_points(loop, place.angle) + move for loop in (prism.outline, *prism.holes)]
    return Prism(loops[0], tuple(loops[1:]), prism.z0 + z, prism.z1 + z)


def volume_of(prism: Prism) -> float:
    """Compute the volume of a prism [m3]."""
    areas = [abs(area_moments(loop).area) for loop in (prism.outline, *prism.holes)]
    return (areas[0] - sum(areas[1:])) * (prism.z1 - prism.z0)


def within(points: np.ndarray, prism: Prism) -> np.ndarray:
    """Tell which points (n, 2) lie within the section of a prism: in its outline, and in none of its holes."""
    low, high = prism.outline.min(axis=0), prism.outline.max(axis=0)
    found = ((points > low) & (points < high)).all(axis=1)
    for loop in (prism.outline, *prism.holes):
        if found.any():
            found[found] = Loop(loop).contains_points(points[found]) == (loop is prism.outline)
    return found


def intersect(one: Prism, other: Prism) -> bool:
    """Tell whether a corner of one prism lies within the other."""
    if min(one.z1, other.z1) - max(one.z0, other.z0) < 1e-9:
        return False
    return any(within(np.concatenate([a.outline, *a.holes]), b).any() for a, b in ((one, other), (other, one)))


def collisions(design: Design, angles: np.ndarray, phase: float = 0.0) -> list[str]:
    """Name what intersects at crank angles, gears turned by a phase [rad]."""
    reducer = Reducer(design)
    sizes = casing(reducer)
    drawn = drawn_of(reducer, sizes)
    still = {"pin"} if design.seat_pair else {"pin", "housing"}  # pins that are pressed in fill their sockets
    found = []
    for angle in angles:
        bodies: dict[str, list[Prism]] = {}
        for place in place_parts(reducer, angle, sizes):
            kind = family(place.part)
            if kind in ("shaft_bearing", "output_bearing", "cam_bearing", "bearing_spacer"):
                continue  # they touch what turns and what stands: OpenCASCADE tells
            at = replace(place, angle=place.angle + phase) if kind == "gear" else place
            body = bodies.setdefault(BODIES.get(kind, place.name), [])
            body.extend(placed(at, prism) for prism in drawn[place.part])
        for (one, ones), (other, others) in combinations(bodies.items(), 2):
            if {family(one), family(other)} <= still:
                continue
            if any(intersect(a, b) for a in ones for b in others):
                found.append(f"{one} and {other} at {np.degrees(angle):.0f} deg")
    return found


def test_nothing_intersects_at_three_crank_angles() -> None:
    assert collisions(design_of("new"), ANGLES[1::12]) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["printed", *NEW])
def test_nothing_intersects_at_36_crank_angles(name: str) -> None:
    assert collisions(design_of(name), ANGLES) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pin", "nonpin", "twodisc", "sleeved"])
def test_nothing_of_tight_clearances_intersects(name: str) -> None:
    assert collisions(design_of(name), ANGLES[::12]) == []


def test_a_gear_turned_by_a_quarter_pitch_intersects() -> None:
    design = design_of("new")
    assert collisions(design, ANGLES[:1], phase=0.5 * np.pi / design.lobes)


@contextmanager
def opened(content: bytes, folder: Path) -> Iterator[dict[str, tuple[int, int]]]:
    """Read a STEP file by OpenCASCADE: its solids by their names."""
    file = folder / "read.step"
    file.write_bytes(content)
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Geometry.OCCImportLabels", 1)
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
        solids = gmsh.model.occ.importShapes(str(file))
        gmsh.model.occ.synchronize()
        yield {gmsh.model.getEntityName(*solid): solid for solid in solids}
    finally:
        gmsh.finalize()


def motor_solids(sizes: Casing) -> list[tuple[int, int]]:
    """Draw the motor that is bolted on [mm]: its body before the flange, its pilot of 2 mm, its shaft."""
    cylinders = [(sizes.motor.circle, -10.0, 0.0), (sizes.motor.pilot, 0.0, 2.0)]
    if sizes.motor.shaft:
        cylinders.append((sizes.motor.shaft, 2.0, 1e3 * sizes.motor.shaft_length))
    face = 1e3 * sizes.face
    body, *others = [
        (3, gmsh.model.occ.addCylinder(0.0, 0.0, face + low, 0.0, 0.0, high - low, 1e3 * radius))
        for radius, low, high in cylinders
    ]
    if sizes.motor.tapped:  # M3, 4.5 mm deep
        at = 1e3 * sizes.motor.circle / np.sqrt(2.0) * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
        holes = [(3, gmsh.model.occ.addCylinder(x, y, face - 4.5, 0.0, 0.0, 4.5, 1.5)) for x, y in at]
        (body, *_), _ = gmsh.model.occ.cut([body], holes)
    return [body, *others]


def common_volumes(reducer: Reducer, crank: float, folder: Path, motor: Motor = "auto") -> dict[str, float]:
    """Intersect the solids of a whole drive, and its motor, two by two: what they have in common [mm3], if anything.

    One of each like parts; teeth and pins, which splines make slow, are tried as polygons.
    """
    several = ("pin", "screw", "dowel", "output_pin", "output_roller", "pressed_pin", *SCREWS, *INSERTS)
    sizes, shared = casing(reducer, motor), {}
    with opened(assembly_step(reducer, crank, sizes), folder) as found:
        solids = {label.split("/")[2]: solid for label, solid in found.items()}
        solids = {one: solid for one, solid in solids.items() if family(one) not in several or one.endswith("_1")}
        solids |= {f"motor {number}": solid for number, solid in enumerate(motor_solids(sizes))}
        gmsh.model.occ.synchronize()
        boxes = {one: np.reshape(gmsh.model.occ.getBoundingBox(*solid), (2, 3)) for one, solid in solids.items()}
        for one, other in combinations(solids, 2):
            (low, high), (bottom, top) = boxes[one], boxes[other]
            if {family(one), family(other)} <= {"gear", "pin", "housing"} or (low > top).any() or (bottom > high).any():
                continue
            common, _ = gmsh.model.occ.intersect([solids[one]], [solids[other]], removeObject=False, removeTool=False)
            volume = sum(gmsh.model.occ.getMass(*entity) for entity in common if entity[0] == 3)
            if volume > 1e-3:
                shared[f"{one} and {other}"] = volume
    return shared


@pytest.mark.parametrize("crank", [0.0, pytest.param(2.3, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", cases((*NEW, "printed", "pin", "twodisc"), "new"))
def test_no_two_solids_of_a_drive_and_its_motor_overlap(name: str, crank: float, tmp_path: Path) -> None:
    assert common_volumes(Reducer(design_of(name)), crank, tmp_path) == {}


@pytest.mark.slow
@pytest.mark.parametrize("name", cases(("new_printed", "new_milled"), "new_printed"))
def test_a_motor_with_threads_of_its_own_is_fastened_by_screws_from_within(name: str, tmp_path: Path) -> None:
    """Their heads are in counterbores below the cavity's floor, and reach into the motor by a thread's diameter."""
    reducer = Reducer(design_of(name))
    sizes = casing(reducer, "nema17")
    screws = [place for place in place_parts(reducer, 0.0, sizes) if place.part == "motor_screw"]
    assert len(screws) == 4
    low, head = (min(one.z0 for one in assembly_sections(reducer, sizes)["motor_screw"]), screws[0].origin[2])
    assert sizes.face - (head + low) == pytest.approx(3e-3)
    assert head + 3e-3 <= sizes.floor + 1e-9
    lines = {line.item: line for line in bill(reducer, 0.0, sizes)}
    assert lines["motor_screw"].count == 4
    assert lines["motor_screw"].designation.startswith("ISO 4762 - M3 x ")
    assert "motor_screw_insert" not in lines
    assert "from within" in assembly_order(reducer, sizes)[8]
    assert common_volumes(reducer, 0.0, tmp_path, "nema17") == {}


def test_screws_of_a_motor_pass_the_holes_of_its_flange() -> None:
    """Those of NEMA 23 have 0.195 in: a hole of ISO 273 for its screws is no wider."""
    assert stock.bolt_hole(MOTORS["nema23"].thread) <= 0.195 * 25.4e-3
    assert not MOTORS["nema23"].tapped


@pytest.mark.parametrize("name", ["new", "new_printed", "twodisc"])
def test_a_screws_head_has_play_in_its_counterbore(name: str) -> None:
    reducer = Reducer(design_of(name))
    sizes = casing(reducer)
    parts = casing_parts(reducer, sizes)
    for part, bolt in (("output_cover", sizes.screws.bolt), ("output_flange", sizes.flange_bolt)):
        assert any(0.5 * bolt.head + 1e-4 < radius < 0.7 * bolt.head for _, radius, *_ in parts[part].holes)


@pytest.mark.parametrize("name", NEW)
def test_the_motor_shaft_fits_into_the_crank(name: str) -> None:
    reducer = Reducer(design_of(name))
    sizes = casing(reducer)
    bores = casing_parts(reducer, sizes).get("shaft", RoundPart("shaft")).holes
    assert bool(bores) == bool(sizes.motor.shaft)
    for _, radius, _, end in bores:
        assert radius == sizes.motor.shaft < reducer.design.shaft.radius
        assert end >= sizes.face + max(sizes.motor.shaft_length, 24e-3 if sizes.motor.name == "NEMA 17" else 0.0)


def test_pins_under_rollers_are_as_thick_in_the_assembly_as_on_the_bill_and_the_plate() -> None:
    """One pin is bought, pressed into bores of its size, and carries a roller: whichever format the files have."""
    reducer = Reducer(PRESETS["pin"])
    output, sizes = reducer.design.output, casing(reducer)
    assert output.rollers
    assert not output.has_roller_parts
    sections, placed = assembly_sections(reducer, sizes), Counter(one.part for one in place_parts(reducer, 0.0, sizes))
    (pin,), ((outside,), (bore,)) = sections["output_pin"][0].loops[0], sections["output_roller"][0].loops
    assert (pin.radius, outside.radius) == (output.root_radius, output.pin_radius)
    assert 1e-5 < 2.0 * (bore.radius - pin.radius) < 3e-5  # E8/m6: it turns
    assert placed["output_pin"] == placed["output_roller"] == output.pins
    bores = [loop[0].radius for loop in sections["output"][0].loops[1:]]
    assert bores.count(output.root_radius) == output.pins
    made = manufactured_parts(reducer, 1e-6, 0.0, sizes)["output"].solid.prisms[0]
    sizes_made = [np.ptp(hole[:, 0]) / 2.0 for hole in made.holes]
    assert np.isclose(sizes_made, output.root_radius, rtol=0.0, atol=1e-6).sum() == output.pins
    (line,) = [one for one in bill(reducer, 0.0, sizes) if one.item == "output_pin"]
    assert line.size.startswith(f"diameter {2e3 * output.root_radius:g} ")


def test_a_motor_without_room_is_refused() -> None:
    with pytest.raises(DesignError, match="the motor flange NEMA 34 does not fit"):
        casing(Reducer(design_of("new")), "nema34")
    assert casing(Reducer(design_of("printed")), "nema17").motor.name == "NEMA 17"


@pytest.mark.parametrize("name", cases(NAMES, "new"))
def test_all_bought_parts_of_a_drive_are_in_stock_and_it_has_ten_steps(name: str) -> None:
    reducer = Reducer(design_of(name))
    sizes = casing(reducer)
    lines = {line.item: line for line in bill(reducer, 0.0, sizes) if line.made_or_bought == "bought"}
    assert {"output_bearing", "screw", "flange_screw"} <= set(lines)
    if name.startswith("new"):
        assert all(line.designation for line in lines.values())
    counts = Counter(place.part for place in place_parts(reducer, 0.0, sizes))
    assert all(lines[item].count == counts[item] for item in ("output_bearing", "screw", "flange_screw"))
    assert len(assembly_order(reducer, sizes)) == 10


@pytest.mark.slow
@pytest.mark.parametrize("name", cases(NAMES, "new_of_two"))
def test_a_cad_kernel_reads_named_coloured_solids_in_their_places(name: str, tmp_path: Path) -> None:
    reducer, crank = Reducer(design_of(name)), 0.7
    expected = {place.name: place for place in place_parts(reducer, crank)}
    drawn = drawn_of(reducer)
    with opened(assembly_step(reducer, crank), tmp_path) as found:
        assert {label.split("/")[2] for label in found} == set(expected)
        volume = 0.0
        for label, solid in found.items():
            _, drive, at, part = label.split("/")
            place = expected[at]
            assert (drive, part) == (reducer.design.name, place.part)
            assert gmsh.model.getColor(*solid)[:3] == pytest.approx(
                [255.0 * value for value in tint(COLOURS[family(part)], part)[:3]], abs=1.0
            )
            volume += 1e-9 * gmsh.model.occ.getMass(*solid)
            low, high = np.reshape(gmsh.model.occ.getBoundingBox(*solid), (2, 3)) * 1e-3
            prisms = [placed(place, prism) for prism in drawn[part]]
            reach = np.concatenate([prism.outline for prism in prisms])
            np.testing.assert_allclose(low[:2], reach.min(axis=0), atol=1e-4)  # OpenCASCADE's box is loose on splines
            np.testing.assert_allclose(high[:2], reach.max(axis=0), atol=1e-4)
            assert low[2] == pytest.approx(min(prism.z0 for prism in prisms), abs=1e-6)
            assert high[2] == pytest.approx(max(prism.z1 for prism in prisms), abs=1e-6)
    counts = Counter(place.part for place in expected.values())
    whole = sum(count * sum(map(volume_of, drawn[part])) for part, count in counts.items())
    assert volume == pytest.approx(whole, rel=2e-3)


@pytest.mark.parametrize("name", cases((*NEW, "pin", "twodisc", "printed"), "new"))
def test_a_drives_mass_is_that_of_its_solids(name: str) -> None:
    """Each part as it is drawn for CAD, of its density; two thirds of a bearing's ring are steel."""
    reducer = Reducer(design_of(name))
    sizes = casing(reducer)
    laid, counts = (
        separate_parts(reducer, 0.0, sizes),
        Counter(place.part for place in place_parts(reducer, 0.0, sizes)),
    )
    mass = 0.0
    for part, drawn in drawn_of(reducer, sizes).items():
        share = drive.BEARING_FILL if part.endswith("_bearing") else 1.0
        density = laid[part].density if part in laid else STEEL
        mass += counts[part] * share * density * sum(map(volume_of, drawn))
    assert figure("drive_mass_kg").value(reducer) == pytest.approx(mass, rel=3e-3)


@pytest.mark.parametrize("discs", [2, 3])
def test_the_exploded_view_has_each_spacer_between_its_cams(discs: int) -> None:
    reducer = Reducer(PRESETS["twodisc"].but(gear={"discs": discs}))
    placed = place_parts(reducer, 0.0, casing(reducer))
    groups = exploded_groups(placed)
    order = [group[0].name for group in groups if family(group[0].part) in ("cam", "spacer")]
    assert order == ["cam_1", "spacer_1", "cam_2", "spacer_2", "cam_3"][: 2 * discs - 1]
    assert sum(map(len, groups)) == len(placed)


def test_the_command_writes_the_assembly(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_text(dump(design_of("new")))
    assert main(["export", "--design", "mine.toml", "--assembly", "--out", "made"]) == 0
    assert str(Path("made") / "assembly.step") in capsys.readouterr().out
    reducer = Reducer(design_of("new"))
    with opened(Path("made/assembly.step").read_bytes(), tmp_path) as found:
        assert len(found) == len(place_parts(reducer, 0.0, casing(reducer)))
    assert len(Path("made/assembly.txt").read_text().splitlines()) == 10
    assert Path("made/exploded.png").read_bytes().startswith(b"\x89PNG")
