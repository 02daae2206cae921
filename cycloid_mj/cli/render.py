"""``cycloid-mj render``: an image of a logged run by MuJoCo, without a display."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError
from cycloid_mj.cli.analyze import LogName
from cycloid_mj.cli.delivery import claim_page, deliver_files
from cycloid_mj.cli.flags import COMMON, FLAT, CommonFlags, integer_flag, number_flag
from cycloid_mj.cli.outfile import claim_file
from cycloid_mj.reducer import reducer_of

EXAMPLES = """Examples:
  cycloid-mj render runs/pin.mcap pin.png
  cycloid-mj render runs/pin.mcap back.png --time-s 0.05 --azimuth 60 --elevation 40"""

WIDTH, HEIGHT = 1280, 960
AZIMUTH, ELEVATION = 90.0, -62.0
"""Default size of an image [pixels], and direction of view [deg]."""
FORMATS = (".png", ".jpg", ".webp")

PictureName = Annotated[str, Parameter(name="--out", metavar="FILE", help="Image to write, .png, .jpg or .webp.")]
TimeFlag = Annotated[float | None, Parameter(metavar="T", help="Time of the image [s]. Default: the end of the run.")]
WidthFlag = Annotated[int, integer_flag(f"Image width [pixels]. Default: {WIDTH}.")]
HeightFlag = Annotated[int, integer_flag(f"Image height [pixels]. Default: {HEIGHT}.")]
AzimuthFlag = Annotated[
    float,
    number_flag("Azimuth of the camera [deg]. Default: 90.", (-360, 360)),
]
ElevationFlag = Annotated[
    float,
    number_flag("Elevation of the camera [deg]; negative: output side, positive: input side. Default: -62.", (-90, 90)),
]


def render(
    log: LogName,
    /,
    out: PictureName,
    *,
    time_s: TimeFlag = None,
    width: WidthFlag = WIDTH,
    height: HeightFlag = HEIGHT,
    azimuth: AzimuthFlag = AZIMUTH,
    elevation: ElevationFlag = ELEVATION,
    output_flags: Annotated[CommonFlags, FLAT] = COMMON,
) -> int:
    """Render an image of a logged run with MuJoCo.

    The model of the log is shown. No display is needed, but off-screen OpenGL is (EGL, or the library that MUJOCO_GL
    names). `cycloid-mj animate` needs neither.
    """
    import numpy as np

    from cycloid_mj.analysis.series import design_of
    from cycloid_mj.base.atomic_write import atomic_file
    from cycloid_mj.log import read
    from cycloid_mj.scene.opengl import require_mujoco

    if Path(out).suffix.lower() not in FORMATS:
        raise UsageError(
            f"cannot write {out}: unknown image format. Use a file name that ends in {' or '.join(FORMATS)}"
        )
    run = read(log)
    if time_s is not None and not run.time[0] <= time_s <= run.time[-1]:
        raise UsageError(
            f"--time-s {time_s:g} is outside the run: give a time from {run.time[0]:.6g} to {run.time[-1]:.6g} s"
        )
    claim_file(Path(out), output_flags.force)
    page = claim_page(output_flags, f"{Path(out).stem}-picture")
    sample = len(run) - 1 if time_s is None else int(np.argmin(np.abs(run.time - time_s)))
    require_mujoco()
    from cycloid_mj.scene.render import render as render_run

    picture = render_run(run, reducer_of(design_of(run)), sample, (width, height), (azimuth, elevation))
    from PIL import Image

    with atomic_file(out) as temporary_path:
        Image.fromarray(picture).save(temporary_path)
    return deliver_files(f"picture: {log}", [out], page, output_flags)
