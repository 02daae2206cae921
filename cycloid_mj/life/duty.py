"""What a reducer is asked for over its life: torques and speeds, each for a share of the time."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

from cycloid_mj.base.errors import UsageError, reason
from cycloid_mj.base.overwrite_guard import as_input
from cycloid_mj.base.units import RPM

COLUMNS = ("torque_nm", "speed_rpm", "share")

FASTEST = 1e5
"""Speed of a crank that no design reaches [rpm], as of ``drive.speed_rpm``."""


@dataclass(frozen=True)
class DutyPoint:
    """A `torque` on the output [N m] and a `speed` of the crank [rad/s] for a `share` of the time."""

    torque: float
    speed: float
    share: float


@dataclass(frozen=True)
class Duty:
    """The points of a duty cycle, whose shares add up to 1, and the `peak` torque of an emergency stop [N m].

    `peak_given` tells whether that torque was asked for, or is twice the largest of the cycle.
    """

    points: tuple[DutyPoint, ...]
    peak: float
    peak_given: bool = True

    @property
    def words(self) -> str:
        """The cycle in words."""
        each = (f"{point.torque:g} N m at {point.speed / RPM:g} rpm, {point.share:.3g}" for point in self.points)
        if len(self.points) == 1:
            point = self.points[0]
            return f"{point.torque:.4g} N m at {point.speed / RPM:.6g} rpm"
        return "; ".join(each)


def steady(torque: float, speed: float, peak: float | None = None) -> Duty:
    """Make the duty of one torque [N m] and speed [rad/s] all the time; its peak is twice that unless it is given."""
    return _cycle((DutyPoint(abs(torque), abs(speed), 1.0),), peak)


def _cycle(points: tuple[DutyPoint, ...], peak: float | None) -> Duty:
    if peak is not None:
        return Duty(points, peak)
    return Duty(points, 2.0 * max(abs(point.torque) for point in points), peak_given=False)


def read_duty(path: Path, peak: float | None = None) -> Duty:
    """Read a duty cycle of the columns torque_nm, speed_rpm and share; shares are taken as parts of their sum.

    A rest has the speed 0: its share counts, its torque does not.

    Raises
    ------
    UsageError
        The file is not there, or not of that form.
    """
    try:
        with as_input(path).open(newline="", encoding="utf-8-sig") as file:
            lines = [(number, _cells(line)) for number, line in enumerate(file, start=1) if _tells(line)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise UsageError(
            f"cannot read the duty cycle {path}: {reason(error)}; give a CSV file of {','.join(COLUMNS)}"
        ) from error
    header = lines[0][1] if lines else []
    if any(column not in header for column in COLUMNS):
        columns = ", ".join(header) if header else "an empty file"
        raise UsageError(f"{path}: a duty cycle has the columns {','.join(COLUMNS)}; found {columns}")
    if len(lines) == 1:
        raise UsageError(f"{path}: the duty cycle has no points: give a line of {','.join(COLUMNS)} for each")
    points = [_point(f"{path}, line {number}", dict(zip(header, row, strict=False))) for number, row in lines[1:]]
    whole = sum(point.share for point in points)
    if not whole > 0.0:
        raise UsageError(f"{path}: the shares add up to {whole:g}; give each point its part of the time")
    if not any(point.speed and point.share for point in points):
        raise UsageError(f"{path}: the crank never turns; give a point with a speed_rpm other than 0")
    return _cycle(tuple(DutyPoint(point.torque, point.speed, point.share / whole) for point in points), peak)


def _tells(line: str) -> bool:
    return bool(line.strip()) and not line.startswith("#")


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in next(csv.reader([line]))]


def _point(where: str, row: dict[str, str]) -> DutyPoint:
    values = {}
    for column in COLUMNS:
        text = row.get(column, "")
        try:
            values[column] = float(text)
        except ValueError as error:
            raise UsageError(f"{where}: {column} is {text!r}; give a number") from error
        if not math.isfinite(values[column]):
            raise UsageError(f"{where}: {column} is {text!r}; give a finite number")
    torque, speed, share = values.values()
    if not abs(speed) < FASTEST:
        raise UsageError(f"{where}: speed_rpm is {speed:g}; give one of less than {FASTEST:g}")
    if share < 0.0:
        raise UsageError(f"{where}: share is {share:g}; give a part of the time of at least 0")
    if torque == 0.0 and speed != 0.0:
        raise UsageError(f"{where}: torque_nm is 0; give an idling drive a small torque, or a speed_rpm of 0")
    return DutyPoint(abs(torque), abs(speed) * RPM, share)
