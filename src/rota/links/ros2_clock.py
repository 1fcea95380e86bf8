"""The time since a plan's start by the clock of a ROS 2 node that follows /clock."""

from __future__ import annotations

import asyncio
from typing import Any

from rota.errors import LinkError
from rota.links.plan_clock import PlanClock

ASK_AGAIN_S = 0.05
NS_PER_S = 10**9


class NodeClock(PlanClock):
    """A PlanClock of simulated time, which goes as fast as /clock does; 0 until ``follow``."""

    _node: Any = None

    async def follow(self, node: Any, limit_s: float) -> None:
        """Take the time of a node from now on; LinkError where it has none within ``limit_s`` of real time."""
        self._node = node
        try:
            async with asyncio.timeout(limit_s):
                while self.stamped_s() == 0:
                    await asyncio.sleep(ASK_AGAIN_S)
        except TimeoutError:
            raise LinkError(f"use_sim_time: nothing is heard on /clock within {limit_s:g} s") from None

    def steady_s(self) -> float:
        """The node's time."""
        return self.stamped_s()

    def stamped_s(self) -> float:
        """The node's time, which its robots' stamps are of."""
        return 0.0 if self._node is None else int(self._node.get_clock().now().nanoseconds) / NS_PER_S
