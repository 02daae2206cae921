"""Run all checks of a commit: formatting, lint, types, import contracts, tests.

python scripts/check.py                # all checks
python scripts/check.py --fast measure # the tests of one package only: those in tests/measure
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
LINTS = (("ruff", "format", "--check", "."), ("ruff", "check", "."))
BESIDE_TESTS = (("mypy",), ("lint-imports",))
"""Checks of one process each, which run next to the first tests; their output follows that of the tests."""


def tests(package: str | None) -> tuple[str, ...]:
    """Return the command that runs all tests, or those of one package; exit for an unknown package."""
    if package is None:
        return ("pytest", "-n", "2", "--dist", "worksteal")
    packages = sorted(path.name for path in (ROOT / "tests").iterdir() if any(path.glob("test_*.py")))
    if package not in packages:
        sys.exit(f"there is no package {package!r}: choose one of {', '.join(packages)}")
    return ("pytest", "-n", "2", f"tests/{package}")


def main() -> int:
    """Run all checks of the project; stop at the first format or lint error; return the first nonzero exit code."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    parser.add_argument("--fast", metavar="PACKAGE", help="run the tests of one package only")
    test_command = tests(parser.parse_args().fast)
    for lint in LINTS:
        if code := _finish(lint, _start(lint)):
            return code
    checks = [_start(check, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) for check in BESIDE_TESTS]
    codes = [_finish(test_command, _start(test_command))]
    codes += [_finish(check, process) for check, process in zip(BESIDE_TESTS, checks, strict=True)]
    return next((code for code in codes if code), 0)


def _start(command: tuple[str, ...], **options: Any) -> subprocess.Popen[str]:
    """Start a tool of this environment in the root of the repository; it may store bytecode.

    Without bytecode, each process that the tests start compiles the libraries again: up to 1 s of CPU.
    """
    print("$", *command, flush=True)
    name, *arguments = command
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    return subprocess.Popen([Path(sys.executable).parent / name, *arguments], cwd=ROOT, env=environment, **options)


def _finish(command: tuple[str, ...], process: subprocess.Popen[str]) -> int:
    """Wait for a command, print its output if it was captured, and return its exit code."""
    output, _ = process.communicate()
    if output:
        print(f"{command[0]}:\n{output}", flush=True)
    return process.returncode


if __name__ == "__main__":
    sys.exit(main())
