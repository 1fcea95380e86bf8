"""``python -m rota``: the ``rota`` program where it is not on the path."""

from rota.command.cli import main

main()
