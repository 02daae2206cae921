"""Fig. 19: the output torque at the rated input torque, and the friction that would give the paper's."""

import math
from collections.abc import Iterator, Mapping, Sequence

from cycloid_mj.measure import Measurement, Table
from cycloid_mj.measure.paper import IDEAL, TORQUES
from cycloid_mj.measure.pool import Done
from cycloid_mj.reproduce.claims import Claim, Verdict
from cycloid_mj.reproduce.plan import Plan, designs
from cycloid_mj.reproduce.stage import Found, Plate, Runs, Told

NEAR = 0.01
"""Torques agree within this share of the torque without losses."""

SENSITIVITY = "output rate by friction, one pair at a time"


def torque(plan: Plan, runs: Runs, told: Told) -> Found:
    """Measure the output torque of both designs, as `cycloid-mj measure torque` does."""
    from cycloid_mj.measure.torque import measure_torque
    from cycloid_mj.plots.measure import measurement_figure

    found = {design.name: measure_torque(design, plan.quick, _steps(told, design.name)) for design in designs()}
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
        tuple(_named(table, name) for name, one in found.items() for table in one.tables),
        (*_claims(found), _order(found)),
        {name: {key: each.as_json() for key, each in one.quantities.items()} for name, one in found.items()},
        tuple(dict.fromkeys(sentence for one in found.values() for sentence in one.assumptions)),
    )


def _steps(told: Told, name: str) -> Done:
    """Give what tells how many runs of a design are done."""
    return lambda done, of: told(f"{name}, {done} of {of} runs")


def _named(table: Table, name: str) -> Table:
    return Table(f"{name}: {table.title}", table.header, table.rows)


def _claims(found: Mapping[str, Measurement]) -> Iterator[Claim]:
    for name, ways in TORQUES.items():
        one = found[name]
        ours, error = one["output_torque"], one.quantities["output_torque"].error or math.nan
        for way, paper in ways.items():
            friction = one.quantities[f"friction_for_paper_{way}"]
            yield Claim(
                "Fig. 19" if way == "measured" else "section 3.4",
                f"{name}: output torque at 1.048 N m in, {way}",
                f"{paper:g} N m, {100 * paper / IDEAL:.1f} %",
                f"{ours:.2f} N m, {100 * ours / IDEAL:.1f} %",
                f"{error:.1g} N m",
                _verdict(ours, paper, friction.value),
                "friction of the sliding pairs, which the paper does not tell",
                _friction(friction.value, friction.error, one.tables),
                {"output_torque_nm": ours, "friction_for_paper": friction.value},
            )


def _verdict(ours: float, paper: float, friction: float) -> Verdict:
    if abs(ours - paper) <= NEAR * IDEAL:
        return "agree"
    return "depends" if math.isfinite(friction) else "disagree"


def _friction(friction: float, error: float | None, tables: Sequence[Table]) -> str:
    told = "no friction tried gives it"
    if math.isfinite(friction):
        told = f"friction {friction:.3f}{f' (error {error:.1g})' if error else ''} for all sliding pairs gives it"
    return f"{told}; one pair at a time in the table of sensitivity"


def _order(found: Mapping[str, Measurement]) -> Claim:
    """Judge which design gives more torque: at equal friction, and at the frictions that give the paper's torques."""
    pin, nonpin = found["pin"], found["nonpin"]
    ours = {name: one["output_torque"] for name, one in found.items()}
    error = max(one.quantities["output_torque"].error or 0.0 for one in found.values())
    needed = [one["friction_for_paper_simulated"] for one in (pin, nonpin)]
    more = ours["nonpin"] > ours["pin"] + error
    return Claim(
        "Fig. 19",
        "the nonpin design gives more output torque than the pin design",
        "35.8 to 34.7 N m simulated, 35.08 to 34.335 measured",
        f"{ours['nonpin']:.2f} to {ours['pin']:.2f} N m",
        f"{error:.1g} N m",
        "agree" if more else "depends" if all(map(math.isfinite, needed)) else "disagree",
        "friction of each design: at equal friction a free pin rolls and loses less than a fixed tooth",
        f"the paper's simulated torques take friction {needed[0]:.3f} with pins and {needed[1]:.3f} without",
        {f"output_torque_nm_{name}": value for name, value in ours.items()},
    )
