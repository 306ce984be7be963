"""The map, and what is computed from its cells."""
