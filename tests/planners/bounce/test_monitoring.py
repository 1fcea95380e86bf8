"""Periodic groups by products of cycles against brute force of the joint space, and by Algorithm 2 as printed."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from maps import PlainTeam, State, typed_cells

from rota.errors import MissionError, NoPlanFound
from rota.planners.bounce import bounce_map
from rota.planners.bounce.bounce_map import make_team, single_map
from rota.planners.bounce.cells import Cells
from rota.planners.bounce.chosen_group import sampled_basins
from rota.planners.bounce.enumeration import enumerate_groups, groups_as_printed, nodes_of
from rota.planners.bounce.group_count import TooMany, Work, count_groups, count_independent
from rota.planners.bounce.group_search import best_group
from rota.planners.bounce.limit_cycles import cycles_see, limit_cycles, require_watchable
from rota.planners.bounce.monitoring import Watch, canonical
from rota_studies.alam2020.listed_groups import groups

Joint = tuple[State, ...]
BENT = "....\n.#..\n...."


class Brute:
    """All cycles and basins of the joint space, in plain Python."""

    def __init__(self, plain: PlainTeam, zones: list[set[tuple[int, int]]]) -> None:
        self.step = {joint: plain.step(joint) for joint in plain.joints()}
        self.zones = zones
        self.cycle_of: dict[Joint, frozenset[Joint]] = {}
        for start in self.step:
            path: list[Joint] = []
            at = start
            while at not in self.cycle_of and at not in path:
                path.append(at)
                at = self.step[at][0]
            cycle = self.cycle_of.get(at) or frozenset(path[path.index(at) :])
            self.cycle_of |= dict.fromkeys(path, cycle)

    def watches(self, joints: Any) -> bool:
        cells = {state[:2] for joint in joints for state in joint}
        return all(cells & zone for zone in self.zones)

    def groups(self) -> set[frozenset[Joint]]:
        cycles = set(self.cycle_of.values())
        return {c for c in cycles if not any(self.step[joint][1] for joint in c) and self.watches(c)}

    def basin(self, cycle: frozenset[Joint], contact_free: str) -> int:
        count = 0
        for start, end in self.cycle_of.items():
            if end is cycle or end == cycle:
                at, contact = start, False
                while at not in cycle and not contact:
                    contact = self.step[at][1] > 0
                    at = self.step[at][0]
                count += contact_free == "cycle" or not contact
        return count

    def printed(self, order: list[Joint]) -> int:
        group: dict[Joint, int] = {}
        kept = 0
        for start in order:
            path: list[Joint] = []
            at = start
            while at not in group:
                group[at] = -1
                path.append(at)
                at = self.step[at][0]
            free = not any(self.step[joint][1] for joint in path)
            if path and at in path and free and self.watches(path):
                kept += 1
                group |= dict.fromkeys(path, kept)
        return kept


def inside_of(cells: Cells, zones: list[set[tuple[int, int]]]) -> np.ndarray:
    at = list(zip(cells.column.tolist(), cells.row.tolist(), strict=True))
    return np.array([[place in zone for place in at] for zone in zones], np.bool_).reshape(len(zones), cells.count)


def joint_of(cells: Cells, states: Any) -> Joint:
    found = []
    for s in states:
        cell, heading = divmod(int(s), cells.headings)
        found.append((int(cells.column[cell]), int(cells.row[cell]), heading))
    return tuple(found)


CASES = [
    (BENT, [3, 3], 8, "blocked", [{(0, 0)}, {(3, 2), (3, 1)}]),
    (BENT, [3, 3], 8, "pass", [{(0, 0)}, {(3, 2), (3, 1)}]),
    (BENT, [2, 3], 8, "blocked", [{(0, 1)}]),
    (BENT, [2, 2], 8, "pass", []),
    ("...\n.#.", [1, 1, 1], 4, "blocked", []),
    ("...\n...", [2, 1, 2], 4, "blocked", [{(0, 0)}]),
    ("...#\n....", [2, 2, 2], 4, "pass", [{(0, 0)}, {(2, 0)}]),
]


@pytest.mark.parametrize(("text", "bounces", "headings", "corners", "zones"), CASES)
def test_products_of_cycles_are_the_groups_of_the_joint_space(
    text: str, bounces: list[int], headings: int, corners: str, zones: list[set[tuple[int, int]]]
) -> None:
    cells = typed_cells(text, headings=headings, corners=corners)
    plain = PlainTeam(text, bounces, headings, corners)
    brute = Brute(plain, zones)
    expected = brute.groups()
    team, inside = make_team(cells, bounces), inside_of(cells, zones)
    cycles = limit_cycles(team)
    watch = Watch(cycles=cycles, sees=cycles_see(cycles, inside, headings), period_steps=np.ones(len(zones)))
    assert count_groups(cycles, watch.sees) == len(expected)
    found = set()
    for nodes in groups(watch):
        period = cycles.common_period(nodes)
        rounds = [[cycles.state[cycles.later(node, t)] for node in nodes] for t in range(period)]
        found.add(frozenset(joint_of(cells, states) for states in rounds))
    assert found == expected
    assert len(list(groups(watch))) == len(expected)
    for contact_free in ("cycle", "trajectory"):
        listed = enumerate_groups(team, inside, headings, contact_free=contact_free)
        told = {}
        for states, length, basin in zip(listed.states, listed.length, listed.basin, strict=True):
            cycle = brute.cycle_of[joint_of(cells, states)]
            assert length == len(cycle)
            told[cycle] = int(basin)
        assert told == {cycle: brute.basin(cycle, contact_free) for cycle in expected}
    number = {joint_of(cells, [s])[0]: s for s in range(cells.states)}
    order = sorted(brute.step, key=lambda joint: [number[state] for state in reversed(joint)])
    kept, listed = groups_as_printed(team, inside, headings)
    assert kept == brute.printed(order) == len(listed.length)
    assert kept <= len(expected) or zones  # a transient may enter a zone that the cycle does not


def test_a_joint_map_is_gone_through_in_parts_and_left_where_the_search_is_to_stop(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    cells = typed_cells(BENT, headings=8)
    team, inside = make_team(cells, [3, 3, 3]), inside_of(cells, [{(0, 0)}])
    outcomes, asked = [], [0]

    def counted(stops_at: int = 10**9) -> bool:
        asked[0] += 1
        return asked[0] >= stops_at

    for together in (1 << 22, 10_007):
        monkeypatch.setattr(bounce_map, "STATES_TOGETHER", together)
        asked[0] = 0
        kept, listed = groups_as_printed(team, inside, 8, counted)
        outcomes.append((kept, listed.states.tolist(), listed.length.tolist(), listed.basin.tolist()))
    assert outcomes[0] == outcomes[1]
    assert asked[0] == 3 * -(-(cells.states**3) // 10_007)
    for stops_at in (1, asked[0] // 2, asked[0]):  # in each of the three ways through it
        asked[0] = 0
        with pytest.raises(NoPlanFound, match="stopped before the joint map was gone through"):
            groups_as_printed(team, inside, 8, lambda at=stops_at: counted(at))  # type: ignore[misc]
        assert asked[0] == stops_at


def test_the_cases_have_groups_and_the_printed_order_loses_some() -> None:
    counts = []
    for text, bounces, headings, corners, zones in CASES:
        cells = typed_cells(text, headings=headings, corners=corners)
        team, inside = make_team(cells, bounces), inside_of(cells, zones)
        cycles = limit_cycles(team)
        counts.append(
            (count_groups(cycles, cycles_see(cycles, inside, headings)), groups_as_printed(team, inside, headings)[0])
        )
    assert sum(count > 10 for count, _ in counts) >= 3
    assert any(kept < count for count, kept in counts)


@settings(max_examples=15, deadline=None, derandomize=True)
@given(
    marks=st.lists(st.booleans(), min_size=12, max_size=12).filter(any),
    bounces=st.tuples(st.integers(1, 7), st.integers(1, 7)),
)
def test_any_small_map_has_the_groups_of_its_joint_space(marks: list[bool], bounces: tuple[int, int]) -> None:
    text = "\n".join("".join(".#"[not mark] for mark in marks[k : k + 4]) for k in (0, 4, 8))
    cells = typed_cells(text)
    team = make_team(cells, list(bounces))
    cycles = limit_cycles(team)
    listed = enumerate_groups(team, inside_of(cells, []), 8, contact_free="cycle")
    assert count_groups(cycles, np.zeros((len(cycles.state), 0), np.bool_)) == len(listed.length)


def test_wide_bodies_have_fewer_groups_the_same_as_their_joint_space() -> None:
    cells = typed_cells("....\n....\n....")
    counts = []
    for apart_m in (0.0, 0.7, 1.0, 1.3):
        team = make_team(cells, [2, 4], apart_m=apart_m)
        cycles = limit_cycles(team)
        counts.append(count_groups(cycles, np.zeros((len(cycles.state), 0), np.bool_)))
        listed = enumerate_groups(team, inside_of(cells, []), 8, contact_free="trajectory")
        assert counts[-1] == len(listed.length)
    assert counts[0] >= counts[1] > counts[2] > counts[3] > 0


def test_groups_without_names_are_those_with_names_taken_together() -> None:
    cells = typed_cells(BENT)
    cycles = limit_cycles(make_team(cells, [2, 2]))
    watch = Watch(cycles=cycles, sees=np.zeros((len(cycles.state), 0), np.bool_), period_steps=np.ones(0))

    def orbit(nodes) -> frozenset:
        period = cycles.common_period(nodes)
        return frozenset(frozenset(cycles.later(node, t) for node in nodes) for t in range(period))

    named = [orbit(nodes) for nodes in groups(watch)]
    nameless = [orbit(nodes) for nodes in groups(watch, unordered=True)]
    assert set(named) == set(nameless)
    assert len(nameless) == len(set(nameless)) < len(named)


@pytest.mark.parametrize("seed", range(6))
def test_sets_without_conflict_are_counted_as_by_trying_all(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = 13
    conflict = rng.random((count, count)) < (0.15, 0.4)[seed % 2]
    conflict = conflict | conflict.T | np.eye(count, dtype=bool)
    conflict[3], conflict[:, 3] = conflict[4], conflict[:, 4]
    conflict[3, 3:5] = conflict[4, 3:5] = True
    kind = rng.integers(0, 2, count).astype(np.int32)
    for wanted in ([1, 0], [2, 2], [3, 1], [0, 4]):
        expected = 0
        for nodes in itertools.combinations(range(count), sum(wanted)):
            alone = not any(conflict[a, b] for a, b in itertools.combinations(nodes, 2))
            expected += alone and np.bincount(kind[list(nodes)], minlength=2).tolist() == wanted
        assert count_independent(conflict, kind, wanted) == expected


def test_counts_beyond_64_bits_are_exact() -> None:
    # no conflicts at all: all ways to choose 40 of 400
    conflict = np.eye(400, dtype=bool)
    assert count_independent(conflict, np.zeros(400, np.int32), [12]) == math.comb(400, 12)
    assert math.comb(400, 12) > 2**70


def test_the_best_group_is_the_best_of_all() -> None:
    zones = [{(0, 0)}, {(3, 2), (3, 1)}]
    for bounces in ([3, 3], [2, 2], [2, 3], [1, 2]):
        cells = typed_cells(BENT)
        cycles = limit_cycles(make_team(cells, bounces))
        sees = cycles_see(cycles, inside_of(cells, zones), 8)
        watch = Watch(cycles=cycles, sees=sees, period_steps=np.array([7.0, 11.0]))
        found = best_group(watch)
        everything = [watch.ratio(nodes) for nodes in groups(watch)]
        assert found.proved
        best = found.group
        if best is None:
            assert everything == []
            continue
        assert best.ratio == min(everything)
        assert watch.ratio(best.nodes) == best.ratio
        early = best_group(watch, enough=2 * best.ratio)
        assert early.group is not None
        assert early.group.ratio <= 2 * best.ratio
        assert not early.proved
        assert not best_group(watch, most_nodes=1).proved


def test_gaps_are_those_of_a_simulation() -> None:
    cells = typed_cells(BENT)
    team = make_team(cells, [2, 3])
    cycles = limit_cycles(team)
    zones = [{(0, 0), (1, 0)}, {(3, 2)}]
    inside = inside_of(cells, zones)
    watch = Watch(cycles=cycles, sees=cycles_see(cycles, inside, 8), period_steps=np.array([1.0, 1.0]))
    plain = PlainTeam(BENT, [2, 3])
    tried = 0
    for nodes in itertools.islice(groups(watch), 20):
        joint = joint_of(cells, cycles.state[list(nodes)])
        times: list[list[int]] = [[], []]
        for t in range(3 * cycles.common_period(nodes)):
            for z, zone in enumerate(zones):
                if any(state[:2] in zone for state in joint):
                    times[z].append(t)
            joint, contacts = plain.step(joint)
            assert contacts == 0
        for z in (0, 1):
            assert watch.gap_steps(nodes, z) == np.diff(times[z]).max()
        tried += 1
    assert tried > 3


def test_nodes_of_states_and_zones_that_no_cycle_enters() -> None:
    cells = typed_cells(BENT)
    team = make_team(cells, [1, 1])
    cycles = limit_cycles(team)
    listed = enumerate_groups(team, inside_of(cells, []), 8, contact_free="cycle")
    for states in listed.states:
        assert (cycles.state[list(nodes_of(cycles, states))] == states).all()
    never = sorted(set(range(cells.count)) - set((cycles.state // 8).tolist()))
    sees = cycles_see(cycles, np.zeros((2, cells.count), np.bool_), 8)
    nowhere = np.zeros((2, cells.count), np.bool_)
    with pytest.raises(MissionError, match=r"^zones gate, yard: no limit .* enters them.*; nor do .* other headings"):
        require_watchable(sees, ["gate", "yard"], cells, nowhere)
    assert never == [] or len(never) < cells.count


def test_angles_that_lead_into_a_zone_are_named() -> None:
    """By 45 degrees all robots of a room end up along its border; other angles' cycles are followed step by step."""
    cells = typed_cells("\n".join(["....."] * 5))
    inside = np.array([(cells.column == 2) & (cells.row == 2)])
    sees = np.zeros((1, 1), np.bool_)
    entering = []
    for bounce in range(1, 8):
        successor = single_map(make_team(cells, [bounce]))
        for state in range(cells.states):
            for _ in range(2 * cells.states):
                state = int(successor[state])
            if inside[0, state // 8] and f"{45 * bounce}" not in entering:
                entering.append(f"{45 * bounce}")
    assert "45" not in entering
    with pytest.raises(
        MissionError, match=f"robots that turn by one of {', '.join(entering)} degrees enter all zones$"
    ):
        require_watchable(sees, ["middle"], cells, inside)


def test_a_count_may_be_given_up() -> None:
    rng = np.random.default_rng(0)
    conflict = rng.random((60, 60)) < 0.1
    conflict = conflict | conflict.T | np.eye(60, dtype=bool)
    whole = count_independent(conflict, np.zeros(60, np.int32), [8])
    assert count_independent(conflict, np.zeros(60, np.int32), [8], Work(10**9)) == whole > 0
    with pytest.raises(TooMany):
        count_independent(conflict, np.zeros(60, np.int32), [8], Work(100))


@pytest.mark.parametrize("free", [False, True])
def test_random_starts_hit_each_group_as_often_as_its_basin_is_large(free: bool) -> None:
    cells = typed_cells(BENT)
    team = make_team(cells, [2, 3])
    cycles = limit_cycles(team)
    watch = Watch(cycles=cycles, sees=np.zeros((len(cycles.state), 0), np.bool_), period_steps=np.ones(0))
    samples = 4000
    hits = dict(sampled_basins(watch, team, free=free, seed=5, samples=samples))
    listed = enumerate_groups(team, inside_of(cells, []), 8, contact_free="trajectory" if free else "cycle")
    for states, basin in zip(listed.states, listed.basin, strict=True):
        share = basin / cells.states**2
        found = hits.pop(canonical(cycles, nodes_of(cycles, states)), 0)
        assert abs(found - samples * share) <= 5 * math.sqrt(samples * share) + 1
    assert hits == {}


def test_cycles_that_never_enter_a_zone_do_not_count_as_good() -> None:
    """Closed rooms, one robot and one zone each: the best team has the best cycle of each room, found and proved."""
    rooms = 5
    cells = typed_cells("\n".join("#".join(["..."] * rooms) for _ in range(3)))
    team = make_team(cells, [2] * rooms)
    cycles = limit_cycles(team)
    inside = np.array([cells.column // 4 == room for room in range(rooms)])
    watch = Watch(cycles=cycles, sees=cycles_see(cycles, inside, 8), period_steps=np.full(rooms, 10.0))
    found = best_group(watch, most_nodes=500)
    assert found.group is not None
    assert found.proved
    assert found.group.ratio == 0.1  # in its room at every step
    # with too few partial teams to look at, nothing is said to be impossible
    few = best_group(watch, most_nodes=4)
    assert (few.group, few.proved, few.unproved) == (None, False, "the search ended after 4 partial teams")
    # a search that is stopped has its first team, which the bound of the rooms does not prove
    stopped = best_group(watch, should_stop=lambda: True)
    assert stopped.group is not None
    assert (stopped.proved, stopped.unproved) == (False, "the search was stopped")
    # one robot less leaves a room unseen, and that is proved
    fewer = limit_cycles(make_team(cells, [2] * (rooms - 1)))
    sees = cycles_see(fewer, inside, 8)
    none = best_group(Watch(cycles=fewer, sees=sees, period_steps=np.full(rooms, 10.0)))
    assert (none.group, none.proved) == (None, True)


@pytest.mark.parametrize("seed", range(4))
def test_the_best_group_of_three_zones_is_the_best_of_all(seed: int) -> None:
    rng = np.random.default_rng(seed)
    tried = 0
    while tried < 8:
        text = "\n".join("".join(rng.choice(list("....#"), 4)) for _ in range(3))
        cells = typed_cells(text) if text.count(".") > 3 else None
        if cells is None:
            continue
        cycles = limit_cycles(make_team(cells, rng.integers(1, 8, 2).tolist()))
        inside = np.zeros((3, cells.count), np.bool_)
        inside[np.arange(3), rng.choice(cells.count, 3)] = True
        period = rng.uniform(3, 20, 3)
        watch = Watch(cycles=cycles, sees=cycles_see(cycles, inside, 8), period_steps=period)
        ratios = [watch.ratio(nodes) for nodes in groups(watch)]
        found = best_group(watch)
        assert found.proved
        assert (found.group is None) == (ratios == [])
        if found.group is not None:
            tried += 1
            assert found.group.ratio == watch.ratio(found.group.nodes) == min(ratios)


def test_a_count_has_a_bound_on_all_its_work() -> None:
    """Twenty zones along a corridor are 2 ** 20 choices of what is left out."""
    cells = typed_cells("\n".join("." * 20 for _ in range(3)))
    cycles = limit_cycles(make_team(cells, [2, 2, 2]))
    inside = cells.column == np.arange(20)[:, None]
    with pytest.raises(TooMany):
        count_groups(cycles, cycles_see(cycles, inside, 8), most_work=30_000)
    # the same zone twenty times is one
    once = count_groups(cycles, cycles_see(cycles, inside[:1], 8))
    assert count_groups(cycles, cycles_see(cycles, inside[[0] * 20], 8), most_work=3_000_000) == once > 0
