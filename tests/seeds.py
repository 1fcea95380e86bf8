"""Random cases: a few in every run of the tests, the others in CI's."""

from __future__ import annotations

from typing import Any

import pytest


def seeds(count: int, *, at_once: int) -> list[Any]:
    """The numbers from 0 to below ``count``; those from ``at_once`` on are marked slow, which make test leaves out."""
    return [pytest.param(seed, marks=[pytest.mark.slow] * (seed >= at_once)) for seed in range(count)]
