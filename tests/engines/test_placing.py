"""A large value is sent to a cluster once for calls that follow each other, and to processes with each call."""

from __future__ import annotations

import pickle
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from typing import Any

import pytest

from rota.engines.placing import answer_of, submit_with
from rota.errors import RotaError


class Client:
    """Takes calls as dask's client does, and notes them."""

    def __init__(self) -> None:
        self.sent: list[bytes] = []

    def submit(self, function: Any, content: bytes, *, pure: bool) -> Any:
        assert function is pickle.loads
        assert not pure
        self.sent.append(content)
        return pickle.loads(content)


class Cluster(Executor):
    """Does calls at once, and has a client."""

    def __init__(self) -> None:
        self._client = Client()

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def longer(large: list[int], more: int, *, by: int = 0) -> int:
    return len(large) + more + by


def test_threads_that_begin_at_once_send_a_value_once() -> None:
    cluster, large = Cluster(), list(range(1000))
    with ThreadPoolExecutor(8) as pool:
        jobs = [pool.submit(submit_with, cluster, large, longer, k, by=2) for k in range(40)]
        assert [job.result().result() for job in jobs] == [1002 + k for k in range(40)]
    assert len(cluster._client.sent) == 1
    other = list(large)  # equal, but another one
    assert submit_with(cluster, other, longer, 0).result() == 1000
    assert submit_with(cluster, large, longer, 1).result() == 1001
    assert len(cluster._client.sent) == 3


def test_other_executors_get_the_value_itself() -> None:
    large = [1, 2, 3]
    with ThreadPoolExecutor(1) as pool:
        assert submit_with(pool, large, longer, 4, by=1).result() == 8


class KilledWorker(Exception):  # noqa: N818
    """Has the name of what dask raises."""


def test_a_lost_cluster_is_told_as_such() -> None:
    lost: Future[int] = Future()
    lost.cancel()
    with pytest.raises(RotaError, match="the connection to the cluster was lost"):
        answer_of(lost)
    for error, raised in ((KilledWorker("3 times"), RotaError), (ZeroDivisionError("by 0"), ZeroDivisionError)):
        failed: Future[int] = Future()
        failed.set_exception(error)
        with pytest.raises(raised, match=str(error)):
            answer_of(failed)
