"""Runs: the folder of a simulation, its files, and reproducing it."""
