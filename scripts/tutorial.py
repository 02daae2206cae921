"""Write into the tutorial what its commands print and draw.

python scripts/tutorial.py          # docs/tutorial.md and the pictures in docs/tutorial, with Chromium

The commands run in their order in an empty folder. What one prints stands behind it in the page, in a block that
follows `MARK`; what stood there before is replaced. `scripts/docs_figures.py` calls this when it is stale.
"""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from picture import keep_small, screenshot

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "tutorial.md"
PICTURES = ROOT / "docs" / "tutorial"

MARK = "<!-- printed by scripts/tutorial.py -->"
"""Ahead of a block of what a command printed; it does not show on the page."""

WIDTH = 110
"""Columns of the terminal."""

TIMED = re.compile(r", \d+ steps in \S+ s of wall time$")
"""End of a line that differs from run to run."""

BLOCK = re.compile(
    rf"^(?P<code>```(?:sh|console)\n(?P<lines>.*?)^```\n)(?:\n{re.escape(MARK)}\n```text\n.*?^```\n)?",
    flags=re.DOTALL | re.MULTILINE,
)
"""Code, with the block of what it printed."""

SHOWN = {
    "runs/drive-review.html": ("review.png", 1180, 1100),
    "made/drive-tolerance.html": ("tolerance.png", 1180, 900),
    "joint/reducer.html": ("joint.png", 1180, 900),
}
"""Pages that the commands write, and the pictures that are taken of their tops: name, width and height [px]."""

MADE = {"parts/exploded.png": "exploded.png"}
"""Pictures that the commands write, and their names next to the page."""


def commands(lines: str) -> list[str]:
    """List the commands of this package in a block of code, without prompts and comments."""
    bare = (line.removeprefix("$ ").split("  #")[0].strip() for line in lines.splitlines())
    return [line for line in bare if line.startswith("cycloid-mj ")]


def run_command(command: str, folder: Path) -> str:
    """Run a command in a folder, and return its output, or its error if it fails."""
    words = [sys.executable, "-m", "cycloid_mj", *shlex.split(command)[1:]]
    print(f"$ {command}", file=sys.stderr, flush=True)
    environment = {**os.environ, "COLUMNS": str(WIDTH), "NO_COLOR": "1"}
    ended = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    error = ended.stderr[ended.stderr.rfind("error: ") :] if ended.returncode else ""
    lines = (ended.stdout + error).rstrip().splitlines()
    return "\n".join(TIMED.sub("", line.rstrip()) for line in lines)


def with_printed(page: str, folder: Path) -> str:
    """Return a page with the output of its commands inserted, which are run in a folder in their order."""

    def fill(block: re.Match[str]) -> str:
        text = "\n\n".join(filter(None, (run_command(command, folder) for command in commands(block["lines"]))))
        return block["code"] + (f"\n{MARK}\n```text\n{text}\n```\n" if text else "")

    return BLOCK.sub(fill, page)


def main() -> None:
    """Run the tutorial and write its page and pictures."""
    PICTURES.mkdir(exist_ok=True)
    with TemporaryDirectory() as scratch:
        folder = Path(scratch)
        page = with_printed(PAGE.read_text(encoding="utf-8"), folder)
        for name, (picture, width, height) in SHOWN.items():
            screenshot(folder / name, PICTURES / picture, width, height)
        for name, picture in MADE.items():
            keep_small(folder / name, PICTURES / picture)
    PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
