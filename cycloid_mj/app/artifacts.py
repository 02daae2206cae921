"""Artifacts of a design that the page offers as downloads: design file, CAD files, models, data sheet, run report."""

import json
import math
from collections.abc import Callable, Mapping
from typing import Any

from cycloid_mj.app.jobs import Download
from cycloid_mj.app.state import design_of
from cycloid_mj.base.atomic_write import zip_files
from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.result import plain
from cycloid_mj.design import Design, dump
from cycloid_mj.parts.export import CHORD_ERROR, assembly_step, bill, bill_csv, export, plate, threemf_bytes
from cycloid_mj.reducer import Reducer

MIN_CRANK_TURNS = 1.25
"""Crank turns of a run after the start has settled."""

Progress = Callable[[Any], None]


def design_file(design: Design) -> dict[str, bytes]:
    """Return the design file (TOML)."""
    return {f"{design.name}.toml": dump(design).encode()}


def model(design: Design) -> dict[str, bytes]:
    """Return a zip file of a model folder for stock MuJoCo."""
    from cycloid_mj.dynamics.mjcf.folder import model_files

    return _zip(f"{design.name}-mjcf", model_files(Reducer(design)))


def data_sheet(design: Design) -> dict[str, bytes]:
    """Return the data sheet as PDF."""
    from cycloid_mj.life.datasheet import datasheet
    from cycloid_mj.plots.datasheet import datasheet_pages
    from cycloid_mj.plots.save import document

    return {f"{design.name}-datasheet.pdf": document(datasheet_pages(datasheet(Reducer(design))))}


def meshes(design: Design) -> dict[str, bytes]:
    """Return a zip file with an STL mesh of each part."""
    return _zip(f"{design.name}-stl", export(design, "stl").files)


def outlines(design: Design) -> dict[str, bytes]:
    """Return a zip file with the outlines of each part as DXF."""
    return _zip(f"{design.name}-dxf", export(design, "dxf").files)


def assembly(design: Design) -> dict[str, bytes]:
    """Return the assembly as a STEP file."""
    return {f"{design.name}.step": assembly_step(Reducer(design))}


def print_plate(design: Design) -> dict[str, bytes]:
    """Return a zip file with a print plate (3MF) and the bill of materials (CSV)."""
    reducer = Reducer(design)
    files = {"plate.3mf": threemf_bytes(plate(reducer, CHORD_ERROR)), "bom.csv": bill_csv(bill(reducer))}
    return _zip(f"{design.name}-print", files)


def joint(design: Design) -> dict[str, bytes]:
    """Return a zip file with the joint for a robot model: the files of ``cycloid-mj reduce`` without its page."""
    from cycloid_mj.robot.files import choose_scenes, joint_files
    from cycloid_mj.robot.identification import reduce

    reduced = reduce(design)
    figures = json.dumps(plain(reduced.as_json()), indent=1)
    files = joint_files(reduced, *choose_scenes(reduced)) | {"reducer.json": figures.encode()}
    return _zip(f"{design.name}-joint", files)


FILES: Mapping[str, tuple[str, Callable[[Design], dict[str, bytes]]]] = {
    "toml": ("Design file", design_file),
    "datasheet": ("Data sheet (PDF)", data_sheet),
    "step": ("Assembly (STEP)", assembly),
    "3mf": ("Print plate (3MF)", print_plate),
    "stl": ("Meshes (STL)", meshes),
    "dxf": ("Outlines (DXF)", outlines),
    "mjcf": ("MuJoCo model (MJCF)", model),
    "joint": ("Joint for a robot", joint),
}
"""Kind -> text of its button, and the function that creates the files by name."""


def make(on_progress: Progress, values: Any, kind: str) -> Download:
    """Create the files of a kind of `FILES` for a design of the page."""
    on_progress({"doing": "creating the file"})
    return Download(files=FILES[kind][1](design_of(values)))


def run(on_progress: Progress, values: Any) -> Download:
    """Simulate a design in MuJoCo at full speed under its load, and return the report of the run as a page.

    Raises
    ------
    CycloidError
        The run failed, or the crank speed is zero.
    """
    from cycloid_mj.comparison import settling_time
    from cycloid_mj.dynamics.run import simulate
    from cycloid_mj.report import report

    design = design_of(values)
    if design.drive.speed == 0.0:
        raise DesignError("the crank speed is zero: set a speed to simulate the drive")
    started = design.but(drive={"ramp": 0.0})
    settled, turn = settling_time(Reducer(started)), 2.0 * math.pi / abs(design.drive.speed)
    short = started.steady(settled, max(MIN_CRANK_TURNS, settled / turn))  # at most half of a hold is not judged

    def report_progress(done: int, total: int) -> None:
        on_progress({"doing": "simulating in MuJoCo", "share": done / total})

    on_progress({"doing": "building the model", "share": 0.0})
    run = simulate(short, progress=report_progress)
    return Download(page=report({design.name: run}, settle=settled))


def _zip(name: str, files: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return a zip file with a folder of files, by the name of the zip file."""
    return {f"{name}.zip": zip_files({f"{name}/{file}": content for file, content in sorted(files.items())})}
