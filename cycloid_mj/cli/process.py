"""The process of ``cycloid-mj``: signals and closed streams, from its start to its end."""

import atexit
import codecs
import os
import sys
import unicodedata
from collections.abc import Sequence
from importlib.util import cache_from_source
from io import StringIO, TextIOWrapper
from pathlib import Path
from typing import TextIO

from cycloid_mj.base.interrupt import end_on_signals, exit_code, raise_on_signals, signal_name
from cycloid_mj.base.memory import collect_rarely, freeze_objects

SUBSTITUTING = "cycloid_mj.substitute"
"""Name of the handler of characters that a stream cannot encode."""

SUBSTITUTES = {
    "\N{DEGREE SIGN}": "deg",
    "\N{DIAMETER SIGN}": "dia ",
    "\N{MICRO SIGN}": "u",
    "\N{GREEK SMALL LETTER MU}": "u",
    "\N{MULTIPLICATION SIGN}": "x",
    "\N{MIDDLE DOT}": "*",
    "\N{PLUS-MINUS SIGN}": "+-",
    "\N{MINUS SIGN}": "-",
    "\N{EN DASH}": "-",
    "\N{EM DASH}": "-",
    "\N{HORIZONTAL ELLIPSIS}": "...",
    "\N{LESS-THAN OR EQUAL TO}": "<=",
    "\N{GREATER-THAN OR EQUAL TO}": ">=",
    "\N{ALMOST EQUAL TO}": "~",
    "\N{RIGHTWARDS ARROW}": "->",
    "\N{SUPERSCRIPT TWO}": "2",
    "\N{SUPERSCRIPT THREE}": "3",
    "\N{LEFT SINGLE QUOTATION MARK}": "'",
    "\N{RIGHT SINGLE QUOTATION MARK}": "'",
    "\N{CHECK MARK}": "ok",
    "\N{BALLOT X}": "x",
}
"""Character -> what is written where the encoding of a stream lacks it."""

LOADED = Path(__file__).parents[1] / "design" / "model.py"
"""A module that every command loads."""

SILENT_FLAGS = {"--quiet", "--help", "-h", "--version"}
"""Words of a command line that asks for no messages, or loads little."""

BLAS_THREADS = {"OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"}
"""Variables by which a user says how many threads multiply matrices."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command, by default that of ``sys.argv``, and return its exit code; see `cycloid_mj.cli.app`."""
    from cycloid_mj.cli import app

    return app.main(argv)


def first_start(words: Sequence[str]) -> bool:
    """Return whether Python has to compile the modules of a command first: an installation can lack bytecode."""
    if sys.dont_write_bytecode or not words or SILENT_FLAGS & set(words):
        return False
    return not Path(cache_from_source(str(LOADED))).exists()


def replace_unencodable(*streams: TextIO) -> None:
    """Make text streams replace characters that their encoding lacks, such as a degree sign by "deg".

    Without this, output to a stream with the encoding ASCII ends in a UnicodeEncodeError.
    """
    codecs.register_error(SUBSTITUTING, substitutes)
    for stream in streams:
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors=SUBSTITUTING)


def substitutes(error: UnicodeError) -> tuple[str, int]:
    """Return substitutes for the characters that cannot be encoded, and where to go on: a handler for `codecs`."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    signs = error.object[error.start : error.end]
    return "".join(map(_substitute, signs)), error.end


def _substitute(sign: str) -> str:
    """Return the substitute of a character: of the table, its letter without accents, or its escape sequence."""
    base_letter = unicodedata.normalize("NFKD", sign)[0]
    return SUBSTITUTES.get(sign) or (base_letter if base_letter.isascii() else ascii(sign)[1:-1])


def find_stop(error: BaseException) -> KeyboardInterrupt | None:
    """Return the interruption that caused an error, directly or through other errors; None if there is none."""
    cause: BaseException | None = error
    while cause is not None and not isinstance(cause, KeyboardInterrupt):
        cause = cause.__cause__ or cause.__context__
    return cause


def run() -> None:
    """Run the command of ``sys.argv``, and end the process with its exit code; errors are printed on stderr.

    Sets up streams, environment and signals of the process. If a signal arrives while the program is still loading, the
    exit code is 128 plus the number of the signal.
    """
    # a stream that was closed before the start is None
    sys.stdout = sys.stdout or StringIO()
    sys.stderr = sys.stderr or StringIO()
    replace_unencodable(sys.stdout, sys.stderr)
    code = 1
    if first_start(sys.argv[1:]):
        sys.stderr.write("first start: Python compiles its modules, which takes some seconds\n")
    collect_rarely()
    # pydantic looks for plugins in every package that is installed; no command has a use for one
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # matrices are small here, or sparse: threads that share them cost more than they do, an eighth of `stress`
    if not BLAS_THREADS & os.environ.keys():
        os.environ["OPENBLAS_NUM_THREADS"] = "1"
    atexit.register(freeze_objects)
    try:
        raise_on_signals()
        code = main()
        sys.stdout.flush()
    except KeyboardInterrupt as stop:
        # before `main` could report it, for example while modules were loaded
        code = exit_code(stop)
        sys.stderr.write(f"error: stopped by {signal_name(stop)}\n")
    except ImportError as error:
        # a module in C that is stopped while it is loaded ends in an error of its own
        cause = find_stop(error)
        if cause is None:
            raise
        code = exit_code(cause)
        sys.stderr.write(f"error: stopped by {signal_name(cause)}\n")
    except OSError:
        # the pipe is closed: what is left must not be flushed again, and complained about, when Python ends
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    end_on_signals()
    sys.exit(code)
