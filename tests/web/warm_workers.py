"""Worker processes of tests that begin as copies of one process, which has loaded what all of them need.

``python -m tests.web.warm_workers ADDRESS`` is that one: it listens at a Unix socket until its stdin ends. A worker of
the server's own is an interpreter that imports and loads compiled loops, which takes seconds.
"""

from __future__ import annotations

import asyncio
import atexit
import gc
import importlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any, NoReturn

from rota.web.workers import process
from rota.web.workers.process import MOST_LINE, WorkerProcess

STANDARD = (0, 1, 2)
# what tasks import when they are asked for something
ASKED_LATER = ("rota.draw", "rota.exports", "rota.web.tasks.planning", "rota.web.tasks.watching")


class CopiedProcess:
    """What a ``WorkerProcess`` uses of a process, for one that is no child: it has ended when it hangs up."""

    def __init__(
        self, pid: int, stdin: asyncio.StreamWriter, stdout: asyncio.StreamReader, hung_up: asyncio.Task[bytes]
    ) -> None:
        self.pid, self.stdin, self.stdout, self._hung_up = pid, stdin, stdout, hung_up

    @property
    def returncode(self) -> int | None:
        """None until it has ended."""
        return 0 if self._hung_up.done() else None

    def kill(self) -> None:
        """End it at once."""
        if not self._hung_up.done():
            os.kill(self.pid, signal.SIGKILL)

    async def wait(self) -> None:
        """Wait until it has ended."""
        await asyncio.shield(self._hung_up)
        self.stdin.close()


def begin_with_copies(address: str) -> None:
    """From now on this process's workers are copies of the process at an address."""

    async def start(settings: Mapping[str, Any]) -> WorkerProcess:
        return WorkerProcess(await _copied(address, settings))  # type: ignore[arg-type]

    WorkerProcess.start = start  # type: ignore[method-assign,assignment]


@contextmanager
def copied_workers() -> Iterator[None]:
    """Meanwhile this process's workers are copies."""
    before = WorkerProcess.start
    begin_with_copies(address_of_one())
    try:
        yield
    finally:
        WorkerProcess.start = before  # type: ignore[method-assign]


async def _copied(address: str, settings: Mapping[str, Any]) -> CopiedProcess:
    """A copy that has been told its settings, with pipes to and from it."""
    loop = asyncio.get_running_loop()
    (its_in, to_it), (from_it, its_out) = os.pipe(), os.pipe()
    line = socket.socket(socket.AF_UNIX)
    line.connect(address)
    asked = {"settings": settings, "environment": process._environment(), "folder": str(Path.cwd())}
    socket.send_fds(line, [json.dumps(asked).encode()], [its_in, its_out, 2])
    line.shutdown(socket.SHUT_WR)
    os.close(its_in)
    os.close(its_out)
    from_line, _writer = await asyncio.open_connection(sock=line)
    pid = int(await from_line.readline())
    stdout = asyncio.StreamReader(limit=MOST_LINE)
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(stdout), os.fdopen(from_it, "rb", 0))
    transport, protocol = await loop.connect_write_pipe(asyncio.streams.FlowControlMixin, os.fdopen(to_it, "wb", 0))
    hung_up = asyncio.create_task(_read_until_it_ends(from_line, _writer))
    return CopiedProcess(pid, asyncio.StreamWriter(transport, protocol, None, loop), stdout, hung_up)


async def _read_until_it_ends(line: asyncio.StreamReader, writer: asyncio.StreamWriter) -> bytes:
    try:
        return await line.read()
    finally:
        writer.close()


@cache
def address_of_one() -> str:
    """Where the process to be copied listens; it is started when it is first asked for, and ends with this one."""
    folder = tempfile.TemporaryDirectory()
    address = f"{folder.name}/workers"
    warm = subprocess.Popen([sys.executable, "-m", __name__, address], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert warm.stdout is not None
    warm.stdout.readline()

    def end() -> None:
        warm.communicate()
        folder.cleanup()

    atexit.register(end)
    return address


def main() -> None:
    """Load, listen, and begin a copy for each that asks, until stdin ends."""
    from rota.web.tasks.preparing import load_planning
    from rota.web.tasks.worker import TASKS

    load_planning()
    for module in (*(function.partition(":")[0] for function in TASKS.values()), *ASKED_LATER):
        importlib.import_module(module)
    gc.collect()
    gc.freeze()
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody asks how they ended
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(sys.argv[1])
    listener.listen()
    print(flush=True)
    while listener in select.select([0, listener], [], [])[0]:
        line, _ = listener.accept()
        asked, streams = _read_request(line)
        if not (pid := os.fork()):
            listener.close()
            _become_worker(asked, streams)
        line.sendall(b"%d\n" % pid)
        line.close()
        for stream in streams:
            os.close(stream)


def _read_request(line: socket.socket) -> tuple[dict[str, Any], list[int]]:
    text, streams, _, _ = socket.recv_fds(line, 2**16, len(STANDARD))
    while part := line.recv(2**16):
        text += part
    return json.loads(text), streams


def _become_worker(asked: dict[str, Any], streams: list[int]) -> NoReturn:
    """What a new interpreter would do; the line to who asked stays open until this process ends."""
    from rota.web.tasks import worker

    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    for stream, number in zip(streams, STANDARD, strict=True):
        os.dup2(stream, number)
        os.close(stream)
    os.environ.clear()
    os.environ.update(asked["environment"])
    os.chdir(asked["folder"])
    sys.argv = ["worker", json.dumps(asked["settings"])]
    try:
        worker.main()
    finally:
        with suppress(OSError):
            sys.stderr.flush()
        os._exit(0)


if __name__ == "__main__":
    main()
