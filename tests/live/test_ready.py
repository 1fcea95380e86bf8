"""What is compiled ahead is all that a watch needs."""

from __future__ import annotations

from types import ModuleType

from tests.live.two_robots import driven, two_robots

from rota.check import tiling_kernels
from rota.geometry import corner_kernels, kernels as geometry_kernels
from rota.live import age_kernels, following_kernels, kernels
from rota.live.ready import make_ready
from rota.live.settings import WatchSettings
from rota.live.watch import Watch

USED: tuple[ModuleType, ...] = (
    age_kernels, following_kernels, kernels, corner_kernels, geometry_kernels, tiling_kernels,
)  # fmt: skip


def compiled() -> dict[str, int]:
    loops = [(f"{module.__name__}.{name}", loop) for module in USED for name, loop in vars(module).items()]
    return {name: len(loop.signatures) for name, loop in loops if hasattr(loop, "signatures")}


def test_no_alarm_waits_for_a_compiler() -> None:
    make_ready()
    before = compiled()
    watch = Watch(two_robots(), WatchSettings(silent_s=3.0))
    notices = [n.kind for event in driven(watch.plan, 41.0, ends_s={"b": 8.0}) for n in watch.take(event)]
    assert {"lost", "will lapse", "lapsed"} <= set(notices)
    assert compiled() == before
    assert sum(before.values()) > 10
