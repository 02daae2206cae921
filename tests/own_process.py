"""Commands run in a process of their own, with an environment and code of its own."""

import os
import subprocess
import sys
from pathlib import Path

import cycloid_mj

RUN = ("simulate", "--design", "pin", "--ramp-s", "0", "--hold-s", "0.001", "--timestep-us", "5", "--json")


def ran(folder: Path, *argv: str, code: Path | None = None, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a command in a process of its own, whose code is, if given, in another place."""
    environment = {
        "PYTHONDONTWRITEBYTECODE": "1",
        "PYTHONPATH": str(code or Path(cycloid_mj.__file__).parents[1]),
        **environment,
    }
    kept = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    command = [sys.executable, "-m", "cycloid_mj", *argv]
    return subprocess.run(command, cwd=folder, env=kept | environment, capture_output=True, text=True)
