"""Plans as formats drive them: what was written for each robot is read again, and makes its trajectory."""
