"""Experiments on a robot: the square of UMBmark, calibrations, and the effect of each error."""
