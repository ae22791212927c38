"""Running the server: a port that stays the same, a token, the browser, a clean end."""

from __future__ import annotations

import contextlib
import getpass
import hashlib
import os
import secrets
import signal
import socket
import sys
import tempfile
import threading
import webbrowser
from collections.abc import Callable, Iterator
from pathlib import Path

import uvicorn

from taut.errors import TautError
from taut.studio import messages
from taut.studio.application import application
from taut.studio.crew import Crew
from taut.studio.link import Studio
from taut.studio.scene_file import Named

HOST = "127.0.0.1"
_FIRST, _PORTS = 49152, 16384  # the ports that nobody may reserve
_TRIES = 100
_GRACE = 2  # seconds that pages have to say goodbye
_REDIRECTION = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="referrer" content="no-referrer"><title>taut studio</title>
<meta http-equiv="refresh" content="0; url={address}"></head><body><a href="{address}">Open the studio</a></body></html>
"""


def serve(source: str, first: Named, port: int | None, browser: bool, debug: bool, tell: Callable[[str], None]) -> None:
    """Run the studio until Ctrl-C or a signal ends it.

    Parameters
    ----------
    source : what the user named, "" for nothing.
    first : what that holds.
    port : None takes the user's and scene's own one.
    browser : whether to open a browser, if there is a display.
    debug : whether workers and server write what they do on stderr.
    tell : called with the address once it can be opened.

    Raises
    ------
    TautError
        The port is taken.
    """
    listening = listen(source, port)
    number = listening.getsockname()[1]
    token = secrets.token_urlsafe(24)
    address = f"http://{HOST}:{number}/?token={token}"
    studio = Studio(source, first, Crew(loud=debug))
    config = uvicorn.Config(
        application(studio, token),
        log_level="info" if debug else "critical",
        access_log=debug,
        lifespan="on",
        loop="asyncio",
        http="h11",
        ws="websockets-sansio",
        ws_max_size=messages.LONGEST,
        ws_per_message_deflate=False,  # nothing is gained on the way to the same machine
        proxy_headers=False,
        server_header=False,
        timeout_graceful_shutdown=_GRACE,
    )

    def ready() -> None:
        tell(address)
        if browser and _has_display():
            with contextlib.suppress(OSError):
                page = kept.enter_context(redirection(address))
                threading.Thread(target=_open, args=(page,), daemon=True).start()

    server = _Server(config, ready)
    with contextlib.closing(listening), contextlib.ExitStack() as kept:
        server.run(sockets=[listening])
    if server.failure is not None:
        raise server.failure


def own_port(source: str) -> int:
    """Return the port for this user and scene: drafts in the browser belong to it, so it must not change by itself."""
    who = f"{_user()}\n{Path(source).resolve() if source else ''}"
    return _FIRST + int.from_bytes(hashlib.sha256(who.encode("utf-8", "replace")).digest()[:4]) % _PORTS


def listen(source: str, port: int | None) -> socket.socket:
    """Return a socket that listens on the port, or by itself on the scene's own one or one of the next.

    Raises
    ------
    TautError
        The port is taken.
    """
    first = own_port(source)
    ports = [port] if port is not None else [_FIRST + (first - _FIRST + k) % _PORTS for k in range(_TRIES)]
    for number in ports:
        one = socket.socket()
        try:
            # after a crash the port is free at once; elsewhere than here this would share it with others
            if sys.platform != "win32":
                one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            one.bind((HOST, number))
            one.listen()
        except OSError as error:
            one.close()
            reason = error.strerror or error
        else:
            return one
    what = f"port {port}" if port is not None else f"{_TRIES} ports from {first} on"
    raise TautError(f"{what}: {reason}; take another one with --port")


class _Server(uvicorn.Server):
    """A server that says when it is ready, and for which the signals to end are no errors."""

    def __init__(self, config: uvicorn.Config, ready: Callable[[], None]) -> None:
        super().__init__(config)
        self._ready = ready
        self.failure: Exception | None = None

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        try:
            if self.started:
                self._ready()
        except Exception as error:  # nobody reads what it says; the workers must be ended before that is told
            self.failure = error
            self.should_exit = True

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        names = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
        numbers = [getattr(signal, name) for name in names if hasattr(signal, name)]
        before = {number: signal.signal(number, self.handle_exit) for number in numbers}
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)


def _user() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):  # a container without users
        return ""


def _has_display() -> bool:
    """Whether a browser would open a window: without one, some would take over the terminal."""
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY") or os.environ.get("BROWSER"))


@contextlib.contextmanager
def redirection(address: str) -> Iterator[str]:
    """Keep a file that only this user can read and that leads to an address, and give the file's own address.

    What a browser is started with can be read by everybody on the machine, and the address has the token in it.
    """
    # browsers that come as snaps see no temporary files of others, and of the home no hidden ones
    place = Path.home() if Path("/snap").is_dir() else None
    with tempfile.TemporaryDirectory(prefix="taut-studio-", dir=place, ignore_cleanup_errors=True) as folder:
        path = Path(folder) / "open.html"
        path.touch(mode=0o600)
        path.write_text(_REDIRECTION.format(address=address), encoding="utf-8")
        yield path.as_uri()


def _open(address: str) -> None:
    with contextlib.suppress(webbrowser.Error, OSError):
        webbrowser.open(address)
