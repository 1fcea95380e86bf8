"""How the robots of a swarm make the decisions of a step: in parts on several threads, or on a GPU."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rota.errors import MissionError
from rota.planners.swarm.chunks import Chunks
from rota.planners.swarm.cuda_step import CudaStep
from rota.planners.swarm.delayed_news_kernels import NUMBER_OF, OWN, Filtering, decide_from_delayed_news
from rota.planners.swarm.filter_kernels import filter_velocities
from rota.planners.swarm.guide_kernels import steer
from rota.planners.swarm.messages import Messages
from rota.planners.swarm.planner_settings import Device
from rota.planners.swarm.reciprocal_block_kernels import BLOCK, MOST_ROUND, PLANES, ROWS, BlockRoom, decide_in_blocks
from rota.planners.swarm.reciprocal_kernels import decide_reciprocal
from rota.planners.swarm.settle_kernels import decide_settle
from rota.planners.swarm.state import Decisions, Guide, Hearing, Kinds, Near, Outline, Room, Rule, Snapshot
from rota.planners.swarm.velocity_set_kernels import MOST_CORNERS

FEWEST_PER_CHUNK, FEWEST_OF_SETTLE = 256, 16  # robots whose decisions take about as long as it takes to wake a thread
FEWEST_IN_BLOCKS = 10_000  # robots; the paper's swarms are smaller, and their figures are those of its own formulas
EXACT = np.empty(0)  # nobody has gone on unheard


@dataclass(frozen=True)
class Controller:
    """How robots decide.

    decide: the compiled controller; rule: what it reads. safe: whether the last filter is applied. hearing: what robots
    learn of each other; None: at every step where all others are. device: what decides, the processor or, "cuda", an
    NVIDIA GPU, to within rounding.
    """

    decide: Callable[..., None]
    rule: Rule
    safe: bool = True
    hearing: Hearing | None = None
    device: Device = "cpu"


class Deciding:
    """Makes the decisions of n robots; the same on any number of threads, bit for bit.

    widest_m: the largest body plus the longest step of any robot, and how far it may have gone on unheard. Raises
    MissionError for a device that is not there or does not do what is asked.
    """

    def __init__(self, controller: Controller, kinds: Kinds, n: int, widest_m: float, threads: int) -> None:
        self._decide, self._safe, self._widest_m = controller.decide, controller.safe, widest_m
        fewest = FEWEST_OF_SETTLE if controller.decide is decide_settle else FEWEST_PER_CHUNK
        self.chunks = Chunks(n, threads, fewest)
        self._rooms = [deciding_room(controller.rule) for _ in range(len(self.chunks))]
        self._device = None if controller.device == "cpu" else CudaStep(controller.decide, kinds, controller.rule)
        if self._device is not None and controller.hearing is not None:
            raise MissionError("swarm.device: cuda is for robots that know all at once; no delay_steps, messages_lost")
        self._blocks: list[BlockRoom] = []
        if n >= FEWEST_IN_BLOCKS and self._device is None and _suits_blocks(controller, kinds, widest_m):
            self._blocks = [
                BlockRoom(np.empty(MOST_ROUND + 1, np.int64), np.ones(ROWS * BLOCK), room, EXACT)
                for room in self._rooms
            ]

    def decide(
        self,
        snapshot: Snapshot,
        messages: Messages | None,
        decisions: Decisions,
        then: Callable[[int, int], float],
        guide: Guide | None = None,
    ) -> list[float]:
        """The velocities of all robots from a snapshot; messages: what they have heard of the others, None: all.

        guide: where robots are sent that know all; None: all decide for themselves.

        Returns what then(begin, end) does for the robots begin to end - 1 of each part, once these have decided.
        """
        if self._device is not None:
            self._device.decide(snapshot, self._widest_m if self._safe else None, decisions)

        def decide_part(begin: int, end: int, part: int) -> float:
            if self._device is None:
                self._decide_part(begin, end, part, snapshot, messages, decisions, guide)
            return then(begin, end)

        return self.chunks.run(decide_part)

    def _decide_part(
        self,
        begin: int,
        end: int,
        part: int,
        snapshot: Snapshot,
        messages: Messages | None,
        decisions: Decisions,
        guide: Guide | None,
    ) -> None:
        """Decide for the robots begin..end - 1 in one thread, with its part of the room."""
        if messages is not None:
            self._decide_from_messages(begin, end, part, snapshot, messages, decisions)
        elif self._blocks and guide is None and not len(snapshot.moving.x):
            widest_m = self._widest_m if self._safe else -1.0
            decide_in_blocks(begin, end, snapshot, widest_m, decisions, self._blocks[part])
        else:
            self._decide(begin, end, snapshot, decisions, self._rooms[part])
            if guide is not None:
                steer(begin, end, snapshot, guide, decisions)
            if self._safe:
                filter_velocities(begin, end, snapshot, self._widest_m, EXACT, decisions, self._rooms[part])

    def _decide_from_messages(
        self, begin: int, end: int, part: int, snapshot: Snapshot, messages: Messages, decisions: Decisions
    ) -> None:
        """Likewise, for robots that know others from messages only."""
        room, controller = self._rooms[part], NUMBER_OF.get(self._decide, OWN)
        if controller == OWN:
            self._decide(begin, end, snapshot, decisions, room)
        news = messages.news_for(part, snapshot.robots, snapshot.grid)
        filtering = Filtering(self._safe, self._widest_m)
        decide_from_delayed_news(begin, end, controller, filtering, snapshot, news, decisions, room)


def _suits_blocks(controller: Controller, kinds: Kinds, widest_m: float) -> bool:
    """Whether ``decide_in_blocks`` decides as this controller; it sees for the filter no farther than for itself."""
    rule, members = controller.rule, kinds.speed_m_s > 0
    published = controller.decide is decide_reciprocal and not rule.circle and rule.samples == 0
    sees_enough = bool((kinds.neighbour_range_m[members] >= 2 * widest_m).all())
    return published and controller.hearing is None and 1 <= rule.neighbours <= PLANES and sees_enough


def deciding_room(rule: Rule) -> Room:
    """Room for one thread that decides by this rule."""
    most = max(rule.neighbours, 1)
    outlines = [Outline(np.empty(MOST_CORNERS), np.empty(MOST_CORNERS)) for _ in range(2)]
    return Room(Near(np.empty(most, np.int64), np.empty(most)), *outlines)
