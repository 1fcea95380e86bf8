"""Alarms of demands: which will lapse, where, in how many seconds and who could still make it; which have lapsed."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from rota.live.ages import Ages
from rota.live.forecast import Forecast, Lapse
from rota.live.notices import DemandStanding, DemandState, Notice, names_in_words, place_text, seconds
from rota.live.ways import Ways
from rota.model.arrays import Floats, Ints

Place = tuple[float, float]

CALM_LOOKS = 3  # forecasts in a row without a lapse until an alarm is taken back
MOST_PRESSING = 3  # demands for which it is worked out at every look who could still make it
CALM_S = 5.0  # and so long without a gap that was too long
ON_TIME = 1 + 1e-9  # a gap that equals the period to rounding meets it


class DemandAlarms:
    """What is told of each demand: once that it will lapse, once that it has, once that all is well again."""

    def __init__(self, forecast: Forecast, ways: Ways, robots: list[str]) -> None:
        self._forecast, self._ways, self._robots = forecast, ways, robots
        self._places = forecast.places
        count = len(self._places.demands)
        self._standing: list[DemandStanding] = ["ok"] * count
        self._calm = [0] * count
        self._late_s = [-math.inf] * count
        self._lapses: dict[int, Lapse] = {}
        self._could: dict[int, tuple[str, ...]] = {}
        self.lapses = 0

    # ------------------------------------------------------------ what has happened

    def close(self, now_s: float, ages: Ages, gaps_s: Floats, where: Ints) -> list[Notice]:
        """After ages were settled: gaps_s and where (demands,) are what ``Ages.settle`` returned."""
        told, oldest = [], ages.oldest()
        for k, demand in enumerate(self._places.demands):
            if oldest[k] < 0:
                continue
            age_s, limit_s = ages.known_s - float(ages.last_seen_s[oldest[k]]), demand.period_s * ON_TIME
            is_late = self._standing[k] == "lapsed"
            if max(age_s, float(gaps_s[k])) > limit_s:
                self._late_s[k] = ages.known_s
                if not is_late:
                    is_over = age_s <= limit_s
                    place, gap_s = (int(where[k]), float(gaps_s[k])) if is_over else (int(oldest[k]), age_s)
                    told.append(self._notice_of_lapse(now_s, k, place, gap_s, is_over=is_over))
            elif is_late and ages.known_s - self._late_s[k] >= CALM_S:
                self._standing[k] = "ok"
                told.append(self._notice(now_s, "seen again", k, f"{demand.name} is seen in time again"))
        return told

    def _notice_of_lapse(self, now_s: float, k: int, place: int, gap_s: float, *, is_over: bool) -> Notice:
        demand, at = self._places.demands[k], self._at(place)
        self._standing[k] = "lapsed"
        self.lapses += 1
        since = f"for {seconds(gap_s)} when it was seen again" if is_over else f"for {seconds(gap_s)}"
        verb = "was not visited" if demand.demand == "visit" else "was not seen"
        text = f"{demand.name} has lapsed: {place_text(at)} {verb} {since}; {demand.period_s:g} s are asked"
        return self._notice(now_s, "lapsed", k, text, place_m=at, gap_s=gap_s, period_s=demand.period_s)

    # ------------------------------------------------------------ what will happen

    def look_ahead(
        self, now_s: float, ages: Ages, lags_s: Floats, until_s: Floats, places_m: dict[int, Place]
    ) -> list[Notice]:
        """Simulate ahead; places_m: where robots are that can be asked to go somewhere. Others: ``Forecast.lapses``."""
        found = self._forecast.lapses(ages.last_seen_s, ages.known_s, lags_s, until_s)
        self._lapses = {lapse.demand: lapse for lapse in found}
        told = []
        for k, demand in enumerate(self._places.demands):
            lapse = self._lapses.get(k)
            self._calm[k] = 0 if lapse is not None else self._calm[k] + 1
            if lapse is None:
                self._could.pop(k, None)
                if self._standing[k] == "will lapse" and self._calm[k] >= CALM_LOOKS:
                    self._standing[k] = "ok"
                    told.append(self._notice(now_s, "in time", k, f"{demand.name} will be seen in time after all"))
            elif self._standing[k] == "ok" and lapse.at_s > now_s:
                self._standing[k] = "will lapse"
                told.append(self._will_lapse(now_s, lapse, places_m))
        pressing = [lapse for lapse in found if self._standing[lapse.demand] == "will lapse"]
        for lapse in pressing[:MOST_PRESSING]:
            self._able(now_s, lapse, places_m)
        return told

    def _able(self, now_s: float, lapse: Lapse, places_m: dict[int, Place]) -> list[tuple[float, int]]:
        """Who could see a place before it lapses: seconds and number of each robot, the nearest first."""
        numbers = sorted(places_m)
        from_m = np.array([places_m[number] for number in numbers]).reshape(-1, 2)
        takes_s = self._ways.times_s(lapse.place, numbers, from_m).tolist()
        pairs = zip(takes_s, numbers, strict=True)
        able = sorted((takes, number) for takes, number in pairs if takes <= lapse.at_s - now_s)
        self._could[lapse.demand] = tuple(self._robots[number] for _, number in able)
        return able

    def _will_lapse(self, now_s: float, lapse: Lapse, places_m: dict[int, Place]) -> Notice:
        """The alarm of a demand that nobody due will meet, with who could still make it."""
        k, at = lapse.demand, self._at(lapse.place)
        left_s = lapse.at_s - now_s
        able = self._able(now_s, lapse, places_m)
        if lapse.next_robot is None:
            due = "nobody is due there"
        else:
            due = f"{self._robots[lapse.next_robot]} is due there {seconds(lapse.next_s - lapse.at_s)} too late"
        if able:
            could = f"{names_in_words(list(self._could[k]))} could still make it, in {seconds(able[0][0])}"
        else:
            could = "nobody can make it" if self._ways.known else "who could make it is not worked out on this ground"
        name = self._places.demands[k].name
        text = f"{name} will lapse in {seconds(left_s)} at {place_text(at)}: {due}; {could}"
        facts = [{"robot": self._robots[number], "takes_s": takes} for takes, number in able]
        return self._notice(now_s, "will lapse", k, text, place_m=at, in_s=left_s, could=facts)

    def lapse_times_s(
        self, ages: Ages, lags_s: Floats, until_s: Floats, later_s: float | None = None
    ) -> dict[int, float]:
        """When demands will lapse, those that will; see ``Forecast.lapses``."""
        return {
            lapse.demand: lapse.at_s
            for lapse in self._forecast.lapses(ages.last_seen_s, ages.known_s, lags_s, until_s, later_s)
        }

    def lapses_without(
        self,
        now_s: float,
        ages: Ages,
        lags_s: Floats,
        until_s: Floats,
        with_it_s: dict[int, float],
        later_s: float | None = None,
    ) -> tuple[str, list[dict[str, Any]]]:
        """What lapses, or lapses sooner, than with a robot that is missing now; in words, and as a list.

        with_it_s: what ``lapse_times_s`` gave with that robot.
        """
        found = [
            lapse
            for lapse in self._forecast.lapses(ages.last_seen_s, ages.known_s, lags_s, until_s, later_s)
            if lapse.at_s < with_it_s.get(lapse.demand, math.inf)
        ]
        names = [self._places.demands[lapse.demand].name for lapse in found]
        facts = [
            {"demand": name, "in_s": lapse.at_s - now_s, "place_m": self._at(lapse.place)}
            for name, lapse in zip(names, found, strict=True)
        ]
        if not found:
            return "nothing more lapses", facts
        words = [f"{name} lapses in {seconds(lapse.at_s - now_s)}" for name, lapse in zip(names, found, strict=True)]
        return names_in_words(words), facts

    # ------------------------------------------------------------ the state

    def states(self, now_s: float, ages: Ages) -> tuple[DemandState, ...]:
        """Every demand as it is now."""
        oldest, found = ages.oldest(), []
        for k, demand in enumerate(self._places.demands):
            place, lapse = int(oldest[k]), self._lapses.get(k)
            found.append(
                DemandState(
                    name=demand.name,
                    period_s=demand.period_s,
                    standing=self._standing[k],
                    age_s=0.0 if place < 0 else max(0.0, now_s - float(ages.last_seen_s[place])),
                    place_m=None if place < 0 else self._at(place),
                    worst_s=float(ages.worst_s[k]),
                    lapses_in_s=None if lapse is None else lapse.at_s - now_s,
                    could=self._could.get(k, ()),
                )
            )
        return tuple(found)

    def _at(self, place: int) -> Place:
        x, y = self._places.points_m[place].tolist()
        return x, y

    def _notice(self, now_s: float, kind: Any, k: int, text: str, **facts: Any) -> Notice:
        return Notice(time_s=now_s, kind=kind, about=self._places.demands[k].name, text=text, facts=facts)
