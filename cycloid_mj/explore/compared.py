"""Comparison of designs by simulation: the runs that it needs, and all of them in memory."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from cycloid_mj.analysis import Series
from cycloid_mj.base.comparison_runs import DEFAULTS, IDLE_TURNS, QUICK_STARTS, TURNS
from cycloid_mj.base.engine import Engine, Progress, silent
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.comparison import (
    ASSUMPTIONS,
    STARTS,
    Comparison,
    Measures,
    Trial,
    Variation,
    apply_conditions,
    comparable,
    conditions,
    independent_starts,
    measure_run,
    sensitivities,
    settle_run,
    settling_time,
    with_play_of,
)
from cycloid_mj.comparison import compare as compare_trials
from cycloid_mj.design import Design, Named, override, resolve
from cycloid_mj.dynamics.planar.timestep import acceleration_timestep
from cycloid_mj.dynamics.run import Solver, model_for, simulate
from cycloid_mj.reducer import Reducer, reducer_of

PIN_AND_NONPIN = {("central", "pin"), ("central", "nonpin")}
"""Layout and kind of ring of two designs that a third design separates, see `list_cases`."""

UNCHANGED = Variation("", "unchanged", ())


@dataclass(frozen=True)
class RunPlan:
    """Runs of a comparison.

    Attributes
    ----------
    starts
        Each design under each load -> its independent starts.
    variations, assumptions
        Variations of all cases, and of the loaded cases only.
    names
        Every design that is simulated, and the name of its run.
    solver
        Solver of all runs.
    """

    starts: Mapping[Design, Sequence[Design]]
    variations: Sequence[Variation]
    assumptions: Sequence[Variation]
    names: Mapping[Design, str]
    solver: Solver

    @property
    def loaded_designs(self) -> list[Design]:
        """Designs under a load."""
        return [design for design in self.starts if design.load.torque]

    def collect_trials(
        self, measures_by_design: Mapping[Design, Measures], designs: Sequence[Design], variation: Variation = UNCHANGED
    ) -> list[Trial]:
        """Return a `Trial` for each of `designs`: the design with a changed parameter and the measures of all its runs.

        The runs of a design start from several initial states. Each is represented in `self.starts` by a copy of the
        design with gravity in another direction, the first by the design itself. `variation` is the change of a
        parameter of all copies. `measures_by_design` has the measured quantities of each run, by the changed copy.
        """
        copies_by_design = (
            [variation.of(reducer_of(design_copy)) for design_copy in self.starts[design]] for design in designs
        )
        return [
            Trial(
                first_copy, measures_by_design[first_copy], tuple(measures_by_design[other] for other in other_copies)
            )
            for first_copy, *other_copies in copies_by_design
        ]

    def compare(self, measures_by_design: Mapping[Design, Measures], motions: Mapping[Design, Series]) -> Comparison:
        """Compare the designs by the quantities measured in all runs, and compute their changes with assumed values.

        `measures_by_design` has the measured quantities of every simulated design. `motions` has the logged motion of
        the first run of each design under each load, by that design.
        """
        changes = sensitivities(
            self.collect_trials(measures_by_design, self.loaded_designs),
            {
                assumption: self.collect_trials(measures_by_design, self.loaded_designs, assumption)
                for assumption in self.assumptions
            },
        )
        comparison = compare_trials(
            self.collect_trials(measures_by_design, list(self.starts)), changes if self.assumptions else ()
        )
        return replace(comparison, motions=tuple(motions[trial.design] for trial in comparison.trials))


@shows_progress
def compare(
    *designs: Named,
    load_nm: float | None = None,
    quick: bool = False,
    solver: Solver = "planar",
    progress: Progress = silent,
) -> Comparison:
    """Compare two or more designs by simulations without load and under load.

    All runs have the speed, environment and settings of the first design. Without load the motion is chaotic, so that
    each design runs from several starts. ``cm.compare("pin", "nonpin").plot()`` draws a crank turn of each run.

    Parameters
    ----------
    designs
        Two or more designs, or names of presets or files.
    load_nm
        Load torque of the loaded runs [N m]; 0 for unloaded runs only. Default: the rated torque of the first design.
    quick
        Whether to run two starts only, and to omit the sensitivity to assumed values of the contact model.
    solver
        Solver of all runs.
    progress
        Called with the numbers of finished and of all runs.

    Returns
    -------
    Comparison
        Measured quantities of each design under each load: `frame`, `tables`, and diagrams of the runs by `plot`.

    Raises
    ------
    UsageError
        There are fewer than two designs, or two designs have one name.
    DesignError
        A design is invalid, or has massless pins.
    RunError
        A run failed.
    """
    if len(designs) < 2:
        raise UsageError(
            f"a comparison needs at least two designs, but the number of designs is {len(designs)}: add another design"
        )
    resolved_designs = [resolve(design) for design in designs]
    cases = list_cases(resolved_designs, override(resolved_designs[0], DEFAULTS), load_nm, solver)
    plan = plan_runs(cases, solver, QUICK_STARTS if quick else STARTS, assumptions=() if quick else ASSUMPTIONS)
    runs = list(plan.names)

    def measure_design(design: Design) -> tuple[Measures, Series | None]:
        motion = settle_run(simulate(design, model_for(solver, reducer_of(design))))
        return measure_run(motion), motion if design in plan.starts else None

    results = dict(zip(runs, Engine(kind="threads").each(measure_design, runs, progress), strict=True))
    return plan.compare(
        {design: measures for design, (measures, _) in results.items()},
        {design: motion for design, (_, motion) in results.items() if motion is not None},
    )


def list_cases(
    designs: Sequence[Design], first_design: Design, load_nm: float | None, solver: Solver, fixed_hold: bool = False
) -> list[Design]:
    """Return every design under the operating conditions of `first_design`, once without load and once under load.

    If a pin and a nonpin design are compared, the list also has the nonpin design with the total play and series
    stiffness of the pin design at that load. This third design separates the effect of the kind of ring from that of
    the clearance.

    Parameters
    ----------
    designs, first_design
        The designs, and the design whose speed, environment and settings apply to all.
    load_nm
        Load torque [N m]; by default the rated torque of `first_design`.
    solver
        Solver of the runs.
    fixed_hold
        Whether all runs have the hold time (``drive.hold_s``, at constant speed) of `first_design`. Otherwise the hold
        time is set so that a whole number of crank turns follows after settling.

    Returns
    -------
    list
        All designs without load, then all designs under load. With the planar solver, all get the shortest time step
        that one of them requires, unless `first_design` sets the time step.

    Raises
    ------
    UsageError
        There are fewer than two designs, or two designs have one name.
    """
    common_conditions = conditions(reducer_of(first_design))
    rated_torque = round(first_design.rated_torque, 9) if load_nm is None else load_nm
    compared_designs = list(designs)
    if {(design.layout, design.ring.kind) for design in designs} == PIN_AND_NONPIN and len(designs) == 2:
        pin, nonpin = sorted(designs, key=lambda design: design.ring.kind, reverse=True)
        compared_designs.append(
            with_play_of(Reducer(nonpin), Reducer(apply_conditions(Reducer(pin), common_conditions, rated_torque)))
        )
    cases_by_load = [
        [apply_conditions(reducer_of(design), common_conditions, load) for design in compared_designs]
        for load in dict.fromkeys((0.0, rated_torque))
    ]
    cases = [case for group in cases_by_load for case in (group if fixed_hold else _with_settled_turns(group))]
    if solver == "planar" and not first_design.settings.timestep:
        timestep = min(acceleration_timestep(reducer_of(case)) for case in cases)
        cases = [reducer_of(case).but(settings={"timestep": timestep}).design for case in cases]
    comparable(cases)
    return cases


def plan_runs(
    cases: Sequence[Design],
    solver: Solver,
    starts: int = STARTS,
    variations: Sequence[Variation] = (),
    assumptions: Sequence[Variation] = ASSUMPTIONS,
) -> RunPlan:
    """Plan the runs of a comparison: every case from several initial states, and again with each parameter variation.

    An initial state is represented by a copy of the design with rotated gravity (`start_variant`).

    Parameters
    ----------
    cases
        Designs under their loads, from `list_cases`.
    solver
        Solver of the runs.
    starts
        Number of different initial states of each case without load; a loaded case has one.
    variations
        Parameter variations of all cases.
    assumptions
        Variations of assumed values of the contact model, of the loaded cases only.
    """
    copies_by_case = {
        design: (design,) if design.load.torque else independent_starts(reducer_of(design), starts) for design in cases
    }
    loaded_cases = [design for design in cases if design.load.torque]
    run_names = {
        design_copy: name_run(design_copy, copy_index)
        for design_copies in copies_by_case.values()
        for copy_index, design_copy in enumerate(design_copies)
    }
    for variation, designs in [
        *((variation, cases) for variation in variations),
        *((variation, loaded_cases) for variation in assumptions),
    ]:
        for design in designs:
            suffix = f"{variation.parameter}-{variation.value}".replace(" ", "-").replace("/", "-per-")
            for copy_index, design_copy in enumerate(copies_by_case[design]):
                varied_design = variation.of(reducer_of(design_copy))
                run_names.setdefault(varied_design, f"{name_run(design_copy, copy_index)}-{suffix}")
    return RunPlan(copies_by_case, variations, assumptions, run_names, solver)


def name_run(design: Design, start: int = 0) -> str:
    """Return the name of a run from design, load and number of the start, for its log."""
    load = design.load.torque
    case = f"{design.name}-{f'{load:g}Nm' if load else 'no-load'}"
    return f"{case}-start-{start + 1}" if start else case


def _with_settled_turns(designs: Sequence[Design]) -> list[Design]:
    """Return the designs with equal run times: the longest of their settling times, plus a number of crank turns.

    There are `TURNS` turns under a load, `IDLE_TURNS` without. All designs have the same load. They are returned
    unchanged if the crank of one of them does not turn.
    """
    if any(design.drive.speed == 0.0 for design in designs):
        return list(designs)
    turn_count = TURNS if designs[0].load.torque else IDLE_TURNS
    longest_settling = max(settling_time(reducer_of(design)) for design in designs)
    # one more sample, so that the last turn is complete
    steady_designs = [
        reducer_of(design).steady(longest_settling, turn_count, samples=1.0, drive={"ramp": design.drive.ramp}).design
        for design in designs
    ]
    # a crank turn of RV reducers takes a different time at the same speed of the sun
    hold_time = max(design.drive.hold for design in steady_designs)
    return [design.but(drive={"hold": hold_time}) for design in steady_designs]
