"""Twists that keep clear of obstacles and of other robots."""
