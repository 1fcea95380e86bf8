"""What is asked and from where it can be seen: samples, places to look from, the limits of sight."""
