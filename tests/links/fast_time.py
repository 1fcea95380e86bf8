"""Time that passes several times as fast, for links and the vehicles beside them."""

from __future__ import annotations

import asyncio
import selectors
import time
from collections.abc import Coroutine
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any, TypeVar

import pytest

Result = TypeVar("Result")
CLOCKS = ("rota.links.plan_clock", "rota.links.vda5050_vehicle")


@dataclass(frozen=True, kw_only=True)
class FastTime:
    """Clocks that go ``rate`` times as fast from ``zero_s`` on, which is a Unix time."""

    rate: float = 1.0
    zero_s: float = field(default_factory=time.time)

    def unix_s(self) -> float:
        return self.zero_s + (time.time() - self.zero_s) * self.rate

    def monotonic_s(self) -> float:
        return time.monotonic() * self.rate

    def let_links_have_it(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Whatever a link reads of the time of day and of the time that passes is this one's."""
        clock = SimpleNamespace(time=self.unix_s, monotonic=self.monotonic_s)
        for module in CLOCKS:
            monkeypatch.setattr(f"{module}.time", clock)

    def run(self, main: Coroutine[Any, Any, Result]) -> Result:
        """What ``asyncio.run`` does, with waits and limits by this clock."""
        with asyncio.Runner(loop_factory=lambda: _FastLoop(self.rate)) as runner:
            return runner.run(main)


class _FastLoop(asyncio.SelectorEventLoop):
    def __init__(self, rate: float) -> None:
        self._rate = rate
        super().__init__(_FastSelector(rate))

    def time(self) -> float:
        return super().time() * self._rate


class _FastSelector(selectors.DefaultSelector):  # type: ignore[misc, valid-type]
    def __init__(self, rate: float) -> None:
        super().__init__()
        self._rate = rate

    def select(self, timeout: float | None = None) -> Any:
        return super().select(None if timeout is None else timeout / self._rate)
