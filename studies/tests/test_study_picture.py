"""Panels of maps and curves: what stands where, and that nothing leaves the picture."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image
from shapely import box

from rota.draw.house_style import house_style
from rota.draw.palette import OBSTACLE, ZONE_TINTS
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone
from rota.model.plan import Plan
from rota_studies.panels.curve_panel import Curve, CurvePanel, Level
from rota_studies.panels.map_panel import Dots, MapPanel, Strokes
from rota_studies.panels.study_picture import study_figure, study_picture

BLUE, GREEN = "#0072B2", "#009E73"


@pytest.fixture
def mission() -> Mission:
    return Mission(
        name="yard", area=box(0, 0, 100, 80), obstacles=(Obstacle(shape=box(40, 30, 60, 50)),), period_s=60,
        zones=(Zone(name="gate", shape=box(70, 50, 95, 75), period_s=8),),
        fleet=Fleet(speed_m_s=10, sensor=DiscSensor(radius_m=6)),
    )  # fmt: skip


@pytest.fixture
def sensors(mission: Mission) -> MapPanel:
    dots = Dots("gate: 2", np.array([(75.0, 60.0), (90.0, 60.0)]), BLUE, reach_m=12)
    path = Strokes("frame", (np.array([(10.0, 10.0), (90.0, 10.0), (90.0, 60.0)]),), "#222222")
    return MapPanel(title="Sensors", note="2 sensors", mission=mission, dots=(dots,), strokes=(path,))


@pytest.fixture
def costs() -> CurvePanel:
    curves = (Curve("with", np.array([9.0, 4.0, 1.0]), BLUE), Curve("without", np.array([9.0, 8.0, 7.0]), GREEN))
    return CurvePanel(
        title="Cost", curves=curves, across="iterations", up="cost", levels=(Level("bound", 0.5, "#000000"),)
    )


def test_sensors_lie_in_the_middle_of_what_they_see(sensors: MapPanel) -> None:
    ax = study_figure([sensors]).axes[0]
    (discs,) = [one for one in ax.collections if hasattr(one, "get_heights") or "Ellipse" in type(one).__name__]
    assert discs.get_offsets() == pytest.approx(sensors.dots[0].places_m)
    assert discs._widths * 2 == pytest.approx([24, 24])  # matplotlib keeps half of each
    (marks,) = [line for line in ax.lines if line.get_marker() == "o"]
    assert np.column_stack(marks.get_data()) == pytest.approx(sensors.dots[0].places_m)


def test_curves_hold_the_values(costs: CurvePanel) -> None:
    ax = study_figure([costs]).axes[0]
    values = [line.get_ydata().tolist() for line in ax.lines if len(line.get_ydata()) == 3]
    assert values == [[9, 4, 1], [9, 8, 7]]
    assert [line.get_ydata() for line in ax.lines][-1] == [0.5, 0.5]
    assert ax.get_xlim() == (0, 2)


def test_curves_at_places_of_their_own_with_a_band() -> None:
    at, band = np.array([10.0, 100.0, 1000.0]), np.array([[1.0, 2, 3], [5, 6, 7]])
    curve = Curve("errors", np.array([3.0, 4.0, 5.0]), BLUE, at=at, band=band)
    panel = CurvePanel(title="Errors", curves=(curve,), across="samples", up="m", logarithmic_across=True)
    ax = study_figure([panel]).axes[0]
    assert ax.get_xscale() == "log"
    assert ax.lines[0].get_xdata().tolist() == [10, 100, 1000]
    assert ax.lines[0].get_marker() == "."
    corners = ax.collections[0].get_paths()[0].vertices
    assert {(10, 1), (10, 5), (1000, 3), (1000, 7)} <= {tuple(corner) for corner in corners.tolist()}


def test_discs_are_as_dark_as_they_are_told(sensors: MapPanel) -> None:
    dark = MapPanel(title="Dark", mission=sensors.mission, dots=(sensors.dots[0]._replace(shade=0.4),))
    (discs,) = [one for one in study_figure([dark]).axes[0].collections if "Ellipse" in type(one).__name__]
    assert discs.get_facecolor()[0, 3] == pytest.approx(0.4)


def test_legends_tell_what_is_drawn(sensors: MapPanel, costs: CurvePanel) -> None:
    labels = [[text.get_text() for text in legend.get_texts()] for legend in study_figure([sensors, costs]).legends]
    assert labels == [["frame", "gate: 2", "seen, 12 m", "obstacle"], ["with", "without", "bound"]]
    listed = MapPanel(title="Zones", mission=sensors.mission, listed_zones=True)
    assert [text.get_text() for text in study_figure([listed]).legends[0].get_texts()] == ["gate, 8 s", "obstacle"]


def test_one_curve_needs_no_legend(costs: CurvePanel) -> None:
    alone = CurvePanel(title="Cost", curves=costs.curves[:1], across="iterations", up="cost")
    assert study_figure([alone]).legends == []


def test_nothing_leaves_the_picture_or_lies_on_something_else(sensors: MapPanel, costs: CurvePanel, yard: Plan) -> None:
    routes = MapPanel(title="Routes", note="5 robots", mission=yard.mission, plan=yard, listed_zones=True)
    wide = CurvePanel(title="Wide", curves=costs.curves, across="iterations", up="cost", logarithmic=True, wide=True)
    with house_style():
        fig = study_figure([sensors, costs, routes, sensors, wide])
        fig.canvas.draw()
    whole = fig.get_window_extent()
    boxes = [ax.get_tightbbox() for ax in fig.axes] + [legend.get_window_extent() for legend in fig.legends]
    boxes += [text.get_window_extent() for text in fig.texts if text.get_text()]
    for one in boxes:
        assert whole.x0 <= one.x0
        assert one.x1 <= whole.x1
        assert whole.y0 <= one.y0
        assert one.y1 <= whole.y1
    for k, one in enumerate(boxes):
        for other in boxes[k + 1 :]:
            wide_px = min(one.x1, other.x1) - max(one.x0, other.x0)
            high_px = min(one.y1, other.y1) - max(one.y0, other.y0)
            assert wide_px <= 0.5 or high_px <= 0.5, (one, other)


def test_the_same_panels_give_the_same_picture(sensors: MapPanel, costs: CurvePanel) -> None:
    drawn = study_picture([sensors, costs])
    assert drawn == study_picture([sensors, costs])
    with Image.open(io.BytesIO(drawn)) as picture:
        picture.load()
        assert picture.format == "PNG"
        assert picture.width == 805  # fits a page's column at 100 %
        colours = {colour for _, colour in picture.convert("RGB").getcolors(256) or []}
    for named in ("#FFFFFF", BLUE, GREEN, OBSTACLE, ZONE_TINTS[1]):  # small marks keep their colours
        assert tuple(bytes.fromhex(named[1:])) in colours, named
