"""The study as one Markdown page: what it is, what the paper leaves open, and a section for each figure."""

from __future__ import annotations

from collections.abc import Sequence

from rota_studies.chen2018 import paper
from rota_studies.page import claims, listed, made_from
from rota_studies.section import Section
from rota_studies.tables import joined

HEADING = "# Chen et al. 2018, figure by figure"

CONTROLLERS = (
    "*RD*: the paper's controller, `reciprocal`, by the reading that works best: the tangent, the exact centroid of "
    "the set instead of 1,000 random velocities, and no last filter, so that its own claim can be judged.",
    "*RD, sampled*: the same by 1,000 random velocities (Algorithm 1), as printed. *RD, circle*: the set of Eq. 2 ends "
    "at the circle of t = τ. *RD + filter*: RD with Rota's last filter, by which no step can make bodies touch.",
    "*V-based*: `voronoi`, range-limited Voronoi cells (Lloyd's step, over-relaxed). *VFA*: `virtual_force`, "
    "overlapping discs push each other. Both with the last filter: without it VFA leaves the area from a corner.",
    "*settle*: Rota's default: up the gradient of the covered area, and on to ground that few discs cover; with the "
    "last filter.",
    "*at rest*: no robot moves by more than 0.00001 m in a step (settle: in two).",
)

LEFT_OPEN = (
    "**Values.** Coverage rates, deadweight losses and speeds by number of robots are shown in Figures 19 and 20 and "
    "printed nowhere: where the page has “not printed”, the paper's statement stands beside ours.",
    "**Places.** Neither the start box nor any obstacle has coordinates. We ran boxes in the *centre*, in a *corner*, "
    "and *between* them (50 m to 100 m along both sides); pictures show the last, from which both the 574 steps of "
    "Figure 12 and the 1,248 of Figure 14 are among ours.",
    "**The set.** Eq. 2 is a union over t of discs that all touch the origin, hence a half-plane in which τ drops out: "
    "the tangent. Figures 2 and 3 also show the circle of t = τ. Responsibilities are applied with both signs of u.",
    "**The centre of the set.** Algorithm 1 draws its random velocity once, before the loop; it must be drawn anew "
    "each time. Its mean is noisy, and with the stop rule of Table 2 few of our runs by it come to rest.",
    "**Sets without area.** Algorithm 1 takes a set without area, a line that a robot could glide along, for empty, "
    "since no random velocity hits it. The exact centroid is a point of that line: RD moves where *RD, sampled* "
    "stands.",
    "**Deadweight loss** is not defined; ours is 1 − area covered / sum of the areas of the discs.",
    "**The baselines** are told by reference only; ours are made as well as we could. The gain of VFA is chosen by a "
    "sweep (Figure 18).",
    "**Figures 1 to 8 and 10** are drawings that explain; they have no result. Figure 22 is a screenshot; in its place "
    "stands what we recorded of sixteen processes.",
    "**Table 3.** Which cases it has is not told. RD's average is printed as 14.807 ms, its three cases make 14.801.",
    "**One run.** The paper shows single runs; ours are as many seeds as the tables say, with mean ± standard "
    "deviation.",
)


def page_markdown(sections: Sequence[Section], *, seed: int) -> str:
    """The page; its pictures are beside it. seed: with which it was made."""
    figures = [str(section.figure) for section in sections if not section.extra]
    made = f"{'Figure' if len(figures) == 1 else 'Figures'} {joined(figures)}" if figures else "Claims"
    parts = [
        HEADING,
        f"{made} of {paper.CITATION}, made again by `rota study chen2018` with seed {seed}: 25 robots (and 1,000) that "
        "know only their neighbours spread from a box over an area and hold. Each figure has what the paper says "
        "beside what its controller, the two methods that it compares with and Rota's own do here. Runs have seeds one "
        "after another; numbers with ± are means and standard deviations over them. Only the times of decisions (Table "
        "3 and the last section) and the processes of Figure 22, which run in real time, differ from machine to "
        "machine, and from hour to hour.",
        made_from("chen2018"),
        *claims(sections),
        "## The controllers",
        listed(CONTROLLERS),
        "## What the paper leaves open, and how we read it",
        listed(LEFT_OPEN),
        *(section.markdown for section in sections),
    ]
    return "\n\n".join(parts) + "\n"
