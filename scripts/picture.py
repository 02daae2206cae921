"""Draw the README's picture: the paper's pin reducer under load, from a short run of its own."""

import sys
from pathlib import Path

from cycloid_mj.design import PRESETS, override
from cycloid_mj.plots import mechanism
from cycloid_mj.run import simulate

DESIGN = ["drive.ramp_s=0.0", "drive.hold_s=0.02", "load.torque_nm=36.0"]


def main(path: str = "models/mechanism.png") -> None:
    """Write the picture to a file."""
    design = override(PRESETS["pin"], DESIGN)
    figure = mechanism(design, simulate(design))
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    main(*sys.argv[1:])
