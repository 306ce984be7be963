"""Readers of other programs' files that hold robots too, or maps with more in them than walls."""
