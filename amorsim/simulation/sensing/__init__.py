"""Mounted sensors over rows: their timing and their noise chains."""
