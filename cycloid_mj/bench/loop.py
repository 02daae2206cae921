"""Measured hysteresis loops: torque against deflection of the output, read, checked and split into branches."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.base.errors import UsageError, reason
from cycloid_mj.base.frame import Frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.overwrite_guard import note_input
from cycloid_mj.base.units import DEGREE

TORQUE, DEFLECTION = COLUMNS = ("torque_output_Nm", "deflection_deg")


@dataclass(frozen=True)
class LoopSettings:
    """Settings of reading a loop (heuristic)."""

    min_points: int = 20
    """Smallest number of points of a loop."""
    min_branch_points: int = 6
    """Smallest mean number of points of a branch: with fewer, rows are not in chronological order."""
    reversal: float = 0.2
    """Share of its range by which the torque returns after a reversal."""
    median_window: int = 5
    """Number of neighbours whose median locates a reversal, so that single outliers are none."""
    max_noise: float = 3.0
    max_steps: float = 2.0
    """Multiples of the typical noise, and of the typical step between points. Their sum is the largest distance of a
    reversal's torque from the median there; beyond, it is an outlier."""
    lead_distance: float = 1.0 / 3.0
    """Distance of the first points from the loop's branch, over its width there, from which they lead to the loop."""
    end_torque: float = 0.9
    """Torque of the first point, over the largest, from which it is at the loop's end and not before the loop."""
    max_negative_opening: float = 0.02
    """Rotation by which falling branches may lie below rising ones, over the height; beyond, a loop releases energy."""
    min_height_deg: float = 1e-4
    """Smallest plausible height of a loop [deg]."""
    max_height_deg: float = 90.0
    """Largest plausible height of a loop [deg]: a locked output does not turn further."""
    max_rated_torques: float = 30.0
    """Largest torque over the rated one that is not in N mm."""
    min_rated_torques: float = 1e-3
    """Smallest torque over the rated one that is not in kN m."""


SETTINGS = LoopSettings()


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredLoop(Presented):
    """Measured hysteresis loop of n points.

    Attributes
    ----------
    name
        Name of its file without the ending.
    torque, deflection
        Torque at the output [N m] and rotation of it [rad], counter-clockwise, in chronological order, shape (n,).
    turns
        Torques at which the course reverses [N m], in chronological order.
    branch
        Number of reversals before each point, shape (n,).
    flipped
        Whether the sign of the deflection was changed, as the file counts it against the torque.
    points_left_out
        Number of first points that lead to the loop, as of a bench that starts from rest; figures and fits omit them.
    """

    name: str
    torque: Array
    deflection: Array
    turns: tuple[float, ...]
    branch: Integers
    flipped: bool = False
    points_left_out: int = 0

    @property
    def frame(self) -> Frame:
        """Points of the loop, one row each."""
        columns = {"torque": self.torque, "deflection": self.deflection, "branch": self.branch}
        return Frame(columns, {"torque": "N m", "deflection": "rad"})

    @property
    def line(self) -> str:
        """Name, number of points, torque range and height."""
        low, high = self.ends
        return (
            f"{self.name}, {len(self.torque)} points, {low:.4g} to {high:.4g} N m, {self.height / DEGREE:.4g} deg high"
        )

    @property
    def height(self) -> float:
        """Range of the deflection [rad]."""
        return float(np.ptp(self.deflection))

    @property
    def ends(self) -> tuple[float, float]:
        """Lowest and highest torque at which the course reverses [N m]."""
        return min(self.turns), max(self.turns)

    @property
    def most(self) -> float:
        """Largest torque at which the course reverses, of either sign [N m]."""
        return max(map(abs, self.turns))

    @property
    def rising(self) -> bool:
        """True if the torque of the first branch rises."""
        return self.turns[1] > self.turns[0]

    def moving(self, direction: int) -> Mask:
        """Return which points of the loop have a rising (`direction` 1) or falling torque (-1), shape (n,)."""
        is_rising = (self.branch % 2 == 0) == self.rising
        return (is_rising == (direction > 0)) & (np.arange(len(self.torque)) >= self.points_left_out)


def _interpolate(abscissa: Array, values: Array, level: float | Array) -> Array:
    """Interpolate values linearly at a level of `abscissa`."""
    order = np.argsort(abscissa)
    return np.asarray(np.interp(level, abscissa[order], values[order]))


def read_loop(path: Path | str) -> MeasuredLoop:
    """Read a hysteresis loop from a CSV file with the columns torque_output_Nm and deflection_deg.

    Parameters
    ----------
    path
        The CSV file. Its header line may begin with ``#``.

    Returns
    -------
    MeasuredLoop
        Torque [N m] and deflection [rad] of the output in chronological order, with reversals and branches.

    Raises
    ------
    UsageError
        The file is missing or malformed, or contains no loop.
    """
    path = Path(path)
    columns = read_columns(path, COLUMNS, "a loop")
    return measured_loop(path.stem, columns[TORQUE], columns[DEFLECTION], str(path))


def read_columns(path: Path, names: tuple[str, ...], content: str) -> dict[str, Array]:
    """Read columns of numbers from a CSV file: column name -> values of the n rows, shape (n,).

    Parameters
    ----------
    path
        The file; its header line may begin with ``#``.
    names
        Columns to read.
    content
        Content of the file in words, for messages.

    Raises
    ------
    UsageError
        The file cannot be read, lacks a column, has no rows, or contains something else than numbers.
    """
    requirement_text = f"{content} needs the columns {','.join(names)}, separated by commas"
    try:
        lines = note_input(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"cannot read {path}: {reason(error)}. Give a CSV file: {requirement_text}") from error
    numbered_lines = [(number, line) for number, line in enumerate(lines, 1) if line.strip(" \t#")]
    if not numbered_lines:
        raise UsageError(f"{path}: the file is empty, but {requirement_text}")
    header_row = next((row for row, (_, line) in enumerate(numbered_lines) if names[0] in line), None)
    if header_row is None:
        first_line = ", ".join(numbered_lines[0][1].lstrip("# ").split(","))
        raise UsageError(
            f"{path}: no header line with the column names was found; the first line is {first_line[:80]!r}. Add the "
            f"header: {requirement_text}"
        )
    keys = [key.strip() for key in numbered_lines[header_row][1].lstrip("# ").split(",")]
    if missing := [name for name in names if name not in keys]:
        raise UsageError(
            f"{path}: the column {missing[0]} is missing; the file has {', '.join(keys)}. Add or rename the column: "
            f"{requirement_text}"
        )
    rows = [(number, row) for number, row in numbered_lines[header_row + 1 :] if not row.lstrip().startswith("#")]
    if not rows:
        raise UsageError(f"{path}: there are no rows below the header. Add one per measured point: {requirement_text}")
    values: dict[str, list[float]] = {name: [] for name in names}
    for number, line in rows:
        cells = next(csv.reader([line]))
        for name in names:
            column = keys.index(name)
            values[name].append(
                _parse_number(cells[column] if column < len(cells) else "", f"{path}, line {number}: {name}")
            )
    return {name: np.array(column) for name, column in values.items()}


def _parse_number(text: str, location: str) -> float:
    """Convert the text of a cell of a file to a finite number, in the unit of the file.

    Raises
    ------
    UsageError
        The text is no finite number; the message begins with its `location` in the file.
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UsageError(
            f"{location} is {text.strip()!r}, which is not a finite number: correct the value, or remove the line"
        )
    return value


def measured_loop(name: str, torque: Array, deflection_deg: Array, origin: str = "") -> MeasuredLoop:
    """Create a loop from torque and deflection in chronological order: check them, determine reversals and branches.

    The sign of the deflection is changed if it decreases with the torque.

    Parameters
    ----------
    name
        Name of the loop.
    torque, deflection_deg
        Torque at the output [N m] and rotation of the output [deg] at n points, shape (n,).
    origin
        Source of the points for messages, such as the file; by default the name.

    Raises
    ------
    UsageError
        The points are no loop: too few points, an outlier, a single branch, rows out of order, exchanged columns, or a
        deflection that cannot be in degrees.
    """
    origin, point_count = origin or name, len(torque)
    if point_count < SETTINGS.min_points:
        raise UsageError(
            f"{origin}: a loop needs at least {SETTINGS.min_points} points, but this one has {point_count}. Record the "
            "loop with more points"
        )
    height = float(np.ptp(deflection_deg))
    if not np.ptp(torque) > 0.0 or not height > 0.0:
        column = TORQUE if not np.ptp(torque) > 0.0 else DEFLECTION
        raise UsageError(
            f"{origin}: {column} is the same in all rows, but both the torque and the deflection must vary over a "
            "loop. Record a full loop"
        )
    reversals, branch_numbers = _find_reversals(torque)
    if point_count < SETTINGS.min_branch_points * (branches := len(np.unique(branch_numbers))):
        raise UsageError(
            f"{origin}: the torque reverses {branches - 1} times in {point_count} points; a loop needs at least "
            f"{SETTINGS.min_branch_points} points per branch. Check that the rows are in chronological order"
        )
    _require_no_outlier(torque, TORQUE, origin)
    _require_no_outlier(deflection_deg, DEFLECTION, origin)
    _require_degrees(height, origin)
    if len(reversals) < 2 or len(np.unique(branch_numbers)) < 2 or min(reversals) >= 0.0 or max(reversals) <= 0.0:
        raise UsageError(
            f"{origin}: the file contains only one branch, from {torque[0]:.4g} to {torque[-1]:.4g} N m, which does "
            "not separate friction from stiffness. Record a full loop: from one torque to the opposite torque and "
            "back"
        )
    is_flipped = float(np.polyfit(torque, deflection_deg, 1)[0]) < 0.0
    deflection = DEGREE * deflection_deg * (-1.0 if is_flipped else 1.0)
    points_left_out = _count_lead_points(torque, deflection, branch_numbers)
    loop = MeasuredLoop(name, torque, deflection, reversals, branch_numbers, is_flipped, points_left_out)
    if _mean_opening(loop) < -SETTINGS.max_negative_opening * loop.height:
        raise UsageError(
            f"{origin}: the loop releases energy, because at the same torque the deflection is smaller during "
            "unloading than during loading. Swap the two columns, or reverse the order of the rows"
        )
    return loop


def require_torque(loop: MeasuredLoop, rated_torque: float) -> None:
    """Raise UsageError if the torques of a loop seem to be in N mm or kN m, by comparison with `rated_torque` [N m]."""
    if rated_torque and loop.most > SETTINGS.max_rated_torques * rated_torque:
        raise UsageError(
            f"{loop.name}: the torque reaches {loop.most:.4g} N m, {loop.most / rated_torque:.3g} times the rated "
            f"torque of the design, {rated_torque:.4g} N m; at most {SETTINGS.max_rated_torques:g} times is allowed. "
            f"If the column {TORQUE} is in N mm, divide it by 1000; otherwise correct drive.torque_nm of the design"
        )
    min_torque = SETTINGS.min_rated_torques * rated_torque
    if loop.most < min_torque:
        raise UsageError(
            f"{loop.name}: the torque reaches only {loop.most:.4g} N m; at least {min_torque:.4g} N m is needed for "
            f"the rated torque of the design, {rated_torque:.4g} N m. If the column {TORQUE} is in kN m, multiply it "
            "by 1000; otherwise measure a loop up to a higher torque"
        )


def _require_degrees(height: float, origin: str) -> None:
    """Raise UsageError if the range of deflection of a loop, `height` [deg], is implausible for values in degrees.

    The message begins with `origin`.
    """
    if not SETTINGS.min_height_deg <= height <= SETTINGS.max_height_deg:
        likely_unit = (
            "in arcminutes or arcseconds" if height > SETTINGS.max_height_deg else "in turns, or of another drive"
        )
        raise UsageError(
            f"{origin}: the deflection has a range of {height:.3g} deg; a drive with a locked crank has "
            f"{SETTINGS.min_height_deg:g} to {SETTINGS.max_height_deg:g} deg. The values may be {likely_unit}: convert "
            f"{DEFLECTION} to degrees"
        )


def _require_no_outlier(values: Array, column: str, origin: str) -> None:
    """Raise UsageError for a value that differs from its running median by more than the range of the running medians.

    The running median is that of five consecutive values, the value itself in the middle. `values` are torques or
    deflections in the order of measurement, shape (n,) for n points; `column` and `origin` name them and their file in
    the message.
    """
    medians = _median_filter(values)
    differences = np.abs(values - medians)
    worst_row = int(np.argmax(differences))
    if differences[worst_row] > np.ptp(medians):
        raise UsageError(
            f"{origin}: {column} is {values[worst_row]:.4g} in row {worst_row + 1} below the header, but about "
            f"{medians[worst_row]:.4g} in the rows next to it, so it is an outlier. Remove that row"
        )


def _mean_opening(loop: MeasuredLoop) -> float:
    """Compute the mean opening of a loop [rad]: the deflection at falling minus that at rising torque.

    It is the mean over the torques that both branches cover. It is negative for a loop that releases energy.
    """
    branch_masks = [loop.moving(direction) for direction in (1, -1)]
    common_range = (
        max(loop.torque[is_moving].min() for is_moving in branch_masks),
        min(loop.torque[is_moving].max() for is_moving in branch_masks),
    )
    levels = np.linspace(*common_range, len(loop.torque))
    rising_branch, falling_branch = (
        _interpolate(loop.torque[is_moving], loop.deflection[is_moving], levels) for is_moving in branch_masks
    )
    return float(np.mean(falling_branch - rising_branch))


def _median_filter(values: Array) -> Array:
    """Compute the median of each value and its neighbours, shape (n,)."""
    padded = np.pad(values, SETTINGS.median_window // 2, mode="edge")
    return np.asarray(np.median(np.lib.stride_tricks.sliding_window_view(padded, SETTINGS.median_window), axis=1))


def _count_lead_points(torque: Array, deflection: Array, branch_numbers: Integers) -> int:
    """Return the number of points of the first branch if it only leads from rest to the loop, else 0.

    A branch is the points between two reversals of the torque. The first branch leads to the loop if its first torque
    is at most the share `SETTINGS.end_torque` of the largest torque, and if it starts at a distance from the later
    branches of the same direction. This distance exceeds the share `SETTINGS.lead_distance` of that between both
    directions. `torque` [N m], `deflection` [rad] and `branch_numbers`, the number of reversals before each point, have
    shape (n,) for n points.
    """
    has_same_direction, is_on_first_branch = (branch_numbers > 0) & (branch_numbers % 2 == 0), branch_numbers == 1
    if not has_same_direction.any() or abs(torque[0]) > SETTINGS.end_torque * np.abs(torque).max():
        return 0
    start_deflection = float(np.median(deflection[: SETTINGS.median_window]))
    start_torque = float(np.median(torque[: SETTINGS.median_window]))
    later_deflection, opposite_deflection = (
        float(_interpolate(torque[is_on_branch], deflection[is_on_branch], start_torque))
        for is_on_branch in (has_same_direction, is_on_first_branch)
    )
    return (
        int(np.sum(branch_numbers == 0))
        if abs(start_deflection - later_deflection)
        > SETTINGS.lead_distance * abs(opposite_deflection - later_deflection)
        else 0
    )


def _reversal_torque(torque: Array, medians: Array, index: int) -> float:
    """Compute the torque at a reversal of a loop [N m]: the extreme among the points around the index `index`.

    These are `SETTINGS.median_window` points before and after it. The extreme is limited to a distance from the median
    at `index`, so that an outlier has no effect. `torque` [N m] and its running `medians` [N m] have shape (n,).
    """
    neighbours = torque[max(index - SETTINGS.median_window, 0) : index + SETTINGS.median_window + 1]
    extreme_torque = float(neighbours.max() if medians[index] >= np.median(neighbours) else neighbours.min())
    noise, median_step = float(np.median(np.abs(torque - medians))), float(np.median(np.abs(np.diff(torque))))
    tolerance = SETTINGS.max_noise * noise + SETTINGS.max_steps * median_step
    return float(np.clip(extreme_torque, medians[index] - tolerance, medians[index] + tolerance))


def _find_reversals(torque: Array) -> tuple[tuple[float, ...], Integers]:
    """Determine the torques at which a torque history reverses, and the number of the branch of each point.

    `torque` [N m] of n points, shape (n,), is in chronological order. A reversal is an extreme after which the torque
    returns by at least `SETTINGS.reversal` times the range of the torque. If the first branch does not begin at an end
    of the loop, its start torque is replaced by the torque of the second reversal. Likewise, the end torque of the last
    branch is replaced by the torque of the last reversal but one.

    Returns
    -------
    torques, branch
        Torques of start, reversals and end [N m], in chronological order, none if the torque does not reverse; and the
        number of reversals before each point, shape (n,).
    """
    medians = _median_filter(torque)
    min_reversal = SETTINGS.reversal * float(np.ptp(medians))
    reversals: list[int] = []
    extreme_index = min_index = max_index = 0
    direction = 0
    for index, value in enumerate(medians):
        if direction == 0:
            min_index = index if value < medians[min_index] else min_index
            max_index = index if value > medians[max_index] else max_index
            if medians[max_index] - medians[min_index] > min_reversal:
                direction, extreme_index = (1, index) if max_index > min_index else (-1, index)
        elif direction * (value - medians[extreme_index]) > 0.0:
            extreme_index = index
        elif direction * (medians[extreme_index] - value) > min_reversal:
            reversals.append(extreme_index)
            direction, extreme_index = -direction, index
    if not reversals:
        return (), np.zeros(len(torque), int)
    reversal_torques = [_reversal_torque(torque, medians, index) for index in reversals]
    # torques at which the first branch begins and the last one ends: the other ends of the loop
    first_extreme = reversal_torques[1] if len(reversal_torques) > 1 else float(medians[: reversals[0] + 1][0])
    last_extreme = reversal_torques[-2] if len(reversal_torques) > 1 else float(medians[reversals[-1] :][-1])
    initial_branch, last_branch = medians[: reversals[0] + 1], medians[reversals[-1] :]
    start_torque = (
        min(first_extreme, float(initial_branch.min()))
        if reversal_torques[0] > first_extreme
        else max(first_extreme, float(initial_branch.max()))
    )
    end_torque = (
        min(last_extreme, float(last_branch.min()))
        if reversal_torques[-1] > last_extreme
        else max(last_extreme, float(last_branch.max()))
    )
    return (start_torque, *reversal_torques, end_torque), np.searchsorted(
        reversals, np.arange(len(torque)), side="left"
    )
