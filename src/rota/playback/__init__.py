"""A plan as what a player on a map needs: one file of numbers, and one page that holds it."""
