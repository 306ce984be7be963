"""The first hits of rays and cones: cells, walls and bodies."""
