"""Sun et al., Sensors 19(9):1994, 2019, figure by figure: the paper's numbers beside ours."""

from rota_studies.sun2019.maps import figure_8, figure_13, figure_15, with_periods

__all__ = ["figure_8", "figure_13", "figure_15", "with_periods"]
