"""Warnings about the figures of a run, as sentences for terminal, page and JSON alike.

Some was known before it began; the rest is its end, its pace, its power balance and its efficiency.
"""

from collections.abc import Iterator

import numpy as np

from cycloid_mj.analysis.findings import ContactSummary, Window
from cycloid_mj.analysis.series import Series
from cycloid_mj.base.names import REDUCER
from cycloid_mj.base.powers import mean_powers
from cycloid_mj.base.record import Run
from cycloid_mj.design.units import MICROMETRE, RPM
from cycloid_mj.dynamics import timestep
from cycloid_mj.dynamics.jam import SELF_LOCKING
from cycloid_mj.dynamics.planar.timestep import FEWEST_STEPS, MOST_ROUNDS
from cycloid_mj.dynamics.regime import pace
from cycloid_mj.dynamics.swing import deepest
from cycloid_mj.reducer import Reducer

OPEN = 0.002
"""Share of the power that may be missing from the balance: what samples of it may miss. At every step it closes to some
1e-9 at any speed, at 20 kHz over whole turns of loaded reducers of nine designs to 2e-5."""

IDLING_OPEN = 0.01
"""The same of a reducer that idles, as a share of what it takes: its means are promised to that. Samples at 10 kHz miss
0.01 to 6 % of it on sixteen reducers, as parts strike each other; at every step it closes to 0.25 % in 0.2 s."""

COARSE = "the log is too coarse or the hold too short for these powers: raise settings.log_rate_hz or drive.hold_s"
"""What opens a balance."""

WHOLE_TURN = 0.99
"""Crank turns from which sampled powers of an idling reducer average out."""

IDLE = 0.01
"""Least power that a share is taken of, over the rated power or the load's: an idling reducer takes next to none."""

AFLOAT = 0.1
"""Least power that comes in, over that which goes out, where the load bears on the shaft that drives."""

DEEP = 0.5
"""Share of the allowed penetration that is worth a warning."""


def warnings(motion: Series, judged: Window, contacts: ContactSummary) -> Iterator[str]:
    """Yield the warnings of a run that was judged over a window."""
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
    limit = MICROMETRE.from_si(deepest(Reducer(design)))
    if contacts.max_penetration_um > DEEP * limit:
        yield f"contacts were {contacts.max_penetration_um:.3g} um deep; a run ends with an error at {limit:g} um"


def doubts(motion: Series) -> tuple[str, ...]:
    """Say what is doubtful in a run: what, where, and what to change; empty where nothing is."""
    run, design = motion.run, motion.design
    reducer = Reducer(design)
    # powers are all there: most columns of a run are forces, of which a copy would be as large as the run
    judged = run.of_topic(REDUCER).select(motion.whole_periods)
    powers = unbalanced(judged, reducer) if motion.phase == "hold" and len(judged) > 1 else ()
    fewest = FEWEST_STEPS if run.provenance.get("solver") == "planar" else timestep.FEWEST_STEPS
    return tuple(dict.fromkeys((*run.warnings, *pace(reducer, fewest), *unsettled(run), *powers)))


def unsettled(run: Run) -> Iterator[str]:
    """Say in how many samples of a planar run a step ended before its contacts settled."""
    if run.provenance.get("solver") != "planar" or "solver_iterations" not in run.columns:
        return
    count = int(np.count_nonzero(run["solver_iterations"] > MOST_ROUNDS))
    if count:
        yield (
            f"in {count} of {len(run)} samples a step of the planar solver ended after {MOST_ROUNDS} rounds with "
            "contacts that still changed: forces and losses there are wrong; shorten settings.timestep_us"
        )


def unbalanced(run: Run, reducer: Reducer, remedy: str = "") -> tuple[str, ...]:
    """Return warnings where the power balance of a run's samples is open, or its efficiency is 0 or impossible.

    A run that logs no losses has no balance, and over less than a crank turn sampled powers do not average out. A
    reducer whose load is not the design's may be driven through both shafts.

    Parameters
    ----------
    run, reducer
        The run, and the drive under its load.
    remedy
        What to do about it, where the log rate and the duration of the run are not those of the design; by default
        the design's keys for both.
    """
    design = reducer.design
    powers = mean_powers(run)
    idle = IDLE * design.drive.torque * abs(design.drive.speed)
    taken = max(powers.crank, powers.output, powers.lost)
    scale = max(taken, idle)
    doubtful = []
    short = _swept(run) < WHOLE_TURN
    if "kinetic_energy" in run.columns and not short:
        idles = powers.delivered <= idle
        through, most = (max(taken, IDLE * idle), IDLING_OPEN) if idles else (scale, OPEN)
        if abs(powers.missing) > most * through:
            doubtful.append(_open(powers.missing, through, abs(design.drive.speed), idles, remedy or COARSE))
    if design.load.torque and 0.0 < powers.efficiency < SELF_LOCKING:
        doubtful.append(
            f"the efficiency is {powers.efficiency:.2%}: friction takes {1.0 / powers.efficiency - 1.0:.3g} times what "
            "goes to the load; such a drive all but locks itself, check friction.*, clearances and the load"
        )
    why = remedy or ("the hold is too short to average over: lengthen drive.hold_s" if short else COARSE)
    of_load = abs(design.load.torque * design.drive.speed) / design.reduction
    if powers.supplied < AFLOAT * powers.delivered and powers.delivered > IDLE * of_load > 0.0:
        doubtful.append(
            f"the load has not settled: {powers.supplied:.3g} W drive and {powers.delivered:.3g} W go out, as parts "
            "still cross their clearances; forces and efficiency are not those of a steady state: use "
            f"{'' if remedy else 'a longer drive.hold_s, '}a larger load or smaller clearances"
        )
    if powers.supplied <= AFLOAT * powers.delivered:
        # of what floats, and of what stands still, there is no efficiency
        return tuple(doubtful)
    # without friction the efficiency is 1 to rounding and what sampled powers leave open
    most = 1.0 + (OPEN if powers.lost < OPEN * scale else 0.0)
    outside = not 0.0 <= powers.efficiency <= most if design.load.torque else powers.efficiency > most
    if design.load.torque and powers.note:
        doubtful.append(f"the efficiency is 0, {powers.note}: both shafts drive, and friction takes all; or {why}")
    if outside and (design.load.torque or max(powers.crank, powers.output) > idle):
        doubtful.append(f"the efficiency reads {powers.efficiency:.2%}, which no reducer has; {why}")
    return tuple(doubtful)


def _open(missing: float, through: float, speed: float, idles: bool, remedy: str) -> str:
    """Tell how far a balance is open, at a crank speed [rad/s], of the power that goes through it or into it [W]."""
    figures = "powers and losses" if idles else "powers, losses and efficiency"
    whose = f"{' of the idling drive' if idles else ''} at {RPM.from_si(speed):.4g} rpm"
    return (
        f"the power balance{whose} is open by {missing:.3g} W, {abs(missing) / through:.2%} of {through:.4g} W: "
        f"{figures} are off by about as much; {remedy}"
    )


def _swept(run: Run) -> float:
    angle = run["crank_angle"]
    return float(abs(angle[-1] - angle[0]) / (2.0 * np.pi) * angle.size / (angle.size - 1))


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
