"""Maps of teams against plain Python, their cycles and basins against scipy, and hand-worked maps."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
import scipy.sparse
from benchmarks.bounce_joint_maps import map_of_sets, tell_apart
from hypothesis import given, settings, strategies as st
from maps import PlainTeam, typed_cells
from scipy.sparse import csgraph

from rota.errors import MissionError
from rota.planners.bounce.bounce_map import (
    NOWHERE,
    cycles_and_basins,
    joint_map,
    make_team,
    require_memory,
    single_map,
)

SMALL = ".#.\n...\n..#"


def states_of(team_cells, s: int) -> tuple[int, int, int]:
    cell, heading = divmod(s, team_cells.headings)
    return int(team_cells.column[cell]), int(team_cells.row[cell]), heading


def test_a_lane_of_three_cells_worked_by_hand() -> None:
    # 180 degrees: east and west shuttle in 2 moves and a turn each way; all other headings turn in place
    cells = typed_cells("...")
    found = cycles_and_basins(single_map(make_team(cells, [4])))
    assert sorted(found.length.tolist()) == [2] * 9 + [6]
    assert found.basin[found.length == 6].tolist() == [6]


def test_an_open_square_of_three_cells_worked_by_hand() -> None:
    # 90 degrees with 4 headings: round the border 8 moves and 4 turns; any lane's robot comes to it
    cells = typed_cells("...\n...\n...", headings=4)
    found = cycles_and_basins(single_map(make_team(cells, [1])))
    assert found.length.tolist() == [12]
    assert found.basin.tolist() == [36]


@pytest.mark.parametrize("corners", ["blocked", "pass"])
@pytest.mark.parametrize(("text", "bounces", "headings"), [(SMALL, [3, 2], 8), ("...\n.#.", [1, 1, 3], 4)])
def test_the_joint_map_is_that_of_the_readings(text: str, bounces: list[int], headings: int, corners: str) -> None:
    cells = typed_cells(text, headings=headings, corners=corners)
    plain = PlainTeam(text, bounces, headings, corners)
    team = make_team(cells, bounces)
    successor = joint_map(team)
    number = {states_of(cells, s): s for s in range(cells.states)}

    def packed(joint) -> int:
        return sum(number[state] * cells.states**i for i, state in enumerate(joint))

    seen = 0
    for joint in plain.joints():
        assert successor[packed(joint)] == packed(plain.step(joint)[0])
        seen += 1
    assert (successor != NOWHERE).sum() == seen


@pytest.mark.parametrize("robots", [1, 2])
@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    marks=st.lists(st.booleans(), min_size=12, max_size=12).filter(any),
    bounce=st.integers(1, 7),
)
def test_cycles_and_basins_are_the_components_that_scipy_finds(robots: int, marks: list[bool], bounce: int) -> None:
    text = "\n".join("".join(".#"[not mark] for mark in marks[k : k + 4]) for k in (0, 4, 8))
    cells = typed_cells(text)
    successor = joint_map(make_team(cells, [bounce] * robots))
    real = np.flatnonzero(successor != NOWHERE)
    to = successor[real].astype(np.int64)
    graph = scipy.sparse.coo_matrix((np.ones(len(real)), (real, to)), shape=(len(successor),) * 2).tocsr()
    found = cycles_and_basins(successor.copy())
    assert (found.cycle[successor == NOWHERE] == -1).all()
    _, basins = csgraph.connected_components(graph, connection="weak")
    pairs = set(zip(basins[real].tolist(), found.cycle[real].tolist(), strict=True))
    assert len(pairs) == len({basin for basin, _ in pairs}) == len(found.length)
    _, strong = csgraph.connected_components(graph, connection="strong")
    sizes = np.bincount(strong)[strong]
    fixed = real[to == real]
    assert sorted(found.length.tolist()) == sorted(
        [len(list(g)) for _, g in itertools.groupby(sorted(strong[sizes > 1]))] + [1] * len(fixed)
    )
    assert found.basin.tolist() == np.bincount(found.cycle[real], minlength=len(found.length)).tolist()


@pytest.mark.parametrize(("text", "robots"), [(SMALL, 2), ("...\n.#.", 3)])
def test_unordered_robots_have_the_cycles_of_ordered_ones(text: str, robots: int) -> None:
    cells = typed_cells(text)
    team = make_team(cells, [3] * robots)
    ordered = cycles_and_basins(joint_map(team))
    sets = cycles_and_basins(map_of_sets(team))
    assert len(sets.cycle) == math.comb(cells.states, robots)
    expected = sorted(zip(ordered.length.tolist(), ordered.basin.tolist(), strict=True))
    counts, lengths, basins = tell_apart(team, sets)
    told = [pair for c, *pair in zip(counts, lengths, basins, strict=True) for _ in range(c)]
    assert sorted((int(length), int(basin)) for length, basin in told) == expected
    assert counts.max() > 1


def test_wide_bodies_pass_only_at_their_distance() -> None:
    cells = typed_cells("....\n....")
    number = {states_of(cells, s): s for s in range(cells.states)}

    def after(apart_m: float, one, other) -> tuple:
        team = make_team(cells, [4, 4], apart_m=apart_m)
        packed = joint_map(team)[number[one] + cells.states * number[other]]
        return (
            None if packed == NOWHERE else tuple(states_of(cells, int(p)) for p in divmod(packed, cells.states))[::-1]
        )

    # side by side in lanes 1 m apart, against each other
    assert after(0.9, (0, 0, 0), (1, 1, 4)) == ((1, 0, 0), (0, 1, 4))
    assert after(1.1, (0, 0, 0), (1, 1, 4)) == ((0, 0, 4), (1, 1, 0))
    # neighbours that are nearer than their bodies allow are no state at all
    assert after(1.1, (0, 0, 0), (1, 0, 0)) is None
    # following diagonally into what is left: nearest are they at (0.5, 0.5), 0.707 m
    assert after(0.7, (0, 0, 0), (1, 0, 2)) == ((1, 0, 0), (1, 1, 2))
    assert after(0.72, (0, 0, 0), (1, 0, 2)) == ((0, 0, 4), (1, 0, 6))


def test_maps_beyond_memory_are_refused_with_an_estimate() -> None:
    with pytest.raises(MissionError, match=r"5 robots has 800 \*\* 5 = 3\.28e\+14 states .* GB.*improved"):
        require_memory(800, 5)
    require_memory(800, 2)
    with pytest.raises(ValueError, match="1 to 7"):
        make_team(typed_cells(SMALL), [8])
