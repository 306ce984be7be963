"""Scenes and frames: a moment as numbers to be drawn, and as bytes for the window."""
