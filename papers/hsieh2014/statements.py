"""All judged claims of the paper: key, figure, condition, text and number."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from cycloid_mj.base.result import Claim, Condition, Range, Removal, Value, Verdict
from hsieh2014.plan import no_load, torque_test
from hsieh2014.stated import FIGURES, FLUCTUATIONS, GEAR_SPEED, HEIGHTS, IDEAL, ORDER, TORQUES

BY_DESIGN = "nonpin / pin"
AHEAD = "N m, nonpin - pin"
"""Units of comparisons of the designs."""
PARTS = {"output_acceleration": "output"}
"""Part of a ranked quantity, if it is not the gear."""


@dataclass(frozen=True)
class Statement:
    """A statement of the paper; fields as in `Claim`."""

    key: str
    figure: str
    part: str
    design: str
    kind: str
    claim: str
    stated: Value
    condition: Condition

    def judge(
        self,
        ours: Value,
        error: Value,
        verdict: Verdict,
        decided_by: str,
        rated: Value | None = None,
        searched: Sequence[Range] = (),
        removals: Iterable[Removal] = (),
        p: float | None = None,
    ) -> Claim:
        """Return the claim with the model's result and the verdict; parameters as in `Claim`.

        A result without p and starts, such as a single run under load, gets its numerical error as spread.
        """
        if p is None and ours.spread is None and ours.value is not None and error.value is not None:
            ours = replace(ours, spread=(ours.value - error.value, ours.value + error.value))
        return Claim(
            **vars(self),
            ours=ours,
            error=error,
            verdict=verdict,
            decided_by=decided_by,
            rated=rated,
            searched=tuple(searched),
            removals=tuple(removals),
            p=p,
        )


def _idle(key: str, figure: str, part: str, design: str, kind: str, claim: str, stated: Value) -> Statement:
    return Statement(key, figure, part, design, kind, claim, stated, no_load())


def gear_speed(design: str) -> Statement:
    """Return the statement of Eq. 12 and Fig. 6 on the mean speed of the gear."""
    claim, value = (
        "the disc turns at 1/35 of the crank speed, in the opposite direction",
        Value("4.907 rad/s", GEAR_SPEED, "rad/s"),
    )
    return _idle(f"gear_speed_mean_{design}", "Eq. 12, Fig. 6", "gear", design, "value", claim, value)


def pin_1_sway(clearance: float) -> Statement:
    """Return the statement of Fig. 9 that pin 1 moves within a clearance [m]."""
    value = Value("within 0.001 mm", 1e3 * clearance, "mm")
    return _idle("pin_1_sway", "Fig. 9", "pin_1", "pin", "height", "pin 1 moves within its clearance", value)


def _pin_1(key: str, figure: str, claim: str, stated: str) -> Statement:
    return _idle(key, figure, "pin_1", "pin", "pattern", claim, Value(stated))


SEEN = "the angle of pin 1 differs visibly at crank angles of 0, 120, 240 and 360 deg"
CYCLE = "pin 1 carries load from 350 to 10 deg, and no load from 10 to 350 deg"
PIN_1_TURNS = _pin_1("pin_1_turns", "Fig. 9(a)", SEEN, "rotated")
PIN_1_SLIDES = _pin_1("pin_1_slides", "Fig. 16", "pin 1 slides on the disc from 10 to 350 deg", "slides")
PIN_1_SPIN = _pin_1("pin_1_spin", "Fig. 9", "pin 1 rotates about its axis", "yes")
PIN_1_CYCLE = _pin_1("stress_cycle_pin_1", FIGURES["pin_1"], CYCLE, "350 to 10 deg")


def transmission_error(design: str) -> Statement:
    """Return the statement of Fig. 7 that the path of q deviates from its closed form by the transmission error."""
    claim = "the disc has a transmission error: q deviates from its ideal path"
    return _idle(f"transmission_error_{design}", "Fig. 7", "gear", design, "pattern", claim, Value("yes"))


def _rated_statement(key: str, figure: str, claim: str) -> Statement:
    return Statement(key, figure, "gear", "both", "order", claim, Value("nonpin better"), torque_test())


PRECISION = _rated_statement("double_contact_precision", "section 2", "double contact lines increase the precision")
CAPACITY = _rated_statement("double_contact_capacity", "section 2", "double contact lines increase the load capacity")

STEEL = Value("E = 210 000, G = 79 000 N/mm2, so ratio 0.329", 210e3 / (2.0 * 79e3) - 1.0, "1")
OF_STEEL = "E and G of the steel, which imply a Poisson's ratio"
POISSON = _idle("poisson", "Table 1", "all", "both", "value", OF_STEEL, STEEL)


def fluctuation(key: str, name: str) -> Statement:
    """Return the statement, of Figs 6-8 or the text on vibration, that pin fluctuates more in a quantity."""
    figure, part = FLUCTUATIONS.get(name, "vibration"), PARTS.get(key, "gear")
    claim = f"{name} fluctuates more with pins than without"
    return _idle(key, figure, part, "both", "order", claim, Value("pin > nonpin"))


def stress_height(part: str, design: str) -> Statement:
    """Return the statement of Figs 12-14 on the maximum of a part's curve."""
    height = HEIGHTS[part, design]
    claim, value = (
        f"the stress of the {'disc' if part == 'gear' else part} reaches about {height:g} MPa",
        Value(f"{height:g} MPa", height, "MPa"),
    )
    return _idle(f"stress_height_{part}_{design}", FIGURES[part], part, design, "height", claim, value)


def stress_of_parts(design: str) -> Statement:
    """Return the statement of Figs 12-14 on the order of the parts by stress."""
    value = Value(" > ".join(f"{HEIGHTS[part, design]:g}" for part in ORDER) + " MPa")
    return _idle(f"stress_order_of_parts_{design}", "Figs 12-14", "all", design, "order", " > ".join(ORDER), value)


def stress_of_designs(part: str) -> Statement:
    """Return the statement of Figs 12-14 on the design in which a part is stressed more."""
    ratio = HEIGHTS[part, "nonpin"] / HEIGHTS[part, "pin"]
    claim, value = (
        f"{part}: less stress without pins than with them",
        Value(f"{ratio:.2g} to 1", ratio, BY_DESIGN),
    )
    return _idle(f"stress_order_of_designs_{part}", FIGURES[part], part, "both", "order", claim, value)


def stress_mean(part: str) -> Statement:
    """Return the statement of Figs 12-14 on the design in which a part's mean stress over a turn is smaller."""
    claim = f"{part}: a smaller mean stress without pins"
    return _idle(f"stress_mean_{part}", FIGURES[part], part, "both", "order", claim, Value("pin > nonpin"))


def stress_fluctuation(part: str) -> Statement:
    """Return the statement of Figs 12-14 on the design in which a part's stress fluctuates less over a turn."""
    claim = f"{part}: its stress fluctuates less without pins"
    return _idle(f"stress_fluctuation_{part}", FIGURES[part], part, "both", "order", claim, Value("pin > nonpin"))


def stress_peaks(design: str) -> Statement:
    """Return the statement of Fig. 12 on the angles at which the shaft's stress peaks."""
    claim, value = "two peaks a turn, near 75 and 255 deg, the highest at 74 deg", Value("75, 255 deg", 74.0, "deg")
    return _idle(f"stress_peaks_shaft_{design}", FIGURES["shaft"], "shaft", design, "pattern", claim, value)


def stress_of_output(design: str) -> Statement:
    """Return the statement of Fig. 15 on the output's stress."""
    claim, value = "the output's stress is low and regular", Value("low, regular")
    return _idle(f"stress_output_{design}", FIGURES["output"], "output", design, "pattern", claim, value)


def output_torque(kind: str, design: str) -> Statement:
    """Return the statement of section 3.4 and Fig. 19 on the output torque, simulated or measured."""
    torque, figure = TORQUES[design][kind], "Fig. 19" if kind == "measured" else "section 3.4"
    claim = f"output torque at an input torque of 1.048 N m, {kind}"
    value = Value(f"{torque:g} N m, {100 * torque / IDEAL:.1f} %", torque, "N m")
    return Statement(f"output_torque_{kind}_{design}", figure, "output", design, "value", claim, value, torque_test())


BOTH_TORQUES = "nonpin 35.8, pin 34.7 N m simulated; nonpin 35.08, pin 34.335 N m measured"
MORE_TORQUE = "the output torque of nonpin is larger than that of pin"
GAIN = Value(BOTH_TORQUES, TORQUES["nonpin"]["simulated"] - TORQUES["pin"]["simulated"], AHEAD)
TORQUE_ORDER = Statement("output_torque_order", "Fig. 19", "output", "both", "order", MORE_TORQUE, GAIN, torque_test())
