"""Wear of a drive in steps: loads of the worn parts, doses of their surfaces, depths by Archard's law, new gaps."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.interrupt import check_interrupt
from cycloid_mj.base.units import HOUR
from cycloid_mj.life.duty import DutyPoint
from cycloid_mj.life.wear_data import Interval, run_in_depth, wear_coefficient, wear_rate, worn_depth
from cycloid_mj.life.wearing_surfaces import (
    Contacts,
    Gap,
    SlidingContacts,
    WearingSurface,
    dose_rate,
    rv_sliding_contacts,
    sliding_contacts,
    wearing_surfaces,
    worn_gaps,
)
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.statics import loads, rv_sheet, springs_of
from cycloid_mj.statics.springs import at_rest, turn_evenly
from cycloid_mj.statics.windup import LOST_MOTION_SHARE

Case = Literal["typical", "low", "high"]
CASES: tuple[Case, ...] = ("typical", "low", "high")
"""Coefficients and depths of run-in of all surfaces: typical, or all at their 5 or 95 % percentile."""


@dataclass(frozen=True)
class WearSettings:
    """Settings of the steps.

    Attributes
    ----------
    poses
        Least number of crank angles of a turn.
    step_share
        Largest depth of a step over the elastic deflection of a loaded contact. A deeper step would unload the contact
        that it wears, and the depth would alternate from place to place: explicit Euler is stable below 2. A quarter
        of it changes lost motion by 0.1 %.
    records
        Number of times at which all figures are computed: more closely at the beginning, when run-in is fast.
    """

    poses: int = 121
    step_share: float = 0.4
    records: int = 8


SETTINGS = WearSettings()


@dataclass(frozen=True, eq=False)
class WearLaw:
    """Material of a surface, its coefficient of wear [m3/(N m)], and the depth of its run-in [m]."""

    material: str
    coefficient: Interval
    run_in: Interval

    def values(self, case: Case) -> tuple[float, float]:
        """Return coefficient and depth of run-in in a case."""
        return getattr(self.coefficient, case), getattr(self.run_in, case)


@dataclass(frozen=True, eq=False)
class WearingDrive:
    """A drive under a duty, and its surfaces that slide; `laws` by the keys of the surfaces."""

    reducer: Reducer
    points: Sequence[DutyPoint]
    settings: WearSettings = SETTINGS

    @cached_property
    def surfaces(self) -> tuple[WearingSurface, ...]:
        """The surfaces that slide."""
        return wearing_surfaces(self.reducer)

    def worn_through(self, depths: Mapping[str, Array]) -> WearingSurface | None:
        """Return the first surface that is worn through; `depths` [m] are arrays (cells,) by the key of the surface."""
        return next((item for item in self.surfaces if float(depths[item.key].max()) >= item.thickness), None)

    @cached_property
    def laws(self) -> dict[str, WearLaw]:
        """Return material, wear coefficient and run-in depth of each wearing surface, by its key, such as "flank"."""
        design = self.reducer.design
        laws = {}
        for surface in self.surfaces:
            material = design.material_of(surface.part)
            material_name = material.name or design.material_table(surface.part)
            intervals = (get_value(design.service, material) for get_value in (wear_coefficient, run_in_depth))
            laws[surface.key] = WearLaw(material_name, *intervals)
        return laws

    @cached_property
    def crank(self) -> Array:
        """Return m crank angles [rad], evenly spaced over a turn of the crank relative to the ring, shape (m,).

        For an RV reducer they are spaced over a turn of the carrier. The number m has no divisor in common with the
        numbers of teeth and pins, so that the pins take m different, equally spaced positions within a pitch.
        """
        reducer, design, count = self.reducer, self.reducer.design, self.settings.poses
        turn, period_count = reducer.mesh_turn, design.output.pins
        if isinstance(reducer, RvReducer):
            turn, period_count = reducer.crank_turn, design.lobes
        while math.gcd(count, design.ring.teeth * period_count) > 1:
            count += 1
        return np.arange(count) / count * turn

    @cached_property
    def deflections(self) -> dict[Gap, float]:
        """Elastic deflection of a contact under its working force [m], for the teeth and each other gap that wears."""
        contacts = self.reducer.at_rated_load.contacts
        deflections: dict[Gap, float] = {"teeth": contacts.teeth.force / contacts.mesh_stiffness}
        others: tuple[Gap, ...] = ("output", "cam")
        gaps = {surface.gap for surface in self.surfaces}
        return deflections | {gap: contacts[gap].force / contacts[gap].stiffness for gap in others if gap in gaps}

    def dose_rates(self, worn_reducer: Reducer) -> dict[str, Array]:
        """Compute pressure times sliding distance per time [Pa m/s] in each cell of each wearing surface.

        A cell is a small interval along the surface. `worn_reducer` has the gaps of the worn parts. The rates are means
        over the duty, shape (cells,), by the key of the surface, such as "flank".

        Raises
        ------
        RunError
            There is no static equilibrium.
        """
        rates = {surface.key: np.zeros(surface.cells) for surface in self.surfaces}
        for point in self.points:
            sliding = _sliding_contacts(worn_reducer.turning_at(point.speed), self.crank, abs(point.torque))
            for surface in self.surfaces:
                rates[surface.key] += point.share * dose_rate(surface, sliding[surface.contacts])
        return rates


def _sliding_contacts(reducer: Reducer, crank: Array, load: float) -> dict[Contacts, SlidingContacts]:
    """Solve for forces, sliding speeds and positions of the contacts by kind of gap, at m crank angles [rad], (m,).

    The keys are those of `sliding_contacts`, such as "flank". `load` [N m] is the torque that opposes the rotation of
    the output.
    """
    if isinstance(reducer, RvReducer):
        return rv_sliding_contacts(reducer, crank, load)
    springs = springs_of(reducer, crank)
    torque = math.copysign(load, reducer.design.drive.speed)
    return sliding_contacts(reducer, springs, loads(reducer, springs, torque, warm_start=True))


@dataclass(frozen=True, eq=False)
class WearState:
    """State of a drive after some hours [h]: doses [Pa m] and depths [m] of its surfaces by key, and the worn reducer.

    The lost motion is that at +-3 % of the rated torque [rad].
    """

    hours: float
    doses: Mapping[str, Array]
    depths: Mapping[str, Array]
    reducer: Reducer
    lost_motion: float


@dataclass(frozen=True, eq=False)
class WearTrend:
    """Wear of a drive after the second of two states of a case, if the contact forces remain those between them.

    Doses then grow at their last rate, and depths follow from the law of wear: run-in ends. The lost motion grows in
    proportion to the mean depths of the surfaces, each times the opening of its gap.
    """

    drive: WearingDrive
    case: Case
    previous: WearState
    last: WearState

    def hours_until(self, limit: float) -> float:
        """Compute the hours [h] until the lost motion reaches a `limit` [rad] or a part is worn through.

        The result is inf if the lost motion did not grow.
        """
        from scipy.optimize import brentq

        growth = self.last.lost_motion - self.previous.lost_motion
        if growth <= 0.0:
            return math.inf
        last_opening = self._mean_opening(self.last.depths)
        opening_per_motion = (last_opening - self._mean_opening(self.previous.depths)) / growth
        opening_limit = last_opening + (limit - self.last.lost_motion) * opening_per_motion

        def excess(hours: float) -> float:
            """Return by how much the limit or a thickness is exceeded after some hours, relative to it [1]."""
            depths = self._depths(hours)
            worn_share = max(float(depths[item.key].max()) / item.thickness for item in self.drive.surfaces)
            return max(self._mean_opening(depths) / opening_limit, worn_share) - 1.0

        upper_hours = 2.0 * self.last.hours
        while excess(upper_hours) < 0.0:
            upper_hours *= 2.0
        return float(brentq(excess, self.last.hours, upper_hours, rtol=1e-6))

    def _depths(self, hours: float) -> dict[str, Array]:
        """Return the depths [m] of the cells of each surface after some hours, by the key of the surface."""
        first_state, last_state, laws = self.previous, self.last, self.drive.laws
        elapsed_share = (hours - last_state.hours) / (last_state.hours - first_state.hours)
        return {
            key: worn_depth(dose + elapsed_share * (dose - first_state.doses[key]), *laws[key].values(self.case))
            for key, dose in last_state.doses.items()
        }

    def _mean_opening(self, depths: Mapping[str, Array]) -> float:
        """Return the sum of the mean openings of gaps [m] by the depths of their surfaces [m]."""
        return sum(item.opening * float(depths[item.key].mean()) for item in self.drive.surfaces)


def lost_motion(reducer: Reducer) -> float:
    """Compute the lost motion [rad]: the rotation of the output between +3 % and -3 % of the rated torque.

    It is the mean over a turn, without friction.
    """
    if isinstance(reducer, RvReducer):
        return rv_sheet.lost_motion(reducer, reducer.design.rated_torque)
    static_reducer = at_rest(reducer)
    springs = springs_of(static_reducer, turn_evenly(reducer), friction=False)
    small_torque = LOST_MOTION_SHARE * reducer.design.rated_torque
    positive_turn, negative_turn = (
        loads(static_reducer, springs, sign * small_torque, warm_start=True).output_turn for sign in (1.0, -1.0)
    )
    return float(np.mean(positive_turn - negative_turn))


def wear_steps(drive: WearingDrive, case: Case, record_times: Sequence[float]) -> Iterator[WearState]:
    """Yield the state of a new drive, then that after each time step of its wear (explicit Euler method).

    A state has the hours, the depth of wear along each surface, the worn reducer, and its lost motion.

    Parameters
    ----------
    drive, case
        Drive with its duty, and which wear coefficients apply: typical ones, or a percentile (`CASES`).
    record_times
        Increasing times [h] at which a step must end; the computation ends at the last of them.

    Raises
    ------
    RunError
        There is no static equilibrium.
    """
    layout = type(drive.reducer)
    reducer = layout(drive.reducer.design)
    doses = {surface.key: np.zeros(surface.cells) for surface in drive.surfaces}
    depths, hours = dict(doses), 0.0
    yield WearState(hours, doses, depths, reducer, lost_motion(reducer))
    for end in record_times:
        while hours < end:
            check_interrupt()
            rates = drive.dose_rates(reducer)
            time_step = _stable_step(drive, case, doses, rates)
            is_last_step = hours + time_step >= end
            time_step, hours = (end - hours, end) if is_last_step else (time_step, hours + time_step)
            doses = {key: dose + time_step * HOUR * rates[key] for key, dose in doses.items()}
            depths = {key: worn_depth(dose, *drive.laws[key].values(case)) for key, dose in doses.items()}
            reducer = layout(drive.reducer.design, worn_gaps(drive.surfaces, depths, rates))
            yield WearState(hours, doses, depths, reducer, lost_motion(reducer))


def _stable_step(drive: WearingDrive, case: Case, doses: Mapping[str, Array], rates: Mapping[str, Array]) -> float:
    """Return the largest time step [h] in which wear widens no gap by more than a share of its deflection under load.

    `drive` is the drive with its duty. `case` is "low", "typical" or "high" wear. `doses` are pressure times sliding
    distance so far [Pa m] of each cell of a surface, and `rates` their rates [Pa m/s]: key of the surface -> (cells,).
    The share is `WearSettings.step_share`. The result is inf without wear.
    """
    time_steps = [math.inf]
    for surface in drive.surfaces:
        law = drive.laws[surface.key].values(case)
        opening_rate = surface.opening * float(np.max(wear_rate(doses[surface.key], *law) * rates[surface.key]))
        if opening_rate > 0.0:
            time_steps.append(drive.settings.step_share * drive.deflections[surface.gap] / opening_rate / HOUR)
    return min(time_steps)
