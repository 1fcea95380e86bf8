"""Studies: what can be learnt by running the planners and looking at how they do, as tables and pictures."""
