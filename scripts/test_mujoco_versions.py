"""Run the collider's tests against the oldest MuJoCo that pyproject.toml allows, the newest, and what comes next.

Each release gets a virtual environment of its own, with this project in it. What comes next is ``mujoco-core``: the
whole of MuJoCo's package from release 4 on, which may be a release ahead of ``mujoco``.

    python scripts/test_mujoco_versions.py
    python scripts/test_mujoco_versions.py --folder envs   # keeps the environments, to run again in less time
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path
from time import perf_counter

ROOT = Path(__file__).resolve().parents[1]
TESTS = [
    *(
        f"tests/dynamics/test_{name}.py"
        for name in ("contact", "selftest", "local_gap", "ring", "each_step", "simulate", "law")
    ),
    "tests/robot/test_robot.py",
]
HELPERS = ("-o", "pythonpath=scripts tests")
AHEAD = "mujoco-core"


def requirements() -> tuple[str, str]:
    """Return the oldest and the newest release of MuJoCo that pyproject.toml allows, as pip requirements."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    allowed = next(line for line in project["dependencies"] if re.match(r"mujoco\b", line))
    oldest = re.search(r">=\s*([\d.]+)", allowed)
    if oldest is None:
        sys.exit(f"pyproject.toml has no oldest release: {allowed}")
    version = oldest.group(1)
    return f"mujoco=={version}" + ".0" * (2 - version.count(".")), allowed


def ran(*command: str | Path, folder: Path = ROOT) -> subprocess.CompletedProcess[str]:
    """Run a command, with compile caches of this environment's own; return its output."""
    environment = {"NUMBA_CACHE_DIR": str(folder / "numba"), "MPLBACKEND": "agg"}
    return subprocess.run([*map(str, command)], cwd=ROOT, env=os.environ | environment, capture_output=True, text=True)


def install(environment: Path, requirement: str) -> str:
    """Create an environment with the project on a release of MuJoCo; return the release, or pip's last line."""
    python = str(environment / "bin" / "python")
    quiet = [python, *["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]]
    commands = [[sys.executable, "-m", "venv", str(environment)]]
    if requirement == AHEAD:
        commands += [
            [*quiet, str(ROOT), "pytest"],
            [python, *["-m", "pip", "uninstall", "--yes", "--quiet", "mujoco"]],
            [*quiet, "--no-deps", "--force-reinstall", AHEAD],
        ]
    else:
        commands += [[*quiet, str(ROOT), requirement, "pytest"]]
    for command in commands:
        done = ran(*command)
        if done.returncode:
            return f"not installable: {done.stderr.strip().splitlines()[-1]}"
    asked = ran(python, "-c", "import mujoco; print(mujoco.__version__)")
    return asked.stdout.strip() or f"not importable: {asked.stderr.strip().splitlines()[-1]}"


def run_tests(environment: Path) -> tuple[bool, str]:
    """Run the tests in an environment; return whether they pass, and pytest's account."""
    pytest = environment / "bin" / "pytest"
    done = ran(pytest, "-q", "-p", "no:cacheprovider", "--import-mode=importlib", *HELPERS, *TESTS, folder=environment)
    lines = done.stdout.strip().splitlines() or done.stderr.strip().splitlines()
    failed = [line.split(" - ")[0].removeprefix("FAILED ") for line in lines if line.startswith(("FAILED", "ERROR"))]
    return done.returncode == 0, "; ".join([lines[-1].strip("= "), *failed])


def main() -> int:
    """Test all releases of MuJoCo, and print a table; return 1 if an allowed release fails."""
    options = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    options.add_argument("--folder", type=Path, help="where to keep the environments; by default they are removed")
    kept: Path | None = options.parse_args().folder
    failures = 0
    seen: set[str] = set()
    with tempfile.TemporaryDirectory() as temporary:
        folder = (kept or Path(temporary)).absolute()
        print(f"{'asked for':24} {'MuJoCo':10} {'s':>5}  tests")
        for name, requirement in zip(("oldest", "newest", "ahead"), (*requirements(), AHEAD), strict=True):
            start = perf_counter()
            release = install(folder / name, requirement)
            if release in seen:
                status, passed = "as above", True
            elif release[0].isdigit():
                passed, status = run_tests(folder / name)
            else:
                passed, status, release = False, release, "-"
            seen.add(release)
            failures += not passed and name != "ahead"
            print(f"{requirement:24} {release:10} {perf_counter() - start:5.0f}  {status}", flush=True)
    return min(failures, 1)


if __name__ == "__main__":
    sys.exit(main())
