"""What the compiled loops of a swarm are given: plain arrays, joined as named tuples."""

from __future__ import annotations

from typing import NamedTuple

from rota.model.arrays import Floats, Ints

NEVER = 2**62  # a step that no run comes to


class Robots(NamedTuple):
    """State of n robots, (n,) each: place and velocity, the row of ``Kinds`` and the number in the fleet.

    Those of a kind from ``member_kinds`` on are bodies only: nobody's neighbours.
    """

    x: Floats
    y: Floats
    vx: Floats
    vy: Floats
    kind: Ints
    name: Ints
    member_kinds: int


class Kinds(NamedTuple):
    """What robots are like, one row for each kind: (k,) each, metres and metres per second."""

    body_m: Floats
    sensor_m: Floats
    speed_m_s: Floats
    neighbour_range_m: Floats
    wall_range_m: Floats


class FleetKinds(NamedTuple):
    """What a fleet of n robots is like: its kinds, and the row of ``kinds`` that each robot has, (n,)."""

    kinds: Kinds
    kind: Ints


class PlaceGraph(NamedTuple):
    """Places on the map (k,), in the order of the cells of a lattice, and links between them; see ``place_graph``.

    Place k has the links link_start[k] up to link_start[k + 1], each to the place link_to and link_m long. Cell (i, j)
    of the lattice has the places cell_start[c] up to cell_start[c + 1], c = j * columns + i. away_m (2, k): how far it
    is to free ground, as told at even and at odd steps, far_m where none is; no way is longer than way_m. load (k,):
    the area of discs round each place, weighted by a cone, in units of one disc; capacity (k,): the area of ground by
    the same measure. After news_steps steps the news of a place have come to all that links lead to. Where ground
    differs in importance, worth (k,) is that of the ground about each place, else empty; then load is the share of it
    that nobody covers, and ``offer_kernels`` tells of away_m, reach_m, most and dear_m.
    """

    x: Floats
    y: Floats
    link_start: Ints
    link_to: Ints
    link_m: Floats
    x0: float
    y0: float
    cell_m: float
    columns: int
    rows: int
    cell_start: Ints
    load: Floats
    capacity: Floats
    away_m: Floats
    far_m: float
    news_steps: int
    way_m: float
    worth: Floats
    reach_m: float
    most: float
    dear_m: float


class ImportanceField(NamedTuple):
    """Importance of the square cells of a ground, (rows, columns), per square metre; (0, 0) where all is worth as much.

    (x0, y0): the lower left corner; side_m: of a cell. sums, moments (rows, columns + 1): of each row from its left end
    up to a cell's left side, the integral of importance along x, and that of importance times x - x0.
    """

    values: Floats
    sums: Floats
    moments: Floats
    x0: float
    y0: float
    side_m: float


class Grid(NamedTuple):
    """Square cells over the area with a rim of empty ones; made by ``world.make_world``.

    Cell (i, j), 0 <= i < columns, has the number c = (j + 1) * (columns + 2) + i + 1; its robots are start[c] up to
    start[c + 1] of the sorted state and the walls near it are walls[wall_item[wall_start[c] : wall_start[c + 1]]],
    each a segment x0, y0, x1, y1.
    """

    x0: float
    y0: float
    cell_m: float
    columns: int
    rows: int
    start: Ints
    wall_start: Ints
    wall_item: Ints
    walls: Floats
    place_graph: PlaceGraph
    importance: ImportanceField


class Moving(NamedTuple):
    """Discs that move and do not give way, (m,) each: place and velocity at the moment of the step, and radius."""

    x: Floats
    y: Floats
    vx: Floats
    vy: Floats
    radius_m: Floats


class Rule(NamedTuple):
    """How velocities are chosen; what is of no use to a controller it does not read.

    ``samples`` 0: the exact centroid; ``circle``: the set ends at the circle of ``horizon_s``, not at its tangent;
    ``late``: robots know others from messages only. ``last_change``: the step from which on nobody joins or leaves and
    no disc moves any more.
    """

    neighbours: int
    circle: bool
    horizon_s: float
    alpha: float
    samples: int
    seed: int
    time_step_s: float
    late: bool = False
    last_change: int = NEVER


class Hearing(NamedTuple):
    """What robots learn of each other: places ``delay_steps`` old, and a share of the messages is lost."""

    delay_steps: int
    lost: float


class Snapshot(NamedTuple):
    """All that robots decide from in one step; the same for all of them."""

    step: int
    robots: Robots
    kinds: Kinds
    grid: Grid
    moving: Moving
    rule: Rule


class Guide(NamedTuple):
    """Where a swarm sends robots that do not decide for themselves; see ``guide_kernels.steer``."""

    targets_m: Floats
    may_enter: Ints
    pads_m: Floats
    keep_m: float


class Decisions(NamedTuple):
    """What a step decides, in the order of the grid: (n,) velocities in m/s, and squared distances in square metres.

    nearest2: to the nearest robot in the cells round about (inf: none), so that the last filter can pass most robots.
    """

    vx: Floats
    vy: Floats
    nearest2: Floats


class Near(NamedTuple):
    """Room of one thread for a robot's neighbours: (most,) their places in the state and squared distances.

    The nearest comes first.
    """

    robot: Ints
    distance2: Floats


class Outline(NamedTuple):
    """Room for the corners of a polygon, counter-clockwise: (MOST_CORNERS,) each."""

    x: Floats
    y: Floats


class Room(NamedTuple):
    """What one thread writes to while it decides for a robot."""

    near: Near
    outline: Outline
    spare: Outline
