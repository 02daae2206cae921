"""The command line ``cycloid-mj``: one module for each subcommand, and `main` that tests call in-process."""

from cycloid_mj.cli.process import main, run

__all__ = ["main", "run"]
