"""Whether a design can be built, and how well it would work: each check with its reason and remedy.

Symbols: N ring teeth, c eccentricity, E pin-circle radius, rho pin radius [m]. As in the parts, the clearance is cut
from the gear (profile and holes) or added to sockets and bore. Where no source sets a limit it is assumed here and
stated, and what misses it is warned of: ``WALL_SHARE``, ``LEAST_CORE``, ``PLAY_SHARE``, ``OVERLOAD`` and ``PLAUSIBLE``,
and those of `margin` and `strength`. An error is what cannot be made, put together or turned.
"""

from collections.abc import Iterator
from itertools import chain

from cycloid_mj.base.errors import DesignError
from cycloid_mj.checks.assembly import assembly_checks
from cycloid_mj.checks.body import body_rules, whole_rules
from cycloid_mj.checks.limit import Check, Checks, Limit, judged
from cycloid_mj.checks.margin import margin_rules
from cycloid_mj.checks.mechanics import OVERLOAD, PLAUSIBLE, PLAY_SHARE, jumps, mechanical_rules
from cycloid_mj.checks.multi_disc import disc_checks
from cycloid_mj.checks.strength import strength_checks
from cycloid_mj.checks.summary import Summary, summary
from cycloid_mj.checks.teeth import WALL_SHARE, WALLS, tooth_rules
from cycloid_mj.checks.tolerance import tolerance_checks
from cycloid_mj.design import Named, resolve
from cycloid_mj.reducer import Reducer

__all__ = [
    "OVERLOAD",
    "PLAUSIBLE",
    "PLAY_SHARE",
    "WALLS",
    "WALL_SHARE",
    "Check",
    "Checks",
    "Limit",
    "Summary",
    "check",
    "jumps",
    "require_sound",
    "shape_checks",
    "sound_checks",
    "soundness",
    "summary",
]


def check(design: Named) -> Checks:
    """List every check of a design, passed or not: those of `soundness`, then those that decide how good it is.

    The latter need a design without errors, and are all warnings.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file: what is checked.
    """
    design = resolve(design)
    reducer = Reducer(design)
    sound = soundness(reducer)
    if any(item.severity == "error" and not item.passed for item in sound):
        return Checks(sound)
    margins = judged(reducer, margin_rules(reducer))
    good = (*disc_checks(reducer), *margins, *tolerance_checks(reducer), *strength_checks(reducer))
    return Checks((*sound, *good))


def soundness(reducer: Reducer) -> tuple[Check, ...]:
    """List the checks of whether a design can be built and would turn.

    What rests on a failed check is left out: undercut where there are loops, balance and assembly of an unsound gear.
    """
    return tuple(sound_checks(reducer))


def sound_checks(reducer: Reducer) -> Iterator[Check]:
    """Yield the checks of `soundness`, each as it is made: who looks for a failed one need not wait for all."""
    design = reducer.design
    whole = design.gear.discs > 1 or design.shaft.radius < design.shaft.counterweight_radius
    for item in shape_checks(reducer):
        whole &= item.passed or item.severity == "warning"
        yield item
    if whole:
        yield from judged(reducer, whole_rules(reducer))
        yield from assembly_checks(reducer)
    yield from judged(reducer, mechanical_rules(reducer, whole))


def shape_checks(reducer: Reducer) -> Iterator[Check]:
    """Yield the checks of `soundness` of the shape of gear and ring, on which the others rest."""
    return judged(reducer, chain(tooth_rules(reducer), body_rules(reducer)))


def require_sound(reducer: Reducer) -> None:
    """Raise DesignError with a line for each failed check of `soundness`; warnings pass."""
    failed = [item for item in soundness(reducer) if not item.passed and item.severity == "error"]
    if failed:
        raise DesignError(f"the design {reducer.design.name!r} cannot be built:", map(str, failed))
