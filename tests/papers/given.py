"""Runs that a test gives to the stages of the paper, in place of logs."""

from hsieh2014.stage import Runs
from ideal import ideal_run


class Given(Runs):
    """Runs by a function of their designs."""

    def __init__(self, give):
        super().__init__()
        self._give = give

    def __call__(self, designs, solver="mujoco"):
        return self._give(designs)


@Given
def ideal_runs(designs):
    """The pin design's gear is the rougher one under load, and the calmer one without."""
    loaded = [design.load.torque != 0.0 for design in designs]
    rough = [(design.ring.kind == "pin") == load for design, load in zip(designs, loaded, strict=True)]
    return [ideal_run(design, 0.004 if more else 0.001) for design, more in zip(designs, rough, strict=True)]
