"""Footprints of bodies, their clearances, and when they meet on their paths."""
