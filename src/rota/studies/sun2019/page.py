"""The study as one Markdown page: what it is, what could not be reproduced, and a section for each figure."""

from __future__ import annotations

from collections.abc import Sequence

from rota.studies.section import Section
from rota.studies.sun2019 import paper
from rota.studies.tables import joined

HEADING = "# Sun et al. 2019, figure by figure"

NOT_REPRODUCED = (
    "**Maps.** No coordinates are printed. Ours were drawn after the text, and that of Figure 13 was tuned until its "
    "zones take about as many sensors as the paper's; Figures 8 and 15 are freer still. Numbers compare in size, not "
    "digit by digit.",
    "**Weights.** λ of Eq. 11, ξ and T_m of Eq. 28, the probabilities p and q, and τ of the fusion rule are not "
    "printed. Ours are named settings, so that costs (Figures 6c, 13b, 13f, 16b, 16f) have a scale of their own.",
    f"**A copied number.** {paper.FIGURE_16.tour_length:,.2f} is the length of the tour in Section 5.1 and, on another "
    "map with other sensors, again in Section 5.3.",
    f"**Iterations.** Table 4 prints {paper.TABLE_4_ITERATIONS} iterations; by the text the cost still falls in the "
    f"{paper.FIGURE_13.partition_iteration}th (Figure 13f) and the {paper.FIGURE_16.partition_iteration}nd (16f).",
    "**Order of zones.** The text says T₁ > T₂ > T₃, twice; Tables 1 and 8 have the contrary, which the method needs.",
    "**Table 6.** Path 4 of Case 4 is told as one of sub-region 2, whose period is 10 s, and given 20 s, that of "
    "sub-region 3. The text finds Case 6 in Figure 14e, the fifth of six pictures.",
    "**Section 5.2.** Two robots are said to take about 37.50 s in sub-region 3; Table 5 has 36.37 s and 37.29 s.",
    "**Routes.** How a route is led where an obstacle, the border or its own next lane is in the way is not told, nor "
    "was it checked that the routes see everything.",
)


# figures whose tables have a column for each way of planning
COMPARING = (13, 14, 16)
HOW_TO_READ = (
    "*paper*: as printed there.",
    "*Eq. 26*: the paper's algorithms with its parameters, run here; times by its formula, 2 × segment + 2 π r_s.",
    "*as printed*: the routes round those segments, cut to the free ground and driven as they are.",
    "*mended*: the paper's algorithms once more, by the method `sun2019` told so (`deployment: ccpso2, tour: genetic, "
    "partition: pso, routes: repaired`), which mends routes until the check passes. It takes long: Table 6 goes "
    "without.",
    "*sun2019*: that method as it is by default; *tours*: the default method.",
    "*lower bound*: no plan has fewer robots, proved.",
    "A route belongs to the sub-region whose period it must keep. *7.00 / 2*: a loop of 7.00 s that two robots "
    "share. A loop may also be longer than T^c where it passes the zone several times a round; the worst gap decides.",
)


def page_markdown(sections: Sequence[Section], *, seed: int, effort: str) -> str:
    """The page; its pictures are beside it. seed, effort: with which it was made."""
    figures = joined([str(section.figure) for section in sections])
    comparing = []
    if any(section.figure in COMPARING for section in sections):
        comparing = ["## How to read the tables", "\n".join(f"- {line}" for line in HOW_TO_READ)]
    parts = [
        HEADING,
        f"{'Figure' if len(sections) == 1 else 'Figures'} {figures} of {paper.CITATION}, made again by `rota study "
        f"sun2019` with seed {seed} and effort {effort}. Each has the paper's numbers beside those of two methods: "
        "`sun2019`, the paper's own (sensors are deployed, joined to a frame, and the frame is cut into routes), and "
        "`tours`, the method that Rota plans with by default. The lower bound is a number of robots below which no "
        "plan exists, proved. Every plan of ours was judged by `rota check`, which knows nothing of the planners.",
        "All numbers under **Here** and in columns of ours come from that one run; the paper's are as printed.",
        "## What cannot be reproduced",
        "\n".join(f"- {line}" for line in NOT_REPRODUCED),
        *comparing,
        *(section.markdown for section in sections),
    ]
    return "\n\n".join(parts) + "\n"
