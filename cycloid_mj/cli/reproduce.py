"""``cycloid-mj reproduce``: the command of the paper that is installed, or a group of such where there are several."""

from cyclopts import App

from cycloid_mj.papers import GROUP, papers

ABOUT = f"""Run a published paper again and judge its claims.

Papers are packages of their own, found by entry points of the group {GROUP}.
"""


def add(app: App, place: float) -> None:
    """Add the command to the table of contents at a place."""
    installed = papers()
    if len(installed) == 1:
        app.command(installed[0].command, name="reproduce", sort_key=place, help_epilogue=installed[0].examples)
        return
    group = App(name="reproduce", help=ABOUT, sort_key=place)
    for paper in installed:
        group.command(paper.command, name=paper.key, help_epilogue=paper.examples)
    app.command(group)
