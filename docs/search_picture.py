"""Draw the stages of a real search: ``python -m docs.search_picture`` writes docs/search.png and prints its figures.

The stages are those of the search for five robots in examples/harbour.yaml at effort quick, whose outcome is the plan
that ``rota plan`` writes. The figures are those of docs/algorithm.md: what the search does for each team size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from rota.check import check_plan
from rota.draw.house_style import house_style
from rota.draw.mission_picture import draw_mission
from rota.draw.palette import OVER_PERIOD, route_style
from rota.files.mission_file import read_mission
from rota.model.mission import Mission
from rota.planners.patrol.annealing.schedule import anneal_all
from rota.planners.patrol.annealing.search import Annealed
from rota.planners.patrol.context import Context, begin_search
from rota.planners.patrol.ground.extra_points import no_points, prepare_with
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.initial.allocation import Allocation, PeriodGrouping, allocations, period_groupings
from rota.planners.patrol.methods.anneal_and_repair import anneal_and_repair
from rota.planners.patrol.methods.fewest.team_size_plan import anneal_in_full, screen
from rota.planners.patrol.methods.fewest.team_sizes import coverage_weight_for, smallest_with_slack
from rota.planners.patrol.repair.repair import Repaired, annealing_of
from rota.planners.patrol.tours.tour import Tour, nests, over_budget_share

MISSION = Path(__file__).parents[1] / "examples" / "harbour.yaml"
PICTURE = Path(__file__).with_name("search.png")
ROBOTS = 5


class Stage(NamedTuple):
    """The tours at one moment of the search, and the samples (n, 2) that no tour sees."""

    title: str
    tours: Sequence[Tour]
    unseen_m: Any


class Trial(NamedTuple):
    """One team size: its allocations, the tours that the screening leaves, and the full annealings that go on."""

    robots: int
    candidates: list[Allocation]
    begun: list[list[Tour]]
    searches: list[Annealed]

    def __str__(self) -> str:
        slack = [allocation.slack for allocation in self.candidates]
        nested = [allocation.slack for allocation in self.candidates if allocation.nested]
        ended = [f"{each.unseen_share:.1%} unseen after {each.moves_made:,} moves" for each in self.searches]
        return (
            f"{self.robots} robots: {len(slack)} allocations, {len(nested)} with nested loops, slack factors"
            f" {min(slack):.2f} to {max(slack):.2f}; {len(self.begun)} left by the screening;"
            f" annealed in full: {', '.join(ended)}"
        )


def begun_search(mission: Mission) -> tuple[Context, list[PeriodGrouping]]:
    """The search of the method, before it tries its first team size."""
    context = begin_search(
        set_up_problem(mission), asked=mission, seed=0, judge=check_plan, progress=lambda share, doing: None,
        should_stop=lambda: False,
    )  # fmt: skip
    settings = context.settings
    groupings = period_groupings(context.problem, settings.allocation.groupings)
    return replace(context, coverage_weight=coverage_weight_for(groupings, settings.team_size)), groupings


def trial(context: Context, groupings: list[PeriodGrouping], robots: int, *, least_slack: float) -> Trial:
    """What the search does for a team size before the repair."""
    seed = context.seed + 1000 * robots
    candidates = allocations(
        context.problem, groupings, robots, context.settings.allocation, least_slack=least_slack
    )  # fmt: skip
    begun = screen(context, candidates, seed=seed)
    return Trial(robots, candidates, begun, anneal_in_full(context, begun, seed=seed))


def stages(context: Context, tried: Trial) -> list[Stage]:
    """Of the search that passes first: the tours at first, after a little annealing, after all of it, and repaired."""
    seed = context.seed + 1000 * tried.robots
    candidates, searches = tried.candidates, tried.searches
    k, plan = next(
        (k, plan)
        for k, search in enumerate(searches)
        for plan in [repaired(context, search, seed + 100 * k)]
        if plan is not None
    )
    shape = shape_of(searches[k].tours)
    tours = next(allocation.tours for allocation in candidates if shape_of(allocation.tours) == shape)
    moves = context.settings.screening.moves
    (little,) = anneal_all(context, [tours], moves=moves, seed=seed, coarse=False)
    return [
        seen_by(context, f"1. First tours, one allocation of {len(candidates)}", tours),
        seen_by(context, f"2. After the {little.moves_made:,} moves of the screening", little.tours),
        seen_by(context, f"3. After {searches[k].moves_made:,} moves more", searches[k].tours),
        Stage(f"4. Bent and repaired: the check says {plan.verdict.verdict}", plan.tours, []),
    ]


def repaired(context: Context, search: Annealed, seed: int) -> Repaired | None:
    """What comes of a search after cooler annealing and repair; None when the check does not pass it."""
    *_, last = [None, *anneal_and_repair(context, search, seed=seed)]
    return last


def shape_of(tours: Sequence[Tour]) -> list[tuple[int, int, int]]:
    """What annealing does not change of tours."""
    return [(tour.period_class, tour.robots, tour.nest) for tour in tours]


def seen_by(context: Context, title: str, tours: Sequence[Tour]) -> Stage:
    """A stage of the search, with its figures in the title."""
    _, samples = prepare_with(context.problem, no_points())
    state = annealing_of(context, list(tours), samples, length_weight=1.0, seed=0)
    unseen = state.unseen_samples
    told = f"{title}\n{state.unseen_share:.2%} unseen, over budget by {over_budget_share(tours):.1%}"
    return Stage(told, tours, [samples.x[unseen], samples.y[unseen]])


def draw(found: Sequence[Stage], mission: Mission) -> Figure:
    """Four maps, a colour for each robot or group of robots; unseen samples as dots."""
    figure = Figure(figsize=(10.5, 8.4), layout="constrained")
    for ax, stage in zip(figure.subplots(2, 2).flat, found, strict=True):
        draw_mission(mission, ax)
        if len(stage.unseen_m):
            ax.plot(*stage.unseen_m, ".", color=OVER_PERIOD, markersize=1.5, zorder=3)
        for robot, alike in enumerate(nests(stage.tours)):
            colour, _ = route_style(robot)
            for k in alike:
                ring = stage.tours[k].vertices_m
                ax.fill(ring[:, 0], ring[:, 1], fill=False, edgecolor=colour, linewidth=1.0, zorder=4)
        ax.set_title(stage.title, fontsize=9, loc="left")
    return figure


def main() -> None:
    """Draw and print."""
    mission = read_mission(MISSION).mission.with_effort("quick")
    context, groupings = begun_search(mission)
    print("Lower bound:", context.bound.robots, "robots:", context.bound.reason)
    likely = smallest_with_slack(groupings, context.settings.team_size.likely_slack)
    for robots in range(likely, context.bound.robots - 1, -1):
        # going up no allocation with enough budgets is left out, going down those of little slack are
        least_slack = 1.0 if robots == likely else context.settings.allocation.least_slack
        tried = trial(context, groupings, robots, least_slack=least_slack)
        print(tried, flush=True)
        if robots == ROBOTS:
            found = stages(context, tried)
            with house_style():
                draw(found, mission).savefig(PICTURE, dpi=110)
            print(*[stage.title for stage in found], sep="\n", flush=True)


if __name__ == "__main__":
    main()
