"""Draws that are a pure function of a key and a counter."""
