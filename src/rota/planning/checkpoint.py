"""A run of a swarm as it stood when it was stopped: all that it takes to go on as if it never had been."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from rota.errors import CheckpointError
from rota.model.arrays import Floats, Ints
from rota.model.mission import Mission


@dataclass(frozen=True, kw_only=True, eq=False)
class Checkpoint:
    """A mission, a seed, and where n robots stand after so many ``steps``; the last ``steps_at_rest`` of them at rest.

    names (n,): numbers in the fleet, in the order in which robots are computed, which rounding depends on; so are
    places_m and velocities_m_s (n, 2), or (n, 3) with altitudes, as all places here. thinned_m: by how much
    trajectories may err. Trajectories so far: kept_steps and kept_robots (k,) with kept_places_m (k, 2), and recent_m
    (r, n, 2), the places since, which are not thinned yet. The last of these come in the order of the fleet, and so
    does past (h, 4, n): what messages may still tell, places and velocities. news_m (k,): how far it is to
    free ground from the places of the map that "settle" uses; none of other controllers, and before the first step.
    Places of a mission far from the origin are those near it, see ``near_origin``.
    """

    mission: Mission
    seed: int
    steps: int
    steps_at_rest: int
    thinned_m: float
    names: Ints
    places_m: Floats
    velocities_m_s: Floats
    kept_steps: Ints
    kept_robots: Ints
    kept_places_m: Floats
    recent_m: Floats
    past: Floats
    news_m: Floats

    def __post_init__(self) -> None:
        n, axes = len(self.mission.fleet.robots or ()), 2 if self.mission.planning.altitudes_m is None else 3
        shapes = {"names": (n,), "places_m": (n, axes), "velocities_m_s": (n, axes)}
        shapes |= {"recent_m": (len(self.recent_m), n, axes), "kept_robots": self.kept_steps.shape}
        shapes["past"] = (len(self.past), 4, n)
        shapes["news_m"] = (self.news_m.size,)
        shapes["kept_places_m"] = (len(self.kept_robots), axes)
        for name, shape in shapes.items():
            if getattr(self, name).shape != shape:
                raise CheckpointError(f"{name}: has the shape {getattr(self, name).shape}; {shape} is needed")
        for field in fields(self):
            values = getattr(self, field.name)
            if isinstance(values, float | np.ndarray) and not np.isfinite(values).all():
                raise CheckpointError(f"{field.name}: holds a value that is not finite")
        if not np.array_equal(np.sort(self.names), np.arange(n)):
            raise CheckpointError(f"names: every number from 0 to {n - 1} is needed once")
        _require_steps(self, n)

    @property
    def recent_from(self) -> int:
        """The step of the first of the recent places."""
        return self.steps - len(self.recent_m) + 1

    def require_same(self, mission: Mission, seed: int) -> None:
        """Raise CheckpointError, naming what differs, unless this is a run of a mission with this seed.

        The most steps of a run may differ, so that one which they have ended goes on; fewer than it has made may not.
        """
        settings, name = self.mission.planning, self.mission.planning.planner
        differ = [
            field.name
            for field in fields(Mission)
            if field.name != "planning" and getattr(self.mission, field.name) != getattr(mission, field.name)
        ]
        if type(settings) is not type(mission.planning):
            differ.append("planner")
        else:
            names = [item.name for item in fields(settings) if item.name != "most_steps"]
            changed = [item for item in names if getattr(settings, item) != getattr(mission.planning, item)]
            differ += [f"{name}.{item}" for item in changed]
        if differ:
            verb = "differs" if len(differ) == 1 else "differ"
            raise CheckpointError(
                f"the run is of another mission: {', '.join(differ)} {verb}; only {name}.most_steps may be changed"
            )
        if seed != self.seed:
            raise CheckpointError(f"seed: {seed} is not allowed; the run has the seed {self.seed}")
        most = mission.planning.most_steps
        if most is not None and most < self.steps:
            raise CheckpointError(
                f"{name}.most_steps: {most} is not allowed; the run has made {self.steps} steps already"
            )


def _require_steps(state: Checkpoint, robots: int) -> None:
    """Raise CheckpointError for counts and places that no run comes to."""
    ok = state.steps >= 0 and state.steps_at_rest >= 0 and len(state.recent_m) >= 1 and state.recent_from >= 0
    if not ok:
        raise CheckpointError(f"steps: {state.steps} with {len(state.recent_m)} recent places is not possible")
    if state.thinned_m < 0:
        raise CheckpointError(f"thinned_m: {state.thinned_m} is not allowed; must be 0 or more")
    ends = ((state.kept_robots, robots - 1), (state.kept_steps, state.recent_from))
    for values, last in ends:
        if len(values) and (values.min() < 0 or values.max() > last):
            raise CheckpointError(f"kept places: numbers from 0 to {last} are needed")
