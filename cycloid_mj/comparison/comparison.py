"""Comparison of two or more designs: the measures of each under each load."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from cycloid_mj.analysis import Series
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.frame import Frame
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.result import Table, load_words, to_json_values
from cycloid_mj.comparison.conditions import HOLD, conditions, differences
from cycloid_mj.comparison.sensitivity import Sensitivity, sensitivity_table
from cycloid_mj.comparison.table import ROWS, figure_frame, table
from cycloid_mj.comparison.trial import Trial
from cycloid_mj.design import Design
from cycloid_mj.dynamics.massless import require_pin_bodies
from cycloid_mj.reducer import Reducer, reducer_of


@dataclass(frozen=True, repr=False)
class Comparison(Presented):
    """Comparison of designs.

    Attributes
    ----------
    designs
        Names, in the order of the call.
    conditions
        Settings that all runs share, by keys of the design file; the duration, `HOLD`, is that of the largest load.
    differences
        Values that differ between the designs: key -> the value of each.
    trials
        The runs by load, each in the order of the designs; those at no load with their independent starts.
    solver
        Solver of all runs.
    sensitivity
        Changes of the dynamic figures of the loaded runs with assumptions of the contact model.
    motions
        For figures: the first run of each trial, next to its closed form; empty if it is not kept.
    """

    designs: tuple[str, ...]
    conditions: dict[str, Any]
    differences: dict[str, tuple[Any, ...]]
    trials: tuple[Trial, ...]
    solver: str
    sensitivity: tuple[Sensitivity, ...] = ()
    motions: tuple[Series, ...] = field(default=(), compare=False)

    @property
    def frame(self) -> Frame:
        """Mean, smallest and largest value of each quantity over the starts, one row per design, load and quantity."""
        return figure_frame(self.trials)

    @property
    def line(self) -> str:
        """Designs, loads and solver."""
        loads = ", ".join(load_words(load) for load in self.loads)
        return f"{' / '.join(self.designs)}; {loads}; {SOLVERS[self.solver]}"

    @property
    def loads(self) -> tuple[float, ...]:
        """Load torques [N m], in ascending order."""
        return tuple(sorted({trial.load for trial in self.trials}))

    def at(self, load: float) -> tuple[Trial, ...]:
        """Return the trials (simulations and their results) under a load [N m]."""
        return tuple(trial for trial in self.trials if trial.load == load)

    @property
    def tables(self) -> tuple[Table, ...]:
        """The quantities under each load, and the sensitivity of dynamic quantities, if it was computed."""
        tables = [table(self.at(load)) for load in self.loads]
        if self.sensitivity:
            tables.append(sensitivity_table(self.sensitivity, str(self.trials[-1].measures.findings.condition)))
        return tuple(tables)

    def as_json(self) -> dict[str, Any]:
        """Convert the comparison of simulated designs to JSON values; the keys are the names of the attributes.

        ``runs`` are the `trials`: each has the measures of the first of several independent runs (starts) of a design
        under a load, and the spreads over all of them. ``sensitivity`` has the changes of the quantities with assumed
        values, such as damping.
        """
        content = {
            "designs": self.designs,
            "solver": self.solver,
            "conditions": self.conditions,
            "differences": self.differences,
            "runs": [_run_json(trial) for trial in self.trials],
            "sensitivity": [
                to_json_values(sensitivity) | {"changes": sensitivity.changes, "determined": sensitivity.is_determined}
                for sensitivity in self.sensitivity
            ],
        }
        return dict(to_json_values(content))


def compare(trials: Sequence[Trial], sensitivity: Sequence[Sensitivity] = ()) -> Comparison:
    """Combine the simulations of two or more designs under the same loads into a comparison.

    Parameters
    ----------
    trials
        Exactly one trial (simulations and their results) of each design under each load, in any order. Solver and
        settings are the same for all; only the duration may depend on the load.
    sensitivity
        How the dynamic quantities of each design change with an assumption of the simulation, such as the damping;
        empty if this is not computed.

    Returns
    -------
    Comparison
        The trials in ascending order of load, the designs in the order of their first trial.

    Raises
    ------
    UsageError
        There are fewer than two designs, two designs of one name, a missing or repeated run, or different settings or
        solvers.
    DesignError
        A design has massless pins.
    """
    designs = comparable([trial.design for trial in trials])
    loads = sorted({trial.load for trial in trials})
    ordered_trials = tuple(
        next(trial for trial in trials if (trial.name, trial.load) == (name, load))
        for load in loads
        for name in designs
    )
    return Comparison(
        designs=tuple(designs),
        conditions=conditions(reducer_of(ordered_trials[-1].design)),
        differences=differences(list(designs.values())),
        trials=ordered_trials,
        solver=_same_solver(ordered_trials),
        sensitivity=tuple(sensitivity),
    )


def comparable(cases: Sequence[Design]) -> dict[str, Design]:
    """Check that the designs in `cases`, each under a load, can be compared; return name -> its first design.

    Raises
    ------
    UsageError
        A name stands for several designs, there are fewer than two names, not every design occurs exactly once under
        each load, or the cases differ in a setting that compared designs must share (`conditions`).
    DesignError
        A design has massless pins.
    """
    design_by_name: dict[str, Design] = {}
    for case in cases:
        require_pin_bodies(reducer_of(case), "the idle and dynamic figures of a comparison")
        # a name identifies one design, with any load and duration
        first_case = design_by_name.setdefault(case.name, case)
        if differing_keys := [key for key in differences([first_case, case]) if key != HOLD]:
            raise UsageError(
                f"two designs are named {case.name!r}, but differ in {', '.join(differing_keys[:3])}: change `name` in "
                "one of the design files"
            )
    if len(design_by_name) < 2:
        raise UsageError(
            "a comparison needs at least two designs, but the designs given are: "
            f"{', '.join(design_by_name) or 'none'}. Add another design"
        )
    _require_every_case(cases, list(design_by_name))
    _require_same_conditions(cases)
    return design_by_name


def _require_every_case(cases: Sequence[Design], design_names: Sequence[str]) -> None:
    """Raise UsageError unless each design, by its name, has exactly one run under each load.

    `cases` are the designs under the loads of the runs, `design_names` those of the designs.
    """
    names_and_loads = [(case.name, case.load.torque) for case in cases]
    for name in design_names:
        for load in sorted({load for _, load in names_and_loads}):
            run_count = names_and_loads.count((name, load))
            if run_count != 1:
                problem = "is missing" if run_count == 0 else f"is given {run_count} times"
                raise UsageError(
                    f"the run of {name} at {load_words(load)} {problem}, but a comparison needs exactly one run of "
                    f"each design under each load: {'add that run' if run_count == 0 else 'remove the repeated runs'}"
                )


def _require_same_conditions(cases: Sequence[Design]) -> None:
    """Raise UsageError for runs under different settings; idle and loaded runs may differ in duration."""
    for case in cases:
        first_case = next(other_case for other_case in cases if other_case.load.torque == case.load.torque)
        _require_equal_settings(reducer_of(first_case), reducer_of(case), ())
        _require_equal_settings(reducer_of(cases[0]), reducer_of(case), (HOLD,))


def _same_solver(trials: Sequence[Trial]) -> str:
    """Return the solver of all runs; raise UsageError where there are two."""
    by_solver = {trial.measures.findings.solver: trial for trial in trials}
    if len(by_solver) > 1:
        runs = " and ".join(f"{trial.name} {SOLVERS[solver]}" for solver, trial in by_solver.items())
        raise UsageError(f"the runs used different solvers: {runs}. Simulate all of them with the same --solver")
    return next(iter(by_solver))


def _require_equal_settings(reference: Reducer, case: Reducer, exempt_keys: Sequence[str]) -> None:
    """Raise UsageError if a design under a load, `case`, differs from `reference` in a setting that is not exempt.

    `exempt_keys` are the keys of settings that may differ.
    """
    expected, actual = conditions(reference), conditions(case)
    for key in expected | actual:
        if actual.get(key) != expected.get(key) and key not in exempt_keys:
            raise UsageError(
                f"the runs have different settings: {key} is {expected.get(key)} for {reference.design.name} at "
                f"{load_words(reference.design.load.torque)}, but {actual.get(key)} for {case.design.name} at "
                f"{load_words(case.design.load.torque)}. Simulate them again with identical settings"
            )


def _run_json(trial: Trial) -> dict[str, Any]:
    """Convert the runs of a design under a load, a `trial`, to JSON values: measures, and spreads over all starts.

    A start is a run of the same design with gravity in another direction. The measures are those of the first start;
    ``starts`` is the number of starts, and ``start_logs`` are the names of their logs. ``spreads`` are included only
    for runs without load, and only for quantities that have a value.
    """
    spreads = [
        {"quantity": quantity, "unit": unit, **spread.as_json()}
        for quantity, unit, read_measure in ROWS
        if trial.load == 0.0 and (spread := trial.over_starts(read_measure)) is not None
    ]
    return {
        "design": trial.name,
        "load_nm": trial.load,
        **to_json_values(trial.measures),
        "starts": len(trial.starts),
        "start_logs": [measures.findings.log for measures in trial.starts],
        "spreads": spreads,
    }
