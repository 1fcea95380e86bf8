"""Workers as a command asks for them: those of a cluster where an address is given, processes of this machine else."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager

from rota.engines.processes import LocalProcesses
from rota.errors import RotaError


@contextmanager
def workers(address: str | None, processes: int | None = None) -> Iterator[Executor]:
    """An executor within the block; what it still does at the end of the block is given up.

    address: of a scheduler, as ``cluster`` takes it, which it raises RotaError for as well. processes: without one, how
    many; None: one for each core.
    """
    if address is None:
        local = LocalProcesses(processes)
        try:
            yield local
        finally:
            local.kill()
        return
    from rota.engines.cluster import close, cluster

    executor = cluster(address)
    try:
        yield executor
    finally:
        close(executor)


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def calls_at_once(executor: Executor) -> int:
    """How many calls the executor can do side by side now; 0 for a cluster that no worker has joined yet.

    Raises RotaError for a cluster that is lost.
    """
    client = getattr(executor, "_client", None)
    if client is not None:
        try:
            return sum(client.nthreads().values())
        except OSError as error:
            raise RotaError(f"the connection to the cluster was lost: {error}") from error
    return executor.processes if isinstance(executor, LocalProcesses) else os.cpu_count() or 1
