"""What a search can tell on its way: the state it has come to, for those who want to watch it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

Stage = Literal["searched", "checked"]


@dataclass(frozen=True, kw_only=True)
class SearchState:
    """Where a search stands.

    stage: "searched", told by the planner of what it is working on; or "checked", told of a plan that was judged.
    robots: in it. unseen_share: how much of the asked ground is never seen, 0..1; by the planner's sample points while
    searched, by the check's area when checked. late_share: by how much the longest wait for what is seen outlasts its
    period, as a share of the period; 0 when none does. met: the check passed it.
    """

    stage: Stage
    robots: int
    unseen_share: float
    late_share: float
    met: bool = False


Watch = Callable[[SearchState], None]
