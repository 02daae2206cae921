"""Ask `cycloid-mj design new` for random drives, and hold each answer to its own data sheet.

    python scripts/requirements_grid.py [--seed 1] [--count 40] [--thorough]

Requirements from 5:1 to 120:1, 30 to 300 mm, 0.2 to 500 N m, of all processes, some with a wish more; evenly spread
(Sobol's points, scrambled by the seed). A drive is to pass `design check`, and its rated torque and life are to meet
what was asked. Of a refusal, the most that goes and a way out are asked for in their turn; `--thorough` asks for all
ways and looks at all drives of a shortlist. Forty take some 8 minutes of CPU; the exit code is 1 where one fails.
"""

import argparse
import math
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

from scipy.stats import qmc

from cycloid_mj.base.units import RPM
from cycloid_mj.checks import check
from cycloid_mj.life.datasheet import momentary_torque
from cycloid_mj.life.figures import length
from cycloid_mj.life.lasting import lasting_checks
from cycloid_mj.life.rated import rated_torque
from cycloid_mj.reducer import Reducer
from cycloid_mj.sizing.answer import SizedDrive, answered, best_ratio
from cycloid_mj.sizing.process import PROCESSES, Process
from cycloid_mj.sizing.requirement import Requirement

RATIOS, DIAMETERS, TORQUES = (5.0, 120.0), (0.03, 0.3), (0.2, 500.0)
KINDS: tuple[Process, ...] = ("steel", "printed", "steel", "milled")
SLOWEST = 10.0
"""CPU time of an answer [s] that a user is asked to wait at most."""

EVERY, RANGE = 8, 6
"""Every so many requirements a range of ratios is asked for, so wide."""

WISHES: tuple[Callable[[Requirement, float], dict[str, Any]], ...] = (
    lambda asked, share: {"discs": 2},
    lambda asked, share: {"discs": 3},
    lambda asked, share: {"discs": 0},
    lambda asked, share: {"length": _even(0.4, 1.2, share) * asked.diameter},
    lambda asked, share: {"backlash": _even(2.0, 40.0, share)},
    lambda asked, share: {"speed": _even(100.0, 6000.0, share) * RPM},
    lambda asked, share: {"life": _even(300.0, 40000.0, share)},
    lambda asked, share: {"fit": ("H7/g6", "H7/f7", "H8/e8")[int(3.0 * share)]},
    lambda asked, share: {"material": _one_of(PROCESSES[asked.process].others, share)},
    lambda asked, share: {"clearance": _even(1.0, 3.0, share) * PROCESSES[asked.process].finest},
    lambda asked, share: {"custom": True},
)
"""What may be asked for beside ratio, diameter, torque and process."""


def drawn(count: int, seed: int) -> list[Requirement]:
    """Draw requirements, each size evenly by its logarithm; larger drives are asked for more torque, half have a wish.

    With one seed, fewer are the first of more.
    """
    points = qmc.Sobol(5, seed=seed).random_base2(math.ceil(math.log2(max(count, 1))))
    grid = []
    for number, (ratio, size, more, wish, share) in enumerate(points[:count]):
        torque = min(max(0.7 * size + 0.6 * (more - 0.35), 0.0), 1.0)
        asked = Requirement(
            ratio=round(_even(*RATIOS, ratio)),
            diameter=_even(*DIAMETERS, size),
            torque=_even(*TORQUES, torque),
            process=KINDS[number % len(KINDS)],
        )
        chosen = int(2.0 * wish * len(WISHES))
        grid.append(asked.but(**WISHES[chosen](asked, share)) if chosen < len(WISHES) else asked)
    return grid


def _even(low: float, high: float, share: float) -> float:
    """Return a number between two, evenly by its logarithm, with three digits."""
    return float(f"{low * (high / low) ** share:.3g}")


def _one_of(names: tuple[str, ...], share: float) -> str:
    return names[int(share * len(names))]


def faults(drive: SizedDrive, asked: Requirement) -> Iterator[str]:
    """Yield what of a requirement a drive does not hold, by `design check` and its own data sheet."""
    reducer = Reducer(drive.design)
    yield from (str(item) for item in check(drive.design) if item.severity == "error" and not item.passed)
    yield from (str(item) for item in lasting_checks(reducer) if not item.passed)
    lasting, _ = rated_torque(reducer, asked.speed, asked.life)
    once, _ = momentary_torque(reducer)
    if min(lasting, once) < asked.torque:
        yield f"its rated torque is {min(lasting, once):.4g} N m"
    told = drive.figures["rated_torque_nm"]
    if abs(told / min(lasting, once) - 1.0) > 0.06:
        yield f"the shortlist tells {told:.4g} N m, the data sheet {min(lasting, once):.4g}"
    if length(reducer) > 1e3 * asked.length:
        yield f"it is {length(reducer):.4g} mm long"
    if drive.figures["backlash_arcmin"] > asked.backlash:
        yield f"its backlash is {drive.figures['backlash_arcmin']:.4g} arcmin"


def judged(asked: Requirement, way: int, thorough: bool, ratios: int = 0) -> tuple[str, float, list[str]]:
    """Ask for a drive, or the best of so many ratios: what is answered, its CPU time [s], and what of it is wrong."""
    began = time.process_time()
    asked = best_ratio(asked, asked.ratio, asked.ratio + ratios) if ratios else asked
    answer = answered(asked)
    spent = time.process_time() - began
    if answer.drives:
        looked_at = answer.drives if thorough else answer.drives[:1]
        return answer.line, spent, [fault for drive in looked_at for fault in faults(drive, answer.asked)]
    wrong = [] if answer.ways else ["no way out"]
    if answer.most >= asked.torque:
        wrong.append(f"{answer.most:g} N m are at most, and {asked.torque:g} refused")
    if answer.most:
        less = answered(answer.asked.but(torque=answer.most))
        wrong += [f"at its most: {fault}" for drive in less.drives[:1] for fault in faults(drive, less.asked)]
        wrong += [] if less.drives else [f"its most, {answer.most:g} N m, is refused: {less.refusal}"]
    ways = answer.ways if thorough else answer.ways[way % max(len(answer.ways), 1) :][:1]
    for one in ways:
        then = answered(one.asked)
        wrong += [f"{one.words}: {fault}" for drive in then.drives[:1] for fault in faults(drive, then.asked)]
        wrong += [] if then.drives else [f"{one.words} is refused: {then.refusal}"]
    return answer.refusal, spent, wrong


def _words(asked: Requirement) -> str:
    """Tell a requirement by the values that are not the usual ones."""
    usual = Requirement(asked.ratio, asked.diameter, asked.torque, process=asked.process)
    wish = {key: value for key, value in vars(asked).items() if value != getattr(usual, key)}
    told = "".join(
        f", {key} {value:.4g}" if isinstance(value, float) else f", {key} {value}" for key, value in wish.items()
    )
    return f"{asked.ratio}:1, {1e3 * asked.diameter:.3g} mm, {asked.torque:g} N m, {asked.process}{told}"


def main() -> int:
    """Judge all answers; a line each as they come."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--thorough", action="store_true")
    given = parser.parse_args()
    answered(Requirement(20, 0.06, 5.0))  # compiles what is not yet
    times, bad = [], 0
    for number, asked in enumerate(drawn(given.count, given.seed), start=1):
        words, spent, wrong = judged(asked, number, given.thorough, RANGE if number % EVERY == 0 else 0)
        times.append(spent)
        bad += bool(wrong)
        print(f"{number:3d}  {spent:5.1f} s  {_words(asked)}\n       {words}", *wrong, sep="\n       ! ", flush=True)
    slow = sum(spent > SLOWEST for spent in times)
    print(f"{len(times)} asked for: {bad} wrong; {slow} took over {SLOWEST:g} s of CPU, the slowest {max(times):.1f} s")
    return int(bool(bad))


if __name__ == "__main__":
    sys.exit(main())
