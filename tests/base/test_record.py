import copy
import pickle

import numpy as np
import pytest

from cycloid_mj.base.errors import LogError
from cycloid_mj.base.record import Run

UNITS = {"gear_angle": "rad", "gear_speed": "rad/s", "pin_force": "N"}


def make_run(samples: int = 7, **changes) -> Run:
    rng = np.random.default_rng(5)
    fields = {
        "time": np.arange(samples) * 0.25,
        "columns": {name: rng.normal(size=samples) for name in UNITS},
        "units": UNITS,
        "provenance": {"seed": "5"},
        "attachments": {"design.toml": b"lobes = 35"},
        "complete": False,
        "note": "stopped",
    }
    return Run(**(fields | changes))


def assert_same(left: Run, right: Run) -> None:
    np.testing.assert_array_equal(left.time, right.time)
    assert list(left.columns) == list(right.columns)
    for name in left.columns:
        np.testing.assert_array_equal(left[name], right[name])
    for name in ("units", "provenance", "attachments", "complete", "note"):
        assert getattr(left, name) == getattr(right, name), name


def test_a_run_contains_its_values_in_order():
    angle = np.array([0.5, np.nan, -0.0])
    run = Run(np.arange(3.0), {"z": angle, "a": [1, 2, 3]}, {"a": "1", "z": "rad"})
    assert list(run.columns) == ["z", "a"]
    assert run["z"].tobytes() == angle.tobytes()
    assert run["a"].dtype == np.float64
    assert len(run) == 3
    assert (run.complete, run.note) == (True, "")


def test_cannot_be_changed_by_anyone():
    time, angle, units = np.arange(3.0), np.ones(3), {"angle": "rad"}
    run = Run(time, {"angle": angle}, units)
    time[0], angle[0], units["angle"] = -9.0, 9.0, "deg"
    assert (run.time[0], run["angle"][0], run.units["angle"]) == (0.0, 1.0, "rad")
    for array in (run.time, run["angle"]):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    with pytest.raises(TypeError):
        run.units["angle"] = "deg"
    with pytest.raises(AttributeError):
        run.note = "x"


def test_locked_arrays_are_shared_and_locked_views_are_not():
    owner = np.ones(3)
    view = owner[:]
    view.flags.writeable = False
    assert not np.shares_memory(Run(np.arange(3.0), {"a": view}, {"a": "1"})["a"], owner)
    owner.flags.writeable = False
    assert Run(np.arange(3.0), {"a": owner}, {"a": "1"})["a"] is owner


def test_block_puts_columns_side_by_side():
    run = make_run()
    block = run.block(["pin_force", "gear_angle"])
    assert block.shape == (7, 2)
    np.testing.assert_array_equal(block[:, 0], run["pin_force"])
    np.testing.assert_array_equal(block[:, 1], run["gear_angle"])
    assert run.block([]).shape == (7, 0)


def test_unknown_column_lists_the_nearest():
    with pytest.raises(LogError, match=r"no column 'gear_angel'; columns with similar names: gear_angle"):
        make_run()["gear_angel"]
    with pytest.raises(LogError, match="its columns are gear_angle, gear_speed, pin_force"):
        make_run().block(["zzz"])
    with pytest.raises(LogError, match="no columns"):
        Run(np.arange(2.0), {}, {})["a"]


@pytest.mark.parametrize("rows", [slice(2, 5), slice(None, None, 3), slice(0, 0)])
def test_select_by_slice_and_by_the_same_mask(rows):
    run = make_run()
    mask = np.zeros(7, dtype=bool)
    mask[rows] = True
    by_slice = run.select(rows)
    assert_same(by_slice, run.select(mask))
    np.testing.assert_array_equal(by_slice.time, run.time[rows])
    np.testing.assert_array_equal(by_slice["pin_force"], run["pin_force"][rows])
    assert by_slice.note == "stopped"


def test_select_refuses_invalid_choices_of_samples():
    run = make_run()
    with pytest.raises(LogError, match=r"mask of type bool and shape \(7,\)"):
        run.select(np.ones(6, dtype=bool))
    with pytest.raises(LogError, match="array of type int64"):
        run.select(np.array([0, 1]))
    with pytest.raises(LogError, match="increasing"):
        run.select(slice(None, None, -1))


def test_a_topic_has_only_its_own_columns():
    run = make_run(topics={"/reducer": ("gear_speed", "gear_angle"), "/forces": ("pin_force",)})
    assert list(run.of_topic("/reducer").columns) == ["gear_speed", "gear_angle"]
    assert run.of_topic("/forces")["pin_force"] is run["pin_force"]
    with pytest.raises(LogError, match="choose one of /reducer, /forces"):
        run.of_topic("/pins")
    with pytest.raises(LogError, match="has no columns, and no topic '/pins': simulate the design again"):
        Run(np.arange(3.0), {}, {}).of_topic("/pins")


@pytest.mark.parametrize("travel", [copy.deepcopy, lambda run: pickle.loads(pickle.dumps(run))])
def test_travels_to_other_processes(travel):
    run = make_run()
    there = travel(run)
    assert_same(run, there)
    assert not there.time.flags.writeable


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"time": np.arange(6) * 0.25}, r"'gear_angle' has shape \(7,\): pass an array of shape \(6,\)"),
        ({"time": np.zeros((7, 1))}, r"shape \(7, 1\)"),
        ({"time": np.array([0, 1, 2, 2, 3, 4, 5.0])}, r"at sample 3: 2\.0 s is followed by 2\.0 s"),
        ({"time": np.array([0, 1, 2, np.nan, 3, 4, 5.0])}, r"sample 3 \(counting from 0\) is nan s"),
        ({"time": np.array([0, 1, 2, 3, 4, 5, np.inf])}, r"sample 6 \(counting from 0\) is inf s"),
        ({"units": {"gear_angle": "rad", "gear_speed": "rad/s"}}, "'pin_force' has no unit"),
        (
            {"units": UNITS | {"pin_forse": "N"}},
            "'pin_forse', but the log has no such column.*; columns with similar names: pin_force",
        ),
    ],
)
def test_refuses_what_does_not_fit(changes, message):
    with pytest.raises(LogError, match=message):
        make_run(**changes)


def test_the_repr_of_a_run_is_one_line_for_any_number_of_samples() -> None:
    time = np.arange(100_000) * 1e-4
    columns = {f"column_{n}": np.zeros(time.size) for n in range(50)}
    run = Run(time, columns, dict.fromkeys(columns, "1"), attachments={"a<b>.toml": b"x" * 10_000}, complete=False)
    assert repr(run) == (
        "Run(samples 100000, columns 50, time 0 to 9.9999 s, attachments a<b>.toml, complete no: no reason given)"
    )
    html = run._repr_html_()
    assert html.startswith("<table><tr><th>samples</th><td>100000</td>")
    assert "a&lt;b&gt;.toml" in html
    assert len(html) < 500


def test_a_run_without_samples_has_a_repr() -> None:
    assert repr(Run(np.zeros(0), {}, {})) == "Run(samples 0, columns 0, time none, attachments none, complete yes)"


# --- topics and forces


def forced_run(**changes) -> Run:
    names = [f"{pair}_force_{axis}" for pair in ("pin_2", "pin_10", "cam", "output_pin_1", "socket_2") for axis in "xy"]
    columns = {name: np.full(3, float(place)) for place, name in enumerate([*names, "cam_friction_power"])}
    topics = {"/reducer": ["cam_friction_power"], "/forces": names}
    return Run(
        **(
            {"time": np.arange(3.0), "columns": columns, "units": dict.fromkeys(columns, "N"), "topics": topics}
            | changes
        )
    )


def test_a_run_keeps_its_topics():
    run = forced_run()
    assert list(run.topics) == ["/reducer", "/forces"]
    for other in (run.select(slice(1, None)), run.usable(), pickle.loads(pickle.dumps(run))):
        assert other.topics == run.topics
    assert run.groups["/reducer"] == {"cam_friction_power": "N"}
    assert make_run().topics == {"/reducer": tuple(UNITS)}
    assert forced_run(topics={"/forces": []}).topics == {"/forces": tuple(run.columns)}
    with pytest.raises(
        LogError,
        match=r"`topics` lists 'cam_friction_powr', but .*; columns with similar names: cam_friction_power",
    ):
        forced_run(topics={"/reducer": ["cam_friction_powr"]})
    with pytest.raises(LogError, match="lists the column 'cam_force_x' twice"):
        forced_run(topics={"/reducer": ["cam_force_x"], "/forces": ["cam_force_x"]})


def test_forces_are_those_of_a_kind_of_pair_in_the_order_of_the_run():
    run = forced_run()
    assert run.pairs("pin_gear") == ("pin_2", "pin_10")
    np.testing.assert_array_equal(run.forces("pin_gear")[1], [[0.0, 1.0], [2.0, 3.0]])
    np.testing.assert_array_equal(run.forces("output")[:, 0, 1], run["output_pin_1_force_y"])
    assert run.forces("pin_socket").shape == (3, 1, 2)
    assert list(run.by_stem("friction_power")) == ["cam"]
    with pytest.raises(
        LogError, match=r"no contact forces of kind 'tooth'; the kinds in this log are.*simulate` again"
    ):
        run.forces("tooth")
