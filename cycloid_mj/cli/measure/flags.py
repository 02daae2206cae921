"""Flags that several measures share, the design that they are asked for, and the folder that they write to."""

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from cycloid_mj.cli.flags import LOAD, SPEED, Quantity, designed, whole, within
from cycloid_mj.cli.outfile import folder
from cycloid_mj.design import Design
from cycloid_mj.errors import CycloidError

OUT = "runs/measure"
RATED = "Default: the rated torque, drive.torque_nm times the ratio (36.68 in the presets)."

OutFlag = Annotated[
    str,
    Parameter(
        metavar="DIR",
        help="Folder of the figure, the JSON file and the logs, made if there is none; files of an earlier measure of "
        f"the same design are replaced. Default: {OUT}.",
    ),
]
NoLogFlag = Annotated[bool, Parameter(name="--no-log", help="Write no MCAP logs of the underlying runs.")]
QuietFlag = Annotated[bool, Parameter(help="No progress and no messages but errors on stderr.")]
TurnsFlag = Annotated[
    int,
    Parameter(
        metavar="N",
        converter=whole,
        validator=within(1, 1000),
        help="Crank turns of each run, from 1 to 1000; one turn of the output tells all orders apart. Default: 1.",
    ),
]


def _each_positive(quantity: Quantity) -> Callable[[Any, Any], None]:
    def require(_: Any, values: tuple[float, ...] | None) -> None:
        for value in values or ():
            if not value > 0.0:
                raise ValueError(f"each must be more than 0 [{quantity.symbol}], not {value:g}")
            try:
                quantity.require(value)
            except ValueError as error:
                raise ValueError(f"each {error}, not {value:g}") from None

    return require


def torque_flag(text: str, default: str = RATED) -> Parameter:
    """Declare a flag for a torque on the output; `text` says which."""
    return Parameter(metavar="X", validator=LOAD.require, help=f"{text} [N m], {LOAD.range}. {default}")


def several(quantity: Quantity, text: str, default: str) -> Parameter:
    """Declare a flag for one or more values above 0 that keep a quantity's limits; `text` says what they are."""
    return Parameter(
        metavar="X",
        consume_multiple=True,
        validator=_each_positive(quantity),
        help=f"{text} [{quantity.symbol}], each more than 0; one or more. {default}",
    )


LoadedFlag = Annotated[float | None, torque_flag("Torque of the loaded runs")]
SpeedsFlag = Annotated[
    tuple[float, ...],
    several(SPEED, "Crank speeds", "Default: shares of the design's drive.speed_rpm from 0.5 to 1.5."),
]


def rad_per_second(rpm: Sequence[float]) -> list[float]:
    """Give crank speeds [rad/s] from rpm."""
    return [SPEED.unit.to_si(one) for one in rpm]


def sound(name: str, changes: Sequence[str], values: Sequence[tuple[Quantity, float | None]] = ()) -> Design:
    """Give the design of a command line, if it can be built.

    Raises
    ------
    UsageError
        No such design, or a change that it does not take.
    DesignError
        It fails a check.
    """
    from cycloid_mj.checks import require_sound

    design = designed(name, changes, values)
    require_sound(design)
    return design


def prepared(out: str) -> Path:
    """Give the folder for the results, before the work that they take; raise CycloidError if it cannot be written."""
    into = folder(out, "the measurement")
    if not os.access(into, os.W_OK | os.X_OK):
        raise CycloidError(f"cannot write the measurement to {out}: no permission; choose another folder with --out")
    return into
