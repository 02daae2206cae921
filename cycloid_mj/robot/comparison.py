"""Comparison of the joint in MuJoCo with the full model: play, wind-up, efficiency, transmission error, resonance."""

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
from cycloid_mj.robot.identification import GRID, Play, solve_play
from cycloid_mj.robot.reducer import ReducedJoint
from cycloid_mj.robot.ripple import Ripple
from cycloid_mj.robot.stability import measure_vibration
from cycloid_mj.robot.transmission import compute_amplitudes, solve_error
from cycloid_mj.robot.trial import TrialScene, create_trial_scene
from cycloid_mj.statics.sheet import shaft_powers
from cycloid_mj.statics.springs import POSES
from cycloid_mj.statics.windup import LOST_MOTION_SHARE

BOUNDS = {
    "backlash_arcmin": 0.002,
    "loop_arcmin": 0.01,
    "wind_up_arcmin": 0.01,
    "resonance_hz": 0.02,
    "te_harmonic": 0.05,
}
"""Allowed relative difference of the joint from the full model, by key."""


@dataclass(frozen=True)
class ComparisonSettings:
    """Conditions of the comparison with the full model, and allowed differences."""

    max_efficiency: float = 0.3
    """Allowed difference of an efficiency [percentage points]."""
    loads: tuple[float, ...] = (0.1, 0.25, 0.5, 0.75, 1.0)
    """Loads at which efficiencies are compared, as shares of the nominal torque."""
    angles_factor: int = 5
    """Number of crank angles of the full model, over that of `statics`; they differ from those of the
    identification."""
    loop_points: int = 160
    """Number of torques of the loop, zero not among them: there the output rests anywhere in its play."""
    slow_step: float = 5e-3
    """Time step [s] of slow motions, with the integrator `discrete`, which damps vibrations."""
    phase_step: float = 0.02
    """Phase of a vibration in a time step [rad]: its frequency is then right within 1e-4."""
    min_harmonic: float = 0.1
    """Smallest harmonic that is compared, relative to the largest."""
    steps_per_cycle: int = 20
    """Time steps in a cycle of the highest harmonic that is compared, at least."""
    max_error_change: float = 0.25
    """Largest change of the transmission error in a time step, relative to the wind-up at the nominal torque: at a
    larger one the stop recedes from the output in a time step, and the torque then throws the output through it."""
    max_frequency: float = 0.2
    """Highest frequency of a harmonic over that of the resonance: the gain 1/(1 - x^2) is then 4 % above 1."""


COMPARISON = ComparisonSettings()


DIRECTIONS = {"forward": 1, "reverse": -1}
"""Directions of the crank."""


@dataclass(frozen=True, eq=False)
class ModelComparison:
    """Comparison of a joint with the full model."""

    rows: tuple[Quantity, ...]
    """Quantities of the joint, with the full model's value as reference."""
    bounds: dict[str, float]
    """Allowed difference by the key of a row, in its unit."""
    curves: tuple[Curve, ...]
    """Curves of both, for figures."""
    highest_speed: float
    """Speed of the crank [rad/s] up to which the strongest harmonic is transmitted, with the matched inertia."""

    @property
    def highest_speed_rpm(self) -> float:
        """That speed [rpm]."""
        return self.highest_speed / RPM

    @property
    def outside_bounds(self) -> list[str]:
        """Names of the quantities outside their bounds."""
        return [row.name for row in self.rows if not self.is_within(row)]

    def is_within(self, row: Quantity) -> bool:
        """Return whether a quantity is within its bound."""
        return row.reference is not None and bool(abs(row.value - row.reference) <= self.bounds[row.key])

    def table(self) -> Table:
        """Tabulate the quantities of reduced joint and full model, and whether their differences are allowed.

        The allowed differences are `bounds`.
        """
        verdict_texts = {True: "ok", False: "exceeds bound"}
        rows = tuple(
            (
                row.name,
                row.value,
                row.reference or 0.0,
                row.unit,
                self._difference(row),
                verdict_texts[self.is_within(row)],
            )
            for row in self.rows
        )
        return Table(
            "Joint compared with the full model", ("quantity", "joint", "full model", "unit", "difference", ""), rows
        )

    def as_json(self) -> list[dict[str, Any]]:
        """Convert the compared quantities to a list of JSON values, those of `Quantity.as_json` with three more keys.

        ``value`` is that of the joint, ``reference`` that of the full model. The additional keys are ``key``
        (identifier of the quantity), ``bound`` (allowed difference, in ``unit``) and ``holds`` (whether the difference
        is within it).
        """
        return [
            {"key": row.key, **row.as_json(), "bound": self.bounds[row.key], "holds": self.is_within(row)}
            for row in self.rows
        ]

    def _difference(self, row: Quantity) -> str:
        assert row.reference is not None
        if row.unit == "%":
            return f"{row.value - row.reference:+.3f} points"
        return f"{100.0 * (row.value / row.reference - 1.0):+.3f} %" if row.reference else f"{row.value:+.3g}"


def compare_with_full_model(reducer: Reducer, reduced: ReducedJoint) -> ModelComparison:
    """Compare play, wind-up, resonance, efficiency and transmission error of a reduced joint with the full model.

    The joint is simulated in MuJoCo, at the levels `backlash` and `full`. The full model is the static model of all
    contacts of the reducer.
    """
    reducer = reducer.but(load={"torque": reducer.design.rated_torque}).working_at(reducer.design.rated_torque)
    play = solve_play(reducer, COMPARISON.angles_factor * POSES)
    loop_rows, loop_curves = _compare_wind_up(reduced.at("backlash"), play)
    # at steps of a large part of a crank turn, the transmission error would be noise
    joint_without_ripple = replace(reduced.at("full"), ripple=Ripple((), (0.0,), *[((),)] * 6))
    efficiency_rows, efficiency_curves = _compare_efficiencies(reducer, joint_without_ripple)
    transmission = [
        _compare_transmission_error(reducer, reduced.at("full"), name, sign) for name, sign in DIRECTIONS.items()
    ]
    quantities = (
        *loop_rows,
        *_compare_resonance(reduced.at("backlash"), play),
        *efficiency_rows,
        *(row for quantities, _ in transmission for row in quantities),
    )
    bounds = {row.key: BOUNDS.get(row.key, BOUNDS["te_harmonic"]) * abs(row.reference or 0.0) for row in quantities}
    # the joint's backlash is extrapolated from this wind-up, so a smaller backlash is not resolved
    resolved_backlash = (play.backlash + GRID.small * play.wind_up[1.0]) / ARCMINUTE
    bounds["backlash_arcmin"] = BOUNDS["backlash_arcmin"] * resolved_backlash
    bounds |= {row.key: COMPARISON.max_efficiency for row in quantities if row.unit == "%"}
    resonance = math.sqrt(reduced.stiffness(reduced.rated_torque) / (2.0 * reduced.reflected_inertia))
    curves = (*loop_curves, *efficiency_curves, *(curve for _, curves in transmission for curve in curves))
    return ModelComparison(
        quantities, bounds, curves, COMPARISON.max_frequency * resonance / _strongest_order(reduced.ripple)
    )


def _strongest_order(ripple: Ripple) -> float:
    """Compute the order of the largest harmonic at the upper stop under the largest load; 1 where there is none."""
    if not ripple.orders:
        return 1.0
    return ripple.orders[int(np.argmax(np.hypot(ripple.high_cos[-1], ripple.high_sin[-1])))]


def _compare_wind_up(reduced: ReducedJoint, play: Play) -> tuple[list[Quantity], list[Curve]]:
    """Compare backlash, lost motion and wind-up [arcmin] of the joint and the full model, at rest with a locked crank.

    `reduced` is the joint, and `play` has play and wind-up of the full model. The joint's backlash is extrapolated to
    zero torque from two small torques in either direction.

    Returns
    -------
    tuple
        The quantities, and curves of the output's angle against the torque; they have no hysteresis.
    """
    scene = create_trial_scene(reduced, 1e-3 * reduced.reflected_inertia, COMPARISON.slow_step)
    scene.hold()
    rated_torque = play.rated

    def rest_angle(share: float) -> float:
        return scene.find_rest(share * rated_torque)

    angles_at_small_torque = {
        share: rest_angle(share) for share in (GRID.small, 2.0 * GRID.small, -GRID.small, -2.0 * GRID.small)
    }
    joint_backlash = (
        2.0 * angles_at_small_torque[GRID.small]
        - angles_at_small_torque[2.0 * GRID.small]
        - 2.0 * angles_at_small_torque[-GRID.small]
        + angles_at_small_torque[-2.0 * GRID.small]
    )
    wind_up_of_joint = {share: 0.5 * (rest_angle(share) - rest_angle(-share)) for share in (LOST_MOTION_SHARE, 1.0)}
    wind_up_of_full_model = {share: 0.5 * play.backlash + play.wind_up[share] for share in wind_up_of_joint}
    loop_name, small_share = "loop at +-3 % of the nominal torque", LOST_MOTION_SHARE
    compared_values = (
        ("backlash_arcmin", "backlash", joint_backlash, play.backlash),
        ("loop_arcmin", loop_name, 2.0 * wind_up_of_joint[small_share], 2.0 * wind_up_of_full_model[small_share]),
        (
            "wind_up_arcmin",
            "wind-up beyond the stop at the nominal torque",
            wind_up_of_joint[1.0] - 0.5 * joint_backlash,
            play.wind_up[1.0],
        ),
    )
    quantities = [
        Quantity(key, name, value / ARCMINUTE, "arcmin", None, reference / ARCMINUTE)
        for key, name, value, reference in compared_values
    ]
    loop_shares = np.linspace(-1.0, 1.0, COMPARISON.loop_points)
    joint_angles = np.array([rest_angle(share) for share in loop_shares])
    load_shares = np.array([0.0, *sorted(play.wind_up)])
    wind_ups = np.array([0.0, *(play.wind_up[share] for share in load_shares[1:].tolist())])
    full_model_angles = np.concatenate([(play.stops[0] - wind_ups)[::-1], play.stops[1] + wind_ups])
    full_model_torques = rated_torque * np.concatenate([-load_shares[::-1], load_shares])
    axis_labels = "torque on the output [N m]", "turn [arcmin]"
    panel_title = "hysteresis loop, crank locked"
    return quantities, [
        Curve(panel_title, "full model", full_model_torques, full_model_angles / ARCMINUTE, *axis_labels, "theory"),
        Curve(panel_title, "joint", loop_shares * rated_torque, joint_angles / ARCMINUTE, *axis_labels),
    ]


def _compare_resonance(reduced: ReducedJoint, play: Play) -> Iterator[Quantity]:
    """Yield the resonance frequency [Hz] of a reduced joint under nominal torque at a locked crank, and its reference.

    The joint is simulated with a load of ten times its reflected inertia. The reference is sqrt(k/J)/(2 pi). The
    stiffness k [N m/rad] is the slope of the wind-up curve of the full model (`Play.stiffness`), and J [kg m2] is the
    inertia of load and output.
    """
    inertia = 10.0 * reduced.reflected_inertia
    expected_angular_frequency = math.sqrt(play.stiffness / (inertia + reduced.output_inertia))
    _, _, frequency_error = measure_vibration(
        create_trial_scene(reduced, inertia, COMPARISON.phase_step / expected_angular_frequency, "implicitfast"),
        inertia,
    )
    nominal_frequency = math.sqrt(reduced.stiffness(play.rated) / (inertia + reduced.output_inertia))
    frequency = nominal_frequency * (1.0 + frequency_error) / (2.0 * np.pi)
    name = f"resonance with {inertia:.3g} kg m2, crank locked"
    yield Quantity("resonance_hz", name, frequency, "Hz", None, expected_angular_frequency / (2.0 * np.pi))


def _compare_efficiencies(reducer: Reducer, reduced: ReducedJoint) -> tuple[list[Quantity], list[Curve]]:
    """Compare the efficiencies of a reduced joint and of the full model at the rated speed, at several loads.

    The loads are `COMPARISON.loads` times the nominal torque. Both are computed with the crank driving and with the
    output driving.

    Returns
    -------
    tuple
        The efficiencies as quantities [%], and curves against the output torque.
    """
    quantities, curves = [], []
    cases = (("driving", True, "efficiency"), ("driven", False, "efficiency of back-driving"))
    for key, is_driving, name in cases:
        joint_percent = [100.0 * _measure_efficiency(reduced, share, is_driving) for share in COMPARISON.loads]
        sign = 1.0 if is_driving else -1.0
        full_percent = [
            100.0 * _full_model_efficiency(reducer, sign * share * reducer.design.rated_torque)
            for share in COMPARISON.loads
        ]
        for share, joint_value, full_value in zip(COMPARISON.loads, joint_percent, full_percent, strict=True):
            quantities.append(
                Quantity(
                    f"{key}_{share:g}",
                    f"{name} at {share:.0%} of the nominal torque",
                    joint_value,
                    "%",
                    None,
                    full_value,
                )
            )
        torques = np.array(COMPARISON.loads) * reducer.design.rated_torque
        axis_labels = "torque on the output [N m]", "efficiency [%]"
        panel_title = f"{name}, {reduced.rated_speed / RPM:.0f} rpm"
        curves += [
            Curve(panel_title, "full model", torques, np.array(full_percent), *axis_labels, "theory"),
            Curve(panel_title, "joint", torques, np.array(joint_percent), *axis_labels),
        ]
    return quantities, curves


def _full_model_efficiency(reducer: Reducer, torque: float) -> float:
    """Compute the efficiency [1] of the full model under an output torque [N m]; 0 if it is self-locking.

    The torque is positive if the crank drives, negative if the output drives.
    """
    try:
        return shaft_powers(reducer, torque).efficiency
    except RunError:
        if torque > 0.0:
            raise
        return 0.0


def _measure_efficiency(reduced: ReducedJoint, share: float, driving: bool) -> float:
    """Measure the efficiency [1] of a reduced joint in MuJoCo at the rated speed, under a share of the nominal torque.

    `reduced` is the reducer as a joint with springs, backlash and losses instead of parts. `driving` is True if the
    crank drives, False if the output does; the result is 0 for a self-locking joint.
    """
    speed, torque = reduced.rated_speed, share * reduced.rated_torque
    scene = create_trial_scene(reduced, 1e-3 * reduced.reflected_inertia, COMPARISON.slow_step)
    scene.hold(speed)
    # the load brakes the output, or drives it
    scene.press_to_stop(reduced.way * (-torque if driving else torque))
    scene.step()
    scene.step()
    useful_torque, friction_torque = torque / reduced.ratio, scene.friction_torque()
    return joint_powers(useful_torque, friction_torque, driving).efficiency


def _compare_transmission_error(
    reducer: Reducer, reduced: ReducedJoint, name: str, direction: int
) -> tuple[list[Quantity], list[Curve]]:
    """Compare the harmonics of the transmission error at nominal torque over a full, slow turn of the output.

    Only harmonics of at least `COMPARISON.min_harmonic` of the largest are compared.

    Parameters
    ----------
    reducer, reduced
        Full model, and reduced joint.
    name, direction
        Direction of the crank in words, and as 1 or -1.

    Returns
    -------
    tuple
        Amplitude of each harmonic as a quantity [arcsec], and the transmission errors over one turn of the crank as
        curves.
    """
    errors = solve_error(reducer, 1.0, direction)
    model_amplitudes, _ = compute_amplitudes(errors)
    harmonics = np.flatnonzero(np.abs(model_amplitudes) >= COMPARISON.min_harmonic * np.abs(model_amplitudes).max())
    wind_up = reduced.wind_up(reduced.rated_torque)
    steps_of_error = len(errors) * np.abs(np.diff(errors)).max() / (COMPARISON.max_error_change * wind_up)
    step_count = max(COMPARISON.steps_per_cycle * int(harmonics.max()), math.ceil(steps_of_error))
    speed = direction * 2.0 * np.pi * reduced.ratio / (step_count * COMPARISON.slow_step)
    scene = create_trial_scene(reduced, 1e-3 * reduced.reflected_inertia, COMPARISON.slow_step)
    scene.hold(speed)
    scene.press_to_stop(-direction * reduced.way * reduced.rated_torque)
    for _ in range(COMPARISON.steps_per_cycle):
        scene.step()
    angle, deviation = _record_motion(scene, step_count)
    orders = harmonics / reduced.ratio
    basis = np.exp(-1j * np.outer(orders, angle))
    amplitudes = 2.0 * basis @ (deviation - deviation.mean()) / step_count
    quantities = [
        Quantity(
            f"te_{name}_{cycles_per_turn:.4g}",
            f"transmission error, order {cycles_per_turn:.4g}, {name}, at the nominal torque",
            abs(amplitude) * ARCSECONDS,
            "arcsec",
            None,
            abs(model_amplitudes[index]) * ARCSECONDS,
        )
        for cycles_per_turn, amplitude, index in zip(orders.tolist(), amplitudes, harmonics.tolist(), strict=True)
    ]
    return quantities, list(_transmission_error_curves(reducer, errors, angle, deviation, name))


def _record_motion(scene: TrialScene, count: int) -> tuple[Array, Array]:
    """Simulate `count` time steps; return crank angle and output deviation L [rad] after each, shape (count,) each."""
    record = np.empty((count, 2))
    for step in range(count):
        scene.step()
        record[step] = scene.data.qpos[scene.addresses.crank_angle], scene.length
    return record[:, 0], record[:, 1]


def _transmission_error_curves(
    reducer: Reducer, errors: Array, angle: Array, deviation: Array, name: str
) -> Sequence[Curve]:
    """Return the transmission errors of full model and joint over the first turn of the crank, as curves.

    Parameters
    ----------
    reducer
        The reducer under its nominal torque.
    errors
        Error of the full model at n evenly spaced crank angles over a full turn of the output [rad], shape (n,).
    angle, deviation
        Crank angle and output deviation of the joint at m time steps in MuJoCo [rad], shape (m,) each.
    name
        Direction of the crank, in words.
    """
    design = reducer.design
    angle = np.mod(angle, 2.0 * np.pi * design.reduction)
    panel_title = f"transmission error under {design.rated_torque:.4g} N m, {name}"
    axis_labels = "crank angle [deg]", "output's error about its mean [arcsec]"
    crank_degrees = np.degrees(2.0 * np.pi * np.arange(errors.size) / errors.size * design.reduction)
    is_in_first_turn, is_recorded_in_first_turn = crank_degrees <= 360.0, angle <= 2.0 * np.pi
    return (
        Curve(
            panel_title,
            "full model",
            crank_degrees[is_in_first_turn],
            ARCSECONDS * (errors - errors.mean())[is_in_first_turn],
            *axis_labels,
            "theory",
        ),
        Curve(
            panel_title,
            "joint",
            np.degrees(angle[is_recorded_in_first_turn]),
            ARCSECONDS * (deviation - deviation.mean())[is_recorded_in_first_turn],
            *axis_labels,
        ),
    )
