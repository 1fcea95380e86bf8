"""Verdicts on the paper's claims, those that need more than a line."""

from __future__ import annotations

from typing import Literal

from rota.papers.chen2018 import maps, paper
from rota.papers.chen2018.runs import EXACT, SAMPLED, Outcome
from rota.papers.section import Verdict


def holds_if(ok: bool) -> Literal["holds", "does not hold"]:
    """The outcome of a claim that is either."""
    return "holds" if ok else "does not hold"


def convergence_verdicts(by_start: dict[tuple[str, str], list[Outcome]], printed: str) -> tuple[Verdict, Verdict]:
    """Section 5.1: RD converges, by the exact centroid, and by random velocities as printed.

    by_start: runs by start and reading. printed: from where the paper's steps are among ours, in words.
    """
    told = {}
    for reading in (EXACT, SAMPLED):
        outcomes = [run for start in maps.STARTS for run in by_start[start, reading.name]]
        told[reading.name] = (sum(run.at_rest for run in outcomes), len(outcomes))
    (exact, tried), (sampled, _) = told[EXACT.name], told[SAMPLED.name]
    return (
        Verdict(
            f"RD converges (k = {paper.STEPS_FIGURE_12})", "5.1, Figure 12", holds_if(exact == tried),
            f"By the exact centroid {exact} of {tried} runs from three starts come to rest; {paper.STEPS_FIGURE_12} is "
            f"{printed}.",
        ),
        Verdict(
            f"RD converges by Algorithm 1, with {paper.SAMPLES:,} random velocities and the stop rule of Table 2",
            "4.4.1, 5.1", holds_if(sampled == tried),
            f"{sampled} of {tried} runs come to rest in the steps allowed; the noise of the mean keeps robots moving.",
        ),
    )  # fmt: skip
