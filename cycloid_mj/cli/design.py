"""``cycloid-mj design show`` and ``cycloid-mj design check``."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from cycloid_mj.cli.flags import JsonFlag
from cycloid_mj.cli.terminal import say, say_json
from cycloid_mj.design import dump, resolve

if TYPE_CHECKING:
    from cycloid_mj.checks import Check

DesignName = Annotated[str, Parameter(metavar="NAME|FILE", help="Design: pin, nonpin, or a TOML file.")]

EXAMPLES = """Examples:
  cycloid-mj design show pin > my.toml
  cycloid-mj design check my.toml
  cycloid-mj design check nonpin --json"""


def commands(sort_key: int) -> App:
    """Give the commands about design files; `sort_key` is their place in the help."""
    app = App(name="design", help="Print a design file, or check one.", help_epilogue=EXAMPLES, sort_key=sort_key)
    app.command(show)
    app.command(check)
    return app


def show(design: DesignName, /) -> int:
    """Print the complete, commented design file of a preset or of a file.

    Each value that the paper (Hsieh 2014) does not give is marked as
    assumed. A file may leave keys out: they keep the values of the preset pin.
    """
    say(dump(resolve(design)).rstrip("\n"))
    return 0


def check(design: DesignName, /, *, json: JsonFlag = False) -> int:
    """Make every geometric and mechanical check of a design and list them all.

    For each: the value, its limit and the reason; for a failure also what to
    change. The exit code is 1 if the design cannot be built, else 0: warnings
    do not count.
    """
    from cycloid_mj.checks import check as checks

    chosen = resolve(design)
    found = checks(chosen)
    sound = not any(_word(item) == "FAIL" for item in found)
    if json:
        say_json({"design": chosen.name, "sound": sound, "checks": [asdict(item) for item in found]})
    else:
        for item in found:
            say(f"{_word(item):4}  {item}")
        failed = [item for item in found if not item.passed]
        warnings = sum(_word(item) == "warn" for item in failed)
        say(f"{len(found)} checks: {len(failed) - warnings} failed, {warnings} warnings")
    return 0 if sound else 1


def _word(item: "Check") -> str:
    if item.passed:
        return "ok"
    return "FAIL" if item.severity == "error" else "warn"
