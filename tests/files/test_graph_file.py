"""Graphs in the three forms of file that are read, networkx's own among them, and the missions made of them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rota.errors import MissionError
from rota.files.graph_file import read_graph
from rota.files.mission_file import read_mission
from rota.files.mission_writer import write_mission
from rota.model.mission import Mission

NODES: list[dict[str, Any]] = [{"id": "a", "x": 0, "y": 0}, {"id": "b", "x": 10, "y": 0}, {"id": 3, "pos": [10, 5]}]


def file_with(folder: Path, document: object, name: str = "g.json") -> Path:
    path = folder / name
    path.write_text(document if isinstance(document, str) else json.dumps(document))
    return path


def node_link(*edges: dict[str, Any], directed: bool = False, key: str = "edges") -> dict[str, Any]:
    return {"directed": directed, "multigraph": False, "graph": {}, "nodes": NODES, key: list(edges)}


@pytest.mark.parametrize("key", ["edges", "links"])
def test_node_link_json_gives_places_and_ways(tmp_path: Path, key: str) -> None:
    edges = {"source": "a", "target": "b", "length_m": 12}, {"source": "b", "target": 3, "time_s": 9}
    graph = read_graph(file_with(tmp_path, node_link(*edges, key=key)))
    assert graph.places == {"a": (0, 0), "b": (10, 0), "3": (10, 5)}
    first, second = graph.edges
    assert (first.line_m, first.one_way, first.costs) == (((0, 0), (10, 0)), False, (12, None))
    assert (second.line_m, second.one_way, second.costs) == (((10, 0), (10, 5)), False, (None, 9))


def test_of_a_directed_graph_opposite_edges_that_are_alike_are_one_both_ways(tmp_path: Path) -> None:
    there, back = {"source": "a", "target": "b"}, {"source": "b", "target": "a"}
    slow = {"source": "b", "target": 3, "time_s": 9}, {"source": 3, "target": "b", "time_s": 8}
    graph = read_graph(file_with(tmp_path, node_link(there, back, there, *slow, directed=True)))
    assert [(edge.source, edge.target, edge.one_way) for edge in graph.edges] == [
        ("a", "b", False), ("b", "3", True), ("3", "b", True),
    ]  # fmt: skip


def test_a_nav2_route_graph_gives_its_lines_one_way(tmp_path: Path) -> None:
    def feature(kind: str, at: object, **told: object) -> dict[str, Any]:
        return {"type": "Feature", "properties": told, "geometry": {"type": kind, "coordinates": at}}

    features = [
        feature("Point", [0, 0], id=0), feature("Point", [4, 0, 1.5], id=1),
        feature("MultiLineString", [[[0, 0], [2, 1], [4, 0]]], id=10, startid=0, endid=1),
    ]  # fmt: skip
    graph = read_graph(file_with(tmp_path, {"type": "FeatureCollection", "features": features}))
    assert graph.places == {"0": (0, 0), "1": (4, 0)}
    assert [(edge.line_m, edge.one_way) for edge in graph.edges] == [(((0, 0), (2, 1), (4, 0)), True)]


def test_a_graph_of_patrolling_sim_is_in_pixels_from_the_top(tmp_path: Path) -> None:
    text = "2\n100\n60\n0.5\n1\n2\n\n0\n10\n20\n1\n1\nE\n30\n\n1\n40\n20\n1\n0\nW\n30\n"
    graph = read_graph(file_with(tmp_path, text, "x.graph"))
    assert graph.places == {"0": (6, 22), "1": (21, 22)}
    assert [(edge.line_m, edge.one_way, edge.length_m) for edge in graph.edges] == [(((6, 22), (21, 22)), False, 15)]


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ("{", "is no JSON"),
        ([], "a graph is needed"),
        (node_link(), "holds no edge"),
        (node_link({"source": "a", "target": "z"}), r'edges\[0\]: leads to "z", which is no node'),
        (node_link({"source": "a", "target": "a"}), "from 'a' to itself"),
        (node_link({"source": "a", "target": "b", "time_s": -1}), "time_s = -1 is not allowed"),
        ({"nodes": [{"id": "a", "x": 0}], "edges": []}, r"nodes\[0\]: has the id \"a\" and the place \[0, null\]"),
        ({"nodes": [*NODES, NODES[0]], "edges": []}, r"nodes\[3\]: 'a' is the id of another node"),
    ],
)
def test_what_is_no_graph_is_refused_with_its_place(tmp_path: Path, document: object, message: str) -> None:
    with pytest.raises(MissionError, match=message):
        read_graph(file_with(tmp_path, document))


def mission_on(folder: Path, graph: object, **fields: object) -> Mission:
    file_with(folder, graph)
    told = {
        "rota": 1, "name": "m", "area": {"graph": "g.json"}, "period_s": 60,
        "fleet": {"speed_m_s": 1, "sensor": {"shape": "disc", "radius_m": 1}}, **fields,
    }  # fmt: skip
    return read_mission(file_with(folder, told, "m.json")).mission


SWARM = {"robots": 3, "speed_m_s": 1, "sensor": {"shape": "disc", "radius_m": 1}}
WAYS = ({"source": "a", "target": "b", "length_m": 12}, {"source": "b", "target": 3, "time_s": 9})


def test_a_mission_visits_each_place_of_its_graph_within_the_period(tmp_path: Path) -> None:
    nodes = [{**NODES[0], "period_s": 30}, NODES[1], {**NODES[2], "period_s": None}]
    mission = mission_on(tmp_path, {**node_link(*WAYS), "nodes": nodes})
    assert [(zone.name, zone.period_s, zone.demand) for zone in mission.zones] == [
        ("a", 30, "visit"), ("b", 60, "visit"),
    ]  # fmt: skip
    assert mission.period_s is None
    assert [(lane.line_m, lane.length_m, lane.least_s) for lane in mission.lanes] == [
        (((0, 0), (10, 0)), 12, None), (((10, 0), (10, 5)), None, 9),
    ]  # fmt: skip
    left, bottom, right, top = mission.area.bounds
    assert (left, bottom, right, top) == pytest.approx((-0.5, -0.5, 10.5, 5.5), abs=0.01)


def test_a_zone_may_name_a_place(tmp_path: Path) -> None:
    mission = mission_on(tmp_path, node_link(*WAYS), zones=[{"place": "b", "period_s": 20}])
    assert {zone.name: zone.period_s for zone in mission.zones} == {"a": 60, "b": 20, "3": 60}
    with pytest.raises(MissionError, match="place: 'c' is no place of the graph; the id of a node"):
        mission_on(tmp_path, node_link(*WAYS), zones=[{"place": "c", "period_s": 20}])


def test_an_edge_shorter_than_its_line_is_refused(tmp_path: Path) -> None:
    with pytest.raises(MissionError, match="from 'a' to 'b' is 3 m long, but 10 m are between its ends"):
        mission_on(tmp_path, node_link({"source": "a", "target": "b", "weight": 3}))


def test_a_graph_in_degrees_lies_where_they_say(tmp_path: Path) -> None:
    nodes = [{"id": "a", "x": 11.5, "y": 48.1}, {"id": "b", "x": 11.5, "y": 48.101}]
    graph = {"nodes": nodes, "edges": [{"source": "a", "target": "b"}]}
    mission = mission_on(tmp_path, graph, coordinates="wgs84")
    assert mission.lanes[0].drawn_m == pytest.approx(111.2, abs=0.2)  # a thousandth of a degree of latitude at 48.1


def test_lanes_are_written_and_read_back(tmp_path: Path) -> None:
    mission = mission_on(tmp_path, node_link(*WAYS, directed=True))
    write_mission(mission, tmp_path / "again.yaml")
    assert read_mission(tmp_path / "again.yaml").mission == mission


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"planner": "swarm", "fleet": SWARM, "period_s": None}, "lanes: the swarm planner has no use for lanes"),
        ({"area": {"graph": "none.json"}}, "none.json: no such file"),
        ({"area": {"graph": "g.json", "map": "x.yaml"}}, "exactly one of"),
        ({"area": [[0, 0], [9, 0], [9, 9]], "zones": [{"place": "b", "period_s": 9}]}, "only an area that is a graph"),
        ({"lanes": [{"line_m": [[0, 0], [1, 0]]}]}, "given beside area.graph"),
        ({"period_s": None}, "period_s"),
    ],
)
def test_contradictions_are_told(tmp_path: Path, fields: dict[str, object], message: str) -> None:
    with pytest.raises(MissionError, match=message):
        mission_on(tmp_path, node_link(*WAYS), **fields)
