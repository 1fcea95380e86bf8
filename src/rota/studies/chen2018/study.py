"""The whole study: the figures that are asked for, made from one set of runs."""

from __future__ import annotations

from collections.abc import Callable

from rota.studies.chen2018.compared_figures import (
    figure_17_section,
    figure_18_section,
    figure_19_section,
    figure_20_section,
)
from rota.studies.chen2018.large_figure import figure_21_section
from rota.studies.chen2018.page import page_markdown
from rota.studies.chen2018.runs import Runs, StudySettings
from rota.studies.chen2018.sampling_figures import figure_9_section, figure_11_section
from rota.studies.chen2018.small_figures import (
    figure_12_section,
    figure_13_section,
    figure_14_section,
    figure_15_section,
    figure_16_section,
)
from rota.studies.study import Makers, Study, made_sections

PAGE, PICTURES = "chen2018.md", "chen2018-figure-*.png"
FIGURES: Makers[Runs] = {
    9: (figure_9_section, 4),
    11: (figure_11_section, 3),
    12: (figure_12_section, 40),
    13: (figure_13_section, 10),
    14: (figure_14_section, 25),
    15: (figure_15_section, 1),
    16: (figure_16_section, 1),
    17: (figure_17_section, 10),
    18: (figure_18_section, 1),
    19: (figure_19_section, 1),
    20: (figure_20_section, 80),
    21: (figure_21_section, 180),
}


def chen2018_study(
    figures: tuple[int, ...] = tuple(FIGURES),
    *,
    settings: StudySettings | None = None,
    seed: int = 0,
    progress: Callable[[float, str], None] | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> Study:
    """Make the figures and tables of Chen et al. 2018 again: what the paper says beside ours.

    figures: numbers out of ``FIGURES``. settings: how much is run; None for the page in docs. seed: the same seed gives
    the same study, but for the times of Table 3, which are measured. progress: called with a fraction 0..1 and what is
    being done. should_stop: asked in every step; raises StudyStopped when it says so, since a study of half the runs is
    none.
    """
    asked = settings or StudySettings()
    stop = should_stop or (lambda: False)
    sections = made_sections(
        FIGURES, figures, lambda tell: Runs(asked, seed=seed, tell=tell, should_stop=stop), progress
    )
    return Study(sections=sections, page_file=PAGE, page=page_markdown(sections, seed=seed))
