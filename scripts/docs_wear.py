"""Wear presets for 1000 h, and write docs/data/wear.csv, the data of a chart of docs/wear.md.

python scripts/docs_wear.py
"""

from docs_page import DATA, csv_text

from cycloid_mj.base.atomic_write import write_files
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.life.accuracy_life import wear

NAMES = ("pin", "nonpin", "printed", "twodisc")
HOURS = 1000.0  # of running


def main() -> None:
    """Write the lost motion [arcmin] of each preset over operating hours, in all cases, to ``wear.csv``."""
    rows = [("preset", "case", "hours", "lost_motion_arcmin")]
    for name in NAMES:
        for case, course in wear(name, HOURS).courses.items():
            for hours, motion in zip(course.hours, course.lost_motion / ARCMINUTE, strict=True):
                rows.append((name, case, f"{hours:.5g}", f"{motion:.5g}"))
    write_files({DATA / "wear.csv": csv_text(rows).encode()})


if __name__ == "__main__":
    main()
