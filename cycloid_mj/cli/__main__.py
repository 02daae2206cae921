"""``python -m cycloid_mj.cli``."""

from cycloid_mj.cli.process import run

run()
