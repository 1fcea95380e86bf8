"""The whole study: its figures, how each is made, and about how much of the work it is."""

from __future__ import annotations

from rota_studies.study import PaperStudy
from rota_studies.sun2019.figure_14 import figure_14_section
from rota_studies.sun2019.page import page_markdown
from rota_studies.sun2019.result_figures import figure_13_section, figure_16_section
from rota_studies.sun2019.runs import Runs, StudySettings
from rota_studies.sun2019.stage_figures import (
    figure_6_section,
    figure_8_section,
    figure_12_section,
    figure_15_section,
)

sun2019_study = PaperStudy(
    name="sun2019",
    figures={
        6: (figure_6_section, 80),
        8: (figure_8_section, 10),
        12: (figure_12_section, 10),
        13: (figure_13_section, 200),
        14: (figure_14_section, 500),
        15: (figure_15_section, 1),
        16: (figure_16_section, 80),
    },
    settings=StudySettings,
    runs=Runs,
    page=lambda sections, seed, settings: page_markdown(sections, seed=seed, settings=settings),
)
"""The figures and tables of Sun et al. 2019."""
