"""An iRobot Create 2 on the desk: its sketch in simavr, its body in a model of the mission's map."""
