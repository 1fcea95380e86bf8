"""Programs of tests that begin as copies of one process, which has loaded what they need.

``python -m tests.warm_process ADDRESS`` is that one: it listens at a Unix socket until its stdin ends. An interpreter
would import all of Rota and load compiled loops, which takes two to five seconds.
"""

from __future__ import annotations

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
import traceback
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NoReturn

STANDARD = (0, 1, 2)
# what commands and the page's tasks import when they are asked for something
ASKED_LATER = (
    "rota.command.cli", "rota.command.plan", "rota.draw", "rota.exports", "rota.web.tasks.planning",
    "rota.web.tasks.watching",
)  # fmt: skip


@cache
def address_of_one() -> str:
    """Where the process to be copied listens; it is started when it is first asked for, and ends with this one."""
    folder = tempfile.TemporaryDirectory()
    address = f"{folder.name}/copies"
    command = [sys.executable, "-m", __name__, address]
    # tests may have gone to folders of their own
    warm = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=Path(__file__).parents[1])
    assert warm.stdout is not None
    assert warm.stdout.readline(), "it ended before it listened"

    def end() -> None:
        warm.communicate()
        folder.cleanup()

    atexit.register(end)
    return address


def begin_copy(
    address: str, code: str, arguments: Sequence[str], streams: Sequence[int], environment: Mapping[str, str]
) -> socket.socket:
    """Begin a copy that runs code as ``python -c`` would, in this folder, with these three files as stdin and so on.

    The line to it tells the number of the process, and, when it has ended, its exit code.
    """
    line = socket.socket(socket.AF_UNIX)
    line.connect(address)
    asked = {"code": code, "arguments": list(arguments), "environment": dict(environment), "folder": str(Path.cwd())}
    socket.send_fds(line, [json.dumps(asked).encode()], list(streams))
    line.shutdown(socket.SHUT_WR)
    return line


def run_copy(code: str, *arguments: str, timeout: float = 120.0) -> subprocess.CompletedProcess[str]:
    """What `python -c CODE ARGUMENTS` would do, by a copy, to its end."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err, open(os.devnull) as nothing:
        streams = [nothing.fileno(), out.fileno(), err.fileno()]
        with begin_copy(address_of_one(), code, arguments, streams, os.environ) as line, line.makefile() as told:
            line.settimeout(timeout)
            pid = int(told.readline())
            try:
                returncode = int(told.readline())
            except TimeoutError:
                os.kill(pid, signal.SIGKILL)
                raise
        said = []
        for stream in (out, err):
            stream.seek(0)
            said.append(stream.read().decode())
    return subprocess.CompletedProcess([code, *arguments], returncode, *said)


def main() -> None:
    """Load, listen, and begin a copy for each that asks, until stdin ends."""
    from rota.web.tasks.preparing import load_planning
    from rota.web.tasks.worker import TASKS

    load_planning()
    for module in (*(function.partition(":")[0] for function in TASKS.values()), *ASKED_LATER):
        importlib.import_module(module)
    gc.collect()
    gc.freeze()
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody asks how those that wait for copies ended
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(sys.argv[1])
    listener.listen()
    print(flush=True)
    while listener in select.select([0, listener], [], [])[0]:
        line, _ = listener.accept()
        asked, streams = _read_request(line)
        if not os.fork():
            listener.close()
            _tell_of_copy(line, asked, streams)
        line.close()
        for stream in streams:
            os.close(stream)


def _read_request(line: socket.socket) -> tuple[dict[str, Any], list[int]]:
    text, streams, _, _ = socket.recv_fds(line, 2**16, len(STANDARD))
    while part := line.recv(2**16):
        text += part
    return json.loads(text), streams


def _tell_of_copy(line: socket.socket, asked: dict[str, Any], streams: list[int]) -> NoReturn:
    """Begin the copy, tell its number, and how it ended."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    if not (pid := os.fork()):
        line.close()
        _become(asked, streams)
    for stream in (*streams, *STANDARD):
        os.close(stream)
    try:
        line.sendall(b"%d\n" % pid)
        line.sendall(b"%d\n" % os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))
    finally:
        os._exit(0)


def _become(asked: dict[str, Any], streams: list[int]) -> NoReturn:
    """What a new interpreter would do."""
    for stream, number in zip(streams, STANDARD, strict=True):
        os.dup2(stream, number)
        os.close(stream)
    os.environ.clear()
    os.environ.update(asked["environment"])
    os.chdir(asked["folder"])
    sys.argv = ["-c", *asked["arguments"]]
    code: object = 0
    try:
        exec(compile(asked["code"], "<string>", "exec"), {"__name__": "__main__"})
    except SystemExit as end:
        code = end.code or 0
    except BaseException:
        traceback.print_exc()
        code = 1
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code if isinstance(code, int) else 1)


if __name__ == "__main__":
    main()
