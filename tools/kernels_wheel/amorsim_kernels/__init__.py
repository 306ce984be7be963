"""Compiled kernels of amorsim, for one version of it, of numba and of Python, and for processors of x86-64-v3."""
