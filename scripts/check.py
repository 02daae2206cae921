"""Everything that must hold before a commit: formatting, lint, types, import contracts, tests."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
COMMANDS = (
    ("ruff", "format", "--check", "."),
    ("ruff", "check", "."),
    ("mypy",),
    ("lint-imports",),
    ("pytest", "-n", "2"),
)


def main() -> int:
    """Run every command, stopping at the first that fails; give its exit code."""
    tools = Path(sys.executable).parent
    for name, *arguments in COMMANDS:
        print("$", name, *arguments, flush=True)
        code = subprocess.run([tools / name, *arguments], cwd=ROOT, check=False).returncode
        if code:
            return code
    return 0


if __name__ == "__main__":
    sys.exit(main())
