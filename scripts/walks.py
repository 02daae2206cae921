"""Count the modules that a design is handed through on its way to a run, a stress and a robot's joint.

python scripts/walks.py          # of this tree
python scripts/walks.py OLD      # and of another revision

Three commands are run and every call between two modules of the package is watched that hands on a design, what is
made of it, or a run: how many rooms and modules they are, how many pairs of functions, and how many pairs of modules
hand on both ways. What is asked of the design or the run itself, by its own methods, is no step of its walk.
"""

import argparse
import contextlib
import io
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = f"{os.sep}cycloid_mj{os.sep}"
HANDED_ON = frozenset({"Design", "Reducer", "Mechanism", "Run"})
"""Names of the classes whose way is followed."""

SHORT = ("--set", "ring.pins=fixed", "--ramp-s", "0", "--load-nm", "36")
WALKS = {
    "a design becomes a run": ("simulate", "--design", "pin", *SHORT, "--hold-s", "0.08", "--out", "run"),
    "a run becomes a stress": ("stress", "--log", "run/pin.mcap", "--part", "pin_1", "--quick", "--out", "stress"),
    "a design becomes a joint": ("reduce", "--design", "pin", "--out", "joint"),
}


@dataclass
class Walk:
    """What was seen of a walk: pairs of modules, and of functions, between which something was handed on."""

    modules: set[tuple[str, str]] = field(default_factory=set)
    functions: set[tuple[str, str]] = field(default_factory=set)

    def watch(self, frame: FrameType, event: str, _: object) -> None:
        """Note a call; made for `sys.setprofile`."""
        if event != "call" or (callee := _module(frame)) is None:
            return
        code, caller = frame.f_code, frame.f_back
        given = code.co_varnames[: code.co_argcount]
        if not any(_handed_on(frame.f_locals.get(name)) for name in given if name != "self"):
            return
        while caller and _module(caller) is None:
            caller = caller.f_back
        if caller and (home := _module(caller)) != callee:
            self.modules.add((str(home), callee))
            self.functions.add((f"{home}:{caller.f_code.co_name}", f"{callee}:{code.co_name}"))

    def counted(self) -> dict[str, int]:
        """Count rooms, modules, pairs of functions, and pairs of modules that hand on both ways."""
        modules = {name for pair in self.modules for name in pair}
        return {
            "rooms": len({name.partition(os.sep)[0] for name in modules}),
            "modules": len(modules),
            "calls": len(self.functions),
            "both ways": sum((there, here) in self.modules for here, there in self.modules) // 2,
        }


def _module(frame: FrameType) -> str | None:
    """Name the package's module of a frame; None for a frame of other code."""
    _, package, name = frame.f_code.co_filename.rpartition(PACKAGE)
    return name if package else None


def _handed_on(value: object) -> bool:
    return type(value).__name__ in HANDED_ON


def walks() -> Iterator[tuple[str, dict[str, int]]]:
    """Run the three commands in an empty folder and yield what each walk counts."""
    from cycloid_mj.cli import main

    with TemporaryDirectory() as folder, contextlib.chdir(folder):
        for name, words in WALKS.items():
            walk = Walk()
            with contextlib.redirect_stdout(io.StringIO()):
                sys.setprofile(walk.watch)
                try:
                    code = main([*words, "--quiet"])
                finally:
                    sys.setprofile(None)
            if code:
                raise SystemExit(f"`cycloid-mj {' '.join(words)}` ended with {code}")
            yield name, walk.counted()


def at(revision: str) -> dict[str, dict[str, int]]:
    """Count the walks of another revision, laid out in a folder of its own, by this script."""
    with TemporaryDirectory() as folder:
        tree = subprocess.run(["git", "archive", revision], cwd=ROOT, check=True, capture_output=True).stdout
        subprocess.run(["tar", "-x", "-C", folder], input=tree, check=True)
        path = os.pathsep.join([folder, f"{folder}/papers"])
        done = subprocess.run(
            [sys.executable, __file__, "--json"],
            env={**os.environ, "PYTHONPATH": path},
            check=True,
            stdout=subprocess.PIPE,
        )
    return dict(json.loads(done.stdout))


def main() -> None:
    """Print a table of the walks, of another revision beside this one where asked for."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    parser.add_argument("old", nargs="?", help="revision to hold this tree against")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    wanted = parser.parse_args()
    now = dict(walks())
    if wanted.json:
        print(json.dumps(now))
        return
    old = at(wanted.old) if wanted.old else {}
    for name, counted in now.items():
        before = old.get(name, {})
        figures = (f"{value} {what}" + (f" ({before[what]})" if before else "") for what, value in counted.items())
        print(f"{name}: {', '.join(figures)}")


if __name__ == "__main__":
    main()
