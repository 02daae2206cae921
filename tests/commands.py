"""A command run within the tests' process."""

from contextlib import redirect_stderr, redirect_stdout
from io import StringIO

from cycloid_mj.cli import main


def told(*argv: object) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of a command."""
    out, err = StringIO(), StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        code = main([str(word) for word in argv])
    return code, out.getvalue(), err.getvalue()
