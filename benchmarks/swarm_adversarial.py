"""Swarms in tight boxes from which no controller would have come there: are bodies, walls and speeds ever at fault?

Dense states: bodies of different sizes at random angles with random velocities. Lattices: bodies that touch exactly, in
squares, triangles, rows along a wall and into a corner, at any angle, and two such lattices side by side. All gaps are
measured at every moment of a step: between two bodies, which move on straight lines, in closed form.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.row import Options, Row
from rota.planners.swarm.deciding import Controller
from rota.planners.swarm.planner import ALL_NEIGHBOURS, DECIDE
from rota.planners.swarm.rollout import Surroundings, Swarm
from rota.planners.swarm.sorted_robots import Beginning
from rota.planners.swarm.state import Hearing, Rule
from rota.planners.swarm.world import kinds_of

Floats = NDArray[np.float64]

STATES, ROBOTS, STEPS = 10_000, 8, 20
ROWS, COLUMNS = 3, 4  # of a lattice
GAPS_M = (0.0, 1e-9, 1e-3, 0.1)  # between a body and the one it was put beside
ROOMS_M = (0.0, 1e-6, 0.3, 2.0)  # between the bodies and the walls
TRIES = 60
SPEED_M_S, TIME_STEP_S = 2.0, 0.25
LATE_AND_LOSSY = Hearing(delay_steps=1, lost=0.1)
ROUNDING_M = 1e-9
FASTEST = 1 + 1e-12  # of the speed allowed, with what rounding leaves


class States(NamedTuple):
    """Small swarms: places (states, robots, 2), bodies (states, robots), boxes (states, 4) x0, y0, x1, y1, metres."""

    places_m: Floats
    bodies_m: Floats
    boxes_m: Floats


class Worst(NamedTuple):
    """Over all moments of a run: the least gaps between bodies and from bodies to walls, metres, below 0 for overlap.

    fastest: the greatest speed, as a share of the one allowed. way_m: how far a robot has gone on average.
    """

    between_m: float
    beside_m: float
    fastest: float
    way_m: float

    @property
    def faultless(self) -> bool:
        """Whether all that stays what it may be, by rounding."""
        return min(self.between_m, self.beside_m) >= -ROUNDING_M and self.fastest <= FASTEST


def swarm_adversarial(options: Options) -> Iterator[Row]:
    """Every controller with the last filter; all know all, and messages a step old of which a tenth is lost."""
    dense = dense_states(STATES, ROBOTS, np.random.default_rng(0))
    lattices = lattice_states(STATES, np.random.default_rng(0))
    many = {f"dense states of {ROBOTS}": dense, f"lattices of {ROWS * COLUMNS}": lattices}
    for (told_states, states), controller in itertools.product(many.items(), DECIDE):
        for hearing, told in ((None, ""), (LATE_AND_LOSSY, ", a step late and 10 % lost")):
            worst = worst_of(states, controller, STEPS, hearing)
            name = f"swarm, {STATES:,} {told_states}, {controller}{told}: between bodies, and walls, at any moment"
            measured = (
                f"{worst.between_m:.2g} and {worst.beside_m:.2g} m in {STEPS} steps; at most {worst.fastest:.6g} x"
                f" the speed; {worst.way_m:.2g} m gone on average"
            )
            yield Row(name, f"never below -{ROUNDING_M:.0e} m, nor too fast", measured, worst.faultless)


def dense_states(states: int, robots: int, rng: np.random.Generator) -> States:
    """Bodies of different sizes, each touching or nearly touching an earlier one, in a box that fits tightly."""
    bodies = rng.uniform(0.2, 1.0, (states, robots))
    places = np.zeros((states, robots, 2))
    for k in range(1, robots):
        waiting = np.arange(states)
        for _ in range(TRIES):
            beside = rng.integers(0, k, len(waiting))
            angle = rng.uniform(0, 2 * np.pi, len(waiting))
            away = bodies[waiting, beside] + bodies[waiting, k] + rng.choice(GAPS_M, len(waiting))
            place = places[waiting, beside] + away[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
            gaps = np.hypot(*np.moveaxis(place[:, None] - places[waiting, :k], 2, 0)) - bodies[waiting, :k]
            fits = (gaps - bodies[waiting, k][:, None]).min(axis=1) >= 0
            places[waiting[fits], k] = place[fits]
            waiting = waiting[~fits]
        # who found no place stands to the right of all
        right = (places[waiting, :k, 0] + bodies[waiting, :k]).max(axis=1)
        places[waiting, k, 0] = right + bodies[waiting, k]
    slack = rng.choice(ROOMS_M, (states, 4))
    low = (places - bodies[..., None]).min(axis=1) - slack[:, :2]
    high = (places + bodies[..., None]).max(axis=1) + slack[:, 2:]
    return States(places, bodies, np.hstack([low, high]))


def lattice_states(states: int, rng: np.random.Generator) -> States:
    """Equal bodies that touch exactly, in ``LATTICES`` by turns, each in a box that fits tightly."""
    made = [LATTICES[k % len(LATTICES)](rng) for k in range(states)]
    radius = rng.choice([0.5, 0.25, 0.3], (states, 1))
    places = np.array(made) * 2 * radius[..., None]
    bodies = np.repeat(radius, places.shape[1], axis=1)
    slack = rng.choice(ROOMS_M, (states, 4))
    low = (places - bodies[..., None]).min(axis=1) - slack[:, :2]
    high = (places + bodies[..., None]).max(axis=1) + slack[:, 2:]
    return States(places, bodies, np.hstack([low, high]))


def lattice(rng: np.random.Generator, rows: int = ROWS, columns: int = COLUMNS) -> Floats:
    """Places 1 apart (rows x columns, 2), in squares or triangles."""
    j, i = (values.ravel() for values in np.mgrid[:rows, :columns])
    if rng.random() < 0.5:
        return np.stack([i, j], axis=1).astype(float)
    return np.stack([i + 0.5 * (j % 2), np.sqrt(0.75) * j], axis=1)


def turned(places: Floats, rng: np.random.Generator) -> Floats:
    """The same at any angle."""
    angle = rng.uniform(0, 2 * np.pi)
    return places @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


def row_on_a_wall(rng: np.random.Generator) -> Floats:
    """A row along one wall; at times along two, into the corner between them."""
    count = ROWS * COLUMNS
    bend = count if rng.random() < 0.5 else int(rng.integers(1, count))
    along = np.arange(count, dtype=float)
    places = np.stack([np.minimum(along, bend), np.maximum(along - bend, 0)], axis=1)
    return places[:, ::-1] if rng.random() < 0.5 else places


def two_lattices(rng: np.random.Generator) -> Floats:
    """Two lattices, each at its own angle, moved together until two of their bodies touch."""
    left, right = (turned(lattice(rng, ROWS, COLUMNS // 2), rng) for _ in range(2))
    dx, dy = np.moveaxis(left[:, None] - right[None], 2, 0)
    meets = np.abs(dy) < 1
    away = np.max(dx[meets] + np.sqrt(1 - dy[meets] ** 2))
    return np.vstack([left, right + np.array([away, 0.0])])


LATTICES: tuple[Callable[[np.random.Generator], Floats], ...] = (
    lattice,
    row_on_a_wall,
    lambda rng: turned(lattice(rng), rng),
    two_lattices,
)


def swarm_of(states: States, controller: str, hearing: Hearing | None, seed: int, threads: int = 1) -> Swarm:
    """All states in one swarm, side by side and each between walls of its own, with random velocities."""
    count, robots = states.bodies_m.shape
    offsets = offsets_m(states)[:, None]
    fleet = kinds_of(
        count * robots,
        body_m=states.bodies_m.ravel(),
        sensor_m=5.0,
        speed_m_s=SPEED_M_S,
        neighbour_range_m=10.0,
        wall_range_m=5.0,
    )
    corners = states.boxes_m[:, [[0, 1], [2, 1], [2, 3], [0, 3], [0, 1]]] + offsets
    walls = np.concatenate([corners[:, :-1], corners[:, 1:]], axis=2).reshape(-1, 4)
    neighbours = 4 if controller == "reciprocal" else ALL_NEIGHBOURS
    velocities_m_s = np.random.default_rng(seed).uniform(-SPEED_M_S, SPEED_M_S, (count * robots, 2))
    rule = Rule(neighbours, False, 1.0, 1.0, 0, seed, TIME_STEP_S)
    return Swarm(
        Beginning((states.places_m + offsets).reshape(-1, 2), velocities_m_s),
        fleet,
        Surroundings(np.ascontiguousarray(walls)),
        Controller(DECIDE[controller], rule, hearing=hearing),
        threads=threads,
    )


def offsets_m(states: States) -> Floats:
    """Where each state's own origin lies, (states, 2): in rows, out of each other's sensor range."""
    spacing = 12.0 + float((states.boxes_m[:, 2:] - states.boxes_m[:, :2]).max())
    k = np.arange(len(states.bodies_m))
    row = int(np.ceil(np.sqrt(len(k))))
    return spacing * np.stack([k % row, k // row], axis=1)


def worst_of(states: States, controller: str, steps: int, hearing: Hearing | None) -> Worst:
    """The worst at any moment of so many steps."""
    swarm = swarm_of(states, controller, hearing, seed=1)
    bodies, count = states.bodies_m, states.bodies_m.shape[1]
    before, offsets = swarm.places_m, np.repeat(offsets_m(states), count, axis=0)
    between, beside, fastest, way = np.inf, np.inf, 0.0, 0.0
    a, b = np.array(list(itertools.combinations(range(count), 2))).T
    for _ in range(steps):
        swarm.step()
        places = swarm.places_m
        begin, end = (values.reshape(*bodies.shape, 2) for values in (before, places))
        nearest = closest(begin[:, a] - begin[:, b], end[:, a] - end[:, b])
        between = min(between, float((nearest - bodies[:, a] - bodies[:, b]).min()))
        # a box is convex: who is in it at both ends of a step is in it all the time
        at = (places - offsets).reshape(*bodies.shape, 2)
        low, high = at - states.boxes_m[:, None, :2], states.boxes_m[:, None, 2:] - at
        beside = min(beside, float((np.minimum(low, high).min(axis=2) - bodies).min()))
        fastest = max(fastest, float(np.hypot(*swarm.velocities_m_s.T).max()) / SPEED_M_S)
        way += float(np.hypot(*(places - before).T).mean())
        before = places
    return Worst(between, beside, fastest, way)


def closest(begin: Floats, end: Floats) -> Floats:
    """Least distance to the origin of points that move straight from begin to end, (..., 2) each."""
    move = end - begin
    square = np.maximum((move**2).sum(axis=-1), 1e-300)
    t = np.clip(-(begin * move).sum(axis=-1) / square, 0, 1)
    return np.asarray(np.hypot(*np.moveaxis(begin + t[..., None] * move, -1, 0)))
