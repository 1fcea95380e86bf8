"""A worker process: ``python -P -m rota.engines.worker THREADS``. It does what comes on stdin, one call after another.

A message is its length, eight bytes, and then a pickle of so many bytes. The first one is the parent's ``sys.path``,
the others are (function, arguments, named arguments); each is answered by a pickle of (True, result) or (False,
exception). A process whose parent is gone, however it ended, ends at once: its stdin is closed.
"""

from __future__ import annotations

import os
import pickle
import queue
import signal
import struct
import sys
import threading
import traceback
from typing import BinaryIO

from rota.planning.stopping import work_left_running

LENGTH = struct.Struct("<Q")


def write_message(stream: BinaryIO, content: bytes) -> None:
    """Send the bytes of one message."""
    stream.write(LENGTH.pack(len(content)))
    stream.write(content)
    stream.flush()


def read_message(stream: BinaryIO) -> bytes | None:
    """The bytes of the next message; None where there comes none any more, or a part of one."""
    head = stream.read(LENGTH.size)
    if len(head) < LENGTH.size:
        return None
    (length,) = LENGTH.unpack(head)
    content = stream.read(length)
    return content if len(content) == length else None


def main() -> None:
    """The process; its argument is how many threads a call may have."""
    threads = int(sys.argv[1])
    # whatever begins threads asks for the number of cores; this process has its share of them
    os.cpu_count = lambda: threads
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches every process of a terminal; the parent decides
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # whatever else is printed
    inbox: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(sys.stdin.buffer, inbox), daemon=True).start()
    sys.path[:] = pickle.loads(inbox.get())
    while True:
        answer = answer_call(inbox.get())
        try:
            write_message(answers, answer)
        except OSError:
            os._exit(1)
        if work_left_running():  # it would slow down the calls to come; a new process does these
            os._exit(0)


def _listen(stream: BinaryIO, inbox: queue.SimpleQueue[bytes]) -> None:
    """Hand on what the parent sends; end the process with it."""
    while (content := read_message(stream)) is not None:
        inbox.put(content)
    os._exit(0)


def answer_call(content: bytes) -> bytes:
    """The answer to one call."""
    try:
        function, arguments, named = pickle.loads(content)
        return pickle.dumps((True, function(*arguments, **named)), protocol=pickle.HIGHEST_PROTOCOL)
    except BaseException as error:
        return pickle.dumps((False, portable(error)), protocol=pickle.HIGHEST_PROTOCOL)


def portable(error: BaseException) -> BaseException:
    """The exception with its traceback as a note; another one in its place where it cannot be sent or read back."""
    error.add_note("".join(traceback.format_exception(error)).rstrip())
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        other: BaseException = RuntimeError(f"{type(error).__name__}: {error}")
        other.__notes__ = error.__notes__
        return other
    return error


if __name__ == "__main__":
    main()
