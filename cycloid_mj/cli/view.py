"""``cycloid-mj view``: MuJoCo's viewer on a model, or on a logged run."""

from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.cli.flags import NAMES, QuietFlag, SetFlag, TemperatureFlag, load_design, number_flag
from cycloid_mj.cli.terminal import note

EXAMPLES = """Examples:
  cycloid-mj view pin
  cycloid-mj view runs/pin.mcap --slow 200"""

SLOW = 100.0
"""Default factor by which the viewer slows the motion down."""

WhatFlag = Annotated[
    str,
    Parameter(name="--design", metavar="DESIGN|RUN.mcap", help=f"Design (preset {NAMES}, or TOML file), or log."),
]
SlowFlag = Annotated[
    float,
    number_flag(f"Slow-motion factor of the replay of a log. Default: {SLOW:g}.", (1e-3, 1e6)),
]


def view(
    what: WhatFlag,
    *,
    set_: SetFlag = (),
    at_c: TemperatureFlag = None,
    slow: SlowFlag = SLOW,
    _quiet: QuietFlag = False,
) -> int:
    """Open the MuJoCo viewer with a design, or replay a log in it.

    The replay of a log is slower than real time by the factor --slow. A display is needed; without one, use
    `cycloid-mj render` or `cycloid-mj animate`.
    """
    from cycloid_mj.scene.viewer import require_display, show_model, show_run

    require_display()
    if what.endswith(".mcap"):
        from cycloid_mj.log import read

        note("replaying the log in the MuJoCo viewer; close its window to stop")
        show_run(read(what), slow)
        return 0
    design = load_design(what, set_, (), at_c)
    from cycloid_mj.base.errors import warn
    from cycloid_mj.dynamics.mjcf import build
    from cycloid_mj.reducer import reducer_of

    note(f"building the MuJoCo model of {design.name}")
    compiled = build(reducer_of(design).at_rated_load.design)  # the window's sliders may load it
    warn(design.name, compiled.warnings)
    show_model(compiled.model)
    return 0
