"""In which order copies of the process that has collected the tests share them, and from where on they do."""

from __future__ import annotations

import gc
import signal
from pathlib import Path

import pytest
from tests.browser import chromium, started_chromium
from tests.shared_out import copies_asked_for, share_out
from tests.warm_process import begin_one

__all__ = ["chromium", "started_chromium"]

PROJECT = Path(__file__).parents[1]

# a shell without job control lets what it starts in the background ignore Ctrl-C, which then no child could be sent
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# to look through modules and tests again and again while they are loaded takes a tenth of that time
gc.disable()

# each copy begins with a part of the tests: patrol's kernels, a minute's work, are compiled by the first one while
# others have the check, bounces and browsers to do; who is done takes from the end of another's
ORDER = (
    "planners/patrol",
    "files",
    "geometry",
    # all of these read all sources, which those do once that one copy runs
    "test_house.py",
    "test_imports.py",
    "test_sizes.py",
    "test_docs.py",
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
    return next((k for k, folder in enumerate(ORDER) if path.startswith(folder)), len(ORDER))


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--copies", metavar="N", help="share the tests out among N copies of this process, or 'auto'")


def pytest_sessionstart(session: pytest.Session) -> None:
    if copies_asked_for(session.config):
        begin_one()  # one for the programs of all, which loads what they need while tests are collected


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    # the modules that are loaded and the tests stay: to look through them again and again took 3 % of the time
    gc.collect()
    gc.freeze()
    gc.enable()
    if copies_asked_for(config):
        items.sort(key=place_in_order)


@pytest.hookimpl(tryfirst=True)
def pytest_runtestloop(session: pytest.Session) -> bool | None:
    asked = session.config.option
    collected = session.items and not asked.collectonly
    if not collected or (session.testsfailed and not asked.continue_on_collection_errors):
        return None
    if not copies_asked_for(session.config):
        return None
    share_out(session)
    return True
