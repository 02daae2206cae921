"""What a drawing tells of seats in printed plates: beams on soft foundations against closed forms, and their file."""

import math
from pathlib import Path

import numpy as np
import pytest

from cycloid_mj.base.errors import DesignError, UsageError
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP, shear_coefficient, shear_modulus
from cycloid_mj.stress import mounts
from cycloid_mj.stress.mounts import StudSeats, crank_compliance, read_mounts, solve_stud_beam, with_modulus

DRAWN = Path(__file__).parents[1] / "data" / "bench" / "mounts.toml"
PRINTED = Reducer(PRESETS["printed"])
STUDS = StudSeats(near_seat=0.0094, far_seat=0.0083, far_plate_free=True)


def test_the_seats_of_the_measured_drive_are_read_off_its_file() -> None:
    told = read_mounts(DRAWN)
    assert told.studs == STUDS
    assert told.crank is not None
    assert told.crank.to_hub + told.crank.to_housing == pytest.approx(0.0492)
    assert told.material.modulus == (490e6, 3600e6)


def test_a_pin_in_deep_seats_matches_hetenyis_half_infinite_beams() -> None:
    """Hetenyi 1946, Beams on Elastic Foundation: the end of a long beam gives 2 b/k, 2 b^2/k and 4 b^3/k."""
    thin = PRINTED.but(
        housing_material={"youngs_modulus": 1e8}, output_material={"youngs_modulus": 2e12}, output={"core_radius": 5e-4}
    )
    design = thin.design
    material, radius, foundation = design.material_of("output"), design.output.root_radius, 1e8
    bending = material.youngs_modulus * math.pi * radius**4 / 4.0
    sheared = shear_coefficient(material) * shear_modulus(material) * math.pi * radius**2
    depth = (foundation / (4.0 * bending)) ** 0.25
    seat = np.array([[2.0 * depth, 2.0 * depth**2], [2.0 * depth**2, 4.0 * depth**3]]) / foundation
    length = design.gear.face_width + 2.0 * AXIAL_GAP
    carried = np.array([[1.0, 0.0], [length, 1.0]])
    turned = length**2 / (2.0 * bending)
    beam = np.array([[length**3 / (3.0 * bending) + length / sheared, turned], [turned, length / bending]])
    facing = np.diag([1.0, -1.0])  # the far seat lies on the other side of its end
    whole = carried.T @ seat @ carried + beam + facing @ seat @ facing
    _, share, across = solve_stud_beam(thin, StudSeats(near_seat=0.06, far_seat=0.06))
    assert across == pytest.approx(np.linalg.inv(whole)[0, 0], rel=0.02)
    assert share == pytest.approx(0.5, rel=2e-3)


def test_a_hard_pin_tilts_and_shifts_in_its_seats() -> None:
    """A rigid bar on two foundations: its stiffness matrix by the moments of both seats about the disc's middle."""
    hard = PRINTED.but(output_material={"youngs_modulus": 2e12}, housing_material={"youngs_modulus": 1e8})
    give, share, across = solve_stud_beam(hard, STUDS)
    foundation, half = hard.design.material_of("housing").youngs_modulus, hard.design.gear.face_width / 2 + AXIAL_GAP
    ends = {-1: (-half - STUDS.far_seat, -half), 1: (half, half + STUDS.near_seat)}
    moments = {
        side: foundation
        * np.array([[(b ** (i + j + 1) - a ** (i + j + 1)) / (i + j + 1) for j in (0, 1)] for i in (0, 1)])
        for side, (a, b) in ends.items()
    }
    both = moments[-1] + moments[1]
    moved = np.linalg.solve(both, [1.0, 0.0])
    assert give == pytest.approx(moved[0], rel=2e-2)
    assert share == pytest.approx(moments[-1][0] @ moved, rel=2e-2)
    pushed = np.linalg.solve(both, moments[-1][0])
    assert across == pytest.approx(moments[-1][0, 0] - moments[-1][0] @ pushed, rel=2e-2)


def test_doubling_the_elements_changes_pin_compliance_by_less_than_a_thousandth(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    coarse = solve_stud_beam(PRINTED, STUDS)
    monkeypatch.setattr(mounts, "SLICES", 2 * mounts.SLICES)
    assert solve_stud_beam(PRINTED, STUDS) == pytest.approx(coarse, rel=1e-3)


def test_the_compliance_of_a_crank_is_that_of_seats_and_post() -> None:
    told = read_mounts(DRAWN).crank
    assert told is not None
    modulus, total = PRINTED.design.material_of("housing").youngs_modulus, told.to_hub + told.to_housing
    hub, housing = told.to_housing / total, told.to_hub / total
    thick = crank_compliance(PRINTED, told.model_copy(update={"post_diameter": 1e3}))
    seats = 2 * hub**2 / told.hub_seat + 2 * housing**2 / told.housing_seat + 1 / told.cam_seat
    assert thick == pytest.approx(seats / modulus, rel=1e-6)
    places = told.to_housing - told.cam_seat / 2 - told.post * (np.arange(1000) + 0.5) / 1000
    bending = modulus * math.pi * told.post_diameter**4 / 64
    material = PRINTED.design.material_of("housing")
    sheared = told.post / (shear_coefficient(material) * shear_modulus(material) * math.pi * told.post_diameter**2 / 4)
    post = told.post * np.mean((housing * places) ** 2) / bending + housing**2 * sheared
    assert crank_compliance(PRINTED, told) - thick == pytest.approx(post, rel=1e-4)
    assert crank_compliance(with_modulus(PRINTED, 2.0 * modulus), told) == pytest.approx(
        crank_compliance(PRINTED, told) / 2
    )


def test_another_modulus_applies_to_all_printed_parts_but_not_to_steel() -> None:
    other = with_modulus(PRINTED, 1e9).design
    assert {part: other.material_of(part).youngs_modulus == 1e9 for part in ("gear", "housing", "output", "shaft")} == {
        "gear": True,
        "housing": True,
        "output": False,
        "shaft": False,
    }


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[stud]\n", "unknown key stud; did you mean studs?"),
        ("studs = 3\n", "studs is a table, but is given as a value: write [studs], and its keys on the lines below"),
        ("[studs]\nnear_seat_mm = 9\n", "studs.far_seat_mm is missing (length of a pin in the second plate"),
        ("[studs]\nnear_seat_mm = 9\nfar_seat_mm = 8\nlength_mm = 3\n", "unknown key studs.length_mm"),
        (
            "[studs]\nnear_seat_mm = 9\nfar_seat_mm = -8\n",
            "far_seat_mm = -8.0 is not allowed: it must be greater than 0",
        ),
        ("[studs]\nnear_seat_mm = 9\nfar_seat_mm = 8\nfar_plate_free = 1\n", "studs.far_plate_free = 1 is not allowed"),
        ("[material]\nmodulus_mpa = 1400\n", "material.modulus_mpa = 1400 is not allowed"),
        ("[material]\nmodulus_mpa = [1400]\n", "material.modulus_mpa[2] is missing"),
        (
            "[material]\nmodulus_mpa = [-1, 700]\n",
            "modulus_mpa[1] = -1.0 is not allowed: it must be greater than 0",
        ),
        ("[material]\nmodulus_mpa = [1400, 700]\n", "the smallest, then the largest"),
        ("[studs\n", "is not valid TOML"),
    ],
)
def test_a_wrong_file_of_mounts_is_reported(tmp_path: Path, text: str, told: str) -> None:
    path = tmp_path / "mounts.toml"
    path.write_text(text)
    with pytest.raises(DesignError, match=r"mounts\.toml") as caught:
        read_mounts(path)
    assert told in str(caught.value)


def test_a_missing_file_of_mounts_is_reported(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"the mounts file .*none\.toml does not exist"):
        read_mounts(tmp_path / "none.toml")


def test_mounts_are_for_springs(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stress", "--design", "printed", "--mounts", str(DRAWN)]) == 2
    assert "--mounts applies only with --springs: add --springs" in capsys.readouterr().err
