"""Plans without a grid: robots that follow attracting limit cycles in polygons, so that all zones are visited.

Robots on one cycle are evenly spaced in time, and stay so; robots on different ones, whose rounds have no common
period, must never come near each other, whatever their phases.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import shapely

from rota.errors import MissionError, NoPlanFound
from rota.model.arrays import Flags
from rota.model.mission import Mission, Robot
from rota.model.plan import Plan, Trajectory
from rota.planners.bounce.plane_tracks import Track, tracks_of
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planners.bounce.rattles import is_rattle
from rota.planners.bounce.robust_team import CANDIDATES, most_robust
from rota.planners.bounce.starts import robots_of
from rota.planning.planner import Request

MOST_FEWEST = 12  # robots that are tried when the mission asks for as few as possible
MOST_TEAMS = 100_000  # that are looked at


@dataclass(frozen=True, kw_only=True, eq=False)
class PlaneTeam:
    """Robots by number on tracks. ``ratio``: the worst gap over its period; inf: some zone is never visited."""

    robots: tuple[Robot, ...]
    tracks: tuple[Track, ...]
    on: tuple[int, ...]
    ratio: float


def plan_in_plane(request: Request) -> tuple[Plan, PlaneTeam]:
    """A plan by which robots without a grid visit all zones for ever along attracting limit cycles, and the team.

    For as few robots as possible teams of 1, 2, ... are tried. Raises NoPlanFound when no team visits all zones. A team
    that visits them too seldom is given all the same.
    """
    mission = request.mission
    counts = [None] if mission.fleet.robots is not None else list(range(1, MOST_FEWEST + 1))
    best: PlaneTeam | None = None
    for k, count in enumerate(counts):
        request.progress(k / len(counts), f"{count or len(mission.fleet.robots or ())} robots")
        team = free_team(request, count)
        if team is not None and (best is None or team.ratio < best.ratio):
            best = team
        if (best is not None and best.ratio <= 1) or request.should_stop():
            break
    if best is None:
        most = "up to " * (count is not None) + f"{count or len(mission.fleet.robots or ())} robots"
        raise NoPlanFound(
            f"no team of {most} on attracting limit cycles keeps apart so that each zone is visited; other bouncing"
            " angles, or cells (bounce.cells: grid), may do"
        )
    return Plan(mission=mission, trajectories=tuple(_trajectories(best)), seed=request.seed), best


def free_team(request: Request, count: int | None) -> PlaneTeam | None:
    """The team with the smallest worst ratio of gap to period, the first that meets all periods, or the most robust.

    count: robots, of a fleet of as few as possible. None where no team visits all zones without contact. Raises
    MissionError for zones that no attracting limit cycle of any robot enters.
    """
    mission, seed = request.mission, request.seed
    robots = robots_of(mission, count)
    tracks, owners = _tracks(mission, robots, seed)
    search = _Search(mission, robots, tracks, owners, request.should_stop)
    for narrowed in _kinds_of_tracks(tracks):
        # cycles that hold first; the others where these do not serve
        search.allowed = narrowed
        search.extend((), 0)
        if search.best is not None and search.best.ratio <= 1:
            break
    meeting = sorted((team for team in search.found if team.ratio <= 1), key=lambda team: team.ratio)
    if BounceSettings.of(mission).purpose != "robust" or not meeting:
        return search.best
    chosen = np.unique(np.linspace(0, len(meeting) - 1, CANDIDATES).round().astype(int))
    teams: list[PlaneTeam] = [meeting[k] for k in chosen]
    plans = [Plan(mission=mission, trajectories=tuple(_trajectories(team)), seed=seed) for team in teams]
    return teams[most_robust(plans, request)]


def _tracks(mission: Mission, robots: tuple[Robot, ...], seed: int) -> tuple[list[Track], list[int]]:
    """All tracks, and for each the number of the first robot of the kind that has it."""
    each = BounceSettings.of(mission).bouncing.angles_of(len(robots))
    zones = [zone for zone in mission.zones if zone.period_s is not None]
    tracks: list[Track] = []
    owners: list[int] = []
    for k, kind in enumerate(_kinds(mission, robots)):
        if kind == k:
            own_tracks = tracks_of(mission, robots[k], each[k], zones, seed)
            tracks += own_tracks
            owners += [k] * len(own_tracks)
    missed = [zone.name for z, zone in enumerate(zones) if not any(len(track.visits[z]) for track in tracks)]
    if missed:
        raise MissionError(
            f"zones {', '.join(missed)}: no attracting limit cycle of any robot enters them; other bouncing angles"
            " (bounce.bouncing_angles_deg: any tries some), or cells (bounce.cells: grid), are needed"
        )
    return tracks, owners


def _kinds_of_tracks(tracks: list[Track]) -> Iterator[Flags]:
    """Which tracks (t,) may be used: those that hold and are no rattles; all that hold; all."""
    holds = np.array([track.cycle.holds for track in tracks], np.bool_)
    rattles = np.array([is_rattle(track.places_m, track.body_radius_m) for track in tracks], np.bool_)
    narrowings = {mask.tobytes(): mask for mask in (holds & ~rattles, holds, np.ones_like(holds))}
    yield from (mask for mask in narrowings.values() if mask.any())


def _kinds(mission: Mission, robots: tuple[Robot, ...]) -> list[int]:
    """For each robot the first robot that has the same angle, speed, turn rate and body."""
    each = BounceSettings.of(mission).bouncing.angles_of(len(robots))
    keys = [
        (angle, robot.ground_speed_m_s, robot.turn_rate_rad_s, robot.body_radius_m)
        for angle, robot in zip(each, robots, strict=True)
    ]
    return [keys.index(key) for key in keys]


class _Search:
    """Teams robot by robot, each on a track of its kind; equal robots in the order of their tracks."""

    def __init__(
        self,
        mission: Mission,
        robots: tuple[Robot, ...],
        tracks: list[Track],
        owners: list[int],
        should_stop: Callable[[], bool],
    ) -> None:
        self.mission, self.robots, self.tracks, self.owners = mission, robots, tracks, owners
        self.kinds, self.should_stop = _kinds(mission, robots), should_stop
        self.periods_s = [zone.period_s for zone in mission.zones if zone.period_s is not None]
        self.enough = 1.0 if BounceSettings.of(mission).purpose == "periods" else 0.0
        self.best: PlaneTeam | None = None
        self.found: list[PlaneTeam] = []
        self.allowed = np.ones(len(tracks), np.bool_)
        self.left = MOST_TEAMS
        self.apart = _apart(tracks, [robots[owner].body_radius_m for owner in owners])
        self.known: dict[tuple[int, int], bool] = {}

    def extend(self, on: tuple[int, ...], least: int) -> None:
        """All teams that begin with robots on these tracks."""
        self.left -= 1
        if self.left < 0 or self.should_stop() or (self.best is not None and self.best.ratio <= self.enough):
            return
        k = len(on)
        if k == len(self.robots):
            team = PlaneTeam(robots=self.robots, tracks=tuple(self.tracks), on=on, ratio=self.ratio(on))
            self.found.append(team)
            if math.isfinite(team.ratio) and (self.best is None or team.ratio < self.best.ratio):
                self.best = team
            return
        first = least if k and self.kinds[k] == self.kinds[k - 1] else 0
        for t in range(first, len(self.tracks)):
            if self.allowed[t] and self.owners[t] == self.kinds[k] and self.may_join(on, t):
                self.extend((*on, t), t)

    def may_join(self, on: tuple[int, ...], t: int) -> bool:
        """Whether one more robot on track t stays apart from the robots on the tracks ``on``."""
        if not all(other == t or self.apart[other, t] for other in on):
            return False
        key = (t, on.count(t) + 1)
        if key not in self.known:
            apart_m = 2 * self.robots[self.owners[t]].body_radius_m
            margin_s = self.tracks[t].margin_s(key[1], apart_m)
            self.known[key] = margin_s > 0 and margin_s >= BounceSettings.of(self.mission).clock_margin_s
        return self.known[key]

    def ratio(self, on: tuple[int, ...]) -> float:
        """The worst gap over its period; of a zone on several tracks the shortest of their gaps."""
        return max(
            min(self.tracks[t].gap_s(z, on.count(t)) for t in set(on)) / period_s
            for z, period_s in enumerate(self.periods_s)
        )


def _apart(tracks: list[Track], radii_m: list[float]) -> Flags:
    """(t, t) whether robots on two tracks can never touch."""
    lines = [shapely.linestrings(track.places_m) for track in tracks]
    apart = np.zeros((len(tracks),) * 2, np.bool_)
    for i, j in itertools.combinations(range(len(tracks)), 2):
        apart[i, j] = apart[j, i] = shapely.distance(lines[i], lines[j]) >= radii_m[i] + radii_m[j]
    return apart


def _trajectories(team: PlaneTeam) -> list[Trajectory]:
    """Each robot's, those on one track evenly spaced in time."""
    trajectories, placed = [], dict.fromkeys(team.on, 0)
    for robot, t in zip(team.robots, team.on, strict=True):
        track = team.tracks[t]
        trajectories.append(track.trajectory(robot.name, placed[t] * track.round_s / team.on.count(t)))
        placed[t] += 1
    return trajectories
