"""The command line: ``amorsim run``, ``check``, ``plot`` and the rest."""

from amorsim.cli.start import main

__all__ = ["main"]
