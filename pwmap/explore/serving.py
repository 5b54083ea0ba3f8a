"""One page on this machine, for this machine only, until a signal or the last page ends it.

Only its own pages may open websockets, and no other page can reach it by DNS rebinding.
"""

from __future__ import annotations

import signal
import time
from asyncio import sleep
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from bokeh.application import Application
from bokeh.application.handlers import FunctionHandler
from bokeh.document import Document
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from bokeh.server.util import bind_sockets
from tornado.httpserver import HTTPServer
from tornado.ioloop import IOLoop, PeriodicCallback
from tornado.iostream import IOStream
from tornado.web import HTTPError, RequestHandler

from pwmap.explore.jobs import Job, Work
from pwmap.explore.page import FOLDER, in_words

ADDRESS = "127.0.0.1"
NAMES = (ADDRESS, "localhost")
ENDS = {signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)}  # on Windows two
PORT, PORTS = 5007, 20  # the first that is tried, and how many
UNUSED = 2000  # ms that a session is kept after its connection was lost for good
LINGER = 10.0  # s after the last page was closed, so that it can be loaded again
LONGEST = 60.0  # s for one file
POLICY = (
    "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "connect-src 'self' ws:; frame-src 'self'; base-uri 'none'; form-action 'none'"
)


Export = Callable[[str, str], tuple[Any, ...]]
"""Returns the job, and its arguments, for a file name and a query.

The job yields type and content. ValueError if there is no such file or state.
"""

Page = Callable[[Document], None]
Serve = Callable[[Page, Export], None]
"""Serves a page: :func:`serve` with its options set."""


def serve(
    page: Page, export: Export, *, port: int | None, stay: bool, ready: Callable[[str], None]
) -> None:
    """Serve pages until a signal or the last page ends it; OSError if the port is taken.

    ``page`` fills the document of one tab. With ``stay`` it goes on after the last page was closed;
    ``ready`` is called with the address.
    """
    server, found = _started(page, export, port)
    loop: IOLoop = server.io_loop
    ends = [each for each in ENDS if signal.getsignal(each) is not signal.SIG_IGN]
    for number in ends:
        signal.signal(number, lambda *_: loop.add_callback_from_signal(loop.stop))
    watch = PeriodicCallback(_ending(server, loop), 500.0)
    if not stay:
        watch.start()
    loop.add_callback(ready, f"http://{ADDRESS}:{found}/")
    try:
        loop.start()
    finally:
        watch.stop()
        server.stop(wait=False)
        for number in ends:
            signal.signal(number, signal.SIG_IGN)


class _PromptServer(HTTPServer):  # type: ignore[misc]
    """Streams without Nagle's algorithm, which would delay short messages by some 40 ms."""

    def handle_stream(self, stream: IOStream, address: Any) -> None:
        stream.set_nodelay(True)
        stream.set_nodelay = lambda _: None  # the protocol would switch it on again
        super().handle_stream(stream, address)


def _started(page: Page, export: Export, port: int | None) -> tuple[BaseServer, int]:
    sockets, found = _bound(port)
    pages = BokehTornado(
        {"/": Application(FunctionHandler(page))},
        extra_websocket_origins=[f"{name}:{found}" for name in NAMES],
        extra_patterns=[(r"/(?:compare|export/([a-z_]+\.[a-z]+))", _Beside, {"export": export})],
        unused_session_lifetime_milliseconds=UNUSED,
        check_unused_sessions_milliseconds=UNUSED // 2,
        keep_alive_milliseconds=5000,
    )
    http = _PromptServer(pages)
    http.add_sockets(sockets)
    server = BaseServer(IOLoop.current(), pages, http)
    server.start()
    return server, found


def _bound(port: int | None) -> Any:
    """Sockets at a port, by default at the first that is free; OSError with the port if not."""
    *others, last = range(PORT, PORT + PORTS) if port is None else [port]
    for each in others:
        with suppress(OSError):
            return bind_sockets(ADDRESS, each)
    try:
        return bind_sockets(ADDRESS, last)
    except OSError as error:
        which = f"no port from {PORT} to {last} can" if others else f"port {last} cannot"
        raise OSError(f"{which} be used: {error.strerror}; --port takes another one") from None


def _ending(server: Any, loop: IOLoop) -> Callable[[], None]:
    """A periodic function that ends the loop some time after the last page was closed."""
    seen = 0.0

    def look() -> None:
        nonlocal seen
        if any(session.connection_count for session in server.get_sessions()):
            seen = time.monotonic()
        elif seen and time.monotonic() - seen > LINGER:
            loop.stop()

    return look


class _Beside(RequestHandler):  # type: ignore[misc]
    """Serves files, and two pages side by side, to requests for this machine's own names only."""

    def initialize(self, export: Export) -> None:
        self.export = export

    def prepare(self) -> None:
        """Refuse a host name that another site has pointed at this machine."""
        if self.request.host.partition(":")[0] not in NAMES:
            raise HTTPError(403)

    def set_default_headers(self) -> None:
        """Set headers that restrict what a browser may do with the answer."""
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("Content-Security-Policy", POLICY)
        self.set_header("Cache-Control", "no-store")

    async def get(self, file: str | None) -> None:
        """Answer with a file of the state in the query, or an error; two pages without a name."""
        if file is None:
            self._answer("text/html; charset=utf-8", (FOLDER / "compare.html").read_bytes())
            return
        try:
            (made,) = await _made(*self.export(file, self.request.query))
        except (ValueError, TypeError) as error:
            self.set_status(400)
            self._answer("text/plain; charset=utf-8", in_words(error))
        else:
            self.set_header("Content-Disposition", f'attachment; filename="{file}"')
            self._answer(*made)

    def _answer(self, kind: str, content: str | bytes) -> None:
        self.set_header("Content-Type", kind)
        self.finish(content)


async def _made(work: Work, *arguments: Any) -> list[Any]:
    """All results of work in another process; ValueError if it fails."""
    job, found = Job(work, *arguments, seconds=LONGEST), list[Any]()
    try:
        while not job.is_over:
            found += job.results()
            await sleep(0.02)
    finally:
        job.stop()
    if job.sentence:
        raise ValueError(job.sentence)
    return found
