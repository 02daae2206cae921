"""A process-wide change that parallel runs share: applied by the first user, reverted by the last."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Shared:
    """A change of global state and its reversal, with a count of its users."""

    def __init__(self, make: Callable[[], None], undo: Callable[[], None]) -> None:
        self._make, self._undo = make, undo
        self._lock = threading.Lock()
        self._users = 0

    @contextmanager
    def apply(self) -> Iterator[None]:
        """Apply the global change in this ``with`` block: the first open block makes it, the last reverts it."""
        with self._lock:
            if not self._users:
                self._make()
            self._users += 1
        try:
            yield
        finally:
            with self._lock:
                self._users -= 1
                if not self._users:
                    self._undo()
