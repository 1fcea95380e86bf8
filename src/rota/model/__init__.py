"""What is asked and what is answered: missions, fleets, plans and their limits, as frozen types."""
