"""List dependencies without a wheel for a system and a Python version that the package claims to support.

    python scripts/wheels.py

asks the index that pip is configured for. Nothing is installed. Which packages a system needs is decided on this
one; those that only Windows needs are added by hand.
"""

import json
import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

SYSTEMS = {
    "Linux x86-64": [f"manylinux_2_{minor}_x86_64" for minor in (5, 12, 17, 24, 26, 27, 28, 31, 34)],
    "macOS arm64": ["macosx_14_0_arm64"],
    "Windows x86-64": ["win_amd64"],
}
VERSIONS = ("3.11", "3.12", "3.13", "3.14")
WINDOWS_ONLY = {"colorama", "filelock"}
"""Needed on Windows alone, by click and by this package."""

NO_WHEEL = re.compile(r"No matching distribution found for ([\w.-]+)")


def resolve(requirements: list[str], *options: str) -> tuple[set[str], str]:
    """Return the names of the packages that pip would install for requirements, and the message of an error."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder, "report.json")
        command = [sys.executable, "-m", "pip", "install", "--dry-run", "--quiet", "--ignore-installed"]
        command += ["--report", str(report), *options, "--target", folder, *requirements]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            return set(), done.stderr
        packages = json.loads(report.read_text(encoding="utf-8"))["install"]
        return {package["metadata"]["name"].lower() for package in packages}, ""


def without_wheel(names: set[str], version: str, tags: list[str]) -> list[str]:
    """Return the packages without a wheel for a Python version and one of the platform tags."""
    options = ["--no-deps", "--only-binary", ":all:", "--python-version", version]
    options += [word for tag in tags for word in ("--platform", tag)]
    missing: list[str] = []
    while True:
        _, error = resolve(sorted(names - {*missing}), *options)
        if not error:
            return missing
        found = NO_WHEEL.search(error)
        if found is None:
            sys.exit(error)
        missing.append(found[1].lower())


def main() -> None:
    """Print the missing wheels of the base install and of all extras, as a Markdown table."""
    project = tomllib.loads(Path(__file__).parents[1].joinpath("pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    wanted = project["dependencies"] + [
        need for name in extras if name not in ("docs", "test") for need in extras[name]
    ]
    names, error = resolve(wanted)
    if error:
        sys.exit(error)
    names |= WINDOWS_ONLY
    print(f"{len(names)} packages of the base install and of {len(extras) - 2} extras; without a wheel:\n")
    print(f"| system | {' | '.join(VERSIONS)} |\n|---{'|---' * len(VERSIONS)}|")
    for system, tags in SYSTEMS.items():
        cells = [", ".join(without_wheel(names, version, tags)) or "none" for version in VERSIONS]
        print(f"| {system} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
