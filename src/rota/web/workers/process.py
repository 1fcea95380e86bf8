"""One worker process: lines of JSON to it and from it, each with bytes behind it; it ends with its server."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rota.web.refusal import Json

MOST_LINE = 2**20  # bytes of a line of JSON; what is larger comes as bytes behind it
END_S = 5.0  # how long a process may take to end by itself


class WorkerGone(Exception):  # noqa: N818 (it says what happened; the callers tell people)
    """The process ended, or was ended, before it answered."""


class WorkerProcess:
    """A process of ``rota.web.tasks.worker``; messages are (JSON, bytes) both ways."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self._process = process
        self._sending = asyncio.Lock()

    @classmethod
    async def start(cls, settings: Mapping[str, Any]) -> WorkerProcess:
        """A new process, told its settings."""
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-m", "rota.web.tasks.worker", json.dumps(settings),
            stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE, limit=MOST_LINE, env=_environment(),
        )  # fmt: skip
        return cls(process)

    @property
    def alive(self) -> bool:
        """Whether it has not ended."""
        return self._process.returncode is None

    @property
    def pid(self) -> int:
        """The process's number."""
        return self._process.pid

    @property
    def memory_bytes(self) -> int:
        """What it holds in memory; 0 where the system does not tell."""
        try:
            pages = int(Path(f"/proc/{self._process.pid}/statm").read_text().split()[1])
        except (OSError, ValueError, IndexError):
            return 0
        return pages * os.sysconf("SC_PAGE_SIZE")

    async def send(self, message: Json, content: bytes = b"") -> None:
        """Send a message; WorkerGone when nobody is there."""
        line = json.dumps({**message, "bytes": len(content)}).encode() + b"\n"
        assert self._process.stdin is not None
        try:
            async with self._sending:
                self._process.stdin.write(line + content)
                await self._process.stdin.drain()
        except (OSError, RuntimeError) as error:
            raise WorkerGone(str(error)) from error

    async def receive(self) -> tuple[Json, bytes]:
        """The next message; WorkerGone when there comes none any more."""
        assert self._process.stdout is not None
        try:
            line = await self._process.stdout.readline()
            message: Json = json.loads(line)
            content = await self._process.stdout.readexactly(message.pop("bytes"))
        except (OSError, ValueError, EOFError) as error:  # ValueError: a line cut off, or too long
            raise WorkerGone(str(error)) from error
        return message, content

    async def end(self, within_s: float = END_S) -> None:
        """Close its input, upon which it ends by itself; kill it if it does not."""
        if self._process.stdin is not None:
            self._process.stdin.close()
        try:
            async with asyncio.timeout(within_s):
                await self._process.wait()
        except TimeoutError:
            await self.kill()

    async def kill(self) -> None:
        """End it at once."""
        with contextlib.suppress(ProcessLookupError):
            self._process.kill()
        await self._process.wait()


def _environment() -> dict[str, str]:
    """The server's environment, with pictures drawn to files only."""
    return {**os.environ, "MPLBACKEND": "Agg", "PYTHONIOENCODING": "utf-8"}
