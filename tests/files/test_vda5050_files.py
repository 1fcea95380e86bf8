"""Files of orders, each line judged as a vehicle would by vda5050-sdk."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from tests.files.test_vda5050_orders import drive
from tests.files.two_robots import two_robots, with_heights

from rota.errors import MissionError, PlanError
from rota.files.vda5050_files import OrderSettings, write_vda5050_orders
from rota.model.plan import Plan, Trajectory


def lines_of(plan: Plan, folder: Path, settings: OrderSettings | None = None, **options: Any) -> list[list[Any]]:
    paths = write_vda5050_orders(plan, folder / "orders", settings=settings, **options)
    assert [path.name for path in paths] == [f"{trajectory.robot}.orders.jsonl" for trajectory in plan]
    return [[json.loads(line) for line in path.read_text().splitlines()] for path in paths]


def test_orders_and_updates_go_on_for_whole_rounds(tmp_path: Path) -> None:
    start = datetime(2026, 5, 1, 12, tzinfo=UTC)
    settings = OrderSettings(duration_s=4 + 30 * 61.6, manufacturer="KIT")
    looping, staying = lines_of(two_robots(robots=("a", "b")), tmp_path, settings, start=start)
    assert {message["manufacturer"] for message in looping} == {"KIT"}
    assert {message["serialNumber"] for message in looping} == {"a"}
    assert len({message["orderId"] for message in looping}) == 1
    assert [message["orderUpdateId"] for message in looping] == list(range(len(looping)))
    # a message releases one round of four stops, and 30 rounds end in time
    assert len(looping) == 30
    passed = drive(looping)
    assert len(passed) == 2 + 30 * 4
    round_s = 61.5004
    stamps = [datetime.fromisoformat(message["timestamp"]) for message in looping]
    due_s = [(stamp - start).total_seconds() for stamp in stamps]
    # a robot has at least a round ahead when it hears of the next one
    arrivals_s = [4 + round_s * number for number in range(len(looping))]
    assert due_s[0] == 0
    assert all(0 <= due <= max(arrival - round_s, 0) + 1e-3 for due, arrival in zip(due_s, arrivals_s, strict=True))
    (order,) = staying
    assert [node["released"] for node in order["nodes"]] == [True, True]


def test_another_plan_is_another_order(tmp_path: Path) -> None:
    plan = two_robots(robots=("a", "b"))
    moved = replace(plan.trajectories[1], positions_m=[[200, 201], [200, 90]])
    ids = [
        lines_of(replace(plan, trajectories=(trajectory,)), tmp_path / name)[0][0]["orderId"]
        for name, trajectory in (("one", plan.trajectories[1]), ("two", plan.trajectories[1]), ("three", moved))
        if (tmp_path / name).mkdir() is None
    ]
    assert ids[0] == ids[1] != ids[2]


def test_what_vda5050_cannot_say_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    with pytest.raises(PlanError, match=r"robot a: its positions have heights, of which VDA 5050 knows nothing"):
        lines_of(with_heights(), tmp_path)
    with pytest.raises(
        PlanError, match=r"serial number '<Zoë> .*: VDA 5050 takes only the characters A-Z a-z 0-9 _ - . :"
    ):
        lines_of(two_robots(), tmp_path)
    plan = two_robots(robots=("a", "b"))
    with pytest.raises(PlanError, match="manufacturer 'K/T': VDA 5050"):
        lines_of(plan, tmp_path, OrderSettings(manufacturer="K/T"))
    with pytest.raises(PlanError, match=r"robot a: its route of .* ends after the year 9999"):
        lines_of(plan, tmp_path, start=datetime(9999, 12, 31, 23, 59, tzinfo=UTC))
    with pytest.raises(MissionError, match=r"--set\.duration_s: 0 is not allowed; it must be greater than 0"):
        OrderSettings(duration_s=0)
    assert not (tmp_path / "orders").exists()


def test_vehicles_of_another_version_wait_by_an_action_of_theirs(tmp_path: Path) -> None:
    settings = OrderSettings(version="3.0.0", wait_action="noop:seconds")
    looping, _ = lines_of(two_robots(robots=("a", "b")), tmp_path, settings)
    assert {message["version"] for message in looping} == {"3.0.0"}
    actions = {
        (action["actionType"], action["actionParameters"][0]["key"])
        for message in looping
        for node in message["nodes"]
        for action in node["actions"]
    }
    assert actions == {("noop", "seconds")}
    assert all("maximumSpeed" in edge and "maxSpeed" not in edge for message in looping for edge in message["edges"])


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"version": "1.1.0"}, r"--set\.version: '1\.1\.0' is not allowed; 2\.0, 2\.1 and 3\.0 are spoken"),
        ({"version": ""}, r"--set\.version: '' is not allowed"),
        ({"wait_action": "wait:"}, r"--set\.wait_action: 'wait:' is not allowed; NAME:PARAMETER is needed"),
        ({"wait_action": "waitForTrigger"}, r"'waitForTrigger' waits for a trigger, which nobody gives to orders"),
    ],
)
def test_versions_and_actions_that_orders_cannot_have_are_refused(given: dict[str, str], message: str) -> None:
    with pytest.raises(PlanError, match=message):
        OrderSettings(**given)  # type: ignore[arg-type]


def test_long_loops_are_released_a_part_at_a_time(tmp_path: Path) -> None:
    count = 240
    places = [[x, 0] for x in range(count)] + [[count - x, 0] for x in range(count + 1)]
    to_and_fro = Trajectory(robot="a", times_s=range(len(places)), positions_m=places)
    (sent,) = lines_of(replace(two_robots(robots=("a", "b")), trajectories=(to_and_fro,)), tmp_path)
    assert {sum(node["released"] for node in message["nodes"]) for message in sent} == {51}
    assert {len(message["nodes"]) for message in sent} == {76}
    assert len(drive(sent)) >= 2 * len(places)
