"""The stage settings of method sun2019: from mission and sweep files to the stages, into plan files and back."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from benchmarks.sun_tables import TABLE_2, TABLE_3, TABLE_4

from rota.errors import MissionError, PlanError
from rota.files.mission_file import read_mission
from rota.files.mission_json import mission_to_json
from rota.files.plan_file import plan_from_json, plan_to_json
from rota.files.sweep_file import read_sweep
from rota.geometry.free_space import standing_space
from rota.geometry.shortest_path import ShortestPaths
from rota.model.mission import Mission
from rota.model.plan import Plan, Trajectory
from rota.model.planner_settings import Settings, settings_of
from rota.planners.patrol.methods.sun2019.our_settings import Sun2019 as OwnSettings
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.sweep.cells import combinations
from rota_studies.sun2019_method import algorithms
from rota_studies.sun2019_method.algorithms import PaperAlgorithms
from rota_studies.sun2019_method.mission_settings import (
    FrameSettings,
    SegmentSettings,
    SensorSettings,
    Sun2019,
)
from rota_studies.sun2019_stages.stages import cut_in_segments, framed_sensors

ROOT = Path(__file__).parents[3]
FIELD = """\
rota: 1
name: field
area: [[0, 0], [30, 0], [30, 30], [0, 30]]
period_s: 40
fleet: {speed_m_s: 4, sensor: {shape: disc, radius_m: 5}}
"""
STAGES = """\
patrol:
  method: sun2019
  sun2019:
    {deployment: ccpso2, tour: genetic, partition: pso, sensors: {iterations: 9, group_sizes: [3, 5], fusion: false},
     frame: {alpha_m: 500, neighbour_range: 3, a_star: {rest: 0.5}, population: 40}, segments: {weight_late: 400}}
"""


def algorithms_of(mission: Mission) -> PaperAlgorithms:
    planning = PatrolSettings.of(mission)
    assert isinstance(planning.method_settings, Sun2019)
    return algorithms.algorithms_of(planning.method_settings, planning.effort)


def mission_of(tmp_path: Path, text: str) -> Mission:
    (tmp_path / "field.yaml").write_text(text)
    return read_mission(tmp_path / "field.yaml").mission


def test_stage_settings_of_a_mission_file_reach_the_stages(tmp_path: Path) -> None:
    settings = algorithms_of(mission_of(tmp_path, FIELD + STAGES))
    (deploy,) = settings.deployments
    assert (deploy.method, deploy.iterations, deploy.group_sizes, deploy.fusion) == ("ccpso2", 9, (3, 5), False)
    assert settings.tour == replace(
        TABLE_3, alpha_m=500, neighbour_range=3, a_star=replace(TABLE_3.a_star, rest=0.5), population=40
    )
    assert settings.partition == replace(TABLE_4, weight_late=400)


def test_names_of_the_papers_stages_stand_for_its_tables() -> None:
    asked = Sun2019(deployment="ccpso2", tour="genetic", partition="pso", routes="printed")
    found = algorithms.algorithms_of(asked, "quick")
    assert found.deployments == (replace(TABLE_2, sensors_max=None),)
    assert (found.tour, found.partition) == (TABLE_3, TABLE_4)
    printed = algorithms.algorithms_of(replace(asked, sensors=SensorSettings(sensors_max=160)), "quick")
    assert printed == replace(found, deployments=(TABLE_2,))
    assert printed.routes == "printed"


def test_best_is_the_same_as_without_this_distribution() -> None:
    for deployment in ("best", "greedy", "exact"):
        assert Sun2019(deployment=deployment).search == OwnSettings().search
    for asked in (Sun2019(deployment="ccpso2"), Sun2019(routes="printed"), Sun2019(sensors=SensorSettings(cell_m=2))):
        assert asked.search != OwnSettings().search


def test_a_plan_file_keeps_stage_settings_and_lacks_those_at_their_defaults(tmp_path: Path) -> None:
    mission = mission_of(tmp_path, FIELD + STAGES)
    stay = Trajectory(robot="robot-1", times_s=[0.0], positions_m=[[5.0, 5.0]])
    document = plan_to_json(Plan(mission=mission, trajectories=(stay,)))
    kept = document["mission"]["patrol"]["sun2019"]
    assert kept["frame"] | {"alpha_m": 500, "a_star": {"before": 1.0, "step": 1.0, "rest": 0.5}} == kept["frame"]
    assert kept["sensors"]["group_sizes"] == [3, 5]
    assert plan_from_json(document).mission.planning == mission.planning
    plain = mission_to_json(mission_of(tmp_path, FIELD))["patrol"]["sun2019"]
    assert plain == {"deployment": "best", "tour": "local_search", "partition": "exact", "routes": "shortened"}


def test_settings_of_a_method_are_there_where_it_is_chosen(tmp_path: Path) -> None:
    asked = mission_of(tmp_path, FIELD + STAGES)
    tours = asked.with_method("tours")
    assert tours.planning == mission_of(tmp_path, FIELD).planning
    assert PatrolSettings().method_settings is None
    assert asked.with_method("sun2019") == asked
    assert tours.with_method("sun2019").planning == PatrolSettings(method="sun2019", method_settings=Sun2019())
    for method, told in (("tours", "Sun2019 is not of method tours"), ("sun2019", "SensorSettings is not of method")):
        given = Sun2019() if method == "tours" else SensorSettings()
        with pytest.raises(MissionError, match=rf"patrol\.method_settings: {told}"):
            PatrolSettings(method=method, method_settings=given)


def test_plan_files_of_other_methods_with_stage_settings_are_read(tmp_path: Path) -> None:
    """Comparing a mission with stage settings wrote such plans, and no plan file's first version lacks the block."""
    mission = mission_of(tmp_path, FIELD)
    stay = Trajectory(robot="robot-1", times_s=[0.0], positions_m=[[5.0, 5.0]])
    document = plan_to_json(Plan(mission=mission, trajectories=(stay,)))
    document["mission"]["patrol"]["sun2019"]["partition"] = "pso"
    del document["mission_sha256"]
    assert plan_from_json(document).mission == mission
    document["mission"]["patrol"]["sun2019"]["partition"] = "even"
    with pytest.raises(PlanError, match=r'patrol\.sun2019\.partition: "even" is not allowed; exact or pso is needed'):
        plan_from_json(document)


def test_contradictions_are_refused_in_python_as_in_files() -> None:
    with pytest.raises(MissionError, match=r"patrol\.sun2019\.sensors\.weight_sensor: 200 is not allowed; it must be"):
        SensorSettings(weight_sensor=200)
    with pytest.raises(MissionError, match=r"patrol\.sun2019\.frame\.population: 602 .* a multiple of 4"):
        FrameSettings(population=602)
    with pytest.raises(MissionError, match=r"patrol\.sun2019\.segments\.inertia_min: 0.95 .* at most inertia_max, 0.9"):
        SegmentSettings(inertia_min=0.95)
    assert SegmentSettings(inertia_min=0.9).inertia_min == 0.9


def test_a_sweep_over_alpha_shows_that_fewer_crossings_take_fewer_robots() -> None:
    """The example's first case, cut as exactly as its frames by two alphas can be."""
    found = {}
    for combination in combinations(read_sweep(ROOT / "examples" / "sun2019-table6" / "alpha.yaml")):
        mission = combination.mission
        assert mission is not None
        settings = algorithms_of(mission)
        if combination.mission_file == "case-1.yaml":
            paths = ShortestPaths(standing_space(mission, 0.0))
            framed = framed_sensors(mission, paths, settings.deployments[0], settings, seed=0)
            robots = len(cut_in_segments(framed, mission.fleet.equal_robot("robot-1"), paths, settings).segments)
            found[settings.tour.alpha_m] = framed.parts[0].frame.zone_crossings, robots
    assert list(found) == [10_000, 0]
    assert all(few < many for few, many in zip(*found.values(), strict=True))


def rows_of(block: type[Settings], place: str) -> list[str]:
    """The rows of the table in docs/methods.md."""
    rows = []
    for item in settings_of(block):
        name = f"{place}.{item.name}"
        if item.block is not None:
            rows += rows_of(item.block, name)
        else:
            bounds = item.bounds(in_mission_file=True)
            words = {"ge": "from {:,.12g}", "gt": "above {:,.12g}", "le": "to {:,.12g}"}
            limits = ", ".join(item.options) or " ".join(words[key].format(bounds[key]) for key in bounds)
            rows.append(f"| `{name}` | {told(item.default)} | {limits or 'true, false'} | {item.meaning} |")
    return rows


def told(value: object) -> str:
    """A default as the table has it."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, tuple):
        return ", ".join(map(str, value))
    return f"{value:,g}" if isinstance(value, int | float) else str(value)


def test_the_page_on_methods_tells_every_stage_setting_with_default_limits_and_meaning() -> None:
    blocks = {"sensors": SensorSettings, "frame": FrameSettings, "segments": SegmentSettings}
    rows = [row for place, block in blocks.items() for row in rows_of(block, place)]
    page = (ROOT / "docs" / "methods.md").read_text(encoding="utf-8")
    assert "\n".join(rows) in page, "the rows of the table are now:\n" + "\n".join(rows)
