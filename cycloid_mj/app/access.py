"""Access control of the page's server: local host names, a secret token, and the headers of every response.

A server on 127.0.0.1 can be reached by every user of the computer and by every page that a browser on it has open.
Three checks keep them out: the request names this computer as its host (against DNS rebinding), it comes from the
page's own origin (against requests forged by other pages), and it carries the secret of this server (against other
users). The secret is part of the printed address; a cookie replaces it after the first visit.
"""

import re
import secrets
from collections.abc import Sequence
from http import HTTPStatus

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from cycloid_mj.app.limits import LIMITS

LOCAL_HOST = re.compile(r"(localhost|127\.0\.0\.1|\[::1\])(:\d+)?", re.ASCII | re.IGNORECASE)
"""A ``Host`` header that names this computer, with or without a port."""

WRONG_HOST = "This page is served to this computer only. Open it as http://127.0.0.1 or http://localhost.\n"
NO_TOKEN = (
    "Open the address that `cycloid-mj app` printed in the terminal: it contains the access token of this page.\n"
)
LONG_PATH = f"The address is too long: {LIMITS.path_length} characters are allowed.\n"


def is_local(hosts: Sequence[str], origins: Sequence[str]) -> bool:
    """Return whether a request has exactly one ``Host``, a local one, and no foreign ``Origin``."""
    if len(hosts) != 1 or not LOCAL_HOST.fullmatch(hosts[0]):
        return False
    return all(origin.lower() == f"http://{hosts[0].lower()}" for origin in origins)


class AccessControl:
    """ASGI middleware that answers foreign requests itself and passes the others on.

    Parameters
    ----------
    inner
        The application behind it.
    token
        Secret that ``/?token=...`` or the cookie has to carry.
    """

    def __init__(self, inner: ASGIApp, token: str) -> None:
        self._inner, self._token = inner, token.encode()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle one request."""
        refusal = self._refuse_request(scope)
        await (refusal or self._inner)(scope, receive, _add_headers(send))

    def _refuse_request(self, scope: Scope) -> Response | None:
        """Return the response that refuses a request to the server from another host or origin, or without the token.

        `scope` describes the request (ASGI). Return None if the request is allowed.
        """
        headers = Headers(scope=scope)
        if len(scope["raw_path"]) + len(scope["query_string"]) > LIMITS.path_length:
            return PlainTextResponse(LONG_PATH, HTTPStatus.REQUEST_URI_TOO_LONG)
        if not is_local(headers.getlist("host"), headers.getlist("origin")):
            return PlainTextResponse(WRONG_HOST, HTTPStatus.FORBIDDEN)
        connection = HTTPConnection(scope)
        cookie = f"cycloid_mj_{scope['server'][1]}"  # browsers share cookies between the ports of one host
        if scope["path"] == "/" and self._matches(connection.query_params.get("token", "")):
            redirect = RedirectResponse("/", HTTPStatus.SEE_OTHER)  # keeps the secret out of address bar and history
            redirect.set_cookie(cookie, self._token.decode(), httponly=True, samesite="lax")
            return redirect
        if not self._matches(connection.cookies.get(cookie, "")):
            return PlainTextResponse(NO_TOKEN, HTTPStatus.FORBIDDEN)
        return None

    def _matches(self, text: str) -> bool:
        return secrets.compare_digest(text.encode(), self._token)


def _add_headers(send_message: Send) -> Send:
    """Return an ASGI function that adds the security headers of the page to a response and sends it by `send_message`.

    `send_message` is the function of ASGI that sends without them.
    """

    async def send_with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            headers["Cache-Control"] = "no-store"
            headers["Referrer-Policy"] = "no-referrer"
            headers["X-Content-Type-Options"] = "nosniff"
        await send_message(message)

    return send_with_headers
