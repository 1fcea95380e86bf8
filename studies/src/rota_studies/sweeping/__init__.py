"""Traditional methods of Sun et al. 2019, Figure 3, to compare with: strips side by side, and sub-areas."""
