"""``python -m cycloid_mj.cli``."""

from cycloid_mj.cli.app import run

run()
