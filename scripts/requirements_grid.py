"""Size random drives by `cycloid-mj design new`, and compare each with its own data sheet.

    python scripts/requirements_grid.py [--seed 1] [--count 40] [--thorough]

Requirements from 5:1 to 120:1, 30 to 300 mm, 0.2 to 500 N m, of all processes, with up to two further requirements, are
spread evenly by the points of Sobol, scrambled by the seed. A written drive has to pass `design check`, and to meet the
requirement by its rating within its tolerances, its tolerance study, and its size with covers. After a refusal, the
largest possible torque and a remedy are tried with the flags that the command suggests; `--thorough` tries all
remedies, all drives of a shortlist, and 0.9 to 2 times the stated maximum. The exit code is 1 if one fails.
"""

import argparse
import json
import math
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

from scipy.stats import qmc

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.units import RPM
from cycloid_mj.checks import check
from cycloid_mj.cli import main as command
from cycloid_mj.design import load
from cycloid_mj.design.processes import PROCESSES, Process
from cycloid_mj.explore.tolerances import tolerance
from cycloid_mj.figures import figure
from cycloid_mj.life.checks import life_checks
from cycloid_mj.life.duty import PEAK_FACTOR
from cycloid_mj.life.figures import drive_diameter, drive_length
from cycloid_mj.life.items import rate
from cycloid_mj.life.rated import rated_and_momentary_torque
from cycloid_mj.reducer import Reducer
from cycloid_mj.sizing.requirement import QUANTITIES, Requirement


@dataclass(frozen=True)
class GridSettings:
    """Ranges of the requirements, and what is judged."""

    ratios: tuple[float, float] = (5.0, 120.0)
    diameters: tuple[float, float] = (0.03, 0.3)
    torques: tuple[float, float] = (0.2, 500.0)
    """Ratios, diameters [m] and torques [N m] between which requirements are drawn."""
    max_cpu: float = 10.0
    """Largest acceptable CPU time of an answer [s]."""
    rtol: float = 1e-3
    """Relative tolerance of the shortlist's torque against the rating of the file."""
    samples: int = 512
    min_yield: float = 0.99
    """Samples of the tolerance study of a file, and their smallest yield."""
    shares: tuple[float, ...] = (0.9, 1.1, 1.5, 2.0)
    max_share: float = 1.1
    """Torques that are tried, and largest rated torque of a drive that is found, relative to a stated maximum."""
    range_interval: int = 8
    range: int = 6
    """Number of requirements from one with a range of ratios to the next, and width of such a range."""


GRID = GridSettings()

KINDS: tuple[Process, ...] = ("steel", "printed", "steel", "milled")

FLAGS: Mapping[str, tuple[str, float]] = {
    **{key: (quantity.flag, quantity.scale) for key, quantity in QUANTITIES.items()},
    **{key: (f"--{key}", 1.0) for key in ("process", "discs", "material", "fit")},
}
"""Flags of the values of a requirement, with their units in SI."""

ALWAYS = ("diameter", "torque", "process")
NUMBERS = ("--diameter-mm", "--torque-nm", "--life-h", "--speed-rpm", "--length-mm", "--backlash-arcmin")


WISHES: tuple[Callable[[Requirement, float], dict[str, Any]], ...] = (
    lambda asked, share: {"discs": 2},
    lambda asked, share: {"discs": 3},
    lambda asked, share: {"discs": 0},
    lambda asked, share: {"length": _even(0.4, 1.2, share) * asked.diameter},
    lambda asked, share: {"backlash": _even(2.0, 40.0, share)},
    lambda asked, share: {"speed": _even(100.0, 6000.0, share) * RPM},
    lambda asked, share: {"life": _even(300.0, 40000.0, share)},
    lambda asked, share: {"fit": ("H7/g6", "H7/f7", "H8/e8")[int(3.0 * share)]},
    lambda asked, share: {"material": (others := PROCESSES[asked.process].others)[int(share * len(others))]},
    lambda asked, share: {"clearance": _even(1.0, 3.0, share) * PROCESSES[asked.process].finest},
    lambda asked, share: {"custom": True},
)
"""Further requirements besides ratio, diameter, torque and process."""


def draw_requirements(count: int, seed: int) -> list[Requirement]:
    """Draw `count` random requirements: sizes from a log-uniform distribution, and up to two further requirements.

    Larger drives get more torque. A quarter of the drives has no further requirement, half of them one, and a quarter
    two, unless these are incompatible. With the same seed, a larger `count` only appends to the list.
    """
    points = qmc.Sobol(7, seed=seed).random_base2(math.ceil(math.log2(max(count, 1))))
    grid = []
    for number, (ratio, size, more, *wishes) in enumerate(points[:count]):
        torque = min(max(0.7 * size + 0.6 * (more - 0.35), 0.0), 1.0)
        sizes = round(_even(*GRID.ratios, ratio)), _even(*GRID.diameters, size), _even(*GRID.torques, torque)
        asked = Requirement(*sizes, process=KINDS[number % len(KINDS)])
        for wish, share in (wishes[:2], wishes[2:]):
            chosen = int(2.0 * wish * len(WISHES))
            if chosen < len(WISHES):
                with suppress(UsageError):  # a fit and a clearance, or a fit beyond its sizes
                    asked = asked.but(**WISHES[chosen](asked, share))
        grid.append(asked)
    return grid


def _even(low: float, high: float, share: float) -> float:
    """Return a number between two, evenly by its logarithm, with three digits."""
    return float(f"{low * (high / low) ** share:.3g}")


def flags(requirement: Requirement, ratios: int = 0) -> dict[str, str]:
    """Return the flags of `design new` for a requirement: flag -> value; with `ratios`, for a range of ratios."""
    usual = Requirement(requirement.ratio, requirement.diameter, requirement.torque)
    values = {}
    for key, (flag, scale) in FLAGS.items():
        value = getattr(requirement, key)
        if key in ALWAYS or value != getattr(usual, key):
            values[flag] = f"{value / scale:.10g}" if isinstance(value, float) else str(value or "auto")
    values |= (
        {"--ratio-range": f"{requirement.ratio}:{requirement.ratio + ratios}"}
        if ratios
        else {"--ratio": str(requirement.ratio)}
    )
    return values | ({"--custom": ""} if requirement.custom else {})


def size(asked: dict[str, str]) -> tuple[dict[str, Any], str]:
    """Run `design new --json` with some flags; return its output, or nothing and its error."""
    words = [word for flag, value in asked.items() for word in ((flag,) if flag == "--custom" else (flag, value))]
    out, err = StringIO(), StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        command(["design", "new", "asked", "--json", "--force", *words])
    return (json.loads(out.getvalue()) if out.getvalue() else {}), err.getvalue()


def faults(drive: dict[str, Any], requested_flags: dict[str, str]) -> Iterator[str]:
    """Yield a sentence for each requirement that a drive does not fulfil, by `design check` and its data sheet."""
    design = load(Path(drive["file"]))
    reducer, figures = Reducer(design), drive["figures"]
    wanted = {flag: float(value) for flag, value in requested_flags.items() if flag in NUMBERS}
    yield from (str(item) for item in check(design) if item.severity == "error" and not item.passed)
    yield from (str(item) for item in life_checks(reducer) if not item.passed)
    items = rate(design, parts="toleranced").items.values()
    (rated, _), (momentary, _) = rated_and_momentary_torque(items, design.rated_torque, design.service.life)
    if rated < wanted["--torque-nm"]:
        yield f"its rated torque is {rated:.4g} N m"
    if momentary < PEAK_FACTOR * wanted["--torque-nm"]:
        yield f"its momentary torque is {momentary:.4g} N m"
    if abs(figures["rated_torque_nm"] / rated - 1.0) > GRID.rtol:
        yield f"the shortlist has {figures['rated_torque_nm']:.4g} N m, its rating {rated:.4g}"
    passed = tolerance(design, GRID.samples).good
    if passed.mean() < GRID.min_yield:
        yield f"its yield is {100.0 * passed.mean():.4g} %"
    if (diameter := drive_diameter(reducer)) > wanted["--diameter-mm"] + 0.01:
        yield f"its diameter is {diameter:.4g} mm"
    kept = {
        "--life-h": design.service.life,
        "--speed-rpm": design.drive.speed / RPM,
    }
    yield from (
        f"{flag} is {value:.6g}" for flag, value in kept.items() if not math.isclose(value, wanted.get(flag, value))
    )
    if not figures["life_h"] >= design.service.life:
        yield f"it lasts {figures['life_h']:.4g} h"
    if (long := drive_length(reducer)) > wanted.get("--length-mm", math.inf):
        yield f"it is {long:.4g} mm long"
    if (backlash := figure("backlash_arcmin").value(reducer)) > wanted.get("--backlash-arcmin", math.inf):
        yield f"its backlash is {backlash:.4g} arcmin"


def judge(requested_flags: dict[str, str], number: int, thorough: bool) -> tuple[str, float, list[str]]:
    """Size a drive for the requested flags; return the answer in words, its CPU time [s], and its faults."""
    began = time.process_time()
    answer, error = size(requested_flags)
    spent = time.process_time() - began
    if not answer:
        return error, spent, ["neither a drive nor a refusal"]
    if drives := answer.get("designs"):
        titles = ", ".join(f"{one['title']} {one['figures']['mass_kg']:.3g} kg" for one in drives)
        return (
            titles,
            spent,
            [fault for one in drives[: None if thorough else 1] for fault in faults(one, requested_flags)],
        )
    most, ways = answer["most"], answer["ways"]
    wrong = [] if ways else ["no way out"]
    if most >= float(requested_flags["--torque-nm"]):
        wrong.append(f"{most:g} N m are at most, and {requested_flags['--torque-nm']} refused")
    others = [("its most", requested_flags | {"--torque-nm": f"{most:g}"})] if most else []
    chosen = ways if thorough else ways[number % max(len(ways), 1) :][:1]
    others += [(one["words"], _replace_flags(requested_flags, one["flags"])) for one in chosen]
    for words, other in others:
        then, error = size(other)
        wrong += [f"{words}: {fault}" for one in then.get("designs", [])[:1] for fault in faults(one, other)]
        wrong += [] if then.get("designs") else [f"{words} is refused: {then.get('why', error)}"]
    wrong += _judge_maximum(requested_flags, most) if thorough and most else []
    return answer["why"], spent, wrong


def _judge_maximum(requested_flags: dict[str, str], most: float) -> Iterator[str]:
    """Yield a sentence for each share of a stated maximum torque [N m] that contradicts it (`GRID.shares`)."""
    for share in GRID.shares:
        answer, _ = size(requested_flags | {"--torque-nm": f"{share * most:.4g}"})
        rated = [drive["figures"]["rated_torque_nm"] for drive in answer.get("designs", [])[:1]]
        if share < 1.0 and not rated:
            yield f"{share:g} times the maximum of {most:g} N m is refused"
        if share > 1.0 and rated and rated[0] > GRID.max_share * most:
            yield f"{share:g} times the maximum of {most:g} N m leads to a drive of {rated[0]:.4g} N m"


def _replace_flags(asked: dict[str, str], words: list[str]) -> dict[str, str]:
    """Replace flags by those of a remedy."""
    custom = {"--custom": ""} if "--custom" in words else {}
    pairs = [word for word in words if word != "--custom"]
    return asked | dict(zip(pairs[::2], pairs[1::2], strict=True)) | custom


def main() -> int:
    """Size drives for all requirements, and print a line for each with its faults."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--thorough", action="store_true")
    given = parser.parse_args()
    os.chdir(tempfile.mkdtemp())
    size(flags(Requirement(20, 0.06, 5.0)))  # compiles what is not yet
    times, bad = [], 0
    for number, one in enumerate(draw_requirements(given.count, given.seed), start=1):
        asked = flags(one, GRID.range if number % GRID.range_interval == 0 else 0)
        told, spent, wrong = judge(asked, number, given.thorough)
        times.append(spent)
        bad += bool(wrong)
        words = " ".join(f"{flag} {value}" for flag, value in asked.items())
        print(f"{number:3d}  {spent:5.1f} s  {words}\n       {told}", *wrong, sep="\n       ! ", flush=True)
    slow = sum(spent > GRID.max_cpu for spent in times)
    print(f"{len(times)} drawn: {bad} wrong; {slow} took over {GRID.max_cpu:g} s of CPU, at most {max(times):.1f} s")
    return int(bool(bad))


if __name__ == "__main__":
    sys.exit(main())
