"""Worker-process housekeeping: ignore Ctrl-C, exit with the parent."""

import os
import signal
import threading
import time

SECONDS_BETWEEN_LOOKS = 1.0
"""Between two looks at whether the parent still lives: joblib's workers have nothing to wait for it by."""


def serve_parent() -> None:
    """Leave Ctrl-C to the parent, which ends its workers, and end where the parent was killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()


def _end_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(SECONDS_BETWEEN_LOOKS)
    os.kill(os.getpid(), signal.SIGTERM)
