"""Animation of the mechanism: selection of the samples of a run, and the frames."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg

from cycloid_mj.analysis import Series, series
from cycloid_mj.base.animation import ANIMATION
from cycloid_mj.base.array import Array
from cycloid_mj.base.engine import Progress, silent
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.base.record import Run
from cycloid_mj.plots.movie import write_movie
from cycloid_mj.plots.stage import AnimatedFigure, Script, create_stage, update_stage
from cycloid_mj.plots.style import with_style
from cycloid_mj.reducer import RvReducer, reducer_of
from cycloid_mj.reducer.member import view_columns_from_ring, view_from_ring
from cycloid_mj.scene import (
    Drawing,
    RvDrawing,
    contact_forces,
    draw_rv_poses,
    drawn_radii,
    ideal_forces,
    magnify_gaps,
    measure_gaps,
)
from cycloid_mj.scene.drawing import check_magnification
from cycloid_mj.scene.rv_drawing import largest_rv_magnification

Image = npt.NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Take:
    """Samples of a run to animate: the run, ordered indices `rows` of samples, and the magnification of clearances.

    The disc shown with its forces is that of `motion`.
    """

    motion: Series
    rows: npt.NDArray[np.intp]
    magnification: float


@shows_progress
def animate(
    run: Run,
    out: Path | str,
    magnify: float = 1.0,
    turns: float = 1.0,
    frames: int = ANIMATION.frames,
    fps: int = ANIMATION.rate,
    width: int = ANIMATION.width,
    progress: Progress = silent,
) -> None:
    """Write an animation of a run in its plane, with forces and loads, as ``.gif`` or ``.mp4``.

    Parameters
    ----------
    run
        The run.
    out
        File to write, replaced if it exists.
    magnify
        Factor by which clearances are magnified.
    turns, frames
        Number of crank turns shown, and largest number of frames; see `select_samples`.
    fps, width
        Frames per second, and width [pixels].
    progress
        Called with the numbers of finished and of all frames.

    Raises
    ------
    UsageError
        A value is out of range, or the name ends neither in .gif nor in .mp4.
    LogError
        The run has no design, or lacks a column.
    CycloidError
        The file cannot be written, or the extra ``video`` is not installed.
    """
    samples = select_samples(run, magnify, frames, turns)

    def counted_frames() -> Iterator[Image]:
        for count, image in enumerate(draw_frames(samples, width), 1):
            progress(count, len(samples.rows))
            yield image

    write_movie(counted_frames(), out, fps)


def select_samples(
    run: Run, magnification: float = 1.0, frames: int = ANIMATION.frames, turns: float = 1.0, disc: int = 0
) -> Take:
    """Select evenly spaced samples of a run for an animation: settled crank turns, or the last turns of a ramp.

    The result has the time series of the run, the indices of the samples and the magnification.

    Parameters
    ----------
    magnification
        Factor by which clearances are magnified.
    frames
        Number of frames; fewer if the run has fewer samples.
    turns
        Crank turns, also fractions; fewer if the run has fewer.
    disc
        Index of the disc shown with its forces; the others are outlines.

    Raises
    ------
    LogError
        The run has no design, lacks a column, or has fewer than two samples.
    UsageError
        `frames` or `turns` is not positive, the magnification is too large, or there is no such disc.
    """
    if frames < 1:
        raise UsageError(f"frames = {frames} (the number of pictures) is out of range: choose 1 or more")
    if not turns > 0.0:
        raise UsageError(
            f"turns = {turns:g} (the number of crank turns shown) is out of range: choose a value greater than 0, such "
            "as 1"
        )
    motion = series(run)
    if not 0 <= disc < motion.design.gear.discs:
        raise UsageError(
            f"the design {motion.design.name} has no disc {disc + 1}: choose a disc from 1 to "
            f"{motion.design.gear.discs}"
        )
    motion = motion.of_disc(disc)
    if isinstance(motion.reducer, RvReducer):
        check_magnification(motion.reducer, magnification, largest_rv_magnification(motion.reducer))
    else:
        drawn_radii(motion.reducer, magnification)
    first_row = motion.one_turn.start
    swept_turns = np.abs(motion.crank_angle[first_row:] - motion.crank_angle[first_row]) / (2 * np.pi)
    frame_turns = np.linspace(0.0, min(turns, float(swept_turns[-1])), frames, endpoint=False)
    return Take(motion, first_row + np.unique(np.searchsorted(swept_turns, frame_turns)), magnification)


@with_style
def draw_frames(samples: Take, width: int = ANIMATION.width) -> Iterator[Image]:
    """Yield the pictures of an animation as RGB arrays, shape (height, width, 3), with even height and width.

    `samples` are those of `select_samples`, `width` is in pixels.

    Raises
    ------
    UsageError
        The width is out of range.
    DesignError
        A part cannot be drawn.
    """
    min_width, max_width = ANIMATION.widths
    if not min_width <= width <= max_width:
        raise UsageError(
            f"the width of the animation is {width} pixels, which is out of range: choose a width from {min_width} to "
            f"{max_width} pixels"
        )
    motion = samples.motion
    columns = {name: values[samples.rows] for name, values in motion.run.columns.items()}
    reducer = reducer_of(view_from_ring(motion.design))
    ring_columns = view_columns_from_ring(motion.reducer, columns)
    poses: Drawing | RvDrawing
    if isinstance(reducer, RvReducer):
        poses = draw_rv_poses(reducer, ring_columns, motion.disc, samples.magnification)
    else:
        poses = magnify_gaps(reducer, measure_gaps(reducer, ring_columns, motion.disc), samples.magnification)
    script = Script(
        reducer=motion.reducer,
        drawn=poses,
        acting=contact_forces(reducer, ring_columns, poses).of_disc(motion.disc),
        ideal=ideal_forces(reducer, ring_columns, motion.disc),
    )
    return _render_frames(
        script, create_stage(script, width), motion.crank_angle[samples.rows], motion.time[samples.rows]
    )


def _render_frames(script: Script, stage: AnimatedFigure, crank_angle: Array, time: Array) -> Iterator[Image]:
    """Draw the frames of an animation and yield the picture of each as an RGB array, shape (height, width, 3).

    `script` has the motion and forces of all frames; `stage` is the figure, whose parts are moved for each frame.
    `crank_angle` [rad] and `time` [s], shape (frames,) each, are printed in the picture.
    """
    canvas = FigureCanvasAgg(stage.figure)
    for row, time_of_frame in enumerate(time.tolist()):
        update_stage(stage, script, row)
        angle = math.degrees(crank_angle[row]) % 360.0
        stage.clock.set_text(f"crank {angle:5.1f}\N{DEGREE SIGN},  {time_of_frame:.4f} s")
        canvas.draw()
        picture = np.asarray(canvas.buffer_rgba())
        height, width = (2 * (size // 2) for size in picture.shape[:2])
        yield picture[:height, :width, :3].copy()
