"""The MuJoCo releases on which the places in its structures were checked, by ``scripts/test_mujoco_versions.py``."""

import os
import re

from cycloid_mj.errors import ContactError

OLDEST, NEWEST = (3, 17, 0), (4, 0, 1)
FAULTY = ((4, 0, 0),)
"""Releases between them on which the contact tests fail."""

REQUIREMENT = "mujoco>=3.17,!=4.0.0,<=4.0.1"
"""The same for pip, as in pyproject.toml."""

UNTESTED = "CYCLOID_MJ_UNTESTED_MUJOCO"
"""Environment variable that lets other releases through, for the tests that decide about them."""


def require_tested(version: str) -> None:
    """Raise ContactError for a MuJoCo release that the contact was not tested on, or that failed.

    The collider reads and writes MuJoCo's own structures, which change without notice: where they have changed, its
    figures would be wrong without a word.
    """
    numbers = tuple(int(number) for number in re.findall(r"\d+", version)[:3])
    if os.environ.get(UNTESTED) or (OLDEST <= numbers <= NEWEST and numbers not in FAULTY):
        return
    raise ContactError(
        f"MuJoCo {version} is not one that cycloid_mj was tested on ({_text(OLDEST)} to {_text(NEWEST)}, without "
        f"{', '.join(map(_text, FAULTY))}): pip install '{REQUIREMENT}'; or set {UNTESTED}=1 to try it"
    )


def _text(numbers: tuple[int, ...]) -> str:
    return ".".join(map(str, numbers))
