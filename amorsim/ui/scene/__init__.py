"""Scenes: what a window draws of a scenario, simulated or only read."""
