"""Compiled functions on numbers and arrays, nothing else: the bottom layer."""
