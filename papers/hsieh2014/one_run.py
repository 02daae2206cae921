"""Comparison of stress studies of single runs with Figs 12-16 of the paper, for ``cycloid-mj stress``."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.base.result import Claim, Value
from cycloid_mj.base.units import MEGAPASCAL
from cycloid_mj.stress.findings import PartFindings, StressFindings
from hsieh2014 import statements
from hsieh2014.cycle import RELIEVED
from hsieh2014.plan import no_load
from hsieh2014.stated import HEIGHTS, LEAST, MOST, NEAR, ORDER, PIN_1_LOADED, SHAFT_PEAKS
from hsieh2014.verdicts import majority_verdict

ALSO = {
    "ring": "; and that a pin hands its force on to a socket which it fits closely, where a lobe takes it on a line",
    "gear": "; the output pins press on the gear in the same way in both designs",
    "shaft": "; the shaft itself is the same",
}
"""Further causes of the difference between pin and nonpin, by part."""
OUTPUT = {
    2: "the planar section: the pins' bending, as cantilevers on the disc, is not in it",
    3: "the pins bend as cantilevers on the disc, without a second disc before the gear; number, radius and length of "
    "the output pins, their fillets and the gap to the gear are assumed",
}
"""Causes of the output's stress, by the dimension of its grid."""


def claims(studies: Sequence[StressFindings]) -> tuple[Claim, ...]:
    """Judge the claims of the paper by studies of its designs: each design, then pin against nonpin for each part.

    Only studies without load are judged, which is the condition of the paper's figures.
    """
    studies = [findings for findings in studies if findings.load == no_load().load]
    by_ring = {findings.ring: findings for findings in reversed(studies)}
    judged = [claim for findings in studies for claim in _design_claims(findings)]
    if by_ring.keys() >= {"pin", "nonpin"}:
        judged += _design_comparisons(by_ring["pin"], by_ring["nonpin"])
    return tuple(judged)


def _design_claims(findings: StressFindings) -> Iterator[Claim]:
    """Yield the claims on a single design: maximum stress and order of the parts, and patterns over the turn."""
    parts = [part for part in ORDER if part in findings]
    yield from (_judge_height(findings, findings[part]) for part in parts)
    if len(parts) == len(ORDER):
        yield _judge_order(findings)
    for part, judge in (("shaft", _judge_shaft_peaks), ("output", _judge_output), ("pin_1", _judge_pin_cycle)):
        if part in findings:
            yield judge(findings)


def _judge(statement: statements.Statement, name: str, value: str, holds: bool, decided_by: str) -> Claim:
    """Judge a statement on the design or part `name`: it agrees if it `holds`, otherwise it disagrees.

    `value` and `decided_by` are result and cause in words. The tables of the study contain the numerical errors.
    """
    renamed = replace(statement, claim=f"{name}: {statement.claim}")
    return renamed.judge(Value(value), Value("one more refinement"), majority_verdict([holds]), decided_by)


def _judge_height(findings: StressFindings, part: PartFindings) -> Claim:
    """Judge whether a part's largest bulk stress is from 0.5 to 1.1 times the paper's maximum."""
    name, bound, height = findings.design, HEIGHTS[part.part, findings.ring], part.bulk_peak.stress / MEGAPASCAL
    ratio = height / bound
    return _judge(
        replace(
            statements.stress_height(part.part, findings.ring),
            claim=f"the {part.part}'s stress stays below {bound:g} MPa",
        ),
        name,
        f"bulk {height:.3g} MPa at {_degrees(part):.0f} deg ({part.bulk.min() / MEGAPASCAL:.3g} at least)",
        LEAST <= ratio <= MOST,
        f"{findings.load:.4g} N m at the output and the assumed dimensions (stress goes with the load: the paper's "
        f"value would take {1 / ratio:.2g} times as much), and {_describe_other_causes(part)}",
    )


def _describe_other_causes(part: PartFindings) -> str:
    """Return in words what decides the largest stress of a part besides its load and its dimensions."""
    if part.part == "shaft":
        return "where the bearings stand and how the inner corners are rounded, which the paper does not tell"
    contact, near = (stress / MEGAPASCAL for stress in (part.contact_peak.stress, part.near_field))
    alone = f"; where bulk begins, the largest force alone makes {near:.3g} MPa (Flamant)" if near else ""
    return (
        f"where contact stress ends: below the patches Hertz gives {contact:.3g} MPa, of which a grid shows the more "
        f"the finer it is{alone}"
    )


def _judge_order(findings: StressFindings) -> Claim:
    """Judge whether shaft, ring and gear are in the paper's order by stress."""
    peaks = [findings[part].bulk_peak.stress / MEGAPASCAL for part in ORDER]
    contacts = ", ".join(f"{part} {findings[part].contact_peak.stress / MEGAPASCAL:.3g}" for part in ORDER)
    return _judge(
        statements.stress_of_parts(findings.ring),
        findings.design,
        ", ".join(f"{part} {peak:.3g} MPa" for part, peak in zip(ORDER, peaks, strict=True)),
        peaks[0] > peaks[1] > peaks[2],
        f"the wall behind sockets or roots and the web between bore and holes, both assumed; and whether contact "
        f"stress is counted (by Hertz: {contacts} MPa)",
    )


def _judge_shaft_peaks(findings: StressFindings) -> Claim:
    """Judge whether the shaft's stress peaks near the paper's two angles."""
    shaft = findings["shaft"]
    degrees = np.degrees(shaft.angle)
    orders = [order for order in (1, 2, shaft.teeth) if 2 * order < shaft.angle.size]
    amplitudes = shaft.orders(tuple(orders)) / MEGAPASCAL
    first = np.mod(degrees, 360.0) < 180.0
    best = [float(degrees[np.argmax(np.where(half, shaft.bulk, -np.inf))]) for half in (first, ~first)]
    return _judge(
        statements.stress_peaks(findings.ring),
        findings.design,
        f"largest of each half turn at {best[0]:.0f} and {best[1]:.0f} deg; amplitudes of orders "
        f"{', '.join(map(str, orders))}: {', '.join(f'{size:.2g}' for size in amplitudes)} MPa about a mean of "
        f"{shaft.bulk.mean() / MEGAPASCAL:.3g}",
        all(_is_near(best, peak) for peak in SHAFT_PEAKS) and int(np.argmax(amplitudes)) == 1,
        "the cam's force turns with the crank: in the shaft's frame it stands still but for the mesh, the output pins "
        "and gravity, so nothing in the geometry makes order 2; it would take supports or loads fixed in the room",
    )


def _judge_output(findings: StressFindings) -> Claim:
    """Judge whether the output's stress is low and regular."""
    output = findings["output"]
    others = [findings[part].governing for part in ORDER if part in findings]
    governing, share = output.governing, np.ptp(output.bulk) / output.bulk.mean()
    return _judge(
        statements.stress_of_output(findings.ring),
        findings.design,
        f"at most {governing / MEGAPASCAL:.3g} MPa, peak to peak {share:.0%} of its mean",
        not others or governing < max(others),
        OUTPUT[output.dimension],
    )


def _judge_pin_cycle(findings: StressFindings) -> Claim:
    """Judge whether pin 1 is loaded only near crank angle 0."""
    pin = findings["pin_1"]
    degrees = np.mod(np.degrees(pin.angle), 360.0)
    order = np.argsort(degrees)
    degrees, loaded = degrees[order], (pin.bulk > RELIEVED * pin.bulk.max())[order]
    changes = np.flatnonzero(loaded != np.roll(loaded, 1))
    cycle = ", ".join(f"{'loaded' if loaded[i] else 'relieved'} from {degrees[i]:.0f} deg" for i in changes)
    cycle = cycle or ("always loaded" if loaded.all() else "never loaded")
    begins, ends = (degrees[changes[loaded[changes] == wanted]] for wanted in (True, False))
    return _judge(
        statements.PIN_1_CYCLE,
        findings.design,
        f"{cycle}; {loaded.mean():.0%} of the turn under load, most at {_degrees(pin):.0f} deg",
        bool(loaded[0]) and _is_near(begins, PIN_1_LOADED[0]) and _is_near(ends, PIN_1_LOADED[1]),
        "load sharing: half of the pins carry at a time where clearances are as small as the deflections, so each "
        "carries for half a turn; 20 deg of 360 would mean two loaded pins, as with larger clearances or less load",
    )


def _design_comparisons(pin: StressFindings, nonpin: StressFindings) -> Iterator[Claim]:
    """Yield the claims, for each part of both designs, that it has less stress in the nonpin design."""
    for part in ORDER:
        if part not in pin or part not in nonpin:
            continue
        sizes = [findings[part].bulk_peak.stress / MEGAPASCAL for findings in (pin, nonpin)]
        forces = [findings[part].largest_force for findings in (pin, nonpin)]
        stated = statements.stress_of_designs(part)
        words = f"less stress in {nonpin.design} than in {pin.design} (ranges {stated.stated.text})"
        yield _judge(
            replace(stated, claim=words),
            part,
            f"{sizes[1]:.3g} against {sizes[0]:.3g} MPa, {sizes[1] / sizes[0]:.2g} to 1",
            sizes[1] < sizes[0],
            f"the largest force of one contact, {forces[1]:.3g} N against {forces[0]:.3g} N "
            f"({forces[1] / forces[0]:.2g} to 1) under {nonpin.load:.4g} and {pin.load:.4g} N m{ALSO.get(part, '')}",
        )


def _is_near(degrees: npt.ArrayLike, wanted: float) -> bool:
    """Return whether any crank angle [deg] is close to the wanted one, modulo a turn."""
    apart: Array = np.mod(np.asarray(degrees, float) - wanted + 180.0, 360.0) - 180.0
    return bool(np.any(np.abs(apart) <= NEAR))


def _degrees(part: PartFindings) -> float:
    return float(np.degrees(part.bulk_peak.angle))
