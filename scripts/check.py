"""Everything that must hold before a commit: formatting, lint, types, import contracts, tests.

python scripts/check.py                # all of it
python scripts/check.py --fast measure # the tests of one room alone: those in tests/measure
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
    """List the command that runs all tests, or those of a room; exit for an unknown room."""
    if room is None:
        return ("pytest", "-n", "2", "--dist", "worksteal")
    rooms = sorted(path.name for path in (ROOT / "tests").iterdir() if any(path.glob("test_*.py")))
    if room not in rooms:
        sys.exit(f"no room {room!r}: choose of {', '.join(rooms)}")
    return ("pytest", "-n", "2", f"tests/{room}")


def main() -> int:
    """Run every command, stopping at the first that fails; return its exit code."""
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
