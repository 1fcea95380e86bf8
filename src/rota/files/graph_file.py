"""Graphs of places and ways: networkx node-link JSON, Nav2 route graphs, and the .graph files of patrolling_sim."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from rota.errors import MissionError
from rota.files.json_text import unique_keys
from rota.files.local_file import read_text
from rota.model.refusals import show_value

Point = tuple[float, float]

NEEDED = (
    "a graph is needed: networkx node-link JSON {nodes: [{id, x, y}, ...], edges: [{source, target}, ...]},"
    " a Nav2 route graph (GeoJSON), or a .graph file of patrolling_sim"
)
LENGTHS, TIMES = ("length_m", "length", "weight"), ("time_s", "seconds")
ROUNDED = 0.02  # a length may be shorter than the line by this share: files round


class Edge(NamedTuple):
    """A way from one place to another, as it is drawn; length_m, least_s: None where the file does not say."""

    source: str
    target: str
    line_m: tuple[Point, ...]
    one_way: bool
    length_m: float | None
    least_s: float | None

    @property
    def costs(self) -> tuple[float | None, float | None]:
        """What driving it takes."""
        return self.length_m, self.least_s


class Graph(NamedTuple):
    """Places by their names, the period_s that some have (None: nothing is asked), and the edges between them."""

    places: Mapping[str, Point]
    periods_s: Mapping[str, Any]
    edges: tuple[Edge, ...]


def read_graph(path: Path) -> Graph:
    """The graph in a file, its coordinates as they stand there. Two opposite edges that are alike are one both ways.

    Node-link JSON: nodes with x and y, or pos: [x, y]; edges (or links) with length_m, length or weight, in metres, and
    time_s or seconds; ``directed`` says whether edges are one-way. Nav2: points with an id, one-way lines with startid
    and endid. patrolling_sim: pixels times the resolution, north up. Raises MissionError, all faults at once.
    """
    text = read_text(path, "a graph")
    if path.suffix == ".graph":
        return _graph_of_patrolling_sim(path, text)
    try:
        document = json.loads(text, object_pairs_hook=unique_keys)
    except ValueError as error:
        raise MissionError(f"{path}: is no JSON: {error}; {NEEDED}") from None
    if isinstance(document, dict) and isinstance(document.get("features"), list):
        return _graph_of(path, _nodes_of_nav2(document), _edges_of_nav2(document))
    if not (isinstance(document, dict) and isinstance(document.get("nodes"), list)):
        raise MissionError(f"{path}: {NEEDED}")
    return _graph_of(path, _nodes_of_node_link(document), _edges_of_node_link(document))


class _Node(NamedTuple):
    """A place as the file has it."""

    where: str
    name: Any
    at: Any
    told: Mapping[str, Any]


class _Link(NamedTuple):
    """An edge as the file has it; line: where it runs, None: straight."""

    where: str
    source: Any
    target: Any
    line: Any
    one_way: bool
    told: Mapping[str, Any]


def _nodes_of_node_link(document: Mapping[str, Any]) -> Iterator[_Node]:
    """The nodes of node-link JSON."""
    for k, node in enumerate(document["nodes"]):
        told = node if isinstance(node, dict) else {}
        yield _Node(f"nodes[{k}]", told.get("id"), told.get("pos", [told.get("x"), told.get("y")]), told)


def _edges_of_node_link(document: Mapping[str, Any]) -> Iterator[_Link]:
    """The edges of node-link JSON, which older files call links."""
    key = "edges" if "edges" in document else "links"
    listed = document.get(key)
    for k, edge in enumerate(listed if isinstance(listed, list) else []):
        told = edge if isinstance(edge, dict) else {}
        one_way = bool(document.get("directed"))
        yield _Link(f"{key}[{k}]", told.get("source"), told.get("target"), None, one_way, told)


def _nodes_of_nav2(document: Mapping[str, Any]) -> Iterator[_Node]:
    """The points of a Nav2 route graph."""
    for where, kind, at, told in _features(document):
        if kind == "Point":
            yield _Node(where, told.get("id"), at, told)


def _edges_of_nav2(document: Mapping[str, Any]) -> Iterator[_Link]:
    """The lines of a Nav2 route graph, which run one way."""
    for where, kind, at, told in _features(document):
        if kind in ("LineString", "MultiLineString"):
            line = at[0] if kind == "MultiLineString" and isinstance(at, list) and at else at
            yield _Link(where, told.get("startid"), told.get("endid"), line, True, told)


def _features(document: Mapping[str, Any]) -> Iterator[tuple[str, Any, Any, Mapping[str, Any]]]:
    """The features of GeoJSON: where each is, its kind, its coordinates and its properties."""
    for k, feature in enumerate(document["features"]):
        feature = feature if isinstance(feature, dict) else {}
        geometry, told = feature.get("geometry"), feature.get("properties")
        geometry = geometry if isinstance(geometry, dict) else {}
        yield (
            f"features[{k}]",
            geometry.get("type"),
            geometry.get("coordinates"),
            told if isinstance(told, dict) else {},
        )


def _graph_of(path: Path, nodes: Iterator[_Node], links: Iterator[_Link]) -> Graph:
    """The graph of what a file has; MissionError with all faults."""
    faults, places, periods_s, edges = list[str](), dict[str, Point](), dict[str, Any](), list[Edge]()
    for node in nodes:
        at = _point(node.at)
        name = "" if node.name is None else str(node.name)
        if at is None or not name:
            has = f"has the id {show_value(node.name)} and the place {show_value(node.at)}"
            faults.append(f"{path}: {node.where}: {has}; an id, and x and y in numbers, are needed")
        elif name in places:
            faults.append(f"{path}: {node.where}: {name!r} is the id of another node; ids must be unique")
        else:
            places[name] = at
            if "period_s" in node.told:
                periods_s[name] = node.told["period_s"]
    for link in links:
        try:
            edges.append(_edge(link, places))
        except ValueError as error:
            faults.append(f"{path}: {link.where}: {error}")
    if not faults and not edges:
        faults.append(f"{path}: holds no edge; {NEEDED}")
    if faults:
        raise MissionError(*faults)
    return Graph(places, periods_s, _both_ways(edges))


def _point(at: Any) -> Point | None:
    """Two finite numbers; heights beside them are dropped."""
    numbers = at[:2] if isinstance(at, list) else []
    if len(numbers) != 2 or any(isinstance(n, bool) or not isinstance(n, int | float) for n in numbers):
        return None
    x, y = map(float, numbers)
    return (x, y) if math.isfinite(x) and math.isfinite(y) else None


def _edge(link: _Link, places: Mapping[str, Point]) -> Edge:
    """An edge between places that are there; ValueError with what is wrong."""
    names = [str(name) for name in (link.source, link.target)]
    for name in names:
        if name not in places:
            raise ValueError(f"leads to {show_value(name)}, which is no node; an id of the nodes is needed")
    source, target = names
    if source == target:
        raise ValueError(f"leads from {source!r} to itself; remove it")
    inner = [_point(at) for at in link.line[1:-1]] if isinstance(link.line, list) else []
    if None in inner:
        raise ValueError("its line has a point that is no pair of numbers")
    drawn = [places[source], *(at for at in inner if at is not None), places[target]]
    line_m = tuple(at for k, at in enumerate(drawn) if k == 0 or at != drawn[k - 1])
    if len(line_m) < 2:
        raise ValueError(f"{source!r} and {target!r} are at one place; a way has a length")
    return Edge(source, target, line_m, link.one_way, _number(link.told, LENGTHS), _number(link.told, TIMES))


def _number(told: Mapping[str, Any], names: tuple[str, ...]) -> float | None:
    """The first of these that an edge has; ValueError where it is no number above 0."""
    for name in names:
        value = told.get(name)
        if value is None:
            continue
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < math.inf:
            raise ValueError(f"{name} = {show_value(value)} is not allowed; it must be a number greater than 0")
        return float(value)
    return None


def _both_ways(edges: list[Edge]) -> tuple[Edge, ...]:
    """The edges, of two that are the same there and back one; those that stand twice once."""
    kept = dict[tuple[Any, ...], Edge]()
    for edge in edges:
        back = (edge.line_m[::-1], edge.costs)
        if back in kept:
            kept[back] = kept[back]._replace(one_way=False)
        else:
            same = kept.setdefault((edge.line_m, edge.costs), edge)
            kept[edge.line_m, edge.costs] = same._replace(one_way=same.one_way and edge.one_way)
    return tuple(kept.values())


def _graph_of_patrolling_sim(path: Path, text: str) -> Graph:
    """Numbers of vertices, width, height, resolution and offsets; of each vertex id, x, y, and its edges.

    An edge has the neighbour's id, a direction and a cost in pixels, typed by hand; a longer line counts instead.
    """
    words = iter(text.split())
    try:
        count, _, height = int(next(words)), float(next(words)), float(next(words))
        resolution, x0, y0 = float(next(words)), float(next(words)), float(next(words))
        nodes, links = list[_Node](), list[_Link]()
        for k in range(count):
            name, x, y = next(words), float(next(words)), float(next(words))
            at = [x0 + resolution * x, y0 + resolution * (height - y)]
            nodes.append(_Node(f"vertex {k}", name, at, {}))
            for _ in range(int(next(words))):
                other, _, cost = next(words), next(words), float(next(words))
                if (other, name) not in {(link.source, link.target) for link in links}:
                    told = {"length_m": cost * resolution}
                    links.append(_Link(f"vertex {k}", name, other, None, False, told))
    except (StopIteration, ValueError):
        raise MissionError(f"{path}: ends early, or has text where a number stands; {NEEDED}") from None
    graph = _graph_of(path, iter(nodes), iter(links))
    drawn = [edge.length_m is not None and edge.length_m < math.dist(*edge.line_m) for edge in graph.edges]
    edges = (edge._replace(length_m=None) if short else edge for edge, short in zip(graph.edges, drawn, strict=True))
    return graph._replace(edges=tuple(edges))
