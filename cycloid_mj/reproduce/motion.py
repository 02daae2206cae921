"""Figs 5-9: input law, gear speed, path and velocity of q, pin 1; and the claims on ratio, speed and pin 1."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from cycloid_mj.analysis import Series, judge, series
from cycloid_mj.comparison import load_words, settled, settling
from cycloid_mj.comparison.fluctuation import turns
from cycloid_mj.measure import Table
from cycloid_mj.reproduce.claims import Claim, judged
from cycloid_mj.reproduce.plan import LOGGED, Plan, designs, main_runs, ramped
from cycloid_mj.reproduce.stage import Found, Plate, Runs, Told

ARCSEC = np.degrees(1.0) * 3600.0
SPEED_ERROR = 1e-3
"""The mean gear speed agrees with the ratio within this share."""


def motions(plan: Plan, runs: Runs) -> list[Series]:
    """Give the main runs beside their closed form, at every logged sample."""
    return [settled(run) for run in runs(main_runs(plan))]


def input_law(plan: Plan, runs: Runs, told: Told) -> Found:
    """Fig. 5: the crank's speed over time."""
    from cycloid_mj.plots.motion import input_figure

    cases = [ramped(design) for design in designs()] if plan.ramp else main_runs(plan)[:2]
    found = [series(run) for run in runs(cases)]
    what = "ramp of 1 s, then constant" if plan.ramp else "QUICK: from full speed, without the ramp"
    plates = [
        Plate(
            f"fig5_input_{one.design.name}",
            "Fig. 5",
            f"{one.design.name}: speed of the crank, {what}; below, how far the servo is off the law.",
            input_figure(one),
        )
        for one in found
    ]
    off = {one.design.name: float(np.abs(one.crank_speed.error).max()) for one in found}
    note = "The paper's law: 0 to 1640 rpm (9840 deg/s, 171.74 rad/s) in a linear ramp of 1 s, then constant."
    return Found(tuple(plates), findings={"largest_error_rad_s": off, "ramp": plan.ramp}, notes=(note,))


def gear_speed(plan: Plan, runs: Runs, told: Told) -> Found:
    """Fig. 6: the angular velocity of the cycloid gear."""
    from cycloid_mj.plots.motion import gear_speed_figure

    found = motions(plan, runs)
    words = "angular velocity of the cycloid gear over a crank turn, with -omega_i/35 (Eq. 12); below, the difference"
    return Found(
        _plates(found, "fig6_gear_speed", "Fig. 6", words, gear_speed_figure),
        (_table(found),),
        (_ratio(found),),
        {_key(one): _numbers(one) for one in found},
        ("The paper: the gear turns at 4.907 rad/s against the crank, with small fluctuations, larger with pins.",),
    )


def q_path(plan: Plan, runs: Runs, told: Told) -> Found:
    """Fig. 7: the path of q, with a local magnification."""
    from cycloid_mj.plots.point import path_figure

    words = "path of q, the centre of hole 1, with Eq. 16 and the place where they differ most, magnified"
    note = "The paper magnifies its path to show that the simulated point strays from the closed form, more with pins."
    return Found(_plates(motions(plan, runs), "fig7_q_path", "Fig. 7", words, path_figure), notes=(note,))


def q_velocity(plan: Plan, runs: Runs, told: Told) -> Found:
    """Fig. 8: the velocity of q and its error."""
    from cycloid_mj.plots.point import velocity_figure

    words = "velocity of q with Eqs 17 and 18 (corrected), and its error"
    note = "The paper: both designs follow the closed form; the velocity fluctuates more with pins."
    return Found(_plates(motions(plan, runs), "fig8_q_velocity", "Fig. 8", words, velocity_figure), notes=(note,))


def pin_1(plan: Plan, runs: Runs, told: Told) -> Found:
    """Fig. 9: spin and centre of pin 1."""
    from cycloid_mj.plots.pin import pin_figure

    found = [one for one in motions(plan, runs) if one.pin_1]
    words = "centre of pin 1 in its socket (dashed: the clearance), its distance from the middle, and its spin"
    plates = _plates(found, "fig9_pin_1", "Fig. 9", words, lambda one: pin_figure(one, _pin(one)))
    note = "The paper: pin 1 sways within its clearance and turns; the nonpin design has no such part."
    return Found(plates, claims=tuple(_pin_claims(found)), notes=(note,))


def _plates(
    found: Sequence[Series], name: str, figure: str, words: str, draw: Callable[[Series], Any]
) -> tuple[Plate, ...]:
    """Draw each run at the paper's sampling."""
    return tuple(
        Plate(f"{name}_{_key(one)}", figure, f"{one.design.name}, {_load(one)}: {words}.", draw(_sampled(one)))
        for one in found
    )


def _sampled(motion: Series) -> Series:
    """Give a run at one sample for each degree."""
    return series(motion.run.select(slice(None, None, LOGGED)), motion.q, settling(motion.design))


def _load(motion: Series) -> str:
    return load_words(motion.design.load.torque)


def _key(motion: Series) -> str:
    return f"{motion.design.name}_{'loaded' if motion.design.load.torque else 'unloaded'}"


def _pin(motion: Series) -> Any:
    return motion.pin_1


def _numbers(motion: Series) -> dict[str, float]:
    found = judge(motion)
    return {
        "gear_speed_mean_rad_s": found.gear_speed.mean_rad_s,
        "gear_speed_rms_error_rad_s": found.gear_speed.rms_error_rad_s,
        "q_path_rms_error_um": found.q_path.rms_error_um,
        "q_path_max_error_um": found.q_path.max_error_um,
        "q_velocity_rms_error_mm_s": found.q_speed.rms_error_mm_s,
        "transmission_error_arcsec": found.transmission_error.peak_to_peak_arcsec,
        "contacts_mean": found.contact_summary.mean_active,
        "peak_force_n": found.contact_summary.peak_force_n,
    }


ROWS = {
    "gear_speed_mean_rad_s": "gear speed, mean [rad/s]",
    "gear_speed_rms_error_rad_s": "gear speed, rms error [rad/s]",
    "q_path_rms_error_um": "path of q, rms error [um]",
    "q_path_max_error_um": "path of q, largest error [um]",
    "q_velocity_rms_error_mm_s": "velocity of q, rms error [mm/s]",
    "transmission_error_arcsec": "transmission error, peak to peak [arcsec]",
    "contacts_mean": "contacts that carry force, mean",
    "peak_force_n": "largest force of a contact [N]",
}


def _table(found: Sequence[Series]) -> Table:
    numbers = [_numbers(one) for one in found]
    head = ("over the settled turns", *(f"{one.design.name}, {_load(one)}" for one in found))
    return Table(
        "Figs 6-8 in numbers", head, tuple((words, *(one[key] for one in numbers)) for key, words in ROWS.items())
    )


def _ratio(found: Sequence[Series]) -> Claim:
    """Hold the mean gear speed against the ratio; its error is the scatter of the turns."""
    ratios = {_key(one): _ratios(one) for one in found}
    means = {key: float(np.mean(each)) for key, each in ratios.items()}
    scatter = max(float(np.std(each) / np.sqrt(len(each))) for each in ratios.values())
    lobes = found[0].design.lobes
    speed = {_key(one): float(np.mean(one.gear_speed.simulated[one.whole_periods])) for one in found}
    low, high = min(means.values()), max(means.values())
    slowest, fastest = sorted(abs(value) for value in (min(speed.values()), max(speed.values())))
    return Claim(
        "Eq. 12, Fig. 6",
        "the gear turns at 1/35 of the crank, against it",
        "35 : 1, 4.907 rad/s",
        f"{low:.4f} to {high:.4f} : 1, {slowest:.4f} to {fastest:.4f} rad/s",
        f"{scatter:.1g} : 1 (scatter of the turns)",
        judged([abs(mean / lobes - 1.0) < SPEED_ERROR for mean in means.values()]),
        "nothing: the number of teeth",
        "both designs, at no load and under the rated load",
        {f"ratio_{key}": value for key, value in means.items()},
    )


def _ratios(motion: Series) -> list[float]:
    """Give crank over gear turn, against each other, for each settled crank turn."""
    crank, gear = motion.crank_angle, motion.run["gear_angle"]
    ends = [(part.start, min(part.stop, crank.size - 1)) for part in turns(motion)]
    return [float(-(crank[stop] - crank[start]) / (gear[stop] - gear[start])) for start, stop in ends]


def _pin_claims(found: Sequence[Series]) -> list[Claim]:
    sway = {_key(one): 1e6 * _span(_pin(one).position[one.hold]) for one in found}
    reach = {_key(one): 1e6 * float(_pin(one).radial[one.hold].max()) for one in found}
    spin = {_key(one): [float(np.mean(_pin(one).spin[part])) for part in turns(one)] for one in found}
    clearance = 1e6 * _pin(found[0]).clearance
    size = ", ".join(
        f"{key.split('_')[1]} {value:.2f} um across, {reach[key]:.2f} um out" for key, value in sway.items()
    )
    rms = {_key(one): float(np.sqrt(np.mean(_pin(one).spin[one.hold] ** 2))) for one in found}
    turn = ", ".join(
        f"{key.split('_')[1]} {np.mean(each):.3g} rad/s (rms {rms[key]:.3g})" for key, each in spin.items()
    )
    scatter = max(float(np.std(each) / np.sqrt(len(each))) for each in spin.values())
    return [
        Claim(
            "Fig. 9",
            "pin 1 sways within its clearance",
            "within 0.001 mm",
            f"{size}; clearance {clearance:g} um",
            f"{_scatter(found):.1g} um (turn to turn)",
            judged([value > 0.1 * clearance for value in sway.values()]),
            "nothing: within the clearance, to which under load the give of the socket adds",
            "Fig. 9 at no load and under load",
            {f"sway_um_{key}": value for key, value in sway.items()},
        ),
        Claim(
            "Fig. 9",
            "pin 1 turns about itself",
            "yes",
            f"on average: {turn}",
            f"{scatter:.1g} rad/s (scatter of the turns)",
            judged([abs(float(np.mean(each))) > 2 * scatter for each in spin.values()]),
            "load, and friction: an idle pin only rocks; under load the gear's flank rolls on it",
            "Fig. 9 at no load and under load; spin by friction in the table of mean spin, pin against nonpin",
            {f"spin_rad_s_{key}": float(np.mean(each)) for key, each in spin.items()},
        ),
    ]


def _span(position: Any) -> float:
    return float(np.ptp(position, axis=0).max())


def _scatter(found: Sequence[Series]) -> float:
    """Give by how much pin 1's largest distance differs between turns, standard error [um]."""
    reach = [[1e6 * float(_pin(one).radial[part].max()) for part in turns(one)] for one in found]
    return max(float(np.std(each) / np.sqrt(len(each))) for each in reach)
