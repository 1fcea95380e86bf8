"""A cache of compiled kernels for each process of the tests, and what tests have to tell people, printed at the end."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

# numba's cache is not made for processes that compile one function for several signatures at the same time: the one may
# write its code under the name that the other's index gives
if worker := os.environ.get("PYTEST_XDIST_WORKER"):
    cache = Path(__file__).parents[1] / ".pytest_cache" / "numba" / worker
    os.environ.setdefault("NUMBA_CACHE_DIR", str(cache))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    for report in terminalreporter.getreports("passed"):
        for name, value in report.user_properties:
            if name == "told":
                terminalreporter.write_line(str(value))
