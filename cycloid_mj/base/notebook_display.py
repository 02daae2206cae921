"""Display of results in a notebook: a line of text, a table as HTML, a figure, and a data frame of pandas or polars."""

from html import escape
from importlib import import_module
from importlib.util import find_spec
from inspect import Parameter, Signature, getdoc, signature
from itertools import islice
from types import ModuleType
from typing import TYPE_CHECKING, Any

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.registry import get_provider
from cycloid_mj.base.text import four_digits

if TYPE_CHECKING:
    from cycloid_mj.base.frame import Frame

MOST_ROWS = 60
"""Largest number of rows of a table in a notebook."""


class Drawn:
    """A result that can be drawn."""

    def plot(self, name: str = "") -> Any:
        """Draw the result of a computation as a ``matplotlib`` figure; return the figure of that name, or the first.

        Raises
        ------
        UsageError
            The result has nothing to draw, or no figure of that name.
        """
        return get_provider("draw_result")(self, name)


class Presented(Drawn):
    """A result with a one-line description and a frame of its figures."""

    @property
    def frame(self) -> "Frame":
        """Table of the quantities of the result, a row each."""
        raise NotImplementedError

    @property
    def line(self) -> str:
        """Description and first quantities."""
        return f"{self.frame.rows} rows of {', '.join(islice(self.frame.columns, 6))}"

    def to_frame(self) -> Any:
        """Return the values as a ``DataFrame`` of pandas, or of polars; raise CycloidError if neither is installed."""
        package = next((name for name in ("pandas", "polars") if find_spec(name)), None)
        if package is None:
            raise CycloidError(
                "a data frame needs pandas or polars, and neither is installed: run pip install pandas, or use the "
                "arrays of .frame.columns"
            )
        return import_module(package).DataFrame({name: item.tolist() for name, item in self.frame.columns.items()})

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.line}>"

    def _repr_html_(self) -> str:
        columns = self.frame.columns
        header = "".join(f"<th>{escape(name)}</th>" for name in columns)
        rows = islice(zip(*(item.tolist() for item in columns.values()), strict=True), MOST_ROWS)
        body = "".join(f"<tr>{''.join(f'<td>{escape(_cell(cell))}</td>' for cell in row)}</tr>" for row in rows)
        note = f"<p>{self.frame.rows - MOST_ROWS} rows more</p>" if self.frame.rows > MOST_ROWS else ""
        return f"<p>{escape(self.line)}</p><table><thead><tr>{header}</tr></thead><tbody>{body}</tbody></table>{note}"


class CallableRoom(ModuleType):
    """A package that can be called: `cycloid_mj.statics` has the parts of the solver, and computes a sheet."""

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Call the function `main` of the package."""
        return self.main(*arguments, **named)

    @property
    def __signature__(self) -> Signature:
        """Signature of a call, for notebooks."""
        return signature(self.main)

    @property
    def __doc__(self) -> str:  # type: ignore[override]
        """Call and docstring of the function `main`, which `help` shows."""
        summary, _, details = (getdoc(self.main) or "").partition("\n\n")
        parameters = signature(self.main).parameters.values()
        parameter_list = ", ".join(str(parameter.replace(annotation=Parameter.empty)) for parameter in parameters)
        return f"{summary}\n\nCall: cm.{self.__name__.rpartition('.')[2]}({parameter_list})\n\n{details}"

    def __dir__(self) -> list[str]:
        """List its public names alone, for completion."""
        return sorted(self.__all__)


def _cell(value: object) -> str:
    if isinstance(value, float):
        return "" if value != value else four_digits(value)
    return str(value)
