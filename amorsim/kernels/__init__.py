"""Compiled functions on numbers and arrays, nothing else: the bottom layer."""

COMPILING = "compiling the kernels, once after installing (about a minute) ..."
"""What whoever has to wait for them is told; here, for all who tell it, and without importing what compiles."""
