"""Packages that one command alone needs: imported where they are used, with one error that names the extra."""

from importlib import import_module
from typing import Any

from cycloid_mj.base.errors import CycloidError


def extra(module: str, what: str, name: str, instead: str = "") -> Any:
    """Import a module of an extra.

    Parameters
    ----------
    module
        Its name.
    what
        What needs it, as the sentence of the error begins.
    name
        The extra.
    instead
        What else can be done, as the sentence ends.

    Raises
    ------
    CycloidError
        It, or a library that it needs, is not installed.
    """
    try:
        return import_module(module)
    except (ImportError, OSError) as problem:
        ways = ", or ".join(filter(None, (f"pip install 'cycloid-mj[{name}]'", instead)))
        raise CycloidError(f"{what} needs {module.replace('_', '-')} ({problem}): {ways}") from problem
