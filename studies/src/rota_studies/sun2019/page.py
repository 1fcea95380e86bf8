"""The study as one Markdown page: verdicts, what could not be reproduced, what is ours, a section for each figure."""

from __future__ import annotations

from collections.abc import Sequence

from rota_studies.page import claims, listed, made_from
from rota_studies.section import Section
from rota_studies.sun2019 import paper
from rota_studies.sun2019.runs import StudySettings
from rota_studies.sun2019_method.mission_settings import SegmentSettings
from rota_studies.tables import joined

HEADING = "# Sun et al. 2019, figure by figure"

NOT_REPRODUCED = (
    "**Maps.** No coordinates are printed. Ours were drawn after the text, and that of Figure 13 was tuned until set "
    "covers take about as many sensors as the paper's swarms; Figures 8 and 15 are freer still. Numbers compare in "
    "size, not digit by digit.",
    "**Weights.** λ of Eq. 11, ξ and T_m of Eq. 28, the probabilities p and q, and τ of the fusion rule are not "
    "printed. Costs of Eq. 11 (Figures 6c, 13b, 16b) have a scale of their own. Those of Eq. 28 do not: T_m = 0.5 s, "
    "ξ₂ = 1,000 and ξ₃ = 100 give 5,709.0 for the times of Table 5, where the paper prints 5,709.23; its 9,343.48 of "
    "Figure 16 would follow if one time of Table 8 were a second too long.",
    f"**A copied number.** {paper.FIGURE_16.tour_length:,.2f} is the length of the tour in Section 5.1 and, on another "
    "map with other sensors, again in Section 5.3.",
    f"**Iterations.** Table 4 prints {paper.TABLE_4_ITERATIONS} iterations; by the text the cost still falls in the "
    f"{paper.FIGURE_13.partition_iteration}th (Figure 13f) and the {paper.FIGURE_16.partition_iteration}nd (16f).",
    "**Order of zones.** The text says T₁ > T₂ > T₃, twice; Tables 1 and 8 have the contrary, which the method needs.",
    "**Table 6.** Path 4 of Case 4 is told as one of sub-region 2, whose period is 10 s, and given 20 s, that of "
    "sub-region 3. The text finds Case 6 in Figure 14e, the fifth of six pictures.",
    "**Section 5.2.** Two robots are said to take about 37.50 s in sub-region 3; Table 5 has 36.37 s and 37.29 s.",
    "**References within.** Algorithm 1 updates neighbourhoods by “(5)” and means Eq. 4; Algorithm 3 is titled "
    "“Modified GA to solve TSP” and updates by “(24)” for Eq. 27. Eq. 28 has T_dif, the text below it T_con. The "
    "sensors of segment i lie on (θ_i, θ_i+1] above Eq. 23 and on (θ_i−1, θ_i] elsewhere. Figure 16 names Table 8, a "
    "result, among its parameters.",
    "**Neighbours.** Figure 7 has r_n = 2 r_s; the text asks for r_n ≥ 2 r_v, which is twice that.",
    "**Routes.** How a route is led where an obstacle, the border or its own next lane is in the way is not told, nor "
    "was it checked that the routes see everything.",
    "**Figures 1 to 5, 7 and 9 to 11** explain and have no result; they are not made again.",
)

OURS = (
    "**Rules begin from the best** of the neighbourhood in half of all updates; Algorithm 1 has them begin from where "
    "the particle is. **Sensors are grouped by nearness** to swarms; Li and Yao, whom the paper follows, draw them at "
    "random. **Up to 20 movements** follow a fusion, not one. Each saves some ten sensors, all together about 20; "
    "without them it cannot be told whether the rules save any (second table of Figure 6).",
    "**The first swarm** has half of its sensors deployed, which is why its cost is so much higher than the paper's. "
    "The end does not depend on it. Velocities are shares of the zone's box; S_MAX is shared out among zones by their "
    "cells; cells at borders are clipped.",
    "**Genetic algorithm.** Groups of four are drawn anew every 500 generations, and a reversal draws up to 20 "
    "stretches until one shortens the tour; Algorithm 2 has one population and one draw (effect: last table of Figure "
    "13).",
    "**A\\*** without weights; legs through obstacles are left out of the graph, which is what τ₃ is for; f(M − 1) of "
    "Eq. 16 is read g(M − 1).",
    "**Number of segments.** Each of Algorithm 3's swarms has a number of its own, spread over those that could be "
    "needed. θ stands for the nearest sensor.",
    "**Joining legs.** By Eq. 22 a segment begins at the last sensor of the one before, so that it has the leg that "
    "leads to its own first one. The discs are covered without that leg; but the five routes of Table 5 are 2,128 m "
    "long together, and round a frame of 1,027 m without five of its 96 legs they would hardly be (2 × 974 m + 5 × "
    "31.4 m = 2,105 m before bends save anything). We keep the legs; Figure 14's last table has both readings.",
    f"**ξ₁ = {SegmentSettings().weight_late:g}.** The paper's plans bound it. Table 6 prints 10.95 s for a single "
    "route of zone 1 in five cases; at the 8 s of Section 5.1 that route would be late by 3.45 s, the margin counted, "
    f"and two routes are called cheaper: ξ₁ ≥ 320, and ≥ {paper.LEAST_WEIGHT:g} where the spare 1.42 s goes to the "
    "rest. In Case 6 routes are late by 5.76 s, and a plan without that is called dearer: "
    f"ξ₁ ≤ {paper.MOST_WEIGHT:g} if two routes more would do. "
    "We take a value between; Figure 14's last table has both ends. With 10,000 Case 6 as printed would cost 68,807.",
    "**One frame for all cases.** 10.95 s stands five times in Table 6, 38.22 s and 9.33 s twice, equal to the digit: "
    "the paper seems to have used one frame for all its cases, though zones are deployed in the order of their "
    "periods. We deploy and tour anew for each case.",
    "**The map's lengths.** Our map was drawn to take about as many sensors as the paper's, not to have its lengths: "
    "by Table 6 its frame has some 94 m to 108 m in sub-region 1, 172 m in 2 and 705 m in the rest (Figure 13 has ours "
    "beside them), and zone-1 takes fewer sensors here than the paper's 10.",
    "***parallel*** gives each robot a strip. The paper says that more robots widen the scan, that is fly abreast; "
    "ours is a reading, which takes more robots where periods are short.",
    "**Routes** are the segments widened by r_s and cut to the free ground; ground that they enclose is gone round as "
    "well where it has a quarter of a disc. T^a is the length of that route over V (Eq. 26).",
)

# figures whose tables have a column for each way of planning
COMPARING = (13, 14, 16)
HOW_TO_READ = (
    "*paper*: as printed there.",
    "*Eq. 26*: the paper's algorithms with its parameters, run here with several seeds; T^a is the length of the "
    "closed route over V. *6.1 (5 to 7), 1.5 (1 to 3) late*: mean and range over the seeds.",
    "*as printed*: these routes driven as they are.",
    "*mended*: the same algorithms with the same tables, but that routes are led to what they leave unseen and the "
    "frame is cut anew until the check passes (in mission files `sun2019: {deployment: ccpso2, tour: genetic, "
    "partition: pso, routes: repaired, sensors: {sensors_max: 160}}`).",
    "*sequential*, *parallel*, *decomposition*: the traditional methods of Section 4.1, which group zones of like "
    "periods and are mended as well; both are ours. In *parallel* each robot has a strip.",
    "*sun2019*: that method as it is by default: the paper's stages, each done by another algorithm, all ours (greedy "
    "set cover, local search, exact partition, routes shortened). None of the paper's three optimisers is in it.",
    "*tours*: the method that Rota plans with by default.",
    "*lower bound*: no plan has fewer robots, proved.",
    "A route belongs to the sub-region whose period it must keep. *7.00 / 2*: a loop of 7.00 s that two robots share. "
    "A loop may also be longer than T^c where it passes the zone several times a round; the worst gap decides.",
)


def page_markdown(sections: Sequence[Section], *, seed: int, settings: StudySettings) -> str:
    """The page; its pictures are beside it. seed, settings: with which it was made."""
    figures = joined([str(section.figure) for section in sections])
    comparing = []
    if any(section.figure in COMPARING for section in sections):
        comparing = ["## How to read the tables", listed(HOW_TO_READ)]
    parts = [
        HEADING,
        f"{'Figure' if len(sections) == 1 else 'Figures'} {figures} of {paper.CITATION}, made again by `rota study "
        f"sun2019` with seeds {seed} to {seed + settings.seeds - 1} and effort {settings.effort}; pictures, and plans "
        f"of methods, have seed {seed}. Each figure has the paper's numbers beside those of its own algorithms, as "
        "printed and mended, and of other methods. The lower bound is a number of robots below which no plan exists, "
        "proved. Every plan of ours was judged by `rota check`, which knows nothing of the planners.",
        made_from("sun2019"),
        *claims(sections),
        "## What cannot be reproduced",
        listed(NOT_REPRODUCED),
        "## Readings and additions of ours",
        "What the paper leaves open had to be filled in, and some of its rules did little as they are printed. Every "
        "value of Tables 2 to 4 and of the weights, probabilities and thresholds is a [setting of missions and "
        "sweeps](methods.md#settings-of-its-stages).",
        listed(OURS),
        *comparing,
        *(section.markdown for section in sections),
    ]
    return "\n\n".join(parts) + "\n"
