"""Base class of the tables of the design file."""

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

Offsets = tuple[Annotated[float, Field(ge=-1e-3, le=1e-3, allow_inf_nan=False)], ...]
"""A deviation [m] of each of some parts; empty: drawn at random."""


class Section(BaseModel):
    """Base class of the tables of the design file."""

    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=False)

    @classmethod
    def merge_change(cls, values: Mapping[str, Any], change: Mapping[str, Any]) -> dict[str, Any]:
        """Return the values of a table with some of them changed."""
        return {**values, **change}
