"""Who may ask the page's server: a browser on this machine that opened the page by one of this machine's own names.

A server on 127.0.0.1 is reached by every page that the browser has open: one whose name is made to resolve to this
machine would be of the same origin (DNS rebinding), and websockets ask for no origin at all. The names give them away.
"""

from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any
from urllib.parse import urlsplit

NAMES = frozenset({"localhost", "127.0.0.1", "::1"})

REFUSED = b"This page is for the machine that serves it: open it as http://127.0.0.1 or http://localhost.\n"

Message = MutableMapping[str, Any]
Asked = Callable[[], Awaitable[Message]]
Answer = Callable[[Message], Awaitable[None]]


class LocalOnly:
    """ASGI middleware that answers HTTP and websockets of a local ``Host``, and of that origin, with the `app`.

    Anything else gets the status 403, before the `app` hears of it.
    """

    def __init__(self, app: Callable[[Message, Asked, Answer], Awaitable[None]]) -> None:
        self._app = app

    async def __call__(self, scope: Message, receive: Asked, send: Answer) -> None:
        """Pass on what is allowed."""
        if scope["type"] not in {"http", "websocket"} or allowed(scope["headers"]):
            await self._app(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
        else:
            headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"content-length", b"%d" % len(REFUSED))]
            await send({"type": "http.response.start", "status": 403, "headers": headers})
            await send({"type": "http.response.body", "body": REFUSED})


def allowed(headers: list[tuple[bytes, bytes]]) -> bool:
    """Tell whether a request has one ``Host``, a local one, and no other ``Origin``."""
    hosts, origins = (
        [value.decode("latin-1") for key, value in headers if key == name] for name in (b"host", b"origin")
    )
    if len(hosts) != 1 or _name(hosts[0]) not in NAMES:
        return False
    return all(origin.lower() == f"http://{hosts[0].lower()}" for origin in origins)


def _name(host: str) -> str | None:
    try:
        return urlsplit(f"//{host}").hostname
    except ValueError:
        return None
