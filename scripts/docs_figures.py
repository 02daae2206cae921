"""Regenerate the figures that the documentation prints, and list which are stale.

python scripts/docs_figures.py --list           # what there is, whether it is stale and why, and what it costs
python scripts/docs_figures.py                  # all that is stale, the cheapest first
python scripts/docs_figures.py measured paper   # these alone; --all: every one, fresh or not

Ctrl-C keeps what is done: each artefact has its stamp in docs/figures.json as soon as it is written, and the output of
each step of one that is not is kept in runs/docs_figures till then. An artefact that fails does not stop the others.

A stamp records the model's results at the time of the artefact: some figures that take a second (statics, the first
milliseconds of runs, the words on a page), and the digest of what was written. An artefact is stale where the same
figures come out otherwise, by more than `TOLERANCE`, or its files are others. So a change of the physics is seen that
moves what is printed, and no other change is.
"""

import argparse
import hashlib
import json
import math
import re
import shutil
import subprocess
import sys
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from typing import Any

from docs_market import CREATED

from cycloid_mj.base.atomic_write import write_files
from cycloid_mj.reducer import Reducer

ROOT = Path(__file__).resolve().parent.parent
STAMPS = ROOT / "docs" / "figures.json"
SCRATCH = ROOT / "runs" / "docs_figures"
TOLERANCE = 2e-3
"""Relative; figures are printed with three or four digits, and their errors are larger than that."""

LENGTH = 0.004
"""Of a run that is probed [s]."""

BLOCKS = 6
"""Parts of a picture's width and height that are looked at."""

PRINTED = rb"^<!-- printed by .*?^```$"
"""What a command printed, on a page."""


Value = float | str
Values = Mapping[str, Value]


@dataclass(frozen=True)
class Step:
    """A command, run from the root; `{out}` is its own file or folder in `SCRATCH`, and `stdout` may be that file."""

    command: tuple[str, ...]
    stdout: bool = False


@dataclass(frozen=True)
class Artefact:
    """Files that are generated together."""

    files: tuple[str, ...]
    """What is written, from the root of the repository."""
    steps: Mapping[str, Step]
    last: tuple[tuple[str, ...], ...]
    """Commands whose output is kept by their keys, and the commands that write the files of it (``{key}``)."""
    probes: tuple[str, ...]
    """Names in `PROBES`."""
    minutes: float
    """CPU time, about."""


CLI = (sys.executable, "-m", "cycloid_mj")
PYTHON = sys.executable
LOADED = ("--load-nm", "36", "--ramp-s", "0", "--hold-s", "0.06")

PAPER_PICTURES = ("speed", "path", "velocity", "pin", "torque")
"""Pictures of the page on the paper."""

MEASURES = ("backlash", "lost-motion", "te", "torque", "efficiency", "loads")
PRESETS = ("pin", "nonpin")
TUTORIAL = (
    "docs/tutorial.md#printed",
    *(f"docs/tutorial/{name}.png" for name in ("review", "tolerance", "exploded", "joint")),
)
DOORS = ("print", "design", "robot")
FILM_PROBES = ("run massless", "look of the animation")
RUNS, PRINTED_PROBES = ("run free", "run nonpin"), ("printed drive's loops", "printed drive's shaft")
MODEL_PROBES = ("statics pin", "statics nonpin", *RUNS)
PAPER_PROBES = (*MODEL_PROBES, "numbers of the paper")


def _script(name: str, *words: str) -> tuple[str, ...]:
    return PYTHON, f"scripts/{name}.py", *words


def _measure(measure: str, design: str) -> Step:
    names = (design,) if measure == "torque" else ("--design", design)
    return Step((*CLI, "measure", measure, *names, "--json", "--quiet", "--force"), stdout=True)


ARTEFACTS: Mapping[str, Artefact] = {
    "picture": Artefact(("models/mechanism.gif",), {}, (_script("picture", "animation"),), FILM_PROBES, 0.2),
    "bench": Artefact(("tests/data/bench/fitted.json",), {}, (_script("docs_bench", "--fit"),), PRINTED_PROBES, 6.0),
    "report": Artefact(
        ("models/report.png",),
        {name: Step((*CLI, "simulate", "--design", name, *LOADED, "--out", "{out}", "--quiet")) for name in PRESETS},
        (_script("picture", "report", "{pin}/pin.mcap", "{nonpin}/nonpin.mcap"),),
        ("run free", "run nonpin", "words of the report"),
        0.2,
    ),
    "datasheet": Artefact(
        ("docs/datasheet.png",),
        {"sheet": Step((*CLI, "datasheet", "--design", "pin", "--out", "{out}", "--quiet"))},
        (_script("picture", "datasheet", "{sheet}/pin-datasheet.html"),),
        ("statics pin",),
        0.5,
    ),
    "doors": Artefact(
        tuple(f"docs/doors/{door}.png" for door in DOORS), {}, (_script("picture", "doors"),), ("statics pin",), 0.1
    ),
    "tutorial": Artefact(TUTORIAL, {}, (_script("tutorial"),), ("drive of the tutorial",), 3.0),
    "app": Artefact(
        tuple(f"docs/app/{name}.png" for name in ("1-requirements", "2-refused", "3-drives", "4-designed")),
        {"walk": Step(_script("app_walk", "--out", "{out}"))},
        (_script("picture", "walk", "{walk}"),),
        ("files of the app",),
        1.5,
    ),
    "validation": Artefact(
        ("docs/data/validation.csv",),
        {"validate": Step((*CLI, "validate", "--json", "--quiet"), stdout=True)},
        (_script("docs_validation", "{validate}"),),
        MODEL_PROBES,
        1.5,
    ),
    "solvers": Artefact(("docs/data/solvers.csv",), {}, (_script("docs_solvers", "--run"),), RUNS, 10.0),
    "models": Artefact(
        tuple(f"models/{name}.json" for name in ("agreement", "free_running", "plain_coacd")),
        {},
        (_script("measure_models"), _script("build_models")),
        RUNS,
        10.0,
    ),
    "measured": Artefact(
        ("tests/data/measured.json",),
        {f"{design}-{measure}": _measure(measure, design) for design in PRESETS for measure in MEASURES},
        (_script("docs_measured", "{}"),),
        MODEL_PROBES,
        3.0,
    ),
    "compared": Artefact(
        ("tests/data/compared.json",),
        {"compare": Step((*CLI, "compare", *PRESETS, "--json", "--out", "{out}.figures", "--force"), stdout=True)},
        (_script("docs_measured", "--compared", "{compare}"),),
        ("run free", "run nonpin"),
        3.0,
    ),
    "market": Artefact(
        ("docs/data/market.csv",),
        {name: Step(_script("docs_market", "--drive", name), stdout=True) for name in CREATED},
        (_script("docs_market", "{}"),),
        ("drive of the tutorial",),
        15.0,
    ),
    "paper": Artefact(
        ("tests/data/reproduce.json", *(f"docs/paper/{name}.png" for name in PAPER_PICTURES)),
        {"reproduce": Step((*CLI, "reproduce", "--quick", "--out", "{out}"))},
        (_script("docs_results", "{reproduce}"), _script("docs_measured")),
        PAPER_PROBES,
        6.0,
    ),
    "authors": Artefact(
        ("tests/data/authors.json",),
        {"authors": Step((*CLI, "reproduce", "--quick", "--as-the-authors", "--out", "{out}"))},
        (_script("docs_results", "{authors}"),),
        PAPER_PROBES,
        8.0,
    ),
}
"""By name, the cheapest first."""


def statics_of(preset: str) -> dict[str, Value]:
    """Collect the figures of a preset by statics."""
    from cycloid_mj.design import PRESETS as DESIGNS
    from cycloid_mj.statics.sheet import quick_sheet

    design = DESIGNS[preset]
    return {
        key: quantity.value for key, quantity in quick_sheet(Reducer(design), design.rated_torque).quantities.items()
    }


@cache
def short_run(kind: str) -> Any:
    """Run a preset for some milliseconds under 36 N m: with pins of a kind, or ``nonpin``."""
    from cycloid_mj.base.errors import CycloidWarning
    from cycloid_mj.design import PRESETS as DESIGNS
    from cycloid_mj.design import override
    from cycloid_mj.dynamics.run import simulate

    changes = ["drive.ramp_s=0", f"drive.hold_s={LENGTH}", "load.torque_nm=36", f"load.rise_s={0.25 * LENGTH}"]
    if kind != "nonpin":
        changes.append(f'ring.pins="{kind}"')
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CycloidWarning)
        return simulate(override(DESIGNS["nonpin" if kind == "nonpin" else "pin"], changes))


def run_of(kind: str) -> dict[str, Value]:
    """Compute rms values over the second half of `short_run`: crank torque, and angle errors of disc and output."""
    import numpy as np

    from cycloid_mj.analysis.series import design_of

    run = short_run(kind)
    design, crank = design_of(run), run["crank_angle"]
    signals = {
        "crank_torque": run["crank_torque"],
        "gear_error": run["gear_angle"] - Reducer(design).member.gear_angle(crank),
        "output_error": run["output_angle"] - Reducer(design).member.output_angle(crank),
    }
    settled = run.time > 0.5 * LENGTH
    return {key: float(np.sqrt(np.mean(values[settled] ** 2))) for key, values in signals.items()}


def words_of_the_report() -> dict[str, Value]:
    """Collect the headings of the report of two short runs, up to the section Mechanism, as one text."""
    from cycloid_mj.base.errors import CycloidWarning
    from cycloid_mj.report import report

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CycloidWarning)
        page = report({"pin": short_run("free"), "nonpin": short_run("nonpin")})
    headings = re.findall(r"<(?:h1|h2|h3|th|summary)[^>]*>(.*?)</", page, flags=re.DOTALL)
    words = [re.sub(r"<[^>]+>", "", heading).strip() for heading in headings]
    return {"words": " | ".join(words[: words.index("Mechanism") + 1])}


def look_of_the_animation() -> dict[str, Value]:
    """Compute the mean brightness, 0 to 1, of `BLOCKS` by `BLOCKS` blocks of the first frame of an animation."""
    import numpy as np

    from cycloid_mj.plots.animation import draw_frames, select_samples

    frame = next(draw_frames(select_samples(short_run("massless"), 200.0, 1), 520))
    brightness = np.asarray(frame, dtype=float).mean(axis=2) / 255.0
    rows = [np.array_split(band, BLOCKS, axis=1) for band in np.array_split(brightness, BLOCKS)]
    return {f"block {i}, {j}": float(block.mean()) for i, band in enumerate(rows) for j, block in enumerate(band)}


def numbers_of_the_paper() -> dict[str, Value]:
    """Compute the digest of all values that the module `hsieh2014.stated` attributes to the paper."""
    from hsieh2014 import stated

    imported = {"PRESETS", "TYPE_CHECKING"}
    values = {key: repr(value) for key, value in sorted(vars(stated).items()) if key.isupper() and key not in imported}
    return {"digest": hashlib.sha256(repr(values).encode()).hexdigest()[:16]}


def drive_of_the_tutorial() -> dict[str, Value]:
    """Collect the figures of the drive that the tutorial's first command writes."""
    from cycloid_mj.sizing import new

    return dict(new(20, 60.0, 4.0).drives[0].figures)


def loops_of_the_printed_drive() -> dict[str, Value]:
    """Compute the residual of each measured loop of the printed drive for its design with a compliant structure.

    The residual is a share of the loop's height.
    """
    import cycloid_mj as cm

    design = cm.load("printed").but(springs={"housing": 400.0, "friction": 2.5, "hysteresis": 3.0})
    names = ("play_loop", "stiffness_loop")
    loops = [cm.read_loop(ROOT / "tests" / "data" / "bench" / f"{name}.csv") for name in names]
    return dict(zip(names, cm.predict_loops(Reducer(design), loops).shares, strict=True))


def shaft_of_the_printed_drive() -> dict[str, Value]:
    """Compute the compliances of the printed drive in bending (crank) and in torsion (parts) by closed forms.

    They stand for the compliances by finite elements, which take longer.
    """
    import cycloid_mj as cm
    from cycloid_mj.statics.structure import crank_flexibility, twisting_compliance

    reducer = Reducer(cm.load("printed"))
    return {"bending": float(crank_flexibility(reducer).max()), **twisting_compliance(reducer)}


def files_of_the_app() -> dict[str, Value]:
    """Compute the digests of the files that the app sends to the browser, by file name."""
    assets = ROOT / "cycloid_mj" / "app" / "assets"
    return {path.name: _digest(str(path.relative_to(ROOT))) for path in sorted(assets.iterdir()) if path.is_file()}


PROBES: Mapping[str, Callable[[], dict[str, Value]]] = {
    **{f"statics {name}": partial(statics_of, name) for name in PRESETS},
    **{f"run {kind}": partial(run_of, kind) for kind in ("free", "massless", "nonpin")},
    "words of the report": words_of_the_report,
    "look of the animation": look_of_the_animation,
    "numbers of the paper": numbers_of_the_paper,
    "drive of the tutorial": drive_of_the_tutorial,
    "printed drive's loops": loops_of_the_printed_drive,
    "printed drive's shaft": shaft_of_the_printed_drive,
    "files of the app": files_of_the_app,
}


@cache
def probe_values(name: str) -> Values:
    """Return what a probe says now."""
    return PROBES[name]()


def stamps() -> dict[str, Any]:
    """Read the stamps, by artefact; none where there is no file."""
    return dict(json.loads(STAMPS.read_text(encoding="utf-8"))) if STAMPS.exists() else {}


def stamp(artefact: Artefact) -> dict[str, Any]:
    """Collect the stamp of what has been written just now."""
    probes = {name: {key: _short(value) for key, value in probe_values(name).items()} for name in artefact.probes}
    return {"probes": probes, "files": {name: _digest(name) for name in artefact.files}}


def stale(artefact: Artefact, kept: Mapping[str, Any] | None) -> list[str]:
    """Return the reasons why an artefact is stale, a reason each; nothing where it is fresh."""
    if kept is None:
        return ["it has no stamp: it was made before there were any"]
    changed = [name for name in artefact.files if kept["files"].get(name) != _digest(name)]
    return list_changes(artefact, kept["probes"]) + [f"{name} is not what the stamp is of" for name in changed]


def list_changes(artefact: Artefact, before: Mapping[str, Values]) -> list[str]:
    """Compare the figures of an artefact's probes with earlier figures, and return a sentence for each that changed."""
    changes = []
    for name in artefact.probes:
        was, now = before.get(name, {}), probe_values(name)
        keys = [key for key in sorted(set(was) | set(now)) if not _alike(was.get(key), now.get(key))]
        changes += [
            f"{name}, {key}: {_format_value(was.get(key))}, now {_format_value(now.get(key))}" for key in keys[:3]
        ]
    return changes


def _alike(before: Value | None, other: Value | None) -> bool:
    if isinstance(before, str) or isinstance(other, str) or before is None or other is None:
        return before == other
    return math.isclose(before, other, rel_tol=TOLERANCE, abs_tol=1e-12) or (before != before and other != other)


def _short(value: Value) -> Value:
    return value if isinstance(value, str) else float(f"{value:.6g}")


def _format_value(value: Value | None) -> str:
    return f"{value:.5g}" if isinstance(value, float) else f"{value!s:.60}"


def _digest(name: str) -> str:
    """Compute the digest of a file; after ``#`` in its name, that of the command output printed on the page."""
    place, _, part = name.partition("#")
    path = ROOT / place
    if not path.exists():
        return "missing"
    content = path.read_bytes()
    if part:
        content = b"".join(re.findall(PRINTED, content, flags=re.DOTALL | re.MULTILINE))
    return hashlib.sha256(content).hexdigest()[:16]


def write(name: str, artefact: Artefact) -> None:
    """Run the steps of an artefact that lack output, and write its stamp; raise CalledProcessError if a step fails."""
    scratch = SCRATCH / name
    probed = scratch / "probes.json"
    if not probed.exists() or list_changes(artefact, json.loads(probed.read_text(encoding="utf-8"))):
        shutil.rmtree(scratch, ignore_errors=True)
        scratch.mkdir(parents=True)
        probed.write_text(json.dumps({probe: dict(probe_values(probe)) for probe in artefact.probes}), encoding="utf-8")
    for key, step in artefact.steps.items():
        out = scratch / key
        if not out.exists():
            _run_step(step, out)
    places = {key: str((scratch / key).relative_to(ROOT)) for key in artefact.steps}  # as pages print them
    for command in artefact.last:
        subprocess.run([word.format(scratch, **places) for word in command], cwd=ROOT, check=True)
    kept = {**stamps(), name: stamp(artefact)}
    write_files({STAMPS: (json.dumps(dict(sorted(kept.items())), indent=1) + "\n").encode()})
    shutil.rmtree(scratch)


def _run_step(task: Step, out: Path) -> None:
    """Run the command of a step; its output gets its name only when it is complete."""
    part = out.with_name(f"{out.name}.part")
    shutil.rmtree(part, ignore_errors=True)
    command = [word.format(out=part) for word in task.command]
    if task.stdout:
        with part.open("w", encoding="utf-8") as stream:
            subprocess.run(command, cwd=ROOT, check=True, stdout=stream)
    else:
        subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    part.rename(out)


def cpu() -> float:
    """Compute the CPU time of all commands that have ended [min]."""
    used = getrusage(RUSAGE_CHILDREN)
    return (used.ru_utime + used.ru_stime) / 60.0


def main() -> int:
    """Write the outdated artefacts of the documentation, or list them; return the exit code."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    parser.add_argument("names", nargs="*", help=f"of {', '.join(ARTEFACTS)}; default: all that are stale")
    parser.add_argument("--list", action="store_true", help="tell what is stale, and why; write nothing")
    parser.add_argument("--all", action="store_true", help="write those that are fresh, too")
    options = parser.parse_args()
    if unknown := [name for name in options.names if name not in ARTEFACTS]:
        parser.error(f"there is no {unknown[0]!r}; there are {', '.join(ARTEFACTS)}")
    chosen = {name: ARTEFACTS[name] for name in options.names or ARTEFACTS}
    reasons = {name: stale(artefact, stamps().get(name)) for name, artefact in chosen.items()}
    if options.list:
        for name, artefact in chosen.items():
            print(f"{name}: {'; '.join(reasons[name]) or 'fresh'} ({artefact.minutes:g} min of CPU)")
            print(*(f"    {file}" for file in artefact.files), sep="\n")
        return 0
    wanted = {name: artefact for name, artefact in chosen.items() if options.all or options.names or reasons[name]}
    left = sum(artefact.minutes for artefact in wanted.values())
    failed = []
    for number, (name, artefact) in enumerate(wanted.items(), 1):
        print(f"{number} of {len(wanted)}: {name}; some {left:g} min of CPU left", file=sys.stderr, flush=True)
        try:
            write(name, artefact)
        except subprocess.CalledProcessError as error:
            print(
                f"error: {name}: {' '.join(error.cmd)} ended with {error.returncode}; steps that are done are kept",
                file=sys.stderr,
            )
            failed.append(name)
        except KeyboardInterrupt:
            print(f"stopped in {name}; the same command goes on from there", file=sys.stderr)
            return 1
        left -= artefact.minutes
    failures = f", {len(failed)} failed ({', '.join(failed)})" if failed else ""
    print(f"{len(wanted) - len(failed)} written{failures}, {cpu():.1f} min of CPU", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
