"""Robots that ship: TOML files, for a robot is data."""
