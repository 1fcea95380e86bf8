"""The plan with which a search begins: lanes over all of the ground, and as many robots as they surely take."""

from __future__ import annotations

import time
from dataclasses import replace

from rota.planners.patrol.context import Context, silent
from rota.planners.patrol.efforts import TIGHT
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.methods.sweeping.methods import sequential_once
from rota.planners.patrol.methods.sweeping.search import Proposal, first_proposals, judge_by_lanes
from rota.planners.patrol.methods.sweeping.wide_turns import sweep_with_wide_turns, turns_widely
from rota.planners.patrol.repair.repair import Repaired, missed_nooks, repair_until_feasible
from rota.planners.patrol.settings import SearchSettings
from rota.planners.patrol.tours.tour import Tour, tour_length_m


def sweep(context: Context, settings: SearchSettings) -> Repaired | None:
    """A plan of lanes, judged, for a search that has no plan yet; None if none passes.

    One route over the ground of each group of periods, shared by robots. Where repairs make it longer than these can
    drive in time, it gets another robot, which passes soon; then it is tried without. Few missions take more than a
    second until the first plan passes. Where the search was stopped already, all may take ten seconds
    of processor time.
    """
    end_s, stopped = time.process_time() + 10.0, context.should_stop()
    context.progress(0.0, "sweeping in lanes")
    hasty = replace(
        context, problem=judge_by_lanes(context.problem), settings=settings, progress=silent,
        should_stop=lambda: time.process_time() > end_s if stopped else context.should_stop(),
    )  # fmt: skip
    if turns_widely(context.problem):
        lanes = sweep_with_wide_turns(hasty, is_crowded)
        if lanes is not None:
            return lanes
    proposals = list(first_proposals(sequential_once(settings.sweeping.angles), hasty))
    proposals = [proposal for proposal in proposals if not any(map(is_crowded, proposal.tours))]
    for proposal in sorted(proposals, key=lambda proposal: proposal.rank)[: settings.sweeping.tries]:
        # what curves miss the check finds turn by turn
        on_arcs = context.problem.robot.turn_radius_m > 0
        rounds = settings.repair.patient_rounds if on_arcs else settings.repair.rounds
        # behind small obstacles next to nothing is hidden, which the check finds sliver by sliver
        extra = missed_nooks(hasty, proposal.tours) if context.problem.lanes_overlap_m > 0 else no_points()
        lanes = repair_until_feasible(hasty, proposal.tours, extra, may_add=True, rounds=rounds)
        if lanes.met:
            return lanes if context.should_stop() else with_robots_of(proposal, hasty, lanes)
        if hasty.should_stop():
            break
    return None


def with_robots_of(proposal: Proposal, context: Context, lanes: Repaired) -> Repaired:
    """The lanes with no robot more than they had before they were repaired, if that passes; else the lanes given."""
    if lanes.robots <= max(proposal.rank[0], context.enough_robots) or context.should_stop():
        return lanes
    tight = replace(context, settings=replace(context.settings, repair=TIGHT))
    fewer = repair_until_feasible(tight, proposal.tours, no_points(), may_add=False, rounds=TIGHT.rounds)
    return fewer if fewer.met else lanes


def is_crowded(tour: Tour) -> bool:
    """Whether robots follow each other so closely that fewer would see as much from where they stand."""
    return tour.robots > 1 and apart_m(tour) < 0.25 * tour.robot.sensor.reach_m  # few that stand could see as much


def apart_m(tour: Tour) -> float:
    """Metres between robots that share a tour."""
    return tour_length_m(tour) / tour.robots
