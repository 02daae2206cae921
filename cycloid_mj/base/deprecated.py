"""Former names of attributes and arguments that were renamed; they work for one release."""

import warnings
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")


def deprecated_attribute(owner: str, old: str, new: str) -> Any:
    """Return a property for the former name of an attribute: it warns, and returns the value under the new name.

    Parameters
    ----------
    owner
        Name of the class, for the warning.
    old, new
        Former and present name of the attribute.
    """

    def read(instance: Any) -> Any:
        warnings.warn(f"the attribute {owner}.{old} is deprecated: use {owner}.{new}", DeprecationWarning, stacklevel=2)
        return getattr(instance, new)

    return property(read, doc=f"Deprecated name of `{new}`.")


def deprecated_argument(old: str, new: str) -> Callable[[Callable[Parameters, Result]], Callable[Parameters, Result]]:
    """Return a decorator that also accepts the former name of a keyword argument, with a warning.

    Parameters
    ----------
    old, new
        Former and present name of the argument.
    """

    def accept_old_name(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
        """Decorate a function so that it also accepts an argument under its former name, with a warning."""

        @wraps(function)
        def call_with_new_name(*args: Parameters.args, **kwargs: Parameters.kwargs) -> Result:
            """Call the function; an argument under its former name is passed under its new name, with a warning."""
            if old in kwargs:
                if new in kwargs:
                    raise TypeError(f"{function.__name__} got both {new} and {old}: remove {old}")
                warning_text = f"the argument {old} of {function.__name__} is deprecated: use {new}"
                warnings.warn(warning_text, DeprecationWarning, stacklevel=2)
                kwargs[new] = kwargs.pop(old)
            return function(*args, **kwargs)

        return call_with_new_name

    return accept_old_name
