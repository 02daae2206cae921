"""`cycloid-mj design`: a new file of one's own, and what a check sums up."""

import json
from pathlib import Path

import pytest
from commands import told
from designs import UNLIKE, design_file

from cycloid_mj.base.result import to_json_values
from cycloid_mj.checks import summarize
from cycloid_mj.design import PRESETS, load, loads, override
from cycloid_mj.figures import FIGURES
from cycloid_mj.life import rate
from cycloid_mj.reducer import Reducer, reducer_of

# `measure backlash` over a turn by its closed form [arcmin], and `measure loads`: the torque of first yield [N m].
MEASURED = {"pin": (0.9678, 28.1), "nonpin": (0.7471, 34.55)}


@pytest.mark.parametrize("name", ["my", "my.toml"])
def test_new_writes_a_commented_file_that_carries_its_own_name(here, name):
    assert told("design", "new", name) == (0, "my.toml\n", "")
    assert load(Path("my.toml")) == override(PRESETS["pin"], {"name": "my"})
    assert "(assumed)" in Path("my.toml").read_text()
    assert [path.name for path in here.iterdir()] == ["my.toml"]


def test_new_starts_from_a_design_with_changes(here):
    assert told("design", "new", "wide", "--from", "nonpin", "--set", "gear.face_width_mm=12")[0] == 0
    assert told("design", "new", "wider", "--from", "wide.toml", "--set", "gear.face_width_mm=15")[0] == 0
    assert load(Path("wider.toml")) == override(PRESETS["nonpin"], {"name": "wider", "gear.face_width_mm": 15.0})


def test_new_leaves_an_existing_file_alone(here):
    Path("my.toml").write_text("mine")
    code, out, err = told("design", "new", "my")
    assert (code, out) == (1, "")
    assert err.startswith("error: my.toml already exists (a design file of ")
    assert err.endswith("): choose another name (--out), or overwrite it with --force\n")
    assert Path("my.toml").read_text() == "mine"


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (("pin",), "is the name of a preset"),
        (("a/b",), "use at most 64 characters"),
        (("",), "use at most 64 characters"),
        (("x" * 65,), "at most 64"),
        (("my", "--from", "pon"), "did you mean pin"),
        (("my", "--set", "ring.teeth=1"), "ring.teeth"),
    ],
)
def test_new_refuses_what_is_no_name_or_no_design(here, argv, words):
    code, out, err = told("design", "new", *argv)
    assert (code, out) == (2, "")
    assert words in err
    assert list(here.iterdir()) == []


def test_check_takes_changes():
    code, out, _ = told("design", "check", "pin", "--set", "ring.pin_radius_mm=2.7")
    assert code == 1
    assert "FAIL  undercut" in out
    code, _, err = told("design", "check", "pin", "--set", "ring.pin_radius=2.7")
    assert code == 2
    assert "ring.pin_radius_mm" in err


@pytest.mark.slow
@pytest.mark.parametrize("name", MEASURED)
def test_summary_agrees_with_the_measures(name):
    play, capacity = MEASURED[name]
    code, out, _ = told("design", "check", name, "--json")
    found = json.loads(out)["summary"]
    assert code == 0
    assert (found["ratio"], found["outer_diameter_mm"], found["rated_torque_nm"]) == (35, 100.0, pytest.approx(36.68))
    assert found["backlash_arcmin"] == pytest.approx(play, rel=5e-3)
    assert found["capacity_nm"] == pytest.approx(capacity, rel=0.02)
    assert 10 < found["loaded_teeth"] < 18
    assert 40 < found["pressure_angle_deg"] < 60
    assert found["weakest"] == PRESETS[name].tooth_pair
    rating = rate(PRESETS[name])
    assert found["weakest_item"] == {"key": rating.weakest.key, **to_json_values(rating.weakest)}
    text = told("design", "check", name)[1]
    assert f"backlash {found['backlash_arcmin']:.3g} arcmin" in text
    assert "ratio 35:1, outer diameter 100 mm, mass 0.8" in text
    assert f"weakest: {rating.weakest.name}: " in text


def test_an_rv_reducer_has_its_summary_as_text_only():
    code, out, _ = told("design", "check", "rv80e", "--json")
    assert code == 0
    assert json.loads(out)["summary"] is None
    assert "ratio 153, 3 cranks on a radius of" in told("design", "check", "rv80e")[1]


@pytest.mark.parametrize("name", ["printed", "twodisc"])
def test_the_summary_has_the_numbers_of_the_catalogue(name):
    """Under the catalogue's keys; the old key `loaded_teeth` is the count of one disc here."""
    found = json.loads(told("design", "check", name, "--json")[1])["summary"]
    reducer = reducer_of(PRESETS[name])
    for key in found.keys() & FIGURES.keys() - {"loaded_teeth"}:
        assert found[key] == pytest.approx(FIGURES[key].value(reducer), rel=1e-12), key
    assert {"backlash_arcmin", "capacity_nm", "loaded_teeth_per_disc"} <= found.keys() & FIGURES.keys()


def test_a_design_with_its_crank_at_rest_is_summarized():
    standing = PRESETS["pin"].but(drive={"speed": 0.0})
    found, turning = summarize(Reducer(standing)), summarize(Reducer(PRESETS["pin"]))
    assert found.backlash == pytest.approx(turning.backlash, rel=1e-6)
    assert found.capacity == pytest.approx(turning.capacity, rel=0.1)


@pytest.mark.parametrize("name", UNLIKE)
def test_every_design_can_be_summed_up(name):
    design = load(design_file(name))
    found = summarize(Reducer(design))
    assert found.ratio == design.ring.teeth - 1
    assert 1 <= found.loaded_teeth < design.ring.teeth
    assert found.capacity > found.rated_torque  # they are sized with room to spare
    steel = design.material.density * 3.14 * design.housing.outer_radius**2 * design.gear.face_width
    assert 0.3 * steel < found.mass < 3.0 * steel


def test_a_strict_check_and_a_checked_rating_fail_where_the_design_does(here):
    """By default only a design that cannot be built fails; `pin` pits within hours at its nominal torque."""
    code, out, _ = told("design", "check", "pin", "--strict")
    assert code == 1
    assert "0 failed" in out
    assert told("design", "check", "pin")[0] == 0
    light = ("--load-nm", "0.5", "--speed-rpm", "100", "--life-h", "10")
    assert [told("rate", "pin", *flags)[0] for flags in (("--check",), (), ("--check", *light))] == [1, 0, 0]


def test_values_inherited_by_a_short_file_are_listed(here):
    Path("short.toml").write_text('name = "short"\n[ring]\nteeth = 20\n')
    code, out, _ = told("design", "check", "short.toml")
    assert code == 0
    assert "values are taken from the preset pin (the default" in out
    assert "output.hole_radius_mm 5" in out
    code, out, err = told("statics", "short.toml", "--all", "--json")
    assert "because short.toml states neither drive.torque_nm nor load.torque_nm" in err
    Path("stated.toml").write_text('name = "short"\n[base]\npreset = "pin"\n[ring]\nteeth = 20\n')
    code, out, err = told("statics", "stated.toml", "--all")
    assert (code, err) == (0, "")
    assert "taken from the preset pin ([base])" in to_json_values(out)


def test_a_short_file_scales_its_preset(here):
    assert told("design", "new", "my", "--from", "printed", "--short", "--set", "gear.face_width_mm=20")[0] == 0
    text = Path("my.toml").read_text()
    assert len(text.splitlines()) < 20
    assert loads(text) == override(PRESETS["printed"].but(name="my"), ["gear.face_width_mm=20"])
    Path("my.toml").write_text(text.replace("pin_circle_radius_mm = 34.0", "pin_circle_radius_mm = 68.0"))
    assert told("design", "check", "my.toml")[0] == 0
    code, _, err = told("design", "new", "your", "--from", "my.toml", "--short")
    assert code == 2
    assert "--short requires a preset" in err


def test_lengths_that_do_not_fit_are_refused_with_the_advice_to_scale_them(here):
    Path("large.toml").write_text("[ring]\npin_circle_radius_mm = 120.0\n")
    code, out, _ = told("design", "check", "large.toml")
    assert code == 1
    assert 'add preset = "pin" and scaled = true to the table [base]' in out
    code, _, err = told("statics", "large.toml")
    assert code == 1
    assert 'add preset = "pin" and scaled = true to the table [base]' in err
    Path("large.toml").write_text('[base]\npreset = "pin"\nscaled = true\n[ring]\npin_circle_radius_mm = 120.0\n')
    assert told("design", "check", "large.toml")[0] == 0
