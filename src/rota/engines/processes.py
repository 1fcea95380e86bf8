"""An executor whose workers are processes of this machine; a worker that is killed costs only what it worked on."""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import Any, NamedTuple, ParamSpec, TypeVar

from rota.engines.worker import read_message, write_message
from rota.errors import RotaError

Result = TypeVar("Result")
Given = ParamSpec("Given")

MOST_DEATHS = 3  # of processes that did the same call: then it is at fault, or the machine is too small for it
END_S = 5.0  # how long an idle process may take to end by itself


class WorkerDied(RotaError):  # noqa: N818 (it says what happened)
    """Every process that did a call ended before it answered; the message says by what."""


class LocalProcesses(Executor):
    """Processes of this machine that do one call each at a time.

    ``concurrent.futures.ProcessPoolExecutor`` gives up all calls when one of its processes is killed; here a new
    process takes the place of the killed one and does its call again. After ``MOST_DEATHS`` the call's future has the
    exception WorkerDied. The processes are fresh interpreters, which do not run the caller's ``__main__``, so that
    functions and arguments come from modules. They end with this process, however it ends.
    """

    def __init__(self, processes: int | None = None, *, threads: int = 1) -> None:
        """processes: how many; None: one for each core. threads: of each. They begin when needed."""
        self.processes = processes or os.cpu_count() or 1
        self._environment = {**os.environ, "NUMBA_NUM_THREADS": str(threads), "MPLBACKEND": "Agg"}
        self._calls: queue.SimpleQueue[_Call | None] = queue.SimpleQueue()
        self._servers: list[threading.Thread] = []
        self._workers: set[_Worker] = set()
        self._lock = threading.Lock()
        self._unfinished = 0  # calls
        self._closed = self._killed = False

    @property
    def pids(self) -> list[int]:
        """The numbers of the processes that are there now."""
        with self._lock:
            return [worker.pid for worker in self._workers]

    def submit(self, fn: Callable[Given, Result], /, *args: Given.args, **kwargs: Given.kwargs) -> Future[Result]:
        """Have a process call the function; raises what pickling it and its arguments raises."""
        call = _Call(Future(), pickle.dumps((fn, args, kwargs), protocol=pickle.HIGHEST_PROTOCOL))
        with self._lock:
            if self._closed:
                raise RuntimeError("cannot submit after shutdown")
            self._unfinished += 1
            self._calls.put(call)
            if len(self._servers) < min(self._unfinished, self.processes):
                self._servers.append(threading.Thread(target=self._serve, daemon=True))
                self._servers[-1].start()
        return call.future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes once all calls are done; cancel_futures: once those are that have begun."""
        with self._lock:
            already, self._closed = self._closed, True
        if cancel_futures:
            self._cancel_waiting()
        if not already:
            for _ in self._servers:
                self._calls.put(None)
        if wait:
            for server in self._servers:
                server.join()

    def kill(self) -> None:
        """End the processes at once; calls that are not done are cancelled, those begun have WorkerDied."""
        self._killed = True
        self.shutdown(wait=False, cancel_futures=True)
        with self._lock:
            for worker in self._workers:
                worker.kill()
        self.shutdown(wait=True)

    def _cancel_waiting(self) -> None:
        with contextlib.suppress(queue.Empty):
            while (call := self._calls.get_nowait()) is not None:
                call.future.cancel()
                call.future.set_running_or_notify_cancel()
            self._calls.put(None)  # it tells a server to end

    def _serve(self) -> None:
        """Do calls, one after another, in a process that is made anew when it is gone."""
        worker: _Worker | None = None
        while (call := self._calls.get()) is not None:
            if call.future.set_running_or_notify_cancel():
                worker = self._do(call, worker)
            with self._lock:
                self._unfinished -= 1
        if worker is not None:
            worker.end()
            self._forget(worker)

    def _do(self, call: _Call, worker: _Worker | None) -> _Worker | None:
        """Do a call; returns the process that did it, None where it is gone."""
        ends: list[str] = []
        while len(ends) < MOST_DEATHS and not self._killed:
            try:
                worker = worker or self._start_worker()
                well, value = pickle.loads(worker.ask(call.content))
            except _Gone as gone:
                ends.append(str(gone))
                if worker is not None:
                    self._forget(worker)
                worker = None
            except BaseException as error:  # an answer that cannot be read
                call.future.set_exception(error)
                return worker
            else:
                (call.future.set_result if well else call.future.set_exception)(value)
                return worker
        why = (
            "the processes were ended" if self._killed else f"each of {MOST_DEATHS} processes ended: {', '.join(ends)}"
        )
        call.future.set_exception(WorkerDied(why))
        return None

    def _start_worker(self) -> _Worker:
        worker = _Worker(self._environment)
        with self._lock:
            self._workers.add(worker)
        if self._killed:
            worker.kill()
        return worker

    def _forget(self, worker: _Worker) -> None:
        with self._lock:
            self._workers.discard(worker)


class _Call(NamedTuple):
    """A call, pickled, and what becomes of it."""

    future: Future[Any]
    content: bytes


class _Gone(Exception):  # noqa: N818
    """A process ended before it answered; by what."""


class _Worker:
    """One process of ``rota.engines.worker``."""

    def __init__(self, environment: dict[str, str]) -> None:
        command = [sys.executable, "-P", "-m", "rota.engines.worker", environment["NUMBA_NUM_THREADS"]]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment)
        self._told_path = False

    @property
    def pid(self) -> int:
        """The process's number."""
        return self._process.pid

    def ask(self, content: bytes) -> bytes:
        """The answer to a call; _Gone when the process ends before it."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        answer = None
        with contextlib.suppress(OSError):
            if not self._told_path:
                write_message(self._process.stdin, pickle.dumps(sys.path))  # type: ignore[arg-type]
                self._told_path = True
            write_message(self._process.stdin, content)  # type: ignore[arg-type]
            answer = read_message(self._process.stdout)  # type: ignore[arg-type]
        if answer is None:
            self.end()
            raise _Gone(exit_in_words(self._process.returncode))
        return answer

    def end(self) -> None:
        """Close its input, upon which it ends by itself; kill it if it does not."""
        assert self._process.stdin is not None
        with contextlib.suppress(OSError):
            self._process.stdin.close()
        try:
            self._process.wait(END_S)
        except subprocess.TimeoutExpired:
            self.kill()

    def kill(self) -> None:
        """End it at once."""
        self._process.kill()
        self._process.wait()


def exit_in_words(code: int) -> str:
    """The exit status of a process, in words."""
    return f"exit status {code}" if code >= 0 else signal.Signals(-code).name
