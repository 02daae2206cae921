"""What the paper says of stress (Hsieh 2014, Figs 10-16), and what studies say of it: agreeing or not, and why."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from cycloid_mj.stress.findings import FIGURES, MEGAPASCAL, RANGES, PartFindings, StressFindings
from cycloid_mj.types import Array, Mask

Verdict = Literal["agrees", "disagrees"]

ORDER = ("shaft", "ring", "gear")
SHAFT_PEAKS = (75.0, 255.0)
"""Crank angles of the shaft's peaks in the paper [deg]."""

PIN_CYCLE = (10.0, 350.0)
"""Crank angles from which pin 1 is relieved, and loaded again, in the paper [deg]."""

NEAR = 10.0
"""Crank angles that are this near each other agree [deg]: a mesh period."""
PATH = {
    "ring": "; and that a pin hands its force on to a socket which it fits closely, where a lobe takes it on a line",
    "gear": "; the output pins press on the gear in the same way in both designs",
    "shaft": "; the shaft itself is the same",
}
"""What else decides between pin and nonpin, by part."""
_OUTPUT = {
    2: "the planar section: the pins' bending, as cantilevers on the disc, is not in it",
    3: "the pins bend as cantilevers on the disc, without a second disc before the gear; number, radius and length of "
    "the output pins, their fillets and the gap to the gear are assumed",
}
"""What decides the output's stress, by the dimension of its grid."""
ABOVE, FAR_BELOW = 1.1, 0.5
"""A maximum agrees with a range from half of it to a tenth above it."""
RELIEVED = 0.1
"""Pin 1 counts as relieved below this share of its largest stress."""


@dataclass(frozen=True)
class Claim:
    """One statement of the paper, what is found here, the verdict, and what decides it."""

    figure: str
    statement: str
    found: str
    verdict: Verdict
    decided_by: str

    def as_json(self) -> dict[str, Any]:
        """Give the claim as a dict of text."""
        return asdict(self)


def claims(studies: Sequence[StressFindings]) -> tuple[Claim, ...]:
    """Hold studies against the paper: each by itself, then pin against nonpin, as far as the parts are there.

    Only the paper's own designs are judged, and only without load, which is the condition of its figures.
    """
    studies = [findings for findings in studies if findings.at_the_papers_load]
    alone = [claim for findings in studies for claim in _alone(findings)]
    pin = next((findings for findings in studies if findings.ring == "pin"), None)
    nonpin = next((findings for findings in studies if findings.ring == "nonpin"), None)
    return (*alone, *(_against(pin, nonpin) if pin and nonpin else ()))


def _alone(findings: StressFindings) -> Iterator[Claim]:
    for part in ORDER:
        if part in findings:
            yield _range(findings, findings[part])
    if all(part in findings for part in ORDER):
        yield _order(findings)
    if "shaft" in findings:
        yield _shaft_peaks(findings)
    if "output" in findings:
        yield _output(findings)
    if "pin_1" in findings:
        yield _pin_cycle(findings)


def _range(findings: StressFindings, part: PartFindings) -> Claim:
    bound, found = RANGES[part.part, findings.ring], part.bulk_peak.stress / MEGAPASCAL
    ratio = found / bound
    size = f"{found:.3g} MPa at {_degrees(part):.0f} deg ({part.bulk.min() / MEGAPASCAL:.3g} at least)"
    reason = (
        f"{findings.load:.4g} N m at the output and the assumed dimensions (stress goes with the load: the paper's "
        f"value would take {1 / ratio:.2g} times as much), and {_near(part)}"
    )
    return Claim(
        FIGURES[part.part],
        f"{findings.design}: the {part.part}'s stress stays below {bound:g} MPa",
        f"bulk {size}",
        "agrees" if FAR_BELOW <= ratio <= ABOVE else "disagrees",
        reason,
    )


def _near(part: PartFindings) -> str:
    """Tell what else decides the largest stress of a part."""
    if part.part == "shaft":
        return "where the bearings stand and how the inner corners are rounded, which the paper does not tell"
    contact, near = (stress / MEGAPASCAL for stress in (part.contact_peak.stress, part.near_field))
    alone = f"; where bulk begins, the largest force alone makes {near:.3g} MPa (Flamant)" if near else ""
    return (
        f"where contact stress ends: below the patches Hertz gives {contact:.3g} MPa, of which a grid shows the more "
        f"the finer it is{alone}"
    )


def _order(findings: StressFindings) -> Claim:
    peaks = [findings[part].bulk_peak.stress / MEGAPASCAL for part in ORDER]
    contacts = ", ".join(f"{part} {findings[part].contact_peak.stress / MEGAPASCAL:.3g}" for part in ORDER)
    return Claim(
        "Figs 12-14",
        f"{findings.design}: shaft > ring > gear",
        ", ".join(f"{part} {peak:.3g} MPa" for part, peak in zip(ORDER, peaks, strict=True)),
        "agrees" if peaks[0] > peaks[1] > peaks[2] else "disagrees",
        f"the wall behind sockets or roots and the web between bore and holes, both assumed; and whether contact "
        f"stress is counted (by Hertz: {contacts} MPa)",
    )


def _shaft_peaks(findings: StressFindings) -> Claim:
    shaft = findings["shaft"]
    degrees = np.degrees(shaft.angle)
    orders = [order for order in (1, 2, shaft.teeth) if 2 * order < shaft.angle.size]
    amplitudes = shaft.orders(tuple(orders)) / MEGAPASCAL
    best = [float(degrees[np.argmax(np.where(half, shaft.bulk, -np.inf))]) for half in _halves(degrees)]
    found = (
        f"largest of each half turn at {best[0]:.0f} and {best[1]:.0f} deg; amplitudes of orders "
        f"{', '.join(map(str, orders))}: {', '.join(f'{size:.2g}' for size in amplitudes)} MPa about a mean of "
        f"{shaft.bulk.mean() / MEGAPASCAL:.3g}"
    )
    agrees = all(_is_near(np.array(best), peak) for peak in SHAFT_PEAKS) and int(np.argmax(amplitudes)) == 1
    return Claim(
        FIGURES["shaft"],
        f"{findings.design}: two peaks a turn, near 75 and 255 deg, the highest at 74 deg",
        found,
        "agrees" if agrees else "disagrees",
        "the cam's force turns with the crank: in the shaft's frame it stands still but for the mesh, the output pins "
        "and gravity, so nothing in the geometry makes order 2; it would take supports or loads fixed in the room",
    )


def _output(findings: StressFindings) -> Claim:
    output = findings["output"]
    others = [findings[part].bulk_peak.stress for part in ORDER if part in findings]
    found, share = output.bulk_peak.stress, np.ptp(output.bulk) / output.bulk.mean()
    low = not others or found < max(others)
    return Claim(
        FIGURES["output"],
        f"{findings.design}: the output's stress is low and regular",
        f"at most {found / MEGAPASCAL:.3g} MPa, peak to peak {share:.0%} of its mean",
        "agrees" if low else "disagrees",
        _OUTPUT[output.dimension],
    )


def _pin_cycle(findings: StressFindings) -> Claim:
    pin = findings["pin_1"]
    degrees = np.mod(np.degrees(pin.angle), 360.0)
    loaded = pin.bulk > RELIEVED * pin.bulk.max()
    order = np.argsort(degrees)
    degrees, loaded = degrees[order], loaded[order]
    changes = np.flatnonzero(loaded != np.roll(loaded, 1))
    told = ", ".join(f"{'loaded' if loaded[i] else 'relieved'} from {degrees[i]:.0f} deg" for i in changes)
    told = told or ("always loaded" if loaded.all() else "never loaded")
    starts, ends = (degrees[[i for i in changes if loaded[i] == wanted]] for wanted in (True, False))
    agrees = bool(loaded[0]) and _is_near(ends, PIN_CYCLE[0]) and _is_near(starts, PIN_CYCLE[1])
    return Claim(
        FIGURES["pin_1"],
        f"{findings.design}: pin 1 is loaded at 0, relieved by 10 deg, loaded again from 350 deg",
        f"{told}; {loaded.mean():.0%} of the turn under load, most at {_degrees(pin):.0f} deg",
        "agrees" if agrees else "disagrees",
        "load sharing: half of the pins carry at a time where clearances are as small as the deflections, so each "
        "carries for half a turn; 20 deg of 360 would mean two loaded pins, as with larger clearances or less load",
    )


def _against(pin: StressFindings, nonpin: StressFindings) -> Iterator[Claim]:
    """Hold the pin design's stress against the nonpin's, part by part."""
    for part in ORDER:
        if part not in pin or part not in nonpin:
            continue
        ours = [findings[part].bulk_peak.stress / MEGAPASCAL for findings in (pin, nonpin)]
        forces = [findings[part].largest_force for findings in (pin, nonpin)]
        theirs = RANGES[part, "nonpin"] / RANGES[part, "pin"]
        yield Claim(
            FIGURES[part],
            f"{part}: less stress in {nonpin.design} than in {pin.design} (ranges {theirs:.2g} to 1)",
            f"{ours[1]:.3g} against {ours[0]:.3g} MPa, {ours[1] / ours[0]:.2g} to 1",
            "agrees" if ours[1] < ours[0] else "disagrees",
            f"the largest force of one contact, {forces[1]:.3g} N against {forces[0]:.3g} N "
            f"({forces[1] / forces[0]:.2g} to 1) under {nonpin.load:.4g} and {pin.load:.4g} N m{PATH.get(part, '')}",
        )


def _is_near(degrees: Array, wanted: float) -> bool:
    return bool(np.any(np.abs(_wrapped(degrees - wanted)) <= NEAR))


def _degrees(part: PartFindings) -> float:
    return float(np.degrees(part.bulk_peak.angle))


def _wrapped(degrees: npt.ArrayLike) -> Array:
    return np.mod(np.asarray(degrees, float) + 180.0, 360.0) - 180.0


def _halves(degrees: Array) -> tuple[Mask, Mask]:
    first = np.mod(degrees, 360.0) < 180.0
    return first, ~first
