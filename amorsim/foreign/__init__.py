"""Readers of other programs' files that hold robots, or maps with more than walls."""
