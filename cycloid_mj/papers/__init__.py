"""Papers with which this project is compared: each is a separate package with an entry point of `GROUP`.

Nothing in `cycloid_mj` imports a paper by its name: a second one is a second package, with a `Paper` of its own.
"""

import re
import sys
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from functools import cache, partial
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, Any, TypeVar

from cycloid_mj.base.errors import warn
from cycloid_mj.reducer import Reducer

if TYPE_CHECKING:
    from cycloid_mj.base.result import Claim
    from cycloid_mj.comparison import Trial, Variation
    from cycloid_mj.design import Design
    from cycloid_mj.measure.published import Published
    from cycloid_mj.stress.findings import Reference
    from cycloid_mj.stress.study import StressStudy

    Varied = Mapping[Variation, Sequence[Trial]]

Answer = TypeVar("Answer")

GROUP = "cycloid_mj.papers"
"""Entry points of this group name the `Paper` of a package, as in ``hsieh2014 = "hsieh2014:PAPER"``."""


@dataclass(frozen=True, eq=False)
class RunsJudged:
    """Answer to a paper's question by the runs of a comparison.

    Attributes
    ----------
    summary, notes
        Sentences: the answer, and its reasons.
    content
        The same as JSON values.
    figures
        Name -> what draws it.
    """

    summary: Sequence[str] = ()
    notes: Sequence[str] = ()
    content: Mapping[str, Any] = field(default_factory=dict)
    figures: Mapping[str, Callable[[], Any]] = field(default_factory=dict)


@dataclass(frozen=True)
class Paper:
    """Contributions of a paper to the commands.

    Attributes
    ----------
    key
        Its name for programs, and of its command where there are several papers.
    source
        Author and year, as tables name it.
    command, examples
        Where the function behind ``cycloid-mj reproduce`` is, as ``module:function``; the examples of its help.
    torques
        Returns the paper's output torques of a design, if it is one of the paper's.
    stress_references
        Returns the paper's stress of a design's parts, by their names.
    judged_runs
        Answers the paper's question by the runs of a comparison, and by the same with one thing varied at a time.
    stress_claims
        Judges what the paper claims of stress by studies of several designs.
    """

    key: str
    source: str
    command: str
    examples: str
    torques: Callable[["Design"], "Sequence[Published]"] = lambda design: ()
    judged_runs: "Callable[[Sequence[Trial], Varied], RunsJudged] | None" = None
    stress_references: Callable[["Design"], "Mapping[str, Reference]"] = lambda design: {}
    stress_claims: Callable[["Sequence[StressStudy]"], "Sequence[Claim]"] = lambda studies: ()


@cache
def papers() -> tuple[Paper, ...]:
    """Load the `Paper` of each installed package with an entry point of `GROUP`, sorted by name of the entry point.

    A paper that cannot be loaded is left out with a warning.
    """
    papers_by_name: dict[str, Paper] = {}
    points = {entry_point.name: entry_point for entry_point in entry_points(group=GROUP)}
    for name in sorted(points):
        paper = _call_paper(name, "ignored", partial(_load_paper, points[name], papers_by_name))
        papers_by_name |= {paper.key: paper} if paper else {}
    return tuple(papers_by_name.values())


def published_torques(reducer: "Reducer") -> "list[Published]":
    """List the published output torques of a design, from all papers."""
    return [
        torque
        for _, torques in _results_of_papers(lambda paper: list(paper.torques(reducer.design)))
        for torque in torques
    ]


def judge_runs(trials: "Sequence[Trial]", varied: "Varied") -> RunsJudged:
    """Return the conclusions that the first paper with such an evaluation draws from the runs of a comparison.

    A paper is an installed package that compares this project with a publication. The conclusions are sentences, JSON
    values and diagrams; they are empty if no paper evaluates runs. `trials` are the runs with their measures. `varied`
    maps each variation of a parameter to the runs that were repeated with it.
    """
    for _, judgement in _results_of_papers(
        lambda paper: paper.judged_runs(trials, varied) if paper.judged_runs else None
    ):
        if judgement:
            return judgement
    return RunsJudged()


def stress_references(reducer: "Reducer") -> "dict[str, Reference]":
    """Collect the published stresses of a design's parts from all papers: name of the part -> reference."""
    return {
        part: reference
        for _, references in _results_of_papers(lambda paper: dict(paper.stress_references(reducer.design)))
        for part, reference in references.items()
    }


def stress_claims(studies: "Sequence[StressStudy]") -> "dict[str, Sequence[Claim]]":
    """Compare the claims of each paper about stress with studies of several designs: source -> evaluated claims."""
    return {paper.source: claims for paper, claims in _results_of_papers(lambda paper: paper.stress_claims(studies))}


def _results_of_papers(evaluate: Callable[[Paper], Answer]) -> Iterator[tuple[Paper, Answer]]:
    """Call a function, `evaluate`, with every paper; yield each paper with its result, unless the result is None.

    A paper is an installed package that compares this project with a publication. A paper that fails is skipped with a
    warning.
    """
    for paper in papers():
        result = _call_paper(paper.key, "passed over", partial(evaluate, paper))
        if result is not None:
            yield paper, result


def _call_paper(name: str, consequence: str, ask_paper: Callable[[], Answer]) -> Answer | None:
    """Call a function of the package of a paper; return its result, or None with a warning if it raises any error.

    `name` is the name of the paper, and `ask_paper` the function, without arguments. `consequence` states in the
    warning what happens to the paper, such as "ignored".
    """
    try:
        with redirect_stdout(sys.stderr):  # results alone go to stdout
            return ask_paper()
    except (Exception, SystemExit) as problem:
        reason = " ".join(f"{problem}".split()) or type(problem).__name__
        reason = f"it ends the program ({reason})" if isinstance(problem, SystemExit) else reason
        warn(f"paper {name}", [f"{consequence}: {reason}"])
        return None


def _load_paper(entry_point: EntryPoint, loaded_keys: Container[str]) -> Paper:
    """Load a paper from an entry point, and load its command as a check.

    `loaded_keys` are the keys of the papers loaded before. Raises an exception if the paper or its command cannot be
    loaded or has the wrong type, or if the key of the paper is not a valid command name or already exists.
    """
    try:
        paper = entry_point.load()
    except Exception as problem:
        raise LookupError(f"{entry_point.value} does not load: {problem}") from problem
    if not isinstance(paper, Paper):
        raise TypeError(f"{entry_point.value} is not a Paper but of type {type(paper).__name__}")
    if not isinstance(paper.key, str) or not re.fullmatch(r"[A-Za-z0-9][\w.-]*", paper.key):
        raise ValueError(f"its key {paper.key!r} is not a valid command name")
    if paper.key in loaded_keys:
        raise ValueError(f"its key {paper.key!r} is taken by another paper")
    if not isinstance(paper.command, str) or not re.fullmatch(r"[\w.]+:[\w.]+", paper.command):
        raise ValueError(f"its command {paper.command!r} is not written as module:function")
    try:
        command = EntryPoint(paper.key, paper.command, GROUP).load()
    except Exception as problem:
        raise LookupError(f"its command {paper.command!r} does not load: {problem}") from problem
    if not callable(command):
        raise TypeError(f"its command {paper.command!r} is not a function")
    return paper
