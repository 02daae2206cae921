"""Artifacts of a design that the page offers as downloads: design file, CAD files, models, data sheet, run report."""

import json
import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import Any

from cycloid_mj.app.drive import BuildOptions, build_files, reducer_at_reference
from cycloid_mj.app.jobs import Download
from cycloid_mj.app.state import parse_design
from cycloid_mj.base.atomic_write import zip_files
from cycloid_mj.base.errors import CycloidError, DesignError
from cycloid_mj.base.extras import import_extra
from cycloid_mj.base.result import to_json_values
from cycloid_mj.design import Design, dump
from cycloid_mj.design.layouts import Layout
from cycloid_mj.parts.export import (
    CHORD_ERROR,
    Format,
    assembly_step,
    casing_or_none,
    drive_files,
    export,
    widen_clearances,
)
from cycloid_mj.parts.export.casing import Casing
from cycloid_mj.parts.export.print_files import PrintSettings, print_files, stock_cam_seat
from cycloid_mj.reducer import Reducer, reducer_of

MIN_CRANK_TURNS = 1.25
"""Crank turns of a run after the start has settled (heuristic)."""

Progress = Callable[[Any], None]

DEFAULT_OPTIONS = BuildOptions()


def design_file(design: Design, _options: BuildOptions) -> dict[str, bytes]:
    """Return the design file (TOML)."""
    return {f"{design.name}.toml": dump(design).encode()}


def model(design: Design, _options: BuildOptions) -> dict[str, bytes]:
    """Return a zip file of a model folder for stock MuJoCo."""
    from cycloid_mj.dynamics.mjcf.folder import model_files

    return _zip(f"{design.name}-mjcf", model_files(reducer_of(design)))


def data_sheet(design: Design, _options: BuildOptions) -> dict[str, bytes]:
    """Return the data sheet as PDF."""
    from cycloid_mj.life.datasheet import datasheet
    from cycloid_mj.plots.datasheet import datasheet_pages
    from cycloid_mj.plots.save import document

    return {f"{design.name}-datasheet.pdf": document(datasheet_pages(datasheet(reducer_of(design))))}


def part_files(file_format: Format, design: Design, options: BuildOptions) -> dict[str, bytes]:
    """Create a zip file with all parts of a design in a file format, and the covers of the drive if they fit.

    `options` has the motor and the printer offset. Returns a dict with one entry, the name of the zip file -> its
    content.
    """
    files = dict(export(design, file_format, CHORD_ERROR, options.offset, options.motor).files)
    reducer = reducer_at_reference(reducer_of(design))
    if casing := _casing(reducer, options):
        widened_reducer = widen_clearances(reducer, options.offset)
        files |= drive_files(widened_reducer, file_format, casing, CHORD_ERROR, stock_cam_seat(reducer))
    return _zip(f"{design.name}-{file_format}", files)


def assembly(design: Design, options: BuildOptions) -> dict[str, bytes]:
    """Return the assembly as a STEP file, with covers if they fit."""
    reducer = reducer_at_reference(reducer_of(design))
    return {f"{design.name}.step": assembly_step(reducer, 0.0, _casing(reducer, options))}


def _casing(reducer: Reducer, options: BuildOptions) -> Casing | None:
    """Return the casing of a drive; None if it does not fit, and for an RV reducer, which has none."""
    return None if WHOLE_DRIVE in LEFT_OUT[reducer.LAYOUT] else casing_or_none(reducer, options.motor)[0]


def print_plate(design: Design, options: BuildOptions) -> dict[str, bytes]:
    """Return a zip file with print plates, test coupon and bill of materials, with covers if they fit."""
    reducer = reducer_at_reference(Reducer(design))
    settings = PrintSettings(CHORD_ERROR, options.offset, stock_cam_seat(reducer), options.bed)
    printed = print_files(reducer, casing_or_none(reducer, options.motor)[0], settings)
    return _zip(f"{design.name}-print", printed.files)


def joint_files_zip(design: Design, _options: BuildOptions) -> dict[str, bytes]:
    """Create a zip file with the files that ``cycloid-mj reduce`` writes for a robot model, without the HTML page.

    Returns a dict with one entry, the name of the zip file -> its content.
    """
    from cycloid_mj.robot.files import choose_scenes, joint_files
    from cycloid_mj.robot.identification import reduce

    joint = reduce(design)
    joint_json = json.dumps(to_json_values(joint.as_json()), indent=1)
    files = joint_files(joint, *choose_scenes(joint)) | {"reducer.json": joint_json.encode()}
    return _zip(f"{design.name}-joint", files)


DESIGN_FILE, WHOLE_DRIVE = "toml", "drive"
"""Kinds of the design file, which is written at once, and of all files to build a drive."""

FILES: Mapping[str, tuple[str, Callable[[Design, BuildOptions], dict[str, bytes]]]] = {
    DESIGN_FILE: ("Design file", design_file),
    "datasheet": ("Data sheet (PDF)", data_sheet),
    "step": ("Assembly (STEP)", assembly),
    "3mf": ("Print plate (3MF)", print_plate),
    "stl": ("Meshes (STL)", partial(part_files, "stl")),
    "dxf": ("Outlines (DXF)", partial(part_files, "dxf")),
    "mjcf": ("MuJoCo model (MJCF)", model),
    "joint": ("Joint for a robot", joint_files_zip),
}
"""Kind -> text of its button, and the function that returns the files as {name: content}."""

LEFT_OUT: Mapping[Layout, tuple[str, ...]] = {"central": (), "rv": ("3mf", WHOLE_DRIVE)}
"""Layout -> kinds of files that it does not have: RV reducers are not printed, and have no covers."""


def create_files(on_progress: Progress, values: Any, kind: str, options: BuildOptions = DEFAULT_OPTIONS) -> Download:
    """Create the files of one kind, such as STEP or DXF, that the page offers for download, as bytes.

    Parameters
    ----------
    on_progress
        Called before each step with a dict: ``doing`` is the step in words. For the whole drive it also has ``share``,
        the completed fraction.
    values
        The design as the page sends it: keys of the design file -> values, see `parse_design`.
    kind
        Key of `FILES`, or `WHOLE_DRIVE` for all files to build the drive.
    options
        Motor, increase of the clearances of printed parts, and bed of the printer; see `BuildOptions`.

    Returns
    -------
    Download
        Its ``files`` are a dict with a single entry, file name -> content as bytes. Several files are in a zip file.
    """
    design = parse_design(values)
    if kind in LEFT_OUT[design.layout]:
        raise DesignError(f"{design.name}: an RV reducer has no covers and no print plate: download single files")
    if kind == WHOLE_DRIVE:
        files = build_files(
            Reducer(design), options, lambda doing, share: on_progress({"doing": doing, "share": share})
        )
        return Download(files=_zip(f"{design.name}-drive", files))
    on_progress({"doing": "creating the file"})
    return Download(files=FILES[kind][1](design, options))


def load_exports() -> None:
    """Load the packages that draw and model the parts, before the user wants their files."""
    from cycloid_mj.plots import drawings, exploded  # noqa: F401

    with suppress(CycloidError):  # not installed: the files say so
        import_extra("OCP", "STEP", "cad")


def simulate_run(on_progress: Progress, values: Any) -> Download:
    """Simulate a design in MuJoCo at full speed under its load, and return the report of the run (`Download.page`).

    The run has no start-up ramp; it lasts for the settling time, then for at least `MIN_CRANK_TURNS` crank turns.
    `values` is the design as the page sends it, see `parse_design`. `on_progress` is called with ``doing``, the step in
    words, and ``share``, the completed fraction from 0 to 1.

    Raises
    ------
    DesignError
        The crank speed is zero.
    CycloidError
        The run failed.
    """
    from cycloid_mj.comparison import settling_time
    from cycloid_mj.dynamics.run import simulate
    from cycloid_mj.report import report

    design = parse_design(values)
    if design.drive.speed == 0.0:
        raise DesignError(
            "the crank speed (drive.speed_rpm) is 0, so there is nothing to simulate: set a speed other than 0, such "
            "as 1640 rpm"
        )
    without_ramp = design.but(drive={"ramp": 0.0})
    settling_duration, crank_turn = settling_time(reducer_of(without_ramp)), 2.0 * math.pi / abs(design.drive.speed)
    # the report judges at least half of the time at constant speed
    shortened_design = without_ramp.steady(settling_duration, max(MIN_CRANK_TURNS, settling_duration / crank_turn))

    def report_progress(done: int, total: int) -> None:
        on_progress({"doing": "simulating in MuJoCo", "share": done / total})

    on_progress({"doing": "building the model", "share": 0.0})
    run = simulate(shortened_design, progress=report_progress)
    return Download(page=report({design.name: run}, settle=settling_duration))


def _zip(name: str, files: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return a zip file with a folder of files, by the name of the zip file."""
    return {f"{name}.zip": zip_files({f"{name}/{file}": content for file, content in sorted(files.items())})}
