"""Algorithm 1 against plain Python, joint trajectories that are possible ones, and what cannot be reached."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from maps import PlainTeam, State, typed_cells

from rota.planners.bounce.bounce_map import make_team
from rota.planners.bounce.cells import Cells
from rota.planners.bounce.coverage import Coverage, cover

ROOM = """
..........
.##.......
.....##...
..........
...#......
...#...##.
..........
.....#....
.##..#....
.........."""
SMALL = ".....\n.#...\n...#."


def state_of(cells: Cells, s: int) -> State:
    cell, heading = divmod(int(s), cells.headings)
    return int(cells.column[cell]), int(cells.row[cell]), heading


def random_start(cells: Cells, robots: int, seed: int) -> list[int]:
    rng = np.random.default_rng(seed)
    at = rng.choice(cells.count, robots, replace=False)
    return [int(s) for s in at * cells.headings + rng.integers(0, cells.headings, robots)]


def require_possible(cells: Cells, plain: PlainTeam, found: Coverage) -> None:
    """Every step is the bounce map's, or the turn of one robot by one heading while the others wait."""
    for t in range(found.steps):
        before = tuple(state_of(cells, s) for s in found.states[t])
        after = tuple(state_of(cells, s) for s in found.states[t + 1])
        robot = found.jumps[t]
        if robot < 0:
            assert plain.step(before) == (after, found.contacts[t])
        else:
            for k, (one, other) in enumerate(zip(before, after, strict=True)):
                turn = (other[2] - one[2]) % cells.headings
                assert one[:2] == other[:2]
                assert turn in ((1, cells.headings - 1) if k == robot else (0,))
    entered = {state_of(cells, s)[:2] for s in found.states.ravel()}
    assert {(int(x), int(y)) for x, y in zip(cells.column, cells.row, strict=True)} >= entered
    assert int(found.covered.sum()) == len(entered)


def plain_algorithm_1(plain: PlainTeam, start: tuple[State, ...]) -> list[tuple[State, ...]]:
    """Algorithm 1 as read, in plain Python; returns the joint trajectory."""
    path, processed = [start], set()
    wanted = len(plain.free)

    def covered(states) -> set[tuple[int, int]]:
        return {state[:2] for joint in states for state in joint}

    def follow(path, processed):
        contacts = 0
        while len(covered(path)) < wanted and path[-1] not in processed:
            processed.add(path[-1])
            after, touched = plain.step(path[-1])
            path.append(after)
            contacts += touched
        return contacts

    follow(path, processed)
    while len(covered(path)) < wanted:
        best = None
        for i in range(len(start)):
            for turn in (1, plain.headings - 1):
                x, y, h = path[-1][i]
                neighbour = (*path[-1][:i], (x, y, (h + turn) % plain.headings), *path[-1][i + 1 :])
                if neighbour in processed:
                    continue
                longer, seen = [*path, neighbour], set(processed)
                contacts = follow(longer, seen)
                key = (-len(covered(longer)), contacts, len(longer))
                if best is None or key < best[0]:
                    best = (key, longer, seen)
        if best is None:
            break
        _, path, processed = best
    return path


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("bounces", [[3], [3, 3], [2, 3]])
def test_algorithm_1_is_that_of_the_readings(bounces: list[int], seed: int) -> None:
    cells, plain = typed_cells(SMALL), PlainTeam(SMALL, bounces)
    start = random_start(cells, len(bounces), seed)
    found = cover(cells, make_team(cells, bounces), start, method="as_printed")
    expected = plain_algorithm_1(plain, tuple(state_of(cells, s) for s in start))
    assert [tuple(state_of(cells, s) for s in states) for states in found.states] == expected
    require_possible(cells, plain, found)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    marks=st.lists(st.booleans(), min_size=16, max_size=16).filter(lambda marks: sum(marks) > 4),
    robots=st.integers(1, 3),
    bounce=st.integers(1, 7),
    seed=st.integers(0, 9),
)
def test_any_map_is_covered_as_far_as_robots_have_a_way(marks: list[bool], robots: int, bounce: int, seed: int) -> None:
    text = "\n".join("".join(".#"[not mark] for mark in marks[k : k + 4]) for k in range(0, 16, 4))
    cells = typed_cells(text)
    start = random_start(cells, robots, seed)
    found = cover(cells, make_team(cells, [bounce] * robots), start, most_steps=2000)
    require_possible(cells, PlainTeam(text, [bounce] * robots), found)
    assert not found.covered[found.walled_off].any()
    if robots == 1:  # alone, a robot that may turn by the clock comes everywhere
        assert not found.missed.any()


@pytest.mark.parametrize(("robots", "most"), [(1, 250), (2, 180), (3, 140), (4, 120), (5, 100)])
def test_a_room_is_covered_in_few_steps_from_wherever_robots_begin(robots: int, most: int) -> None:
    cells = typed_cells(ROOM)
    team, plain = make_team(cells, [3] * robots), PlainTeam(ROOM, [3] * robots)
    for seed in range(5):
        found = cover(cells, team, random_start(cells, robots, seed))
        require_possible(cells, plain, found)
        assert found.complete
        assert found.steps <= most
        # no more cells than robots times steps can be entered
        assert found.steps >= cells.count / robots - 1


def test_two_robots_in_one_cell_are_refused_and_a_wall_is_told() -> None:
    cells = typed_cells("..#.\n..#.")
    team = make_team(cells, [3, 3])
    with pytest.raises(ValueError, match="one cell"):
        cover(cells, team, [0, 3])
    found = cover(cells, team, [0, 8])
    assert found.walled_off.sum() == 2
    assert not found.missed.any()
    assert found.share == pytest.approx(4 / 6)
    # the limit of steps leaves what could be entered
    assert cover(typed_cells(ROOM), team=make_team(typed_cells(ROOM), [3]), start=[0], most_steps=9).missed.any()
