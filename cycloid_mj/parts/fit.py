"""Errors of designs whose parts do not fit into each other, with the keys of the design file."""

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design.units import MILLIMETRE


def require_above(key: str, value: float, bound: float, otherwise: str) -> None:
    """Raise DesignError unless the length ``key`` is more than the bound [m], or else ``otherwise``."""
    if not value > bound:
        raise too_small(key, value, bound, otherwise)


def require_below(key: str, value: float, bound: float, otherwise: str) -> None:
    """Raise DesignError unless the length ``key`` is less than the bound [m], or else ``otherwise``."""
    if not value < bound:
        raise _misfit(key, value, f"less than {_millimetres(bound)}", otherwise)


def too_small(key: str, value: float, bound: float, otherwise: str) -> DesignError:
    """Return the error of a length ``key`` that must be more than the bound [m], or else ``otherwise``."""
    return _misfit(key, value, f"more than {_millimetres(bound)}", otherwise)


def _misfit(key: str, value: float, allowed: str, otherwise: str) -> DesignError:
    return DesignError(
        f"{key}_{MILLIMETRE.suffix} = {_millimetres(value)} is not allowed: make it {allowed}, or {otherwise}"
    )


def _millimetres(length: float) -> str:
    return f"{MILLIMETRE.from_si(length):.9g}"
