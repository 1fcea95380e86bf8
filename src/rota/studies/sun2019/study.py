"""The whole study: the figures that are asked for, made from one set of runs."""

from __future__ import annotations

from collections.abc import Callable

from rota.studies.study import Makers, Study, made_sections
from rota.studies.sun2019.page import page_markdown
from rota.studies.sun2019.result_figures import figure_13_section, figure_14_section, figure_16_section
from rota.studies.sun2019.runs import Runs, StudySettings
from rota.studies.sun2019.stage_figures import (
    figure_6_section,
    figure_8_section,
    figure_12_section,
    figure_15_section,
)

PAGE, PICTURES = "sun2019.md", "figure-*.png"
FIGURES: Makers[Runs] = {
    6: (figure_6_section, 8),
    8: (figure_8_section, 6),
    12: (figure_12_section, 6),
    13: (figure_13_section, 20),
    14: (figure_14_section, 150),
    15: (figure_15_section, 1),
    16: (figure_16_section, 30),
}


def sun2019_study(
    figures: tuple[int, ...] = tuple(FIGURES),
    *,
    settings: StudySettings | None = None,
    seed: int = 0,
    progress: Callable[[float, str], None] | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> Study:
    """Make the figures and tables of Sun et al. 2019 again: the paper's numbers beside ours.

    figures: numbers out of ``FIGURES``. settings: None for the tables of the paper. seed: the same seed gives the same
    study. progress: called with a fraction 0..1 and what is being done. should_stop: asked before every run and within
    searches; raises StudyStopped when it says so, since a study of half the runs is none.
    """
    asked = settings or StudySettings()
    stop = should_stop or (lambda: False)
    sections = made_sections(
        FIGURES, figures, lambda tell: Runs(asked, seed=seed, tell=tell, should_stop=stop), progress
    )
    return Study(sections=sections, page_file=PAGE, page=page_markdown(sections, seed=seed, effort=asked.effort))
