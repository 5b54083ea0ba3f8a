"""How pages are served."""

import asyncio
import socket

import pytest

pytest.importorskip("bokeh")
from tornado.httpserver import HTTPServer
from tornado.iostream import IOStream
from tornado.web import Application

from pwmap.explore.serving import ADDRESS, _bound, _PromptServer


def test_parts_of_a_letter_never_wait_for_a_receipt(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not even when tornado would let them wait again, as it does after an answer."""
    streams = list[IOStream]()
    monkeypatch.setattr(HTTPServer, "handle_stream", lambda _, stream, __: streams.append(stream))

    async def waits() -> list[int]:
        with socket.create_server(("127.0.0.1", 0)) as listening:
            address = listening.getsockname()
            with socket.create_connection(address) as page:
                page.setblocking(False)
                _PromptServer(Application()).handle_stream(IOStream(listening.accept()[0]), address)
                (stream,) = streams
                option = socket.IPPROTO_TCP, socket.TCP_NODELAY
                at_first = stream.socket.getsockopt(*option)
                stream.set_nodelay(False)
                later = stream.socket.getsockopt(*option)
                stream.close()
                return [at_first, later]

    assert asyncio.run(waits()) == [1, 1]


# tornado leaves the socket that it could not bind to Python
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_port_that_is_taken_is_named() -> None:
    with socket.create_server((ADDRESS, 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(OSError, match=f"port {port} cannot be used: .*; --port takes another"):
            _bound(port)
