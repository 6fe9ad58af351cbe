"""The server: on the loopback address of this machine, until Ctrl-C."""

import asyncio
import logging
import socket
import webbrowser
from collections.abc import Callable
from pathlib import Path

import uvicorn

from acf_jax.app.server import make_app, new_token
from acf_jax.errors import InputError

HOST = "127.0.0.1"
WAITING = 64  # requests that wait until the server takes them
CLOSING_S = 1  # that open answers, such as the progress of a job, get when the server ends


def serve(folders: list[Path], port: int, shows: bool, say: Callable[[str], object]) -> None:
    """Answer until Ctrl-C.

    **Arguments:** `port`: 0 takes a free one. `shows`: open a browser. `say`: told the address.

    **Raises:** `InputError` where the port cannot be had.
    """
    with _listen(port) as listening:
        port = listening.getsockname()[1]
        token = new_token()
        config = uvicorn.Config(
            make_app(folders, token, port),
            log_level="error",
            access_log=False,
            server_header=False,
            proxy_headers=False,
            ws="none",
            timeout_graceful_shutdown=CLOSING_S,
        )
        logging.getLogger("uvicorn.error").addFilter(_is_told)
        address = f"http://{HOST}:{port}/?token={token}"
        say(
            f"{address}\nopen it in a browser on this machine; Ctrl-C ends the app, not a diagnosis that runs"
        )
        if shows:
            webbrowser.open(address)
        uvicorn.Server(config).run(sockets=[listening])


def _listen(port: int) -> socket.socket:
    # a socket that says that it is TCP: only then asyncio sends small answers at once, and not 40 ms later
    listening = socket.socket(proto=socket.IPPROTO_TCP)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((HOST, port))
        listening.listen(WAITING)  # a browser that is quicker than the server waits
    except OSError as error:
        listening.close()
        raise InputError(
            f"--port {port}: cannot be had ({error.strerror}); name another, or leave it out"
        ) from None
    return listening


def _is_told(record: logging.LogRecord) -> bool:
    """Not that an answer was on its way when Ctrl-C came: uvicorn prints it as a fault, with its traceback."""
    return not (record.exc_info and isinstance(record.exc_info[1], asyncio.CancelledError))
