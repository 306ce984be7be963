"""The commands that simulate many times."""
