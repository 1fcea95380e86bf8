"""What the command line shows while it works."""

from __future__ import annotations

import io
from dataclasses import replace

from benchmarks.small_plans import equal_patrolling, patrolling
from rich.console import Console
from rich.progress import Progress

from rota.check import check_plan
from rota.command.terminal import Bar, TimeLeft


def shown_of(*plans_met: bool, given: bool = False) -> list[str]:
    """What a bar on a terminal tells of plans in turn that the check passes or not."""
    out = io.StringIO()
    plan = patrolling() if given else equal_patrolling()
    report = check_plan(plan)
    with Progress(console=Console(file=out, width=80, force_terminal=False), transient=True) as progress:
        for met in plans_met:
            Bar(progress).show_better(plan, replace(report, verdict="met" if met else "violated"))
    return out.getvalue().split()


def test_a_better_plan_is_shown_with_its_seconds_and_robots() -> None:
    seconds, s, robots, word, *_ = shown_of(False, True)
    assert 0 <= float(seconds) < 60
    assert (s, robots, word) == ("s", "3", "robots")


def test_a_plan_that_fails_and_one_for_a_given_team_are_not_shown() -> None:
    assert "robots" not in shown_of(False)
    assert "robots" not in shown_of(True, given=True)


def test_the_bar_never_falls_back_and_tells_the_time_left() -> None:
    out, now = io.StringIO(), [0.0]
    with Progress(
        TimeLeft(), console=Console(file=out, width=80), get_time=lambda: now[0], auto_refresh=False
    ) as progress:
        bar = Bar(progress, lambda: now[0])
        for now[0], share in ((10.0, 0.25), (20.0, 0.5), (21.0, 0.3)):
            bar.show(share, "planning")
        assert progress.tasks[0].completed == 0.5
        progress.refresh()
    assert "about 20 s left" in out.getvalue()
