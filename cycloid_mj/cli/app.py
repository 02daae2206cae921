"""The table of contents of the command line, and how every mistake is told: one line on stderr and an exit code.

Exit codes: 0 done; 1 a design, run, log or file that failed, or Ctrl-C, SIGTERM, SIGHUP; 2 a wrong name, flag or value.
"""

import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from inspect import BoundArguments

from cyclopts import App, CycloptsError, Parameter

from cycloid_mj import __version__
from cycloid_mj.base.engine import at_most
from cycloid_mj.base.errors import CycloidError, UsageError
from cycloid_mj.base.interrupt import cause
from cycloid_mj.base.replacing import one_command
from cycloid_mj.cli import (
    analyze,
    animate,
    bench,
    build,
    compare,
    datasheet,
    design,
    doctor,
    export,
    figures,
    kinematics,
    log,
    measure,
    optimize,
    page,
    plot,
    profile,
    rate,
    reduce,
    render,
    review,
    serve,
    simulate,
    statics,
    stress,
    sweep,
    tolerance,
    validate,
    view,
)
from cycloid_mj.cli.mistakes import sentence
from cycloid_mj.cli.terminal import log_to_stderr, tell, warnings_kept
from cycloid_mj.papers import GROUP, papers

FAILURE = 1

ABOUT = """Simulate cycloidal speed reducers in MuJoCo and compare with theory.

Results go to stdout, progress and messages to stderr. Exit code: 0 done,
1 failed, 2 wrong usage. `cycloid-mj COMMAND --help` tells all of a command.
"""

EXAMPLES = """Start with:
  cycloid-mj simulate --design pin    # the paper's reducer
  cycloid-mj plot runs/pin.mcap       # draw that run
  cycloid-mj design new my            # edit this: my.toml
  cycloid-mj design check my.toml"""

ABOUT_PAPERS = f"""Run a published paper again and judge its claims.

Papers are packages of their own, found by entry points of the group {GROUP}.
"""

RENAMED = {"--jobs": "--workers"}

COMMANDS: dict[Callable[..., int], str] = {
    simulate.simulate: simulate.EXAMPLES,
    analyze.analyze: analyze.EXAMPLES,
    plot.plot: plot.EXAMPLES,
    review.report: review.EXAMPLES,
    animate.animate: animate.EXAMPLES,
    render.render: render.EXAMPLES,
    view.view: view.EXAMPLES,
    compare.compare: compare.EXAMPLES,
    statics.statics: statics.EXAMPLES,
    figures.figures: figures.EXAMPLES,
    validate.validate: validate.EXAMPLES,
    stress.stress: stress.EXAMPLES,
    rate.rate: rate.EXAMPLES,
    datasheet.datasheet: datasheet.EXAMPLES,
    sweep.sweep: sweep.EXAMPLES,
    tolerance.tolerance: tolerance.EXAMPLES,
    optimize.optimize: optimize.EXAMPLES,
    reduce.reduce: reduce.EXAMPLES,
    bench.calibrate: bench.EXAMPLES,
    bench.compare_bench: bench.TE_EXAMPLES,
    serve.app: serve.EXAMPLES,
    build.build: build.EXAMPLES,
    export.export: export.EXAMPLES,
    profile.profile: profile.EXAMPLES,
    kinematics.kinematics: kinematics.EXAMPLES,
    doctor.doctor: doctor.EXAMPLES,
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command, by default that of ``sys.argv``, and give its exit code.

    A mistake of the user's never raises: it is told in one line on stderr.
    """
    words = [_renamed(word) for word in (sys.argv[1:] if argv is None else argv)]
    try:
        quiet = "--quiet" in words
        with one_command(), warnings_kept(None if quiet else tell), log_to_stderr(quiet):
            app = application()
            if group := _group_alone(app, words):
                app.help_print(words, console=page.console(stderr=True))
                raise UsageError(f"{group} needs a command: {', '.join(page.commands(app[group])) or 'none is there'}")
            command, bound, _ = app.parse_args(words)
            with at_most(_workers(bound)):
                code = command(*bound.args, **bound.kwargs)
        sys.stdout.flush()
        return code or 0
    except CycloptsError as error:
        return _failed(sentence(error), UsageError.exit_code)
    except CycloidError as error:
        return _failed(str(error), error.exit_code)
    except KeyboardInterrupt as stop:
        return _failed(f"stopped by {cause(stop)}", FAILURE)
    except BrokenPipeError:
        return FAILURE
    except OSError as error:
        file = f" {error.filename}" if error.filename else ""
        return _failed(f"cannot read or write{file}: {error.strerror or error}", FAILURE)
    except SystemExit as stop:
        # rich ends the program itself when a help page meets a closed pipe
        return stop.code if isinstance(stop.code, int) else FAILURE


def application() -> App:
    """Build the whole command line: every command, its flags and its help."""
    app = App(
        name="cycloid-mj",
        version=__version__,
        help=ABOUT,
        help_epilogue=EXAMPLES,
        help_format="plaintext",
        default_parameter=Parameter(negative=(), show_default=False),
        result_action="return_value",
        exit_on_error=False,
        print_error=False,
        suppress_keyboard_interrupt=False,
        console=page.console(),
    )
    for place, (command, examples) in enumerate(COMMANDS.items()):
        app.command(command, sort_key=place, help_epilogue=examples)
    _add_papers(app, place=list(COMMANDS).index(stress.stress) + 0.5)
    for place, group in enumerate((measure, design, log), start=len(COMMANDS)):
        app.command(group.commands(sort_key=place))
    app.register_install_completion_command(help="Make this shell complete commands and flags.")
    return page.flowing(app)


def _add_papers(app: App, place: float) -> None:
    """Add ``reproduce`` at a place: the command of the one paper that is installed, or a group of several."""
    installed = papers()
    if len(installed) == 1:
        app.command(installed[0].command, name="reproduce", sort_key=place, help_epilogue=installed[0].examples)
        return
    group = App(name="reproduce", help=ABOUT_PAPERS, sort_key=place)
    for paper in installed:
        group.command(paper.command, name=paper.key, help_epilogue=paper.examples)
    app.command(group)


def _renamed(word: str) -> str:
    """Return a word of the command line with the present name of a flag that was called otherwise."""
    flag, equals, value = word.partition("=")
    if (name := RENAMED.get(flag)) is None:
        return word
    tell(f"warning: {flag} is called {name} now")
    return f"{name}{equals}{value}"


def _workers(bound: BoundArguments) -> int | None:
    """Return what ``--workers`` says, if the command has that flag."""
    return next((value.workers for value in bound.arguments.values() if hasattr(value, "workers")), None)


def _group_alone(app: App, words: Sequence[str]) -> str:
    """Name the group of commands, such as ``measure``, that is asked for without any of its commands; else nothing."""
    chain, apps, rest = app.parse_commands(list(words))
    return chain[-1] if chain and not rest and apps[-1].default_command is None else ""


def _failed(message: str, code: int) -> int:
    with suppress(OSError):
        tell(f"error: {message}")
    return code
