"""The picture of a plan: what is in it, its size, and that it appears whole or not at all."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.quiver import Quiver
from PIL import Image
from shapely import LineString, box

from rota.draw import draw_plan, draw_routes
from rota.draw.mission_picture import period_text
from rota.draw.palette import ROUTE_COLOURS, route_style
from rota.draw.plan_picture import plan_figure
from rota.draw.route_lines import route_label
from rota.draw.routes import routes_of
from rota.draw.zone_labels import draw_zone_labels
from rota.errors import RotaError
from rota.model.mission import DiscSensor, Fleet, Mission, Zone
from rota.model.plan import Plan, Trajectory
from rota.planning.plan_summary import robot_rows, round_off

MAGIC = {".png": b"\x89PNG\r\n\x1a\n", ".pdf": b"%PDF-", ".svg": b"<?xml"}


def drawn_routes(plan: Plan):
    fig = Figure(figsize=(6, 6))
    FigureCanvasAgg(fig)
    ax = fig.add_subplot()
    draw_routes(plan, ax)
    return ax


@pytest.mark.parametrize(
    ("suffix", "name"),
    [
        pytest.param(".png", "yard", marks=pytest.mark.slow),
        pytest.param(".pdf", "strip", marks=pytest.mark.slow),
        (".svg", "strip"),
    ],
)
def test_same_plan_same_bytes_in_every_format(suffix: str, name: str, tmp_path: Path, request: pytest.FixtureRequest):
    plan = request.getfixturevalue(name)
    one, other = tmp_path / f"one{suffix}", tmp_path / f"other{suffix.upper()}"
    draw_plan(plan, one)
    with matplotlib.rc_context({"font.size": 20, "savefig.bbox": "tight"}):
        draw_plan(plan, str(other))
        assert matplotlib.rcParams["font.size"] == 20
    assert one.read_bytes().startswith(MAGIC[suffix])
    assert one.read_bytes() == other.read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == [one.name, other.name]


def test_size_follows_the_area(yard: Plan, strip: Plan, tmp_path: Path):
    sizes = []
    for plan in (yard, strip):
        draw_plan(plan, tmp_path / "picture.png")
        with Image.open(tmp_path / "picture.png") as picture:
            sizes.append(picture.size)
    inches = [plan_figure(plan, cells=100).get_size_inches() for plan in (yard, strip)]
    assert [tuple(np.floor(size * 160 + 1e-6).astype(int)) for size in inches] == sizes
    assert sizes[0][0] == 1838
    assert inches[1][0] > 2 * inches[1][1], "a strip has its maps one below the other"


def test_equal_aspect_and_both_maps_alike(yard: Plan):
    fig = plan_figure(yard, cells=400)
    routes, gaps = fig.axes[:2]
    assert routes.get_xlim() == gaps.get_xlim()
    for ax in (routes, gaps):
        window = ax.get_window_extent()
        assert window.width / np.ptp(ax.get_xlim()) == pytest.approx(window.height / np.ptp(ax.get_ylim()), rel=1e-6)
    assert [text.get_text() for text in fig.texts] == ["yard", "5 robots · lower bound 2 · outside zones every 60 s"]


def test_one_line_per_loop_and_one_mark_per_robot(yard: Plan):
    ax = drawn_routes(yard)
    labels = [line.get_label() for line in ax.get_lines() if not line.get_label().startswith("_")]
    assert labels == ["robot-1 … robot-3: 230.0 m, 23.0 s", "robot-4: 94.3 m, 11.0 s", "robot-5: stays"]
    marks = [text for text in ax.texts if text.get_text().isdigit()]
    assert [text.get_text() for text in marks] == ["1", "2", "3", "4", "5"]
    assert [text.get_bbox_patch().get_facecolor()[:3] for text in marks] == [
        matplotlib.colors.to_rgb(ROUTE_COLOURS[k]) for k in (0, 0, 0, 1, 2)
    ]
    np.testing.assert_allclose([text.xy for text in marks][3:], [(70, 60), (30, 60)])
    # no arrows for the robot that stays; the way to the loop is a line of its own, dashed, and a mark where it begins
    assert sum(isinstance(child, Quiver) for child in ax.get_children()) == 2
    assert len(ax.get_lines()) == 5
    way, start = (line for line in ax.get_lines() if line.get_label().startswith("_"))
    assert way.is_dashed()
    np.testing.assert_array_equal(start.get_xydata(), way.get_xydata()[:1])
    assert min(text.get_fontsize() for text in ax.texts) >= 7


def test_the_legend_tells_lengths_and_times_as_the_table_does(yard: Plan):
    rows = {row.robot: (round_off(row.loop_length_m), round_off(row.loop_time_s)) for row in robot_rows(yard)}
    for route in routes_of(yard)[:2]:
        label = route_label(yard, route)
        for robot in route.robots:
            length_m, time_s = rows[yard.trajectories[robot].robot]
            assert label.endswith(f": {length_m} m, {time_s} s")


def test_names_without_their_number_get_it(yard: Plan):
    names = ("robot-3", "robot-1", "boat", "robot-4", "b5")
    renamed = tuple(replace(trajectory, robot=name) for trajectory, name in zip(yard, names, strict=True))
    plan = replace(yard, trajectories=renamed)
    labels = [route_label(plan, route).split(":")[0] for route in routes_of(plan)]
    assert labels == ["1–3  robot-3 … boat", "robot-4", "b5"]


@pytest.mark.parametrize(
    ("period_s", "words"),
    [
        (0.5, "0.5 s"), (8, "8 s"), (599, "599 s"), (600, "10 min"), (1000, "1000 s"), (1234.5, "1234.5 s"),
        (5400, "90 min"), (7200, "2 h"), (86_400, "24 h"),
    ],
)  # fmt: skip
def test_a_period_is_told_as_it_was_asked(period_s: float, words: str):
    assert period_text(period_s) == words


def test_zones_are_labelled_with_what_they_ask(yard: Plan):
    ax = drawn_routes(yard)
    words = [text.get_text() for text in ax.texts if not text.get_text().isdigit()]
    assert words == ["gate  8 s", "pond  nothing asked", r"shed \$1  visit 90 s"]
    ax.figure.canvas.draw()
    boxes = [text.get_window_extent() for text in ax.texts if not text.get_text().isdigit()]
    frame = ax.get_window_extent()
    for k, one in enumerate(boxes):
        assert frame.x0 <= one.x0
        assert one.x1 <= frame.x1
        assert not any(one.overlaps(other) for other in boxes[:k])


@pytest.mark.parametrize("side_m", [4.0, 8.0, 60.0])
def test_a_label_does_not_hide_the_small_loop_of_its_zone(yard: Plan, side_m: float):
    ring = [(30, 30), (30 + side_m, 30), (30 + side_m, 30 + side_m), (30, 30 + side_m), (30, 30)]
    there = Trajectory(robot="robot-1", times_s=np.arange(5.0) * side_m, positions_m=ring)
    zone = Zone(name="tank", shape=box(28, 28, 32 + side_m, 32 + side_m), period_s=99)
    mission = replace(yard.mission, zones=(zone,), obstacles=())
    ax = drawn_routes(Plan(mission=mission, trajectories=(there,)))
    ax.figure.canvas.draw()
    label = next(text for text in ax.texts if text.get_text() == "tank  99 s")
    on_map = box(*label.get_bbox_patch().get_window_extent().transformed(ax.transData.inverted()).extents)
    assert on_map.intersection(LineString(ring)).length == 0
    # in its zone where there is room, otherwise right beside it
    assert on_map.within(zone.shape) == (side_m == 60)
    assert on_map.distance(zone.shape) < 2


def test_legend_has_an_entry_per_loop_and_kind_of_obstacle(yard: Plan):
    fig = plan_figure(yard, cells=400)
    words = [text.get_text() for text in fig.legends[0].get_texts()]
    assert words[3:] == ["way from the start", "obstacle", "no entry, seen through", "cuts sight, may be entered"]
    assert len(words) == 7


def test_marks_at_one_place_are_spread(yard: Plan):
    same = tuple(replace(yard.trajectories[4], robot=f"robot-{k}") for k in range(8))
    ax = drawn_routes(replace(yard, trajectories=same))
    offsets = np.array([text.xyann for text in ax.texts if text.get_text().isdigit()])
    apart = np.hypot(*(offsets[:, None] - offsets[None]).transpose(2, 0, 1))
    assert apart[np.triu_indices(8, 1)].min() >= 10.5


def test_first_32_routes_differ_in_colour_or_style():
    assert len({route_style(k) for k in range(32)}) == 32
    assert len({route_style(k)[0] for k in range(8)}) == 8


def test_many_robots_fit_on_the_figure(yard: Plan):
    way = yard.trajectories[3]
    many = tuple(replace(way, robot=f"r{k}", positions_m=way.positions_m + k / 9) for k in range(70))
    fig = plan_figure(replace(yard, trajectories=many), cells=400)
    words = [text.get_text() for text in fig.legends[0].get_texts()]
    assert "… and 10 more loops" in words
    fig.draw_without_rendering()
    legend = fig.legends[0].get_window_extent()
    assert legend.y0 >= 0
    assert legend.x1 <= fig.axes[1].get_window_extent().x0


def test_a_plan_without_robots_or_zones_is_drawn(yard: Plan, tmp_path: Path):
    bare = Mission(name="$" * 80, area=box(0, 0, 9, 9), period_s=40, fleet=yard.mission.fleet)
    draw_plan(Plan(mission=bare, trajectories=()), tmp_path / "bare.svg")
    assert b"</svg>" in (tmp_path / "bare.svg").read_bytes()


@pytest.mark.parametrize("name", ["plan.jpg", "plan", "plan.png.gz"])
def test_another_suffix_is_refused_with_those_allowed(yard: Plan, tmp_path: Path, name: str):
    with pytest.raises(RotaError, match=r"format (for|of) a picture; \.png, \.svg or \.pdf is needed"):
        draw_plan(yard, tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_not_there_is_named(yard: Plan, tmp_path: Path):
    with pytest.raises(RotaError, match=r"nowhere.plan\.png: there is no folder .*; create it first"):
        draw_plan(yard, tmp_path / "nowhere" / "plan.png")


def test_a_failure_half_way_leaves_the_old_file(yard: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    target = tmp_path / "plan.png"
    target.write_text("old")

    def fails(self: Figure, path: Path, **_: object) -> None:
        Path(path).write_text("half")
        raise KeyboardInterrupt

    monkeypatch.setattr(Figure, "savefig", fails)
    with pytest.raises(KeyboardInterrupt):
        draw_plan(yard, target)
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_drawing_chooses_no_backend_and_leaves_pyplot_alone():
    code = "import sys, rota.draw; assert 'matplotlib.pyplot' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(("beyond_m", "leaders"), [(-0.5, 0), (0.6, 1)])
def test_a_zone_s_label_keeps_off_the_routes_where_there_is_room_for_it(beyond_m: float, leaders: int) -> None:
    """A zone that a route fills: its label goes beside it, or on a leader where that ground is full, too."""
    area = box(0, 0, 20, 20)
    zone = Zone(name="desk", shape=box(5, 5, 12, 12), period_s=600, demand="visit")
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=1))
    mission = Mission(name="m", area=area, zones=(zone,), fleet=fleet)
    low, high = 5 - beyond_m, 12 + beyond_m
    lanes = [(x, y) for k, x in enumerate(np.linspace(low, high, 12)) for y in ((low, high) if k % 2 else (high, low))]
    way = np.array([*lanes, lanes[0]])
    times = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(way, axis=0).T))])
    plan = Plan(mission=mission, trajectories=(Trajectory(robot="r", times_s=times, positions_m=way),))
    fig = Figure(figsize=(6, 6))
    FigureCanvasAgg(fig)
    ax = fig.add_subplot()
    ax.set(xlim=(0, 20), ylim=(0, 20), aspect="equal")
    draw_zone_labels(mission, ax, routes_of(plan))
    (label,) = ax.texts
    fig.canvas.draw()
    on_map = box(*label.get_bbox_patch().get_window_extent().transformed(ax.transData.inverted()).extents)
    assert on_map.intersection(LineString(way)).length == 0
    assert on_map.distance(zone.shape) < 2
    assert len(ax.lines) == leaders


def test_a_plan_is_drawn_on_axes_or_as_a_figure(yard: Plan) -> None:
    ax = Figure().add_subplot()
    assert draw_plan(yard, ax=ax) is ax
    assert len(ax.lines) >= len(yard)
    assert isinstance(draw_plan(yard), Figure)
    with pytest.raises(TypeError, match="a path or ax, not both"):
        draw_plan(yard, "plan.png", ax=ax)  # type: ignore[call-overload]
