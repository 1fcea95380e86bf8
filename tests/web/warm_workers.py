"""Worker processes of the page's tests that begin as copies of a process that has loaded what they need."""

from __future__ import annotations

import asyncio
import json
import os
import signal
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from tests.warm_process import address_of_one, begin_copy

from rota.web.workers import process
from rota.web.workers.process import MOST_LINE, WorkerProcess

WORKER = "from rota.web.tasks.worker import main; main()"
INTERPRETER = WorkerProcess.start


class CopiedProcess:
    """What a ``WorkerProcess`` uses of a process, for one that is no child of this one."""

    def __init__(
        self, pid: int, stdin: asyncio.StreamWriter, stdout: asyncio.StreamReader, ended: asyncio.Task[int]
    ) -> None:
        self.pid, self.stdin, self.stdout, self._ended = pid, stdin, stdout, ended

    @property
    def returncode(self) -> int | None:
        """None until it has ended."""
        return self._ended.result() if self._ended.done() else None

    def kill(self) -> None:
        """End it at once."""
        if not self._ended.done():
            os.kill(self.pid, signal.SIGKILL)

    async def wait(self) -> int:
        """Wait until it has ended."""
        code = await asyncio.shield(self._ended)
        self.stdin.close()
        return code


def begin_with_copies(address: str) -> None:
    """From now on this process's workers are copies of the process at an address."""

    async def start(settings: Mapping[str, Any]) -> WorkerProcess:
        return WorkerProcess(await _copied(address, settings))  # type: ignore[arg-type]

    WorkerProcess.start = start  # type: ignore[method-assign,assignment]


@contextmanager
def workers(*, copied: bool) -> Iterator[None]:
    """Meanwhile this process's workers are copies, or interpreters of their own, whatever they were."""
    before = WorkerProcess.start
    if copied:
        begin_with_copies(address_of_one())
    else:
        WorkerProcess.start = INTERPRETER  # type: ignore[method-assign]
    try:
        yield
    finally:
        WorkerProcess.start = before  # type: ignore[method-assign]


async def _copied(address: str, settings: Mapping[str, Any]) -> CopiedProcess:
    """A copy that has been told its settings, with pipes to and from it."""
    loop = asyncio.get_running_loop()
    (its_in, to_it), (from_it, its_out) = os.pipe(), os.pipe()
    line = begin_copy(address, WORKER, [json.dumps(settings)], [its_in, its_out, 2], process._environment())
    os.close(its_in)
    os.close(its_out)
    told, writer = await asyncio.open_connection(sock=line)
    pid = int(await told.readline())
    stdout = asyncio.StreamReader(limit=MOST_LINE)
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(stdout), os.fdopen(from_it, "rb", 0))
    transport, protocol = await loop.connect_write_pipe(asyncio.streams.FlowControlMixin, os.fdopen(to_it, "wb", 0))
    stdin = asyncio.StreamWriter(transport, protocol, None, loop)
    return CopiedProcess(pid, stdin, stdout, asyncio.create_task(_exit_code(told, writer)))


async def _exit_code(told: asyncio.StreamReader, writer: asyncio.StreamWriter) -> int:
    try:
        return int(await told.readline())
    finally:
        writer.close()
