"""Clients that never finish what they ask are hung up on, and others are not."""

from __future__ import annotations

import asyncio

import uvicorn
from starlette.types import Receive, Scope, Send

from rota.web.serving import PatientProtocol


class Hurried(PatientProtocol):
    """The same, in tenths of seconds."""

    head_s, body_s = 0.2, 0.6


async def echo(scope: Scope, receive: Receive, send: Send) -> None:
    """Read the body, and say that it came."""
    if scope["type"] == "http":
        while (await receive()).get("more_body"):
            pass
        await send({"type": "http.response.start", "status": 204, "headers": []})
        await send({"type": "http.response.body", "body": b""})


HEAD = b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 3\r\n"
WHOLE = HEAD + b"\r\nabc"


async def hung_up(*parts: bytes) -> bytes:
    """What the server answers until it hangs up, when it is sent these parts and then nothing."""
    config = uvicorn.Config(
        echo, http=Hurried, port=0, log_level="error", ws="none", lifespan="off", timeout_keep_alive=60
    )
    server = uvicorn.Server(config)
    task = asyncio.create_task(server.serve())
    while not server.started:
        await asyncio.sleep(0.01)
    port = server.servers[0].sockets[0].getsockname()[1]
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    answered = b""
    try:
        async with asyncio.timeout(20):
            for part in parts:
                writer.write(part)
                if part == WHOLE:
                    answered = await reader.readuntil(b"\r\n\r\n")
            answered += await reader.read()
    except ConnectionResetError:
        pass
    writer.close()
    server.should_exit = True
    await task
    return answered


def test_who_says_nothing_or_half_a_head_or_half_a_body_is_hung_up_on() -> None:
    for parts in ((), (HEAD,), (HEAD + b"\r\n", b"ab")):
        assert asyncio.run(hung_up(*parts)) == b""


def test_a_second_request_that_is_not_finished_is_hung_up_on_after_the_answer_to_the_first() -> None:
    assert asyncio.run(hung_up(WHOLE, HEAD)).startswith(b"HTTP/1.1 204")
