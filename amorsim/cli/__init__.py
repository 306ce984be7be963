"""The command line: ``amorsim run``, ``check``, ``plot`` and the rest."""

from amorsim.cli.app import main

__all__ = ["main"]
