"""Nothing depends on what POSIX alone has: modules, signals and functions that Windows lacks are hidden.

Nor does a text file depend on the encoding of the system.
"""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

HIDE = """
import os, signal, sys, warnings
import filelock  # which keeps the locks of this system
import multiprocessing.util, subprocess, tempfile  # and so do these

for name in ("fcntl", "grp", "pty", "pwd", "resource", "syslog", "termios", "tty"):
    sys.modules[name] = None
for name in dir(signal):
    if name.startswith("SIG") and name not in {
        "SIGABRT", "SIGFPE", "SIGILL", "SIGINT", "SIGSEGV", "SIGTERM", "SIG_DFL", "SIG_IGN"
    }:
        delattr(signal, name)
for name in ("alarm", "pthread_kill", "pthread_sigmask", "setitimer", "sigwait"):
    vars(signal).pop(name, None)
for name in (
    "chown", "fchmod", "fork", "forkpty", "getegid", "geteuid", "getgid", "getloadavg", "getpgid", "getuid", "killpg",
    "mkfifo", "nice", "sched_getaffinity", "setsid", "statvfs", "sysconf", "wait", "waitid",
):
    vars(os).pop(name, None)
warnings.filterwarnings("ignore", category=EncodingWarning)
warnings.filterwarnings("error", category=EncodingWarning, module="cycloid_mj|hsieh2014")
"""

MODULES = """
import importlib, pkgutil
import cycloid_mj, hsieh2014

for package in (cycloid_mj, hsieh2014):
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
print("imported")
"""

COMMANDS = """
from cycloid_mj.cli import main

short = ["--ramp-s", "0", "--hold-s", "0.002", "--quiet"]
for argv in (
    ["design", "check", "pin"],
    ["statics", "pin"],
    ["simulate", "pin", *short, "--solver", "planar", "--out", "runs"],
    ["simulate", "pin", *short, "--solver", "planar", "--out", "runs", "--force"],
    ["analyze", "runs/pin.mcap"],
    ["log", "csv", "runs/pin.mcap", "--out", "pin.csv"],
    ["sweep", "pin", "--vary", "clearance.cam_um=1,2", "--measure", "mass", "--workers", "1", "--out", "study"],
    ["sweep", "pin", "--vary", "clearance.cam_um=1,2", "--measure", "mass", "--workers", "1", "--out", "study"],
    ["reduce", "printed", "--out", "joint"],
):
    assert main(argv) == 0, argv
print("done")
"""


@pytest.mark.slow
@pytest.mark.parametrize(("work", "last"), [(MODULES, "imported"), (COMMANDS, "done")], ids=["modules", "commands"])
def test_without_what_windows_lacks(work, last, tmp_path) -> None:
    done = subprocess.run(
        [sys.executable, "-X", "warn_default_encoding", "-c", HIDE + work],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.splitlines()[-1] == last
