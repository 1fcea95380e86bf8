"""Films of robots that charge: who stands on a charger sees nothing there, and bars are how full batteries are."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_hex
from tests.relieved import relieved

from rota.cells.cell_map import cell_map_of
from rota.draw.film_frames import FilmFrames
from rota.draw.palette import DOCKED, FILLED_WELL, ROUTE_COLOURS
from rota.draw.sightings import Sightings
from rota.routes.flights import on_charger


def test_robots_are_on_chargers_when_the_plan_says_so_in_every_round() -> None:
    plan = relieved(3)
    # they fly from 0 to 180, from 160 to 340 and from 320 to 500 of 480 s
    times_s = np.array([10.0, 170, 190, 330, 350, 479])
    for late_s in (0, 480, 4800):
        docked = [on_charger(trajectory, times_s + late_s).tolist() for trajectory in plan]
        assert docked == [
            [False, False, True, True, True, True],
            [True, False, False, False, True, True],
            [False, True, True, False, False, False],
        ]


def test_who_charges_sees_nothing() -> None:
    plan = relieved(3)
    sightings = Sightings(plan, cell_map_of(plan.mission, 400))
    assert [shape.is_empty for shape in sightings.footprints(250.0)] == [True, False, True]
    sightings.advance(0.0, 481.0)
    assert np.isfinite(sightings.last_seen_s).all()
    alone = Sightings(relieved(2), sightings.cell_map)
    # the first one is on the pad from 180 s on, the second one from 20 s to 160 s
    alone.advance(30.0, 150.0)
    assert alone.last_seen_s.max() == 150
    assert [shape.is_empty for shape in alone.footprints(100.0)] == [False, True]


def test_marks_are_grey_beside_the_charger_and_coloured_where_they_fly() -> None:
    plan = relieved(3)
    film: Any = FilmFrames(plan, 100.0)
    film._move(250.0, np.zeros(film._sightings.last_seen_s.shape))
    assert [to_hex(colour) for colour in film._marks.get_facecolor()] == [
        DOCKED.lower(), ROUTE_COLOURS[0].lower(), DOCKED.lower(),
    ]  # fmt: skip
    places_m = film._marks.get_offsets()
    np.testing.assert_allclose(places_m[1], plan.trajectories[1].at(250.0))
    apart_m = np.hypot(*(places_m[0] - places_m[2]))
    assert apart_m * film._charging._scale > 0, "each has a spot of its own"
    assert np.hypot(*places_m[0]) < 12


def test_bars_are_as_long_as_batteries_are_full() -> None:
    film: Any = FilmFrames(relieved(3), 100.0)
    film._move(100.0, np.zeros(film._sightings.last_seen_s.shape))
    bars, empty = film._charging._bars.get_segments(), film._charging._empty.get_segments()
    shares = [np.ptp(bar[:, 0]) / np.ptp(all_of[:, 0]) for bar, all_of in zip(bars, empty, strict=True)]
    # 100 of 400 s are used; full; 180 s were used until 20 s, and 80 s of charging gave back 160
    assert shares == pytest.approx([0.75, 1.0, 0.95])
    assert {to_hex(colour) for colour in film._charging._bars.get_color()} == {FILLED_WELL.lower()}


def test_frames_have_the_colours_of_the_bars() -> None:
    film = FilmFrames(relieved(2), 100.0)
    (frame,) = film.frames(np.array([50.0]))
    colour = [int(FILLED_WELL[k : k + 2], 16) for k in (1, 3, 5)]
    assert (frame[:, :, :3] == colour).all(axis=2).sum() > 40
    assert (film.key_colours() == colour).all(axis=1).any()
