"""Packages that one command alone needs: imported where they are used, with one error that names the extra."""

from importlib import import_module
from typing import Any

from cycloid_mj.base.errors import CycloidError


def import_extra(module: str, feature: str, extra_name: str, alternative: str = "") -> Any:
    """Import and return a module of an optional dependency group ("extra") of this package.

    Parameters
    ----------
    module
        Name of the module.
    feature
        What needs it, as the beginning of the error message.
    extra_name
        Name of the extra that installs it.
    alternative
        What else the user can do, as the end of the error message.

    Raises
    ------
    CycloidError
        The module, or a library that it needs, is not installed.
    """
    try:
        return import_module(module)
    except (ImportError, OSError) as problem:
        remedies = ", or ".join(filter(None, (f"pip install 'cycloid-mj[{extra_name}]'", alternative)))
        raise CycloidError(f"{feature} needs {module.replace('_', '-')} ({problem}): {remedies}") from problem
