"""A worker process: ``python -m rota.web.tasks.worker SETTINGS``. It reads tasks from stdin until that ends.

Messages are a line of JSON with ``bytes``, the number of bytes that follow it. A process whose server is gone, however
it ended, ends at once: its stdin is closed.
"""

from __future__ import annotations

import importlib
import json
import os
import queue
import sys
import threading
import traceback
from pathlib import Path
from typing import BinaryIO

from rota.errors import MissionError, RotaError
from rota.web.refusal import Json, Refusal, unkept
from rota.web.store.database import Database
from rota.web.tasks.context import Context, with_given_names

# memory that is asked for and not used yet counts here, and a library may loop where it gets none
ROOM_BYTES = 2**30
NO_ROOM = ("bad_alloc", "can't start new thread")  # how GEOS and Python's threads say what others call MemoryError
TASKS = {
    "validate": "rota.web.tasks.validate:validate",
    "read": "rota.web.tasks.read:read_upload",
    "example": "rota.web.tasks.read:read_example",
    "yaml": "rota.web.tasks.read:mission_yaml",
    "keep_plan": "rota.web.tasks.show:keep_uploaded_plan",
    "playback": "rota.web.tasks.show:playback",
    "picture": "rota.web.tasks.show:picture",
    "page": "rota.web.tasks.show:page",
    "require_change": "rota.web.tasks.show:require_change",
    "export": "rota.web.tasks.export:export",
    "schema": "rota.web.tasks.about:mission_schema_text",
    "require_plannable": "rota.web.tasks.validate:require_plannable",
    "openapi": "rota.web.interface.document:openapi",
    "prepare": "rota.web.tasks.preparing:prepare",
    "about": "rota.web.tasks.about:about",
}

Inbox = queue.Queue[tuple[Json, bytes]]


class Outbox:
    """Messages to the server, from any thread. Whatever else is printed goes to stderr."""

    def __init__(self) -> None:
        self._stream = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
        self._sending = threading.Lock()

    def send(self, message: Json, content: bytes = b"") -> None:
        """Send a message; a server that is gone ends the process."""
        line = json.dumps({**message, "bytes": len(content)}, allow_nan=False).encode() + b"\n"
        try:
            with self._sending:
                self._stream.write(line + content)
                self._stream.flush()
        except OSError:
            os._exit(1)


def main() -> None:
    """The process: its settings are the first argument, as JSON."""
    settings: Json = json.loads(sys.argv[1])
    outbox = Outbox()
    limit_memory(settings["memory_bytes"])
    lower_priority()
    inbox: Inbox = queue.Queue()
    stop = threading.Event()
    context = Context(database=Database(Path(settings["data"])), **settings["counts"])
    threading.Thread(target=_listen, args=(sys.stdin.buffer, inbox, stop), daemon=True).start()
    if settings["role"] == "planning":
        _plan(context, inbox, outbox, stop)
    elif settings["role"] == "watching":
        from rota.web.tasks.watching import watch_fleet

        message, _ = inbox.get()
        outbox.send(watch_fleet(context, message, outbox.send, stop))
    else:
        _serve(context, inbox, outbox)


def lower_priority() -> None:
    """Let the server come first, where the system lets us say so."""
    if hasattr(os, "nice"):
        os.nice(5)


def _listen(stream: BinaryIO, inbox: Inbox, stop: threading.Event) -> None:
    """Hand on what the server sends; end the process with it."""
    while line := stream.readline():
        message: Json = json.loads(line)
        content = stream.read(message.pop("bytes"))
        if message.get("stop"):
            stop.set()
        else:
            inbox.put((message, content))
    os._exit(0)


def _serve(context: Context, inbox: Inbox, outbox: Outbox) -> None:
    """Tasks, one after another."""
    while True:
        message, content = inbox.get()
        try:
            outbox.send(*do_task(context, message, content))
        except Refusal as refusal:
            outbox.send(refusal_as_message(refusal))
        except MissionError as error:
            outbox.send(refusal_as_message(Refusal(422, "the mission has faults", _plain_faults(error))))
        except RotaError as error:
            outbox.send(refusal_as_message(Refusal(422, str(error))))
        except Exception as error:
            outbox.send(refusal_as_message(_failure(error)))


def _failure(error: Exception) -> Refusal:
    """What a task that failed is answered with; a fault of ours goes to the log."""
    if is_out_of_memory(error):
        return Refusal(413, "this needs more memory than the server gives to one request")
    traceback.print_exception(error)
    return unkept(error) or Refusal(500, "a fault in Rota, not in what was sent; the server's log has it")


def do_task(context: Context, message: Json, content: bytes) -> tuple[Json, bytes]:
    """What the function of a task answers."""
    module, _, name = TASKS[message["task"]].partition(":")
    answer: tuple[Json, bytes] = getattr(importlib.import_module(module), name)(context, message, content)
    return answer


def refusal_as_message(refusal: Refusal) -> Json:
    """A refusal as a message."""
    faults = [{**fault, "message": with_given_names(fault["message"])} for fault in refusal.faults]
    return {"refused": {"status": refusal.status, "message": with_given_names(refusal.message), "faults": faults}}


def _plain_faults(error: MissionError) -> list[Json]:
    """Faults that have no place but in words."""
    return [{"field": "", "path": [], "message": fault} for fault in error.faults]


def _plan(context: Context, inbox: Inbox, outbox: Outbox, stop: threading.Event) -> None:
    """One job, then the end; until it comes, what planning needs is loaded, if that was asked for."""
    from rota.web.tasks.planning import PlanningJob

    message, _ = inbox.get()
    if message.get("task") == "prepare":
        from rota.web.tasks.preparing import load_planning

        load_planning()
        message, _ = inbox.get()
    try:
        outbox.send(PlanningJob(context, message["job"], outbox.send, stop).run())
    except Exception as error:
        traceback.print_exc()
        told = str(unkept(error) or "a fault in Rota, not in the mission; the server's log has it")
        if is_out_of_memory(error):
            told = "planning needed more memory than is allowed"
        outbox.send({"event": "ended", "outcome": "failed", "message": told})


def is_out_of_memory(error: Exception) -> bool:
    """Whether an error says that memory was refused, whichever library was the one to ask for it."""
    return isinstance(error, MemoryError) or any(said in str(error) for said in NO_ROOM)


def limit_memory(most_bytes: int) -> None:
    """Let allocations beyond ``most_bytes``, and some room, fail; data only is counted, since loops map much more.

    The server ends planning processes that take more before that; this is for those that grow at a bound. Without
    effect on systems that know no such limit (Windows, macOS).
    """
    if sys.platform != "linux":
        return
    import resource

    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    most_bytes += ROOM_BYTES
    soft = most_bytes if hard == resource.RLIM_INFINITY else min(most_bytes, hard)
    resource.setrlimit(resource.RLIMIT_DATA, (soft, hard))


if __name__ == "__main__":
    main()
