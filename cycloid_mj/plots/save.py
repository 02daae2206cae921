"""Writers of figures; equal figures have identical files."""

from collections.abc import Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from matplotlib.text import Text

from cycloid_mj.base.atomic_write import encodable_text, write_files
from cycloid_mj.base.errors import CycloidError, UsageError, reason
from cycloid_mj.base.overwrite_guard import make_folder
from cycloid_mj.plots.style import with_style

METADATA: dict[str, dict[str, Any]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}
"""Metadata by format: no time and no program, so that files are reproducible."""

RESOLUTION = 200
"""Resolution of PNG files [px/in]."""


class FigureError(CycloidError):
    """A figure cannot be written."""


@with_style
def save(figures: Mapping[str, Figure], folder: Path | str, formats: Sequence[str] = ("png",)) -> list[Path]:
    """Write diagrams as ``folder/name.format``, and return the paths; if a file fails, none is written.

    The folder is created if necessary.

    Parameters
    ----------
    figures
        Name -> figure.
    folder
        Folder of the files.
    formats
        Any of png (200 dpi), svg and pdf.

    Raises
    ------
    UsageError
        A format is none of these.
    FigureError
        The folder cannot be created.
    CycloidError
        A file cannot be written; existing files are unchanged.
    """
    unknown_formats = [name for name in formats if name not in METADATA]
    if unknown_formats:
        raise UsageError(f"unknown figure format {unknown_formats[0]!r}: choose one of {', '.join(METADATA)}")
    folder = Path(folder)
    try:
        make_folder(folder)
    except OSError as problem:
        raise FigureError(f"cannot write figures to {folder}: {reason(problem)}. Choose a writable folder") from problem
    files = pictures(figures, folder, formats)
    write_files(files)
    return list(files)


def pictures(figures: Mapping[str, Figure], folder: Path, formats: Sequence[str] = ("png",)) -> dict[Path, bytes]:
    """Return figures as `save` writes them, to be written together with other files: path -> content."""
    return {
        folder / f"{name}.{form}": encode_figure(figure, form)
        for name, figure in figures.items()
        for form in dict.fromkeys(formats)
    }


@with_style
def encode_figure(figure: Figure, form: str) -> bytes:
    """Return a diagram as the bytes of a picture in the format `form` ("png", "svg" or "pdf").

    The layout of the figure is fixed at its first encoding, so that all formats look the same.
    """
    for text in figure.findobj(Text):  # undecodable bytes of file names have no glyphs
        text.set_text(encodable_text(text.get_text()))
    content = BytesIO()
    figure.savefig(content, format=form, dpi=RESOLUTION, metadata=METADATA[form])
    figure.set_layout_engine("none")
    return content.getvalue()


@with_style
def document(pages: Sequence[Figure]) -> bytes:
    """Encode figures as the pages of one tagged (accessible) PDF file, and return its bytes."""
    from cycloid_mj.plots.tagged_pdf import BACKEND, TaggedPdfFile  # half the import time of matplotlib

    content = BytesIO()
    file: Any = TaggedPdfFile(content, metadata=METADATA["pdf"])
    for page in pages:
        page.savefig(file, format="pdf", backend=BACKEND)
    file.finalize()
    file.close()
    return content.getvalue()
