"""Checks of a design: whether it can be built, and how well it works, each with its reason and remedy.

Symbols: N ring teeth, c eccentricity, E pin-circle radius, rho pin radius [m]. As in the parts, the clearance is cut
from the disc (profile and holes) or added to sockets and bore. A design that cannot be manufactured, assembled or
turned fails a check. Limits without a source are assumed and stated as such, and cause warnings:
``TEETH.min_wall_share``, ``TEETH.min_core_share``, ``MECHANICS.max_clearance_share``, ``MECHANICS.overload`` and
``PLAUSIBLE``, and those of `margin` and `strength`.
"""

from collections.abc import Iterator
from itertools import chain

from cycloid_mj.base.errors import DesignError
from cycloid_mj.checks.assembly import assembly_checks
from cycloid_mj.checks.body import balance_rules, body_rules
from cycloid_mj.checks.casing import casing_checks
from cycloid_mj.checks.check import Check, Checks
from cycloid_mj.checks.limit import Limit
from cycloid_mj.checks.margin import margin_rules
from cycloid_mj.checks.mechanics import PLAUSIBLE, jumps, mechanical_rules
from cycloid_mj.checks.multi_disc import disc_checks
from cycloid_mj.checks.rule import evaluate
from cycloid_mj.checks.rv import rv_checks
from cycloid_mj.checks.strength import strength_checks
from cycloid_mj.checks.summary import Summary, summarize
from cycloid_mj.checks.teeth import WALLS, tooth_rules
from cycloid_mj.checks.tolerance import tolerance_checks
from cycloid_mj.design import Named, resolve
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of

__all__ = [
    "PLAUSIBLE",
    "WALLS",
    "Check",
    "Checks",
    "Limit",
    "MECHANICS.max_clearance_share",
    "MECHANICS.overload",
    "Summary",
    "TEETH.min_wall_share",
    "check",
    "jumps",
    "require_sound",
    "shape_checks",
    "sound_checks",
    "soundness",
    "summarize",
]


def check(design: Named) -> Checks:
    """Check whether a design can be built, and how well it works; return all checks, passed and failed.

    Checks of how well it works fail with warnings only. They are left out for a design that cannot be built, and for an
    RV reducer. The checks of load capacity and life are in ``life.checks``.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file.

    Raises
    ------
    UsageError
        The design does not exist.
    DesignError
        The file is not a valid design.
    """
    design = resolve(design)
    reducer = reducer_of(design)
    feasibility_checks = soundness(reducer)
    if isinstance(reducer, RvReducer) or any(
        feasibility_check.severity == "error" and not feasibility_check.passed
        for feasibility_check in feasibility_checks
    ):
        return Checks(feasibility_checks)
    margin_checks = evaluate(reducer, margin_rules(reducer))
    quality_checks = (*disc_checks(reducer), *margin_checks, *tolerance_checks(reducer), *strength_checks(reducer))
    return Checks((*feasibility_checks, *quality_checks, *casing_checks(reducer)))


def soundness(reducer: Reducer) -> tuple[Check, ...]:
    """Return the checks of whether a design can be built and turned.

    Checks that depend on a failed check are left out: undercut of a profile with loops, balance and assembly of a disc
    that cannot be manufactured.
    """
    return tuple(sound_checks(reducer))


def sound_checks(reducer: Reducer) -> Iterator[Check]:
    """Yield the checks whether a design can be built, without statics, one by one as they are computed.

    The checks are the same as in `soundness`; an iterator lets a search stop at the first failure.
    """
    if isinstance(reducer, RvReducer):
        yield from rv_checks(reducer)
        return
    design = reducer.design
    has_shape = design.gear.discs > 1 or design.shaft.radius < design.shaft.counterweight_radius
    for shape_check in shape_checks(reducer):
        has_shape &= shape_check.passed or shape_check.severity == "warning"
        yield shape_check
    if has_shape:
        yield from evaluate(reducer, balance_rules(reducer))
        yield from assembly_checks(reducer)
    yield from evaluate(reducer, mechanical_rules(reducer, has_shape))


def shape_checks(reducer: Reducer) -> Iterator[Check]:
    """Yield the checks of the shape of disc and ring, which all other checks require to pass."""
    return evaluate(reducer, chain(tooth_rules(reducer), body_rules(reducer)))


def require_sound(reducer: Reducer) -> None:
    """Raise DesignError with a line for each failed check of `soundness`; warnings do not count."""
    failures = Checks(soundness(reducer)).failures
    if failures:
        raise DesignError(f"the design {reducer.design.name!r} cannot be built:", map(str, failures))
