"""The page and its data on the loopback address, for one browser that knows the token, and for no other page."""

import json
import secrets
import socketserver
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cache
from hmac import compare_digest
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from typing import Any, NamedTuple
from urllib.parse import parse_qs, urlsplit

from ropefric.errors import InputError, InternalError, RopefricError, known_error
from ropefric.files.plain_text import visible
from ropefric.page.desk import MOST_OF_A_FILE, Desk
from ropefric.page.work import REPORT_WITH

HOST = "127.0.0.1"
TOKEN_HEADER = "X-Ropefric-Token"  # noqa: S105  (its name)
MOST_BYTES = 65536
"""Largest request with settings or a decision."""

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
        asked = urlsplit(self.path)
        query = {name: values[-1] for name, values in parse_qs(asked.query).items()}
        try:
            self._refuse_others(asked.path, query)
            status, tree = 200, make(asked.path, query)
        except Exception as error:  # noqa: BLE001  (the boundary: the page gets words, never a traceback)
            status, tree = _answer_to(error)
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
        host, origin = self.headers.get("Host", ""), self.headers.get("Origin")
        if host not in {f"{name}:{self.server.server_port}" for name in (HOST, "localhost")}:
            raise _Refused(403, "the request names another address than this page has")
        given = self.headers.get(TOKEN_HEADER, query.get("token", ""))
        is_known = compare_digest(given.encode(), self.server.token.encode())
        if path not in _page() and not is_known:
            why = "the token is missing or wrong; it is the end of the address that ropefric printed"
            raise _Refused(403, why)
        if origin != f"http://{host}" and (origin is not None or self.command != "GET"):
            raise _Refused(403, "only the page itself may send this request")

    def _get(self, path: str, query: Mapping[str, str]) -> Any:
        if path in _page():
            return _page()[path]
        place, _, name = path.removeprefix("/").partition("/")
        if place == "results":
            # Browsers show no PDF where nothing may run.
            policy = _NOTHING if name.endswith(".pdf") else _REPORT
            return _Sent(self.server.desk.result(name), name.rpartition(".")[2], policy)
        if place == "api" and name in self.server.desk.reads:
            return self.server.desk.reads[name](query)
        raise _Refused(404, "there is no such page")

    def _post(self, path: str, query: Mapping[str, str]) -> Any:
        name, desk = path.removeprefix("/api/"), self.server.desk
        if name == "upload":
            return desk.upload(query["name"], self._content("application/octet-stream", MOST_OF_A_FILE))
        if name in desk.writes:
            return desk.writes[name](dict(json.loads(self._content("application/json", MOST_BYTES))))
        raise _Refused(404, "there is no such page")

    def _content(self, kind: str, most: int) -> bytes:
        """Return what a request sends."""
        if self.headers.get_content_type() != kind:
            raise _Refused(415, f"this is not {kind}")
        size, content = int(self.headers["Content-Length"]), b""
        if not 0 <= size <= most:
            why = f"more than {most} bytes are not accepted here; name the folder of the recordings"
            raise _Refused(413, why)
        with suppress(TimeoutError):
            content = self.rfile.read(size)
        if len(content) < size:
            raise _Refused(408, "the request broke off")
        return content


@cache
def _page() -> dict[str, _Sent]:
    """Return the files of the page by their addresses; they contain no data."""
    static = (files("ropefric.page") / "static").iterdir()
    found = {f"/static/{one.name}": _Sent(one.read_bytes(), one.name.rpartition(".")[2]) for one in static}
    return found | {"/": found["/static/page.html"]._replace(policy=_POLICY)}


def _answer_to(error: Exception) -> tuple[int, dict[str, Any]]:
    """Return the status of an answer, and its error in words."""
    if isinstance(error, _NOT_UNDERSTOOD) and not isinstance(error, RopefricError):
        error = _Refused(400, "the request cannot be understood")
    if isinstance(error, _Refused):
        status, why = error.args
        return status, {"error": {"code": "RF110", "message": why}}
    known = known_error(error, report_with=REPORT_WITH)
    said = visible("; ".join(dict.fromkeys(problem.message for problem in known.problems)))
    status = 500 if isinstance(known, InternalError) else 409
    return status, {"error": {**known.problem.to_dict(), "message": said}}
