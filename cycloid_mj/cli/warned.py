"""What a command is warned of: shown once each, and kept for its JSON."""

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from cycloid_mj.errors import CycloidWarning

_seen: ContextVar[dict[str, None]] = ContextVar("seen")


@contextmanager
def warnings_kept(show: Callable[[str], None] | None) -> Iterator[None]:
    """Keep the warnings issued inside this ``with`` block, in whichever thread; show each once, if there is a `show`.

    Python's own way with warnings of other kinds stays as it is.
    """
    seen: dict[str, None] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("always", CycloidWarning)
        others = warnings.showwarning

        def keep(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
            if not issubclass(category, CycloidWarning):
                others(message, category, *place, **more)
            elif (text := str(message)) not in seen:
                seen[text] = None
                if show:
                    show(f"warning: {text}")

        warnings.showwarning = keep
        token = _seen.set(seen)
        try:
            yield
        finally:
            _seen.reset(token)


def with_warnings(found: dict[str, Any]) -> dict[str, Any]:
    """Give a command's JSON object with the warnings kept so far, ``warnings``, unless it has that key already."""
    seen = _seen.get(None)
    return found if seen is None or "warnings" in found else found | {"warnings": list(seen)}
