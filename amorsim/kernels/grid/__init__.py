"""Occupied cells: the grid, how it is made, and the segments and walls that it was made of."""
