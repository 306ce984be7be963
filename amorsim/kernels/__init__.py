"""Compiled functions on numbers and arrays, nothing else: the bottom layer."""

COMPILING = "compiling the kernels, once after installing (a minute or two) ..."
"""The message for users who wait for the compiler; it is here so that showing it imports no kernel."""
