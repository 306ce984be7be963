"""Poses, errors, random draws, the clock, maps and shapes: the base of every component."""
