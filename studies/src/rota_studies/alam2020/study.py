"""The whole study: its figures, how each is made, and about how much of the work it is."""

from __future__ import annotations

from rota_studies.alam2020.coverage_figures import (
    figure_6_section,
    figure_7_section,
    figure_8_section,
    figure_9_section,
)
from rota_studies.alam2020.error_figure import figure_12_section
from rota_studies.alam2020.monitoring_figures import figure_10_section, figure_11_section
from rota_studies.alam2020.page import page_markdown
from rota_studies.alam2020.plane_figure import figure_13_section
from rota_studies.alam2020.runs import Runs, StudySettings
from rota_studies.study import PaperStudy

alam2020_study = PaperStudy(
    name="alam2020",
    figures={
        6: (figure_6_section, 3),
        7: (figure_7_section, 3),
        8: (figure_8_section, 3),
        9: (figure_9_section, 3),
        10: (figure_10_section, 10),
        11: (figure_11_section, 10),
        12: (figure_12_section, 15),
        13: (figure_13_section, 10),
    },
    settings=StudySettings,
    runs=Runs,
    page=lambda sections, seed, _: page_markdown(sections, seed=seed),
)
"""The figures of Alam & Bobadilla 2020, and two (12 and 13, extra) for what its conclusion asks for."""
