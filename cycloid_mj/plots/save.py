"""Figures to files, the same bytes every time."""

from collections.abc import Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from matplotlib.text import Text

from cycloid_mj.base.atomic_write import storable, write_whole
from cycloid_mj.base.errors import CycloidError, UsageError, reason
from cycloid_mj.base.overwrite_guard import make_folder
from cycloid_mj.plots.style import styled

METADATA: dict[str, dict[str, Any]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}
"""What each format would say about when and by what it was written: nothing."""

RESOLUTION = 200
"""Dots per inch of a PNG."""


class FigureError(CycloidError):
    """A figure that cannot be written."""


@styled
def save(figures: Mapping[str, Figure], folder: Path | str, formats: Sequence[str] = ("png",)) -> list[Path]:
    """Write figures as `folder`/name.format, all of them or none, making the folder; give the paths.

    Parameters
    ----------
    figures
        Name -> figure.
    folder
        Where to.
    formats
        Any of png (200 dpi), svg and pdf.

    Raises
    ------
    UsageError
        A format is none of these.
    FigureError
        The folder cannot be made.
    CycloidError
        A file cannot be written; all that were there before are as they were.
    """
    unknown = [name for name in formats if name not in METADATA]
    if unknown:
        raise UsageError(f"no figure format {unknown[0]!r}; there are {', '.join(METADATA)}")
    folder = Path(folder)
    try:
        make_folder(folder)
    except OSError as problem:
        raise FigureError(
            f"cannot write figures to {folder}: {reason(problem)}; give a folder that can be written"
        ) from problem
    files = pictures(figures, folder, formats)
    write_whole(files)
    return list(files)


def pictures(figures: Mapping[str, Figure], folder: Path, formats: Sequence[str] = ("png",)) -> dict[Path, bytes]:
    """Draw figures as `save` writes them, to be written together with other files: path -> content."""
    return {
        folder / f"{name}.{form}": drawn(figure, form)
        for name, figure in figures.items()
        for form in dict.fromkeys(formats)
    }


@styled
def drawn(figure: Figure, form: str) -> bytes:
    """Encode a figure as the bytes of a file of a format; what is drawn first lays it out for all."""
    for text in figure.findobj(Text):  # odd bytes of a file's name have no letters
        text.set_text(storable(text.get_text()))
    content = BytesIO()
    figure.savefig(content, format=form, dpi=RESOLUTION, metadata=METADATA[form])
    figure.set_layout_engine("none")
    return content.getvalue()


@styled
def document(pages: Sequence[Figure]) -> bytes:
    """Encode figures as the pages of one PDF file."""
    from matplotlib.backends.backend_pdf import PdfPages  # loads what subsets fonts, half of what matplotlib costs

    content = BytesIO()
    with PdfPages(content, metadata=METADATA["pdf"]) as file:
        for page in pages:
            file.savefig(page)
    return content.getvalue()
