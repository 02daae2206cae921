"""Former names of attributes that were renamed; they work for one release."""

import warnings
from typing import Any


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
