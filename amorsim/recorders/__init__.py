"""Recorders: components that write a run to files while it goes on."""
