"""Kernels that find how scans fit on one another."""
