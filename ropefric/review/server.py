"""The page and its data on the loopback address, for one browser that knows the token, and for no other page."""

import json
import secrets
import socketserver
from collections.abc import Callable, Mapping
from functools import cache
from hmac import compare_digest
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from math import nan
from typing import Any
from urllib.parse import parse_qs, urlsplit

from ropefric.errors import InputError, RopefricError
from ropefric.files.plain_text import visible
from ropefric.review.session import Review

HOST = "127.0.0.1"
TOKEN_HEADER = "X-Ropefric-Token"  # noqa: S105  (its name)
MOST_BYTES = 65536
"""Of a decision."""

_HEADERS = {
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",  # the address holds the token
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}
_POLICY = (
    "default-src 'none'; script-src 'nonce-{0}'; style-src 'nonce-{0}'; connect-src 'self'; img-src data:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


class ReviewServer(ThreadingHTTPServer):
    """A review on a port of the loopback address; 0 takes any that is free."""

    daemon_threads = True
    allow_reuse_address = False

    def __init__(self, review: Review, port: int = 0) -> None:
        self.review = review
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
        """Return what a browser opens."""
        return f"http://{HOST}:{self.server_port}/?token={self.token}"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of a browser that went away in the middle of an answer."""


class _Refused(Exception):  # noqa: N818  (an answer, not an error)
    """An answer of another kind than what was asked for: status, and why."""

    def __init__(self, status: int, why: str) -> None:
        super().__init__(why)
        self.status = status


class _Handler(BaseHTTPRequestHandler):
    server: ReviewServer
    server_version, sys_version = "ropefric", ""
    timeout = 30.0

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002
        """Write no log: addresses hold the token."""

    def do_GET(self) -> None:
        """Answer what only reads."""
        self._answer(self._get)

    def do_POST(self) -> None:
        """Answer what writes."""
        self._answer(self._post)

    def _answer(self, make: Callable[[str, Mapping[str, str]], Any]) -> None:
        asked, status = urlsplit(self.path), 200
        query = {name: values[-1] for name, values in parse_qs(asked.query).items()}
        try:
            self._refuse_others(query)
            if asked.path == "/" and self.command == "GET":
                nonce = secrets.token_urlsafe(16)
                page = _page().replace("{{nonce}}", nonce).encode()
                self._send(200, page, "text/html; charset=utf-8", _POLICY.format(nonce))
                return
            tree = make(asked.path, query)
        except _Refused as refused:
            status, tree = refused.status, {"error": {"code": "RF110", "message": str(refused)}}
        except RopefricError as error:
            status, tree = 409, {"error": {**error.problem.to_dict(), "message": _all_of(error)}}
        except (KeyError, TypeError, ValueError, RecursionError):
            status, tree = 400, {"error": {"code": "RF110", "message": "this request makes no sense"}}
        except Exception as error:  # noqa: BLE001  (the boundary: the page gets words, never a traceback)
            words = f"internal fault, {type(error).__name__}: {error}"
            status, tree = 500, {"error": {"code": "RF000", "message": words, "fix": "please report it"}}
        self._send(status, json.dumps(tree).encode(), "application/json", "default-src 'none'")

    def _send(self, status: int, body: bytes, kind: str, policy: str) -> None:
        self.send_response(status)
        own = {"Content-Type": kind, "Content-Length": str(len(body)), "Content-Security-Policy": policy}
        for name, value in {**_HEADERS, **own}.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def _refuse_others(self, query: Mapping[str, str]) -> None:
        """Refuse whoever does not know the token, and names that lead here from other sites."""
        names = {f"{name}:{self.server.server_port}" for name in (HOST, "localhost")}
        host = self.headers.get("Host", "")
        if host not in names:
            raise _Refused(403, "this address is not known here")
        given = self.headers.get(TOKEN_HEADER, query.get("token", ""))
        if not compare_digest(given.encode(), self.server.token.encode()):
            raise _Refused(
                403, "the token is missing or wrong: open the address that `ropefric review` printed"
            )
        origin = self.headers.get("Origin")
        if origin != f"http://{host}" and (origin is not None or self.command != "GET"):
            raise _Refused(403, "another page may not ask for this")

    def _get(self, path: str, query: Mapping[str, str]) -> Any:
        review = self.server.review
        if path in {"/api/overview", "/api/answer"}:
            return getattr(review, path.removeprefix("/api/"))()
        if path == "/api/trial":
            return review.trial(query["trial"])
        if path == "/api/preview":
            return review.preview(query["trial"], float(query["pick_s"]))
        if path == "/api/curve":
            start_s, stop_s = (float(query.get(name) or nan) for name in ("start_s", "stop_s"))
            return review.curve(query["trial"], start_s, stop_s, int(query["columns"]))
        raise _Refused(404, "there is no such page")

    def _post(self, path: str, _: Mapping[str, str]) -> Any:
        if self.headers.get_content_type() != "application/json":
            raise _Refused(415, "this is not JSON")
        size = int(self.headers["Content-Length"])
        if not 0 <= size <= MOST_BYTES:
            raise _Refused(413, "this is too long for a decision")
        asked = dict(json.loads(self.rfile.read(size)))
        review = self.server.review
        if path == "/api/decide":
            pick_s, text = asked.get("pick_s"), str(asked.get("text", ""))
            pick_s = None if pick_s is None else float(pick_s)
            return review.decide(asked["trial"], asked["action"], pick_s=pick_s, text=text)
        if path in {"/api/undo", "/api/reload"}:
            return getattr(review, path.removeprefix("/api/"))()
        raise _Refused(404, "there is no such page")


@cache
def _page() -> str:
    return (files("ropefric.review") / "page.html").read_text(encoding="utf-8")


def _all_of(error: RopefricError) -> str:
    return visible("; ".join(dict.fromkeys(problem.message for problem in error.problems)))
