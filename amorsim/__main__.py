"""``python -m amorsim`` is the command line."""

from amorsim.cli import main

main()
