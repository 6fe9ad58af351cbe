"""The server's socket."""

import asyncio
import socket

from acf_jax.app.serve import HOST, _listen


def test_small_answers_are_sent_at_once() -> None:
    """Else the second part of each waits for the browser's acknowledgement, 40 ms."""

    async def accepted() -> int:
        told = asyncio.get_running_loop().create_future()

        def take(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            taken = writer.get_extra_info("socket")
            told.set_result(taken.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))
            writer.close()

        listening = _listen(0)
        async with await asyncio.start_server(take, sock=listening):
            _, writer = await asyncio.open_connection(HOST, listening.getsockname()[1])
            value: int = await told
            writer.close()
            return value

    assert asyncio.run(accepted())
