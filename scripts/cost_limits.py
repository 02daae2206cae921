"""Requirements on the cost of commands and studies: each cost next to its limit, each gain next to its minimum.

CPU times are of a process and of all that it starts, user and system. A command runs once before it is timed, so that
what it compiles is kept; the first one of an installation runs where nothing is kept, neither code nor bytecode.
"""

import math
import sys
import tempfile
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

from costs import Launched, launch, second_cost
from sweeping import TOLERANCES

from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.explore.sampling import SAMPLING, list_batches, tolerance_zones
from cycloid_mj.explore.tolerances import solve_sample_batch
from cycloid_mj.figures import SAMPLED
from cycloid_mj.figures.sampled import ANGLES
from cycloid_mj.measure import MEASURES
from cycloid_mj.reducer import Reducer

LOADED = "load.torque_nm=36.68"
AT_SPEED = ("drive.ramp_s=0", "drive.hold_s=0.13")

SOLVED = {
    "free pins": (9.0, ("pin", LOADED)),
    "massless pins": (8.0, ("pin", LOADED, "ring.pins=massless")),
    "fixed pins": (8.0, ("pin", LOADED, "ring.pins=fixed")),
    "nonpin": (8.0, ("nonpin", LOADED, "drive.hold_s=0.6")),
}
"""Runs at full speed by both solvers: minimum ratio of the costs of MuJoCo and planar, preset and changes."""

TOOTHED = {
    12: ("gear.eccentricity_mm=2", "ring.pin_radius_mm=5", "output.hole_radius_mm=6"),
    72: ("gear.eccentricity_mm=0.4", "ring.pin_radius_mm=1.1", "output.hole_radius_mm=4.4"),
    144: ("gear.eccentricity_mm=0.2", "ring.pin_radius_mm=0.55", "output.hole_radius_mm=4.2"),
}
"""Numbers of free pins on the pin circle of the preset, the fewest first, with the changes that fit them."""

SLEEVED = (
    "ring.pins=sleeved",
    "ring.teeth=54",
    "ring.pin_radius_mm=1.5",
    "ring.sleeve_thickness_mm=0.5",
    "gear.eccentricity_mm=0.5",
    "gear.discs=2",
    "output.hole_radius_mm=4.5",
    "output.member=ring",
    *(f"clearance.{pair}_um=20" for pair in ("pin_gear", "pin_sleeve", "cam", "output")),
)
"""Changes from `pin` to a drive of 54 sleeved pins and two discs, with its output at the ring and 20 um of play."""

SPREAD = {"tolerance.cam": "normal 0.2", "tolerance.output": "normal 0.2"}
TIGHT = {"tolerance.cam": "normal 0.4", "tolerance.pin_position": "normal 0.4", "tolerance.output": "normal 0.4"}
"""Tolerances with which some samples of `pin` have hardly any play, and some none."""

SAMPLES = {"pin": ("pin", TOLERANCES), "pin, tight": ("pin", TIGHT)}
SAMPLES |= {"nonpin": ("nonpin", SPREAD), "twodisc": ("twodisc", TOLERANCES)}

SHARED = {
    "eight starts": ("compare", "pin", "nonpin", "--load-nm", "0"),
    "a sweep of runs": (
        *("sweep", "--design", "pin", "--vary", "load.torque_nm=6:36:32", "--measure", "simulate", "--real-pins"),
        *("--set", "drive.ramp_s=0", "--set", "drive.hold_s=2", "--out", "made"),
    ),
    "samples that are verified": (
        *("tolerance", "--design", "pin", "--samples", "6000", "--verify", "5", "--out", "made"),
        *("--set", "tolerance.cam=normal 0.2"),
    ),
}
"""Commands whose work two workers share; their start counts."""


@dataclass(frozen=True)
class Demand:
    """A figure [unit] with its upper limit, or with `least` its lower one; `measure` measures it once."""

    name: str
    limit: float
    unit: str
    measure: Callable[[], float]
    least: bool = False

    def share(self, value: float) -> float:
        """Return a value relative to its limit, or the minimum relative to the value: 1 or less is fulfilled."""
        return self.limit / value if self.least else value / self.limit


def cpu(*words: str) -> float:
    """Measure the CPU time of a command [s]."""
    return launch(*words).cpu


def memory(*words: str) -> float:
    """Measure the peak memory of a command [MB]."""
    return launch(*words).memory


def run_uncached(*words: str) -> Launched:
    """Run a command where neither compiled code nor bytecode is kept yet."""
    with tempfile.TemporaryDirectory() as empty:
        return launch(*words, NUMBA_CACHE_DIR=f"{empty}/code", PYTHONPYCACHEPREFIX=f"{empty}/bytecode")


def measures_cost() -> float:
    """Measure the CPU time of all measures of `pin` at full quality, each a command of its own [s]."""
    return sum(cpu("measure", name, "--design", "pin", "--quiet") for name in MEASURES)


def solver_ratio(preset: str, *changes: str) -> float:
    """Compute the cost of a simulated second in MuJoCo over that of the planar solver, each at its own step."""
    design = override(PRESETS[preset], [*AT_SPEED, *changes])
    return second_cost("mujoco", design) / second_cost("planar", design)


def cost_exponent(most: int) -> float:
    """Compute the exponent of the cost of a simulated second of the planar solver, by the number of free pins."""
    fewest, costs = next(iter(TOOTHED)), {}
    for teeth in (fewest, most):
        design = override(PRESETS["pin"], [*AT_SPEED, LOADED, f"ring.teeth={teeth}", *TOOTHED[teeth]])
        costs[teeth] = second_cost("planar", design)
    return math.log(costs[most] / costs[fewest]) / math.log(most / fewest)


def cpu_ratio(words: tuple[str, ...], dear: tuple[str, ...], cheap: tuple[str, ...]) -> float:
    """Compute the ratio of the CPU time of a command with some flags to that with others."""
    return cpu(*words, *dear) / cpu(*words, *cheap)


def marginal_second(*words: str) -> float:
    """Compute the CPU time of an additional simulated second [s], by runs of 3 s and 1 s."""
    long, short = (cpu(*words, "--hold-s", hold) for hold in ("3", "1"))
    return 0.5 * (long - short)


def sample_cost(design: Design) -> float:
    """Measure the CPU time of one sample of `tolerance`, balanced at 360 angles under three torques [ms]."""
    reducer = Reducer(design)
    work = partial(solve_sample_batch, reducer, tolerance_zones(reducer), 0, ANGLES)
    first_batch, *rest = list_batches(SAMPLING.block)
    work((first_batch, SAMPLED))
    start = time.process_time()
    for block in rest:
        work((block, SAMPLED))
    return 1e3 * (time.process_time() - start) / sum(block.count for block in rest)


def speedup(*words: str) -> float:
    """Compute the ratio of the wall time of a command with one worker to that with two."""
    one, two = (launch(*words, "--workers", workers, "--quiet").wall for workers in ("1", "2"))
    return one / two


def flags(changes: Iterable[str]) -> tuple[str, ...]:
    """Write changes of a design as flags of a command."""
    return tuple(word for change in changes for word in ("--set", change))


def of_pin(*words: str) -> tuple[str, ...]:
    """Return a quiet command on `pin`."""
    return (*words, "--design", "pin", "--quiet")


def seconds(name: str, limit: float, *words: str) -> Demand:
    """Limit the CPU time of a command on `pin` [s]."""
    return Demand(name, limit, "s", partial(cpu, *of_pin(*words)))


COMPARED = ("compare", "pin", "nonpin", "--quiet")
AT_TEN_KILOHERTZ = ("--ramp-s", "0", *flags(("ring.pins=fixed", "settings.log_rate_hz=10000")))
SHORT_RUN = ("simulate", "--solver", "planar", "--ramp-s", "0", "--hold-s", "0.01")
TEN_SECONDS = ("--hold-s", "10", *AT_TEN_KILOHERTZ)
PLANAR = of_pin("simulate", "--solver", "planar")
BOTH_SOLVERS = ("--solver", "mujoco"), ("--solver", "planar")

DEMANDS = (
    *(
        Demand(f"MuJoCo / planar, {name}", limit, "1", partial(solver_ratio, *words), least=True)
        for name, (limit, words) in SOLVED.items()
    ),
    *(Demand(f"growth, 12 to {most} free pins", 1.0, "1", partial(cost_exponent, most)) for most in list(TOOTHED)[1:]),
    Demand("--help", 0.3, "s", partial(cpu, "--help")),
    seconds("statics", 0.9, "statics"),
    Demand("statics, the first", 7.0, "s", lambda: run_uncached(*of_pin("statics")).cpu),
    seconds("simulate, planar", 6.0, "simulate", "--solver", "planar"),
    seconds("simulate, planar, start and end", 1.5, *SHORT_RUN),
    Demand("simulate, planar, a second at 10 kHz", 0.8, "s", partial(marginal_second, *PLANAR, *AT_TEN_KILOHERTZ)),
    seconds("simulate", 19.0, "simulate"),
    Demand("all seven measures", 25.0, "s", measures_cost),
    seconds("backlash, 54 sleeved pins", 10.0, "measure", "backlash", "--quick", *flags(SLEEVED)),
    Demand("compare, MuJoCo / planar", 5.0, "1", partial(cpu_ratio, COMPARED, *BOTH_SOLVERS), least=True),
    *(
        Demand(f"a sample, {name}", 2.5, "ms", partial(sample_cost, override(PRESETS[preset], changes)))
        for name, (preset, changes) in SAMPLES.items()
    ),
    seconds("stress", 60.0, "stress"),
    Demand("stress, memory", 1400.0, "MB", partial(memory, *of_pin("stress"))),
    seconds("stress, quick", 18.0, "stress", "--quick"),
    Demand("10 s at 10 kHz, memory", 400.0, "MB", partial(memory, *PLANAR, *TEN_SECONDS)),
    *(Demand(f"two workers, {name}", 1.9, "1", partial(speedup, *words), least=True) for name, words in SHARED.items()),
)
"""All requirements. The last three are wall times, and are right only on two idle cores."""


def limits_table(passes: int) -> dict[str, dict[str, list[float]]]:
    """Measure the costs that are limited: CPU time, memory and ratios of commands and studies, with their limits.

    A `share` of 1 or less fulfils the requirement. Lines are printed as they are measured.
    """
    short = ("simulate", "--hold-s", "0.01")
    for words in (("statics",), short, (*short, "--solver", "planar")):
        launch(*of_pin(*words))
    table: dict[str, dict[str, list[float]]] = {}
    for demand in DEMANDS:
        values = [demand.measure() for _ in range(passes)]
        shares = [demand.share(value) for value in values]
        table[demand.name] = {"measured": values, "limit": [demand.limit], "share": shares}
        print(f"{demand.name}: {values} {demand.unit}, limit {demand.limit:g}", file=sys.stderr, flush=True)
    return table
