"""Self-tests of the contact with one place of MuJoCo's structures spoiled, each in a process of its own.

What is read at a wrong place is chance: a process may end by a signal, which must not be that of the tests.
Run as a script with the name of a part; prints what came of each place, as JSON.
"""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from cycloid_mj.dynamics.contact import each_step, layout, reference_correction, selftest

CRASHED = "ended by a signal"


def spoiled_lifts() -> dict[str, Callable[[], str]]:
    """Trials of the lift, by the place that is spoiled."""
    steps = layout.find_step_layout()
    instead = {
        "nuserdata": steps.nuserdata + 4,
        "nuser_geom": steps.nuserdata,
        "ncon": steps.ncon + 4,
        "efc_aref": steps.efc_vel,
        "qacc": steps.userdata,
        "stride": steps.stride + 8,
        "dim": steps.efc_address,
        "efc_address": steps.dim,
        "friction": steps.mu,
        "mu": steps.mu + 8,
    }

    def trial(place: str) -> str:
        wrong = steps._replace(**{place: instead[place]})
        return selftest.try_correction(reference_correction.compile_control_callback(wrong).address)

    return {place: lambda place=place: trial(place) for place in instead}


def spoiled_steps() -> dict[str, Callable[[], str]]:
    """Trials of what a run keeps of its steps, by the place that is spoiled."""
    steps = layout.find_step_layout()
    instead = {"efc_force": steps.efc_vel, "stride": steps.stride + 8, "efc_address": steps.dim, "ncon": steps.ncon + 4}

    def trial(place: str) -> str:
        wrong = steps._replace(**{place: instead[place]})
        each_step.find_step_layout = lambda: wrong
        with each_step._installation.apply():
            return selftest.try_steps(each_step.add_sensor, each_step.EachStep)

    return {place: lambda place=place: trial(place) for place in instead}


PARTS = {"lift": spoiled_lifts, "steps": spoiled_steps}


def outcomes(part: str) -> dict[str, str]:
    """Run the trials of a part in a new interpreter; what is told of each place, ``CRASHED``, or nothing.

    Each place has code of its own, whose compilation takes most of the time; without optimization it takes less.
    """
    quick = os.environ | {"NUMBA_OPT": "0"}
    done = subprocess.run([sys.executable, __file__, part], capture_output=True, text=True, check=True, env=quick)
    told: dict[str, str] = json.loads(done.stdout)
    return told


def _forked(trial: Callable[[], str]) -> str:
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        os.write(writing, trial().encode())
        os._exit(0)
    os.close(writing)
    told = Path(f"/dev/fd/{reading}").read_text()
    _, status = os.waitpid(child, 0)
    return CRASHED if os.WIFSIGNALED(status) else told


if __name__ == "__main__":
    sys.stdout.write(json.dumps({place: _forked(trial) for place, trial in PARTS[sys.argv[1]]().items()}))
