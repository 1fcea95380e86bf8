"""The door that every planner has: what it is asked, what it answers, and what else the rest of Rota asks of it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from rota.errors import MissionError
from rota.model.planner_registry import door_of, planner_names

if TYPE_CHECKING:
    from rota.check.report import Report as Report
    from rota.compiled.parts import Part
    from rota.model.mission import Mission, Robot
    from rota.model.plan import Plan, Seam, Trajectory
    from rota.model.planner_settings import PlannerSettings
    from rota.planning.checkpoint import Checkpoint
    from rota.planning.progress import Watch
    from rota.planning.robot_processes import ProcessSettings, RobotProcesses


@dataclass(frozen=True, kw_only=True)
class Request:
    """What a planner is asked.

    mission: with settings of this planner. seed: the same seed gives the same answer, on any number of threads.
    judge: the check's report on a plan. progress: to be told a share 0..1 and what is being done. should_stop: to be
    polled often; once True the best answer so far is wanted. watch: to be told of every state on the way, perhaps from
    several threads. checkpoint: of a planner that makes runs, the one to go on from. observe: of such a planner, to be
    given the measures of every step. executor: workers for what can be done side by side, with functions and arguments
    that can be pickled; None: this process alone. The answer is the same.
    """

    mission: Mission
    seed: int
    judge: Callable[[Plan], Report]
    progress: Callable[[float, str], None]
    should_stop: Callable[[], bool]
    watch: Watch | None = None
    checkpoint: Checkpoint | None = None
    observe: Callable[[Any], None] | None = None
    executor: Executor | None = None


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What a planner answers: a plan, and what it knows beside it.

    facts: sentences that only the search could tell. checkpoint: of a run that ended before it came to rest.
    """

    plan: Plan
    facts: tuple[str, ...] = ()
    checkpoint: Checkpoint | None = None


@dataclass(frozen=True, kw_only=True)
class Handover:
    """What a planner is asked where a plan takes over from another one.

    mission: of the robots that remain. places: where they are at that moment. seam: as the plan has it.
    going_on: what robots that remain would drive from then on by the plan before, by their names. loops: whose rounds
    are to be shared among those that remain; the clock of all is 0 at that moment. lateness: how late a plan is; less
    is better. most: ways to share them that are worked out. importance: of what depends on each of the loops, by name,
    where that differs: rounds of what is less important may be left out; empty: all are as important. batteries: how
    full they are, 0 to 1, by name. drivers: the robot that each loop was planned for, by the loop's name.
    """

    mission: Mission
    places: dict[str, tuple[float, float]]
    seam: Seam
    seed: int
    going_on: dict[str, Trajectory]
    loops: tuple[Trajectory, ...]
    lateness: Callable[[Plan], tuple[float, ...]]
    most: int
    importance: Mapping[str, float] = field(default_factory=dict)
    batteries: Mapping[str, float] = field(default_factory=dict)
    drivers: Mapping[str, Robot] = field(default_factory=dict)


class Planner(ABC):
    """A planner as the rest of Rota sees it; each overrides what it has more of.

    ``methods``: the values of its setting ``method`` that can be compared side by side. ``plans_near_origin``: missions
    far from the origin come to it moved there, with the places of all declared fields; it tells places as (x, y).
    """

    methods: tuple[str, ...] = ()
    plans_near_origin: bool = False

    @property
    @abstractmethod
    def settings(self) -> type[PlannerSettings]:
        """The type of its settings, which name it and say what it refuses of a mission."""

    @abstractmethod
    def plan(self, request: Request) -> Answer:
        """A plan for the mission. Raises NoPlanFound, with the best there is, when none meets the demand."""

    def sentences(self, answer: Answer, report: Report) -> Iterator[str | None]:
        """What is said below a new plan, paragraph by paragraph; None in place of what there is nothing to say of."""
        yield from answer.facts

    def takeovers(self, asked: Handover) -> Iterator[Plan]:
        """Plans that take over, made of the rounds that are handed over; the one that changes least comes first.

        They may be late, or their bodies may touch: the check tells. MissionError for robots that cannot take over.
        """
        raise MissionError(
            f"planner: {self.settings.planner} is not allowed; only robots that drive rounds of patrol take over"
        )

    def covering_time(self, plan: Plan) -> str | None:
        """How long robots that only react, whatever the plan says, take to cover their ground; None: they do not."""
        return None

    def proved_bound(self, mission: Mission) -> tuple[int, str] | None:
        """The fewest robots that any plan takes, proved without planning, and the reason; None: nothing is proved.

        The reason goes on after "... robots at least:". Raises NoPlanFound where no robot can stand or see.
        """
        return None

    def hasty_bound(self, mission: Mission) -> tuple[int, str] | None:
        """The same within a moment, for whoever edits a mission: it may prove less."""
        return self.proved_bound(mission)

    def compiled_packages(self, mission: Mission) -> tuple[str, ...]:
        """Folders below the package rota whose ``kernels.py`` planning the mission runs; compiling them takes long."""
        return ()

    def parts_to_compile(self) -> tuple[Part, ...]:
        """What a first plan compiles, in parts that processes share out; none: it takes a moment."""
        return ()

    def small_mission(self) -> Mission | None:
        """A mission planned in a moment that runs compiled loops, so that no time measured holds loading."""
        return None

    def robot_processes(self, mission: Mission, settings: ProcessSettings) -> RobotProcesses:
        """The mission's robots as processes of their own; MissionError for robots that do not decide for themselves."""
        raise MissionError(f"planner: {self.settings.planner} is not allowed; only robots of a swarm decide themselves")

    def omission(self, mission: Mission) -> str | None:
        """What any plan leaves out of what the mission asks, told before planning; None: nothing, or not known."""
        return None

    def long_work(self, mission: Mission) -> Iterator[str]:
        """What makes planning this mission long, each with a rough estimate."""
        yield from ()


def about(seconds: float) -> str:
    """A time as estimates tell it: in seconds, minutes or hours."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} minutes" if seconds < 5400 else f"{seconds / 3600:.1f} hours"


def planner_named(name: str) -> Planner:
    """The planner of this name. Raises MissionError for a name that is not known and for a door that cannot be loaded.

    No compiled loops are loaded before it plans.
    """
    planner = door_of(name)
    if not isinstance(planner, Planner):
        raise MissionError(
            f"planner: {type(planner).__name__} is no planner; a subclass of rota.planning.planner.Planner is needed"
        )
    return planner


def loadable_planners() -> tuple[str, ...]:
    """The names of all planners whose doors can be loaded; one that another distribution breaks is left out."""

    def loads(name: str) -> bool:
        try:
            planner_named(name)
        except MissionError:
            return False
        return True

    return tuple(name for name in planner_names() if loads(name))


def prove_bound(mission: Mission) -> tuple[int, str] | None:
    """The fewest robots that any plan of the mission takes, proved without planning, and why; None: nothing is proved.

    The reason goes on after "... robots at least:". Raises NoPlanFound where no robot can stand or see.
    """
    return planner_of(mission).proved_bound(mission)


def planner_of(mission: Mission) -> Planner:
    """The planner of a mission's settings."""
    return planner_named(mission.planning.planner)
