"""The page's server: starlette and uvicorn, on this computer only, for JSON requests, files and the page itself."""

import gc
import json
import logging
import secrets
import socket
import threading
import traceback
import webbrowser
from collections.abc import Mapping
from http import HTTPStatus
from importlib import resources
from typing import Any
from urllib.parse import quote

import uvicorn
from anyio.to_thread import run_sync
from starlette.applications import Starlette
from starlette.requests import ClientDisconnect, Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp

from cycloid_mj.app.access import AccessControl
from cycloid_mj.app.api import AT_ONCE, QUICK, SLOWER, create_job, with_load
from cycloid_mj.app.artifacts import FILES, load_exports
from cycloid_mj.app.connections import LimitedConnection
from cycloid_mj.app.drive import BEDS, MOTOR_WORDS
from cycloid_mj.app.jobs import InProcess, Jobs
from cycloid_mj.app.limits import LIMITS
from cycloid_mj.app.requirement import load_search
from cycloid_mj.app.state import BASES, changed_values
from cycloid_mj.app.summary import sentence_in_words
from cycloid_mj.app.workers import Workers
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.result import to_json_values
from cycloid_mj.design import PRESETS, Design
from cycloid_mj.design.materials import MATERIALS
from cycloid_mj.design.processes import PROCESSES, ProcessLimits
from cycloid_mj.life.heat import COOLING
from cycloid_mj.sizing.rv import DUTY_SHARE

CONTENT_SECURITY_POLICY = "default-src 'self'; img-src 'self' data:; base-uri 'none'; frame-ancestors 'none'"

MEDIA_TYPES = {"html": "text/html", "css": "text/css", "js": "text/javascript", "svg": "image/svg+xml"}

_log = logging.getLogger(__name__)


class Page:
    """The state that all windows of the page share: worker processes, jobs and the start values.

    The design itself is kept by each window.
    """

    def __init__(self, design: Design, workers: Workers) -> None:
        self.workers = workers
        self.jobs = Jobs({"studies": workers.long, "files": workers.files, "at once": InProcess()})
        self.slots = threading.BoundedSemaphore(LIMITS.requests)
        self.start = start_values(design)

    def answer(self, name: str, content: Mapping[str, Any]) -> Any:
        """Answer a request of the page: at once, in a worker process, or by starting a job.

        Parameters
        ----------
        name
            Name of the request.
        content
            The JSON object that the page sends with it.

        Raises
        ------
        KeyError
            There is no request of that name.
        CycloidError
            The request is refused, or its computation failed.
        """
        if name in AT_ONCE:
            return AT_ONCE[name](content)
        if name in QUICK:
            return self.workers.quick.do(QUICK[name], content)
        if name in SLOWER:
            return self.workers.slower.do(SLOWER[name], content)
        if name == "start":
            return self.start
        if name == "job":
            job = create_job(content)
            return self.jobs.describe(self.jobs.start(job.queue, job.name, job.work, *job.args))
        number = content.get("job")
        if name in ("status", "stop") and isinstance(number, int):
            return self.jobs.describe((self.jobs.get if name == "status" else self.jobs.stop)(number))
        raise KeyError(name)


def application(page: Page, token: str) -> ASGIApp:
    """Create the ASGI application of a page; clients need the secret `token` to use it.

    It serves the assets of the page, its requests, and the files and reports of jobs.
    """
    assets = _read_assets()

    async def send_asset(request: Request) -> Response:
        name = request.path_params.get("name", "index.html")
        if name not in assets:
            return PlainTextResponse("There is no such page.\n", HTTPStatus.NOT_FOUND)
        return _media_response(assets[name], MEDIA_TYPES[name.rpartition(".")[2]])

    async def send_report(request: Request) -> Response:
        report = page.jobs.get(_job_number(request)).page
        return Response(report, media_type="text/html") if report else _file_missing()

    async def send_file(request: Request) -> Response:
        """Send a file that a background job has created to the browser as a download; status 404 if there is none.

        `request` names the job and the file.
        """
        name = request.path_params["name"]
        files = page.jobs.get(_job_number(request)).files
        if name not in files:
            return _file_missing()
        disposition = {"Content-Disposition": f"attachment; filename*=utf-8''{quote(name)}"}
        return Response(files[name], media_type="application/octet-stream", headers=disposition)

    async def answer_request(request: Request) -> Response:
        """Answer a request in a thread; refuse it with an error status if it is too long, not JSON, or one too many."""
        try:
            body = await _read_body(request)
        except ClientDisconnect:
            return Response(status_code=HTTPStatus.REQUEST_TIMEOUT)
        if body is None:
            return _error_response(
                HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
                f"the request is too large: at most {LIMITS.body_bytes} bytes are allowed",
            )
        if request.headers.get("content-type", "").partition(";")[0].strip().lower() != "application/json":
            return _error_response(
                HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "the content type of a request must be application/json"
            )
        if not page.slots.acquire(blocking=False):
            return _error_response(
                HTTPStatus.SERVICE_UNAVAILABLE, "too many requests at the same time: try again in a moment"
            )
        return await run_sync(_answer_request, page, request.path_params["name"], body, abandon_on_cancel=True)

    routes = [
        Route("/", send_asset),
        Route("/ask/{name}", answer_request, methods=["POST"]),
        Route("/file/{job}/{name}", send_file),
        Route("/report/{job}", send_report),
        Route("/{name}", send_asset),
    ]
    handlers = {CycloidError: _missing_job_response, Exception: _failure_response}
    return AccessControl(Starlette(routes=routes, exception_handlers=handlers), token)


def start_values(design: Design) -> dict[str, Any]:
    """Return what the page shows first, as JSON values: the design, and the choices of its start form and menus.

    ``design`` has the values in which the design differs from its preset; ``fresh`` is true for the preset ``pin``. The
    choices are ``presets``, ``processes`` (`process_defaults` by name), ``materials``, ``files``, ``motors``, ``beds``
    and ``cooling``; ``rv`` has the defaults of an RV reducer.
    """
    return {
        "design": changed_values(with_load(design)),
        "fresh": design == PRESETS["pin"],
        "presets": list(PRESETS),
        "processes": {name: process_defaults(limits) for name, limits in PROCESSES.items()},
        "materials": list(MATERIALS),
        "files": {kind: words for kind, (words, _) in FILES.items()},
        "motors": MOTOR_WORDS,
        "beds": BEDS,
        "cooling": list(COOLING),
        "rv": rv_defaults(),
    }


def rv_defaults() -> dict[str, Any]:
    """Return the usual values of an RV reducer, by the fields of `process_defaults`; its speed follows its ratio."""
    defaults = process_defaults(PROCESSES["steel"])
    material = BASES["rv"].material.name
    return {**defaults, "material": material, "speed_rpm": None, "duty_percent": 100.0 * DUTY_SHARE}


def process_defaults(limits: ProcessLimits) -> dict[str, Any]:
    """Return the usual values of a manufacturing process with some `limits`, by the fields of the start form.

    These are ``material``, ``life_h``, ``speed_rpm`` of the crank, and ``duty_percent``, the share of the time under
    load.
    """
    return {
        "material": limits.material,
        "life_h": limits.life_h,
        "speed_rpm": limits.speed_rpm,
        "duty_percent": 100.0 * limits.duty_share,
    }


def new_token() -> str:
    """Return a new secret for the address of a page."""
    return secrets.token_urlsafe(24)


def open_socket(port: int) -> socket.socket:
    """Return a socket that listens on a port of this computer; port 0 selects any free port.

    Raises
    ------
    CycloidError
        The port is in use, or this user may not listen on it.
    """
    listener = socket.socket()
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind(("127.0.0.1", port))
    except OSError as error:
        listener.close()
        raise CycloidError(
            f"port {port} of this computer is in use or not permitted: choose another port from 1024 to 65535 with "
            "--port"
        ) from error
    listener.listen(LIMITS.backlog)
    return listener


def create_server(app: ASGIApp, connection: type[LimitedConnection] = LimitedConnection) -> uvicorn.Server:
    """Return a uvicorn server of the page's application; it runs until ``should_exit`` is set.

    `connection` is the class of its connections, which limits their number and the time of a request.
    """
    return uvicorn.Server(
        uvicorn.Config(
            app,
            http=connection,
            ws="none",
            loop="asyncio",
            lifespan="off",
            backlog=LIMITS.backlog,
            timeout_keep_alive=round(connection.limits.timeout_s),
            timeout_graceful_shutdown=1,
            proxy_headers=False,
            server_header=False,
            access_log=False,
            log_config=None,
            log_level="critical",
        )
    )


def serve(design: Design, listener: socket.socket, token: str, show: bool) -> None:
    """Serve the page of a design on a listening socket until the process is stopped.

    Parameters
    ----------
    design
        Design of the page.
    listener
        Socket from `open_socket`.
    token
        Secret that the page's address contains.
    show
        Whether to open the page in the default browser.
    """
    page_request = {"design": changed_values(with_load(design))}
    slower_work = [(SLOWER[name], (page_request,)) for name in ("checks", "life")]
    quick_work = [(work, (page_request,)) for work in QUICK.values()]
    workers = Workers(quick_work, slower_work, [(load_search, ())], [(load_exports, ())])
    try:
        server = create_server(application(Page(design, workers), token))
        if show:
            address = page_address(listener, token)
            threading.Timer(0.3, webbrowser.open, (address,)).start()
        gc.freeze()
        server.run([listener])
    finally:
        workers.close()


def page_address(listener: socket.socket, token: str) -> str:
    """Return the address that opens the page, with its secret."""
    return f"http://127.0.0.1:{listener.getsockname()[1]}/?token={token}"


def _answer_request(page: Page, name: str, body: bytes) -> Response:
    """Answer the request `name`, whose JSON text is `body`, with a JSON response; runs in a thread.

    Errors are answered, too: a refused request with the text ``refused``. At the end the semaphore `page.slots`, which
    limits the number of requests at a time and which the caller has acquired, is released.
    """
    try:
        content = json.loads(body)
        if not isinstance(content, dict):
            raise ValueError(f"send a JSON object, not a {type(content).__name__}")
        return _json_response(HTTPStatus.OK, page.answer(name, content))
    except CycloidError as error:  # status 200: browsers log every other status as an error of the page
        return _json_response(HTTPStatus.OK, {"refused": sentence_in_words(str(error).removeprefix("override: "))})
    except KeyError:
        return _error_response(HTTPStatus.NOT_FOUND, "unknown request: reload the page")
    except (ValueError, RecursionError) as error:
        return _error_response(HTTPStatus.BAD_REQUEST, f"the request is not a valid JSON object: {error}")
    except Exception as error:  # a failure of one request must not end the server
        return _failure_response(None, error)
    finally:
        page.slots.release()
        gc.collect()  # as the workers do


def _failure_response(_request: Request | None, error: Exception) -> Response:
    """Log an unexpected exception in one line, and return it as a response."""
    *_, (frame, line) = traceback.walk_tb(error.__traceback__)
    reason = f"{type(error).__name__}: {error}"
    _log.error("error: %s (%s:%d)", reason, frame.f_code.co_filename, line)
    return _error_response(HTTPStatus.INTERNAL_SERVER_ERROR, reason)


def _missing_job_response(_request: Request, error: Exception) -> Response:
    return PlainTextResponse(f"{error}\n", HTTPStatus.NOT_FOUND)


async def _read_body(request: Request) -> bytes | None:
    """Read the body of an HTTP request to the page; return None if it is longer than allowed."""
    if int(request.headers.get("content-length", "0")) > LIMITS.body_bytes:  # h11 has checked that these are digits
        return None
    body = bytearray()
    async for chunk in request.stream():
        body += chunk
        if len(body) > LIMITS.body_bytes:
            return None
    return bytes(body)


def _job_number(request: Request) -> int:
    text = request.path_params["job"]
    return int(text) if text.isdecimal() and len(text) < 10 else 0


def _file_missing() -> Response:
    return PlainTextResponse("This file is no longer available: create it again.\n", HTTPStatus.NOT_FOUND)


def _error_response(status: HTTPStatus, words: str) -> Response:
    return _json_response(status, {"error": words})


def _json_response(status: HTTPStatus, content: Any) -> Response:
    text = json.dumps(to_json_values(content), separators=(",", ":"))
    return Response(text, status, media_type="application/json; charset=utf-8")


def _media_response(content: bytes, media_type: str) -> Response:
    headers = {"Content-Security-Policy": CONTENT_SECURITY_POLICY} if media_type == "text/html" else None
    return Response(content, media_type=media_type, headers=headers)


def _read_assets() -> dict[str, bytes]:
    """Read the page's own files."""
    folder = resources.files("cycloid_mj.app").joinpath("assets")
    files = (file for file in folder.iterdir() if file.name.rpartition(".")[2] in MEDIA_TYPES)
    return {file.name: file.read_bytes() for file in files}
