"""The paper's numbers, against its tables as the article prints them."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from rota_studies.sun2019 import paper
from rota_studies.sun2019.printed_settings import TABLE_7
from rota_studies.sun2019_method.partition import PartitionSettings

# Sensors 19(9):1994, CC BY 4.0: rows of Tables 5, 6 and 8 as they stand there, two routes side by side in the last two
TABLE_5 = """
Path 1 | 40.00 | 36.37
Path 2 | 20.00 | 18.81
Path 3 | 40.00 | 37.29
Path 4 | 8.00 | 6.75
Path 5 | 8.00 | 7.19
"""
TABLE_6 = """
Path 1 | 2 | 10.00 | 9.33  | Path 1 | 2 | 20.00 | 19.47
Path 2 | 2 | 10.00 | 8.68  | Path 2 | 2 | 20.00 | 19.41
Path 3 | 3 | 40.00 | 38.39 | Path 3 | 3 | 30.00 | 28.77
Path 4 | 1 | 12.00 | 10.95 | Path 4 | 1 | 12.00 | 10.95
Path 5 | 3 | 40.00 | 38.22 | Path 5 | 3 | 30.00 | 29.03
Path 1 | 2 | 7.00  | 6.30  | Path 1 | 2 | 10.00 | 9.33
Path 2 | 2 | 7.00  | 5.74  | Path 2 | 2 | 10.00 | 8.74
Path 3 | 2 | 7.00  | 5.91  | Path 3 | 2 | 10.00 | 6.35
Path 4 | 2 | 7.00  | 5.57  | Path 4 | 2 | 20.00 | 18.48
Path 5 | 3 | 40.00 | 36.22 | Path 5 | 3 | 20.00 | 18.83
Path 6 | 1 | 12.00 | 10.95 | Path 6 | 1 | 12.00 | 10.95
Path 7 | 3 | 40.00 | 38.22 | Path 7 | 3 | 20.00 | 18.92
       |   |       |       | Path 8 | 3 | 20.00 | 18.65
Path 1 | 2 | 10.00 | 6.94  | Path 1 | 2 | 10.00 | 9.53
Path 2 | 2 | 10.00 | 8.82  | Path 2 | 2 | 10.00 | 9.75
Path 3 | 2 | 10.00 | 9.34  | Path 3 | 2 | 10.00 | 8.97
Path 4 | 3 | 20.00 | 18.28 | Path 4 | 3 | 10.00 | 9.05
Path 5 | 3 | 20.00 | 19.27 | Path 5 | 3 | 10.00 | 9.41
Path 6 | 1 | 8.00  | 7.24  | Path 6 | 3 | 10.00 | 9.05
Path 7 | 1 | 8.00  | 7.40  | Path 7 | 1 | 12.00 | 10.95
Path 8 | 3 | 20.00 | 17.20 | Path 8 | 3 | 10.00 | 11.64
Path 9 | 3 | 20.00 | 18.52 | Path 9 | 3 | 10.00 | 10.53
       |   |       |       | Path 10 | 3 | 10.00 | 10.90
       |   |       |       | Path 11 | 3 | 10.00 | 10.41
"""
TABLE_8 = """
Path 1 | 45.00 | 44.12 | Path 5 | 10.00 | 7.86
Path 2 | 45.00 | 37.65 | Path 6 | 10.00 | 8.00
Path 3 | 12.00 | 10.12 | Path 7 | 45.00 | 39.14
Path 4 | 45.00 | 39.17 |        |       |
"""


def columns(table: str, width: int) -> list[list[tuple[str, ...]]]:
    """The rows of each of the columns of routes that stand side by side."""
    rows = [[cell.strip() for cell in line.split("|")] for line in table.strip().splitlines()]
    return [
        [tuple(row[k : k + width]) for row in rows if row[k].startswith("Path")] for k in range(0, len(rows[0]), width)
    ]


def told(route: paper.PaperRoute) -> tuple[str, ...]:
    zone = () if route.zone is None else (str(route.zone),)
    return (*zone, f"{route.period_s:.2f}", f"{route.time_s:.2f}")


def test_table_5() -> None:
    assert [told(route) for route in paper.TABLE_5.routes] == [row[1:] for row in columns(TABLE_5, 3)[0]]
    assert paper.TABLE_5.periods_s == (8, 20, 40)


def test_table_6() -> None:
    left, right = columns(TABLE_6, 4)
    printed: list[list[tuple[str, ...]]] = []
    for rows in (left, right):
        for row in rows:
            printed += [[]] if row[0] == "Path 1" else []
            printed[-1].append(row[1:])
    cases = [paper.TABLE_6[k] for k in (0, 2, 4, 1, 3, 5)]  # the left column has Cases 1, 3 and 5
    assert [[told(route) for route in case.routes] for case in cases] == printed
    # Section 5.2 and the table: of Path 4 in Case 4 the period is that of sub-region 3
    odd = [
        (case.name, k + 1)
        for case in paper.TABLE_6
        for k, route in enumerate(case.routes)
        if route.period_s != case.periods_s[route.zone - 1]
    ]
    assert odd == [("Case 4", 4)]


def test_table_8() -> None:
    first, second = columns(TABLE_8, 3)
    assert [told(route) for route in paper.TABLE_8.routes] == [row[1:] for row in first + second]


def test_late_are_the_last_four_of_case_6_alone() -> None:
    cases = (paper.TABLE_5, *paper.TABLE_6, paper.TABLE_8)
    late = [(case.name, k + 1) for case in cases for k, route in enumerate(case.routes) if route.late]
    assert late == [("Case 6", 8), ("Case 6", 9), ("Case 6", 10), ("Case 6", 11)]


@pytest.mark.parametrize(("run", "sensors"), [(paper.FIGURE_13, 96), (paper.FIGURE_16, 83)])
def test_sensors_of_the_zones_add_up(run: paper.PaperRun, sensors: int) -> None:
    assert sum(run.sensors) == sensors
    assert run.tour_length == 61_025.99


def test_the_papers_plans_bound_the_weight_of_what_is_late() -> None:
    margin_s, robot, early, around_s = 0.5, 1000.0, 100.0, 2 * np.pi * 5 / 20

    def spare(routes: list[paper.PaperRoute]) -> list[float]:
        return [route.period_s - margin_s - route.time_s for route in routes]

    # Case 6: what is late, and what plans with one or two routes more and nothing late cost at most beyond it
    case_6 = spare(list(paper.TABLE_6[5].routes))
    late_s = -sum(min(0.0, spare_s) for spare_s in case_6)
    assert late_s == pytest.approx(5.76)
    one, two = (k * robot + early * (k * (10 - margin_s - around_s) - late_s) for k in (1, 2))
    assert [round(one / late_s), round(two / late_s)] == [211, 523]

    def merged(routes: list[paper.PaperRoute]) -> float:
        """The weight from which on two routes are cheaper than one that has their ends but once."""
        saved = robot + early * sum(spare(routes))
        late_s = sum(route.time_s for route in routes) - around_s + margin_s - routes[0].period_s
        return saved / late_s

    zone_1 = [route for route in paper.TABLE_5.routes if route.period_s == 8]
    zone_2 = [route for route in paper.TABLE_6[2].routes if route.zone == 2]
    assert round(merged(zone_1)) == 227
    assert round(min(merged(list(pair)) for pair in itertools.combinations(zone_2, 2))) == 261
    assert 362 < PartitionSettings().weight_late < 523


def test_table_7_as_printed() -> None:
    printed = ("iterations", "swarms", "particles", "sensors_max", "velocity_min", "velocity_max", "inertia_max",
               "inertia_min", "c1", "c2")  # fmt: skip
    assert [getattr(TABLE_7, name) for name in printed] == [200, 40, 60, 210, -0.1, 0.1, 0.9, 0.4, 2, 2]
