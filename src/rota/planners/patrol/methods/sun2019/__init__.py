"""The method of Sun et al. 2019, stage by stage: sensors deployed, a frame through them, routes cut from the frame."""
