"""Choosing twists that keep clear of what was seen, and of others."""
