"""Parallel work on many items: in threads or processes of this machine (joblib), or on a Dask cluster."""

from cycloid_mj.base.engine.engine import Engine, Progress, all_in_threads, at_most, each_in_threads, silent
from cycloid_mj.base.engine.packages import Versions, versions

__all__ = ["Engine", "Progress", "Versions", "all_in_threads", "at_most", "each_in_threads", "silent", "versions"]
