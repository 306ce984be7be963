"""Sensors with the figures of real devices, as files."""
