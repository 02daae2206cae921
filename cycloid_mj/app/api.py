"""Questions that the page may ask: functions from JSON values to JSON values, by name.

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
from cycloid_mj.app.state import apply_changes, design_of, differences, values_of
from cycloid_mj.base.errors import UsageError
from cycloid_mj.design import Design, presets_for
from cycloid_mj.design.file import loads
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.sheet import load_of

MAX_MAGNIFICATION = 1000.0
"""Largest factor by which the page draws clearances."""

MAX_TURN = 1000
"""Highest number of a crank turn whose forces the page requests."""

MAX_FOUND = 30
"""Most parameters that a search shows."""

Content = Mapping[str, Any]


def draw(content: Content) -> dict[str, Any]:
    """Apply ``changes`` to a ``design``, and return everything that is shown at once (`view`)."""
    design = apply_changes(design_of(content.get("design", {})), content.get("changes", {}))
    return view(design, content)


def open_design(content: Content) -> dict[str, Any]:
    """Return the `view` of a ``preset`` or of the ``text`` of a design file."""
    text, preset = content.get("text"), content.get("preset")
    presets = presets_for("app")
    if isinstance(preset, str) and preset in presets:
        design = presets[preset]
    elif isinstance(text, str):
        design = loads(text, str(content.get("name", "the file"))[:80])
    else:
        raise UsageError(f"unknown preset {preset!r}: choose one of {', '.join(presets)}")
    return view(with_load(design), content)


def with_load(design: Design) -> Design:
    """Return a design under its load; without one under its nominal torque."""
    load, _ = load_of(Reducer(design))
    return design.but(load={"torque": load})


def view(design: Design, content: Content) -> dict[str, Any]:
    """Return everything of a design that needs no solution: values, header, controls, cross-section, errors.

    Parameters
    ----------
    content
        ``play`` is the magnification of clearances, ``asked`` the requirements that the header is judged by.
    """
    factor = content.get("play", 1.0)
    if not isinstance(factor, int | float) or not 1.0 <= factor <= MAX_MAGNIFICATION:
        raise UsageError(
            f"the magnification of the clearances is {factor!r}, which is out of range: choose a number from 1 to "
            f"{MAX_MAGNIFICATION:g}"
        )
    reducer = Reducer(design)
    return {
        "design": values_of(design),
        "name": design.name,
        "head": summary.geometry(reducer, content.get("asked")),
        "load_nm": abs(design.load.torque),
        "controls": [asdict(control) for control in controls(design)],
        "section": section(reducer, float(factor)),
        "errors": summary.errors(reducer),
    }


def _reducer(content: Content) -> Reducer:
    return _cached_reducer(json.dumps(content.get("design"), sort_keys=True))


@lru_cache(maxsize=1)  # consecutive questions are on the same design: each reuses what has been solved
def _cached_reducer(values: str) -> Reducer:
    return Reducer(design_of(json.loads(values)))


def statics(content: Content) -> dict[str, Any]:
    """Return the figures of the static equilibrium."""
    return summary.statics(_reducer(content), content.get("asked"))


def life(content: Content) -> dict[str, Any]:
    """Return the rating, with the size of the drive with covers for a motor of the ``options``."""
    options = drive.build_options(content.get("options"))
    return summary.life(_reducer(content), content.get("asked"), options.motor)


def checks(content: Content) -> dict[str, Any]:
    """Return failures and warnings."""
    return summary.checks(_reducer(content))


def remedies(content: Content) -> dict[str, Any]:
    """Return changes that resolve the warnings of life, heat and strength."""
    return summary.remedies(_reducer(content))


def compare(content: Content) -> dict[str, Any]:
    """Return the values in which the designs ``a`` and ``b`` differ, in words."""
    rows = differences(content.get("a"), content.get("b"))
    return {
        "rows": [
            {"key": key, "label": key_in_words(key), "a": value_in_words(key, a), "b": value_in_words(key, b)}
            for key, a, b in rows
        ]
    }


def find(content: Content) -> dict[str, Any]:
    """Return controls of the parameters that a ``text`` matches and the page does not show already."""
    found = find_controls(design_of(content.get("design", {})), str(content.get("text", "")))
    return {"controls": [asdict(control) for control in found[:MAX_FOUND]]}


def forces(content: Content) -> dict[str, Any]:
    """Return the forces over the crank turn with the number ``turn``."""
    number = content.get("turn", 0)
    if type(number) is not int or not 0 <= number <= MAX_TURN:
        raise UsageError(f"the crank turn is {number!r}, which is out of range: choose an integer from 0 to {MAX_TURN}")
    return turn.forces(_reducer(content), number)


def error(content: Content) -> dict[str, Any]:
    """Return the transmission error over a crank turn and its orders."""
    return turn.error(_reducer(content))


def shape(content: Content) -> dict[str, Any]:
    """Return the meshes of the drive with covers for a motor of the ``options``."""
    return solid.assembly(_reducer(content), drive.build_options(content.get("options")))


def build(content: Content) -> dict[str, Any]:
    """Return size, bill and order of assembly of the drive with covers for a motor of the ``options``."""
    return drive.describe_drive(_reducer(content), drive.build_options(content.get("options")))


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


def job_of(content: Content) -> JobKind:
    """Return the job of a question.

    Raises
    ------
    UsageError
        There is no such job, or its arguments are out of range.
    """
    kind, design = str(content.get("kind")), content.get("design")
    if kind == "size":
        requirement.requirement_of(content.get("form"))
        return JobKind("studies", "the search for drives", requirement.size, (content.get("form"),))
    if kind in artifacts.FILES or kind == artifacts.WHOLE_DRIVE:
        options = drive.build_options(content.get("options"))
        queue = "at once" if kind == artifacts.DESIGN_FILE else "files"
        name = "the files of the drive" if kind == artifacts.WHOLE_DRIVE else artifacts.FILES[kind][0]
        return JobKind(queue, name, artifacts.make, (design, kind, options))
    jobs: Mapping[str, tuple[str, Callable[..., Any], tuple[Any, ...]]] = {
        "run": ("the simulation", artifacts.run, (design,)),
        "scatter": ("tolerances", monte_carlo.samples, (design, content.get("spread_um"))),
        "stress": ("stresses", part_stress.stress, (design,)),
    }
    if kind not in jobs:
        raise UsageError(f"unknown job {kind!r}: choose one of {', '.join((*artifacts.FILES, *jobs))}")
    return JobKind("studies", *jobs[kind])
