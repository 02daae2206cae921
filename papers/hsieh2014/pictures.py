"""Rendered pictures of both reducers and their parts, as in the paper's Figs 3, 4 and 17; needs OpenGL."""

from collections.abc import Iterator, Sequence

from cycloid_mj.analysis.series import design_of
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.names import GEAR, HOUSING, OUTPUT, PIN, SHAFT, all_numbered
from cycloid_mj.base.record import Run
from cycloid_mj.reducer import Reducer
from hsieh2014.stage import PaperFigure

VIEWS = {"front": (90.0, -89.9), "aslant": (60.0, -35.0)}
"""Azimuth and elevation of the camera [deg]."""
PART_VIEWS = {"shaft": (60.0, -15.0), "output": (60.0, 40.0)}
"""Azimuth and elevation for parts with a view of their own [deg]."""
SIZE = (700, 700)
"""[pixels]"""


def pictures(rated: Sequence[Run]) -> tuple[tuple[PaperFigure, ...], tuple[str, ...]]:
    """Render both reducers under the rated load and their parts; without OpenGL return the reason."""
    try:
        return tuple(plate for run in rated for plate in _plates(run)), ()
    except CycloidError as error:
        return (), (f"No pictures of the reducers (Figs 3, 4, 17): {error}",)


def _plates(run: Run) -> Iterator[PaperFigure]:
    """Render a reducer from both sides, and its parts."""
    from cycloid_mj.scene.render import render, render_part
    from hsieh2014.paper_figures import picture_figure

    design = design_of(run)
    views = {name: render(run, Reducer(design), len(run) - 1, SIZE, view) for name, view in VIEWS.items()}
    words = "the reducer as it runs here under the rated load, with the forces on the gear; the output is see-through."
    yield PaperFigure(f"fig17_reducer_{design.name}", "Fig. 17", f"{design.name}: {words}", picture_figure(views))
    pins = {"pins": all_numbered(PIN, design.ring.teeth)} if design.ring.has_moving_pins else {}
    bodies = {"shaft": [SHAFT], "gear": [GEAR], "ring": [HOUSING]} | pins | {"output": [OUTPUT]}
    parts = {
        name: render_part(run, names, SIZE, PART_VIEWS.get(name, VIEWS["aslant"])) for name, names in bodies.items()
    }
    words = f"{design.name}: its parts one by one, each as large as fits: {', '.join(parts)}."
    yield PaperFigure(f"fig3_4_parts_{design.name}", "Figs 3, 4", words, picture_figure(parts))
