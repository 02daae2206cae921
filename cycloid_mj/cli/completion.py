"""Shell completion: the scripts of cyclopts, which complete commands and flags, extended to file names."""

import re
from typing import Literal

from cyclopts import App

Shell = Literal["zsh", "bash", "fish", "powershell"]

ZSH_WITHOUT_ACTION = re.compile(r"^(\s+'(?:\*?--[\w-]+\[.*\]:[\w-]+|\d+:(?:[^:']|\\:|'\\'')*))(' ?\\?)$", re.MULTILINE)
"""A flag with a value, or an argument by position, that a script for zsh completes by nothing."""


class CompletingApp(App):
    """A command line whose completion scripts fall back to the names of files."""

    def generate_completion(self, *, prog_name: str | None = None, shell: Shell | None = None) -> str:
        """Return the completion script for a shell, by default the one that runs this process."""
        return complete_files(super().generate_completion(prog_name=prog_name, shell=shell))


def complete_files(script: str) -> str:
    """Return a shell completion `script`, changed to suggest file names where a command has no other candidates.

    Scripts for bash and zsh are changed; fish and PowerShell suggest file names by themselves.
    """
    if script.startswith("#compdef"):
        return ZSH_WITHOUT_ACTION.sub(r"\1:_files\2", script)
    return re.sub(r"^complete -F ", "complete -o bashdefault -o default -F ", script, flags=re.MULTILINE)
