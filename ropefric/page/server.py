"""The page and its data on the loopback address, for one browser that knows the token, and for no other page."""

import json
import secrets
import socketserver
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from hmac import compare_digest
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from typing import Any, NamedTuple
from urllib.parse import parse_qs, urlsplit

from ropefric.errors import InputError, InternalError, RopefricError, known_error
from ropefric.files.plain_text import visible
from ropefric.page.desk import MOST_OF_A_FILE, REPORT_WITH, Desk

HOST = "127.0.0.1"
TOKEN_HEADER = "X-Ropefric-Token"  # noqa: S105  (its name)
MOST_BYTES = 65536
"""Largest request with settings or a decision."""
_BLOCK = 2**20

_HEADERS = {
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",  # the address may hold the token
    "X-Content-Type-Options": "nosniff",
}
_NOTHING = "default-src 'none'; frame-ancestors 'none'"
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; frame-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
# A report has no script; its own styles and pictures stand in it, and only our page may frame it.
_REPORT = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; sandbox; frame-ancestors 'self'"
_KINDS = {
    "json": "application/json",
    "html": "text/html; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "txt": "text/plain; charset=utf-8",
    "pdf": "application/pdf",
}


_NOT_UNDERSTOOD = (LookupError, TypeError, ValueError, AttributeError, OverflowError, RecursionError)
"""Faults of a request whose fields are missing, or are no numbers or tables where such are needed."""


class PageServer(ThreadingHTTPServer):
    """A desk on a port of the loopback address; 0 takes any that is free."""

    daemon_threads = True
    allow_reuse_address = False

    def __init__(self, desk: Desk, port: int = 0) -> None:
        self.desk = desk
        self.token = secrets.token_urlsafe(24)
        try:
            super().__init__((HOST, port), _Handler)
        except OSError as error:
            why = f"port {port} cannot be used: {(error.strerror or str(error)).lower()}"
            fix = "choose another one, or none: then any free one is taken"
            raise InputError(why, code="RF110", key="--port", fix=fix) from None

    def server_bind(self) -> None:
        """Bind without asking the network for this machine's name."""
        socketserver.TCPServer.server_bind(self)
        self.server_name, self.server_port = HOST, int(self.server_address[1])

    @property
    def address(self) -> str:
        """Return the address that a browser opens."""
        return f"http://{HOST}:{self.server_port}/?token={self.token}"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore a browser that leaves before the end of an answer."""


class _Sent(NamedTuple):
    """A body, the ending of its name, and the policy of its content."""

    body: bytes
    ending: str
    policy: str = _NOTHING


class _Refused(Exception):  # noqa: N818  (an answer, not an error)
    """A refusal: its status and its reason."""

    def __init__(self, status: int, why: str) -> None:
        super().__init__(why)
        self.status = status


class _Handler(BaseHTTPRequestHandler):
    server: PageServer
    server_version, sys_version = "ropefric", ""
    timeout = 30.0

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002
        """Write no log: addresses hold the token."""

    def do_GET(self) -> None:
        """Answer a request that reads."""
        self._answer(self._get)

    def do_POST(self) -> None:
        """Answer a request that writes."""
        self._answer(self._post)

    def _answer(self, make: Callable[[str, Mapping[str, str]], Any]) -> None:
        asked, status = urlsplit(self.path), 200
        query = {name: values[-1] for name, values in parse_qs(asked.query).items()}
        try:
            self._refuse_others(asked.path, query)
            tree = make(asked.path, query)
        except _Refused as refused:
            status, tree = refused.status, {"error": {"code": "RF110", "message": str(refused)}}
        except Exception as error:  # noqa: BLE001  (the boundary: the page gets words, never a traceback)
            status, tree = _answer_to(error)
        self._send(status, tree)

    def _send(self, status: int, tree: Any) -> None:
        sent = tree if isinstance(tree, _Sent) else _Sent(json.dumps(tree).encode(), "json")
        headers = _HEADERS | {"Content-Type": _KINDS[sent.ending], "Content-Length": str(len(sent.body))}
        headers |= {"Content-Security-Policy": sent.policy}
        if "frame-ancestors 'self'" not in sent.policy:
            headers |= {"X-Frame-Options": "DENY"}
        self.send_response(status)
        for name, value in headers.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(sent.body)

    def _refuse_others(self, path: str, query: Mapping[str, str]) -> None:
        """Refuse other names of this address, other sites, and requests without the token.

        The page itself needs no token, because it contains no data; it lets the user enter a missing token.
        """
        names = {f"{name}:{self.server.server_port}" for name in (HOST, "localhost")}
        host = self.headers.get("Host", "")
        if host not in names:
            raise _Refused(403, "the request names another address than this page has")
        given = self.headers.get(TOKEN_HEADER, query.get("token", ""))
        is_known = compare_digest(given.encode(), self.server.token.encode())
        if path.startswith(("/api/", "/results/")) and not is_known:
            why = "the token is missing or wrong; it is the end of the address that ropefric printed"
            raise _Refused(403, why)
        origin = self.headers.get("Origin")
        if origin != f"http://{host}" and (origin is not None or self.command != "GET"):
            raise _Refused(403, "only the page itself may send this request")

    def _get(self, path: str, query: Mapping[str, str]) -> Any:
        if path == "/":
            return _Sent(_page()["page.html"], "html", _POLICY)
        place, _, name = path.removeprefix("/").partition("/")
        if place == "static" and name in _page():
            return _Sent(_page()[name], name.rpartition(".")[2])
        if place == "results":
            # Browsers show no PDF where nothing may run.
            policy = _NOTHING if name.endswith(".pdf") else _REPORT
            return _Sent(self.server.desk.result(name), name.rpartition(".")[2], policy)
        if place == "api" and (read := self.server.desk.reads.get(name)) is not None:
            return read(query)
        raise _Refused(404, "there is no such page")

    def _post(self, path: str, query: Mapping[str, str]) -> Any:
        place, _, name = path.removeprefix("/").partition("/")
        is_file, write = name == "upload", self.server.desk.writes.get(name)
        if place != "api" or not (is_file or write):
            raise _Refused(404, "there is no such page")
        kind, most = ("octet-stream", MOST_OF_A_FILE) if is_file else ("json", MOST_BYTES)
        if self.headers.get_content_type() != f"application/{kind}":
            raise _Refused(415, f"this is not application/{kind}")
        size = int(self.headers["Content-Length"])
        if not 0 <= size <= most:
            why = f"more than {most} bytes are not accepted here; name the folder of the recordings"
            raise _Refused(413, why)
        content = self._content(size)
        if write is not None:
            return write(dict(json.loads(b"".join(content))))
        try:
            return self.server.desk.upload(query["name"], content, size)
        finally:
            for _ in content:  # a browser reads no answer before it has sent all
                pass

    def _content(self, size: int) -> Iterator[bytes]:
        """Yield what a request sends, in blocks."""
        try:
            while size > 0 and (block := self.rfile.read(min(size, _BLOCK))):
                size -= len(block)
                yield block
        except TimeoutError:
            raise _Refused(408, "the request broke off") from None


@cache
def _page() -> dict[str, bytes]:
    return {one.name: one.read_bytes() for one in (files("ropefric.page") / "static").iterdir()}


def _answer_to(error: Exception) -> tuple[int, dict[str, Any]]:
    """Return the status of an answer, and its error in words."""
    if isinstance(error, _NOT_UNDERSTOOD) and not isinstance(error, RopefricError):
        return 400, {"error": {"code": "RF110", "message": "the request cannot be understood"}}
    known = known_error(error, report_with=REPORT_WITH)
    said = visible("; ".join(dict.fromkeys(problem.message for problem in known.problems)))
    status = 500 if isinstance(known, InternalError) else 409
    return status, {"error": {**known.problem.to_dict(), "message": said}}
