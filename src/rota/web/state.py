"""What a running server works with."""

from __future__ import annotations

from dataclasses import dataclass, field

from rota.web.jobs.queue import JobQueue
from rota.web.jobs.watches import WatchDesk
from rota.web.limits import Limits
from rota.web.refusal import Json
from rota.web.store.database import Database
from rota.web.tiles import Tiles
from rota.web.workers.pool import Pool


@dataclass(kw_only=True)
class State:
    """What runs. ``kept``: answers that stay the same while the server runs."""

    database: Database
    pool: Pool
    jobs: JobQueue
    watches: WatchDesk
    limits: Limits
    tiles: Tiles | None
    kept: dict[str, Json] = field(default_factory=dict)
