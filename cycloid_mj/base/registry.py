"""Registry of functions that upper layers provide, so that no lower layer imports an upper layer.

`cycloid_mj/__init__.py` fills the registry; Python imports it before every other module of the package.
"""

from importlib import import_module
from typing import Any

_providers: dict[str, str] = {}


def register(**providers: str) -> None:
    """Register providers: a name, and ``module:object``, which is imported when it is first used."""
    _providers.update(providers)


def get_provider(name: str) -> Any:
    """Import and return the object that a module has registered under a name, such as a function of a higher layer.

    Raises
    ------
    LookupError
        No object is registered under this name.
    """
    module, _, attribute = _providers[name].partition(":")
    return getattr(import_module(module), attribute)
