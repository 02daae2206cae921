"""Requests that the page may send: functions from JSON values to JSON values, by name.

`AT_ONCE` are answered by the page's own process, `QUICK` and `SLOWER` by a worker process each, and jobs by others.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict
from functools import lru_cache
from typing import Any, NamedTuple

from cycloid_mj.app import artifacts, drive, monte_carlo, part_stress, requirement, solid, summary, turn
from cycloid_mj.app.controls import controls, find_controls, key_in_words, value_in_words
from cycloid_mj.app.drawing import section
from cycloid_mj.app.limits import REQUESTS
from cycloid_mj.app.state import apply_changes, at_load, changed_values, differences, parse_design
from cycloid_mj.base.errors import UsageError
from cycloid_mj.design import PRESETS, Design
from cycloid_mj.design.file import loads
from cycloid_mj.explore.tolerance_zones import has_tolerances
from cycloid_mj.reducer import Reducer, reducer_of
from cycloid_mj.statics.sheet import load_of

Content = Mapping[str, Any]

MAX_NAME_LENGTH = 80
"""Characters of a file's name in messages."""


def draw(content: Content) -> dict[str, Any]:
    """Apply ``changes`` to a ``design``, and return everything that is shown at once (`view`)."""
    design = apply_changes(parse_design(content.get("design", {})), content.get("changes", {}))
    return view(design, content)


def open_design(content: Content) -> dict[str, Any]:
    """Open a design from a ``preset`` or the ``text`` of a design file, and return its `view`."""
    return view(with_load(_design_to_open(content)), content)


def _design_to_open(content: Content) -> Design:
    """Return the design that a request opens: the preset with the name ``preset``, or that of a design file.

    `content` has the name ``preset``, or the text ``text`` and the name ``name`` of the file.

    Raises
    ------
    UsageError
        There is no such preset, and no text.
    DesignError
        The text is not a valid design file.
    """
    text, preset = content.get("text"), content.get("preset")
    if isinstance(preset, str) and preset in PRESETS:
        return PRESETS[preset]
    if isinstance(text, str):
        return loads(text, str(content.get("name", "the file"))[:MAX_NAME_LENGTH])
    raise UsageError(f"unknown preset {preset!r}: choose one of {', '.join(PRESETS)}")


def with_load(design: Design) -> Design:
    """Return a design whose load and nominal torque are equal: its load, or without one its nominal torque."""
    reducer = reducer_of(design)
    return at_load(reducer).design.but(load={"torque": load_of(reducer)[0]})


def view(design: Design, content: Content) -> dict[str, Any]:
    """Return all that the page shows of a design without solving for static equilibrium, as JSON values.

    The keys are ``design`` (values that differ from the preset), ``name``, ``layout``, ``toleranced`` (whether it has
    tolerances), ``files`` (kinds of downloads), ``head`` (`geometry_figures`), ``load_nm`` (magnitude of the torque on
    the output), ``controls`` (the input controls), ``section`` (the cross-section) and ``errors`` (failed checks).

    Parameters
    ----------
    content
        Request of the page: ``play`` is the factor by which the drawn clearances are magnified (default 1),
        ``required`` are the values in the start form by field name, with which the quantities of the header are
        compared.
    """
    magnification = content.get("play", 1.0)
    if not isinstance(magnification, int | float) or not 1.0 <= magnification <= REQUESTS.magnification:
        raise UsageError(
            f"the factor by which the drawing magnifies clearances is {magnification!r}, which is out of range: choose "
            f"a number from 1 to {REQUESTS.magnification:g}"
        )
    reducer = reducer_of(design)
    return {
        "design": changed_values(design),
        "name": design.name,
        "layout": design.layout,
        "toleranced": has_tolerances(reducer),
        "files": [kind for kind in artifacts.FILES if kind not in artifacts.LEFT_OUT[design.layout]],
        "head": summary.geometry_figures(reducer, content.get("required")),
        "load_nm": abs(design.load.torque),
        "controls": [asdict(control) for control in controls(design)],
        "section": section(reducer, float(magnification)),
        "errors": summary.errors(reducer),
    }


def _reducer(content: Content) -> Reducer:
    return _cached_reducer(json.dumps(content.get("design"), sort_keys=True))


@lru_cache(maxsize=1)  # consecutive requests are for the same design: each reuses what has been solved
def _cached_reducer(values: str) -> Reducer:
    return reducer_of(parse_design(json.loads(values)))


def statics(content: Content) -> dict[str, Any]:
    """Return the quantities of the static equilibrium of a design, as JSON values."""
    return summary.statics(_reducer(content), content.get("required"))


def life(content: Content) -> dict[str, Any]:
    """Return the rating, with the size of the drive with covers for a motor of the ``options``."""
    options = drive.parse_options(content.get("options"))
    return summary.life(_reducer(content), content.get("required"), options.motor)


def checks(content: Content) -> dict[str, Any]:
    """Return the failed checks and the warnings of the design in the request `content`."""
    return summary.checks(_reducer(content))


def remedies(content: Content) -> dict[str, Any]:
    """Return changes of the design that resolve a warning of life, heat or strength, ``check`` in the request."""
    return summary.remedies(_reducer(content), str(content.get("check", "")))


def compare(content: Content) -> dict[str, Any]:
    """Return the values in which two designs differ, as ``rows``; the request `content` has designs ``a`` and ``b``.

    Each row has the ``key`` of the design file, its ``label`` in words, and the values ``a`` and ``b`` as text.
    """
    rows = differences(content.get("a"), content.get("b"))
    return {
        "rows": [
            {"key": key, "label": key_in_words(key), "a": value_in_words(key, a), "b": value_in_words(key, b)}
            for key, a, b in rows
        ]
    }


def find(content: Content) -> dict[str, Any]:
    """Return controls of the parameters that a ``text`` matches and the page does not show already."""
    matches = find_controls(parse_design(content.get("design", {})), str(content.get("text", "")))
    return {"controls": [asdict(control) for control in matches[: REQUESTS.matches]]}


def forces(content: Content) -> dict[str, Any]:
    """Return the forces over the crank turn with the number ``turn``."""
    turn_number = content.get("turn", 0)
    if type(turn_number) is not int or not 0 <= turn_number <= REQUESTS.turn:
        raise UsageError(f"crank turn {turn_number!r} is not allowed: choose a whole number from 0 to {REQUESTS.turn}")
    return turn.forces(_reducer(content), turn_number)


def error(content: Content) -> dict[str, Any]:
    """Return the transmission error over a crank turn and its orders."""
    return turn.error(_reducer(content))


def shape(content: Content) -> dict[str, Any]:
    """Return the meshes of the drive with covers for a motor of the ``options``."""
    return solid.assembly_meshes(_reducer(content), drive.parse_options(content.get("options")))


def build(content: Content) -> dict[str, Any]:
    """Return size, bill and order of assembly of the drive with covers for a motor of the ``options``."""
    return drive.describe_drive(_reducer(content), drive.parse_options(content.get("options")))


AT_ONCE: Mapping[str, Callable[[Content], dict[str, Any]]] = {
    "draw": draw,
    "open": open_design,
    "compare": compare,
    "find": find,
}

QUICK: Mapping[str, Callable[[Content], dict[str, Any]]] = {"statics": statics, "forces": forces}

SLOWER: Mapping[str, Callable[[Content], dict[str, Any]]] = {
    "checks": checks,
    "life": life,
    "remedies": remedies,
    "error": error,
    "solid": shape,
    "build": build,
}


class JobKind(NamedTuple):
    """A job: its queue (``studies``, ``files`` or ``at once``), what it computes in words, function and arguments."""

    queue: str
    name: str
    work: Callable[..., Any]
    args: tuple[Any, ...]


def create_job(content: Content) -> JobKind:
    """Return the background job that a request of the page describes: its queue, name, function and arguments.

    `content` is the request. ``kind`` in it selects the job; ``design`` and the other keys are its arguments.

    Raises
    ------
    UsageError
        There is no such job, or its arguments are out of range.
    """
    kind, design = str(content.get("kind")), content.get("design")
    if kind == "size":
        requirement.parse_form(content.get("form"))
        return JobKind("studies", "the search for drives", requirement.size, (content.get("form"),))
    if kind in artifacts.FILES or kind == artifacts.WHOLE_DRIVE:
        options = drive.parse_options(content.get("options"))
        queue = "at once" if kind == artifacts.DESIGN_FILE else "files"
        name = "the files of the drive" if kind == artifacts.WHOLE_DRIVE else artifacts.FILES[kind][0]
        return JobKind(queue, name, artifacts.create_files, (design, kind, options))
    jobs: Mapping[str, tuple[str, Callable[..., Any], tuple[Any, ...]]] = {
        "run": ("the simulation", artifacts.simulate_run, (design,)),
        "scatter": ("tolerances", monte_carlo.study_tolerances, (design, content.get("spread_um"))),
        "stress": ("stresses", part_stress.stress, (design,)),
    }
    if kind not in jobs:
        job_kinds = "size", artifacts.WHOLE_DRIVE, *artifacts.FILES, *jobs
        raise UsageError(f"unknown job {kind!r}: choose one of {', '.join(job_kinds)}")
    return JobKind("studies", *jobs[kind])
