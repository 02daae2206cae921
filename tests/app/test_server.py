"""The server of the page: what it sends, whom it refuses, and how it withstands malformed, slow and idle clients."""

import gc
import http.client
import json
import math
import re
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, replace
from importlib import resources
from typing import Any

import pytest

from cycloid_mj.app.access import is_local
from cycloid_mj.app.api import AT_ONCE, QUICK, SLOWER
from cycloid_mj.app.connections import LimitedConnection
from cycloid_mj.app.controls import controls
from cycloid_mj.app.jobs import Job
from cycloid_mj.app.limits import LIMITS
from cycloid_mj.app.server import Page, application, create_server, open_socket
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS

TOKEN = "secret-of-this-test"

TIMEOUT_S = 1.0
"""Time-out of the server with few connections [s]."""

FEW = 20
"""Limit of its connections."""


class Immediate:
    """Workers that answer without a process, and fail for one torque."""

    def __init__(self) -> None:
        self.quick = self.slower = self.long = self.files = self

    def do(self, work: Any, *args: Any, on_progress: Any = None) -> Any:
        if on_progress:
            return work(on_progress, *args)
        if args[0]["design"].get("load.torque_nm") == 13:
            raise ZeroDivisionError("by the thirteenth")
        return {"value": math.nan, "of": [math.inf, 1.0]}


@dataclass
class Running:
    """A server in a thread."""

    page: Page
    port: int


@contextmanager
def running(connection: type[LimitedConnection] = LimitedConnection) -> Iterator[Running]:
    page = Page(PRESETS["pin"], Immediate())  # type: ignore[arg-type]
    with open_socket(0) as listener:
        port = listener.getsockname()[1]
        server = create_server(application(page, TOKEN), connection)
        thread = threading.Thread(target=server.run, args=([listener],), daemon=True)
        thread.start()
        yield Running(page, port)
        server.should_exit = True
        thread.join(20.0)
        assert not thread.is_alive()


@pytest.fixture(scope="module", autouse=True)
def modules_left_out() -> Iterator[None]:
    """Leave what is loaded out of the garbage collection after each answer, as the command does."""
    gc.freeze()
    yield
    gc.unfreeze()


@pytest.fixture(scope="module")
def server() -> Iterator[Running]:
    with running() as one:
        yield one


class FewConnections(LimitedConnection):
    """Small limits, so that the tests are short."""

    limits = replace(LIMITS, timeout_s=TIMEOUT_S, connections=FEW)


@pytest.fixture
def small() -> Iterator[Running]:
    with running(FewConnections) as one:
        yield one


Answer = tuple[int, bytes, http.client.HTTPMessage]


def request(
    server: Running, path: str, body: Any = None, headers: dict[str, str] | None = None, token: str = TOKEN
) -> Answer:
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
    cookie = {"Cookie": f"other=1; cycloid_mj_{server.port}={token}"} if token else {}
    content = body if isinstance(body, bytes | None) else json.dumps(body).encode()
    all_headers = {"Content-Type": "application/json", **cookie, **(headers or {})}
    connection.request("GET" if body is None else "POST", path, content, all_headers)
    answer = connection.getresponse()
    result = answer.status, answer.read(), answer.headers
    connection.close()
    return result


def raw(server: Running, sent: bytes) -> bytes:
    """Send bytes and return all that comes back before the server closes or is silent."""
    with socket.create_connection(("127.0.0.1", server.port), timeout=20.0) as client:
        client.sendall(sent)
        client.shutdown(socket.SHUT_WR)
        received = b""
        try:
            while chunk := client.recv(65536):
                received += chunk
        except ConnectionResetError:
            pass
    return received


# --- who may use it


@pytest.mark.parametrize(
    ("hosts", "origins", "allowed"),
    [
        (["localhost:8137"], [], True),
        (["LOCALHOST"], ["http://localhost"], True),
        (["127.0.0.1:8137"], ["http://127.0.0.1:8137"], True),
        (["[::1]:8137"], ["http://[::1]:8137"], True),
        (["evil.example:8137"], [], False),
        (["evil.example:8137"], ["http://evil.example:8137"], False),
        (["127.0.0.1.evil.example"], [], False),
        (["localhost@evil.example"], [], False),
        (["evil.example@localhost"], [], False),
        (["localhost/evil.example"], [], False),
        (["127.0.0.1:8137"], ["http://evil.example"], False),
        (["127.0.0.1:8137"], ["http://127.0.0.1:3000"], False),
        (["127.0.0.1:8137"], ["null"], False),
        (["[::1"], [], False),
        ([""], [], False),
        ([], [], False),
        (["localhost", "evil.example"], [], False),
    ],
)
def test_only_local_names_of_the_same_origin_are_allowed(hosts: list[str], origins: list[str], allowed: bool) -> None:
    assert is_local(hosts, origins) is allowed


def test_foreign_hosts_and_origins_are_refused(server: Running) -> None:
    for headers in ({"Host": "evil.example"}, {"Origin": "http://evil.example"}):
        assert request(server, "/", None, headers)[0] == 403
        assert request(server, "/ask/start", {}, headers)[0] == 403


@pytest.mark.parametrize("path", ["/", "/app.js", "/file/1/a.toml", "/report/1", "/?token=", "/?token=wrong"])
def test_without_the_token_nothing_is_sent(server: Running, path: str) -> None:
    for token in ("", "wrong", "schlüssel"):
        status, body, headers = request(server, path, token=token)
        assert status == 403
        assert b"cycloid-mj app" in body
        assert TOKEN not in str(headers)


def test_without_the_token_no_question_is_answered(server: Running) -> None:
    for name in ("start", "status", "stop", "job"):
        assert request(server, f"/ask/{name}", {"job": 1}, token="")[0] == 403
    assert request(server, f"/ask/start?token={TOKEN}", {}, token="")[0] == 403


def test_the_token_becomes_a_cookie_that_opens_the_page(server: Running) -> None:
    status, _, headers = request(server, f"/?token={TOKEN}", token="")
    assert status == 303
    assert headers["Location"] == "/"
    cookie = headers["Set-Cookie"]
    assert "HttpOnly" in cookie
    assert "samesite=lax" in cookie.lower()
    assert request(server, "/", None, {"Cookie": cookie.partition(";")[0]}, token="")[0] == 200


# --- what it sends


@pytest.mark.parametrize(
    ("name", "kind"),
    [("", "text/html"), ("app.css", "text/css"), ("app.js", "text/javascript"), ("gear.svg", "image/svg+xml")],
)
def test_the_page_and_its_files_are_sent(server: Running, name: str, kind: str) -> None:
    status, body, headers = request(server, f"/{name}")
    assert (status, headers.get_content_type()) == (200, kind)
    assert body
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert headers["Cache-Control"] == "no-store"


def test_the_page_loads_nothing_from_elsewhere(server: Running) -> None:
    _, page, headers = request(server, "/")
    assert "default-src 'self'" in headers["Content-Security-Policy"]
    for name in re.findall(r'(?:src|href)="([^"]+)"', page.decode()):
        status, body, _ = request(server, f"/{name}")
        assert status == 200
        imports = re.findall(r'from "\./([\w.]+)"', body.decode())
        assert all(request(server, f"/{one}")[0] == 200 for one in imports)
        assert not re.search(r"https?://(?!www\.w3\.org)", body.decode())


@pytest.mark.parametrize(
    "path", ["/../server.py", "/%2e%2e/server.py", "/assets/app.js", "/x", "/file/1/a", "/report/x", "/%00", "//"]
)
def test_nothing_else_is_sent(server: Running, path: str) -> None:
    assert request(server, path)[0] == 404


def test_a_design_is_opened_and_its_file_fetched_under_its_name(server: Running) -> None:
    _, body, _ = request(server, "/ask/open", {"text": 'name = "my drive"\n[ring]\nteeth = 20\n', "name": "my.toml"})
    opened = json.loads(body)
    assert opened["name"] == "my drive"
    assert opened["load_nm"] > 0.0
    number = json.loads(request(server, "/ask/job", {"kind": "toml", "design": opened["design"]})[1])["job"]
    finished(server.page.jobs.get(number))
    status, content, headers = request(server, f"/file/{number}/my%20drive.toml")
    assert status == 200
    assert b"teeth = 20" in content
    assert "my%20drive.toml" in headers["Content-Disposition"]


def finished(job: Job) -> None:
    for _ in range(1200):
        if job.state == "done":
            return
        time.sleep(0.05)
    raise AssertionError(job)


def test_questions_are_answered_and_failures_reported(server: Running, caplog: pytest.LogCaptureFixture) -> None:
    status, body, _ = request(server, "/ask/draw", {"design": {}, "changes": {"ring.teeth": 30}})
    assert status == 200
    assert json.loads(body)["head"]["ratio"] == 29
    status, body, _ = request(server, "/ask/draw", {"design": {}, "changes": {"ring.teeth": 3}})
    assert status == 200, "a browser logs any other as an error of the page"
    assert "ring teeth = 3" in json.loads(body)["refused"]
    assert json.loads(request(server, "/ask/statics", {"design": {}})[1]) == {"value": None, "of": [None, 1.0]}
    status, body, _ = request(server, "/ask/statics", {"design": {"load.torque_nm": 13}})
    assert status == 500
    assert json.loads(body)["error"] == "ZeroDivisionError: by the thirteenth"
    assert len([one for one in caplog.records if one.levelname == "ERROR"]) == 1
    assert "Traceback" not in caplog.text


def test_every_question_of_the_page_has_an_answer() -> None:
    text = "".join(file.read_text() for file in resources.files("cycloid_mj.app").joinpath("assets").iterdir())
    asks = set(re.findall(r'(?:ask|newest|replace)\("(\w+)"', text))
    assert asks == {*AT_ONCE, *QUICK, *SLOWER, "start", "job", "status", "stop"}


def test_sliders_are_written_in_json() -> None:
    assert json.dumps([asdict(control) for control in controls(PRESETS["twodisc"])])


# --- malformed requests


@pytest.mark.parametrize(
    ("path", "body", "headers", "status"),
    [
        ("/ask/nothing", {}, {}, 404),
        ("/ask/status", {}, {}, 404),
        ("/ask/draw", b"{", {}, 400),
        ("/ask/draw", b"[1]", {}, 400),
        ("/ask/draw", b"[" * 100_000, {}, 400),
        ("/ask/draw", b"\xff", {}, 400),
        ("/ask/draw", b"1" * 5000, {}, 400),
        ("/ask/draw", b"{}", {"Content-Type": "text/plain"}, 415),
        ("/ask/draw", b"", {"Content-Length": str(LIMITS.body_bytes + 1)}, 413),
        ("/ask/draw", b" " * (LIMITS.body_bytes + 1), {}, 413),
        ("/ask/status", {"job": 77}, {}, 200),
        ("/ask/status", {"job": 10**30}, {}, 200),
        ("/ask/job", {"kind": "rm"}, {}, 200),
        ("/ask/job", {"kind": "size", "form": {"ratio": 1}}, {}, 200),
        ("/ask/open", {"preset": "none"}, {}, 200),
        ("/ask/open", {"preset": []}, {}, 200),
        ("/ask/job", {"kind": []}, {}, 200),
        ("/ask/open", {"text": "not TOML ["}, {}, 200),
    ],
)
def test_a_wrong_question_is_refused_in_a_sentence(
    server: Running, path: str, body: Any, headers: dict[str, str], status: int
) -> None:
    answer = request(server, path, body, headers)
    assert answer[0] == status
    assert json.loads(answer[1])["refused" if status == 200 else "error"]


HOST = b"Host: 127.0.0.1\r\n"


@pytest.mark.parametrize(
    ("sent", "status"),
    [
        (b"POST /ask/draw HTTP/1.1\r\n" + HOST + b"Content-Length: " + b"9" * 5000 + b"\r\n\r\n", 400),
        (b"POST /ask/draw HTTP/1.1\r\n" + HOST + b"Content-Length: x\r\n\r\n", 400),
        (b"POST /ask/draw HTTP/1.1\r\n" + HOST + b"Content-Length: -1\r\n\r\n", 400),
        (b"POST /ask/draw HTTP/1.1\r\n" + HOST + b"Content-Length: 1\r\nContent-Length: 2\r\n\r\n", 400),
        (b"GET /" + b"a" * 60_000 + b" HTTP/1.1\r\n" + HOST + b"\r\n", 414),
        (b"GET /file/" + b"9" * 5000 + b"/x HTTP/1.1\r\n" + HOST + b"\r\n", 414),
        (b"GET / HTTP/1.1\r\n\r\n", 400),
        (b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n", 400),
        (b"GET / HTTP/1.0\r\n\r\n", 403),
        (b"GET / HTTP/9.9\r\n" + HOST + b"\r\n", 403),
        (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n", 400),
        (b"\xff" * 100 + b"\r\n\r\n", 400),
        (b"GET / HTTP/1.1\r\n" + b"X: y\r\n" * 100_000, 400),
        (b"CONNECT evil.example:80 HTTP/1.1\r\n" + HOST + b"\r\n", 403),
        (b"OPTIONS * HTTP/1.1\r\n" + HOST + b"\r\n", 403),
    ],
)
def test_a_malformed_request_is_answered_with_4xx(
    server: Running, sent: bytes, status: int, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    answer = raw(server, sent)
    assert answer.startswith(b"HTTP/1.1 %d " % status)
    assert request(server, "/app.js")[0] == 200
    assert "Traceback" not in capfd.readouterr().err + caplog.text


@pytest.mark.parametrize("digits", [10, 300, LIMITS.path_length - 100])
def test_a_job_number_of_any_length_is_answered(server: Running, digits: int) -> None:
    assert request(server, f"/file/{'9' * digits}/x")[0] == 404
    assert request(server, f"/report/{'9' * digits}")[0] == 404


def test_broken_chunks_and_leaving_clients_print_no_traceback(
    server: Running, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    head = f"POST /ask/draw HTTP/1.1\r\nHost: 127.0.0.1\r\nCookie: cycloid_mj_{server.port}={TOKEN}\r\n".encode()
    json_head = head + b"Content-Type: application/json\r\n"
    assert raw(server, json_head + b"Transfer-Encoding: chunked\r\n\r\nZZZ\r\n").startswith(b"HTTP/1.1 400 ")
    for sent in (json_head + b"Content-Length: 100\r\n\r\nabc", json_head, b"GET"):
        with socket.create_connection(("127.0.0.1", server.port)) as client:
            client.sendall(sent)
    assert request(server, "/app.js")[0] == 200
    assert "Traceback" not in capfd.readouterr().err + caplog.text


# --- many, idle and slow clients


def test_the_backlog_is_at_least_128() -> None:
    assert LIMITS.backlog >= 128
    assert LIMITS.timeout_s == 30.0


@pytest.mark.slow
def test_two_thousand_requests_of_64_clients_are_answered(server: Running) -> None:
    statuses: list[int] = []

    def client() -> None:
        statuses.extend(request(server, "/gear.svg")[0] for _ in range(31))

    clients = [threading.Thread(target=client) for _ in range(64)]
    for one in clients:
        one.start()
    for one in clients:
        one.join()
    assert statuses == [200] * (64 * 31)


def test_too_many_questions_at_the_same_time_are_refused(server: Running) -> None:
    assert all(server.page.slots.acquire(timeout=60.0) for _ in range(LIMITS.requests))
    try:
        assert request(server, "/ask/draw", {"design": {}})[0] == 503
    finally:
        for _ in range(LIMITS.requests):
            server.page.slots.release()
    assert request(server, "/ask/draw", {"design": {}})[0] == 200


def test_idle_connections_do_not_freeze_the_page(small: Running) -> None:
    with ExitStack() as stack:
        for _ in range(4 * FEW):
            stack.enter_context(socket.create_connection(("127.0.0.1", small.port)))
        began = time.monotonic()
        assert request(small, "/app.js")[0] == 200
        assert time.monotonic() - began < 0.5 * TIMEOUT_S


@pytest.mark.slow
def test_two_thousand_idle_connections_do_not_freeze_the_page(server: Running) -> None:
    clients = []
    try:
        for _ in range(20):
            for _ in range(100):
                clients.append(socket.create_connection(("127.0.0.1", server.port), timeout=10.0))
            while len(clients) > 300:  # the process has 1024 file descriptors
                clients.pop(0).close()
            began = time.monotonic()
            assert request(server, "/app.js")[0] == 200
            assert time.monotonic() - began < 2.0
    finally:
        for client in clients:
            client.close()


def test_slow_requests_are_ended_and_do_not_freeze_the_page(small: Running) -> None:
    head = f"POST /ask/draw HTTP/1.1\r\nHost: localhost\r\nCookie: cycloid_mj_{small.port}={TOKEN}\r\n".encode()
    head += b"Content-Type: application/json\r\nContent-Length: 1000\r\n\r\n"
    with ExitStack() as stack:
        clients = [
            stack.enter_context(socket.create_connection(("127.0.0.1", small.port), timeout=20.0)) for _ in range(FEW)
        ]
        for client in clients:
            client.sendall(head + b"{")
        assert request(small, "/app.js")[0] == 200
        answers = []
        for client in clients[1:]:  # the first one had to give way to the request above
            try:
                answers.append(client.recv(65536)[:12])
            except ConnectionResetError:
                answers.append(b"reset")
        assert answers.count(b"HTTP/1.1 408") >= FEW - 2
    assert request(small, "/ask/draw", {"design": {}})[0] == 200


@pytest.mark.parametrize("sent", [b"", b"GET / HTT", b"GET / HTTP/1.1\r\nHost: localhost\r\n"])
def test_a_request_that_does_not_arrive_is_ended(small: Running, sent: bytes) -> None:
    began = time.monotonic()
    with socket.create_connection(("127.0.0.1", small.port), timeout=20.0) as client:
        client.sendall(sent)
        answer = client.recv(65536)
    assert TIMEOUT_S * 0.8 < time.monotonic() - began < TIMEOUT_S + 5.0
    assert answer[:12] == (b"HTTP/1.1 408" if sent else b"")


def test_a_connection_is_kept_for_further_requests(small: Running) -> None:
    connection = http.client.HTTPConnection("127.0.0.1", small.port, timeout=20)
    headers = {"Cookie": f"cycloid_mj_{small.port}={TOKEN}", "Content-Type": "application/json"}
    for _ in range(3):
        connection.request("GET", "/app.js", headers=headers)
        assert connection.getresponse().read()
        time.sleep(0.6 * TIMEOUT_S)
    connection.request("POST", "/ask/draw", b'{"design": {}}', headers)
    assert connection.getresponse().status == 200
    connection.close()


# --- the command


@pytest.mark.slow
def test_wrong_ports_and_flags_are_reported_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["app", "--design", "pin", "--port", "0"]) == 2
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        assert main(["app", "--no-browser", "--port", str(taken.getsockname()[1])]) == 1
    errors = capsys.readouterr().err.splitlines()
    assert len(errors) == 2
    assert "is in use" in errors[1]


def test_a_taken_port_is_refused() -> None:
    with open_socket(0) as taken, pytest.raises(CycloidError, match="is in use"):
        open_socket(taken.getsockname()[1])
