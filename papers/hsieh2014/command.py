"""``cycloid-mj reproduce``: reproduce the paper figure by figure and claim by claim, as one HTML page."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.base.result import Table, Verdict
from cycloid_mj.cli.delivery import Destination, claim_destination, deliver
from cycloid_mj.cli.flags import FLAT, Delivery, out_flag
from cycloid_mj.cli.outfile import claim_folder
from cycloid_mj.cli.terminal import tell

if TYPE_CHECKING:
    from cycloid_mj.base.frame import Frame
    from cycloid_mj.base.result import Claim
    from hsieh2014.plan import Plan
    from hsieh2014.run import Report
    from hsieh2014.stage import Stage, StageRun

OUT = "runs/reproduce"
STEM, FIGURES, LOGS = "reproduce", "figures", "logs"
FORMATS = ("png", "svg")
HEADER = ("claim", "condition", "the paper", "ours", "num. error", "verdict")
COLUMNS = (
    *("key", "figure", "part", "design", "load_nm", "speed_rpm", "claim", "stated", "stated_value", "unit"),
    *("ours", "ours_value", "ours_lowest", "ours_highest", "numerical_error", "error_unit"),
    *("verdict", "p", "decided_by"),
)
SECONDS_BETWEEN_LINES = 5.0  # of progress
SOLVERS = {"planar": "the planar solver", "mujoco": "MuJoCo"}

ReproduceQuickFlag = Annotated[
    bool,
    Parameter(
        name="--quick",
        help="Use fewer crank turns, no ramp and coarser grids, with 12 independent starts as well: about 3 minutes "
        "on two idle cores instead of 20.",
    ),
]
AuthorsFlag = Annotated[
    bool,
    Parameter(
        name="--as-the-authors",
        help='Compare our contact with that of the authors\' motion solver, as far as known (contact.law = "impact", '
        "then facets): Figs 6, 8, 9, 12-16 and the torque, and which change causes which feature. Runs only the stage "
        "authors, unless --only names others.",
    ),
]
SolverFlag = Annotated[
    Literal["planar", "mujoco"],
    Parameter(
        help="Solver of the independent starts and of the variations: planar (fast, compiled) or mujoco. The figures "
        "always use MuJoCo. Default: planar."
    ),
]
FreshFlag = Annotated[bool, Parameter(help="Ignore existing logs and simulate everything again.")]
OnlyFlag = Annotated[
    tuple[str, ...],
    Parameter(
        name="--only",
        metavar="STAGE",
        consume_multiple=True,
        help="Stages to run: geometry, equal, input, gear_speed, q_path, q_velocity, pin_1, vibration, stress, torque, "
        "authors. Default: all but authors.",
    ),
]


@dataclass(frozen=True, kw_only=True)
class ReproduceDelivery(Delivery):
    """Output flags of the command: the folder also contains the logs of its runs."""

    out: Annotated[
        str | None,
        out_flag("the page, the claims as JSON and CSV, figures and logs; matching logs in it are read again", OUT),
    ] = None


DELIVERED = ReproduceDelivery()


def reproduce(
    *,
    quick: ReproduceQuickFlag = False,
    only: OnlyFlag = (),
    as_the_authors: AuthorsFlag = False,
    solver: SolverFlag = "planar",
    fresh: FreshFlag = False,
    delivery: Annotated[ReproduceDelivery, FLAT] = DELIVERED,
) -> int:
    """Reproduce the figures of Hsieh 2014 and judge its claims.

    Compute geometry, kinematics, dynamics, stress and torque of both designs
    at the paper's sampling of one degree. One HTML page, which needs no
    network, shows every figure, a table of claims under the paper's own
    conditions (the paper's value, the model's value, numerical error, verdict,
    its cause, and the value at the rated load), and the errata of the
    equations. Figures (PNG, SVG), all numbers (JSON) and the claims (CSV) are
    written to the same folder. No parameter is tuned to the paper. The designs
    differ only in the ring.

    If a stage fails, the page states the error and shows the other stages;
    the exit code is 1. Stress needs the extra `fem`.
    """
    from cycloid_mj.stress.packages import import_package
    from hsieh2014.logs import Logs
    from hsieh2014.plan import FULL, QUICK
    from hsieh2014.run import AUTHORS, STEPS, STRESS, run_steps

    keys = [step.key for step in (*STEPS, AUTHORS)]
    only = (*only, AUTHORS.key) if as_the_authors else only
    if unknown := next((key for key in only if key not in keys), None):
        raise UsageError(f"unknown stage {unknown!r}: choose one of {', '.join(keys)}")
    if STRESS in only:  # before the runs, of which it is the last to know
        for name in ("gmsh", "skfem"):
            import_package(name)
    place = claim_destination(delivery, STEM, default_folder=OUT, with_page=True)
    into = place.folder or Path(OUT)
    logs = Logs(claim_folder(str(into / LOGS), "the logs", (), delivery.force), fresh, delivery.quiet)
    claim_folder(str(into / FIGURES), "the figures", (), delivery.force)
    start = monotonic()
    plan = replace(QUICK if quick else FULL, solver=solver)
    stages = run_steps(plan, logs, _reporter(delivery.quiet), only)
    return deliver(_outcome(stages, plan, place, monotonic() - start), place, delivery)


def _reporter(quiet: bool) -> "Report":
    """Return a function that reports the start and the progress of each stage."""
    last = [0.0]

    def report(stage: "Stage", text: str, left: float) -> None:
        now = monotonic()
        if quiet or (text and now - last[0] < SECONDS_BETWEEN_LINES):
            return
        last[0] = now
        tell(f"{stage.heading}{f': {text}' if text else ''}; about {left:.0f} s left")

    return report


def _outcome(stages: "Sequence[StageRun]", plan: "Plan", destination: Destination, seconds: float) -> Outcome:
    """Return what the command writes and prints: page, claims, figures and failed stages."""
    from cycloid_mj.plots.save import pictures
    from hsieh2014.errata import errata
    from hsieh2014.run import AUTHORS

    claims = [claim for stage in stages for claim in stage.result.claims]
    broken = [stage for stage in stages if stage.error]
    drawings = {plate.name: plate.drawing for stage in stages for plate in stage.result.plates}
    files = {str(path): content for path, content in pictures(drawings, Path(FIGURES), FORMATS).items()}
    printed = errata()
    content = {
        "quick": plan.quick,
        "stages": [stage.as_json() for stage in stages],
        "claims": [claim.as_json() for claim in claims],
        "errata": printed,
        "page": str(destination.page),
    }
    counts = {verdict: sum(claim.verdict == verdict for claim in claims) for verdict in Verdict}
    flags = (
        " --quick" if plan.quick else "",
        " --as-the-authors" if AUTHORS.key in {s.step.key for s in stages} else "",
    )
    command = f"cycloid-mj reproduce{''.join(flags)}"
    return Outcome(
        title="Hsieh 2014, reproduced",
        condition=f"{command}, {seconds:.0f} s",
        headline={"claims": f"{len(claims)}", **{str(verdict): f"{count}" for verdict, count in counts.items()}}
        if claims
        else {},
        failures=[f"stage {stage.step.key} ({stage.step.paper}) failed: {stage.error}" for stage in broken],
        summary=[f"page: {destination.page}"],
        tables=[_table(claims)] if claims else [],
        frame=_frame(claims) if claims else None,
        files=files,
        result=content,
        page=partial(_page, stages, printed, files, plan, f"{command}, {seconds:.0f} s."),
        code=1 if broken else 0,
    )


def _page(
    stages: "Sequence[StageRun]",
    errata: Sequence[Mapping[str, Any]],
    files: Mapping[str, bytes],
    plan: "Plan",
    command: str,
) -> str:
    """Return the HTML page of all stages and `errata`, with the smaller format of each figure.

    `files` are the images by path, `command` is a sentence on command and run time.
    """
    from hsieh2014.page import reproduction_page
    from hsieh2014.plan import SAMPLES, main_runs

    plates = [plate.name for stage in stages for plate in stage.result.plates]
    smaller = {name: min((files[f"{FIGURES}/{name}.{form}"] for form in FORMATS), key=len) for name in plates}
    sample = 1.0 / main_runs(plan)[0].settings.log_rate
    about = (
        "Hsieh, Dynamics Analysis of Cycloidal Speed Reducers With Pinwheel and Nonpinwheel Designs (J. Mech. Des., "
        "2014). Captions are in our own words; the paper's plots are not shown, its stated values are.",
        f"{command} Crank at 1640 rpm, every figure one settled turn at one degree ({sample * SAMPLES.logged:.6g} s), "
        f"from runs at a step of {1e6 * sample / plan.steps:.4g} us. Independent starts and what is varied are run by "
        f"{SOLVERS[plan.solver]}, all else by MuJoCo.",
    )
    return reproduction_page(stages, errata, smaller, about)


def _table(claims: "Sequence[Claim]") -> Table:
    """Return the table of claims for the terminal."""
    from hsieh2014.page import error_words

    rows = []
    for claim in claims:
        values = claim.condition.words, claim.stated.text, claim.ours.text, error_words(claim), str(claim.verdict)
        rows.append((f"{claim.figure}, {claim.design}: {claim.claim}", *values))
    return Table("the paper's claims; what decides each is on the page", HEADER, tuple(rows), words=range(len(HEADER)))


def _frame(claims: "Sequence[Claim]") -> "Frame":
    """Return the claims as a data frame with one row per claim."""
    from cycloid_mj.base.frame import make_frame

    rows = [
        {
            "key": claim.key,
            "figure": claim.figure,
            "part": claim.part,
            "design": claim.design,
            "load_nm": claim.condition.load,
            "speed_rpm": claim.condition.speed_rpm,
            "claim": claim.claim,
            "stated": claim.stated.text,
            "stated_value": claim.stated.value,
            "unit": claim.ours.unit,
            "ours": claim.ours.text,
            "ours_value": claim.ours.value,
            "ours_lowest": claim.ours.spread[0] if claim.ours.spread else None,
            "ours_highest": claim.ours.spread[1] if claim.ours.spread else None,
            "numerical_error": claim.error.value,
            "error_unit": claim.error.unit,
            "verdict": str(claim.verdict),
            "p": claim.p,
            "decided_by": claim.decided_by,
        }
        for claim in claims
    ]
    return make_frame([{key: cell for key, cell in row.items() if cell is not None} for row in rows], COLUMNS, {})
