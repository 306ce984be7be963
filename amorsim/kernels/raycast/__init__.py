"""What rays and cones meet first: cells, walls and bodies."""
