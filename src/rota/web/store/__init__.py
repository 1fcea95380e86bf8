"""What the page keeps: missions, files, plans and jobs in one SQLite database."""
