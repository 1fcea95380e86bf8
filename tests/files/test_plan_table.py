"""Tables of timed points, read back by Python's csv and by numpy."""

from __future__ import annotations

import csv
import io

import numpy as np
from pyproj import Geod
from tests.files.two_robots import ORIGIN, ROBOTS, two_robots, with_heights

from rota.files.executed.timed_files import as_csv
from rota.files.plan_table import csv_text
from rota.files.spreadsheet_cells import as_cell, from_cell
from rota.model.plan import Plan


def rows_of(plan: Plan) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(csv_text(plan))))


def test_every_number_reads_back_equal() -> None:
    plan = two_robots()
    rows = rows_of(plan)
    assert list(rows[0]) == ["robot", "t_s", "x_m", "y_m", "lat", "lon", "in_loop"]
    for name, trajectory in zip(ROBOTS, plan, strict=True):
        mine = [row for row in rows if row["robot"] == name]
        assert [float(row["t_s"]) for row in mine] == trajectory.times_s.tolist()
        assert [[float(row["x_m"]), float(row["y_m"])] for row in mine] == trajectory.positions_m.tolist()
    assert [row["in_loop"] for row in rows] == ["0", "1", "1", "1", "1", "1", "1", "0", "1"]


def test_places_on_the_globe_are_as_far_from_the_origin() -> None:
    rows = rows_of(two_robots())
    for row in rows:
        _, _, distance_m = Geod(ellps="WGS84").inv(ORIGIN.lon, ORIGIN.lat, float(row["lon"]), float(row["lat"]))
        assert abs(distance_m - np.hypot(float(row["x_m"]), float(row["y_m"]))) < 1e-6


def test_without_an_origin_numpy_reads_the_same_numbers() -> None:
    plan = two_robots(origin=None, robots=("a", "b"))
    read = np.genfromtxt(io.StringIO(csv_text(plan)), delimiter=",", names=True, dtype=None, encoding="utf-8")
    assert read.dtype.names == ("robot", "t_s", "x_m", "y_m", "in_loop")
    np.testing.assert_array_equal(read["t_s"], np.concatenate([t.times_s for t in plan]))
    np.testing.assert_array_equal(read["y_m"], np.concatenate([t.positions_m[:, 1] for t in plan]))


def test_no_name_is_computed_by_a_spreadsheet_and_each_reads_back() -> None:
    names = ("=1+1", "'=1+1", "+x", "-x", "@SUM(A1)", "\tx", "'x", "it's", "a=b")
    cells = [as_cell(name) for name in names]
    assert not [cell for cell in cells if cell[0] in "=+-@\t\r"]
    assert [from_cell(cell) for cell in cells] == list(names)
    assert cells[-3:] == ["'x", "it's", "a=b"]
    plan = two_robots(robots=("=1+1", "'=1+1"))
    assert list(dict.fromkeys(row["robot"] for row in rows_of(plan))) == ["'=1+1", "''=1+1"]
    assert [driven.robot for driven in as_csv(plan)] == ["=1+1", "'=1+1"]


def test_heights_have_a_column_when_any_robot_has_them() -> None:
    rows = rows_of(with_heights())
    assert [row["z_m"] for row in rows] == ["30.0", "40.125", "30.0", "", ""]
