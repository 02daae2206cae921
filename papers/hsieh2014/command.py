"""``cycloid-mj reproduce``: the whole paper again, figure by figure and claim by claim, as one HTML page."""

import json as js
from collections.abc import Sequence
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.whole import write_whole
from cycloid_mj.cli.flags import ForceFlag, JsonFlag, QuietFlag
from cycloid_mj.cli.outfile import folder
from cycloid_mj.cli.terminal import finite, say, say_json, say_table, tell, with_warnings

if TYPE_CHECKING:
    from hsieh2014.plan import Plan
    from hsieh2014.run import Report
    from hsieh2014.stage import Stage, StageRun

OUT = "runs/reproduce"
PAGE, RESULT = "reproduce.html", "reproduce.json"
FORMATS = ("png", "svg")
FAILURE = 1
HEADER = ("claim", "condition", "the paper", "ours", "num. error", "verdict")
SECONDS_BETWEEN_LINES = 5.0

ReproduceQuickFlag = Annotated[
    bool,
    Parameter(
        name="--quick",
        help="Fewer crank turns, no ramp, coarser grids: the same pages, of 12 independent starts as well, in about "
        "3 minutes on two free cores, not 20.",
    ),
]
OutFlag = Annotated[
    str | None,
    Parameter(
        metavar="DIR",
        help=f"Folder of {PAGE}, {RESULT}, figures and logs, made if there is none. Logs in it that fit are read in "
        f"place of running. Default: {OUT}.",
    ),
]
AuthorsFlag = Annotated[
    bool,
    Parameter(
        name="--as-the-authors",
        help='Run with the contact that the authors\' motion solver may have had (contact.law = "impact", then facets) '
        "beside ours: Figs 6, 8, 9, 12-16 and the torque, and which change brings which feature. This stage alone, "
        "authors, unless --only names others as well.",
    ),
]
FreshFlag = Annotated[bool, Parameter(help="Run everything anew, and replace logs that fit.")]
OnlyFlag = Annotated[
    tuple[str, ...],
    Parameter(
        name="--only",
        metavar="STAGE",
        consume_multiple=True,
        help="Stages to run: geometry, equal, input, gear_speed, q_path, q_velocity, pin_1, vibration, stress, torque. "
        "authors. Default: all but authors.",
    ),
]


def reproduce(
    *,
    quick: ReproduceQuickFlag = False,
    out: OutFlag = None,
    only: OnlyFlag = (),
    as_the_authors: AuthorsFlag = False,
    fresh: FreshFlag = False,
    force: ForceFlag = False,
    json: JsonFlag = False,
    quiet: QuietFlag = False,
) -> int:
    """Run the whole paper again (Hsieh 2014) and judge its claims.

    Geometry, kinematics, dynamics, stress and torque of both designs, at the
    paper's sampling of one degree. One HTML page that needs no network shows
    every figure, a table of claims, each at the paper's own condition (its
    number, ours, the numerical error, the verdict, what decides it, and ours
    at the rated load beside), and the paper's errata.
    Figures (png, svg) and all numbers (JSON) lie beside it. Nothing is tuned
    to agree; both designs differ in the ring alone.

    A stage that breaks is told on the page, the others still appear, and the
    exit code is 1. Stress needs the extra `fem`.
    """
    from hsieh2014.errata import errata
    from hsieh2014.logs import Logs
    from hsieh2014.plan import FULL, QUICK
    from hsieh2014.run import AUTHORS, STEPS, run_steps

    keys = [step.key for step in (*STEPS, AUTHORS)]
    only = (*only, AUTHORS.key) if as_the_authors else only
    if unknown := next((key for key in only if key not in keys), None):
        raise UsageError(f"no stage {unknown!r}; there are {', '.join(keys)}")
    into = folder(out or OUT, "the report", (PAGE, RESULT), force)
    logs = Logs(folder(str(into / "logs"), "the logs", (), force), fresh, quiet)
    folder(str(into / "figures"), "the figures", (), force)
    start = monotonic()
    plan = QUICK if quick else FULL
    stages = run_steps(plan, logs, _reporter(quiet), only)
    content = with_warnings(
        {
            "quick": quick,
            "stages": [stage.as_json() for stage in stages],
            "claims": [claim.as_json() for stage in stages for claim in stage.result.claims],
            "errata": errata(),
        }
    )
    page = _written(stages, content, into, plan, monotonic() - start)
    _report(stages, content, page, json)
    return FAILURE if any(stage.error for stage in stages) else 0


def _reporter(quiet: bool) -> "Report":
    """Return what tells each stage as it begins, and now and then how far it is."""
    last = [0.0]

    def report(step: "Stage", text: str, left: float) -> None:
        now = monotonic()
        if quiet or (text and now - last[0] < SECONDS_BETWEEN_LINES):
            return
        last[0] = now
        tell(f"{step.heading}{f': {text}' if text else ''}; about {left:.0f} s left in all")

    return report


def _written(stages: "Sequence[StageRun]", content: dict[str, Any], into: Path, plan: "Plan", seconds: float) -> Path:
    """Write the figures, the JSON file and the page; give the page's path."""
    from cycloid_mj.plots.save import pictures
    from hsieh2014.page import reproduction_page
    from hsieh2014.plan import LOGGED, main_runs

    drawings = {plate.name: plate.drawing for stage in stages for plate in stage.result.plates}
    figures = pictures(drawings, into / "figures", FORMATS)
    smaller = {
        name: min((figures[into / "figures" / f"{name}.{form}"] for form in FORMATS), key=len) for name in drawings
    }
    result = js.dumps(finite(content), indent=1, ensure_ascii=False) + "\n"
    sample = 1.0 / main_runs(plan)[0].settings.log_rate
    about = (
        "Hsieh, Dynamics Analysis of Cycloidal Speed Reducers With Pinwheel and Nonpinwheel Designs (J. Mech. Des., "
        "2014). Captions are in our own words; the paper's plots are not shown, its stated values are.",
        f"cycloid-mj reproduce{' --quick' if plan.quick else ''}, {seconds:.0f} s. Crank at 1640 rpm, every figure one "
        f"settled turn at one degree ({sample * LOGGED:.6g} s), from runs at a step of {1e6 * sample / plan.steps:.4g} "
        "us.",
    )
    page = reproduction_page(stages, content["errata"], smaller, about)
    write_whole({**figures, into / RESULT: result.encode(), into / PAGE: page.encode()})
    return into / PAGE


def _report(stages: "Sequence[StageRun]", content: dict[str, Any], page: Path, json: bool) -> None:
    from hsieh2014.page import error_words

    if json:
        say_json(content | {"page": str(page)})
    else:
        claims = [claim for stage in stages for claim in stage.result.claims]
        rows = [
            (
                f"{claim.figure}, {claim.design}: {claim.claim}",
                claim.condition.words,
                claim.stated.text,
                claim.found.text,
                error_words(claim),
                claim.verdict,
            )
            for claim in claims
        ]
        if rows:
            say_table("the paper's claims (Hsieh 2014); what decides each is on the page", HEADER, rows)
        say(f"page: {page}")
    for stage in stages:
        if stage.error:
            tell(f"error: stage {stage.step.key} ({stage.step.paper}) broke: {stage.error}")
