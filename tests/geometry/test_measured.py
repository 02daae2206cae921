"""Measured parts: files, alignment, and what they change in statics and in the models of both solvers."""

from pathlib import Path

import numpy as np
import pytest
from designs import cases

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import PRESETS, Design, dump, loads, override, resolve
from cycloid_mj.dynamics.contact.teeth import USER_DATA
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.figures import figure
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.deviations import deviations, profile_error
from cycloid_mj.geometry.measured import measured_profile, measurement_notes
from cycloid_mj.geometry.modification import gear_profile, profile_offset
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.balance import loads as static_loads
from cycloid_mj.statics.samples import backlash, identical_samples, solve_samples
from cycloid_mj.statics.springs import springs_of

T = np.linspace(0.0, 2.0 * np.pi, 2000, endpoint=False)


def write(path: Path, header: str, *columns: Array) -> Path:
    rows = [",".join(map(repr, map(float, row))) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([header, *rows]), encoding="utf-8")
    return path


def with_wave(path: Path, preset: str, order: int, amplitude_um: float) -> Design:
    """A design whose measured profile stands out by a cosine over the parameter of its trochoid."""
    design = PRESETS[preset]
    x, y = profile.outline(gear_profile(design), T, profile_offset(design)).T
    angle, deviation = np.degrees(np.arctan2(x, y)), amplitude_um * np.cos(order * T)
    return override(design, {"measured.gear": str(write(path, "angle_deg,deviation_um", angle, deviation))})


@pytest.mark.parametrize("preset", ["pin", "printed"])
def test_a_measured_gear_one_micrometre_smaller_adds_one_micrometre_of_clearance(preset: str, tmp_path: Path) -> None:
    angle = np.arange(360.0)
    path = write(tmp_path / "cmm.csv", "angle_deg,deviation_um", angle, np.full(360, -1.0))
    measured = override(PRESETS[preset], {"measured.gear": str(path)})
    wider = PRESETS[preset].but(clearance={"pin_gear": PRESETS[preset].clearance.pin_gear + 1e-6})
    value = figure("backlash_arcmin").value
    assert value(Reducer(measured)) == pytest.approx(value(Reducer(wider)), rel=1e-6)
    assert value(Reducer(measured)) > 1.001 * value(Reducer(PRESETS[preset]))


@pytest.mark.parametrize(
    ("preset", "order"), cases((("pin", 3), ("pin", 35), ("twodisc", 29), ("printed", 26)), ("pin", 3), ("twodisc", 29))
)
def test_a_known_wave_is_recovered(preset: str, order: int, tmp_path: Path) -> None:
    design = with_wave(tmp_path / "cmm.csv", preset, order, 2.0)
    waves = deviations(design).waves
    expected = np.zeros_like(waves)
    expected[order - 1, 0] = -2e-6
    np.testing.assert_allclose(waves, expected, atol=1e-10)


def test_transmission_error_of_a_wave_follows_from_the_reciprocal_theorem(tmp_path: Path) -> None:
    """A gap that is wider by w turns the output by w dF/dT, of the contact's force over the torque (Maxwell).

    That holds while the same teeth carry.
    """
    torque, step, crank = 10.0, 0.01, 0.04 + np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    perfect = PRESETS["pin"].but(ring={"pins": "fixed"})
    wavy = with_wave(tmp_path / "cmm.csv", "pin", 4, 0.01).but(ring={"pins": "fixed"})
    springs = springs_of(Reducer(perfect), crank, friction=False)
    less, same, more = (
        static_loads(Reducer(perfect), springs, torque + change, warm_start=True) for change in (-step, 0.0, step)
    )
    real = static_loads(Reducer(wavy), springs_of(Reducer(wavy), crank, friction=False), torque, warm_start=True)
    rate = (more.teeth - less.teeth) / (2.0 * step)
    foot = springs.contacts.phase[:, : rate.shape[1]] / perfect.lobes
    expected = np.sum(rate * profile_error(deviations(wavy).waves, foot), axis=1)
    carrying = [state.teeth > 0.0 for state in (less, same, more, real)]
    alike = np.all([np.all(mask == carrying[1], axis=1) for mask in carrying], axis=0)
    assert alike.sum() > 25
    assert np.ptp(expected) > 5e-8
    np.testing.assert_allclose(
        (real.output_turn - same.output_turn)[alike], expected[alike], atol=0.02 * np.ptp(expected)
    )


def test_points_are_aligned_and_the_alignment_is_reported(tmp_path: Path) -> None:
    design = PRESETS["printed"]
    gear, offset = gear_profile(design), profile_offset(design)
    outward = 1e-6 * (3.0 * np.cos(3.0 * T) - 1.0)
    points = profile.outline(gear, T, offset) + outward[:, np.newaxis] * profile.normals(gear, T)
    angle = np.radians(1.5)  # clockwise
    x, y = np.cos(angle) * points[:, 0] + np.sin(angle) * points[:, 1], np.cos(angle) * points[:, 1]
    y -= np.sin(angle) * points[:, 0]
    path = write(tmp_path / "scan.txt", "x_mm,y_mm", 1e3 * x + 0.4, 1e3 * y - 0.7)
    measured = override(design, {"measured.gear": str(path)})
    found = measured_profile(measured)
    assert found is not None
    assert found.alignment is not None
    assert (found.alignment.x, found.alignment.y) == pytest.approx((4e-4, -7e-4), abs=1e-8)
    assert found.alignment.rotation == pytest.approx(angle, abs=1e-7)
    assert found.mean == pytest.approx(-1e-6, abs=2e-8)
    assert found.waves[2] == pytest.approx([-3e-6, 0.0], abs=3e-8)
    (note,) = measurement_notes(measured)
    assert "2000 points" in note
    assert "aligned by 400 um, -700 um and 5400 arcsec" in note


def test_pins_are_displaced_outwards_and_clockwise(tmp_path: Path) -> None:
    path = tmp_path / "pins.csv"
    rows = [f"{pin},{pin == 1},0,0" for pin in range(36, 0, -1)]
    rows[26] = "10,2,3,0.5"  # on +x, a quarter of 36 pins from +y
    path.write_text(
        "\n".join(["pin,radial_um,tangential_um,radius_um", *rows]).replace("True", "1").replace("False", "0")
    )
    made = deviations(override(PRESETS["pin"], {"measured.pins": str(path)}))
    assert made.pin_displacement[0] == pytest.approx([0.0, 1e-6])
    assert made.pin_displacement[9] == pytest.approx([2e-6, -3e-6])
    assert made.pin_radius[9] == pytest.approx(0.5e-6)
    assert np.count_nonzero(np.linalg.norm(made.pin_displacement, axis=1) > 1e-12) == 2


def test_paths_are_relative_to_the_design_file_and_a_log_needs_none(tmp_path: Path) -> None:
    folder = tmp_path / "drive"
    folder.mkdir()
    write(folder / "cmm.csv", "angle_deg,deviation_um", np.arange(0.0, 360.0, 5.0), np.full(72, 0.5))
    (folder / "my.toml").write_text('name = "my"\n[measured]\ngear = "cmm.csv"\n')
    design = resolve(folder / "my.toml")
    assert deviations(design).disc_radius == pytest.approx([0.5e-6])
    text = dump(design)
    (folder / "cmm.csv").unlink()
    assert loads(text) == design
    with pytest.raises(DesignError, match="relative to the design file"):
        resolve(folder / "my.toml")
    assert override(design, {"measured.gear": ""}).measured.is_empty


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "has no measurements"),
        (
            "angle,deviation\n1,2\n",
            "line 1: the header 'angle,deviation' is not valid. Change it to angle_deg,deviation_um or x_mm,y_mm",
        ),
        ("# scan\nangle_deg,deviation_um\n1,2\n3,x\n", "line 4: '3,x' is not valid. Write 2 numbers"),
        ("angle_deg,deviation_um\n1,2\n3,4,5\n", "line 3"),
        ("angle_deg,deviation_um\n1,0.002e6\n", "line 2: deviation_um is 2000, but must be from -1000 to 1000"),
        ("angle_deg,deviation_um\n1,nan\n", "line 2"),
        pytest.param(
            "angle_deg,deviation_um\n" + 10_001 * "1,2\n",
            "has 10,001 rows: at most 10,000 are allowed. Remove some rows",
            id="too many rows",
        ),
    ],
)
def test_a_bad_profile_is_refused_with_its_line(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(DesignError, match=message):
        override(PRESETS["pin"], {"measured.gear": str(path)})


@pytest.mark.parametrize(
    ("pins", "message"), [(range(1, 36), "has 35 pins, but ring.teeth is 36"), ([1, 2, 2, 4], "pin 3 is missing")]
)
def test_bad_pins_are_refused(pins: list[int], message: str, tmp_path: Path) -> None:
    path = tmp_path / "pins.csv"
    path.write_text("\n".join(["pin,radial_um,tangential_um,radius_um", *(f"{pin},0,0,0" for pin in pins)]))
    with pytest.raises(DesignError, match=message):
        override(PRESETS["pin"], {"measured.pins": str(path)})


@pytest.mark.parametrize("separator", [";", "\t", " "])
def test_exports_with_other_separators_are_read(separator: str, tmp_path: Path) -> None:
    """Without a header, with z, and with decimal commas next to semicolons and tabs."""
    design = PRESETS["printed"]
    points = 1e3 * profile.outline(gear_profile(design), T[::4], profile_offset(design))
    text = "\n".join(separator.join(f"{value:.6f}" for value in (x, y, 0.0)) for x, y in points)
    path = tmp_path / "scan.asc"
    path.write_text(text if separator == " " else text.replace(".", ","))
    found = measured_profile(override(design, {"measured.gear": str(path)}))
    assert found is not None
    assert found.points == 500
    assert abs(found.mean) < 1e-9


def test_samples_and_the_model_have_the_measured_parts(tmp_path: Path) -> None:
    design = with_wave(tmp_path / "cmm.csv", "pin", 40, 1.0).but(ring={"pins": "massless"})
    assert len(deviations(design).waves) == 40  # more than the errors can list
    reducer = Reducer(design)
    sides = solve_samples(reducer, identical_samples(reducer, 2), [0.01, -0.01], 90)
    alone = [
        static_loads(reducer, springs_of(reducer, np.linspace(0.0, 2.0 * np.pi, 90, endpoint=False), False), torque)
        for torque in (0.01, -0.01)
    ]
    expected = np.mean(alone[0].output_turn - alone[1].output_turn)
    np.testing.assert_allclose(backlash(*sides), expected, rtol=1e-6)
    numbers = build(design).model.geom("teeth").user[USER_DATA:].reshape(-1, 2)
    np.testing.assert_allclose(numbers, deviations(design).waves, atol=1e-18)
