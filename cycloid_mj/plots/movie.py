"""Writers of animations: GIF and MP4."""

from collections.abc import Iterable
from itertools import chain
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from cycloid_mj.base.animation import ANIMATION
from cycloid_mj.base.atomic_write import atomic_file
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.extras import import_extra

Frame = npt.NDArray[np.uint8]


COLOURS = 128
"""Colours of a GIF: smaller files, no visible difference."""


QUALITY = "10"
"""Constant rate factor of H.264, from 0 (lossless) to 51: no visible artefacts at edges."""


def write_movie(frames: Iterable[Frame], path: Path | str, rate: int = ANIMATION.rate) -> None:
    """Write frames of equal size as an endless ``.gif`` or as ``.mp4`` (H.264).

    The file appears under its name when it is complete.

    Parameters
    ----------
    frames
        Pictures, shape (height, width, 3), height and width even.
    path
        File to write; replaced if it exists.
    rate
        Frames per second.

    Raises
    ------
    UsageError
        The name ends neither in .gif nor in .mp4, or the rate is out of range.
    CycloidError
        The file cannot be written, or the extra ``video`` is not installed.
    """
    path = Path(path)
    writers = {".gif": _write_gif, ".mp4": _write_mp4}
    if path.suffix.lower() not in writers:
        raise UsageError(f"cannot write {path}: unknown animation format. Use a file name that ends in .gif or .mp4")
    slowest, fastest = ANIMATION.rates
    if not slowest <= rate <= fastest:
        raise UsageError(
            f"the frame rate of the animation {path} is {rate:g} per second, which is out of range: choose a rate from "
            f"{slowest} to {fastest} per second (--fps)"
        )
    with atomic_file(path) as temporary:
        writers[path.suffix.lower()](frames, temporary, rate)


def _write_gif(frames: Iterable[Frame], path: Path, rate: int) -> None:
    """Write RGB frames as a GIF with a `rate` [frames/s].

    All frames share the palette of the first one, which avoids flicker.
    """
    pictures = (Image.fromarray(frame) for frame in frames)
    first_picture = next(pictures).quantize(COLOURS, dither=Image.Dither.NONE)
    other_pictures = (picture.quantize(palette=first_picture, dither=Image.Dither.NONE) for picture in pictures)
    # GIF has hundredths of a second
    duration = 10 * round(100 / rate)
    first_picture.save(
        path, format="GIF", save_all=True, append_images=other_pictures, duration=duration, loop=0, disposal=1
    )


def _write_mp4(frames: Iterable[Frame], path: Path, rate: int) -> None:
    """Write RGB frames as an MP4 file (H.264) with a `rate` [frames/s] by PyAV; raise OSError if that fails."""
    av = import_extra("av", "MP4", "video", "write a .gif")
    stream = iter(frames)
    first_picture = next(stream)
    try:
        with av.open(str(path), "w", format="mp4") as container:
            video = container.add_stream("libx264", rate=rate, options={"crf": QUALITY})
            video.height, video.width = first_picture.shape[:2]
            video.pix_fmt = "yuv420p"
            for frame in chain([first_picture], stream):
                container.mux(video.encode(av.VideoFrame.from_ndarray(frame)))
            container.mux(video.encode())
    except av.FFmpegError as problem:
        raise OSError(problem.errno, problem.strerror) from problem
