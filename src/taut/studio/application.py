"""The server as an ASGI application: the page, its files, the link; nothing for strangers."""

from __future__ import annotations

import base64
import hashlib
import re
import secrets
from collections.abc import AsyncIterator, Iterator, Mapping
from contextlib import asynccontextmanager
from importlib.resources import files
from importlib.resources.abc import Traversable

from starlette.applications import Starlette
from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket

from taut.studio.link import TRY_LATER, Link, Studio

MOST_LINKS = 32
_TYPES = {
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".png": "image/png",
    ".svg": "image/svg+xml",
}
_LOOPBACK = re.compile(r"(?:127\.0\.0\.1|localhost|\[::1\])(?::\d{1,5})?", re.IGNORECASE)
_INLINE = re.compile(rb"<script[^>]*>(.+?)</script>", re.DOTALL)
_REFUSED = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<meta name="color-scheme" content="light dark"><title>taut studio</title></head>
<body><h1>This address has no key, or an old one</h1>
<p>The studio is only for who started it. Open the whole address that <code>taut studio</code> printed in the terminal;
it ends in <code>?token=…</code> and is a new one at each start.</p>
<p>What you drew is kept in this browser and will be there.</p></body></html>
"""


def application(studio: Studio, token: str) -> Starlette:
    """Return the application.

    Parameters
    ----------
    studio : whom the links work for; its crew is started and ended with the application.
    token : the secret that opens page and link.
    """
    page = page_files()
    links: set[Link] = set()

    def known(given: str | None) -> bool:
        return given is not None and secrets.compare_digest(given.encode(), token.encode())

    async def index(request: Request) -> Response:
        if not known(request.query_params.get("token")):
            return HTMLResponse(_REFUSED, 403)
        return HTMLResponse(page["index.html"].read_bytes())

    async def static(request: Request) -> Response:
        name = request.path_params["name"]
        file, kind = page.get(name), _TYPES.get(_ending(name))
        if file is None or kind is None:
            return PlainTextResponse("there is no such file", 404)
        return Response(file.read_bytes(), media_type=kind)

    async def link(socket: WebSocket) -> None:
        # browsers tell the origin of the page that opens a link, and pages cannot lie about it
        ours = socket.headers.get("origin") == f"http://{socket.headers.get('host')}"
        if not ours or not known(socket.query_params.get("token")):
            await socket.close()
            return
        if len(links) >= MOST_LINKS:
            await socket.accept()  # only a link that was open can be told why it is closed
            await socket.close(TRY_LATER, f"the studio is open in {MOST_LINKS} tabs already; close one of them")
            return
        one = Link(socket, studio)
        links.add(one)
        try:
            await one.run()
        finally:
            links.discard(one)

    @asynccontextmanager
    async def working(app: Starlette) -> AsyncIterator[None]:
        studio.crew.start()
        try:
            yield
        finally:
            await studio.crew.close()

    routes = [Route("/", index), Route("/page/{name:path}", static), WebSocketRoute("/link", link)]
    app = Starlette(routes=routes, middleware=[Middleware(_Guard, page=page)], lifespan=working)
    app.router.redirect_slashes = False
    return app


def page_files() -> Mapping[str, Traversable]:
    """Return the files of the page by their path in its folder; nothing else is ever served."""
    return dict(_listed(files("taut.studio") / "page", ""))


def _listed(folder: Traversable, prefix: str) -> Iterator[tuple[str, Traversable]]:
    for entry in folder.iterdir():
        if entry.is_dir():
            yield from _listed(entry, f"{prefix}{entry.name}/")
        else:
            yield f"{prefix}{entry.name}", entry


def _ending(name: str) -> str:
    return name[name.rfind(".") :]


class _Guard:
    """Turns away what does not come from this machine under its own name, and says to browsers what may be done.

    Another site's page can have its name resolved to this machine; the host that it then asks for is still its own.
    """

    def __init__(self, app: ASGIApp, page: Mapping[str, Traversable]) -> None:
        self._app = app
        self._page = page

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        refusal: Response | None = None
        if not _LOOPBACK.fullmatch(host):
            refusal = PlainTextResponse("the studio answers only to 127.0.0.1 and localhost", 403)
        elif headers.get("content-length", "0") != "0" or "transfer-encoding" in headers:
            refusal = PlainTextResponse("the studio takes no uploads", 413)

        async def guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(self._said(host))
            await send(message)

        if refusal is None:
            await self._app(scope, receive, guarded)
        elif scope["type"] == "http":
            await refusal(scope, receive, guarded)
        else:
            await WebSocket(scope, receive, send).close()

    def _said(self, host: str) -> dict[str, str]:
        index = self._page["index.html"].read_bytes() if "index.html" in self._page else b""
        hashes = [base64.b64encode(hashlib.sha256(script).digest()).decode() for script in _INLINE.findall(index)]
        scripts = " ".join(["'self'", *(f"'sha256-{one}'" for one in hashes)])
        link = f" ws://{host}" if _LOOPBACK.fullmatch(host) else ""
        policy = (
            "default-src 'none'",
            f"script-src {scripts}",
            "style-src 'self'",
            "img-src 'self' data: blob:",
            "media-src blob:",
            f"connect-src 'self'{link}",
            "base-uri 'none'",
            "form-action 'none'",
            "frame-ancestors 'none'",
        )
        return {
            "content-security-policy": "; ".join(policy),
            "cross-origin-opener-policy": "same-origin",
            "cross-origin-resource-policy": "same-origin",
            "referrer-policy": "no-referrer",
            "x-content-type-options": "nosniff",
            "cache-control": "no-store",
        }
