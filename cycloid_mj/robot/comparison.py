"""The joint, as MuJoCo runs it, against the full model: play, wind-up, efficiency, transmission error, resonance."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import RunError
from cycloid_mj.base.result import Curve, Quantity, Table
from cycloid_mj.base.units import ARCMINUTE, ARCSECONDS, RPM
from cycloid_mj.reducer import Reducer
from cycloid_mj.robot.friction import joint_powers
from cycloid_mj.robot.identification import SMALL, Play, play_of
from cycloid_mj.robot.reducer import ReducedJoint
from cycloid_mj.robot.ripple import Ripple
from cycloid_mj.robot.stability import vibration
from cycloid_mj.robot.transmission import error, waves
from cycloid_mj.robot.trial import TrialScene, bench
from cycloid_mj.statics.balance import powers
from cycloid_mj.statics.springs import POSES
from cycloid_mj.statics.windup import LOST_MOTION_SHARE

BOUNDS = {
    "backlash_arcmin": 0.002,
    "loop_arcmin": 0.01,
    "wind_up_arcmin": 0.01,
    "resonance_hz": 0.02,
    "te_harmonic": 0.05,
}
"""Largest relative difference of the joint from the full model, by key."""

POINTS = 0.3
"""Largest difference of an efficiency [points of percent]."""

SHARES = (0.1, 0.25, 0.5, 0.75, 1.0)
"""Loads at which efficiencies are held against each other, as shares of the rated torque."""

ANGLES = 5
"""Times as many crank angles of the full model as `statics` has; not those that the joint was measured at."""

POINTS_OF_THE_LOOP = 160
"""Torques from end to end, zero not among them: there the output rests anywhere in its play."""

QUASI_STATIC = 5e-3
"""Step [s] of what is slow, with the integrator `discrete`, which damps all that would vibrate."""

ANGLE = 0.02
"""Angle of a vibration in a step [rad]: its frequency is then right within a part in ten thousand."""

NOTABLE = 0.1
"""Harmonics are compared that have this share of the largest."""

WAYS = {"forward": 1, "reverse": -1}
"""Ways of the crank."""

STEPS_IN_A_CYCLE = 20
"""Of the highest harmonic that is compared."""

BELOW = 0.2
"""Highest frequency of a harmonic over that of the joint's resonance: the gain 1/(1 - x^2) is then 4 %."""


@dataclass(frozen=True, eq=False)
class Against:
    """What the comparison found.

    Attributes
    ----------
    rows
        Of each the joint's value, and the full model's as its reference.
    bounds
        Key of a row -> largest difference that is allowed, in its unit.
    curves
        Of both, for figures.
    highest_speed
        Of the crank [rad/s] up to which the strongest harmonic comes through, at the matched inertia.
    """

    rows: tuple[Quantity, ...]
    bounds: dict[str, float]
    curves: tuple[Curve, ...]
    highest_speed: float

    @property
    def highest_speed_rpm(self) -> float:
        """The same [rpm]."""
        return self.highest_speed / RPM

    @property
    def missed(self) -> list[str]:
        """Names of what is further from the full model than allowed."""
        return [row.name for row in self.rows if not self.holds(row)]

    def holds(self, row: Quantity) -> bool:
        """Tell whether a row is within its bound."""
        return row.reference is not None and bool(abs(row.value - row.reference) <= self.bounds[row.key])

    def table(self) -> Table:
        """Tabulate the rows."""
        rows = tuple(
            (
                row.name,
                row.value,
                row.reference or 0.0,
                row.unit,
                self._difference(row),
                "holds" if self.holds(row) else "NO",
            )
            for row in self.rows
        )
        return Table("Joint against full model", ("quantity", "joint", "full model", "unit", "difference", ""), rows)

    def as_json(self) -> list[dict[str, Any]]:
        """Convert the rows to JSON values."""
        return [
            {"key": row.key, **row.as_json(), "bound": self.bounds[row.key], "holds": self.holds(row)}
            for row in self.rows
        ]

    def _difference(self, row: Quantity) -> str:
        assert row.reference is not None
        if row.unit == "%":
            return f"{row.value - row.reference:+.3f} points"
        return f"{100.0 * (row.value / row.reference - 1.0):+.3f} %" if row.reference else f"{row.value:+.3g}"


def against(reducer: Reducer, reduced: ReducedJoint) -> Against:
    """Run the joint in MuJoCo at the levels `backlash` and `full` and hold it against the full model."""
    reducer = reducer.but(load={"torque": reducer.design.rated_torque}).working_at(reducer.design.rated_torque)
    play = play_of(reducer, ANGLES * POSES)
    slow, slow_curves = _loop(reduced.at("backlash"), play)
    # at steps of a large part of a crank turn, the transmission error would be noise
    smooth = replace(reduced.at("full"), ripple=Ripple((), (0.0,), *[((),)] * 6))
    lossy, lossy_curves = _efficiencies(reducer, smooth)
    ways = [_transmission(reducer, reduced.at("full"), name, way) for name, way in WAYS.items()]
    rows = (*slow, *_resonance(reduced.at("backlash"), play), *lossy, *(row for rows, _ in ways for row in rows))
    bounds = {row.key: POINTS if row.unit == "%" else _bound(row) for row in rows}
    resonance = math.sqrt(reduced.stiffness(reduced.rated_torque) / (2.0 * reduced.reflected_inertia))
    curves = (*slow_curves, *lossy_curves, *(curve for _, curves in ways for curve in curves))
    return Against(rows, bounds, curves, BELOW * resonance / _strongest(reduced.ripple))


def _bound(row: Quantity) -> float:
    key = "te_harmonic" if row.unit == "arcsec" else row.key
    return BOUNDS[key] * abs(row.reference or 0.0)


def _strongest(ripple: Ripple) -> float:
    """Compute the order of the largest harmonic at the upper stop under the largest load; 1 where there is none."""
    if not ripple.orders:
        return 1.0
    return ripple.orders[int(np.argmax(np.hypot(ripple.high_cos[-1], ripple.high_sin[-1])))]


def _loop(reduced: ReducedJoint, play: Play) -> tuple[list[Quantity], list[Curve]]:
    """Let the output rest under torques from one end to the other at a locked crank."""
    on = bench(reduced, 1e-3 * reduced.reflected_inertia, QUASI_STATIC)
    on.hold()
    rated = play.rated

    def turn(share: float) -> float:
        return on.rest(share * rated)

    small = {share: turn(share) for share in (SMALL, 2.0 * SMALL, -SMALL, -2.0 * SMALL)}
    width = 2.0 * small[SMALL] - small[2.0 * SMALL] - 2.0 * small[-SMALL] + small[-2.0 * SMALL]
    joint = {share: 0.5 * (turn(share) - turn(-share)) for share in (LOST_MOTION_SHARE, 1.0)}
    full = {share: 0.5 * play.backlash + play.wind_up[share] for share in joint}
    rows = [
        Quantity("backlash_arcmin", "backlash", width / ARCMINUTE, "arcmin", None, play.backlash / ARCMINUTE),
        Quantity(
            "loop_arcmin",
            "loop at +-3 % of the rated torque",
            2.0 * joint[LOST_MOTION_SHARE] / ARCMINUTE,
            "arcmin",
            None,
            2.0 * full[LOST_MOTION_SHARE] / ARCMINUTE,
        ),
        Quantity(
            "wind_up_arcmin",
            "wind-up beyond the stop at the rated torque",
            (joint[1.0] - 0.5 * width) / ARCMINUTE,
            "arcmin",
            None,
            play.wind_up[1.0] / ARCMINUTE,
        ),
    ]
    ramp = np.linspace(-1.0, 1.0, POINTS_OF_THE_LOOP)
    joint_turn = np.array([turn(share) for share in ramp])
    shares = np.array([0.0, *sorted(play.wind_up)])
    half = np.array([0.0, *(play.wind_up[share] for share in shares[1:].tolist())])
    sides = [(play.stops[1] + half, shares * rated), (play.stops[0] - half, -shares * rated)]
    whole = [np.concatenate([sides[1][i][::-1], sides[0][i]]) for i in (0, 1)]
    axes = "torque on the output [N m]", "turn [arcmin]"
    panel = "hysteresis loop, crank locked"
    return rows, [
        Curve(panel, "full model", whole[1], whole[0] / ARCMINUTE, *axes, "theory"),
        Curve(panel, "joint", ramp * rated, joint_turn / ARCMINUTE, *axes),
    ]


def _resonance(reduced: ReducedJoint, play: Play) -> Iterator[Quantity]:
    """Let a heavy load vibrate about the rated torque: sqrt(k/J), with the full model's slope."""
    inertia = 10.0 * reduced.reflected_inertia
    expected = math.sqrt(play.stiffness / (inertia + reduced.output_inertia))
    _, _, off = vibration(bench(reduced, inertia, ANGLE / expected, "implicitfast"), inertia)
    still = math.sqrt(reduced.stiffness(play.rated) / (inertia + reduced.output_inertia))
    frequency = still * (1.0 + off) / (2.0 * np.pi)
    yield Quantity(
        "resonance_hz",
        f"resonance with {inertia:.3g} kg m2, crank held",
        frequency,
        "Hz",
        None,
        expected / (2.0 * np.pi),
    )


def _efficiencies(reducer: Reducer, reduced: ReducedJoint) -> tuple[list[Quantity], list[Curve]]:
    """Turn the crank at the rated speed under loads both ways."""
    rows, curves = [], []
    ways = (("driving", True, "efficiency"), ("driven", False, "efficiency of back-driving"))
    for key, driving, name in ways:
        joint = [100.0 * _efficiency(reduced, share, driving) for share in SHARES]
        sign = 1.0 if driving else -1.0
        full = [100.0 * _of_full_model(reducer, sign * share * reducer.design.rated_torque) for share in SHARES]
        for share, ours, theirs in zip(SHARES, joint, full, strict=True):
            rows.append(
                Quantity(f"{key}_{share:g}", f"{name} at {share:.0%} of the rated torque", ours, "%", None, theirs)
            )
        torques = np.array(SHARES) * reducer.design.rated_torque
        axes = "torque on the output [N m]", "efficiency [%]"
        panel = f"{name}, {reduced.rated_speed / RPM:.0f} rpm"
        curves += [
            Curve(panel, "full model", torques, np.array(full), *axes, "theory"),
            Curve(panel, "joint", torques, np.array(joint), *axes),
        ]
    return rows, curves


def _of_full_model(reducer: Reducer, torque: float) -> float:
    """Compute the efficiency of the full model; 0 where an output that drives is jammed by friction."""
    try:
        return powers(reducer, torque).efficiency
    except RunError:
        if torque > 0.0:
            raise
        return 0.0


def _efficiency(reduced: ReducedJoint, share: float, driving: bool) -> float:
    """Compute the joint's efficiency by the power that friction takes in MuJoCo; 0 where the load cannot give it."""
    speed, torque = reduced.rated_speed, share * reduced.rated_torque
    on = bench(reduced, 1e-3 * reduced.reflected_inertia, QUASI_STATIC)
    on.hold(speed)
    # the load brakes the output, or drives it
    on.press(reduced.way * (-torque if driving else torque))
    on.step()
    on.step()
    useful, taken = torque / reduced.ratio, on.friction_torque()
    return joint_powers(useful, taken, driving).efficiency


def _transmission(reducer: Reducer, reduced: ReducedJoint, name: str, way: int) -> tuple[list[Quantity], list[Curve]]:
    """Turn the crank under the rated load through a whole turn of the output, as slowly as the steps ask."""
    errors = error(reducer, 1.0, way)
    fine, _ = waves(errors)
    turns = round(reduced.ratio)
    strong = np.flatnonzero(np.abs(fine) >= NOTABLE * np.abs(fine).max())
    count = STEPS_IN_A_CYCLE * int(strong.max())
    speed = way * 2.0 * np.pi * turns / (count * QUASI_STATIC)
    on = bench(reduced, 1e-3 * reduced.reflected_inertia, QUASI_STATIC)
    on.hold(speed)
    on.press(-way * reduced.way * reduced.rated_torque)
    for _ in range(STEPS_IN_A_CYCLE):
        on.step()
    angle, length = _followed(on, count)
    order = strong / turns
    basis = np.exp(-1j * np.outer(order, angle))
    joint = 2.0 * basis @ (length - length.mean()) / count
    rows = [
        Quantity(
            f"te_{name}_{one:.4g}",
            f"transmission error, order {one:.4g}, {name}, at the rated torque",
            abs(ours) * ARCSECONDS,
            "arcsec",
            None,
            abs(fine[place]) * ARCSECONDS,
        )
        for one, ours, place in zip(order.tolist(), joint, strong.tolist(), strict=True)
    ]
    return rows, list(_te_curves(reducer, errors, angle, length, name))


def _followed(on: TrialScene, count: int) -> tuple[Array, Array]:
    """Compute crank angle and L over `count` steps, shape (count,)."""
    followed = np.empty((count, 2))
    for i in range(count):
        on.step()
        followed[i] = on.data.qpos[on.place.crank_angle], on.length
    return followed[:, 0], followed[:, 1]


def _te_curves(reducer: Reducer, errors: Array, angle: Array, length: Array, name: str) -> Sequence[Curve]:
    """Draw the first turn of the crank after angle 0; what turned back is at the same angles less whole turns."""
    design = reducer.design
    angle = np.mod(angle, 2.0 * np.pi * design.reduction)
    panel = f"transmission error under {design.rated_torque:.4g} N m, {name}"
    axes = "crank angle [deg]", "output's error about its mean [arcsec]"
    full = np.degrees(2.0 * np.pi * np.arange(errors.size) / errors.size * design.reduction)
    first, ours = full <= 360.0, angle <= 2.0 * np.pi
    return (
        Curve(panel, "full model", full[first], ARCSECONDS * (errors - errors.mean())[first], *axes, "theory"),
        Curve(panel, "joint", np.degrees(angle[ours]), ARCSECONDS * (length - length.mean())[ours], *axes),
    )
