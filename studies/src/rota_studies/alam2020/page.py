"""The study as one Markdown page: what it is, what the paper leaves open, and a section for each figure."""

from __future__ import annotations

from collections.abc import Sequence

from rota_studies.alam2020 import maps, paper
from rota_studies.alam2020.claims import standing_verdicts
from rota_studies.page import claims, listed, made_from
from rota_studies.section import Section
from rota_studies.tables import joined

HEADING = "# Alam & Bobadilla 2020, figure by figure"

METHODS = (
    "*as printed*: the paper's Algorithm 1 for coverage and Algorithm 2 for monitoring (`method: as_printed`), by the "
    "readings below.",
    "*improved*: Rota's own (`method: improved`, the default). To cover, robots turn by the clock whenever that enters "
    "more new cells for a step; to monitor, groups are products of single robots' limit cycles, which needs no joint "
    "map and finds all of them, so that zones' periods can be asked for.",
    "A *step* moves every robot by one cell or turns it on the spot; a *contact* turns both robots, like a bump.",
)

LEFT_OPEN = (
    "**Maps.** No layout of Figures 6 to 11 is published, neither are the regions nor the starts: ours are of the same "
    "size and kind, typed in `rota_studies.alam2020.maps`. No number of ours can therefore be expected to equal the "
    "paper's.",
    "**Numbers.** Steps are plotted (Figures 7b and 8b), not printed; where the page has “not printed”, the paper's "
    "statement stands beside ours.",
    "**Loops.** The conditions of both algorithms' inner loops are inverted: they must go on while a cell is "
    "unprocessed.",
    "**Corners.** A diagonal move is blocked when a cell beside it is; the paper's robots are discs.",
    "**Contacts** on the published grid: two robots with one target cell, or moves with one middle. In the "
    "laboratories robots are wider than their cells, so there the distance of bodies on their way counts.",
    "**Neighbours** of Algorithm 1: one robot turned by one heading either way. Of these the best covers most cells, "
    "then has fewest contacts, then is shortest. A turn by the clock takes a step.",
    "**Periodic groups.** Whether a group is a cycle without contact or a whole trajectory without contact from its "
    "start, and whether robots are told apart, is not told. As printed, what is kept depends on the order in which "
    "cells are taken.",
    "**SAMEREGION**(F, x) of Algorithm 2 is read as: each target region is entered by some robot on the trajectory. As "
    "printed the way into the cycle counts, too, so a group may be kept whose cycle misses a region. Another reading, "
    "a region of its own for each robot, is possible.",
    "**When coverage is tested.** Algorithm 1, line 13, tests after an iteration; here every step is looked at, and a "
    "run ends with the step that enters the last cell.",
    "**Speed.** Robots are said to keep one speed; on a grid a diagonal move is √2 as long as a straight one. A step "
    "lasts as long as the robot that needs longest, turns as long as a diagonal move. Straight ways of robots in step "
    "with slower ones are driven slower.",
    "**Clocks.** The paper's robots know the time, and nothing is said of clocks that differ. Here they may differ by "
    "the margin that each plan's check tells.",
    "**Figures 1 to 5** are drawings of ideas; 6a, 6d-f, 11a and 11d-f are photographs. They are not made again.",
)


def page_markdown(sections: Sequence[Section], *, seed: int) -> str:
    """The page; its pictures are beside it. seed: with which it was made."""
    figures = [str(section.figure) for section in sections if not section.extra]
    extras = [section.heading for section in sections if section.extra]
    told = f"{'Figure' if len(figures) == 1 else 'Figures'} {joined(figures)}" if figures else "What is left open by"
    parts = [
        HEADING,
        f"{told} {'of ' if figures else ''}{paper.CITATION}, made again by `rota study alam2020` with seed {seed}: "
        "robots with nothing but a bump sensor and a clock drive straight, turn by a fixed angle where they bump, and "
        "cover a room or watch regions of it. "
        + (f"Beyond the paper, whose conclusion asks for it: {joined(extras)}. " if extras else "")
        + "Random starts are seeds one after another; numbers with ± are means and standard deviations over them.",
        made_from("alam2020"),
        *claims(sections, standing_verdicts(maps.lab(maps.LAB_2, 2, paper.GROUPS[11][0]))),
        "## The methods",
        listed(METHODS),
        "## What the paper leaves open, and how we read it",
        listed(LEFT_OPEN),
        *(section.markdown for section in sections),
    ]
    return "\n\n".join(parts) + "\n"
