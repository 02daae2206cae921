"""The command line: its list of commands, and its errors on stderr.

Exit codes: 0 success; 1 a failed design, run, log or file; 2 a wrong name, flag or value; 130, 143 and 129 after
Ctrl-C, SIGTERM and SIGHUP.
"""

import sys
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from inspect import BoundArguments
from typing import TYPE_CHECKING

from cyclopts import App, CoercionError, CycloptsError, Group

from cycloid_mj.base.engine import at_most
from cycloid_mj.base.errors import CycloidError, UsageError, reason, warn
from cycloid_mj.base.interrupt import exit_code, signal_name
from cycloid_mj.base.overwrite_guard import command_scope
from cycloid_mj.base.version import __version__
from cycloid_mj.cli import page
from cycloid_mj.cli.completion import CompletingApp
from cycloid_mj.cli.contents import GROUPS, INSTALLATION_GROUP, PAPER_AND_LOG
from cycloid_mj.cli.terminal import collect_warnings, log_to_stderr, tell, tell_error
from cycloid_mj.cli.validation_errors import correct_case, describe_error

if TYPE_CHECKING:
    from cycloid_mj.papers import Paper


ABOUT = """Design and simulate cycloidal speed reducers.

Results are printed on stdout, progress and messages on stderr. Exit code: 0 success,
1 failure, 2 wrong usage. `cycloid-mj COMMAND --help` explains a command.
"""

EXAMPLES = """Examples:
  cycloid-mj simulate --design pin    # simulate a published reducer
  cycloid-mj design new my            # write a design file: my.toml
  cycloid-mj statics my.toml          # compute its main figures
  cycloid-mj app --design my.toml     # edit it in the browser"""

ABOUT_PAPERS = """Reproduce a published paper and evaluate its claims.

Papers are separate packages, registered as entry points of the group cycloid_mj.papers.
"""

ABOUT_COMPLETION = "Install completion of commands, flags and files for this shell."

REPRODUCE, COMPLETION = "reproduce", "--install-completion"
RENAMED = {"--jobs": "--workers"}
FOLDED = {"profile": ("design", "profile"), "kinematics": ("design", "kinematics"), "plot": ("log", "plot")}
"""Commands of groups that scripts call by their name alone."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command, by default that of ``sys.argv``, and return its exit code.

    No error is raised: a message is printed on stderr. The exit code is 2 for wrong usage, 1 for a failure or a closed
    pipe, and 128 plus the number of the signal after Ctrl-C or another signal.
    """
    words = _replace_old_command([_rename_flag(word) for word in (sys.argv[1:] if argv is None else argv)])
    try:
        quiet = "--quiet" in words
        with command_scope(), collect_warnings(None if quiet else tell), log_to_stderr(quiet):
            app = application(words[:1])
            if group := _group_alone(app, words):
                app.help_print(words, console=page.console(stderr=True))
                command_texts = ", ".join(page.commands(app[group]))
                if not command_texts:
                    raise UsageError(
                        f"{group} has no commands: install a package that provides one, as described above"
                    )
                raise UsageError(f"{group} needs a command: choose one of {command_texts}")
            command, bound_arguments = parse(app, words)
            workers = next(
                (value.workers for value in bound_arguments.arguments.values() if hasattr(value, "workers")), None
            )
            with at_most(workers):
                code = command(*bound_arguments.args, **bound_arguments.kwargs)
        sys.stdout.flush()
        return code or 0
    except CycloptsError as error:
        return _report_failure(describe_error(error), UsageError.exit_code)
    except CycloidError as error:
        with suppress(OSError):
            tell_error(error)
        return exit_code(error.__cause__) if isinstance(error.__cause__, KeyboardInterrupt) else error.exit_code
    except KeyboardInterrupt as stop:
        return _report_failure(f"stopped by {signal_name(stop)}", exit_code(stop))
    except BrokenPipeError:
        return 1
    except OSError as error:
        file = f" {error.filename}" if error.filename else ""
        return _report_failure(f"cannot read or write{file}: {reason(error)}", 1)
    except SystemExit as stop:
        # rich ends the program itself when a help page is written to a closed pipe
        return stop.code if isinstance(stop.code, int) else 1


def application(names: Collection[str] | None = None) -> App:
    """Build the command line, with flags and help of all commands or only of the commands `names`.

    The other commands are listed by name only. Their modules are not imported, so that help is fast.
    """
    app = CompletingApp(
        name="cycloid-mj",
        version=__version__,
        help=page.paragraphs(ABOUT),
        help_epilogue=EXAMPLES,
        help_format="plaintext",
        default_parameter=page.FLAGS,
        result_action="return_value",
        exit_on_error=False,
        print_error=False,
        suppress_keyboard_interrupt=False,
        console=page.console(),
    )
    has_all_commands = names is None or COMPLETION in names
    for order, (title, commands) in enumerate(GROUPS.items()):
        group = Group(title, sort_key=order)
        if title == PAPER_AND_LOG:
            _add_papers(app, group, has_all_commands or REPRODUCE in (names or ()))
        for position, (name, command) in enumerate(commands.items(), start=1):
            register = command.add_to if has_all_commands or name in (names or ()) else command.list_in
            register(app, name, group, position)
        if title == INSTALLATION_GROUP:
            for flag in (*app.help_flags, *app.version_flags):
                app[flag].group = group
            app.register_install_completion_command(help=ABOUT_COMPLETION, group=group)
    return app


def _add_papers(app: App, group: Group, imported: bool) -> None:
    """Add the command ``reproduce``, which the installed packages of papers provide.

    If a single such package is installed, ``reproduce`` is its command, otherwise a group with a command for each.
    Without `imported`, only the name ``reproduce`` is added, and no package is imported.
    """
    installed_papers: Sequence[Paper] = ()
    if imported:
        from cycloid_mj.papers import papers

        installed_papers = [paper for paper in papers() if _has_command(paper)]
    if len(installed_papers) == 1:
        command, examples = installed_papers[0].command, installed_papers[0].examples
        app.command(command, name=REPRODUCE, group=group, sort_key=0, help_epilogue=examples)
    else:
        papers_app = CompletingApp(name=REPRODUCE, help=ABOUT_PAPERS, group=group, sort_key=0)
        for paper in installed_papers:
            papers_app.command(paper.command, name=paper.key, help_epilogue=paper.examples)
        app.command(papers_app)
    if imported:
        page.set_help_format(app[REPRODUCE])


def parse(app: App, words: list[str]) -> tuple[Callable[..., int], BoundArguments]:
    """Parse a command line; return the function of the command and its arguments.

    Words of a fixed set, such as a solver's name, may be in capital or small letters: they are corrected.

    Raises
    ------
    CycloptsError
        The command line is not valid.
    """
    while True:
        try:
            command, bound_arguments, _ = app.parse_args(words)
            return command, bound_arguments
        except CoercionError as error:
            corrected_words = correct_case(error, words)
            if corrected_words is None:
                raise
            words = corrected_words


def _has_command(paper: "Paper") -> bool:
    """Return whether the function of a paper package can become a command with flags; warn if it cannot.

    The function builds the command. Any exception means that it cannot, because papers are packages of other authors.
    """
    trial_app = App()
    try:
        trial_app.command(paper.command, name=REPRODUCE, help_epilogue=paper.examples)
        page.set_help_format(trial_app[REPRODUCE]).assemble_argument_collection()
    except Exception as problem:
        warn(
            f"paper {paper.key}",
            [f"ignored: its command {paper.command!r} cannot be read as a command with flags ({problem})"],
        )
        return False
    return True


def _replace_old_command(words: list[str]) -> list[str]:
    """Replace a deprecated command name at the start of a command line by its new group and name, and warn of it.

    `words` are returned unchanged if they do not start with such a name.
    """
    if not words or (new_name := FOLDED.get(words[0])) is None:
        return words
    tell(
        f"warning: the command `{words[0]}` is deprecated: use `{' '.join(new_name)}`; the old name will be removed in "
        "the next release"
    )
    return [*new_name, *words[1:]]


def _rename_flag(word: str) -> str:
    """Replace a deprecated flag in a word of the command line by its new name, and warn; return the word."""
    flag, equals, value = word.partition("=")
    if (name := RENAMED.get(flag)) is None:
        return word
    tell(f"warning: the flag {flag} is deprecated: use {name}; the old name will be removed in the next release")
    return f"{name}{equals}{value}"


def _group_alone(app: App, words: Sequence[str]) -> str:
    """Return the group of commands that is called without a command, such as ``measure``; else an empty text."""
    names, apps, unparsed = app.parse_commands(list(words))
    return names[-1] if names and not unparsed and apps[-1].default_command is None else ""


def _report_failure(message: str, code: int) -> int:
    with suppress(OSError):
        tell(f"error: {message}")
    return code
