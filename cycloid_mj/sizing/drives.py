"""Drives for a requirement: the answer of the search with its figures, reasons and remedies."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

from cycloid_mj.figures import figure
from cycloid_mj.life.rated import rated_and_momentary_torque
from cycloid_mj.life.sheet_rows import backlash_with_bearings
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.sizing.answer import Answer, SizedDrive
from cycloid_mj.sizing.reasons import reasons_of
from cycloid_mj.sizing.remedies import remedies
from cycloid_mj.sizing.requirement import Requirement
from cycloid_mj.sizing.search import SETTINGS, Rated
from cycloid_mj.sizing.solve import Trial, solve
from cycloid_mj.statics import loads, springs_of
from cycloid_mj.statics.springs import turn_evenly

MIN_DIFFERENCE = 1.05
"""Ratio of stiffness or life from which a drive is shown next to the lightest (heuristic)."""


LIGHTEST = f"lowest losses among the drives within {SETTINGS.mass_tolerance:.0%} of the lowest mass"
"""Why the first drive is shown."""

WHY = {
    "stiffest": "highest stiffness of the candidates",
    "longest life": "longest life of the candidates",
    "stiffest and longest life": "highest stiffness and longest life of the candidates",
}
"""Why a drive is shown next to the lightest, by what it is best in."""


def size_drive(requirement: Requirement, on_progress: Callable[[Answer], None] = lambda _: None) -> Answer:
    """Find drives that meet a requirement; if there are none, find the largest torque that its other values allow.

    `on_progress` is called with an answer that has the first drive. If there is none, it is called with the refusal
    when its largest torque is known, and again after each remedy that is added to it.
    """
    solution, answer, pool = solve(requirement)
    if solution:
        first_drive = _sized_drive(solution, solution.best, "lightest", LIGHTEST)
        on_progress(Answer(requirement, (first_drive,)))
        return Answer(solution.pool.requirement, (first_drive, *_other_drives(solution, solution.best)))
    longer_changes, answer = answer.remedies, replace(answer, remedies=())  # listed after what is easier to change
    on_progress(answer)
    for remedy in remedies(requirement, answer.most, pool, longer_changes):
        answer = replace(answer, remedies=(*answer.remedies, remedy))
        on_progress(answer)
    return answer


def _other_drives(solution: Trial, lightest: Rated) -> Iterator[SizedDrive]:
    """Yield the stiffest and the longest-lived of the evaluated candidates, if clearly better than the lightest.

    Both may be the same drive, which is then yielded once.

    Parameters
    ----------
    solution
        Result of the search, with the evaluated candidates.
    lightest
        The lightest drive.
    """
    pool, requirement = solution.pool, solution.pool.requirement
    study_factors = pool.study_factors["other"]
    strong_rows = [
        row
        for row, rated in pool.rated.items()
        if rated and rated.figures["mass"] > lightest.figures["mass"]
        if study_factors[row] * rated.capacity >= requirement.torque and rated.figures["length"] <= requirement.length
    ]
    merits: list[tuple[str, Callable[[Rated | None], float]]] = [
        ("stiffest", lambda rated: _stiffness(rated.reducer) if rated else 0.0),
        ("longest life", lambda rated: rated.life if rated else 0.0),
    ]
    titles: dict[Rated, str] = {}
    for title, merit in merits:
        min_merit = MIN_DIFFERENCE * merit(lightest)
        row = max(strong_rows, key=lambda row: merit(pool.rated[row]), default=None)
        drive = pool.rated[row] if row is not None else None
        if row is not None and drive and not drive.passed and merit(drive) > min_merit:
            drive = pool.study(row)
        # a study that failed may have been repeated at less than the required torque
        if drive and drive.passed and drive.torque >= requirement.torque and merit(drive) > min_merit:
            titles[drive] = f"{titles[drive]} and {title}" if drive in titles else title
    for drive, title in titles.items():
        yield _sized_drive(solution, drive, title.partition(" and ")[0], WHY[title])


def _sized_drive(solution: Trial, rated: Rated, title: str, why: str) -> SizedDrive:
    """Return one drive of a search in the form for users: design, main quantities, and a reason for each value.

    Parameters
    ----------
    solution
        Result of the search; only its requirement is used, for the reasons.
    rated
        The drive with its computed limits.
    title, why
        Title, such as "lightest", and a sentence on why the drive is shown.
    """
    reducer = rated.reducer
    figures = _drive_quantities(rated)
    if figures["drive_diameter_mm"] > figures["outer_diameter_mm"] + 1e-3:
        why += f"; the screws are outside of the ring: diameter with covers {figures['drive_diameter_mm']:.3g} mm"
    if solution.pool.requirement.backlash < math.inf:
        for row in backlash_with_bearings(reducer):
            why += f"; the play of needle bearings and rollers increases the backlash to {row.value:.3g} arcmin"
    reasons = dict(reasons_of(solution.pool.requirement, reducer, rated.weakest.name))
    return SizedDrive(title, why, reducer.design, figures, reasons)


def _drive_quantities(rated: Rated) -> dict[str, float]:
    """Compute the quantities of a drive in the table of `design new`: key with unit, such as "mass_kg" -> value.

    `rated` is the drive with its computed limits.
    """
    reducer, design = rated.reducer, rated.reducer.design
    (continuous, _), (momentary, _) = rated_and_momentary_torque(
        rated.items.values(), design.rated_torque, design.service.life
    )
    loaded_reducer = reducer.but(load={"torque": design.rated_torque})
    return {
        "ratio": design.reduction,
        "outer_diameter_mm": 2e3 * design.housing.outer_radius,
        "drive_length_mm": figure("drive_length_mm").value(reducer),
        "drive_diameter_mm": figure("drive_diameter_mm").value(reducer),
        "mass_kg": rated.figures["mass"],
        "mechanism_mass_kg": figure("mass_kg").value(reducer),
        "rated_torque_nm": continuous,
        "momentary_torque_nm": momentary,
        "life_h": rated.life,
        "temperature_c": rated.items["temperature"].value,
        "stiffness_nm_per_arcmin": figure("stiffness_nm_per_arcmin").value(loaded_reducer),
        **{key: value for key, value in rated.study.items() if key != "turning_percent"},
    }


@once
def _stiffness(reducer: Reducer) -> float:
    """Compute the stiffness between half and full torque at few crank angles [N m/rad]."""
    still, torque = reducer.but(drive={"speed": 0.0}), reducer.design.rated_torque
    springs = springs_of(still, turn_evenly(reducer, 19), friction=False)
    half, full = (loads(still, springs, share * torque).output_turn for share in (0.5, 1.0))
    return 0.5 * torque / float((full - half).mean())
