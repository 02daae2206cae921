"""Make the pictures of the documentation: the README's moving one, the tops of pages, and a walk through the app.

python scripts/picture.py animation                      # models/mechanism.gif: the pin reducer under load
python scripts/picture.py report PIN.mcap NONPIN.mcap    # models/report.png, with Chromium
python scripts/picture.py datasheet PAGE.html            # docs/datasheet.png, with Chromium
python scripts/picture.py walk FOLDER                    # docs/app, of what scripts/app_walk.py has taken
python scripts/picture.py doors                          # docs/doors: the README's three, cut out of other pictures

`scripts/docs_figures.py` calls them.
"""

import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from cycloid_mj.cli import main as cycloid_mj

MODELS = Path(__file__).parent.parent / "models"
DOCS = MODELS.parent / "docs"
RUN = ("simulate", "--design", "pin", "--set", 'ring.pins="massless"', "--load-nm", "36", "--ramp-s", "0")
LENGTH = ("--hold-s", "0.06")
LOOK = ("--magnify", "200", "--frames", "36", "--width", "520")
WIDTH, HEIGHT = 1265, 1780
"""Of the picture of a report [px]."""

COLOURS = 256  # of a PNG file with a palette

WALKED = ("1-requirements.png", "2-refused.png", "3-drives.png", "4-designed.png")
"""Steps of the walk through the designer's page that are shown."""

DOORS = {
    "print": (DOCS / "tutorial" / "exploded.png", (944, 62, 1572, 566)),
    "design": (MODELS / "report.png", (45, 726, 605, 1294)),
    "robot": (DOCS / "tutorial" / "joint.png", (14, 246, 574, 542)),
}
"""The README's pictures: the picture that each is cut out of, and left, top, right, bottom in it [px]."""


def animation(path: Path = MODELS / "mechanism.gif") -> int:
    """Write the animation to a file; return the exit code."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory() as folder:
        code = cycloid_mj([*RUN, *LENGTH, "--out", folder, "--quiet"])
        return code or cycloid_mj(["animate", str(Path(folder) / "pin.mcap"), str(path), *LOOK, "--force"])


def report(logs: Sequence[str], path: Path = MODELS / "report.png") -> int:
    """Render the top of the report of some logs as a PNG file; return the exit code."""
    with TemporaryDirectory() as folder:
        page = Path(folder) / "report.html"
        if code := cycloid_mj(["report", *logs, "--out", str(page)]):
            return code
        screenshot(page, path, WIDTH, HEIGHT)
    return 0


def walk(folder: Path) -> int:
    """Keep the pictures of a walk through the designer's page that the documentation shows; return the exit code."""
    for name in WALKED:
        keep_small(folder / name, DOCS / "app" / name)
    return 0


def keep_small(taken: Path, path: Path) -> None:
    """Write a picture with few colours."""
    from PIL import Image

    path.parent.mkdir(exist_ok=True)
    with Image.open(taken) as picture:
        picture.convert("RGB").quantize(COLOURS).save(path, optimize=True)


def screenshot(page: Path, path: Path, width: int, height: int) -> None:
    """Render the top of an HTML page as an image of a size [px]; exit with 1 if there is no Chromium."""
    chromium = shutil.which("chromium")
    if not chromium:
        sys.exit("error: the picture of a page needs Chromium (Debian: chromium)")
    with TemporaryDirectory() as folder:
        taken = Path(folder) / "taken.png"
        look = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", f"--window-size={width},{height}"]
        # time for the script of the page to draw its charts [ms]
        look += ["--virtual-time-budget=10000", f"--screenshot={taken}"]
        subprocess.run([chromium, *look, page.resolve().as_uri()], check=True, capture_output=True)
        keep_small(taken, path)


def datasheet(page: str, path: Path = DOCS / "datasheet.png") -> int:
    """Write the top of the page of a data sheet to a picture; return the exit code."""
    screenshot(Path(page), path, WIDTH, HEIGHT)
    return 0


def crop_doors() -> int:
    """Cut the README's pictures out of other pictures of the documentation; return the exit code."""
    from PIL import Image

    (DOCS / "doors").mkdir(exist_ok=True)
    for name, (source, box) in DOORS.items():
        with Image.open(source) as picture:
            cut = picture.convert("RGB").crop(box)
        cut.quantize(COLOURS).save(DOCS / "doors" / f"{name}.png", optimize=True)
    return 0


if __name__ == "__main__":
    what, *given = sys.argv[1:] or ["animation"]
    made = {"report": lambda: report(given), "datasheet": lambda: datasheet(given[0])}
    made |= {"walk": lambda: walk(Path(given[0])), "doors": crop_doors}
    sys.exit(made[what]() if what in made else animation(*map(Path, given)))
