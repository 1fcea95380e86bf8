"""Measures of a run against exact areas, brute force and closed forms."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.distance import pdist
from shapely import MultiPolygon, Polygon, box
from tests.planners.swarm.conftest import in_box
from tests.planners.swarm.test_last_filter import wishing

from rota.files.mission_file import read_mission
from rota.geometry.free_space import free_ground
from rota.planners.swarm.metrics import Observer, covered_share
from rota.planners.swarm.planner import run_mission
from rota.planners.swarm.planner_settings import SwarmSettings

SQUARE = MultiPolygon([box(0, 0, 250, 250)])


def test_the_exact_share_of_two_discs_is_their_closed_form() -> None:
    # two discs of 25 m, 30 m apart: the lens is 2 r^2 acos(d / 2r) - d / 2 sqrt(4 r^2 - d^2)
    lens = 2 * 25**2 * math.acos(30 / 50) - 15 * math.sqrt(4 * 25**2 - 30**2)
    share = covered_share(np.array([[100, 100], [130, 100.0]]), np.array([25.0, 25.0]), SQUARE)
    assert share * 250**2 == pytest.approx(2 * math.pi * 25**2 - lens, rel=1e-5)
    assert covered_share(np.array([[0.0, 125]]), np.array([25.0]), SQUARE) == pytest.approx(
        math.pi * 25**2 / 2 / 250**2, rel=1e-5
    )


def test_pixels_count_what_shapely_measures() -> None:
    rng = np.random.default_rng(13)
    region = MultiPolygon([Polygon([(0, 0), (250, 0), (200, 250), (0, 250)], [[(80, 80), (120, 80), (100, 130)]])])
    for _ in range(5):
        places, sensors = rng.uniform(0, 250, (30, 2)), rng.uniform(15, 30, 30)
        observer = Observer(in_box(places, sensor_m=sensors, body_m=0), region, 1e-5)
        history = observer.history()
        exact = covered_share(places, sensors, region)
        assert history.coverage[0] == pytest.approx(exact, abs=2e-3)
        loss = 1 - exact * region.area / (math.pi * (sensors**2).sum())
        assert history.deadweight_loss[0] == pytest.approx(loss, abs=5e-3)


def test_gaps_ways_and_reversals_of_robots_on_a_line() -> None:
    wish = np.array([[2.0, 0], [-1.0, 0]])
    swarm = in_box([[10, 100], [40, 100]], decide=wishing(wish))
    observer = Observer(swarm, SQUARE, 1e-5)
    for step in range(4):
        wish[1] *= -1  # the second one goes to and fro
        swarm.step()
        observer.note(2e-6 * (step + 1))
    history = observer.history()
    # the wall counts where the robots may heed it; gaps are between rims of bodies of 0.5 m
    assert history.wall_gap_m[:2] == pytest.approx([9.5, 10.0])
    assert history.body_gap_m == pytest.approx([29, 28.75, 28, 27.75, 27])
    assert history.way_m == pytest.approx(np.arange(5) * 0.25 * 1.5)
    assert history.reversals == pytest.approx([0, 0, 0.5, 0.5, 0.5])
    assert history.decision_s == pytest.approx([0, 1e-6, 2e-6, 3e-6, 4e-6])
    assert history.steps == 4


def test_who_leaves_the_region_is_counted() -> None:
    wish = np.array([[-2.0, 0], [0.0, 0]])
    swarm = in_box([[0.9, 125], [125, 125]], decide=wishing(wish), safe=False)
    observer = Observer(swarm, SQUARE, 1e-5)
    for step in range(60):
        if step == 30:
            wish[0] = 0.0
        swarm.step()
        observer.note(0.0)
    history = observer.history()
    # half a metre a step: 0.9, 0.4, -0.1
    assert history.outside[:4].tolist() == [0, 0, 1, 1]
    assert history.outside[-1] == 1


def test_the_small_case_of_the_paper_converges_as_measured() -> None:
    """Our readings, from the centre: 75.5 % in 289 steps on average of ten seeds; two of them here."""
    mission = read_mission(Path(__file__).parents[3] / "examples" / "swarm-square.yaml").mission
    mission = replace(mission, planning=SwarmSettings(controller="reciprocal"))
    for seed in (1, 2):
        run = run_mission(mission, seed=seed, observed=True)
        history = run.history
        assert history is not None
        assert run.at_rest
        assert history.steps == run.steps < 450
        ends = np.array([trajectory.positions_m[-1] for trajectory in run.plan])
        exact = covered_share(ends, np.full(25, 25.0), free_ground(mission))
        assert history.coverage[-1] == pytest.approx(exact, abs=2e-3)
        assert 0.73 < exact < 0.775
        assert history.coverage[-1] > history.coverage[0] + 0.4
        assert history.body_gap_m[-1] == pytest.approx(pdist(ends).min() - 2 * 0.55, abs=1e-9)
        assert history.body_gap_m.min() >= 0
