"""The table of measures on the command line against the functions that it calls."""

import subprocess
import sys
from dataclasses import fields
from inspect import signature

import pytest

from cycloid_mj.cli.flags import SPEED
from cycloid_mj.cli.measure import COMMANDS
from cycloid_mj.measure import MEASURES

SHARED = {"design", "progress"}


def test_every_measure_has_a_command_with_help_and_examples():
    assert list(COMMANDS) == list(MEASURES)
    assert all(options.__doc__ and f"measure {name} " in options.EXAMPLES for name, options in COMMANDS.items())


@pytest.mark.parametrize("name", COMMANDS)
def test_the_options_of_a_command_are_parameters_of_its_measure(name):
    parameters = set(signature(MEASURES[name]).parameters)
    assert set(COMMANDS[name]().arguments()) | SHARED <= parameters
    # crank angles are chosen by --quick on the command line, published torques by the design
    assert parameters - set(COMMANDS[name]().arguments()) - SHARED <= {"angles", "published"}
    assert ("published" in parameters) == COMMANDS[name].PUBLISHED


@pytest.mark.parametrize("name", COMMANDS)
def test_defaults_of_the_flags_are_those_of_the_measure(name):
    defaults = {word: one.default for word, one in signature(MEASURES[name]).parameters.items()}
    for word, value in COMMANDS[name]().arguments().items():
        assert value == defaults[word] or (not value and not defaults[word])


def test_speeds_reach_a_measure_in_si():
    vibration = COMMANDS["vibration"]
    assert {field.name for field in fields(vibration)} >= {"speeds_rpm", "load_nm"}
    arguments = vibration(load_nm=20.0, speeds_rpm=(500.0,)).arguments()
    assert arguments["load"] == 20.0
    assert arguments["speeds"] == [SPEED.unit.to_si(500.0)]


def test_help_needs_no_arrays_and_no_simulation():
    code = "import sys; from cycloid_mj.cli import main; main(['measure', 'te', '--help']); print(*sorted(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "cyclopts" in loaded
    assert not {"numpy", "scipy", "mujoco", "numba", "matplotlib", "cycloid_mj.measure"} & set(loaded)
