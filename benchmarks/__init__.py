"""What planning and checking cost from the shell: ``python -m benchmarks [name ...]`` prints the table."""
