"""The files that the page gives: the design and what is made from it, each as a name and bytes."""

import io
import zipfile
from collections.abc import Callable, Mapping

from cycloid_mj.design import Design, dump
from cycloid_mj.parts.export import FORMATS, export
from cycloid_mj.reducer import Reducer


def design_file(design: Design) -> dict[str, bytes]:
    """Write the design as TOML."""
    return {f"{design.name}.toml": dump(design).encode()}


def model(design: Design) -> dict[str, bytes]:
    """Pack a model folder that any MuJoCo opens."""
    from cycloid_mj.dynamics.mjcf.folder import model_files

    return _packed(f"{design.name}-mjcf", model_files(Reducer(design)))


def data_sheet(design: Design) -> dict[str, bytes]:
    """Draw the data sheet as PDF."""
    from cycloid_mj.life.datasheet import datasheet
    from cycloid_mj.plots.datasheet import datasheet_pages
    from cycloid_mj.plots.save import document

    return {f"{design.name}-datasheet.pdf": document(datasheet_pages(datasheet(Reducer(design))))}


def parts_in(file_format: str) -> Callable[[Design], dict[str, bytes]]:
    """Return the function that makes every part of a design in a format, packed."""

    def pack(design: Design) -> dict[str, bytes]:
        return _packed(f"{design.name}-{file_format}", export(design, file_format).files)  # type: ignore[arg-type]

    return pack


FILES: Mapping[str, Callable[[Design], dict[str, bytes]]] = {
    "TOML": design_file,
    **{name.upper(): parts_in(name) for name in FORMATS if name != "obj"},
    "MJCF": model,
    "Datasheet": data_sheet,
}
"""What a button says -> what it gives."""


def _packed(name: str, files: Mapping[str, bytes]) -> dict[str, bytes]:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for place, content in sorted(files.items()):
            archive.writestr(zipfile.ZipInfo(f"{name}/{place}", (1980, 1, 1, 0, 0, 0)), content)
    return {f"{name}.zip": packed.getvalue()}
