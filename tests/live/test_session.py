"""A watch over the simulated link, and its replay: the same notices and states, byte for byte."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest
from tests.live.two_robots import two_robots

from rota.links.link_settings import make_link
from rota.live.notices import Notice, notice_json, state_json
from rota.live.recording import recording_of
from rota.live.session import Session, replay
from rota.live.settings import WatchSettings
from rota.live.watch import Watch
from rota.live.watch_log import LogReader, LogWriter
from rota.routes.route import route_of

FAULTS = "faults=b:dies@12+a:nan@40"


class Told:
    """All that a watch showed, as text."""

    def __init__(self, watch: Watch) -> None:
        self.watch, self.lines = watch, list[str]()

    def show(self, notices: list[Notice]) -> None:
        self.lines += [notice_json(notice) for notice in notices]
        self.lines.append(state_json(self.watch.state()))


def watched_live(log: Path, *settings: str) -> Told:
    plan = two_robots()
    told = Told(Watch(plan, WatchSettings(silent_s=3.0)))

    async def follow() -> None:
        link = make_link("simulated", plan, ["clock=0", *settings])
        await link.open()
        for way in plan:
            await link.send_route(route_of(way, plan.mission.fleet.altitude_m))
            await link.start(way.robot)
        with LogWriter(log, plan, told.watch.settings) as writer:
            session = Session(told.watch, writer, told.show)
            await asyncio.wait_for(session.follow(link, until_s=60.0, should_stop=lambda: False), 120)

    asyncio.run(follow())
    return told


def test_a_replay_tells_the_same_byte_for_byte(tmp_path: Path) -> None:
    live = watched_live(tmp_path / "lane.rota-log", FAULTS, "lost=0.05", "delay_s=0.5", "speed_noise=0.1")
    kinds = [line.split('"notice": "')[1].split('"')[0] for line in live.lines if '"notice"' in line]
    assert {"lost", "will lapse", "lapsed", "dropped"} <= set(kinds)
    log = LogReader.of(tmp_path / "lane.rota-log", two_robots())
    again = Told(Watch(two_robots(), log.settings))
    replay(log, again.watch, again.show)
    assert log.fault is None
    assert again.lines == live.lines


def test_what_was_really_driven_is_recorded(tmp_path: Path) -> None:
    told = watched_live(tmp_path / "lane.rota-log", "position_noise_m=0", "speed_noise=0")
    log = LogReader.of(tmp_path / "lane.rota-log", two_robots())
    recording = recording_of(two_robots(), log.events(), log.settings)
    assert recording.window_s == (0.0, pytest.approx(60.0, abs=0.3))
    assert [track.robot for track in recording.tracks] == ["a", "b"]
    # every leg is one report's interval long, and driven at full speed but where it turns
    lasted_s = recording.tracks[0].times_s[:, 1] - recording.tracks[0].times_s[:, 0]
    assert lasted_s[1:].max() == pytest.approx(0.2)
    assert told.watch.lapses == 0
