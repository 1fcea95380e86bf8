"""`rota serve` as a process, and clients on loopback that cost little themselves: one connection each, kept open."""

from __future__ import annotations

import asyncio
import json
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

Json = dict[str, Any]


@contextmanager
def page_server(data: Path, *options: str) -> Iterator[tuple[int, int]]:
    """A server of the folder on a free port; the port and the process's number are the value of the block."""
    command = [sys.executable, "-m", "rota", "serve", "--no-open", "--port", "0", "--data", str(data), *options]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    try:
        lines = iter(process.stderr.readline, "")
        port = next(int(found[1]) for line in lines if (found := re.search(r"127\.0\.0\.1:(\d+)/", line)))
        yield port, process.pid
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(30)
        process.stderr.close()


class Client:
    """A connection that sends a request, reads its answer, and sends the next one."""

    def __init__(self, port: int) -> None:
        self._port = port
        self._streams: tuple[asyncio.StreamReader, asyncio.StreamWriter] | None = None

    async def ask(self, method: str, path: str, body: Json | None = None) -> tuple[int, bytes]:
        """The status and the body of an answer."""
        if self._streams is None or self._streams[0].at_eof():  # servers hang up when nothing is asked for long
            self._streams = await asyncio.open_connection("127.0.0.1", self._port)
        reader, writer = self._streams
        content = b"" if body is None else json.dumps(body).encode()
        kind = "" if body is None else "Content-Type: application/json\r\n"
        head = (
            f"{method} {path} HTTP/1.1\r\nHost: 127.0.0.1:{self._port}\r\n{kind}Content-Length: {len(content)}\r\n\r\n"
        )
        writer.write(head.encode() + content)
        answer = (await reader.readuntil(b"\r\n\r\n")).decode("latin-1").lower()
        status = int(answer.split(" ", 2)[1])
        length = re.search(r"content-length: (\d+)", answer)
        return status, await reader.readexactly(int(length[1]) if length else 0)

    async def json(self, method: str, path: str, body: Json | None = None) -> Any:
        """What an answer holds; RuntimeError for a refusal."""
        status, content = await self.ask(method, path, body)
        if status >= 400:
            raise RuntimeError(f"{method} {path}: {status} {content[:300]!r}")
        return json.loads(content)

    def close(self) -> None:
        """Hang up."""
        if self._streams is not None:
            self._streams[1].close()
