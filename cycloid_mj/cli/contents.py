"""The table of contents of the command line: every command in its group, with the line that the list of all shows.

The line is the first of the command's docstring; it stands here too, so that the list imports no command.
"""

from collections.abc import Mapping
from importlib import import_module
from typing import NamedTuple

from cyclopts import App, Group

from cycloid_mj.cli.page import flowing


class Listed(NamedTuple):
    """A command in the list: its line, and where in `cycloid_mj.cli` its function and the examples of its help are.

    A function `commands` makes a group of commands with a name of its own.
    """

    line: str
    function: str
    examples: str = "EXAMPLES"

    def add_to(self, app: App, name: str, group: Group, place: int) -> None:
        """Import the command, and add it with its help."""
        module_name, _, function_name = self.function.partition(":")
        module = import_module(f"cycloid_mj.cli.{module_name}")
        function = getattr(module, function_name)
        if function_name == "commands":
            function = function(place)
            function.group = group
            app.command(function)
        else:
            examples = getattr(module, self.examples)
            app.command(function, name=name, group=group, sort_key=place, help_epilogue=examples)
        flowing(app[name])

    def list_in(self, app: App, name: str, group: Group, place: int) -> None:
        """Add the command's name and line, which import nothing."""
        app.command(f"cycloid_mj.cli.{self.function}", name=name, group=group, sort_key=place, help=self.line)


BEGIN = "Begin with"
PAPER_AND_LOG = "Paper and log"
HERE = "This installation"

GROUPS: Mapping[str, Mapping[str, Listed]] = {
    BEGIN: {
        "design": Listed("Make a design file, print one, or check one.", "design:commands"),
        "statics": Listed("Compute what a data sheet has of a reducer, in a second.", "statics:statics"),
        "simulate": Listed("Run a design, log it, and compare the run with the closed form.", "simulate:simulate"),
        "report": Listed("Write the review of one or more logged runs as one HTML page.", "review:report"),
        "app": Listed("Design a drive on a page in the browser.", "serve:app"),
    },
    "Design": {
        "figures": Listed("List the figures that commands print, limit and vary, by key.", "figures:figures"),
        "rate": Listed("Rate life, fatigue, wear and heat, the weakest item first.", "rate:rate"),
        "datasheet": Listed("Write a data sheet, as makers of reducers do: PDF and HTML.", "datasheet:datasheet"),
    },
    "Analyse": {
        "measure": Listed("Measure one figure by simulation, with its error and its closed form.", "measure:commands"),
        "protocol": Listed("Tell what makers state of a reducer, from model and bench.", "protocol:protocol"),
        "stress": Listed("Compute the stress of the parts by finite elements.", "stress:stress"),
        "compare": Listed("Run designs at no load and under load, side by side.", "compare:compare"),
        "validate": Listed(
            "Compare the simulation with closed forms, independent solvers and published cases.", "validate:validate"
        ),
    },
    "Simulate": {
        "analyze": Listed("Compare a logged run with the closed form.", "analyze:analyze"),
        "animate": Listed("Draw a logged run in motion, with forces and loads.", "animate:animate"),
        "render": Listed("Render a moment of a logged run with MuJoCo.", "render:render"),
        "view": Listed("Open MuJoCo's viewer on a design, or replay a log there.", "view:view"),
    },
    "Explore": {
        "sweep": Listed("Evaluate a design over a grid, a sample or a table of parameter values.", "sweep:sweep"),
        "tolerance": Listed("Draw samples within the tolerances: yield and error budget.", "tolerance:tolerance"),
        "optimize": Listed(
            "Find the best design within ranges, or a Pareto front of two objectives.", "optimize:optimize"
        ),
    },
    "Make": {
        "export": Listed("Write every part of a design for CAD or printing.", "export:export"),
        "build": Listed("Make a model folder that any MuJoCo opens: DIR/scene.xml.", "build:build"),
    },
    "Robot": {
        "reduce": Listed("Reduce a reducer to one joint for a robot's model.", "reduce:reduce"),
        "calibrate": Listed("Fit clearances, stiffness and friction to measured loops.", "bench:calibrate"),
        "compare-bench": Listed(
            "Hold a measured transmission error against a design.", "bench:compare_bench", "TE_EXAMPLES"
        ),
    },
    PAPER_AND_LOG: {
        "log": Listed("Tell what is in a log, get it out, or make a cut log whole.", "log:commands"),
    },
    HERE: {"doctor": Listed("Look at this installation, and test it.", "doctor:doctor")},
}
"""Group -> name -> command, in the order of the list; the paper's own command comes first in its group."""
