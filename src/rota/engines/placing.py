"""Calls on any executor that all take one large value, which a cluster is sent once and not with every call."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from concurrent.futures import CancelledError, Executor, Future
from threading import Lock
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

from rota.errors import RotaError

Result = TypeVar("Result")

# of each executor the large value placed last, and what stands for it there
_placed: WeakKeyDictionary[Executor, tuple[Any, Any]] = WeakKeyDictionary()
_placing = Lock()  # several threads begin with the same value at once


def submit_with(
    executor: Executor, large: Any, function: Callable[..., Result], *arguments: Any, **named: Any
) -> Future[Result]:
    """The future of ``function(large, *arguments, **named)``; all of them must be picklable.

    Calls that follow each other with the same value, by identity, send it to each worker of a cluster once.
    """
    call = pickle.dumps((function, arguments, named), protocol=pickle.HIGHEST_PROTOCOL)
    client = getattr(executor, "_client", None)
    if client is None:
        return executor.submit(_call, large, call)
    with _placing:
        known = _placed.get(executor)
        if known is None or known[0] is not large:
            content = pickle.dumps(large, protocol=pickle.HIGHEST_PROTOCOL)
            # a call, since a worker that is lost takes values with it that no call makes again
            known = _placed[executor] = (large, client.submit(pickle.loads, content, pure=False))
    return executor.submit(_call, known[1], call)


def answer_of(future: Future[Result]) -> Result:
    """The result of a call that was handed to an executor; raises what the call raised.

    RotaError where a cluster is lost, or has given the call up since workers that did it were lost.
    """
    try:
        return future.result()
    except CancelledError:
        raise RotaError("the connection to the cluster was lost") from None
    except Exception as error:
        if type(error).__name__ != "KilledWorker":  # of dask, which may not be there
            raise
        raise RotaError(f"workers of the cluster were lost: {error}") from error


def _call(large: Any, call: bytes) -> Any:
    function, arguments, named = pickle.loads(call)
    return function(large, *arguments, **named)
