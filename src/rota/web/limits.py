"""How large and how long what people send and start may be; what lies beyond is refused before memory is spent."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

MIB = 2**20


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Bytes, counts and seconds.

    document_bytes: a mission as JSON. upload_bytes, upload_files: one upload.
    vertices: of all shapes of a mission. planning_jobs: at once; queued_jobs: behind
    them. job_memory_bytes, job_time_s: of one job; stop_grace_s: how long one asked to stop may take to do so.
    task_time_s, task_memory_bytes: of reading, checking, drawing and exporting. waiting_tasks: behind the warm workers.
    watches: live fleets at once. missions, plans, jobs: kept.
    """

    document_bytes: int = 4 * MIB
    upload_bytes: int = 64 * MIB
    upload_files: int = 20
    vertices: int = 100_000
    planning_jobs: int = 1
    queued_jobs: int = 100
    job_memory_bytes: int = 4096 * MIB
    job_time_s: float = 3600.0
    stop_grace_s: float = 30.0
    task_time_s: float = 180.0
    task_memory_bytes: int = 3072 * MIB
    waiting_tasks: int = 300
    watches: int = 4
    missions: int = 10_000
    plans: int = 10_000
    jobs: int = 10_000

    def for_workers(self, role: str, data: str) -> dict[str, Any]:
        """What a worker process is told: what it is for, where the database is, and how large things may be."""
        memory = self.job_memory_bytes if role == "planning" else self.task_memory_bytes
        counts = {"vertices": self.vertices, "missions": self.missions, "plans": self.plans}
        return {"role": role, "data": data, "memory_bytes": memory, "counts": counts}
