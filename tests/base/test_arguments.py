"""Wrong arguments of public functions end in one error that names the argument and the allowed values."""

from collections.abc import Callable
from math import inf, nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cycloid_mj as cm
from cycloid_mj.base.arguments import require_choice, require_count, require_number
from cycloid_mj.base.errors import UsageError
from cycloid_mj.bench import read_loop

LOOP = Path(__file__).parents[1] / "data" / "bench" / "play_loop.csv"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: cm.statics(None), "None is not a design: choose a Design, the name of a preset"),
        (lambda: cm.rate(b"pin"), "b'pin' is not a design"),
        (lambda: cm.load("pin", {1: 1}), "changes = {1: 1} is not allowed: use texts such as"),
        (lambda: cm.load("pin", 5), "changes = 5 is not allowed"),
        (lambda: cm.load("pin", [None]), "changes = [None] is not allowed"),
        (lambda: cm.rate("pin", parts="real"), "parts = 'real' is not allowed: choose one of 'perfect', 'toleranced'"),
        (lambda: cm.rate("pin", poses=0), "poses = 0 is not allowed: choose a whole number of at least 1"),
        (lambda: cm.rate("pin", life=-1.0), "life = -1.0 is not allowed: choose a finite number greater than 0 [h]"),
        (lambda: cm.rate("pin", life=nan), "life = nan is not allowed"),
        (lambda: cm.datasheet("pin", -1.0), "life_h = -1.0 is not allowed"),
        (lambda: cm.export("pin", "iges"), "file_format = 'iges' is not allowed: choose one of 'stl', 'obj'"),
        (
            lambda: cm.export("pin", "stl", motor="nema"),
            "motor = 'nema' is not allowed: choose one of 'auto', 'nema17'",
        ),
        (lambda: cm.export("pin", "dxf", arcs=0.0), "arcs = 0.0 is not allowed"),
        (lambda: cm.calibrate("printed", [read_loop(LOOP)], held="sun"), "held = 'sun' is not allowed"),
        (lambda: cm.calibrate("printed", [read_loop(LOOP)], crank=nan), "crank = nan is not allowed"),
        (lambda: cm.protocol("pin", nan), "rated_nm = nan is not allowed"),
        (lambda: cm.protocol("pin", angles=0), "angles = 0 is not allowed"),
        (lambda: cm.compare_bench("pin", None, inf), "load = inf is not allowed: choose a finite number [N m]"),
        (lambda: cm.tolerance("pin", 0), "samples = 0 is not allowed"),
        (lambda: cm.tolerance("pin", 2.5), "samples = 2.5 is not allowed: choose a whole number"),
        (lambda: cm.tolerance("pin", 2, -1), "seed = -1 is not allowed"),
        (lambda: cm.new(20, 60, 4, process="wood"), "process = 'wood' is not allowed: choose one of 'steel'"),
        (lambda: cm.build("pin", "sun"), "held = 'sun' is not allowed: choose one of 'crank', 'output', ''"),
    ],
)
def test_a_wrong_argument_is_named_with_the_allowed_values(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(UsageError) as caught:
        call()
    assert message in str(caught.value)


def test_a_single_change_may_be_a_text() -> None:
    assert cm.load("pin", "load.torque_nm=36").load.torque == 36.0


def test_numbers_of_numpy_are_numbers() -> None:
    require_number("torque", np.float32(3.0), "N m", above=0.0)
    require_count("samples", np.int64(3), 1, 5)
    require_choice("parts", "perfect", ["perfect"])
    for value in (True, "3", None, 6):
        with pytest.raises(UsageError, match="choose a whole number from 1 to 5"):
            require_count("samples", value, 1, 5)
