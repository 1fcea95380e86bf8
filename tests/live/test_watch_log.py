"""Logs: what was written is read again bit for bit, damage is told where it is, and strangers' logs are refused."""

from __future__ import annotations

import gzip
import json
from dataclasses import replace
from pathlib import Path

import pytest
from tests.live.two_robots import driven, two_robots

from rota.errors import RotaError
from rota.live.events import Dropped, Event, Heard, Tick
from rota.live.settings import WatchSettings
from rota.live.watch_log import LONGEST_LINE, LogReader, LogWriter

EVENTS: list[Event] = [
    Tick(0.1 + 0.2),
    Heard(1 / 3, 0, 0.1, 1e-17, -2.5, 30.0, None, None),
    Heard(1 / 3, 1, 0.2, 7.0, 2**0.5, 30.0, 0.875, "running"),
    Dropped("not a number", 17, "b, t = nan"),
    Tick(0.5),
]


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """A log of a few events of two robots."""
    path = tmp_path / "lane.rota-log"
    with LogWriter(path, two_robots(), WatchSettings(silent_s=2.5, off_route_m=0.75)) as writer:
        for event in EVENTS:
            writer.write(event)
    return path


def test_a_log_gives_back_every_event_and_the_settings(log: Path) -> None:
    reader = LogReader.of(log, two_robots())
    assert list(reader.events()) == EVENTS
    assert reader.fault is None
    assert reader.settings == WatchSettings(silent_s=2.5, off_route_m=0.75)


def test_a_log_is_never_written_over(log: Path) -> None:
    with pytest.raises(RotaError, match="exists already"):
        LogWriter(log, two_robots(), WatchSettings())
    assert list(LogReader.of(log, two_robots()).events()) == EVENTS


def test_a_tick_brings_all_before_it_to_the_file(tmp_path: Path) -> None:
    writer = LogWriter(tmp_path / "open.rota-log", two_robots(), WatchSettings())
    for event in EVENTS:
        writer.write(event)
    reader = LogReader.of(tmp_path / "open.rota-log", two_robots())
    assert list(reader.events()) == EVENTS
    assert reader.fault is not None
    assert "breaks off without its last line" in reader.fault
    writer.close()


def test_the_log_of_another_plan_is_refused(log: Path) -> None:
    with pytest.raises(RotaError, match=r"lane\.rota-log:1: the log of another plan: its hash begins"):
        LogReader.of(log, replace(two_robots(), seed=7))


@pytest.mark.parametrize(
    ("cut", "kept", "words"),
    [
        (lambda lines: [*lines[:-1], lines[-1][:3]], 5, r":7: the line is cut off; what comes before it is used"),
        (lambda lines: [*lines[:-2], lines[-2][:5]], 4, r":6: the line is cut off"),
        (lambda lines: lines[:-1], 5, "breaks off without its last line"),
        (lambda lines: [*lines[:3], '["r", 1, 2]\n', *lines[3:]], 2, r":4: no line of a log"),
        (lambda lines: [*lines[:3], "\x00\xff{{{{\n", *lines[3:]], 2, r":4: no line of a log"),
        (lambda lines: [*lines[:3], f"[{'1' * 10_000}]\n", *lines[3:]], 2, r":4: the line is too long"),
        (lambda lines: [*lines[:3], "[" * 900 + "\n", *lines[3:]], 2, r":4: no line of a log"),
        (lambda lines: [*lines[:3], '["t", NaN]\n', *lines[3:]], 2, r":4: no line of a log"),
        (lambda lines: [*lines[:3], '["r", 1, 2, 1, 0, 0, 0, null, null]\n', *lines[3:]], 2, r":4: no line of a log"),
        (lambda lines: [*lines[:3], '["x", "unknown robot", -1, ""]\n', *lines[3:]], 2, r":4: no line of a log"),
    ],
)
def test_damage_is_told_where_it_is_and_what_comes_before_it_holds(log: Path, cut, kept: int, words: str) -> None:
    log.write_text("".join(cut(log.read_text().splitlines(keepends=True))), encoding="latin-1")
    reader = LogReader.of(log, two_robots())
    assert list(reader.events()) == EVENTS[:kept]
    assert reader.fault is not None
    assert words.replace("\\", "") in reader.fault.replace("\\", "")


@pytest.mark.parametrize(
    ("header", "words"),
    [
        ("", r":1: no log of a watch; one is needed"),
        ("[1]\n", r":1: no log of a watch"),
        ('{"rota_watch": 2}\n', r":1: rota_watch: 2 is not 1"),
        ("x" * 2 * LONGEST_LINE, r":1: no log of a watch"),
    ],
)
def test_what_is_no_log_is_refused(tmp_path: Path, header: str, words: str) -> None:
    (tmp_path / "other").write_text(header)
    with pytest.raises(RotaError, match=words):
        LogReader.of(tmp_path / "other", two_robots())
    with pytest.raises(RotaError, match="cannot be read"):
        LogReader.of(tmp_path / "none", two_robots())


def test_settings_out_of_range_are_told(log: Path) -> None:
    lines = log.read_text().splitlines(keepends=True)
    header = json.loads(lines[0])
    header["settings"]["silent_s"] = -1
    log.write_text(json.dumps(header) + "\n" + "".join(lines[1:]))
    with pytest.raises(RotaError, match=":1: settings: silent_s"):
        LogReader.of(log, two_robots())


def test_lines_are_bounded(tmp_path: Path) -> None:
    longest = Heard(
        -1.2345678901234567e-300, 199, -1.2345678901234567e-300, *[-1.2345678901234567e-300] * 3, 0.5, "running"
    )
    path = tmp_path / "long.rota-log"
    with LogWriter(path, two_robots(), WatchSettings()) as writer:
        writer.write(longest)
        writer.write(Dropped("unknown robot", 2**52, '"' * 60))
        for event in driven(two_robots(), 1.0):
            writer.write(event)
    assert max(map(len, path.read_bytes().splitlines())) < LONGEST_LINE / 2


def test_a_packed_log_is_read_as_it_is_and_up_to_its_damage(log: Path) -> None:
    packed = log.with_suffix(".gz")
    packed.write_bytes(gzip.compress(log.read_bytes()))
    reader = LogReader.of(packed, two_robots())
    assert list(reader.events()) == EVENTS
    assert reader.fault is None
    packed.write_bytes(gzip.compress(log.read_bytes())[:-12])
    reader = LogReader.of(packed, two_robots())
    assert list(reader.events()) == EVENTS[: len(list(reader.events()))]
    assert reader.fault is not None
    packed.write_bytes(b"\x1f\x8b no log")
    with pytest.raises(RotaError, match=r"no log of a watch|cannot be read: (Not|Unknown)"):
        LogReader.of(packed, two_robots())


def test_a_watch_that_never_began_leaves_no_log(tmp_path: Path) -> None:
    path = tmp_path / "none.rota-log"
    with pytest.raises(RotaError, match="no broker"), LogWriter(path, two_robots(), WatchSettings()):
        raise RotaError("no broker")
    assert not path.exists()
    writer = LogWriter(path, two_robots(), WatchSettings())
    writer.write(Tick(1.0))
    with pytest.raises(RotaError, match="lost"), writer:
        raise RotaError("lost")
    assert list(LogReader.of(path, two_robots()).events()) == [Tick(1.0)]
