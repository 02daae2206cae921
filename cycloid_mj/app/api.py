"""What the page may ask for: each by name, a function from JSON values to JSON values.

Those in `AT_ONCE` are answered by the page's own process, those in `QUICK` by one beside it, those in `SLOWER` by
another, and long work by a third.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict
from functools import lru_cache
from typing import Any

from cycloid_mj.app import artifacts, requirement, scatter, solid, stressed, summary, turn
from cycloid_mj.app.controls import in_words, knobs, value_in_words
from cycloid_mj.app.drawing import section
from cycloid_mj.app.state import changed, design_of, differences, values_of
from cycloid_mj.base.errors import UsageError
from cycloid_mj.design import PRESETS, Design
from cycloid_mj.design.file import loads
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.sheet import load_of

LARGEST_PLAY = 1000.0

Content = Mapping[str, Any]


def draw(content: Content) -> dict[str, Any]:
    """Draw a design with changes to it: its values then, sliders, outlines, reasons why it cannot be built."""
    design = changed(design_of(content.get("design", {})), content.get("changes", {}))
    return shown(design, content)


def opened(content: Content) -> dict[str, Any]:
    """Read a design file, or take a preset."""
    text, preset = content.get("text"), content.get("preset")
    if isinstance(preset, str) and preset in PRESETS:
        design = PRESETS[preset]
    elif isinstance(text, str):
        design = loads(text, str(content.get("name", "the file"))[:80])
    else:
        raise UsageError(f"there is no preset {preset!r}: it is one of {', '.join(PRESETS)}")
    return shown(loaded(design), content)


def loaded(design: Design) -> Design:
    """Put the rated torque on a design without load."""
    load, _ = load_of(Reducer(design))
    return design.but(load={"torque": load})


def shown(design: Design, content: Content) -> dict[str, Any]:
    """Return all that follows from a design at once."""
    play = content.get("play", 1.0)
    if not isinstance(play, int | float) or not 1.0 <= play <= LARGEST_PLAY:
        raise UsageError(f"play {play!r}: give from 1 to {LARGEST_PLAY:g}")
    reducer = Reducer(design)
    return {
        "design": values_of(design),
        "name": design.name,
        "head": summary.geometry(reducer, content.get("asked")),
        "load_nm": abs(design.load.torque),
        "life_h": design.service.life,
        "knobs": [asdict(knob) for knob in knobs(design)],
        "section": section(reducer, float(play)),
        "errors": summary.errors(reducer),
    }


def _reducer(content: Content) -> Reducer:
    return _kept(json.dumps(content.get("design"), sort_keys=True))


@lru_cache(maxsize=1)  # the questions on one design come one after the other: each goes on from what is solved
def _kept(values: str) -> Reducer:
    return Reducer(design_of(json.loads(values)))


def statics(content: Content) -> dict[str, Any]:
    """Solve the figures by statics."""
    return summary.statics(_reducer(content), content.get("asked"))


def life(content: Content) -> dict[str, Any]:
    """Rate a design."""
    return summary.life(_reducer(content), content.get("asked"))


def checks(content: Content) -> dict[str, Any]:
    """Check a design."""
    return summary.checks(_reducer(content))


def ways(content: Content) -> dict[str, Any]:
    """Find what mends the checks of life, heat and strength."""
    return summary.ways(_reducer(content))


def compared(content: Content) -> dict[str, Any]:
    """List in words the values in which two designs differ."""
    rows = differences(content.get("a"), content.get("b"))
    words = ((key, in_words(key), value_in_words(key, a), value_in_words(key, b)) for key, a, b in rows)
    return {"rows": [{"key": key, "label": label, "a": a, "b": b} for key, label, a, b in words]}


def forces(content: Content) -> dict[str, Any]:
    """Solve the forces over a turn of the crank."""
    number = content.get("turn", 0)
    if type(number) is not int or not 0 <= number <= 1000:
        raise UsageError(f"turn {number!r}: give a whole number from 0 to 1000")
    return turn.forces(_reducer(content), number)


def error(content: Content) -> dict[str, Any]:
    """Solve the transmission error over a turn."""
    return turn.error(_reducer(content))


def shape(content: Content) -> dict[str, Any]:
    """Make the meshes of all parts where they stand."""
    return solid.assembly(_reducer(content))


AT_ONCE: Mapping[str, Callable[[Content], dict[str, Any]]] = {"draw": draw, "open": opened, "compare": compared}

QUICK: Mapping[str, Callable[[Content], dict[str, Any]]] = {"statics": statics, "forces": forces}

SLOWER: Mapping[str, Callable[[Content], dict[str, Any]]] = {
    "checks": checks,
    "life": life,
    "ways": ways,
    "error": error,
    "solid": shape,
}


def long_work(content: Content) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    """Return long work and what it is done with.

    Raises
    ------
    UsageError
        There is no such work.
    """
    kind, design = str(content.get("kind")), content.get("design")
    if kind == "size":
        requirement.requirement_of(content.get("form"))
        return requirement.size, (content.get("form"),)
    if kind in artifacts.FILES:
        return artifacts.make, (design, kind)
    works: Mapping[str, tuple[Callable[..., Any], tuple[Any, ...]]] = {
        "run": (artifacts.run, (design,)),
        "scatter": (scatter.samples, (design, content.get("spread_um"))),
        "stress": (stressed.stress, (design,)),
    }
    if kind not in works:
        raise UsageError(f"there is no work {kind!r}")
    return works[kind]
