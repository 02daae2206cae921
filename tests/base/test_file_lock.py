"""Locks of files: one process at once, with and without fcntl (as on Windows)."""

import signal
import subprocess
import sys
from pathlib import Path

import filelock  # noqa: F401  # it keeps the locks of this system when fcntl is hidden
import pytest

from cycloid_mj.base.file_lock import lock_file

HOLD = """
import filelock, sys  # filelock keeps the locks of this system
if sys.argv[2] == "without fcntl":
    sys.modules["fcntl"] = None
from pathlib import Path
from cycloid_mj.base.file_lock import lock_file
release = lock_file(Path(sys.argv[1]))
print("locked", flush=True)
sys.stdin.read()
"""


@pytest.mark.parametrize("system", ["with fcntl", "without fcntl"])
def test_a_file_is_locked_until_its_process_ends_or_is_killed(system, tmp_path, monkeypatch) -> None:
    if system == "without fcntl":
        monkeypatch.setitem(sys.modules, "fcntl", None)
    path = tmp_path / "run.mcap"
    path.write_bytes(b"samples")
    command = [sys.executable, "-c", HOLD, str(path), system]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=Path(__file__).parents[2]
    ) as held:
        assert held.stdout is not None
        assert held.stdout.readline() == b"locked\n"
        with pytest.raises(BlockingIOError):
            lock_file(path)
        assert path.read_bytes() == b"samples"
        held.send_signal(signal.SIGTERM)
    release = lock_file(path)
    with pytest.raises(BlockingIOError):
        lock_file(path)
    release()
    lock_file(path)()
    assert path.read_bytes() == b"samples"
