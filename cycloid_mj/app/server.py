"""The page's server: Python's own, on this machine alone, for JSON questions, files and the page itself."""

import gc
import json
import logging
import sys
import threading
import traceback
import webbrowser
from collections.abc import Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib import resources
from typing import Any
from urllib.parse import quote, unquote

from cycloid_mj.app.answers import in_words
from cycloid_mj.app.asks import AT_ONCE, QUICK, SLOWER, loaded, long_work
from cycloid_mj.app.jobs import Jobs
from cycloid_mj.app.local import REFUSED, allowed
from cycloid_mj.app.made import FILES
from cycloid_mj.app.state import values_of
from cycloid_mj.app.workers import Workers
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.result import plain
from cycloid_mj.design import PRESETS, Design
from cycloid_mj.design.materials import MATERIALS
from cycloid_mj.sizing.process import PROCESSES

LARGEST = 1_000_000
"""Bytes of a question; a design file has some thousand."""

MOST_ASKED = 24
"""Questions at one time: more are refused, so that no page fills the memory."""

TYPES = {"html": "text/html", "css": "text/css", "js": "text/javascript", "svg": "image/svg+xml"}

_log = logging.getLogger(__name__)


class PageServer(ThreadingHTTPServer):
    """Serves one page, whose windows share processes; each window keeps its own design."""

    daemon_threads = True
    allow_reuse_address = True

    def __init__(self, design: Design, port: int, workers: Workers) -> None:
        super().__init__(("127.0.0.1", port), Handler)
        self.workers, self.jobs = workers, Jobs(workers.long)
        self.asked = threading.BoundedSemaphore(MOST_ASKED)
        self.start = start_values(design)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Tell what went wrong with a request, but not that its window has gone meanwhile."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)

    def ask(self, name: str, content: Mapping[str, Any]) -> Any:
        """Answer one question; errors as those of its work."""
        if name in AT_ONCE:
            return AT_ONCE[name](content)
        if name in QUICK:
            return self.workers.quick.do(QUICK[name], content)
        if name in SLOWER:
            return self.workers.slower.do(SLOWER[name], content)
        if name == "start":
            return self.start
        if name == "job":
            work, args = long_work(content)
            return self.jobs.start(work, *args).as_json()
        number = content.get("job")
        if name in ("look", "stop") and isinstance(number, int):
            return (self.jobs.get if name == "look" else self.jobs.stop)(number).as_json()
        raise KeyError(name)


class Handler(BaseHTTPRequestHandler):
    """One request."""

    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True  # else a body may wait 40 ms for the other side to acknowledge its headers
    server: PageServer

    def do_GET(self) -> None:
        """Send the page, one of its files, or what a job has made."""
        if not self._allowed():
            return
        place = unquote(self.path.partition("?")[0]).strip("/") or "index.html"
        kind, _, rest = place.partition("/")
        try:
            if kind in ("file", "report"):
                self._send_made(kind, rest)
            elif (content := _asset(place)) is not None:
                self._send(HTTPStatus.OK, content, TYPES[place.rpartition(".")[2]])
            else:
                self._send(HTTPStatus.NOT_FOUND, b"There is nothing here.\n", "text/plain")
        except CycloidError as error:
            self._send(HTTPStatus.NOT_FOUND, f"{error}\n".encode(), "text/plain")

    def do_POST(self) -> None:
        """Answer a question in JSON with JSON; what is refused is answered, too: a browser would log another status."""
        if not self._allowed():
            return
        length = self.headers.get("Content-Length", "")
        if not length.isdecimal() or int(length) > LARGEST:
            self.close_connection = True
            self._send_json(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, {"error": "the question is too long"})
            return
        body = self.rfile.read(int(length))
        if self.headers.get_content_type() != "application/json":
            self._send_json(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, {"error": "questions are JSON"})
            return
        if not self.server.asked.acquire(blocking=False):
            self._send_json(HTTPStatus.SERVICE_UNAVAILABLE, {"error": "too much is asked at once"})
            return
        try:
            content = json.loads(body)
            if not isinstance(content, dict):
                raise ValueError("an object is expected")
            self._send_json(HTTPStatus.OK, self.server.ask(self.path.strip("/").removeprefix("ask/"), content))
        except CycloidError as error:
            self._send_json(HTTPStatus.OK, {"refused": in_words(str(error).removeprefix("override: "))})
        except KeyError:
            self._send_json(HTTPStatus.NOT_FOUND, {"error": "nobody answers that"})
        except (ValueError, RecursionError) as error:
            self._send_json(HTTPStatus.BAD_REQUEST, {"error": f"no question in JSON: {error}"})
        except OSError:
            raise  # the window has gone
        except Exception as error:  # whatever goes wrong with one question, the page goes on
            *_, (frame, line) = traceback.walk_tb(error.__traceback__)
            reason = f"{type(error).__name__}: {error}"
            _log.error("error: %s (%s:%d)", reason, frame.f_code.co_filename, line)
            self._send_json(HTTPStatus.INTERNAL_SERVER_ERROR, {"error": reason})
        finally:
            self.server.asked.release()
            gc.collect()  # as the workers do

    def log_message(self, format: str, *args: Any) -> None:
        """Suppress the log of requests that succeed."""

    def _allowed(self) -> bool:
        """Refuse whoever did not open the page by a name of this machine."""
        hosts, origins = (self.headers.get_all(name) or [] for name in ("Host", "Origin"))
        if allowed(hosts, origins):
            return True
        self.close_connection = True
        self._send(HTTPStatus.FORBIDDEN, REFUSED.encode(), "text/plain")
        return False

    def _send_made(self, kind: str, rest: str) -> None:
        number, _, name = rest.partition("/")
        job = self.server.jobs.get(int(number) if number.isdecimal() else 0)
        if kind == "report" and job.page:
            self._send(HTTPStatus.OK, job.page.encode(), "text/html", "")
        elif name in job.files:
            self._send(HTTPStatus.OK, job.files[name], "application/octet-stream", name)
        else:
            self._send(HTTPStatus.NOT_FOUND, b"This is gone: make it again.\n", "text/plain")

    def _send_json(self, status: HTTPStatus, content: Any) -> None:
        self._send(status, json.dumps(plain(content), separators=(",", ":")).encode(), "application/json")

    def _send(self, status: HTTPStatus, body: bytes, kind: str, name: str | None = None) -> None:
        self.send_response(status)
        text = kind.startswith("text/") or kind == "application/json"
        self.send_header("Content-Type", f"{kind}; charset=utf-8" if text else kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Content-Type-Options", "nosniff")
        if name is None and kind == "text/html":
            self.send_header("Content-Security-Policy", "default-src 'self'; img-src 'self' data:; base-uri 'none'")
        if name:
            self.send_header("Content-Disposition", f"attachment; filename*=utf-8''{quote(name)}")
        self.end_headers()
        self.wfile.write(body)


def start_values(design: Design) -> dict[str, Any]:
    """Collect what the page begins with: the design, and what its start form offers, which opens without a design."""
    return {
        "design": values_of(loaded(design)),
        "fresh": design == PRESETS["pin"],
        "presets": list(PRESETS),
        "processes": {name: [limits.material, *limits.others] for name, limits in PROCESSES.items()},
        "materials": list(MATERIALS),
        "files": {kind: words for kind, (words, _) in FILES.items()},
    }


def serve(design: Design, port: int, show: bool) -> None:
    """Serve the page on this machine alone until the process is stopped; every window has a design of its own."""
    question = {"design": values_of(loaded(design))}
    slower = [(SLOWER[name], (question,)) for name in ("checks", "life")]
    workers = Workers([(work, (question,)) for work in QUICK.values()], slower)
    try:
        with PageServer(design, port, workers) as server:
            if show:
                threading.Timer(0.3, webbrowser.open, (f"http://127.0.0.1:{port}",)).start()
            gc.freeze()
            server.serve_forever()
    finally:
        workers.close()


def _asset(name: str) -> bytes | None:
    """Read one of the page's own files; nothing where there is none of that name."""
    stem, _, kind = name.rpartition(".")
    if kind not in TYPES or not stem.isidentifier():
        return None
    file = resources.files("cycloid_mj.app").joinpath("assets", name)
    return file.read_bytes() if file.is_file() else None
