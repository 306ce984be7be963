"""The Simulator within a notebook: a live widget for a simulation of the kernel."""
