"""Kernels that draw maps from scans."""
