# mypy: disallow-untyped-calls=False
"""An executor whose workers are those of a dask.distributed scheduler, on this machine or on many."""

from __future__ import annotations

import re
import socket
from concurrent.futures import Executor
from importlib.metadata import version

from rota.errors import RotaError

CONNECT_S = 20.0


def cluster(address: str) -> Executor:
    """The workers of the scheduler at an address such as ``tcp://10.0.0.1:8786``; more may join while it works.

    A call whose worker ends is done again by another; after the scheduler's ``allowed-failures`` (3) its future has the
    exception ``distributed.KilledWorker``. A call that a worker has begun is done to its end even when it is cancelled.

    Raises RotaError when dask.distributed is not installed, no scheduler answers, or a worker has another version of
    Rota, or none.
    """
    try:
        import dask
        from distributed import Client
    except ImportError:
        raise RotaError("a cluster needs dask.distributed: pip install 'rota[cluster]'") from None
    _require_listener(address)
    # a problem of tens of megabytes is sent once; nobody who runs a command can do anything about it
    dask.config.set({"distributed.admin.large-graph-warning-threshold": "1GiB"})
    try:
        client = Client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise RotaError(f"no scheduler answers at {address!r}: {error}") from error
    executor: Executor = client.get_executor(pure=False)
    try:
        _require_our_version(client.run(_rota_version))
    except ModuleNotFoundError as error:
        close(executor)
        raise RotaError(f"a worker of {address} cannot load Rota: {error}") from error
    except RotaError:
        close(executor)
        raise
    return executor


def _require_listener(address: str) -> None:
    """Refuse an address that is none, or at which nobody listens: a client that cannot connect lingers for long."""
    named = re.fullmatch(r"(?:tcp|tls)://(\[[^\]]+\]|[^:/]+):(\d{1,5})", address)
    if named is None:
        raise RotaError(f"{address!r} is no address of a scheduler; one such as tcp://10.0.0.1:8786 is needed")
    try:
        socket.create_connection((named[1].strip("[]"), int(named[2])), timeout=CONNECT_S).close()
    except (OSError, OverflowError) as error:
        raise RotaError(f"no scheduler answers at {address!r}: {error}") from error


def close(executor: Executor) -> None:
    """End the connection to a cluster; what waits there is cancelled."""
    executor.shutdown(wait=False)
    executor._client.close()  # type: ignore[attr-defined]


def _require_our_version(theirs: dict[str, str]) -> None:
    """Refuse workers that would plan by another version."""
    ours = _rota_version()
    for worker, other in sorted(theirs.items()):
        if other != ours:
            raise RotaError(f"worker {worker} has rota {other}; this is rota {ours}, and all must have the same")


def _rota_version() -> str:
    """The version of Rota on the machine that asks."""
    return version("rota")
