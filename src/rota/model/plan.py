"""What is answered: one timed trajectory per robot, for ever."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from rota.errors import PlanError
from rota.model.arrays import Floats as Floats
from rota.model.fields import field_of, fields_of
from rota.model.limits import FAR_FROM_AREA_M
from rota.model.mission import Mission
from rota.model.refusals import refusal
from rota.model.seam import Driven as Driven, Seam as Seam
from rota.model.trajectory import Charge as Charge, Trajectory as Trajectory, Waypoints as Waypoints, parts_in

if TYPE_CHECKING:
    import pandas

EndReason = Literal["rest", "blocked", "most_steps", "stopped"]


NAMED = 5  # blocked robots


def _require_near(trajectory: Trajectory, bounds_m: Floats, flying: bool) -> None:
    """Raise PlanError for positions too far from the area for the check, or with heights that nothing is said of."""
    places = trajectory.positions_m
    if places.shape[1] == 3 and not flying:
        raise PlanError(
            f"robot {trajectory.robot}: positions_m[0] has 3 numbers; 2 are needed, since only robots of a swarm"
            " have heights"
        )
    low, high = bounds_m[:2] - FAR_FROM_AREA_M, bounds_m[2:] + FAR_FROM_AREA_M
    far = ((places[:, :2] < low) | (places[:, :2] > high)).any(axis=1)
    far |= (np.abs(places[:, 2:]) > FAR_FROM_AREA_M).any(axis=1)
    if far.any():
        k = int(np.flatnonzero(far)[0])
        raise PlanError(
            f"robot {trajectory.robot}: positions_m[{k}] = {places[k].tolist()}; at most {FAR_FROM_AREA_M:g} m away"
            " from the area are allowed"
        )


@dataclass(frozen=True, kw_only=True)
class RunEnd:
    """How a swarm's run ended that a plan was made from: after so many ``steps``, and whether all robots were at rest.

    ``reason``: "rest", the stop rule held and nothing was to come any more; "blocked", it held as well, but the robots
    named in ``blocked`` want to move on and cannot; "most_steps", the mission allows no more; "stopped", by Ctrl-C or a
    time limit. Raises PlanError for steps below 0 and a reason that says something else of rest or of who is blocked.
    """

    at_rest: bool = field_of()
    steps: int = field_of(least=0)
    reason: EndReason = field_of()
    blocked: tuple[str, ...] = field_of(
        (), "robots that want to move on and cannot", count=((0, None), (1, None)), newer=True, spared=True
    )

    def __post_init__(self) -> None:
        if self.reason not in get_args(EndReason) or self.at_rest != (self.reason == "rest"):
            allowed = "rest for robots at rest, else blocked, most_steps or stopped"
            raise PlanError(f"reason: {self.reason!r} with at_rest {self.at_rest}; {allowed}")
        if bool(self.blocked) != (self.reason == "blocked"):
            raise PlanError(
                f"blocked: {len(self.blocked)} robots with the reason {self.reason!r}; robots for blocked only"
            )
        if self.steps < 0:
            raise PlanError(f"steps: {self.steps} is not allowed; must be 0 or more")

    @property
    def goes_on(self) -> bool:
        """Whether more steps would change anything."""
        return self.reason in ("most_steps", "stopped")

    def text(self) -> str:
        """The end in words, which go on after "the run was" or the like."""
        steps = f"after {self.steps:,} step" + ("s" if self.steps != 1 else "")
        if self.at_rest:
            return f"at rest {steps}"
        if self.blocked:
            first = ", ".join(self.blocked[:NAMED]) + (", ..." if len(self.blocked) > NAMED else "")
            who = f"{len(self.blocked)} robots want" if len(self.blocked) > 1 else "1 robot wants"
            return f"blocked {steps}: {who} to move on and cannot ({first})"
        why = "by swarm.most_steps" if self.reason == "most_steps" else "when it was stopped"
        return f"cut off {steps} {why}, before all robots were at rest"


@dataclass(frozen=True, kw_only=True, repr=False)
class Plan:
    """A mission and its answer: ``len(plan)`` robots, ``plan["robot-1"]``, and each trajectory in turn.

    ``lower_bound_robots``: no plan with fewer robots exists, proved; None: not known.

    ``lower_bound_cost``: of a fleet of kinds, no cheaper one can do what is asked, proved; None: not known.

    ``lower_bound_reason``: why, in words that go on after "... robots at least:"; None: not told. ``run_end``: how the
    run of a swarm ended; None: not told, and for other planners. ``seam``: where the plan takes over from another one,
    and what was driven before; None: it does not.

    Raises PlanError for two trajectories of one robot, for positions more than 1e6 m away from the mission's area and
    for heights of robots that are no swarm's: swarms with ``altitudes_m`` have them, and records of flights over hills.
    """

    seed: int = field_of(0)
    lower_bound_robots: int | None = field_of(None, least=0)
    lower_bound_reason: str | None = field_of(
        None, "why no plan has fewer robots; absent: not told", count=((1, None),), newer=True, spared=True
    )
    lower_bound_cost: float | None = field_of(
        None,
        "of a fleet of kinds: no cheaper one can do what is asked; absent: not told",
        least=0,
        newer=True,
        spared=True,
    )
    run_end: RunEnd | None = field_of(
        None, "of a swarm: whether its robots were at rest; absent: not told", newer=True, spared=True
    )
    seam: Seam | None = field_of(
        None, "where it takes over from another plan; absent: it does not", newer=True, spared=True
    )
    mission: Mission = field_of()
    trajectories: tuple[Trajectory, ...] = field_of(key="robots", count=((0, None),))

    def __post_init__(self) -> None:
        self._require_types()
        counted = Counter(trajectory.robot for trajectory in self.trajectories)
        for name, count in counted.items():
            if count > 1:
                raise PlanError(f"robot {name} has more than one trajectory")
            self.mission.fleet.robot(name)
        planning = self.mission.planning
        if self.run_end is not None and not planning.makes_runs:
            raise PlanError(f"run_end: only swarms have runs; the planner is {planning.planner}")
        for name in () if self.run_end is None else self.run_end.blocked:
            self.mission.fleet.robot(name)
        if self.seam is not None and (back := set(self.seam.lost) & set(counted)):
            raise PlanError(f"seam: robot {min(back)} is lost, and has a trajectory all the same")
        bounds_m = np.array(self.mission.area.bounds)
        for trajectory in self.trajectories:
            _require_near(trajectory, bounds_m, planning.makes_runs)
        known = [charger.name for charger in self.mission.chargers]
        ways: list[Trajectory | Driven] = [*self.trajectories, *(() if self.seam is None else self.seam.driven)]
        for way in ways:
            for k, charge in enumerate(way.charges):
                if charge.charger not in known:
                    raise PlanError(
                        f"robot {way.robot}: charges[{k}].charger: {charge.charger!r} is not allowed; the"
                        f" mission has {', '.join(map(repr, known)) or 'no chargers'}"
                    )

    def _require_types(self) -> None:
        """Raise PlanError for what is of another type than its field is declared with."""
        parts_in((self.mission,), Mission, "mission")
        object.__setattr__(self, "trajectories", parts_in(self.trajectories, Trajectory, "trajectories"))
        parts_in(() if self.seam is None else (self.seam,), Seam, "seam")
        parts_in(() if self.run_end is None else (self.run_end,), RunEnd, "run_end")
        for item in fields_of(Plan):
            if item.name in ("seed", "lower_bound_robots", "lower_bound_reason", "lower_bound_cost"):
                for _, part, fault in item.faults(getattr(self, item.name)):
                    raise PlanError(f"{item.name}: {refusal(fault.kind, part, fault.given)}")

    @property
    def heeds_motion(self) -> bool:
        """Whether any robot speeds up and brakes along its legs."""
        return any(trajectory.accelerations_m_s2 is not None for trajectory in self.trajectories)

    def __iter__(self) -> Iterator[Trajectory]:
        return iter(self.trajectories)

    def without_bound(self) -> Plan:
        """The plan, which claims nothing of what others cannot do."""
        return replace(self, lower_bound_robots=None, lower_bound_cost=None, lower_bound_reason=None)

    def __len__(self) -> int:
        return len(self.trajectories)

    def __bool__(self) -> bool:
        return True  # a plan without robots is a plan

    def __contains__(self, robot: object) -> bool:
        """Whether a robot of this name has a trajectory here, or whether this trajectory is one of the plan's."""
        return any(each.robot == robot or each == robot for each in self)

    def __getitem__(self, robot: str) -> Trajectory:
        """The trajectory of the robot of this name; KeyError names those that there are."""
        for trajectory in self.trajectories:
            if trajectory.robot == robot:
                return trajectory
        raise KeyError(f"{robot!r}; the plan has {', '.join(repr(each.robot) for each in self) or 'no robots'}")

    def __repr__(self) -> str:
        bound = "" if self.lower_bound_robots is None else f", {self.lower_bound_robots} at least"
        robots = f"{len(self)} robot{'' if len(self) == 1 else 's'}"
        return f"<Plan of {self.mission.name!r}: {robots}{bound}, seed {self.seed}>"

    def _repr_html_(self) -> str:
        from rota.model.html import plan_html

        return plan_html(self)

    def to_dataframe(self) -> pandas.DataFrame:
        """All timed points as a pandas table; ImportError where pandas is not installed.

        Columns: robot, time_s, x_m, y_m, z_m (nan in the plane), in_loop, and heading_rad (nan: along the way).
        """
        import pandas

        parts = []
        for one in self.trajectories:
            count, dimensions = one.positions_m.shape
            parts.append(
                pandas.DataFrame(
                    {
                        "robot": one.robot,
                        "time_s": one.times_s,
                        "x_m": one.positions_m[:, 0],
                        "y_m": one.positions_m[:, 1],
                        "z_m": one.positions_m[:, 2] if dimensions == 3 else np.full(count, np.nan),
                        "in_loop": one.times_s >= one.loop_start_s,
                        "heading_rad": np.full(count, np.nan) if one.headings_rad is None else one.headings_rad,
                    }
                )
            )
        return pandas.concat(parts, ignore_index=True) if parts else pandas.DataFrame()
