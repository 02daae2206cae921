"""Run the command: ``python -m cycloid_mj``."""

from cycloid_mj.cli.process import run

run()
