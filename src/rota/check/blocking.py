"""What blocks sight, and what blocks motion, each as one shape.

A search has hundreds of plans for one mission checked, so that the last few are kept.
"""

from __future__ import annotations

import functools
from typing import Any

import shapely

from rota.model.mission import Obstacle


@functools.lru_cache(maxsize=4)
def blocks_sight(obstacles: tuple[Obstacle, ...]) -> Any:
    """All obstacles that block sight as one geometry; an empty one where none does."""
    return shapely.union_all([obstacle.shape for obstacle in obstacles if obstacle.blocks_sight])


@functools.lru_cache(maxsize=4)
def blocks_motion(obstacles: tuple[Obstacle, ...]) -> Any:
    """All obstacles that block motion as one geometry; an empty one where none does."""
    return shapely.union_all([obstacle.shape for obstacle in obstacles if obstacle.blocks_motion])
