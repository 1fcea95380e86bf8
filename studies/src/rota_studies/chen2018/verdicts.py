"""Verdicts on the paper's claims, those that need more than a line."""

from __future__ import annotations

from rota_studies.chen2018 import maps, paper
from rota_studies.chen2018.runs import EXACT, SAMPLED, Outcome
from rota_studies.verdict import Verdict, mostly


def convergence_verdicts(by_start: dict[tuple[str, str], list[Outcome]], printed: str) -> tuple[Verdict, Verdict]:
    """Section 5.1: RD converges, by the exact centroid, and by random velocities as printed.

    by_start: runs by start and reading. printed: from where the paper's steps are among ours, in words.
    """
    exact, sampled = (
        mostly([run.at_rest for start in maps.STARTS for run in by_start[start, reading.name]])
        for reading in (EXACT, SAMPLED)
    )
    return (
        Verdict(
            f"RD converges (k = {paper.STEPS_FIGURE_12})", "5.1, Figure 12", exact.outcome,
            f"By the exact centroid at rest in {exact.told}, from three starts; {paper.STEPS_FIGURE_12} is {printed}.",
        ),
        Verdict(
            f"RD converges by Algorithm 1, with {paper.SAMPLES:,} random velocities and the stop rule of Table 2",
            "4.4.1, 5.1", sampled.outcome,
            f"At rest in the steps allowed in {sampled.told}; the noise of the mean keeps robots moving.",
        ),
    )  # fmt: skip
