"""Mounted sensors over rows: when they read, and through what chain of noise."""
