"""The commands that make a run, or read one."""
