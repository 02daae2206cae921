"""Draw the README's moving picture: the paper's pin reducer under load, its gaps drawn 200 times as wide."""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from cycloid_mj.cli import main as cycloid_mj

RUN = (
    "simulate",
    "--design",
    "pin",
    "--set",
    'ring.pins="massless"',
    "--load-nm",
    "36",
    "--ramp-s",
    "0",
    "--hold-s",
    "0.06",
)
LOOK = ("--magnify", "200", "--frames", "36", "--width", "520")


def main(path: str = "models/mechanism.gif") -> int:
    """Write the picture to a file; give the exit code."""
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory() as folder:
        code = cycloid_mj([*RUN, "--out", folder, "--quiet"])
        return code or cycloid_mj(["animate", str(Path(folder) / "pin.mcap"), path, *LOOK])


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
