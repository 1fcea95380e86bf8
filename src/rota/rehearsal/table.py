"""A rehearsal as plain text, for people."""

from __future__ import annotations

import math
from collections.abc import Callable

from rota.model.columns import columns
from rota.rehearsal.estimates import Estimate
from rota.rehearsal.outcome import DemandOutcome, Rehearsal
from rota.rehearsal.stages import TAKES_OVER_S

TOLD = 5  # demands whose worst gap is told with its place, the latest first
ROUNDING, ALMOST_ALL = 1e-12, 0.9995  # of a share; from the second on it would be rounded to 100.0 %
HEAD = ("demand", "period s", "places", "available %", "worst late s", "runs on time %")


def rehearsal_table(made: Rehearsal) -> str:
    """The rehearsal as plain text: the conditions, the share of what is asked, one row per demand, what was worst."""
    lines = [f"{_runs_text(made)}: {conditions_text(made)}"]
    lines.append(f"available: {percent_text(made.available)} % of all that is asked, in area and time")
    if made.conditions.failures_per_hour:
        lines.append(f"robots that fail: {number_text(made.failed, 2)} in a run")
    if made.takeovers is not None:
        lines.append(
            f"plans that take over, {TAKES_OVER_S:g} s after a failure: {number_text(made.takeovers, 2)} in a run"
        )
    if made.refusal is not None:
        lines.append(f"where none takes over, robots go on by the one before; the first is {made.refusal}")
    if made.runs > 1:
        lines.append("in brackets: 95 % confidence intervals")
    rows = [HEAD, *(_row(each) for each in made.demands)]
    lines += ["", columns(rows)]
    lines += _contact_lines(made) + _charging_lines(made)
    late = sorted((each for each in made.demands if each.late_s.mean > 0), key=lambda each: -each.late_s.mean)
    lines += [_worst_text(each) for each in late[:TOLD]]
    return "\n".join(lines)


def _contact_lines(made: Rehearsal) -> list[str]:
    """What is told of bodies that touch."""
    contacts = made.contacts
    if contacts is None:
        return ["contacts: no two ways come so near each other that bodies can touch"]
    driving, standing = percent_text(contacts.driving), percent_text(contacts.standing)
    told = f"contacts: bodies of robots that drive touch in {driving} % of the runs"
    if made.conditions.failures_per_hour:
        told += f", with one that has failed in {standing} %"
    return [told, *([f"first: {contacts.first}"] if contacts.first else [])]


def _charging_lines(made: Rehearsal) -> list[str]:
    """What is told of batteries, of reliefs and of chargers."""
    charging = made.charging
    if charging is None:
        return []
    lines = []
    if charging.spare_s is not None:
        least = number_text(charging.spare_s, 1)
        below = percent_text(charging.below)
        lines.append(
            f"batteries: {least} s beyond the reserve at the least; one falls below it in {below} % of the runs"
        )
    low = sorted((each for each in charging.robots if each.below.mean > 0), key=lambda each: each.worst_s)
    for each in low[:TOLD]:
        lines.append(
            f"{each.robot}: below its reserve of {each.reserve_s:g} s in {percent_text(each.below)} % of the runs;"
            f" {number_text(each.least_s, 1)} s left at the least, {each.worst_s:.1f} s in run {each.worst_run} after"
            f" {each.worst_at_s:.1f} s"
        )
    if len(low) > TOLD:
        lines.append(f"{len(low) - TOLD} more robots fall below their reserve")
    if made.conditions.late_relief_s:
        lines.append(f"reliefs: {number_text(charging.reliefs, 0)} in a run")
    if charging.first_hurry is not None:
        hurried = percent_text(charging.hurried)
        lines.append(f"robots whose batteries do not let them wait, in {hurried} % of the runs: {charging.first_hurry}")
    if charging.first_crowd is not None:
        lines.append(f"chargers too full, in {percent_text(charging.crowded)} % of the runs: {charging.first_crowd}")
    return lines


def conditions_text(made: Rehearsal) -> str:
    """What may go wrong, and who waits for whom, in words."""
    asked, told = made.conditions, []
    if asked.failures_per_hour:
        told.append(f"each robot fails {asked.failures_per_hour:g} times an hour")
    if asked.speed_noise:
        told.append(f"speeds vary by {100 * asked.speed_noise:g} %")
    if asked.wind_m_s:
        where = "anywhere" if asked.wind_from_deg is None else f"{asked.wind_from_deg:g} degrees"
        told.append(f"wind of {asked.wind_m_s:g} m/s from {where}")
    if asked.late_relief_s:
        told.append(f"reliefs are late by {asked.late_relief_s:g} s in the mean")
    if asked.replan:
        told.append("those that remain are replanned")
    kept = "nobody keeps them in phase" if asked.hands_off else _waiting_text(made)
    return ", ".join([*told, kept] if told else ["all goes by plan"])


def _waiting_text(made: Rehearsal) -> str:
    """Who waits for whom."""
    if made.relieve_nobody == made.robots:
        return "nobody waits for who is late: no robot relieves another"
    some = {0: "", 1: " but for 1 robot that relieves nobody"}
    return "all wait for who is late" + some.get(
        made.relieve_nobody, f" but for {made.relieve_nobody} robots that relieve nobody"
    )


def percent_text(share: Estimate) -> str:
    """A share in percent with its interval; what is not all of it does not look like all."""
    rounds_up = any(value is not None and ALMOST_ALL <= value < 1 - ROUNDING for value in share)
    digits = 3 if rounds_up else 1

    def percent(value: float) -> str:
        told = math.floor(1e5 * (value + ROUNDING)) / 1e3 if rounds_up else 100 * value
        return f"{told:.{digits}f}"

    return _with_interval(share, percent)


def number_text(value: Estimate, digits: int) -> str:
    """A mean with its interval, where there is one that is not a single number."""
    return _with_interval(value, lambda each: f"{each:.{digits}f}")


def _with_interval(value: Estimate, text: Callable[[float], str]) -> str:
    if value.low is None or value.high is None or value.low == value.high:
        return text(value.mean)
    return f"{text(value.mean)} ({text(value.low)} to {text(value.high)})"


def _runs_text(made: Rehearsal) -> str:
    runs = "1 run" if made.runs == 1 else f"{made.runs} runs"
    robots = "1 robot" if made.robots == 1 else f"{made.robots} robots"
    return f"{runs} of {made.conditions.hours:g} h, {robots}, seed {made.seed}"


def _row(each: DemandOutcome) -> tuple[str, ...]:
    return (
        each.name,
        f"{each.period_s:g}",
        f"{each.places}",
        percent_text(each.available),
        number_text(each.late_s, 1 if each.late_s.mean < 100 else 0),
        percent_text(each.on_time),
    )


def _worst_text(each: DemandOutcome) -> str:
    x, y = each.worst_place_m
    return f"worst of {each.name}: unseen for {each.worst_gap_s:.1f} s at ({x:.2f}, {y:.2f}) in run {each.worst_run}"
