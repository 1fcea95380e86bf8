"""Robots that charge take over: timetables of flights for those that remain, and how each comes into one."""
