"""Answer from runs of ``cycloid-mj compare`` to the paper's question whether the pin design fluctuates more."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from cycloid_mj.base.result import to_json_values
from cycloid_mj.comparison import Trial, Variation
from cycloid_mj.papers import RunsJudged
from hsieh2014.decisions import Varied, decisions
from hsieh2014.ranking import Ranking, rankings, summary

SOURCE = "Hsieh 2014, Figs 6-8"


def judged_runs(trials: Sequence[Trial], varied: Mapping[Variation, Sequence[Trial]]) -> RunsJudged:
    """Rank every pin design against every nonpin design by their runs, also with single parameters varied."""
    ranked = rankings(trials)
    sweep = [Varied(each.parameter, each.value, tuple(rankings(runs))) for each, runs in varied.items()]
    decided, concluded = decisions(ranked, sweep), summary(ranked)
    content = {
        "rankings": [_json(each) for each in ranked],
        "summary": concluded,
        "sweep": [{**vars(point), "rankings": [_json(each) for each in point.rankings]} for point in sweep],
        "decisions": decided,
    }
    if not ranked:
        words = "the paper's findings on vibration set a pin against a nonpin design: not judged here"
        return RunsJudged(notes=[words], content=content)
    return RunsJudged(
        concluded,
        [
            f"the paper ({SOURCE}) finds that the pin design fluctuates more; these runs are judged "
            f"{' and '.join(_bases(trials))}, path and velocity of q without steady shifts:",
            *(each.sentence for each in ranked),
            *(f"what decides, by the ratio of the rms values: {sentence}" for sentence in decided),
        ],
        dict(to_json_values(content)),
        {"compare_sweep": partial(_sweep_figure, trials, ranked, sweep)} if sweep else {},
    )


def _bases(trials: Sequence[Trial]) -> list[str]:
    """Return in words by what runs without load and under load are judged."""
    loads = {trial.load for trial in trials}
    idle = ["at no load by their independent starts"] if 0.0 in loads else []
    return idle + (["under load by their crank turns"] if any(loads) else [])


def _json(ranking: Ranking) -> dict[str, Any]:
    derived = ("ratio", "verdict", "sentence", "starts")
    return to_json_values(ranking) | {key: getattr(ranking, key) for key in derived}


def _sweep_figure(trials: Sequence[Trial], ranked: Sequence[Ranking], sweep: Sequence[Varied]) -> Any:
    from hsieh2014.ratios_figure import ratios_figure

    conditions = {trial.load: str(trial.measures.findings.condition) for trial in trials}
    return ratios_figure(conditions, ranked, sweep)
