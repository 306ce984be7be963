"""Poses, errors, random draws, the clock, maps and the world: what every component stands on."""
