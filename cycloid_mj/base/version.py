"""Version of the package; `pyproject.toml` reads it from here, and CITATION.cff repeats it."""

__version__ = "0.2.0"
