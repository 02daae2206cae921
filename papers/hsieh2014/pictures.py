"""Pictures of both reducers as they run, where there is OpenGL: the paper's Figs 3, 4 and 17."""

from collections.abc import Sequence

from cycloid_mj.analysis.series import design_of
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.record import Run
from cycloid_mj.reducer import Reducer
from hsieh2014.stage import Plate


def pictures(rated: Sequence[Run]) -> tuple[tuple[Plate, ...], tuple[str, ...]]:
    """Render both reducers under the rated load; without OpenGL give the reason in place of the pictures."""
    from cycloid_mj.scene.render import render
    from hsieh2014.paper_figures import picture_figure

    views = {"front": (90.0, -89.9), "aslant": (60.0, -35.0)}
    try:
        drawn = {
            run.provenance["design"]: {
                name: render(run, Reducer(design_of(run)), len(run) - 1, (700, 700), view)
                for name, view in views.items()
            }
            for run in rated
        }
    except CycloidError as error:
        return (), (f"No pictures of the reducers (Figs 3, 4, 17): {error}",)
    words = "the reducer as it runs here under the rated load, with the forces on the gear; the output is see-through."
    return tuple(
        Plate(f"fig17_reducer_{name}", "Figs 3, 4, 17", f"{name}: {words}", picture_figure(pictures))
        for name, pictures in drawn.items()
    ), ()
