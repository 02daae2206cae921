"""Everything that must hold before a commit: formatting, lint, types, import contracts, tests.

python scripts/check.py                # all of it
python scripts/check.py --fast measure # the tests of one room alone: those in tests/test_measure*.py
"""

import argparse
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
LINTS = (
    ("ruff", "format", "--check", "."),
    ("ruff", "check", "."),
    ("mypy",),
    ("lint-imports",),
)


def tests(room: str | None) -> tuple[str, ...]:
    """Give the command that runs all tests, or those of a room.

    Raises
    ------
    SystemExit
        No test file is named after the room.
    """
    if room is None:
        return ("pytest", "-n", "2", "--dist", "worksteal")
    files = sorted((ROOT / "tests").glob(f"test_{room}*.py"))
    if not files:
        rooms = sorted({path.stem.removeprefix("test_").split("_")[0] for path in (ROOT / "tests").glob("test_*.py")})
        sys.exit(f"no tests/test_{room}*.py: choose of {', '.join(rooms)}")
    return ("pytest", "-n", "2", *(str(path.relative_to(ROOT)) for path in files))


def main() -> int:
    """Run every command, stopping at the first that fails; give its exit code."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    parser.add_argument("--fast", metavar="ROOM", help="run the tests of one room alone")
    tools = Path(sys.executable).parent
    for name, *arguments in (*LINTS, tests(parser.parse_args().fast)):
        print("$", name, *arguments, flush=True)
        code = subprocess.run([tools / name, *arguments], cwd=ROOT, check=False).returncode
        if code:
            return code
    return 0


if __name__ == "__main__":
    sys.exit(main())
