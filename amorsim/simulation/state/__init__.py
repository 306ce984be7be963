"""The state of a simulation: read, restored, begun again, changed."""
