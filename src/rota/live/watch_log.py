"""A watch's log: JSON lines, written as things happen, from which the watch is made again bit for bit.

The first line is the header: which plan, by its hash, and the settings. Then a line for each event::

    ["r", 12.41, 0, 12.3, 4.5, 6.75, 30.0, 0.87, "running"]   a report: arrival, robot's number, time, place, ...
    ["x", "unknown robot", 3, "ghost, t = 1.0"]                messages that were dropped: fault, how many, an example
    ["t", 12.6]                                                a tick
    ["end"]                                                    the watch ended; without it, the log was cut off

A log that was packed by gzip is read as it is.
"""

from __future__ import annotations

import gzip
import hashlib
import json
import os
import zlib
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from types import TracebackType
from typing import IO, Any

from rota.errors import RotaError
from rota.files.atomic_write import require_writable
from rota.files.plan_file import plan_text
from rota.links.link import FAULTS
from rota.live.events import Dropped, Event, Heard, Tick
from rota.live.intake import LONGEST_EXAMPLE, MODES
from rota.live.settings import WatchSettings
from rota.model.plan import Plan

VERSION = 1
LONGEST_LINE = 1000  # bytes; a report takes some 60
MOST = 1e12  # of any number: no time or place is larger
GZIP = b"\x1f\x8b"
MADE_BY = "'rota watch --log' writes one"


def plan_hash(plan: Plan) -> str:
    """SHA-256 of a plan's file as Rota writes it, in hexadecimal digits, without the line of the mission's own digest.

    Versions that wrote no such line have left logs, too.
    """
    lines = plan_text(plan).splitlines(keepends=True)
    return hashlib.sha256("".join(line for line in lines if '"mission_sha256"' not in line).encode()).hexdigest()


class LogWriter:
    """Appends events to a new file; ``flush`` after every tick keeps what was written if the program dies.

    A block that an error ends before any event leaves no file.
    Raises RotaError for a file that exists already, or cannot be written.
    """

    def __init__(self, path: str | os.PathLike[str], plan: Plan, settings: WatchSettings) -> None:
        require_writable(path)
        try:
            self._file: IO[str] = open(path, "x", encoding="ascii", newline="\n")  # noqa: SIM115 (closed by close)
        except FileExistsError:
            raise RotaError(f"{path}: exists already; a log is never written over") from None
        except OSError as error:
            raise RotaError(f"{path}: cannot be written: {error.strerror}") from None
        self._path, self._holds_events = path, False
        self._line({"rota_watch": VERSION, "plan_sha256": plan_hash(plan), "settings": asdict(settings)})

    def write(self, event: Event) -> None:
        """Append an event; a tick brings all before it to the disk's care. Raises RotaError where the disk is full."""
        self._holds_events = True
        if isinstance(event, Heard):
            self._line(["r", *event])
        elif isinstance(event, Dropped):
            self._line(["x", *event])
        else:
            self._line(["t", *event])
            self._flush()

    def close(self, *, ended: bool = True) -> None:
        """End the file; ``ended`` False: the watch broke off."""
        if ended:
            self._line(["end"])
        self._flush()
        self._file.close()

    def __enter__(self) -> LogWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close(ended=error is None)
        if error is not None and not self._holds_events:
            Path(self._path).unlink(missing_ok=True)

    def _line(self, value: object) -> None:
        try:
            self._file.write(json.dumps(value, allow_nan=False, separators=(",", ":")) + "\n")
        except OSError as error:
            raise RotaError(f"{self._path}: cannot be written: {error.strerror}") from None

    def _flush(self) -> None:
        try:
            self._file.flush()
        except OSError as error:
            raise RotaError(f"{self._path}: cannot be written: {error.strerror}") from None


@dataclass
class LogReader:
    """A log that was read up to its header. ``events`` goes on; ``fault``: why they ended early, None: they did not.

    Nothing is evaluated, and no line longer than ``LONGEST_LINE`` is taken into memory.
    """

    path: Path
    settings: WatchSettings
    robots: int
    fault: str | None = None

    @classmethod
    def of(cls, path: str | os.PathLike[str], plan: Plan) -> LogReader:
        """Raises RotaError for what is no log, or is the log of another plan."""
        try:
            with _open(Path(path)) as file:
                header = _json_line(file.readline(LONGEST_LINE))
        except (EOFError, zlib.error) as error:
            raise RotaError(f"{path}: no log of a watch: {error}") from None
        except OSError as error:
            raise RotaError(f"{path}: cannot be read: {error.strerror or error}; a log is needed ({MADE_BY})") from None
        if not isinstance(header, dict) or "rota_watch" not in header:
            raise RotaError(f"{path}:1: no log of a watch; one is needed ({MADE_BY})")
        if header["rota_watch"] != VERSION:
            raise RotaError(f"{path}:1: rota_watch: {header['rota_watch']!r:.40} is not {VERSION}, which is read here")
        known, own = header.get("plan_sha256"), plan_hash(plan)
        if known != own:
            hashes = f"its hash begins with {str(known)[:12]}, this plan's with {own[:12]}"
            raise RotaError(f"{path}:1: the log of another plan: {hashes}")
        try:
            settings = WatchSettings(**header["settings"])
        except (KeyError, TypeError, RotaError) as error:
            raise RotaError(f"{path}:1: settings: {error}") from None
        return cls(path=Path(path), settings=settings, robots=len(plan.trajectories))

    def events(self) -> Iterator[Event]:
        """All events up to the log's end, or up to what is damaged, which ``fault`` tells then."""
        self.fault = None
        with _open(self.path) as file:
            file.readline(LONGEST_LINE)
            for number, line in enumerate(iter(lambda: _line_of(file), b""), start=2):
                if not line.endswith(b"\n"):
                    what = "is cut off" if len(line) < LONGEST_LINE else "is too long"
                    self.fault = f"{self.path}:{number}: the line {what}; what comes before it is used"
                    return
                fields = _json_line(line)
                if fields == ["end"]:
                    return
                event = _event(fields, self.robots)
                if event is None:
                    self.fault = f"{self.path}:{number}: no line of a log; what comes before it is used"
                    return
                yield event
        self.fault = f"{self.path}: the log breaks off without its last line; what there is is used"


def _open(path: Path) -> IO[bytes]:
    """The log's text, also of one that was packed by gzip."""
    with path.open("rb") as file:
        is_packed = file.read(2) == GZIP
    return gzip.open(path, "rb") if is_packed else path.open("rb")  # type: ignore[return-value]


def _line_of(file: IO[bytes]) -> bytes:
    """The next line, as much of it as may be; where a packed log is damaged, one that is cut off."""
    try:
        return file.readline(LONGEST_LINE)
    except (EOFError, OSError, zlib.error):
        return b"?"


def _json_line(line: bytes) -> Any:
    """What a line holds; None where it is not JSON."""
    try:
        return json.loads(line)
    except (ValueError, RecursionError):
        return None


def _event(fields: Any, robots: int) -> Event | None:
    """The event of a line; None where it is none."""
    if not isinstance(fields, list) or not fields:
        return None
    kind, values = fields[0], fields[1:]
    if kind == "t" and len(values) == 1 and _is_number(values[0]):
        return Tick(float(values[0]))
    if kind == "x" and len(values) == 3:
        fault, messages, example = values
        known = fault in FAULTS and isinstance(example, str) and len(example) <= LONGEST_EXAMPLE
        return Dropped(fault, messages, example) if known and _is_whole(messages) else None
    if kind == "r" and len(values) == 8:
        at_s, robot, time_s, x, y, height, battery, mode = values
        ok = _is_whole(robot) and robot < robots and all(map(_is_number, (at_s, time_s, x, y, height)))
        ok = ok and (battery is None or (_is_number(battery) and 0 <= battery <= 1))
        if ok and (mode is None or _is_mode(mode)):
            charge = None if battery is None else float(battery)
            return Heard(float(at_s), robot, float(time_s), float(x), float(y), float(height), charge, mode)
    return None


def _is_mode(value: Any) -> bool:
    return isinstance(value, str) and value in MODES


def _is_whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 1 << 53


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and -MOST <= value <= MOST
