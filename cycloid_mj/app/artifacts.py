"""What the page has made of a design: files, pages, a run, each as names and bytes to be fetched."""

import json
import math
from collections.abc import Callable, Mapping
from typing import Any

from cycloid_mj.app.jobs import Made
from cycloid_mj.app.state import design_of
from cycloid_mj.base.atomic_write import zipped
from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.result import plain
from cycloid_mj.design import Design, dump
from cycloid_mj.parts.export import CHORD_ERROR, assembly_step, bill, bill_csv, export, plate, threemf_bytes
from cycloid_mj.reducer import Reducer

TURNS = 1.25
"""Crank turns of a run after it has settled, at least."""

Told = Callable[[Any], None]


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


def meshes(design: Design) -> dict[str, bytes]:
    """Pack a mesh of each part."""
    return _packed(f"{design.name}-stl", export(design, "stl").files)


def outlines(design: Design) -> dict[str, bytes]:
    """Pack the outlines of each part as DXF."""
    return _packed(f"{design.name}-dxf", export(design, "dxf").files)


def assembly(design: Design) -> dict[str, bytes]:
    """Write the reducer put together as one STEP file."""
    return {f"{design.name}.step": assembly_step(Reducer(design))}


def print_plate(design: Design) -> dict[str, bytes]:
    """Pack the plate for a printer as 3MF, with the bill of materials."""
    reducer = Reducer(design)
    files = {"plate.3mf": threemf_bytes(plate(reducer, CHORD_ERROR)), "bom.csv": bill_csv(bill(reducer))}
    return _packed(f"{design.name}-print", files)


def joint(design: Design) -> dict[str, bytes]:
    """Pack the joint for a robot's model: the files of ``cycloid-mj reduce``, but for its page."""
    from cycloid_mj.robot.files import joint_files, scenes
    from cycloid_mj.robot.measured import reduce

    reduced = reduce(design)
    figures = json.dumps(plain(reduced.as_json()), indent=1)
    files = joint_files(reduced, *scenes(reduced)) | {"reducer.json": figures.encode()}
    return _packed(f"{design.name}-joint", files)


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
"""Kind -> what its button says, and what makes it."""


def make(told: Told, values: Any, kind: str) -> Made:
    """Make one of `FILES` of the page's design."""
    told({"doing": "being made"})
    return Made(files=FILES[kind][1](design_of(values)))


def run(told: Told, values: Any) -> Made:
    """Run a design at full speed under its load, and give the review of the run as a page.

    Raises
    ------
    CycloidError
        The run went wrong, or the crank stands still.
    """
    from cycloid_mj.comparison import settling
    from cycloid_mj.dynamics.run import simulate
    from cycloid_mj.report import report

    design = design_of(values)
    if design.drive.speed == 0.0:
        raise DesignError("the crank stands still: give it a speed")
    started = design.but(drive={"ramp": 0.0})
    settled, turn = settling(Reducer(started)), 2.0 * math.pi / abs(design.drive.speed)
    short = started.steady(settled, max(TURNS, settled / turn))  # no more than half of a hold is left out

    def note(done: int, whole: int) -> None:
        told({"doing": "running in MuJoCo", "share": done / whole})

    told({"doing": "building the model", "share": 0.0})
    run = simulate(short, progress=note)
    return Made(page=report({design.name: run}, settle=settled))


def _packed(name: str, files: Mapping[str, bytes]) -> dict[str, bytes]:
    return {f"{name}.zip": zipped({f"{name}/{place}": content for place, content in sorted(files.items())})}
