"""The whole study: the figures that are asked for, made from one set of runs."""

from __future__ import annotations

from collections.abc import Callable

from rota.studies.alam2020.coverage_figures import (
    figure_6_section,
    figure_7_section,
    figure_8_section,
    figure_9_section,
)
from rota.studies.alam2020.error_figure import figure_12_section
from rota.studies.alam2020.monitoring_figures import figure_10_section, figure_11_section
from rota.studies.alam2020.page import page_markdown
from rota.studies.alam2020.plane_figure import figure_13_section
from rota.studies.alam2020.runs import Runs, StudySettings
from rota.studies.study import Makers, Study, made_sections

PAGE, PICTURES = "alam2020.md", "alam2020-figure-*.png"
FIGURES: Makers[Runs] = {
    6: (figure_6_section, 3),
    7: (figure_7_section, 3),
    8: (figure_8_section, 3),
    9: (figure_9_section, 3),
    10: (figure_10_section, 10),
    11: (figure_11_section, 10),
    12: (figure_12_section, 15),
    13: (figure_13_section, 10),
}


def alam2020_study(
    figures: tuple[int, ...] = tuple(FIGURES),
    *,
    settings: StudySettings | None = None,
    seed: int = 0,
    progress: Callable[[float, str], None] | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> Study:
    """Make the figures of Alam & Bobadilla 2020 again, and two for what its conclusion asks for.

    figures: numbers out of ``FIGURES``; 12 and 13 are extra. settings: how much is run; None for the page in docs.
    seed: the same seed gives the same study. progress: called with a fraction 0..1 and what is being done. should_stop:
    asked before every run; raises StudyStopped when it says so, since a study of half the runs is none.
    """
    asked = settings or StudySettings()
    stop = should_stop or (lambda: False)
    sections = made_sections(
        FIGURES, figures, lambda tell: Runs(asked, seed=seed, tell=tell, should_stop=stop), progress
    )
    return Study(sections=sections, page_file=PAGE, page=page_markdown(sections, seed=seed))
