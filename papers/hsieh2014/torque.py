"""Fig. 19: the output torque at the rated input torque, and the friction that would give the paper's."""

import math
from collections.abc import Iterator, Mapping, Sequence

from cycloid_mj.measure import Measurement
from cycloid_mj.measure.pool import Progress as Steps
from cycloid_mj.result import Claim, Quantity, Table, Value, Verdict
from hsieh2014.plan import Plan, designs, equalised
from hsieh2014.stage import Found, Plate, Progress, Runs
from hsieh2014.stated import IDEAL, TORQUES, torques
from hsieh2014.statements import AHEAD, TORQUE_ORDER, output_torque

NEAR = 0.01
"""Torques agree within this share of the torque without losses."""
ERROR = "half the step or half the average"


def torque(plan: Plan, runs: Runs, progress: Progress) -> Found:
    """Measure the output torque of both designs, as `cycloid-mj measure torque` does."""
    from cycloid_mj.measure import torque as measure_torque
    from cycloid_mj.plots.measure import measurement_figure

    found = {
        design.name: measure_torque(design, plan.quick, _steps(progress, design.name), torques(design))
        for design in designs()
    }
    progress(equalised().name)
    alike = _at_equal_play(plan)
    plates = tuple(
        Plate(
            f"fig19_torque_{name}",
            "Fig. 19",
            f"{name}: output torque at 1.048 N m in, its ripple by order, and the output rate by friction with the "
            "paper's rates on it.",
            measurement_figure(one),
        )
        for name, one in found.items()
    )
    return Found(
        plates,
        (_columns(found, alike), *(_named(table, name) for name, one in found.items() for table in one.tables)),
        (*_claims(found), _order(found)),
        {name: {key: each.as_json() for key, each in one.quantities.items()} for name, one in found.items()}
        | {equalised().name: {"output_torque_nm": alike}},
        tuple(dict.fromkeys(sentence for one in found.values() for sentence in one.assumptions)),
    )


def _at_equal_play(plan: Plan) -> float:
    """Give the output torque [N m] of the nonpin design with the pin design's total play and series stiffness."""
    from cycloid_mj.measure.steady import steady_design, whole_periods
    from cycloid_mj.measure.torque import PERIODS, QUICK_PERIODS, rated_test

    design = steady_design(equalised())
    return rated_test(design, whole_periods(design, QUICK_PERIODS if plan.quick else PERIODS)).output


def _columns(found: Mapping[str, Measurement], alike: float) -> Table:
    """Put the output torques side by side: the design's effect apart from that of clearance and compliance."""
    torques = {name: one["output_torque"] for name, one in found.items()} | {equalised().name: alike}
    return Table(
        "output torque at equal friction, 1.048 N m in; the third has the pin design's total play and series stiffness",
        ("", *torques),
        (
            ("output torque [N m]", *(f"{torque:.2f}" for torque in torques.values())),
            ("output rate [%]", *(f"{100 * torque / IDEAL:.2f}" for torque in torques.values())),
        ),
    )


def _steps(progress: Progress, name: str) -> Steps:
    """Give what tells how many runs of a design are done."""
    return lambda done, of: progress(f"{name}, {done} of {of} runs")


def _named(table: Table, name: str) -> Table:
    return Table(f"{name}: {table.title}", table.header, table.rows)


def _claims(found: Mapping[str, Measurement]) -> Iterator[Claim]:
    """Hold each output torque against ours: by number, and else by whether a friction gives it."""
    for name, ways in TORQUES.items():
        one = found[name]
        ours, error = one["output_torque"], one.quantities["output_torque"].error
        for way, paper in ways.items():
            friction = one.quantities[f"friction_for_paper_{way}"]
            yield output_torque(way, name).judged(
                found=Value(f"{ours:.2f} N m, {100 * ours / IDEAL:.1f} %", ours, "N m"),
                error=Value(ERROR, error, "N m"),
                verdict=_verdict(ours, paper, friction.value),
                decided_by=f"friction of the sliding pairs, left open by the paper: {_friction(friction)}",
            )


def _verdict(ours: float, paper: float, friction: float) -> Verdict:
    if abs(ours - paper) <= NEAR * IDEAL:
        return Verdict.AGREES
    return Verdict.DEPENDS if math.isfinite(friction) else Verdict.DISAGREES


def _friction(friction: Quantity) -> str:
    if not math.isfinite(friction.value):
        return "none that was tried gives it"
    error = f" (error {friction.error:.1g})" if friction.error else ""
    return f"{friction.value:.3f}{error} for all of them gives it"


def _order(found: Mapping[str, Measurement]) -> Claim:
    """Judge which design gives more torque: at equal friction, and at the frictions that give the paper's torques."""
    pin, nonpin = found["pin"], found["nonpin"]
    ours = {name: one["output_torque"] for name, one in found.items()}
    error = max(one.quantities["output_torque"].error or 0.0 for one in found.values())
    needed = [one["friction_for_paper_simulated"] for one in (pin, nonpin)]
    ahead = ours["nonpin"] - ours["pin"]
    return TORQUE_ORDER.judged(
        found=Value(f"{ours['nonpin']:.2f} to {ours['pin']:.2f} N m", ahead, AHEAD),
        error=Value(ERROR, error, "N m"),
        verdict=_order_verdict(ahead, error, needed),
        decided_by="friction of each design, left open by the paper: its simulated torques take "
        f"{needed[0]:.3f} with pins and {needed[1]:.3f} without. At equal friction the total play, the stiffness in "
        "series and the assumed cam decide; with those equal both designs lose alike, whether a pin is free to turn or "
        "not",
    )


def _order_verdict(ahead: float, error: float, needed: Sequence[float]) -> Verdict:
    """Judge the order by the torque that the nonpin design is ahead [N m], its error, and the frictions needed."""
    if ahead > error:
        return Verdict.AGREES
    if all(map(math.isfinite, needed)):
        return Verdict.DEPENDS
    return Verdict.DISAGREES if ahead < -error else Verdict.NOT_DETERMINED
