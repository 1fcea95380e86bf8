"""The stored runs of a study: what was run and what came out, from which alone its page is made."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from rota import __version__
from rota.errors import RotaError
from rota.files.mission_json import mission_to_json
from rota.model.mission import Mission
from rota.model.plan import Plan, Trajectory
from rota_studies.plain import alike, built, plain

Json = dict[str, Any]
T = TypeVar("T")
AT_A_TIME = 2
DIGEST = 16  # hex digits
HEAD = ("study", "rota", "seed", "settings")


class Record(NamedTuple):
    """One run: what was run, and what came out, both as JSON."""

    run: Json
    came_out: Any


class Changed(NamedTuple):
    """A run that no longer comes to what its record says."""

    run: Json
    recorded: Any
    now: Any


class Job(NamedTuple):
    """A run to be made: what tells it apart from all others, and how it is made."""

    run: Mapping[str, Any]
    make: Callable[[], Any]


class Records:
    """Runs, each made once and kept as a record; what is asked for is always read back from its record.

    So a page cannot show what its records do not hold, and is the same from a file of them.

    known: records of earlier runs. may_run: whether a run that has none is made; else it raises RotaError. again:
    whether a known run is made all the same, to compare; what differs is in ``changed``.
    """

    def __init__(
        self,
        known: Iterable[Record] = (),
        *,
        may_run: bool = True,
        again: Callable[[Record], bool] = lambda record: False,
    ) -> None:
        self._known = {_key(record.run): record for record in known}
        self._may_run, self._again = may_run, again
        self._used: dict[str, Record] = {}
        self._built: dict[str, Any] = {}
        self.changed: list[Changed] = []

    @property
    def used(self) -> tuple[Record, ...]:
        """The records of all that was asked for, in the order of the first asking."""
        return tuple(self._used.values())

    def get(self, kind: Any, run: Mapping[str, Any], make: Callable[[], T]) -> T:
        """What a run came to, as a value of the type ``kind``; ``make`` is called where there is no record of it."""
        found: T = self.get_all(kind, [Job(run, make)], at_a_time=1)[0]
        return found

    def get_all(self, kind: Any, jobs: Sequence[Job], *, at_a_time: int = AT_A_TIME) -> list[Any]:
        """The same of several runs, some made at a time; their order is that of the jobs."""
        keyed = [(_key(job.run), job) for job in jobs]
        missing = {key: job for key, job in keyed if key not in self._used and self._is_made(key)}
        if at_a_time > 1 and len(missing) > 1:
            with ThreadPoolExecutor(at_a_time) as pool:
                made = dict(zip(missing, pool.map(lambda job: _stored(job.make()), missing.values()), strict=True))
        else:
            made = {key: _stored(job.make()) for key, job in missing.items()}
        for key, job in keyed:
            if key not in self._used:
                self._used[key] = self._record(key, job, made)
        return [self._value(kind, key) for key, _ in keyed]

    def _is_made(self, key: str) -> bool:
        """Whether a run has to be made. Raises RotaError where it must not be."""
        known = self._known.get(key)
        if known is None and not self._may_run:
            raise RotaError(f"the records have no run {key}; make them anew, without --from")
        return known is None or self._again(known)

    def _record(self, key: str, job: Job, made: Mapping[str, Any]) -> Record:
        """The record of a run, known or just made."""
        known = self._known.get(key)
        if known is None:
            return Record(_stored(job.run), made[key])
        if key in made and not alike(known.came_out, made[key]):
            self.changed.append(Changed(known.run, known.came_out, made[key]))
        return Record(_stored(job.run), known.came_out)

    def _value(self, kind: Any, key: str) -> Any:
        """What came out as a value, built once."""
        if key not in self._built:
            self._built[key] = built(kind, self._used[key].came_out)
        return self._built[key]


def _key(run: Mapping[str, Any]) -> str:
    """What was run, as text."""
    return json.dumps(plain(run), ensure_ascii=False, sort_keys=True)


def _stored(value: Any) -> Any:
    """A value as it will be read from a file."""
    return json.loads(json.dumps(plain(value), allow_nan=False))


# ---------------------------------------------------------------- files


@dataclass(frozen=True, kw_only=True)
class RecordsFile:
    """A file of records: of which study, made by which version, from which seed on and with which settings."""

    study: str
    rota: str = __version__
    seed: int
    settings: Any
    runs: tuple[Record, ...]

    @property
    def text(self) -> str:
        """JSON with a line for each run."""
        head = {"study": self.study, "rota": self.rota, "seed": self.seed, "settings": plain(self.settings)}
        lines = [f"{json.dumps(name)}: {_line(value)}" for name, value in head.items()]
        runs = [_line({"run": record.run, "came_out": record.came_out}) for record in self.runs]
        return "{" + ",\n ".join([*lines, '"runs": [\n  ' + ",\n  ".join(runs) + "]"]) + "}\n"


def _line(value: Any) -> str:
    """A value on one line."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def read_records(path: str | Path, study: str) -> RecordsFile:
    """The records of a study. Raises RotaError for a file that holds none, or those of another study."""
    try:
        document = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise RotaError(f"{path}: cannot be read: {error.strerror or error}") from error
    except ValueError as error:  # of JSON, and of bytes that are no text
        raise RotaError(f"{path}: not JSON: {error}; a file of records is needed") from error
    if not isinstance(document, dict) or not {*HEAD, "runs"} <= document.keys():
        raise RotaError(f"{path}: holds no records of a study; `rota study {study} -o FOLDER` writes them")
    if document["study"] != study:
        raise RotaError(f"{path}: holds records of {document['study']!r}; those of {study} are needed")
    try:
        runs = tuple(Record(one["run"], one["came_out"]) for one in document["runs"])
        head = {name: document[name] for name in HEAD}
        return RecordsFile(**head | {"seed": int(head["seed"])}, runs=runs)
    except (TypeError, KeyError, ValueError) as error:
        raise RotaError(f"{path}: a run has no 'run' and 'came_out', or the seed is no number") from error


# ---------------------------------------------------------------- digests


def mission_digest(mission: Mission) -> str:
    """Hex digits that tell a mission from others, settings of its planner and all."""
    text = json.dumps(mission_to_json(mission), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:DIGEST]


def what(mission: Mission) -> Json:
    """What tells a mission apart, for a record."""
    return {"mission": mission.name, "digest": mission_digest(mission)}


def drawn_ways(plan: Plan) -> tuple[Trajectory, ...]:
    """A plan's trajectories as records keep them to be drawn: to ``DIGITS``, without points at the same moment."""
    return tuple(_rounded(trajectory) for trajectory in plan.trajectories)


def _rounded(way: Trajectory) -> Trajectory:
    """A trajectory to ``DIGITS``."""
    times_s, positions_m, start_s = (
        built(NDArray[np.float64], plain(values))
        for values in (way.times_s, way.positions_m, np.array([way.loop_start_s]))
    )
    # the last point of those at one moment stays, so that the loop ends where it began
    kept = np.append(np.diff(times_s) > 0, True)
    headings = None if way.headings_rad is None else built(NDArray[np.float64], plain(way.headings_rad))[kept]
    return Trajectory(
        robot=way.robot, times_s=times_s[kept], positions_m=positions_m[kept], headings_rad=headings,
        loop_start_s=float(start_s[0]),
    )  # fmt: skip


def plan_digest(plan: Plan) -> str:
    """Hex digits that tell where a plan's robots are when, to the millimetre and millisecond, from other plans."""
    found = hashlib.sha256()
    for trajectory in plan.trajectories:
        found.update(trajectory.robot.encode())
        for values in (trajectory.times_s, trajectory.positions_m):
            found.update((values.round(3) + 0.0).tobytes())
    return found.hexdigest()[:DIGEST]
