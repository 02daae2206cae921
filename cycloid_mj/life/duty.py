"""Duty cycles: torques and speeds, each for a share of the time."""

import csv
import math
from dataclasses import dataclass, replace
from pathlib import Path

from cycloid_mj.base.errors import DesignError, UsageError, reason
from cycloid_mj.base.overwrite_guard import note_input
from cycloid_mj.base.units import RPM
from cycloid_mj.design import Design

COLUMNS = ("torque_nm", "speed_rpm", "share")

MAX_SPEED = 1e5
"""Upper limit of the speed of a crank [rpm], as of ``drive.speed_rpm``."""


PEAK_FACTOR = 2.0
"""Peak torque of an emergency stop over the largest torque of a duty cycle, unless it states another (assumed)."""


@dataclass(frozen=True)
class DutyPoint:
    """A `torque` on the output [N m] and a `speed` of the crank [rad/s] for a `share` of the time."""

    torque: float
    speed: float
    share: float


@dataclass(frozen=True)
class Duty:
    """The points of a duty cycle, whose shares add up to 1, and the `peak` torque of an emergency stop [N m].

    `peak_given` is whether the peak was specified; else it is twice the largest torque of the cycle. `period` is the
    duration of one cycle [s], by default 10 min as for intermittent duty (S3, IEC 60034-1).
    """

    points: tuple[DutyPoint, ...]
    peak: float
    peak_given: bool = True
    period: float = 600.0

    @property
    def words(self) -> str:
        """Return the duty cycle in words: torque [N m], speed [rpm] and share of the time of each point."""
        if len(self.points) == 1:
            point = self.points[0]
            return f"{point.torque:.4g} N m at {point.speed / RPM:.6g} rpm"
        return "; ".join(
            f"{point.torque:g} N m at {point.speed / RPM:g} rpm, {point.share:.3g}"
            if point.speed
            else f"rest, {point.share:.3g}"
            for point in self.points
        )


def describe_condition(design: Design, duty: Duty) -> str:
    """Return a duty cycle with the temperatures of the parts and the friction law, as a condition of results."""
    return f"{duty.words}, {design.condition_words}"


def constant_duty(torque: float, speed: float, peak: float | None = None) -> Duty:
    """Return the duty cycle of a constant torque [N m] and speed [rad/s]; its peak defaults to twice the torque."""
    return _cycle((DutyPoint(abs(torque), abs(speed), 1.0),), peak)


def add_rests(duty: Duty, share: float) -> Duty:
    """Return a constant duty with rests between, so that it runs for a share of the time [1] (S3, IEC 60034-1).

    A duty of several points is unchanged, because its file states its rests.
    """
    if len(duty.points) > 1 or share == 1.0:
        return duty
    return replace(duty, points=(replace(duty.points[0], share=share), DutyPoint(0.0, 0.0, 1.0 - share)))


def turning_points(duty: Duty, design: Design, effect: str) -> tuple[DutyPoint, ...]:
    """Return the points of a duty cycle at which the input turns.

    Raises
    ------
    DesignError
        There are none. The message states the `effect` that needs them, such as "parts wear".
    UsageError
        One of them has no torque.
    """
    points = tuple(point for point in duty.points if point.speed)
    shaft_name, example_speed = ("sun gear", 2295) if design.layout == "rv" else ("crank", 1640)
    if not all(point.torque for point in points):
        raise UsageError(
            f"{design.name}: the torque of the duty is 0 N m while the {shaft_name} turns, which is not allowed. Use a "
            "small torque for an idling drive, or the speed 0 for a rest"
        )
    if not points:
        raise DesignError(
            f"{design.name}: drive.speed_rpm is 0, but {effect} only if the {shaft_name} turns: set a speed other "
            f"than 0, such as {example_speed} rpm"
        )
    return points


def _cycle(points: tuple[DutyPoint, ...], peak: float | None) -> Duty:
    """Return the duty cycle of some points, its peak twice the largest torque unless it is specified."""
    if peak is not None:
        return Duty(points, peak)
    return Duty(points, PEAK_FACTOR * max(abs(point.torque) for point in points), peak_given=False)


def read_duty(path: Path, peak_torque: float | None = None) -> Duty:
    """Read a duty cycle from a CSV file with the columns torque_nm, speed_rpm and share.

    Shares are relative to their sum. A rest has the speed 0: its share counts, its torque does not. `peak_torque` [N m]
    is that of an emergency stop; by default twice the largest torque.

    Raises
    ------
    UsageError
        The file cannot be read or does not have that form.
    """
    try:
        with note_input(path).open(newline="", encoding="utf-8-sig") as file:
            lines = [(line_number, _cells(line)) for line_number, line in enumerate(file, start=1) if _has_values(line)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise UsageError(
            f"cannot read the duty cycle {path}: {reason(error)}. Choose a CSV file with the columns "
            f"{','.join(COLUMNS)}"
        ) from error
    header = lines[0][1] if lines else []
    if any(column not in header for column in COLUMNS):
        columns = ", ".join(header) if header else "none"
        raise UsageError(
            f"{path}: a duty cycle needs the columns {','.join(COLUMNS)}, but the file has {columns}. Add the missing "
            "columns"
        )
    if len(lines) == 1:
        raise UsageError(f"{path}: the duty cycle has no points. Add one line per point: {','.join(COLUMNS)}")
    points = [
        _parse_point(f"{path}, line {line_number}", dict(zip(header, row, strict=False)))
        for line_number, row in lines[1:]
    ]
    share_sum = sum(point.share for point in points)
    if not share_sum > 0.0:
        raise UsageError(
            f"{path}: the column `share` sums to {share_sum:g}, but the sum must be greater than 0. Enter a positive "
            "share for at least one point"
        )
    if not any(point.speed and point.share for point in points):
        raise UsageError(
            f"{path}: the crank never turns. Enter a speed_rpm other than 0 for at least one point with a positive "
            "share"
        )
    return _cycle(tuple(DutyPoint(point.torque, point.speed, point.share / share_sum) for point in points), peak_torque)


def _has_values(line: str) -> bool:
    """Return whether a line is neither empty nor a comment."""
    return bool(line.strip()) and not line.startswith("#")


def _cells(line: str) -> list[str]:
    """Split a line of CSV into its cells."""
    return [cell.strip() for cell in next(csv.reader([line]))]


def _parse_point(location: str, row: dict[str, str]) -> DutyPoint:
    """Convert a row of the duty-cycle file (column -> text) to a point of the duty cycle.

    Raises
    ------
    UsageError
        A value is not allowed; the message begins with the row's `location`, file and line.
    """
    value_by_column = {}
    for column in COLUMNS:
        text = row.get(column, "")
        try:
            value_by_column[column] = float(text)
        except ValueError as error:
            raise UsageError(f"{location}: {column} is {text!r}, which is not a number. Correct this value") from error
        if not math.isfinite(value_by_column[column]):
            raise UsageError(f"{location}: {column} is {text!r}, but must be finite. Correct this value")
    torque, speed, share = value_by_column.values()
    if not abs(speed) < MAX_SPEED:
        raise UsageError(f"{location}: speed_rpm is {speed:g}, but must be less than {MAX_SPEED:g}. Reduce this speed")
    if share < 0.0:
        raise UsageError(f"{location}: share is {share:g}, but must be at least 0. Correct this value")
    if torque == 0.0 and speed != 0.0:
        raise UsageError(
            f"{location}: torque_nm is 0 while the crank turns, which is not allowed. Use a small torque for an idling "
            "drive, or speed_rpm = 0 for a pause"
        )
    return DutyPoint(abs(torque), abs(speed) * RPM, share)
