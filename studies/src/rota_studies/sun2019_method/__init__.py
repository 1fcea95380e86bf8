"""The algorithms that Sun et al. 2019 print for the stages of the method sun2019; missions name them."""
