"""A loop as a bench measured it: torque against deflection of the output, read, checked, and in branches."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.base.errors import UsageError, reason
from cycloid_mj.base.frame import Frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.overwrite_guard import as_input
from cycloid_mj.base.units import DEGREE

TORQUE, DEFLECTION = COLUMNS = ("torque_output_Nm", "deflection_deg")

FEWEST = 20
"""Points of a loop: fewer hold no branches."""

REVERSAL = 0.2
"""A torque has turned round once it has come back by this share of its range."""

SMOOTHED = 5
"""Neighbours whose median stands for a torque where the course turns round: single outliers are no ends."""

OFF_LOOP, NEAR_END = 1.0 / 3.0, 0.9
"""Distance of a beginning from the loop's own branch, as a share of its width there, from which it is not of the loop;
and torque, as a share of the largest, from which a beginning is at the loop's end."""

FEWEST_OF_A_BRANCH = 6
"""Points of a branch in the mean: with fewer the torque goes to and fro, as where rows are not in the order of time."""

TAKEN_OUT = 0.02
"""Turn, as a share of the height, by which falling branches lie below the rising ones where a loop gives work away."""

LEAST_HEIGHT, MOST_HEIGHT = 1e-4, 90.0
"""Height of a loop [deg] that can be in degrees: an output that turns further is not held."""

MILLIMETRES, KILO = 30.0, 1e-3
"""How many times the rated torque a torque goes to that is taken to be in N mm, and in kN m."""


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredLoop(Presented):
    """One measured loop.

    Attributes
    ----------
    name
        Its file's, without the ending.
    torque, deflection
        At the output [N m] and of it [rad], in the order of time, shape (n,); both counter-clockwise.
    turns
        Torques at which the course turns round [N m], in their order.
    branch
        Of each point: how often the course has turned round before, shape (n,).
    flipped
        Whether the file counts deflection against the torque: then its sign has been turned here.
    lead
        How many of the first points are the way to the loop, as from rest, and not of the loop.
    """

    name: str
    torque: Array
    deflection: Array
    turns: tuple[float, ...]
    branch: Integers
    flipped: bool = False
    lead: int = 0

    @property
    def frame(self) -> Frame:
        """Its points, a row each."""
        columns = {"torque": self.torque, "deflection": self.deflection, "branch": self.branch}
        return Frame(columns, {"torque": "N m", "deflection": "rad"})

    @property
    def line(self) -> str:
        """What it is."""
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
        """The lowest and the highest torque at which the course turns round [N m]."""
        return min(self.turns), max(self.turns)

    @property
    def most(self) -> float:
        """The largest torque at which the course turns round, of either sign [N m]."""
        return max(map(abs, self.turns))

    @property
    def rising(self) -> bool:
        """Whether the torque of the first branch rises."""
        return self.turns[1] > self.turns[0]

    def on_the_way(self, way: int) -> Mask:
        """Tell which points of the loop lie where the torque rises, `way` 1, or falls, -1, shape (n,)."""
        rising = (self.branch % 2 == 0) == self.rising
        return (rising == (way > 0)) & (np.arange(len(self.torque)) >= self.lead)


def _between(along: Array, values: Array, level: float | Array) -> Array:
    """Compute the value at a level by the straight line between the points next to it on either side."""
    order = np.argsort(along)
    return np.asarray(np.interp(level, along[order], values[order]))


def read_loop(path: Path | str) -> MeasuredLoop:
    """Read a loop from a CSV file of the columns torque_output_Nm and deflection_deg; lines of other text may be named.

    A header after ``#`` is one too.

    Parameters
    ----------
    path
        The CSV file.

    Raises
    ------
    UsageError
        The file is not there, not of that form, or holds no loop.
    """
    path = Path(path)
    columns = read_columns(path, COLUMNS, "a loop")
    return measured_loop(path.stem, columns[TORQUE], columns[DEFLECTION], str(path))


def read_columns(path: Path, names: tuple[str, ...], what: str) -> dict[str, Array]:
    """Read columns of numbers from a CSV file whose header, with or without a ``#``, names them.

    Raises
    ------
    UsageError
        The file cannot be read, lacks a column, has no rows, or has something else than a number in one.
    """
    form = f"{what} has the columns {','.join(names)}, separated by commas"
    try:
        lines = as_input(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"cannot read {path}: {reason(error)}; {form}") from error
    numbered = [(number, line) for number, line in enumerate(lines, 1) if line.strip(" \t#")]
    header = next((place for place, (_, line) in enumerate(numbered) if names[0] in line), None)
    columns = ", ".join(numbered[0][1].lstrip("# ").split(",")) if numbered else "nothing: the file is empty"
    if header is None:
        raise UsageError(f"{path}: {form}, named in its first line; found {columns[:80]}")
    keys = [key.strip() for key in numbered[header][1].lstrip("# ").split(",")]
    if missing := [name for name in names if name not in keys]:
        raise UsageError(f"{path}: the column {missing[0]} is missing: {form}; found {', '.join(keys)}")
    rows = [(number, row) for number, row in numbered[header + 1 :] if not row.lstrip().startswith("#")]
    if not rows:
        raise UsageError(f"{path}: there are no rows below the header; {form}")
    values: dict[str, list[float]] = {name: [] for name in names}
    for number, line in rows:
        words = next(csv.reader([line]))
        for name in names:
            place = keys.index(name)
            values[name].append(_number(words[place] if place < len(words) else "", f"{path}, line {number}: {name}"))
    return {name: np.array(column) for name, column in values.items()}


def _number(word: str, where: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UsageError(f"{where} is {word.strip()!r}; give a number, or take the line out")
    return value


def measured_loop(name: str, torque: Array, deflection_deg: Array, where: str = "") -> MeasuredLoop:
    """Build a loop from torque [N m] and deflection [deg], shape (n,) each; `where` it comes from, for errors.

    Raises
    ------
    UsageError
        They are no loop: too few points, one far from all others, one branch, rows out of order, columns exchanged, or
        a deflection that is in no way in degrees.
    """
    where, count = where or name, len(torque)
    if count < FEWEST:
        raise UsageError(f"{where}: {count} points are no loop; give at least {FEWEST}")
    height = float(np.ptp(deflection_deg))
    if not np.ptp(torque) > 0.0 or not height > 0.0:
        still = TORQUE if not np.ptp(torque) > 0.0 else DEFLECTION
        raise UsageError(f"{where}: {still} is the same in all rows: that is no loop")
    turns, branch = _turns(torque)
    if count < FEWEST_OF_A_BRANCH * (turned := len(np.unique(branch))):
        raise UsageError(
            f"{where}: the torque turns round {turned - 1} times in {count} points: are the rows in the order of time?"
        )
    _require_no_stray(torque, TORQUE, where)
    _require_no_stray(deflection_deg, DEFLECTION, where)
    if not LEAST_HEIGHT <= height <= MOST_HEIGHT:
        other = "in minutes or seconds of arc" if height > MOST_HEIGHT else "in turns, or of another drive"
        raise UsageError(
            f"{where}: the deflection goes over {height:.3g} deg, which no held output does: is it {other}? "
            f"{DEFLECTION} is in degrees"
        )
    if len(turns) < 2 or len(np.unique(branch)) < 2 or min(turns) >= 0.0 or max(turns) <= 0.0:
        raise UsageError(
            f"{where}: one branch only, from {torque[0]:.4g} to {torque[-1]:.4g} N m: a loop goes to a torque, to one "
            "of the other sign, and back; without it friction cannot be told from stiffness"
        )
    flipped = float(np.polyfit(torque, deflection_deg, 1)[0]) < 0.0
    deflection = DEGREE * deflection_deg * (-1.0 if flipped else 1.0)
    lead = _lead(torque, deflection, branch)
    loop = MeasuredLoop(name, torque, deflection, turns, branch, flipped, lead)
    if _opening(loop) < -TAKEN_OUT * loop.height:
        raise UsageError(
            f"{where}: the loop gives work away: under a torque that falls the output is turned less far than under "
            "one that rises. Are the two columns exchanged, or the rows in the reverse order of time?"
        )
    return loop


def require_torque(loop: MeasuredLoop, rated: float) -> None:
    """Raise UsageError for a loop that is near a drive's rated torque [N m] only if it was meant in N mm or kN m."""
    if rated and loop.most > MILLIMETRES * rated:
        raise UsageError(
            f"{loop.name}: the torque goes to {loop.most:.4g} N m, {loop.most / rated:.3g} times the design's "
            f"rated {rated:.4g} N m: is {TORQUE} in N mm? then divide it by 1000; if not, give the design its "
            "drive.torque_nm"
        )
    if loop.most < KILO * rated:
        raise UsageError(
            f"{loop.name}: the torque goes to {loop.most:.4g} N m, {loop.most / rated:.3g} of the design's rated "
            f"{rated:.4g} N m: is {TORQUE} in kN m? then multiply it by 1000; if not, measure a loop of more torque"
        )


def _require_no_stray(values: Array, column: str, where: str) -> None:
    """Refuse a value that is farther from its neighbours than the whole loop goes."""
    smooth = _smoothed(values)
    away = np.abs(values - smooth)
    worst = int(np.argmax(away))
    if away[worst] > np.ptp(smooth):
        raise UsageError(
            f"{where}: {column} is {values[worst]:.4g} in row {worst + 1} below the header, and near "
            f"{smooth[worst]:.4g} in those beside it: take that row out"
        )


def _opening(loop: MeasuredLoop) -> float:
    """Compute by how much the falling branches lie above the rising ones [rad], in the mean over the torque of both."""
    ways = [loop.on_the_way(way) for way in (1, -1)]
    inside = max(loop.torque[way].min() for way in ways), min(loop.torque[way].max() for way in ways)
    levels = np.linspace(*inside, len(loop.torque))
    rising, falling = (_between(loop.torque[way], loop.deflection[way], levels) for way in ways)
    return float(np.mean(falling - rising))


def _smoothed(values: Array) -> Array:
    """Compute the median of each value and its neighbours, shape (n,)."""
    padded = np.pad(values, SMOOTHED // 2, mode="edge")
    return np.asarray(np.median(np.lib.stride_tricks.sliding_window_view(padded, SMOOTHED), axis=1))


def _lead(torque: Array, deflection: Array, branch: Integers) -> int:
    """Count how many points come before the loop: those of a first branch that begins off the others that go its way.

    A bench that starts from rest begins in the middle of the loop, and a loop that has closed, on its own branch.
    """
    same, other = (branch > 0) & (branch % 2 == 0), branch == 1
    if not same.any() or abs(torque[0]) > NEAR_END * np.abs(torque).max():
        return 0
    begun = float(np.median(deflection[:SMOOTHED]))
    at = float(np.median(torque[:SMOOTHED]))
    again, across = (float(_between(torque[one], deflection[one], at)) for one in (same, other))
    return int(np.sum(branch == 0)) if abs(begun - again) > OFF_LOOP * abs(across - again) else 0


def _end(torque: Array, smooth: Array, place: int) -> float:
    """Compute the torque at which a course turns round near a place: the outermost there, unless it is an outlier."""
    near = torque[max(place - SMOOTHED, 0) : place + SMOOTHED + 1]
    outermost = float(near.max() if smooth[place] >= np.median(near) else near.min())
    usual = 3.0 * float(np.median(np.abs(torque - smooth))) + 2.0 * float(np.median(np.abs(np.diff(torque))))
    return float(np.clip(outermost, smooth[place] - usual, smooth[place] + usual))


def _turns(torque: Array) -> tuple[tuple[float, ...], Integers]:
    """Find the torques at which a course turns round, with where it comes from and goes, and the branch of each point.

    A first branch that starts half-way is taken to come from the extreme before it, as that of a closed loop does; the
    last to go to the one after.
    """
    smooth = _smoothed(torque)
    least = REVERSAL * float(np.ptp(smooth))
    places: list[int] = []
    best = low = high = 0
    way = 0
    for place, value in enumerate(smooth):
        if way == 0:
            low = place if value < smooth[low] else low
            high = place if value > smooth[high] else high
            if smooth[high] - smooth[low] > least:
                way, best = (1, place) if high > low else (-1, place)
        elif way * (value - smooth[best]) > 0.0:
            best = place
        elif way * (smooth[best] - value) > least:
            places.append(best)
            way, best = -way, place
    if not places:
        return (), np.zeros(len(torque), int)
    inner = [_end(torque, smooth, place) for place in places]
    # where the first branch comes from, and the last goes to: where the torque is at its other end
    first = inner[1] if len(inner) > 1 else float(smooth[: places[0] + 1][0])
    last = inner[-2] if len(inner) > 1 else float(smooth[places[-1] :][-1])
    beginning, end = smooth[: places[0] + 1], smooth[places[-1] :]
    start = min(first, float(beginning.min())) if inner[0] > first else max(first, float(beginning.max()))
    stop = min(last, float(end.min())) if inner[-1] > last else max(last, float(end.max()))
    return (start, *inner, stop), np.searchsorted(places, np.arange(len(torque)), side="left")
