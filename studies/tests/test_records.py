"""Records: runs are made once, what is asked for comes from them alone, and a run that changed is told."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapely import box

from rota.errors import RotaError
from rota.model.mission import DiscSensor, Fleet, Mission
from rota.model.plan import Plan, Trajectory
from rota_studies.records import (
    Job,
    Record,
    Records,
    RecordsFile,
    drawn_ways,
    mission_digest,
    plan_digest,
    read_records,
)

RUN = {"what": "sum", "seed": 1}


def never() -> Any:
    raise AssertionError("ran all the same")


def test_a_run_is_made_once_and_read_back_from_its_record() -> None:
    records, made = Records(), []

    def make() -> float:
        made.append(None)
        return 1 / 3

    assert records.get(float, RUN, make) == records.get(float, RUN, make) == 0.3333333
    assert len(made) == 1
    assert records.used == (Record(RUN, 0.3333333),)


def test_several_runs_keep_their_order_and_known_ones_are_not_made() -> None:
    records = Records([Record({"k": 1, "seed": 0}, 10)])
    jobs = [Job({"k": 2}, lambda: 20), Job({"seed": 0, "k": 1}, never), Job({"k": 3}, lambda: 30)]
    assert records.get_all(int, jobs) == [20, 10, 30]
    assert [record.run["k"] for record in records.used] == [2, 1, 3]


def test_without_a_record_nothing_is_run_where_nothing_may() -> None:
    with pytest.raises(RotaError, match=r'the records have no run \{"seed": 1, "what": "sum"\}'):
        Records(may_run=False).get(float, RUN, never)


def test_a_run_made_again_that_comes_to_something_else_is_told() -> None:
    known = [Record(RUN, {"robots": 3}), Record({"what": "other"}, {"robots": 5})]
    records = Records(known, again=lambda record: record.run["what"] == "sum")
    assert records.get(dict[str, int], RUN, lambda: {"robots": 4}) == {"robots": 3}  # the page shows its record
    records.get(dict[str, int], {"what": "other"}, never)
    ((run, recorded, now),) = records.changed
    assert (run, recorded, now) == (RUN, {"robots": 3}, {"robots": 4})
    same = Records(known, again=lambda _: True)
    same.get(dict[str, int], RUN, lambda: {"robots": 3})
    assert same.changed == []


def test_a_file_of_records_is_read_as_it_was_written(tmp_path: Path) -> None:
    file = RecordsFile(study="some2020", seed=3, settings={"seeds": 8}, runs=(Record(RUN, [0.5, "inf"]),))
    (tmp_path / "some2020.json").write_text(file.text)
    assert read_records(tmp_path / "some2020.json", "some2020") == file
    assert len(file.text.splitlines()) == len(file.runs) + 5
    assert json.loads(file.text)["runs"] == [{"run": RUN, "came_out": [0.5, "inf"]}]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("no", "not JSON"),
        ("[]", "holds no records of a study"),
        ('{"study": "other", "rota": "1", "seed": 0, "settings": {}, "runs": []}', "holds records of 'other'"),
        ('{"study": "some2020", "rota": "1", "seed": 0, "settings": {}, "runs": [{}]}', "a run has no 'run'"),
        ('{"study": "some2020", "rota": "1", "seed": "x", "settings": {}, "runs": []}', "the seed is no number"),
    ],
)
def test_other_files_are_refused(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "file.json").write_text(text)
    with pytest.raises(RotaError, match=f"file.json: .*{message}"):
        read_records(tmp_path / "file.json", "some2020")


def test_a_file_that_is_missing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RotaError, match="cannot be read"):
        read_records(tmp_path / "none.json", "some2020")


def plan(shift_m: float = 0.0) -> Plan:
    mission = Mission(
        name="yard", area=box(0, 0, 9, 9), period_s=9, fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=5))
    )
    places = np.array([[1.0 + shift_m, 1.0], [2.0, 1.0], [2.0, 1.0 + 1e-12], [1.0 + shift_m, 1.0]])
    way = Trajectory(robot="a", times_s=np.array([0.0, 1.0, 1.0 + 1e-12, 2.0]), positions_m=places)
    return Plan(mission=mission, trajectories=(way,))


def test_digests_tell_plans_and_missions_apart_but_not_by_rounding() -> None:
    assert plan_digest(plan()) == plan_digest(plan(1e-9)) != plan_digest(plan(0.1))
    assert mission_digest(plan().mission) == mission_digest(plan(0.1).mission)


def test_ways_to_be_drawn_have_no_two_points_at_a_moment() -> None:
    (way,) = drawn_ways(plan())
    assert way.times_s.tolist() == [0, 1, 2]
    assert way.positions_m.tolist() == [[1, 1], [2, 1], [1, 1]]
