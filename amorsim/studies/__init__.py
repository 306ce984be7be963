"""Experiments on a robot: the square of UMBmark, calibrations, and which error did what."""
