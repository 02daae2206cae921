"""What a reader of a run should know before he trusts its figures: sentences, for a terminal, a page and JSON alike."""

from collections.abc import Iterator

from cycloid_mj.analysis.doubts import doubts
from cycloid_mj.analysis.findings import ContactSummary, Window
from cycloid_mj.analysis.series import Series
from cycloid_mj.design.units import MICROMETRE, RPM

DEEP = 0.5
"""Share of the allowed penetration that is worth a warning."""


def warnings(motion: Series, judged: Window, contacts: ContactSummary) -> Iterator[str]:
    """Give the warnings of a run that was judged over a window."""
    run, design = motion.run, motion.design
    if not run.complete:
        yield f"the run did not reach its end: {run.note or 'no reason is known'}"
    elif run.note:
        yield run.note
    if judged.phase == "ramp":
        yield _ended_in_ramp(motion)
    elif _turns(judged) < 1.0:
        yield _short(motion, judged)
    yield from doubts(motion)
    limit = MICROMETRE.from_si(design.contact.max_penetration)
    if contacts.max_penetration_um > DEEP * limit:
        yield f"contacts were {contacts.max_penetration_um:.3g} um deep; a run ends with an error at {limit:g} um"


def _ended_in_ramp(motion: Series) -> str:
    drive = motion.design.drive
    reached = RPM.from_si(float(motion.crank_speed.simulated[-1]))
    return (
        f"the run ended in its ramp, at {motion.time[-1]:.4g} of {drive.ramp:g} s and {reached:.4g} of"
        f" {RPM.from_si(drive.speed):g} rpm: its figures are of the ramp, over all speeds up to there; what is missing"
        " is everything at constant speed, efficiency too"
    )


def _short(motion: Series, judged: Window) -> str:
    speed = abs(motion.design.drive.speed)
    settled = judged.start_s - motion.design.drive.ramp
    needed = f"; a turn takes {settled + 6.2832 / speed:.2g} s of hold, settling included" if speed else ""
    return (
        f"only {judged.crank_turns:.2f} crank turns at constant speed were judged: means and peaks are those of part"
        f" of a turn{needed}"
    )


def _turns(judged: Window) -> float:
    """Crank turns with the odd share of one sample."""
    return judged.crank_turns * judged.samples / max(judged.samples - 1, 1) + 1e-6
