"""Common conditions of the measures that turn the crank: time step, speed, load and log rate of their runs."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from cycloid_mj.base.errors import DesignError
from cycloid_mj.dynamics.run import STEP_RULES, Solver
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.film import drag_torques, film_text


@dataclass(frozen=True)
class SteadySettings:
    """Settings of runs at constant crank speed, and of the averages over them."""

    log_rate: float = 20e3
    """Smallest log rate of the runs [Hz]."""
    drag_share: float = 0.01
    """Torque that keeps the flanks of an unloaded reducer in contact, relative to the rated one."""
    settling_time: float = 0.01
    """Time before the first evaluated sample of a driven crank [s]: rise of the load, and decay of its oscillation."""
    periods: int = 12
    quick_periods: int = 4
    """Smallest number of mesh periods of an average, and that of a quick measurement: a third of a crank turn or less.
    """
    period_tolerance: float = 0.1
    """Accepted deviation of an average from a whole number of periods of the output pins, in periods."""
    heavy_disc_share: float = 0.02
    """Weight of the discs relative to the load's force on their cams from which on losses vary over the crank turn, by
    1 %."""

    def min_periods(self, quick: bool) -> int:
        """Return the smallest number of mesh periods of an average."""
        return self.quick_periods if quick else self.periods


STEADY = SteadySettings()


def require_motion(reducer: Reducer) -> None:
    """Raise DesignError if the crank of a design does not turn.

    Raises
    ------
    DesignError
        ``drive.speed`` is 0.
    """
    if reducer.design.drive.speed == 0.0:
        raise DesignError(
            f"{reducer.design.name}: drive.speed_rpm is 0, but this measurement needs a crank that turns: set a speed "
            "other than 0, such as 1640 rpm"
        )


def drag_assumption(reducer: Reducer) -> str:
    """Return a phrase on the assumed drag torques of seals and lubricant on the shafts [N m], or "neglected"."""
    if reducer.design.has_film:
        crank_drag, output_drag = drag_torques(reducer)
        return (
            f"seals, and idle friction of the cams: {crank_drag:.3g} N m on the crank, {output_drag:.3g} N m on the "
            "output"
        )
    drag_texts = [
        f"drag.{shaft}_nm {torque:g} N m" if torque else f"drag.{shaft}_nm 0: neglected"
        for shaft, torque in (("crank", reducer.design.drag.crank), ("output", reducer.design.drag.output))
    ]
    return f"seals and lubricant: {', '.join(drag_texts)}"


def friction_assumption(reducer: Reducer, kinds: Iterable[str]) -> str:
    """Describe the friction of kinds of pairs: their coefficients, or the film law with lubricant and temperature."""
    if reducer.design.has_film:
        return film_text(reducer)
    return f"friction: {', '.join(f'{pair} {reducer.design.friction_of(pair):g}' for pair in kinds)}"


def halve_time_step(reducer: Reducer, solver: Solver) -> Reducer:
    """Return the design with half the time step that the solver would choose."""
    return reducer.but(settings={"timestep": 0.5 * STEP_RULES[solver].choose(reducer).seconds})


def load_cases(reducer: Reducer, load: float | None, drag: float | None = None) -> dict[str, float]:
    """Return the output torques [N m] of the conditions "unloaded" and "loaded".

    Parameters
    ----------
    reducer
        The drive.
    load
        Torque of the loaded condition [N m]; by default the rated torque.
    drag
        Torque of the unloaded condition [N m]; by default the rated torque times `SteadySettings.drag_share`.
    """
    rated_torque = reducer.design.rated_torque
    return {
        "unloaded": STEADY.drag_share * rated_torque if drag is None else drag,
        "loaded": rated_torque if load is None else load,
    }


def describe_loads(torques: Mapping[str, float]) -> str:
    """Format the output torques [N m] of several conditions, for the title of a measurement."""
    return " and ".join(f"{name} {torque:.3g} N m" for name, torque in torques.items())
