"""The robots and obstacles of a simulation, in groups of those alike."""
