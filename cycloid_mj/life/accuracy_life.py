"""Accuracy life of a drive: hours until its lost motion has grown by a share, with the interval of the coefficients."""

import math
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.base.frame import Frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.result import Table, to_json_values
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.design import Named, resolve
from cycloid_mj.life.duty import Duty, constant_duty, describe_condition, turning_points
from cycloid_mj.life.wear_course import (
    CASES,
    SETTINGS,
    Case,
    WearingDrive,
    WearLaw,
    WearSettings,
    WearState,
    WearTrend,
    wear_steps,
)
from cycloid_mj.life.wear_data import MM3, RUN_IN, Interval
from cycloid_mj.life.wearing_surfaces import WearingSurface
from cycloid_mj.reducer import reducer_of
from cycloid_mj.statics.sheet import quick_sheet

GROWTH = 1.0
"""Growth of the lost motion at which the accuracy life ends: doubled, as a clearance is worn in `rate`."""

SHEET_COLUMNS = {
    "backlash": ("backlash_arcmin", "backlash [arcmin]"),
    "stiffness_ideal": ("stiffness_nm_arcmin", "stiffness [N m/arcmin]"),
    "output_peak_to_peak_loaded_forward_speed": ("te_arcsec", "TE p-p [arcsec]"),
    "efficiency": ("efficiency_percent", "efficiency [%]"),
}
"""Key of a figure of `statics` -> key and heading of its column; those of the largest forces follow."""


@dataclass(frozen=True, eq=False)
class Course:
    """Lost motion [rad] over hours in one case, shape (n,) each, and why it ended.

    Attributes
    ----------
    hours, lost_motion, end
        Hours [h], lost motion [rad], and the reason of the end in words.
    is_final
        Whether the drive cannot run beyond the last hour, since a part is worn through or has no static equilibrium.
    trend
        Wear beyond the last hour; None: the lost motion grows linearly.
    """

    hours: Array
    lost_motion: Array
    end: str
    is_final: bool = False
    trend: WearTrend | None = None

    def life(self, limit: float) -> float:
        """Return the hours until the lost motion reaches a `limit` [rad], interpolated; inf if it does not grow.

        Beyond the computed hours it is extrapolated by the `trend`, but not where the drive cannot run any longer.
        """
        reached_indices = np.flatnonzero(self.lost_motion >= limit)
        if reached_indices.size:
            reached_index = max(int(reached_indices[0]), 1)
            interval = slice(reached_index - 1, reached_index + 1)
            return float(np.interp(limit, self.lost_motion[interval], self.hours[interval]))
        if self.is_final:
            return float(self.hours[-1])
        if self.trend:
            return self.trend.hours_until(limit)
        last_hours, last_growth = (float(np.diff(history[-2:]).sum()) for history in (self.hours, self.lost_motion))
        remaining_growth = limit - float(self.lost_motion[-1])
        return float(self.hours[-1]) + remaining_growth * last_hours / last_growth if last_growth > 0.0 else math.inf


@dataclass(frozen=True, eq=False)
class WornSurface:
    """A surface, its law of wear, and at the end of the typical course its depths [m] and the run-in's part of them."""

    surface: WearingSurface
    law: WearLaw
    depth: Array
    run_in: Array

    def volume(self, depth: Array) -> float:
        """Return the volume of a depth on all sections of the surface [m3]."""
        surface = self.surface
        return surface.count * surface.section * surface.length * float(depth.mean())

    def as_json(self) -> dict[str, Any]:
        """Convert the wear of a surface to JSON values: material, wear coefficient, run-in depth and depth of wear.

        Keys are ``key``, ``name``, ``material``, ``coefficient_mm3_nm`` and ``run_in_um`` with their intervals,
        ``largest_depth_um``, ``mean_depth_um``, and the lists ``place_mm`` (positions along the surface) and
        ``depth_um``.
        """
        return {
            "key": self.surface.key,
            "name": self.surface.name,
            "material": self.law.material,
            "coefficient_mm3_nm": to_json_values(self.law.coefficient.times(MM3)),
            "run_in_um": to_json_values(self.law.run_in.times(1e6)),
            "largest_depth_um": 1e6 * float(self.depth.max()),
            "mean_depth_um": 1e6 * float(self.depth.mean()),
            "place_mm": (1e3 * self.surface.coordinates).tolist(),
            "depth_um": (1e6 * self.depth).tolist(),
        }


@dataclass(frozen=True, eq=False)
class WearLife(Presented):
    """Wear of a drive over its hours.

    Attributes
    ----------
    design, condition
        Name of the design; torque and speed.
    hours
        Hours that were requested.
    growth
        Growth of the lost motion at which the accuracy life ends [1].
    courses
        Lost motion over hours by case; without the cases that were not begun before an interruption.
    columns, records
        Keys and headings of figures, and their values in the typical course, a row for each recorded time.
    surfaces
        The surfaces that wear.
    interrupted
        Whether the computation was stopped before all cases were finished.
    """

    design: str
    condition: str
    hours: float
    growth: float
    courses: Mapping[Case, Course]
    columns: tuple[tuple[str, str], ...]
    records: tuple[tuple[float, ...], ...]
    surfaces: tuple[WornSurface, ...]
    interrupted: bool

    @property
    def limit(self) -> float:
        """Lost motion at which the accuracy life ends [rad]."""
        return (1.0 + self.growth) * float(self.courses["typical"].lost_motion[0])

    @cached_property
    def _lives(self) -> dict[Case, float]:
        """The accuracy life of each computed case [h]."""
        return {case: course.life(self.limit) for case, course in self.courses.items()}

    def life(self, case: Case = "typical") -> float:
        """Return the accuracy life in a case [h], as `Course.life`; NaN if the case is missing."""
        return self._lives.get(case, math.nan)

    def life_text(self, case: Case = "typical") -> str:
        """Format the accuracy life [h], after which wear has increased the lost motion by the permitted growth.

        The text is the hours; "about ... h, extrapolated" for a life beyond the computed hours; "unlimited" if the lost
        motion does not grow; or "not computed" if the case was not begun. `case` is "low", "typical" or "high", for
        wear coefficients at their 5, 50 or 95 % percentile.
        """
        life = self.life(case)
        if math.isnan(life):
            return "not computed"
        if not math.isfinite(life):
            return "unlimited"
        return f"about {float(f'{life:.2g}'):g} h, extrapolated" if self.extrapolated(case) else f"{life:.4g} h"

    def extrapolated(self, case: Case = "typical") -> bool:
        """Return whether the accuracy life in a case is beyond its course."""
        course = self.courses.get(case)
        return course is not None and bool(self.life(case) > course.hours[-1])

    @property
    def interval_text(self) -> str:
        """Return the 5 to 95 % interval of the accuracy life in words, such as "412 h to unlimited"."""
        shortest_life, longest_life = (self.life_text(case) for case in ("high", "low"))
        if shortest_life == longest_life:
            return shortest_life
        note = ", extrapolated"
        if shortest_life.endswith(note) and longest_life.endswith(note):
            return f"{shortest_life.removesuffix(note)} to {longest_life.removesuffix(note)}, both extrapolated"
        return f"{shortest_life} to {longest_life}"

    @property
    def run_in_share(self) -> float:
        """Share of run-in in the volume that is worn at the end of the typical course [1]."""
        worn_volume = sum(item.volume(item.depth) for item in self.surfaces)
        return sum(item.volume(item.run_in) for item in self.surfaces) / worn_volume if worn_volume else 0.0

    @property
    def assumptions(self) -> tuple[str, ...]:
        """Return the assumptions of the wear computation as sentences: wear law, run-in, interval and sources."""
        return (
            "Archard: the depth of each point is k times its pressure times sliding distance; the drive turns half of "
            "the time each way, and parts of the same kind wear equally",
            "statics is solved again after each step with the worn flanks, pins, holes and cams; curvatures, "
            "stiffnesses and friction remain those of new parts; rolling bearings and teeth of planets do not wear",
            f"run-in: k begins at {RUN_IN.factor:g} times its steady value and falls while the run-in depth is worn "
            f"off; it makes {self.run_in_share:.0%} of the worn volume here, and made {RUN_IN.share:.0%} of the growth "
            "of an RV reducer's lost motion in 1550 h (Lubricants 13 (2025) 362)",
            "interval: coefficient and run-in of all surfaces at their 5 or 95 % percentile together",
            "a part is worn through at the height of a lobe, the radius of a pin or the thickness of a wall; the "
            "computation and all lives end there",
            "a life beyond the computed hours is extrapolated by the law of wear and run-in with the last forces",
            *dict.fromkeys(f"k of {item.law.material}: {item.law.coefficient.source}" for item in self.surfaces),
            *dict.fromkeys(f"run-in of {item.law.material}: {item.law.run_in.source}" for item in self.surfaces),
        )

    @property
    def _rows(self) -> list[dict[str, float]]:
        """The recorded values of each time, by the key of the column."""
        keys = [key for key, _ in self.columns]
        return [dict(zip(keys, row, strict=True)) for row in self.records]

    @property
    def frame(self) -> Frame:
        """The records, a row each."""
        from cycloid_mj.base.frame import make_frame

        return make_frame(self._rows, [key for key, _ in self.columns], {})

    @property
    def line(self) -> str:
        """Design, condition and accuracy life."""
        return f"{self.design}, {self.condition}; accuracy life {self.life_text()} ({self.interval_text})"

    def tables(self) -> tuple[Table, ...]:
        """Return two tables on the wear of a drive: accuracy, forces and depths over time, and wear of each surface.

        The first table is for the typical case of wear.
        """
        surface_rows = tuple(
            (
                item.surface.name,
                item.law.material,
                _interval_text(item.law.coefficient.times(MM3)),
                _interval_text(item.law.run_in.times(1e6)),
                f"{1e6 * item.depth.max():.3g}",
                f"{1e6 * item.depth.mean():.3g}",
            )
            for item in self.surfaces
        )
        headings = ("surface", "material", "k [mm3/(N m)]", "run-in [um]", "largest depth [um]", "mean [um]")
        return (
            Table("Typical course", tuple(heading for _, heading in self.columns), self.records),
            Table("Surfaces (5, 50, 95 %; depths at the end of the typical course)", headings, surface_rows),
        )

    def as_json(self) -> dict[str, Any]:
        """Convert lives [h], lost motion over time [arcmin], recorded rows and worn surfaces to JSON values.

        ``accuracy_life_h`` and ``accuracy_life_interval_h`` are the lives; an unlimited life is None. ``courses`` has
        hours and lost motion of each case, ``records`` a dict of accuracy, forces and wear depths, such as
        ``te_arcsec``, for each recorded time, and ``surfaces`` the worn surfaces.
        """
        content = {
            "design": self.design,
            "condition": self.condition,
            "hours": self.hours,
            "growth_percent": 100.0 * self.growth,
            "accuracy_life_h": self.life(),
            "accuracy_life_extrapolated": self.extrapolated(),
            "accuracy_life_interval_h": [self.life("high"), self.life("low")],
            "accuracy_life": {case: self.life_text(case) for case in CASES},
            "limit_arcmin": self.limit / ARCMINUTE,
            "run_in_share": self.run_in_share,
            "interrupted": self.interrupted,
            "records": self._rows,
            "courses": {
                case: {
                    "hours": course.hours.tolist(),
                    "lost_motion_arcmin": (course.lost_motion / ARCMINUTE).tolist(),
                    "end": course.end,
                }
                for case, course in self.courses.items()
            },
            "surfaces": list(self.surfaces),
            "assumptions": list(self.assumptions),
        }
        return dict(to_json_values(content))


def _interval_text(interval: Interval) -> str:
    return f"{interval.low:.3g}, {interval.typical:.3g}, {interval.high:.3g}"


def wear(
    design: Named,
    hours: float,
    growth: float = GROWTH,
    duty: Duty | None = None,
    settings: WearSettings = SETTINGS,
    on_progress: Callable[[Case, float], None] | None = None,
) -> WearLife:
    """Compute the wear of a drive over time, and its accuracy life with its 5 to 95 % interval.

    Wear follows Archard's law with run-in; after each step, statics are solved with the worn gaps. There are three
    cases (`CASES`): wear coefficients and run-in depths are typical, or all at their 5 % or 95 % percentile. A case
    ends after `hours`, when the lost motion has grown by `growth`, or when a part is worn through. After Ctrl-C, the
    result has the finished cases and steps.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file.
    hours, growth
        Hours of running [h], and relative growth of the lost motion at which the accuracy life ends [1].
    duty
        Torques and speeds with their shares of the time; by default the nominal torque at the design's speed.
    settings
        Settings of the time steps.
    on_progress
        Called after each step with the case and the finished share of this case [1].

    Returns
    -------
    WearLife
        Wear and accuracy over the hours, and the accuracy life with its interval.

    Raises
    ------
    UsageError
        Hours or growth are not positive, or the crank turns without torque.
    DesignError, RunError
        The crank does not turn, or no surface of the drive slides; the new drive has no static equilibrium.
    """
    reducer = reducer_of(resolve(design))
    for name, argument in (("hours", hours), ("growth", growth)):
        if not 0.0 < argument < math.inf:
            raise UsageError(
                f"the argument {name} of the wear study is {argument:g}, which is out of range: give a finite number "
                "greater than 0"
            )
    duty = duty or constant_duty(reducer.design.rated_torque, reducer.design.drive.speed)
    drive = WearingDrive(reducer, turning_points(duty, reducer.design, "parts wear"), settings)
    log = _Log(drive, hours, growth)
    for case in CASES:
        if not log.run_case(case, on_progress):
            break
    return log.result(duty)


class _Log:
    """Courses, records and the last typical state of a drive, as far as they are computed."""

    def __init__(self, drive: WearingDrive, hours: float, growth: float) -> None:
        self._drive, self._hours, self._growth = drive, hours, growth
        self._courses: dict[Case, Course] = {}
        self._records: list[tuple[float, ...]] = []
        self._columns: tuple[tuple[str, str], ...] = ()
        self._interrupted = False

    def run_case(self, case: Case, on_progress: Callable[[Case, float], None] | None) -> bool:
        """Compute and store the lost motion over the hours for a case of wear; return False if it was interrupted.

        The case is "low", "typical" or "high": wear coefficients at their 5, 50 or 95 % percentile. `on_progress` is
        called after each step with the case and the finished share of the computation, 0 to 1.

        Raises
        ------
        RunError
            The new drive has no static equilibrium.
        KeyboardInterrupt
            The computation was interrupted before the first step.
        """
        record_count = self._drive.settings.records
        record_times = (self._hours * (np.arange(1, record_count + 1) / record_count) ** 2).tolist()
        hours: list[float] = []
        lost_motions: list[float] = []
        last_states: deque[WearState] = deque(maxlen=2)
        end_reason, is_unusable = f"{self._hours:g} h are over", False
        try:
            for state in wear_steps(self._drive, case, record_times):
                hours.append(state.hours)
                lost_motions.append(state.lost_motion)
                last_states.append(state)
                growth = state.lost_motion / lost_motions[0] - 1.0
                worn_surface = self._drive.worn_through(state.depths)
                is_end = growth >= self._growth or worn_surface is not None
                if case == "typical":
                    self._record_typical(state, state.hours in record_times or is_end)
                if on_progress:
                    on_progress(case, min(1.0, max(state.hours / self._hours, growth / self._growth)))
                if worn_surface:
                    thickness_text = f"{1e3 * worn_surface.thickness:.3g} mm"
                    end_reason = f"after {state.hours:.4g} h, {worn_surface.name} are worn through ({thickness_text})"
                    is_unusable = True
                elif is_end:
                    end_reason = f"the lost motion has grown by {self._growth:.0%}"
                if is_end:
                    break
        except RunError as error:
            if not lost_motions:
                raise
            end_reason, is_unusable = f"no static equilibrium: {error}", True
        except KeyboardInterrupt:
            if not lost_motions:
                raise
            self._interrupted, end_reason = True, "interrupted"
        trend = WearTrend(self._drive, case, last_states[0], last_states[-1])
        self._courses[case] = Course(np.array(hours), np.array(lost_motions), end_reason, is_unusable, trend)
        return not self._interrupted

    def _record_typical(self, state: WearState, is_due: bool) -> None:
        """Store accuracy, contact forces and wear depths at the typical wear coefficients, if a record is due.

        `state` is the state of the wearing drive. A record is stored if `is_due` is true, for the first state, and when
        the lost motion has grown since the last record by the permitted growth divided by `WearSettings.records`.
        """
        growth_step = self._growth / self._drive.settings.records
        last_lost_motion = self._records[-1][1] * ARCMINUTE if self._records else 0.0
        if not (
            is_due
            or not self._records
            or state.lost_motion > last_lost_motion + growth_step * self._records[0][1] * ARCMINUTE
        ):
            return
        torque = max(abs(point.torque) for point in self._drive.points)
        quantities = quick_sheet(state.reducer, torque).quantities
        force_columns = {
            key: (f"{key}_n", f"{key.removesuffix('_peak_force').replace('_', ' ')} [N]")
            for key in quantities
            if key.endswith("_peak_force")
        }
        largest_depths = [1e6 * float(depth.max()) for depth in state.depths.values()]
        depth_columns = (
            (f"{item.key}_depth_um", f"{item.key.replace('_', ' ')} [um]") for item in self._drive.surfaces
        )
        columns = {**SHEET_COLUMNS, **force_columns}
        first_columns = (("hours", "time [h]"), ("lost_motion_arcmin", "lost motion [arcmin]"))
        self._columns = (*first_columns, *columns.values(), *depth_columns)
        values = (quantities[key].value for key in columns)
        self._records.append((state.hours, state.lost_motion / ARCMINUTE, *values, *largest_depths))

    def result(self, duty: Duty) -> WearLife:
        """Return the lost motion by case, the stored records and the worn surfaces that are computed so far.

        The result states the duty cycle `duty` in words.
        """
        trend, laws = self._courses["typical"].trend, self._drive.laws
        assert trend is not None
        last_state, surfaces = trend.last, []
        for surface in self._drive.surfaces:
            law, depth = laws[surface.key], last_state.depths[surface.key]
            surfaces.append(
                WornSurface(surface, law, depth, depth - law.coefficient.typical * last_state.doses[surface.key])
            )
        return WearLife(
            design=self._drive.reducer.design.name,
            condition=f"{describe_condition(self._drive.reducer.design, duty)}, half of the time each way",
            hours=self._hours,
            growth=self._growth,
            courses=self._courses,
            columns=self._columns,
            records=tuple(self._records),
            surfaces=tuple(surfaces),
            interrupted=self._interrupted,
        )
