"""What a reducer is asked for over its life: torques and speeds, each for a share of the time."""

import csv
from dataclasses import dataclass
from pathlib import Path

from cycloid_mj.errors import UsageError
from cycloid_mj.units import RPM

COLUMNS = ("torque_nm", "speed_rpm", "share")


@dataclass(frozen=True)
class DutyPoint:
    """A `torque` on the output [N m] and a `speed` of the crank [rad/s] for a `share` of the time."""

    torque: float
    speed: float
    share: float


@dataclass(frozen=True)
class Duty:
    """The points of a duty cycle, whose shares add up to 1, and the `peak` torque of an emergency stop [N m]."""

    points: tuple[DutyPoint, ...]
    peak: float

    @property
    def words(self) -> str:
        """The cycle in words."""
        each = (f"{point.torque:g} N m at {point.speed / RPM:g} rpm, {point.share:.0%}" for point in self.points)
        return "; ".join(each)


def steady(torque: float, speed: float, peak: float | None = None) -> Duty:
    """Give the duty of one torque [N m] and speed [rad/s] all the time; its peak is twice that unless it is given."""
    return Duty((DutyPoint(abs(torque), abs(speed), 1.0),), 2.0 * abs(torque) if peak is None else peak)


def read_duty(path: Path, peak: float | None = None) -> Duty:
    """Read a duty cycle of the columns torque_nm, speed_rpm and share; shares are taken as parts of their sum.

    Raises
    ------
    UsageError
        The file is not there, or not of that form.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.DictReader(line for line in file if line.strip() and not line.startswith("#")))
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(
            f"cannot read the duty cycle {path}: {error}; give a CSV file of {','.join(COLUMNS)}"
        ) from error
    if not rows or any(column not in rows[0] for column in COLUMNS):
        found = ", ".join(rows[0]) if rows else "no rows"
        raise UsageError(f"{path}: a duty cycle has the columns {','.join(COLUMNS)}; found {found}")
    points = [_point(path, number, row) for number, row in enumerate(rows, start=2)]
    whole = sum(point.share for point in points)
    if not whole > 0.0:
        raise UsageError(f"{path}: the shares add up to {whole:g}; give each point its part of the time")
    parts = tuple(DutyPoint(point.torque, point.speed, point.share / whole) for point in points)
    return Duty(parts, 2.0 * max(abs(point.torque) for point in parts) if peak is None else peak)


def _point(path: Path, number: int, row: dict[str, str]) -> DutyPoint:
    values = []
    for column in COLUMNS:
        try:
            values.append(float(row[column]))
        except (TypeError, ValueError) as error:
            raise UsageError(f"{path}, line {number}: {column} is {row[column]!r}; give a number") from error
    torque, speed, share = values
    if share < 0.0 or torque == 0.0 or speed == 0.0:
        raise UsageError(f"{path}, line {number}: a point has a torque, a speed, and a share of the time of at least 0")
    return DutyPoint(torque, speed * RPM, share)
