"""Limits of the page: they bound what any client can make the server compute, store, open or wait for."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ServerLimits:
    """Limits of the page's server."""

    path_length: int = 2000
    """Characters of a path and its query; the page's own paths have fewer than 200."""
    body_bytes: int = 1_000_000
    """Bytes of a request; a design file has some thousand."""
    requests: int = 24
    """Requests being answered at the same time; further requests are refused, so that no page fills the memory."""
    backlog: int = 256
    """Connections that wait in the kernel to be accepted."""
    connections: int = 256
    """Open connections. A browser uses six; each costs one of the 1024 file descriptors a process usually has."""
    timeout_s: float = 30.0
    """Time for a request to arrive completely, for a connection to stay idle, and for a response to make progress."""
    close_delay_s: float = 2.0
    """Longest wait for the client to close after a refusal; data received meanwhile is discarded. Closing at once would
    reset the connection before the client has read the refusal."""


LIMITS = ServerLimits()


@dataclass(frozen=True)
class RequestLimits:
    """Ranges of the values in the page's requests, and numbers of jobs."""

    magnification: float = 1000.0
    """Largest factor by which the page draws clearances."""
    turn: int = 1000
    """Highest number of a crank turn whose forces the page requests."""
    matches: int = 30
    """Most parameters that a search shows."""
    offset_um: float = 500.0
    """Largest printer offset [um]."""
    queued_jobs: int = 6
    """Jobs that may be queued; more are refused."""
    finished_jobs: int = 40
    """Finished and stopped jobs whose results are kept, the latest."""


REQUESTS = RequestLimits()
