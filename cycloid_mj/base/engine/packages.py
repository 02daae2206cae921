"""Versions of the packages that affect figures; results of different versions must not be mixed."""

import platform
from functools import cache

from cycloid_mj.base.errors import RunError
from cycloid_mj.base.version import __version__

PACKAGES = ("mujoco", "numpy", "scipy", "numba")
"""Packages whose code a figure passes through."""

Versions = tuple[tuple[str, str], ...]
"""Name and version of Python, this package and each of `PACKAGES`."""


@cache
def versions() -> Versions:
    """Return the versions of this process."""
    from importlib.metadata import version  # 10 ms, which not every command needs

    local = (("python", platform.python_version()), ("cycloid_mj", __version__))
    return local + tuple((name, version(name)) for name in PACKAGES)


def require_same_versions(worker_versions: Versions, worker: str) -> None:
    """Raise RunError, naming the `worker`, if it has other versions of the packages than this process."""
    local_versions, worker_versions_by_name = dict(versions()), dict(worker_versions)
    differing = [
        f"{name} is {worker_versions_by_name.get(name, 'missing')} there and {local_versions.get(name, 'missing')} here"
        for name in local_versions | worker_versions_by_name
        if local_versions.get(name) != worker_versions_by_name.get(name)
    ]
    if differing:
        raise RunError(
            f"{worker} has different package versions from this computer: {'; '.join(differing)}. Install the same "
            "versions on all machines, because results depend on them"
        )
