"""The papers that this project is held against: each a package of its own, found by the entry points of `GROUP`.

Nothing in `cycloid_mj` imports a paper by its name: a second one is a second package, with a `Paper` of its own.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING

from cycloid_mj.errors import warn

if TYPE_CHECKING:
    from cycloid_mj.design import Design
    from cycloid_mj.measure.published import Published
    from cycloid_mj.result import Claim
    from cycloid_mj.stress.findings import Reference
    from cycloid_mj.stress.study import StressStudy

GROUP = "cycloid_mj.papers"
"""Entry points of this group name the `Paper` of a package, as in ``hsieh2014 = "hsieh2014:PAPER"``."""


@dataclass(frozen=True)
class Vibration:
    """Where a paper finds that a pin design fluctuates more than a nonpin one: its `source`, and quantity -> figure."""

    source: str = "none is installed"
    figures: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Paper:
    """What a paper adds to the commands.

    Attributes
    ----------
    key
        Its name for programs, and of its command where there are several papers.
    source
        Author and year, as tables name it.
    command, examples
        Where the function behind ``cycloid-mj reproduce`` is, as ``module:function``; the examples of its help.
    torques
        Gives the output torques that the paper has for a design, if it is one of the paper's.
    stress_references
        Gives what the paper has on the stress of a design's parts, by their names.
    vibration
        Where it ranks the vibration of pin and nonpin designs, if it does.
    stress_claims
        Judges what the paper claims of stress by studies of several designs.
    """

    key: str
    source: str
    command: str
    examples: str
    torques: Callable[["Design"], "Sequence[Published]"] = lambda design: ()
    vibration: Vibration | None = None
    stress_references: Callable[["Design"], "Mapping[str, Reference]"] = lambda design: {}
    stress_claims: Callable[["Sequence[StressStudy]"], "Sequence[Claim]"] = lambda studies: ()


@cache
def papers() -> tuple[Paper, ...]:
    """Give the papers that are installed, by name; one that does not load is left out with a warning."""
    points = {point.name: point for point in entry_points(group=GROUP)}
    return tuple(paper for name in sorted(points) if (paper := _loaded(points[name])))


def published_torques(design: "Design") -> "list[Published]":
    """Give the output torques that the papers have for a design."""
    return [one for paper in papers() for one in paper.torques(design)]


def vibration() -> Vibration:
    """Give where a paper ranks the vibration of pin and nonpin designs; nothing where none does."""
    return next((paper.vibration for paper in papers() if paper.vibration), Vibration())


def stress_references(design: "Design") -> "dict[str, Reference]":
    """Give what the papers have on the stress of a design's parts, by their names."""
    return {part: reference for paper in papers() for part, reference in paper.stress_references(design).items()}


def _loaded(point: EntryPoint) -> Paper | None:
    try:
        paper = point.load()
    except Exception as problem:  # whatever is wrong with a paper, the other commands shall run
        warn(f"paper {point.name}", [f"left out, since {point.value} does not load: {problem}"])
        return None
    assert isinstance(paper, Paper)
    return paper
