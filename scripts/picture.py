"""Make the pictures of the documentation: the README's moving one, and the top of a report.

python scripts/picture.py animation                      # models/mechanism.gif: the pin reducer under load
python scripts/picture.py report PIN.mcap NONPIN.mcap    # models/report.png, with Chromium and its driver

`scripts/docs_figures.py` calls both.
"""

import shutil
import sys
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

from cycloid_mj.cli import main as cycloid_mj

MODELS = Path(__file__).parent.parent / "models"
RUN = ("simulate", "--design", "pin", "--set", 'ring.pins="massless"', "--load-nm", "36", "--ramp-s", "0")
LENGTH = ("--hold-s", "0.06")
LOOK = ("--magnify", "200", "--frames", "36", "--width", "520")
WIDTH, HEIGHT = 1265, 1780
"""Of the picture of a report [px]."""

COLOURS = 256


def animation(path: Path = MODELS / "mechanism.gif") -> int:
    """Write the moving picture to a file; give the exit code."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory() as folder:
        code = cycloid_mj([*RUN, *LENGTH, "--out", folder, "--quiet"])
        return code or cycloid_mj(["animate", str(Path(folder) / "pin.mcap"), str(path), *LOOK, "--force"])


def report(logs: Sequence[str], path: Path = MODELS / "report.png") -> int:
    """Write the top of the report of some runs to a picture; give the exit code."""
    from PIL import Image
    from selenium import webdriver

    chromium, driver_path = shutil.which("chromium"), shutil.which("chromedriver")
    if not chromium or not driver_path:
        print(
            "error: the picture of a report needs Chromium and its driver (Debian: chromium, chromium-driver)",
            file=sys.stderr,
        )
        return 1
    with TemporaryDirectory() as folder:
        page = Path(folder) / "report.html"
        if code := cycloid_mj(["report", *logs, "--out", str(page)]):
            return code
        options = webdriver.ChromeOptions()
        options.binary_location = chromium
        for word in ("--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"):
            options.add_argument(word)
        driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver_path))
        try:
            screen = {"width": WIDTH, "height": HEIGHT, "deviceScaleFactor": 1, "mobile": False}
            driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
            driver.get(page.as_uri())
            taken = driver.get_screenshot_as_png()
        finally:
            driver.quit()
    Image.open(BytesIO(taken)).convert("RGB").quantize(COLOURS).save(path, optimize=True)
    return 0


if __name__ == "__main__":
    what, *given = sys.argv[1:] or ["animation"]
    sys.exit(report(given) if what == "report" else animation(*map(Path, given)))
