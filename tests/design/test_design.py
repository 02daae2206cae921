"""The design file: units, the exact round trip, what is assumed, and every error in the words of the file."""

import math
import tomllib

import numpy as np
import pytest
from pydantic import ValidationError

from cycloid_mj.base.errors import DesignError, UsageError
from cycloid_mj.design import (
    PARTS,
    PRESETS,
    Design,
    Gear,
    Measured,
    Ring,
    Tolerance,
    dump,
    load,
    loads,
    override,
    resolve,
)
from cycloid_mj.design.layouts import applies
from cycloid_mj.design.units import DEGREE, RPM, UNITS, file_key, unit_of

# What the paper gives and what it leaves open (Hsieh 2014, section 3.1 and Table 1).
FROM_PAPER = {
    "": {"structure", "layout"},
    "ring": {"kind", "teeth", "pin_circle_radius_mm", "pin_radius_mm", "pins"},
    "gear": {"eccentricity_mm", "discs"},
    "output": {"member"},
    "clearance": {"pin_gear_um", "pin_socket_um", "tooth_um", "cam_um", "output_um"},
    "material": {"youngs_modulus_mpa", "tensile_strength_mpa", "yield_strength_mpa"},
    "drive": {"power_kw", "torque_nm", "speed_rpm"},
    "environment": {"gravity_x_m_s2", "gravity_y_m_s2"},
}
FROM_ELSEWHERE = {
    "friction": {"cam_rolling", "output_rolling"},
    "material": {"poisson", "density_kg_m3", "expansion_um_m_k", "surface_yield_mpa", "endurance_pressure_mpa"},
}
PAIRS = ("pin_gear", "pin_socket", "pin_sleeve", "tooth", "cam", "output")
ASSUMED_HERE = {
    "ring": {"socket", "sleeve_thickness_mm", "halves", "preload_arcmin", "preload_torque_nm"},
    "gear": {"disc_gap_mm", "face_width_mm", "bore_radius_mm", "bearing"},
    "clearance": {"pin_sleeve_um"},
    "output": {"rollers", "pins", "pin_radius_mm", "pin_circle_radius_mm", "hole_radius_mm", "disc_thickness_mm"}
    | {"roller_bearing", "core_radius_mm", "fillet_radius_mm", "support", "main_bearings"}
    | {"main_bearing_seat"},
    "shaft": {
        "radius_mm",
        "bore_radius_mm",
        "cam_joint",
        "retaining_rings",
        "seal_ring",
        "length_mm",
        "counterweight_radius_mm",
        "mounting",
        "fillet_radius_mm",
    }
    | {"bearing_width_mm", "bearing_offset_mm", "bearing_spacing_mm"},
    "housing": {"outer_radius_mm", "support", "bolts", "bolt_circle_radius_mm", "bolt_radius_mm"},
    "errors": {
        *("seed", "pin_position_um", "pin_radius_um", "hole_position_um", "eccentricity_um"),
        *("pin_x_um", "pin_y_um", "pin_dr_um", "hole_x_um", "hole_y_um"),
        *("disc_size_um", "disc_dr_um", "cam_position_um", "cam_x_um", "cam_y_um"),
        *("profile_cos_um", "profile_sin_um"),
    },
    "modification": {"equidistant_um", "pin_circle_um", "rotation_arcsec"},
    "friction": {*PAIRS, "law", "lubricant", "roughness_um", "boundary", "film_formula"},
    "drag": {"crank_nm", "output_nm"},
    "stiffness": {f"{pair}_n_m" for pair in PAIRS},
    "springs": {
        "carrier_nm_arcmin",
        "shaft_nm_arcmin",
        "housing_nm_arcmin",
        "friction_nm",
        "friction_travel_deg",
        "hysteresis_nm",
        "hysteresis_travel_deg",
    },
    "damping": set(PAIRS),
    "working_force": {f"{pair}_n" for pair in PAIRS},
    "contact": {
        *("law", "impact_stiffness_n_mm", "impact_exponent", "impact_damping_n_s_mm", "impact_depth_mm"),
        "stiffness_law",
        "stiffness_n_m",
        "working_force_n",
        "working_load_nm",
        "cam_rollers",
        "damping_ratio",
        "creep_speed_mm_s",
        "max_penetration_um",
    },
    "bearing": {"dynamic_capacity_n", "static_capacity_n", "shaft_dynamic_capacity_n", "output_dynamic_capacity_n"}
    | {"shaft_static_capacity_n", "output_static_capacity_n", "reliability", "service_factor"}
    | {"viscosity_mm2_s", "cleanliness"},
    "service": {
        "life_h",
        "surface",
        "endurance_limit_mpa",
        "notch_factor",
        "wear_coefficient_mm3_nm",
        "ambient_temperature_c",
        "duty_share",
    }
    | {"film_coefficient_w_m2_k", "grease_temperature_c", "seal_temperature_c", "run_in_depth_um"},
    "thermal": {"face_gap_mm", "joint_conductance_w_m2_k", "emissivity"},
    "drive": {"ramp_s", "hold_s", "rotor_inertia_kg_m2"},
    "load": {"torque_nm", "rise_s"},
    "settings": {"timestep_us", "log_rate_hz", "scene_rate_hz"},
}
# File value and its SI value, as decimals: each carries one rounding and the conversion adds one.
IN_SI = [
    ("ring.pin_circle_radius_mm", 40.75, 0.04075),
    ("ring.pin_radius_mm", 2.2, 0.0022),
    ("gear.eccentricity_mm", 1.1, 0.0011),
    ("clearance.pin_gear_um", 0.7, 0.7e-6),
    ("material.youngs_modulus_mpa", 210000.0, 210e9),
    ("material.yield_strength_mpa", 620.4, 620.4e6),
    ("drive.power_kw", 0.18, 180.0),
    ("drive.torque_nm", 1.048, 1.048),
    ("settings.timestep_us", 3.3, 3.3e-6),
    ("settings.log_rate_hz", 12345.6, 12345.6),
    ("environment.gravity_y_m_s2", -9.81, -9.81),
    ("drive.rotor_inertia_kg_m2", 2e-5, 2e-5),
    ("contact.working_force_n", 77.0, 77.0),
]


def value_at(design: Design, key: str) -> object:
    """Look a key of the file up in the design: its name there lacks the unit."""
    table, name = key.split(".")
    section = getattr(design, table)
    names = [field for field in type(section).model_fields if name == field or name.startswith(field + "_")]
    return getattr(section, max(names, key=len))


def lines_noted(text: str, note: str) -> dict[str, set[str]]:
    """Keys by table of the lines whose comment ends with a note."""
    found: dict[str, set[str]] = {}
    table = ""
    for line in text.splitlines():
        if line.startswith("["):
            table = line.strip("[]")
        elif " = " in line and line.endswith(f"({note})"):
            found.setdefault(table, set()).add(line.split(" = ")[0])
    return found


def random_changes(rng: np.random.Generator) -> list[str]:
    """Values of 1 to 17 digits for every number of the file, within 20 % of the preset's."""
    changes = []
    for table, keys in tomllib.loads(dump(PRESETS["pin"])).items():
        for key, value in keys.items() if isinstance(keys, dict) else ():
            if isinstance(value, float) and key not in ("reliability", "emissivity", "duty_share"):  # 1 at most
                digits = rng.integers(1, 18)
                changes.append(f"{table}.{key}={float(f'{value * rng.uniform(0.8, 1.2):.{digits}g}')!r}")
    return [*changes, f"ring.teeth={rng.integers(4, 401)}", f"output.pins={rng.integers(2, 101)}", 'name="a b-1"']


@pytest.mark.parametrize(("key", "in_file", "in_si"), IN_SI)
def test_values_become_si(key: str, in_file: float, in_si: float) -> None:
    converted = value_at(override(PRESETS["pin"], [f"{key}={in_file!r}"]), key)
    assert converted == pytest.approx(in_si, rel=2.0**-52, abs=0.0)


def test_the_lengths_of_the_paper_are_the_nearest_floats() -> None:
    ring, gear = PRESETS["pin"].ring, PRESETS["pin"].gear
    assert (ring.pin_circle_radius, ring.pin_radius, gear.eccentricity) == (0.04075, 0.00225, 0.001)


def test_speeds_become_radians_per_second() -> None:
    # 1640 rpm = 9840 deg/s = 164 pi / 3 rad/s; two roundings of the factor and one of the quotient.
    for speed in (PRESETS["pin"].drive.speed, RPM.to_si(1640.0), DEGREE.to_si(9840.0)):
        assert speed == pytest.approx(171.74039839624, rel=1e-13)
        assert speed == pytest.approx(164.0 * math.pi / 3.0, rel=4e-16)


def test_every_unit_restores_the_numbers_of_a_file() -> None:
    rng = np.random.default_rng(1)
    numbers = [float(f"{x:.{d}g}") for d in (1, 3, 9, 15, 17) for x in 10.0 ** rng.uniform(-9, 9, 200)]
    for unit in UNITS.values():
        for number in numbers:
            assert unit.to_si(unit.from_si(unit.to_si(number))) == unit.to_si(number)
        # Up to 14 digits the very number comes back, so that a file keeps the words of its author.
        short = [float(f"{number:.14g}") for number in numbers]
        assert [unit.from_si(unit.to_si(number)) for number in short] == short


@pytest.mark.parametrize("name", PRESETS)
def test_presets_survive_the_round_trip(name: str) -> None:
    text = dump(PRESETS[name])
    assert loads(text) == PRESETS[name]
    assert dump(loads(text)) == text
    assert resolve(name) is PRESETS[name]


@pytest.mark.parametrize("seed", range(20))
def test_changed_values_survive_the_round_trip_exactly(seed: int) -> None:
    changes = random_changes(np.random.default_rng(seed))
    design = override(PRESETS["pin"], changes)
    assert loads(dump(design)) == design
    assert dump(loads(dump(design))) == dump(design)
    # The control: the same design with one value off by its last bit is another one.
    shifted = math.nextafter(design.gear.eccentricity, 1.0)
    assert design.model_copy(update={"gear": design.gear.model_copy(update={"eccentricity": shifted})}) != design


@pytest.mark.slow
def test_any_si_value_survives_but_for_its_last_bit() -> None:
    # An SI float may fall between two floats of the file (spacing at most 2^-52 of the value).
    for eccentricity in np.random.default_rng(2).uniform(5e-4, 2e-3, 300).tolist():
        design = loads(dump(Design(gear=Gear(eccentricity=eccentricity))))
        assert design.gear.eccentricity == pytest.approx(eccentricity, rel=2.0**-52, abs=0.0)
        assert loads(dump(design)) == design


def test_a_changed_value_leaves_the_others_untouched_to_the_last_bit() -> None:
    design = override(PRESETS["pin"], ["drive.speed_rpm=1234.5678901234567", "ring.pin_radius_mm=2.1234567890123457"])
    again = override(design, ["load.torque_nm=36"])
    assert again == design.model_copy(update={"load": design.load.model_copy(update={"torque": 36.0})})
    assert override(design, []) is design


def test_the_file_has_every_key_and_marks_assumed_values() -> None:
    text = dump(PRESETS["pin"])
    tables = {name: set(keys) for name, keys in tomllib.loads(text).items() if isinstance(keys, dict)}
    assert lines_noted(text, "assumed") == ASSUMED_HERE
    assert lines_noted(text, "Hsieh 2014") == FROM_PAPER
    assert lines_noted(text, "SKF, JTEKT catalogues") == {"friction": FROM_ELSEWHERE["friction"]}
    assert lines_noted(text, "SolidWorks Alloy Steel") == {"material": FROM_ELSEWHERE["material"]}
    kinds = (FROM_PAPER, ASSUMED_HERE, FROM_ELSEWHERE)
    kinds = (
        *kinds,
        {"tolerance": set(Tolerance.model_fields)},
        {"measured": {file_key(name, field) for name, field in Measured.model_fields.items()}},
        {"material": {"name"}},
        {"thermal": lines_noted(text, "ISO 1")["thermal"] | lines_noted(text, "mineral oil greases")["thermal"]},
    )  # of an entry of the library, which says where each is from
    told = set().union(*kinds) - {""}
    assert tables == {t: set().union(*(kind.get(t, set()) for kind in kinds)) for t in told}
    # Nothing of the model is missing in the file but parts that are made of what all are.
    other_layout = {"planet", "cranks", "crank_errors", "crank_tolerance"}
    absent = {f"{part}_material" for part in PARTS} | other_layout
    assert set(Design.model_fields) - absent == {"name", "structure", "layout", *tables}
    for table, keys in tables.items():
        fields = type(getattr(PRESETS["pin"], table)).model_fields
        assert sum(applies("central", table, name) for name in fields) == len(keys)


def test_a_key_states_its_unit() -> None:
    # Numbers without a unit in their key are counts, ratios and friction coefficients, and nothing else.
    bare = {"teeth", "pins", "bolts", "seed", "cam_rollers", "damping_ratio", "poisson", "reliability"}
    bare |= {
        "service_factor",
        "notch_factor",
        "discs",
        "impact_exponent",
        "halves",
        "emissivity",
        "duty_share",
        "cleanliness",
    }
    for table, field in Design.model_fields.items():
        for name, inner in getattr(field.annotation, "model_fields", {}).items():
            if inner.annotation in (int, float) and table not in ("friction", "damping"):
                assert (unit_of(inner).suffix == "") == (name in bare), f"{table}.{name}"


def test_a_changed_value_is_no_longer_called_assumed_or_the_papers() -> None:
    text = dump(override(PRESETS["pin"], ["gear.face_width_mm=12", "gear.eccentricity_mm=0.9"]))
    assert "face_width_mm = 12.0  # face width of each disc; pins and ring span all of them\n" in text
    assert lines_noted(text, "assumed")["gear"] == {"disc_gap_mm", "bore_radius_mm", "bearing"}
    assert lines_noted(text, "Hsieh 2014")["gear"] == {"discs"}


def test_keys_left_out_keep_the_preset_pin() -> None:
    design = loads("[ring]\nkind = 'nonpin'\n[gear]\neccentricity_mm = 1\n")
    assert design == Design(ring=Ring(kind="nonpin"))


def test_a_design_is_a_frozen_value() -> None:
    with pytest.raises(ValidationError, match="frozen"):
        PRESETS["pin"].gear.eccentricity = 2e-3  # type: ignore[misc]
    assert hash(PRESETS["pin"]) == hash(Design())


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("[gear]\neccentricty_mm = 1", r"unknown key gear\.eccentricty_mm; did you mean gear\.eccentricity_mm\?"),
        ("[gear]\neccentricity = 1", r"did you mean gear\.eccentricity_mm\?"),
        ("[gear]\neccentricity_um = 1", r"did you mean gear\.eccentricity_mm\?"),
        ("[gaer]\neccentricity_mm = 1", r"unknown key gaer; did you mean gear\?"),
        ("eccentricity_mm = 1", r"unknown key eccentricity_mm; did you mean gear\.eccentricity_mm\?"),
        ("[gear]\npin_radius_mm = 1", r"did you mean ring\.pin_radius_mm or output\.pin_radius_mm\?"),
        ("[load]\nspeed_rpm = 1", r"unknown key load\.speed_rpm; did you mean drive\.speed_rpm\?"),
        ("[environment]\nqqqq = 1", r"available keys: environment\.gravity_x_m_s2, environment\.gravity_y_m_s2$"),
        ("zzzz = 1", r"available keys: name, structure, layout, ring, gear, "),
    ],
)
def test_an_unknown_key_is_reported_with_the_right_one(text: str, hint: str) -> None:
    with pytest.raises(DesignError, match=hint):
        loads(text)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            "ring.pin_radius_mm=-2.25",
            r"ring\.pin_radius_mm = -2\.25 is not allowed: it must be from 0\.001 to 1000 \(pin radius rho\)",
        ),
        ("ring.pin_radius_mm=0", "from 0.001 to 1000"),
        ("ring.pin_radius_mm=1e-300", "from 0.001 to 1000"),
        ("gear.bore_radius_mm=1e308", "from 0.001 to 5000"),
        ("shaft.radius_mm=6000", r"shaft\.radius_mm = 6000\.0 is not allowed: it must be from 0\.001 to 5000"),
        ("clearance.cam_um=0", r"clearance\.cam_um = 0\.0 is not allowed: it must be greater than 0 and at most 1000"),
        ("clearance.cam_um=1001", "at most 1000"),
        ("drive.speed_rpm=1e5", "less than 100000"),
        ("drive.speed_rpm=nan", r"drive\.speed_rpm = nan is not allowed: it must be a finite number"),
        ("drive.torque_nm=inf", "finite number"),
        ("gear.eccentricity_mm=-inf", "finite number"),
        ("material.youngs_modulus_mpa=1e308", "inf is not allowed"),
        ("material.poisson=0.5", "less than 0.5"),
        ("ring.teeth=3", r"ring\.teeth = 3 is not allowed: it must be from 4 to 400"),
        ("ring.teeth=401", "from 4 to 400"),
        ("ring.teeth=36.0", r"ring\.teeth = 36\.0 is not allowed: it must be a whole number"),
        ("ring.teeth=true", "true is not allowed: it must be a whole number"),
        (f"ring.teeth={10**30}", "inf is not allowed"),
        (f"ring.pin_radius_mm={10**400}", "inf is not allowed"),
        (f"ring.pin_radius_mm=-{10**400}", "-inf is not allowed"),
        (f"ring.teeth={'9' * 5000}", "a whole number"),
        ("ring.kind=pins", '"pins" is not allowed: it must be "pin" or "nonpin"; did you mean "pin"'),
        ("ring.kind=1", '"pin" or "nonpin"'),
        ("gear.eccentricity_mm=true", "true is not allowed: it must be a number"),
        ("gear.eccentricity_mm=one", '"one" is not allowed: it must be a number'),
        ("gear.eccentricity_mm=", '"" is not allowed: it must be a number'),
        ("gear.eccentricity_mm=[1.0]", "it must be a number"),
        ("gear.eccentricity_mm={mm=1.0}", "it must be a number"),
        ("gear.eccentricity_mm=2020-01-01", "it must be a number"),
        ("gear=3", r"gear is a table, but is given as a value: write \[gear\]"),
        ("name=../pin", '"../pin" is not allowed'),
        ('name=""', '"" is not allowed'),
        ('name="a\\nb"', "not allowed"),
        ("name=3", "it must be text in quotes"),
        (f"name={'a' * 65}", "at most 64 characters"),
    ],
)
def test_a_wrong_value_is_reported_in_the_words_of_the_file(change: str, told: str) -> None:
    with pytest.raises(DesignError, match=told) as error:
        override(PRESETS["pin"], [change])
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 400


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[gear]\nlobes = 34\n", "tooth difference of 2 or more are not supported"),
        ("[ring]\nteeth_difference = 2\n", "tooth difference of 2 or more are not supported"),
        ("[stages]\nfirst = 3\n", 'set layout = "rv"'),
        ("[shaft]\ncranks = 3\n", 'set layout = "rv"'),
        ("[gear]\npins = 12\n", "hypocycloid drives, with the pins on the disc, are not supported"),
    ],
)
def test_a_layout_that_does_not_exist_is_reported_where_it_is_requested(text: str, told: str) -> None:
    with pytest.raises(DesignError, match=told) as error:
        loads(text)
    assert "\n" not in str(error.value)
    table, line = text.splitlines()
    with pytest.raises(DesignError, match=told):
        override(PRESETS["pin"], [f"{table.strip('[]')}.{line.partition(' ')[0]}=3"])


def test_all_wrong_values_are_reported_together() -> None:
    with pytest.raises(DesignError, match=r"ring\.teeth = 2 .*; .*gear\.face_width_mm = -1\.0 "):
        loads("[ring]\nteeth = 2\n[gear]\nface_width_mm = -1.0")


@pytest.mark.parametrize(
    "change", ["load.torque_nm", "load.torque_nm:36", "=36", "load.=36", ".torque_nm=36", "a.b.c=1", "", "name.x=1"]
)
def test_a_change_that_is_not_an_assignment_shows_the_syntax(change: str) -> None:
    with pytest.raises(UsageError, match=r"give table\.key=value, e\.g\. |name is a value and not a table"):
        override(PRESETS["pin"], [change])


def test_a_change_names_the_nearest_key() -> None:
    with pytest.raises(DesignError, match=r"--set: unknown key load\.torque; did you mean load\.torque_nm\?"):
        override(PRESETS["pin"], ["load.torque=36"])
    with pytest.raises(DesignError, match=r"unknown key laod; did you mean load\?"):
        override(PRESETS["pin"], ["laod.torque_nm=36"])


def test_changes_take_words_with_and_without_quotes_and_the_last_one_counts() -> None:
    for word in ("nonpin", '"nonpin"', " 'nonpin' "):
        assert override(PRESETS["pin"], [f"ring.kind={word}"]).ring.kind == "nonpin"
    assert override(PRESETS["pin"], ["ring.teeth=30", " ring.teeth = 40 "]).ring.teeth == 40


@pytest.mark.parametrize(
    "content",
    [
        b"\x00\x01\x02\xff\xfe",
        "[gear]\neccentricity_mm = 1".encode("utf-16"),
        b"eccentricity 1",
        b"[gear",
        b"[gear]\n[gear]",
        b"x = " + b"[" * 100_000,
        b"x = " + b"9" * 5000,
    ],
)
def test_a_file_that_is_not_toml_is_reported(tmp_path, content: bytes) -> None:
    path = tmp_path / "bad.toml"
    path.write_bytes(content)
    with pytest.raises(
        DesignError, match=r"bad\.toml.*(is not valid TOML|is nested too deeply|Choose a readable TOML file)"
    ) as error:
        load(path)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("content", ["", "\n\n", "# nothing but a comment\n"])
def test_an_empty_file_shows_where_to_start(tmp_path, content: str) -> None:
    path = tmp_path / "empty.toml"
    path.write_text(content)
    with pytest.raises(DesignError, match=r"empty\.toml is empty: write the values .* `cycloid-mj design new my`"):
        load(path)


def test_a_missing_file_names_the_nearest(tmp_path) -> None:
    (tmp_path / "krol_variant_1.toml").write_text(dump(PRESETS["pin"]))
    assert resolve(str(tmp_path / "krol_variant_1.toml")) == PRESETS["pin"]
    with pytest.raises(UsageError, match=r"did you mean .*krol_variant_1\.toml\?"):
        resolve(str(tmp_path / "krol_varaint_1.toml"))
    with pytest.raises(
        UsageError, match=r"neither a preset \(pin, nonpin, printed.*\) nor a file; did you mean nonpin\?"
    ):
        resolve("nopin")
    with pytest.raises(UsageError, match="writes a design file to start from"):
        resolve("0123456789")


@pytest.mark.parametrize("name", ["", ".", "x" * 5000, "a\0b", "../" * 500 + "x/"])
def test_a_path_that_cannot_be_read_is_an_error(name: str) -> None:
    with pytest.raises((DesignError, UsageError)):
        resolve(name)


def test_a_file_of_an_editor_with_a_byte_order_mark_is_read(tmp_path) -> None:
    path = tmp_path / "bom.toml"
    path.write_text(dump(PRESETS["nonpin"]), encoding="utf-8-sig")
    assert load(path) == PRESETS["nonpin"]
