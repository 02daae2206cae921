"""Who may ask the page's server: a browser on this machine that opened the page by one of this machine's own names.

A server on 127.0.0.1 is reached by every page that the browser has open: one whose name is made to resolve to this
machine would be of the same origin (DNS rebinding). The names give it away.
"""

import re
from collections.abc import Sequence

LOCAL = re.compile(r"(localhost|127\.0\.0\.1|\[::1\])(:\d+)?", re.ASCII | re.IGNORECASE)
"""A ``Host`` of this machine, with or without its port."""

REFUSED = "This page is for the machine that serves it: open it as http://127.0.0.1 or http://localhost.\n"


def allowed(hosts: Sequence[str], origins: Sequence[str]) -> bool:
    """Tell whether a request has one ``Host``, a local one, and no other ``Origin``."""
    if len(hosts) != 1 or not LOCAL.fullmatch(hosts[0]):
        return False
    return all(origin.lower() == f"http://{hosts[0].lower()}" for origin in origins)
