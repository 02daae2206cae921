"""The table of contents of the command line: every command in its group, with the line that the list of all shows.

The line is the first of the command's docstring; it stands here too, so that the list imports no command.
"""

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import NamedTuple

from cyclopts import App, Group

from cycloid_mj.cli.page import set_help_format


class Listed(NamedTuple):
    """A command in the list: its line, and where in `cycloid_mj.cli` its function and the examples of its help are.

    A function `commands` makes a group of commands with a name of its own.
    """

    line: str
    function: str
    examples: str = "EXAMPLES"

    def add_to(self, app: App, name: str, group: Group, position: int) -> None:
        """Import the function of this command, and add it with its flags and help to the app `app`.

        The attribute `function` has the form "module:function". If the function is named "commands", it builds a group
        of commands. `name` is the name of the command, `position` its place in its `group` of the help.
        """
        module_name, _, function_name = self.function.partition(":")
        module = import_module(f"cycloid_mj.cli.{module_name}")
        function = getattr(module, function_name)
        if function_name == "commands":
            function = function(position)
            function.group = group
            app.command(function)
        else:
            examples = getattr(module, self.examples)
            app.command(function, name=name, group=group, sort_key=position, help_epilogue=examples)
        set_help_format(app[name])

    def list_in(self, app: App, name: str, group: Group, position: int) -> None:
        """Add the name and the help line of the command to a group of the app, without importing its module."""
        app.command(f"cycloid_mj.cli.{self.function}", name=name, group=group, sort_key=position, help=self.line)


START_GROUP = "Start with"
PAPER_AND_LOG = "Paper and logs"
INSTALLATION_GROUP = "Installation"

GROUPS: Mapping[str, Mapping[str, Listed]] = {
    START_GROUP: {
        "design": Listed("Create, print and check design files.", "design:commands"),
        "statics": Listed(
            "Compute data-sheet figures without a simulation, in a second.",
            "statics:statics",
        ),
        "simulate": Listed("Simulate a design, log the run, and compare it with theory.", "simulate:simulate"),
        "report": Listed("Write an HTML report of one or more logged runs.", "review:report"),
        "app": Listed("Open the browser app: from requirements to a finished design.", "serve:app"),
    },
    "Design": {
        "figures": Listed("List all quantities that commands print, limit and vary, by key.", "figures:figures"),
        "rate": Listed("Rate life, fatigue, wear and heat, the weakest item first.", "rate:rate"),
        "thermal": Listed("Compute temperatures, warm-up and thermal limits of a drive.", "thermal:thermal"),
        "wear": Listed("Compute the wear of a drive over its running hours, and its accuracy life.", "wear:wear"),
        "datasheet": Listed("Write a manufacturer-style data sheet as PDF and HTML.", "datasheet:datasheet"),
    },
    "Analyse": {
        "measure": Listed(
            "Measure one figure by simulation, with its numerical error and closed form.", "measure:commands"
        ),
        "protocol": Listed("Evaluate standard test figures of the model and of measurements.", "protocol:protocol"),
        "stress": Listed("Compute the stress of the parts by finite elements.", "stress:stress"),
        "compare": Listed("Compare designs in simulations without load and under load.", "compare:compare"),
        "validate": Listed("Compare the simulation with closed forms and published cases.", "validate:validate"),
    },
    "Simulate": {
        "analyze": Listed("Compare a logged run with closed-form results.", "analyze:analyze"),
        "animate": Listed("Draw an animation of a logged run with forces and loads.", "animate:animate"),
        "render": Listed("Render an image of a logged run with MuJoCo.", "render:render"),
        "view": Listed("Open the MuJoCo viewer with a design, or replay a log in it.", "view:view"),
    },
    "Explore": {
        "sweep": Listed("Evaluate a design over a grid, a sample or a table of parameter values.", "sweep:sweep"),
        "tolerance": Listed(
            "Estimate yield and error budget from random samples within the tolerances.", "tolerance:tolerance"
        ),
        "optimize": Listed("Find the best design within ranges, or a Pareto front.", "optimize:optimize"),
    },
    "Manufacture": {
        "export": Listed("Write the parts of a design for CAD or 3-D printing.", "export:export"),
        "build": Listed("Write a model folder for any MuJoCo installation: DIR/scene.xml.", "build:build"),
    },
    "Robot": {
        "reduce": Listed("Reduce a drive to one joint for a robot model.", "reduce:reduce"),
        "calibrate": Listed("Fit clearances, stiffness and friction to measured loops.", "bench:calibrate"),
        "compare-bench": Listed(
            "Compare a measured transmission error with the model.", "bench:compare_bench", "TE_EXAMPLES"
        ),
    },
    PAPER_AND_LOG: {
        "log": Listed("Inspect, convert and repair logs.", "log:commands"),
    },
    INSTALLATION_GROUP: {"doctor": Listed("Check the installation and report missing components.", "doctor:doctor")},
}
"""Group -> name -> command, in the order of the list; the paper's own command comes first in its group."""

PYTHON: Mapping[str, Sequence[str]] = {
    "design": ("load", "check", "new"),
    "statics": ("statics",),
    "simulate": ("simulate",),
    "report": ("report",),
    "figures": ("FIGURES",),
    "rate": ("rate",),
    "thermal": ("thermal",),
    "wear": ("wear",),
    "datasheet": ("datasheet",),
    "measure": ("measure",),
    "protocol": ("protocol",),
    "stress": ("stress",),
    "compare": ("compare",),
    "validate": ("validate",),
    "analyze": ("analyze",),
    "animate": ("animate",),
    "render": ("render",),
    "sweep": ("sweep",),
    "tolerance": ("tolerance",),
    "optimize": ("optimize",),
    "export": ("export",),
    "build": ("build",),
    "reduce": ("reduce", "attach_reducer"),
    "calibrate": ("calibrate", "read_loop"),
    "compare-bench": ("compare_bench", "read_te"),
    "log": ("read_log", "write_log"),
}
"""Command -> names of `cycloid_mj` that do the same in Python."""

WITHOUT_PYTHON = {"app", "view", "doctor"}
"""Commands that open a window, or check the installation."""
