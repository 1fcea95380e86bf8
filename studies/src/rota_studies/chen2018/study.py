"""The whole study: its figures, how each is made, and about how much of the work it is."""

from __future__ import annotations

from rota_studies.chen2018.claims import figure_24_section
from rota_studies.chen2018.compared_figures import (
    figure_17_section,
    figure_18_section,
    figure_19_section,
)
from rota_studies.chen2018.gazebo_figure import figure_23_section
from rota_studies.chen2018.large_figure import figure_21_section
from rota_studies.chen2018.page import page_markdown
from rota_studies.chen2018.processes_figure import figure_22_section
from rota_studies.chen2018.runs import Runs, StudySettings
from rota_studies.chen2018.sampling_figures import figure_9_section, figure_11_section
from rota_studies.chen2018.scale_figure import figure_20_section
from rota_studies.chen2018.small_figures import (
    figure_12_section,
    figure_13_section,
    figure_14_section,
    figure_15_section,
    figure_16_section,
)
from rota_studies.study import PaperStudy

chen2018_study = PaperStudy(
    name="chen2018",
    figures={
        9: (figure_9_section, 4),
        11: (figure_11_section, 3),
        12: (figure_12_section, 40),
        13: (figure_13_section, 10),
        14: (figure_14_section, 25),
        15: (figure_15_section, 1),
        16: (figure_16_section, 1),
        17: (figure_17_section, 10),
        18: (figure_18_section, 60),
        19: (figure_19_section, 1),
        20: (figure_20_section, 80),
        21: (figure_21_section, 250),
        22: (figure_22_section, 150),
        23: (figure_23_section, 15),
        24: (figure_24_section, 60),
    },
    settings=StudySettings,
    runs=Runs,
    page=lambda sections, seed, _: page_markdown(sections, seed=seed),
)
"""The figures and tables of Chen et al. 2018. Times of Table 3 and runs of Figure 22 differ with the same seed."""
