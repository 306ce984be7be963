"""Scenes: what a window draws of a scenario that is simulated, or that can only be read."""
