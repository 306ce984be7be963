"""Recorders: what writes a run down while it goes."""
