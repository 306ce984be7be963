"""Scenarios, as Python objects and as files."""
