"""How many workers share the tests, and in which order."""

from __future__ import annotations

import gc
import os
import signal
from pathlib import Path

import pytest
from tests.browser import chromium, started_chromium

__all__ = ["chromium", "started_chromium"]

PROJECT = Path(__file__).parents[1]

# a shell without job control lets what it starts in the background ignore Ctrl-C, which then no child could be sent
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# each worker begins with a part of the tests: patrol's kernels, a minute's work, are compiled by the first one while
# others have the check, bounces and browsers to do; who is done takes from the end of another's
ORDER = (
    "planners/patrol",
    "files",
    "geometry",
    "planners/swarm",
    "check",
    "planners/bounce",
    "draw",
    "web",
    "playback",
    "studies",
    "command",
)


def place_in_order(item: pytest.Item) -> int:
    path = item.path.relative_to(PROJECT).as_posix().removeprefix("tests/")
    return next((k for k, folder in enumerate(ORDER) if path.startswith(folder + "/")), len(ORDER))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """One process more than cores: robots that go by real time, and browsers, keep them waiting."""
    return (os.cpu_count() or 1) + 1


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    # the modules that are loaded and the tests stay: to look through them again and again took 3 % of the time
    gc.collect()
    gc.freeze()
    if "PYTEST_XDIST_WORKER" in os.environ:
        items.sort(key=place_in_order)
